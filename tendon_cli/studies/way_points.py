"""Route of a sheath, digitised as way-points, and the total curvature that the model needs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.route import MeasuredRoute, measured_route
from tendon_cli.readers.heading import Heading, columns_named
from tendon_cli.readers.table import read_table
from tendon_cli.studies.magnitude import Slip, column_slips

MAX_BYTES = 16_000_000
"""Largest size of a file of way-points, bytes."""
MAX_BEND = 100.0
"""Largest bend angle of a sheath, rad."""
NOISE_TO_WARN_OF = 0.1
"""Share of the plain sum of turns that noise may make without a warning."""
ERROR_TO_WARN_OF = 0.1
"""Largest ratio of twice the standard error to the bend angle without a warning."""
_LEAST_ERROR_TO_WARN_OF = math.radians(5.0)
"""Twice the standard error, rad, that is never warned of, however small the bend angle."""
NOISE_APART = 1.5
"""Largest factor between estimated and stated noise without a warning."""
TURN_TO_WARN_OF = 0.5
"""Largest turn at one way-point without a warning, rad."""


@dataclass(frozen=True, eq=False)
class Route:
    """Way-points of a sheath, as a file has them."""

    points: npt.NDArray[np.float64]
    """Way-points, (n, 3), m."""
    unit: str
    """Symbol of the unit of x."""
    notes: list[str]
    """Note that names the columns that are not read, if there are any."""

    def slips(self, where: str) -> tuple[Slip, ...]:
        """Return the slip of the length of the route, if it is far from that of any sheath.

        A bend angle is the same in every unit, so that it would not tell.
        """
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        length = np.array([steps.sum()])
        return column_slips("tendon_length", length, self.unit, "a route", [where])


def read_route(content: bytes, where: str) -> Route:
    """Return way-points from the content of a file with the columns x, y and z.

    Columns whose header has no unit are in m.
    """

    def known(columns: Sequence[Heading]) -> list[Heading]:
        """Return the coordinates of a line that names two or more."""
        found = columns_named(columns, "xyz")
        return found if len(found) > 1 else []

    table = read_table(content, known, source=where, noun="way-point")
    points = []
    unit = ""
    read = []
    for axis in "xyz":
        column = table.need(axis, hint=f"such as {axis} (m)")
        if column is not None:
            read.append(column)
            values, symbol = table.quantity(column, "length", unit="m")
            unit = unit or symbol
            points.append(values)
    table.raise_faults()
    if len(np.unique(points, axis=1).T) < 2:
        problem = "holds fewer than two different way-points, expected two at least"
        raise InputError(problem, where=where)
    return Route(np.array(points).T, unit, [*table.unread(read), *table.notes])


def smooth(route: npt.NDArray[np.float64], noise: float) -> npt.NDArray[np.float64]:
    """Return a smooth route that passes the way-points within their digitisation noise.

    The smoothing spline leaves residuals of the size expected of the noise and no more; it is
    sampled finely.

    Args:
        route: Way-points, (n, 3), m.
        noise: Standard deviation of each coordinate, m.
    """
    from scipy.interpolate import make_splprep  # only digitised routes pay for its import

    steps = np.linalg.norm(np.diff(route, axis=0), axis=1)
    route = route[np.append(True, steps > 0.0)]
    if noise <= 0.0 or len(route) < 5:
        return route
    spline, _ = make_splprep(route.T, s=noise**2 * route.size)
    return np.asarray(spline(np.linspace(0.0, 1.0, 20 * len(route)))).T


def measure_route(route: Route, where: str, smoothing: float) -> tuple[MeasuredRoute, list[str]]:
    """Measure the bend angle of a route, and return it with warnings.

    Args:
        route: The way-points.
        where: Name of the file in errors.
        smoothing: Noise that the study states, m; 0 if it states none.

    Raises:
        InputError: The route bends more than a sheath can, or cannot be measured.
    """
    try:
        measured = measured_route(route.points, smoothing or None)
    except ValueError as error:
        raise InputError(str(error), where=where) from None
    if measured.bend_angle > MAX_BEND:
        problem = f"bends by {measured.bend_angle:.4g} rad, expected {MAX_BEND:g} at most"
        raise InputError(problem, where=where)
    warnings = [f"{where}: {warning}" for warning in _warnings(measured, smoothing)]
    return measured, [*route.notes, *warnings]


def route_note(measured: MeasuredRoute, where: str) -> str:
    """Return a note on a route: its bend angle, as `--bend-angle` of `fit-friction` takes it."""
    bend = math.degrees(measured.bend_angle)
    error = math.degrees(measured.standard_error)
    raw = math.degrees(measured.sum_of_turns)
    note = f"{where} bends by {bend:.2f} deg +/- {error:.2g} deg; {raw:.2f} deg as it stands"
    if measured.noise is not None:
        note += f", its way-points scatter by {1e3 * measured.noise:.2g} mm"
    return note


def _warnings(measured: MeasuredRoute, smoothing: float) -> Iterator[str]:
    """Yield warnings on a measured route.

    A stated smoothing confirms the noise, so that its share of the turns is no warning.

    Args:
        measured: The route.
        smoothing: Noise that the study states, m; 0 if it states none.
    """
    bend = math.degrees(measured.bend_angle)
    noise = measured.noise
    if smoothing and noise is not None:
        agrees = smoothing / NOISE_APART < noise < smoothing * NOISE_APART
        if not agrees:
            yield (
                f"the way-points scatter by {1e3 * noise:.2g} mm, not by the "
                f"{1e3 * smoothing:.2g} mm that path_smoothing says; the larger of both was used"
            )
    by_noise = measured.sum_of_turns - measured.bend_angle
    if not smoothing and by_noise > NOISE_TO_WARN_OF * measured.sum_of_turns:
        yield (
            f"noise of about {1e3 * (noise or 0.0):.2g} mm makes the way-points turn by "
            f"{math.degrees(measured.sum_of_turns):.0f} deg, of which {bend:.0f} deg count as the "
            "route's; give the digitisation noise as path_smoothing to confirm it"
        )
    if measured.largest_turn > TURN_TO_WARN_OF:
        yield (
            f"the route turns by {math.degrees(measured.largest_turn):.0f} deg at one way-point; "
            "more way-points along the bends make its curvature more certain"
        )
    largest_error = max(ERROR_TO_WARN_OF * measured.bend_angle, _LEAST_ERROR_TO_WARN_OF)
    if 2.0 * measured.standard_error > largest_error:
        error = math.degrees(measured.standard_error)
        yield f"its bend angle, {bend:.4g} deg, has a standard error of {error:.2g} deg"
