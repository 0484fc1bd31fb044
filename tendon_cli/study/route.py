"""The route of a sheath, digitised as way-points, and the total curvature that the model needs of it."""

from __future__ import annotations

import csv
import math
import re

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.sheath import RouteCurvature, total_curvature
from tendon_cli.units import UNITS, shorten

MAX_BYTES = 16_000_000
NOISE_TO_WARN_OF = 0.1
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


def measure_route(content: bytes, where: str, smoothing: float) -> tuple[RouteCurvature, list[str]]:
    """Total curvature of a route file, and what to be wary of."""
    route = read_route(content, where)
    try:
        raw = total_curvature(route)
        if smoothing > 0.0:
            return total_curvature(smooth(route, smoothing)), []
    except ValueError as error:
        raise InputError(str(error), where=where) from None
    warnings = []
    if raw.noise_share > NOISE_TO_WARN_OF:
        warnings.append(
            f"{where}: {raw.noise_share:.0%} of the curvature is gone when every second way-point is left out, so "
            "noise dominates; give the digitisation noise as path_smoothing"
        )
    elif raw.largest_turn > TURN_TO_WARN_OF:
        warnings.append(
            f"{where}: the route turns by {math.degrees(raw.largest_turn):.0f} deg at one way-point; more way-points "
            "along the bends make its curvature more certain"
        )
    return raw, warnings


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
