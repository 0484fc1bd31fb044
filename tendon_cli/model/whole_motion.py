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
from tendon_cli.model.setting import shown
from tendon_cli.model.window import Positions, ends_of_states, slack_codes

ANGLES = 91
"""Taken of any motion, whichever a study lists: what lies between them is sought from there."""
_ROUNDS, _NARROWER = 3, 12.0
"""Each goes to the top of the parabola through three angles, which lie closer by that from round to round."""
_AHEAD = 1e-3
"""Of a step; whether an end is tighter inward of the first or last angle is seen there."""


def grid(elbow_angle: Array) -> Array:
    """The angles at which windows over the whole motion are taken, (1, K), from all that a study lists, rad."""
    low, high = float(np.min(elbow_angle)), float(np.max(elbow_angle))
    return np.linspace(low, high, ANGLES if high > low else 1).reshape(1, -1)


def with_edges(angles: Array) -> Array:
    """`grid` angles, and besides the first and the last one just inward of it, (1, K + 2)."""
    ahead = _AHEAD * (angles[0, 1] - angles[0, 0])
    return np.insert(
        angles, [1, angles.size - 1], [angles[0, 0] + ahead, angles[0, -1] - ahead], axis=1
    )


def without_edges(state: Positions, angles: Array) -> Flags:
    """States among angles `with_edges` as those of the nearest `grid` angles, in place; whether one is no edge's."""
    way, place = np.divmod(state, angles.size + 2)
    np.copyto(state, way * angles.size + np.clip(place - 1, 0, angles.size - 1), where=state >= 0)
    return np.asarray((place > 0) & (place <= angles.size))


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
    slack_ends = [
        (int(code), np.zeros(()), slack >= 0, 1.0 * (slack == code)) for code in np.unique(slack)
    ]
    ends = [*slack_ends, *(each[:4] for each in ends_of(at, bounds))]
    for code, end, is_lower, gain in ends:
        for of_limits, holds, sign in zip(curves, (is_lower, ~is_lower), (1.0, -1.0), strict=True):
            asks = counts & holds & (gain != 0.0) & ~np.isnan(required)
            asked = np.where(asks, sign * shown(design, required + end), -np.inf)
            most = asked.reshape(-1, asked.shape[-1]).max(axis=0)
            if np.any(most > -np.inf):
                name = LIMIT_NAMES[code]
                of_limits[name] = sign * np.maximum(
                    most, sign * of_limits.get(name, -sign * np.inf)
                )
    return curves


def refined(
    design: Design,
    state: Positions,
    value: Array,
    angles: Array,
    flexion: Flags,
    bounds: Bounds,
    *,
    upper: bool,
    start: Array | None = None,
) -> tuple[Array, Positions, Array]:
    """Ends of windows over all angles, from ends over `grid` angles (N, state): N, state and the angle that binds.

    Ends have one axis, the first of the designs' three; directions are (D, 1), angles (K,). The state becomes the one
    nearest to the angle that binds; that is NaN where the grid's end stays the tightest. From angles to `start` at
    they are sought in the state's direction, within a part of a step: where another peak lies that near.
    """
    sign, step, place = (
        -1.0 if upper else 1.0,
        (angles[-1] - angles[0]) / (len(angles) - 1),
        state % len(angles),
    )
    way = state // len(angles)

    def asked(where: Array, ways: Flags) -> Array:
        """What is asked for at angles (designs, angles), the larger the tighter: (designs, directions, angles)."""
        values = (
            sign
            * ends_of_states(State.of(design, where[:, np.newaxis, :], ways), bounds)[int(upper)]
        )
        return np.broadcast_to(
            np.where(np.isnan(values), -np.inf, values),
            (len(state), ways.shape[-2], where.shape[1]),
        )

    centre, each = angles[place] if start is None else start, np.arange(len(state))
    for apart in step * _NARROWER ** -(np.arange(float(_ROUNDS)) + (start is not None)):
        middle = np.clip(centre, angles[0] + apart, angles[-1] - apart)
        where = middle[:, np.newaxis] + apart * np.array([-1.0, 0.0, 1.0])
        values = asked(
            where, flexion if apart == step else flexion.ravel()[way, np.newaxis, np.newaxis]
        )
        before, here, after = np.moveaxis(values, -1, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = 0.5 * (before - after) / (before - 2.0 * here + after)
            rise = 0.25 * (after - before) * ahead
        most = values.max(axis=2)
        inside = (np.abs(ahead) <= 1.0) & (rise > 0.0) & (here + rise > most)
        ahead = np.where(inside, ahead, values.argmax(axis=2) - 1.0)
        direction = np.where(inside, here + rise, most).argmax(axis=1)
        if apart == step:
            way = direction
        centre = middle + apart * ahead[each, direction if apart == step else 0]
    top = asked(centre[:, np.newaxis], flexion.ravel()[way, np.newaxis, np.newaxis])[:, 0, 0]
    nearest, tighter = (
        way * len(angles) + np.rint((centre - angles[0]) / step).astype(np.int64),
        top > sign * value,
    )
    return (
        np.where(tighter, sign * top, value),
        np.where(tighter, nearest, state),
        np.where(tighter, centre, np.nan),
    )
