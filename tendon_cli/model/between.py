"""Windows of the whole motion: between the angles at which states were taken, too.

An end of a window is the largest (the smallest) over all angles of what each state asks for. Taken over some angles it
errs on the unsafe side, by the square of their distance. So it is sought around the angle that binds among these, where
it lies between two of them. Arguments broadcast as in `actuator`; SI units, angles in radians.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import Situation
from tendon_cli.model.bounds import Bounds, ends_of
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.motor import taken
from tendon_cli.model.window import Ends, ends_of_states, slack_codes

ANGLES = 91
"""Taken of any motion, whichever a study lists: what lies between them is sought from there."""
_POINTS = 9
_ROUNDS = 4
"""Each has the points four times as dense; then the top of a parabola is exact but for rounding."""
_AHEAD = 1e-3
"""Of a step; whether an end rises from the motion's own end inward is seen there."""


def grid(elbow_angle: Array) -> Array:
    """The angles at which windows over the whole motion are taken, (1, K), from all that a study lists, rad."""
    low, high = float(np.min(elbow_angle)), float(np.max(elbow_angle))
    return np.linspace(low, high, ANGLES if high > low else 1).reshape(1, -1)


def end_curves(
    design: Design, elbow_angle: Array, flexion: Flags, bounds: Bounds
) -> tuple[dict[str, Array], dict[str, Array]]:
    """What each limit on states asks for at each angle, N: the least pretensions, and the largest, by its name.

    Over all designs and directions; infinite where a limit asks for nothing. Angles are (1, K), the results (K,).
    """
    at = Situation.of(design, elbow_angle, flexion)
    required, slack = at.response.required, slack_codes(at)
    curves: tuple[dict[str, Array], dict[str, Array]] = {}, {}
    slack_ends = [(int(code), np.zeros(()), slack >= 0, 1.0 * (slack == code)) for code in np.unique(slack)]
    ends = [*slack_ends, *(each[:4] for each in ends_of(at, bounds))]
    for code, end, is_lower, gain in ends:
        for of_limits, holds, sign in zip(curves, (is_lower, ~is_lower), (1.0, -1.0), strict=True):
            asked = np.where(holds & (gain != 0.0) & ~np.isnan(required), sign * (required + end), -np.inf)
            most = asked.reshape(-1, asked.shape[-1]).max(axis=0)
            if np.any(most > -np.inf):
                name = LIMIT_NAMES[code]
                of_limits[name] = sign * np.maximum(most, sign * of_limits.get(name, -sign * np.inf))
    return curves


def refined(
    ends: Ends, design: Design, elbow_angle: Array, flexion: Flags, bounds: Bounds, chosen: npt.NDArray[np.bool_]
) -> Ends:
    """Ends of windows over `grid` angles, those `chosen` taken over all angles between the first and the last.

    The designs have the shape of the ends, and two axes for states; directions are (D, 1), angles (1, K). A binding
    state stays the one nearest to the angle that binds, which is given beside it.
    """
    for name in ("low", "high"):
        ends = _refined(ends, name, design, elbow_angle.ravel(), flexion, bounds, chosen)
    return ends


def _refined(
    ends: Ends, name: str, design: Design, angles: Array, flexion: Flags, bounds: Bounds, chosen: npt.NDArray[np.bool_]
) -> Ends:
    """The same at one end."""
    state, sign = getattr(ends, f"{name}_state"), 1.0 if name == "low" else -1.0
    at = np.nonzero(chosen & (state >= 0) & np.isfinite(ends.low) & (len(angles) > 1))
    if not at[0].size:
        return ends
    some, place, step = taken(design, (*state.shape, 1, 1), at), state[at] % len(angles), angles[1] - angles[0]

    def asked(where: Array, which: slice | npt.NDArray[np.bool_] = slice(None)) -> Array:
        """What is asked for at angles of each design, (designs, directions, angles); the larger, the tighter."""
        rows = np.arange(len(place))[which]
        few = some if len(rows) == len(place) else taken(some, (len(place), 1, 1), (rows,))
        situation = Situation.of(few, where[:, np.newaxis, :], flexion)
        values = sign * ends_of_states(situation, bounds)[0 if name == "low" else 1]
        shape = (len(where), len(flexion), where.shape[1])
        return np.broadcast_to(np.where(np.isnan(values), -np.inf, values), shape)

    centre, edge = angles[place], (place == 0) | (place == len(angles) - 1)
    inward = centre + np.where(place == 0, _AHEAD, -_AHEAD) * step
    here = asked(np.column_stack([centre, inward])).max(axis=1)
    rises = ~edge | (here[:, 1] > here[:, 0])
    best, direction, angle = here[:, 0].copy(), state[at] // len(angles), centre.copy()

    def take(where: Array, values: Array, ways: npt.NDArray[np.int64]) -> None:
        better = values > best[rises]
        for whole, part in ((best, values), (direction, ways), (angle, where)):
            whole[rises] = np.where(better, part, whole[rises])

    spread, middle = np.linspace(-1.0, 1.0, _POINTS), centre[rises]
    for narrow in range(_ROUNDS if rises.any() else 0):
        where = np.clip(middle[:, np.newaxis] + spread * step * 4.0**-narrow, angles[0], angles[-1])
        values = asked(where, rises)
        flat = values.reshape(len(where), -1)
        rows, most = np.arange(len(where)), flat.argmax(axis=1)
        middle = where[rows, most % _POINTS]
        take(middle, flat[rows, most], most // _POINTS)
    if rises.any():
        apart = 0.25 * step * 4.0 ** (1 - _ROUNDS)
        middle = np.clip(middle, angles[0] + apart, angles[-1] - apart)
        way = direction[rises]
        three = asked(middle[:, np.newaxis] + apart * np.array([-1.0, 0.0, 1.0]), rises)[np.arange(len(way)), way]
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = 0.5 * (three[:, 0] - three[:, 2]) / (three[:, 0] - 2.0 * three[:, 1] + three[:, 2])
        top = middle + apart * np.clip(np.nan_to_num(ahead), -1.0, 1.0)
        take(top, asked(top[:, np.newaxis], rises)[np.arange(len(way)), way, 0], way)
    return _with(ends, name, at, sign * best, direction, angle, angles)


def _with(
    ends: Ends, name: str, at: tuple[npt.NDArray[np.int64], ...], value: Array, direction: npt.NDArray[np.int64],
    angle: Array, angles: Array,
) -> Ends:  # fmt: skip
    """Ends with some of them tighter, and the states and angles that bind there."""
    now = getattr(ends, name)[at]
    tighter = value > now if name == "low" else value < now
    nearest = np.abs(angle[:, np.newaxis] - angles).argmin(axis=1)
    changed = {each: getattr(ends, f"{name}{each}").copy() for each in ("", "_state", "_angle")}
    changed[""][at] = np.where(tighter, value, now)
    changed["_state"][at] = np.where(tighter, direction * len(angles) + nearest, changed["_state"][at])
    changed["_angle"][at] = np.where(tighter, angle, np.nan)
    return replace(ends, **{f"{name}{each}": values for each, values in changed.items()})
