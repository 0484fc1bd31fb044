"""The route of a sheath, digitised as way-points, and the total curvature that the model needs of it."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.route import MeasuredRoute, measured_route
from tendon_cli.units import UNITS, shorten

MAX_BYTES = 16_000_000
MAX_BEND = 100.0
"""Largest bend angle of a sheath, rad."""
NOISE_TO_WARN_OF, ERROR_TO_WARN_OF = 0.1, 0.1  # shares of the bend
NOISE_APART = 1.5
TURN_TO_WARN_OF = 0.5
_HEADER = re.compile(r"\s*(?P<axis>[xyz])\s*[\[(_ ]?\s*(?P<unit>m|cm|mm|um|km|in)?\s*[\])]?\s*", re.IGNORECASE)


def read_route(content: bytes, where: str) -> npt.NDArray[np.float64]:
    """Way-points in m, shape (n, 3), from CSV with the columns x, y and z.

    A unit may stand in the header (`x_mm`, `x [mm]`), else it is m. Separated by comma, semicolon or tab; lines that
    start with # are comments. Raises InputError with the line at fault.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("not UTF-8 text", where=where, hint="save the route as CSV in UTF-8") from None
    numbered = [(at, line) for at, line in enumerate(text.splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"]
    if not numbered:
        raise InputError("holds no way-points, expected a header x, y, z and a line for each", where=where)
    separator = next((sign for sign in ";\t" if sign in numbered[0][1]), ",")
    columns, scales = _columns(_split(numbered[0][1], separator), where)
    rows = [_row(line, separator, columns, scales, f"{where}, line {at}") for at, line in numbered[1:]]
    if len({tuple(row) for row in rows}) < 2:
        raise InputError("holds fewer than two different way-points, expected two at least", where=where)
    return np.array(rows)


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
        found = measured_route(read_route(content, where), smoothing or None)
    except ValueError as error:
        raise InputError(str(error), where=where) from None
    if found.bend_angle > MAX_BEND:
        problem = f"bends by {found.bend_angle:.4g} rad, expected {MAX_BEND:g} at most"
        raise InputError(problem, where=where, hint="one way-point after the other, along the sheath")
    return found, [f"{where}: {warning}" for warning in _warnings(found, smoothing)]


def route_note(found: MeasuredRoute, where: str) -> str:
    """The bend angle that was taken, as `--bend-angle` of `fit-friction` takes it, and the one as it stands."""
    bend, error, raw = (math.degrees(a) for a in (found.bend_angle, found.standard_error, found.as_it_stands))
    noise = "" if found.noise is None else f", its way-points scatter by {1e3 * found.noise:.2g} mm"
    return f"{where} bends by {bend:.2f} deg +/- {error:.2g} deg; {raw:.2f} deg as it stands{noise}"


def _warnings(found: MeasuredRoute, smoothing: float) -> Iterator[str]:
    """What may be wrong with a measured route; smoothing takes nothing of it away."""
    bend, noise = math.degrees(found.bend_angle), found.noise
    if smoothing and noise is not None and not smoothing / NOISE_APART < noise < smoothing * NOISE_APART:
        said = f"not by the {1e3 * smoothing:.2g} mm that path_smoothing says"
        yield f"the way-points scatter by {1e3 * noise:.2g} mm, {said}; the larger of both was used"
    if not smoothing and found.as_it_stands - found.bend_angle > NOISE_TO_WARN_OF * found.as_it_stands:
        yield (
            f"noise of about {1e3 * (noise or 0.0):.2g} mm makes the way-points turn by "
            f"{math.degrees(found.as_it_stands):.0f} deg, of which {bend:.0f} deg were taken for the route's; give the "
            "digitisation noise as path_smoothing to confirm it"
        )
    if found.largest_turn > TURN_TO_WARN_OF:
        yield (
            f"the route turns by {math.degrees(found.largest_turn):.0f} deg at one way-point; more way-points along "
            "the bends make its curvature more certain"
        )
    if 2.0 * found.standard_error > max(ERROR_TO_WARN_OF * found.bend_angle, math.radians(5.0)):
        yield f"its bend angle, {bend:.4g} deg, has a standard error of {math.degrees(found.standard_error):.2g} deg"


def _split(line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error as error:
        return [str(error)]


def _columns(header: list[str], where: str) -> tuple[list[int], list[float]]:
    """Positions and units of x, y and z in the header."""
    found: dict[str, tuple[int, float]] = {}
    for at, name in enumerate(header):
        match = _HEADER.fullmatch(name)
        if match:
            unit = UNITS[(match["unit"] or "m").lower()]
            found.setdefault(match["axis"].lower(), (at, float(unit.factor)))
    missing = [axis for axis in "xyz" if axis not in found]
    if missing:
        names = shorten(", ".join(header))
        raise InputError(f"no column {missing[0]}, the header reads: {names}", where=where, hint="columns: x, y, z")
    return [found[axis][0] for axis in "xyz"], [found[axis][1] for axis in "xyz"]


def _row(line: str, separator: str, columns: list[int], scales: list[float], where: str) -> list[float]:
    numbers, cells = [], _split(line, separator)
    for axis, column, scale in zip("xyz", columns, scales, strict=True):
        cell = cells[column] if column < len(cells) else ""
        hint = f"the line reads: {shorten(line.strip())}"
        try:
            number = float(cell)
        except ValueError:
            hint += ", where the decimal sign is to be a point" if "," in cell else ""
            raise InputError(f'{axis} is "{shorten(cell)}", expected a number', where=where, hint=hint) from None
        if not math.isfinite(number) or abs(number) > 1e6:
            raise InputError(f"{axis} is {number}, expected a finite length", where=where, hint=hint)
        numbers.append(number * scale)
    return numbers
