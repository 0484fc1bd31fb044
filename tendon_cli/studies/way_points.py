"""The route of a sheath, digitised as way-points, and the total curvature that the model needs of it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.route import MeasuredRoute, measured_route
from tendon_cli.studies.csv_columns import read_columns

MAX_BYTES = 16_000_000
MAX_BEND = 100.0
"""Largest bend angle of a sheath, rad."""
NOISE_TO_WARN_OF, ERROR_TO_WARN_OF = 0.1, 0.1  # shares of the bend
NOISE_APART = 1.5
TURN_TO_WARN_OF = 0.5


def read_route(content: bytes, where: str) -> npt.NDArray[np.float64]:
    """Way-points in m, shape (n, 3), from CSV as `read_columns` takes it; a header without unit is in m."""
    points = read_columns(content, where, dict.fromkeys("xyz", "length"), "way-point", unit="m")[
        0
    ].T
    if len(np.unique(points, axis=0)) < 2:
        raise InputError(
            "holds fewer than two different way-points, expected two at least", where=where
        )
    return points


def smooth(route: npt.NDArray[np.float64], noise: float) -> npt.NDArray[np.float64]:
    """A smooth route that passes the way-points within their digitisation noise, a standard deviation in m.

    The smoothing spline leaves residuals of the size expected of the noise and no more; it is sampled finely.
    """
    from scipy.interpolate import make_splprep  # only digitised routes pay for its import

    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    route = route[np.append(True, steps > 0.0)]
    if noise <= 0.0 or len(route) < 5:
        return route
    spline, _ = make_splprep(route.T, s=noise**2 * route.size)
    return np.asarray(spline(np.linspace(0.0, 1.0, 20 * len(route)))).T


def measure_route(content: bytes, where: str, smoothing: float) -> tuple[MeasuredRoute, list[str]]:
    """Total curvature of a route file whose noise is stated (0 where it is not), and what to be wary of.

    Raises InputError for a file that is no route, and for one that bends more than a sheath can.
    """
    try:
        measured = measured_route(read_route(content, where), smoothing or None)
    except ValueError as error:
        raise InputError(str(error), where=where) from None
    if measured.bend_angle > MAX_BEND:
        raise InputError(
            f"bends by {measured.bend_angle:.4g} rad, expected {MAX_BEND:g} at most", where=where
        )
    return measured, [f"{where}: {warning}" for warning in _warnings(measured, smoothing)]


def route_note(measured: MeasuredRoute, where: str) -> str:
    """The bend angle that was taken, as `--bend-angle` of `fit-friction` takes it, and the one as it stands."""
    bend, error, raw = (
        math.degrees(a)
        for a in (measured.bend_angle, measured.standard_error, measured.as_it_stands)
    )
    noise = (
        ""
        if measured.noise is None
        else f", its way-points scatter by {1e3 * measured.noise:.2g} mm"
    )
    return f"{where} bends by {bend:.2f} deg +/- {error:.2g} deg; {raw:.2f} deg as it stands{noise}"


def _warnings(measured: MeasuredRoute, smoothing: float) -> Iterator[str]:
    """What may be wrong with a measured route; smoothing takes nothing of it away."""
    bend, noise = math.degrees(measured.bend_angle), measured.noise
    if (
        smoothing
        and noise is not None
        and not smoothing / NOISE_APART < noise < smoothing * NOISE_APART
    ):
        other = f"not by the {1e3 * smoothing:.2g} mm that path_smoothing says"
        yield f"the way-points scatter by {1e3 * noise:.2g} mm, {other}; the larger of both was used"
    if (
        not smoothing
        and measured.as_it_stands - measured.bend_angle > NOISE_TO_WARN_OF * measured.as_it_stands
    ):
        yield (
            f"noise of about {1e3 * (noise or 0.0):.2g} mm makes the way-points turn by "
            f"{math.degrees(measured.as_it_stands):.0f} deg, of which {bend:.0f} deg were taken for the route's; give "
            "the digitisation noise as path_smoothing to confirm it"
        )
    if measured.largest_turn > TURN_TO_WARN_OF:
        yield (
            f"the route turns by {math.degrees(measured.largest_turn):.0f} deg at one way-point; more way-points along "
            "the bends make its curvature more certain"
        )
    if 2.0 * measured.standard_error > max(
        ERROR_TO_WARN_OF * measured.bend_angle, math.radians(5.0)
    ):
        yield f"its bend angle, {bend:.4g} deg, has a standard error of {math.degrees(measured.standard_error):.2g} deg"
