"""Windows of the whole motion: between the angles at which states were taken, too.

An end of a window is the largest (the smallest) over all angles of what each state asks for. Taken over some angles it
errs on the unsafe side, by the square of their distance. So it is sought around the angle that binds among these, where
it lies between two of them. Arguments broadcast as in `actuator`; SI units, angles in radians.
"""

from __future__ import annotations

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds, ends_of
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.motor import taken
from tendon_cli.model.setting import shown
from tendon_cli.model.window import Positions, ends_of_states, slack_codes

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
    design: Design, elbow_angle: Array, flexion: Flags, bounds: Bounds, counts: Flags
) -> tuple[dict[str, Array], dict[str, Array]]:
    """What each limit on states asks for at each angle, N: the least pretensions, and the largest, by its name.

    Over both directions and the designs that count (their shape, then (1, 1)), as their pretension is read; infinite
    where a limit asks for nothing. Angles are (1, K), the results (K,).
    """
    at = State.of(design, elbow_angle, flexion)
    required, slack = at.response.required, slack_codes(at)
    curves: tuple[dict[str, Array], dict[str, Array]] = {}, {}
    slack_ends = [(int(code), np.zeros(()), slack >= 0, 1.0 * (slack == code)) for code in np.unique(slack)]
    ends = [*slack_ends, *(each[:4] for each in ends_of(at, bounds))]
    for code, end, is_lower, gain in ends:
        for of_limits, holds, sign in zip(curves, (is_lower, ~is_lower), (1.0, -1.0), strict=True):
            asks = counts & holds & (gain != 0.0) & ~np.isnan(required)
            asked = np.where(asks, sign * shown(design, required + end), -np.inf)
            most = asked.reshape(-1, asked.shape[-1]).max(axis=0)
            if np.any(most > -np.inf):
                name = LIMIT_NAMES[code]
                of_limits[name] = sign * np.maximum(most, sign * of_limits.get(name, -sign * np.inf))
    return curves


def refined(
    design: Design, state: Positions, value: Array, angles: Array, flexion: Flags, bounds: Bounds, *, upper: bool
) -> tuple[Array, Positions, Array]:
    """Ends of windows over all angles, from ends over `grid` angles (N, state): N, state and the angle that binds.

    Ends have one axis, the first of the designs' three; directions are (D, 1), angles (K,). The state becomes the one
    nearest to the angle that binds; that is NaN where the grid's end stays the tightest.
    """
    sign, step, place = -1.0 if upper else 1.0, (angles[-1] - angles[0]) / max(len(angles) - 1, 1), state % len(angles)
    best, way, angle = sign * value, state // len(angles), angles[place]

    def asked(rows: Positions, where: Array) -> Array:
        """What is asked for at angles (designs, angles), the larger the tighter: (designs, directions, angles)."""
        some = design if len(rows) == len(state) else taken(design, (len(state), 1, 1), (rows,))
        values = sign * ends_of_states(State.of(some, where[:, np.newaxis, :], flexion), bounds)[int(upper)]
        return np.broadcast_to(np.where(np.isnan(values), -np.inf, values), (len(rows), len(flexion), where.shape[1]))

    def take(rows: Positions, where: Array, values: Array) -> None:
        flat, each = values.reshape(len(rows), len(flexion) * where.shape[1]), np.arange(len(rows))
        most = flat.argmax(axis=1)
        better = flat[each, most] > best[rows]
        direction, point = np.divmod(most, where.shape[1])
        for whole, part in ((best, flat[each, most]), (way, direction), (angle, where[each, point])):
            whole[rows[better]] = part[better]

    inward = np.where(place == 0, _AHEAD, np.where(place == len(angles) - 1, -_AHEAD, 0.0)) * step
    edge = np.flatnonzero(inward)
    falls = asked(edge, (angle + inward)[edge, np.newaxis]).max(axis=(1, 2)) <= best[edge]
    rows = np.delete(np.arange(len(state)), edge[falls])
    for narrow in range(_ROUNDS):
        spread = np.linspace(-step, step, _POINTS) * 4.0**-narrow
        where = np.clip(angle[rows, np.newaxis] + spread, angles[0], angles[-1])
        take(rows, where, asked(rows, where))
    apart = 0.25 * step * 4.0 ** (1 - _ROUNDS)
    middle = np.clip(angle[rows], angles[0] + apart, angles[-1] - apart)
    three = asked(rows, middle[:, np.newaxis] + apart * np.array([-1.0, 0.0, 1.0]))[np.arange(len(rows)), way[rows]]
    with np.errstate(divide="ignore", invalid="ignore"):
        ahead = 0.5 * (three[:, 0] - three[:, 2]) / (three[:, 0] - 2.0 * three[:, 1] + three[:, 2])
    top = (middle + apart * np.clip(np.nan_to_num(ahead), -1.0, 1.0))[:, np.newaxis]
    take(rows, top, asked(rows, top))
    nearest = way * len(angles) + np.abs(angle[:, np.newaxis] - angles).argmin(axis=1)
    tighter = best > sign * value
    return sign * best, np.where(tighter, nearest, state), np.where(tighter, angle, np.nan)
