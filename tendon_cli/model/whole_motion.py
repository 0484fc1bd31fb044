"""Windows of pretension over the whole motion, also between the angles of a grid.

The lower end of a window is the largest pretension that any state needs, the upper end the smallest
that any state allows. Over a grid of angles both err on the unsafe side, by the square of its step.
So each end is refined around the angle of the grid that binds. Arguments broadcast as in
`actuator`; SI units, angles in radians.
"""

from __future__ import annotations

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds, bound_ends
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.limits import CONTACT_PRESSURE, LIMIT_NAMES
from tendon_cli.model.setting import reading_at
from tendon_cli.model.window import ends_of_states, slack_codes

ANGLES = 91
"""Angles of the grid over any motion, whatever angles a study lists."""
_ROUNDS = 3
"""Rounds of a search, each of which goes to the top of the parabola through three angles."""
_NARROWER = 12.0
"""Factor by which these angles move together from round to round."""
_BEFORE = 1e-9
"""Distance from the angle at which the strap begins to press, within which it does not yet, rad."""
_AHEAD = 1e-3
"""Distance inward of the first and last angle, as a share of a step; it shows whether an end is
tighter there."""


def angle_grid(elbow_angle: Array) -> Array:
    """Return the angles at which windows over the whole motion are taken.

    Args:
        elbow_angle: All angles that a study lists, rad.

    Returns:
        Equally spaced angles from the least to the largest, (1, K), rad.
    """
    low = float(np.min(elbow_angle))
    high = float(np.max(elbow_angle))
    count = ANGLES if high > low else 1
    return np.linspace(low, high, count).reshape(1, -1)


def with_contacts(angles: Array, design: Design) -> Array:
    """Add to angles, (1, K), those from which on the straps of designs press, rad.

    Only angles between the first and the last are added, and none for designs whose straps have no
    width.
    """
    contact, width = np.broadcast_arrays(design.arm.first_contact, design.arm.contact_width)
    contacts = np.unique(contact[~np.isnan(width)])
    is_inside = (contacts > angles[0, 0]) & (contacts < angles[0, -1])
    return np.union1d(angles, contacts[is_inside])[np.newaxis]


def with_edges(angles: Array) -> Array:
    """Add to the angles of `angle_grid` one just inward of either end, (1, K + 2), rad."""
    ahead = _AHEAD * (angles[0, 1] - angles[0, 0])
    edges = [angles[0, 0] + ahead, angles[0, -1] - ahead]
    return np.insert(angles, [1, angles.size - 1], edges, axis=1)


def without_edges(state: Rows, angles: Array) -> Flags:
    """Renumber states among angles `with_edges` as those of the nearest grid angles, in place.

    Args:
        state: Indices of states over both directions and the angles `with_edges`; -1 for none.
        angles: Angles of `angle_grid`, (1, K), rad.

    Returns:
        True where the state was not at the first or the last angle.
    """
    direction, place = np.divmod(state, angles.size + 2)
    nearest = direction * angles.size + np.clip(place - 1, 0, angles.size - 1)
    np.copyto(state, nearest, where=state >= 0)
    return np.asarray((place > 0) & (place <= angles.size))


def end_curves(
    design: Design, elbow_angle: Array, flexion: Flags, bounds: Bounds, counts: Flags
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return the pretensions that each limit on states needs or allows at each angle.

    Args:
        design: Designs.
        elbow_angle: Angles, (1, K), rad.
        flexion: Directions of motion, (D, 1).
        bounds: Limits of the designs.
        counts: True for the designs, or the states, that count; the designs' shape, then (1, 1) or
            (D, K).

    Returns:
        Least and largest pretensions by the name of the limit, (K,), N, over both directions and
        the designs that count, as their pretension is read; infinite where a limit sets none.
    """
    at = State.of(design, elbow_angle, flexion)
    required = at.response.required
    counts = counts & ~np.isnan(required)

    # Code of the limit, margin at which it is just kept (N), where that is a lower or upper end
    slack = slack_codes(at)
    never = np.zeros_like(slack, dtype=np.bool_)
    ends = [(int(code), np.zeros(()), slack == code, never) for code in np.unique(slack)]
    for end in bound_ends(at, bounds):
        moves = end.gain != 0.0
        ends.append((end.code, end.margin, end.is_lower & moves, ~end.is_lower & moves))

    least: dict[str, Array] = {}
    largest: dict[str, Array] = {}
    for code, margin, is_lower, is_upper in ends:
        name = LIMIT_NAMES[code]
        pretension = reading_at(design, required + margin)
        for curves, binds, sign in ((least, is_lower, 1.0), (largest, is_upper, -1.0)):
            asked = np.where(counts & binds, sign * pretension, -np.inf)
            tightest = asked.reshape(-1, asked.shape[-1]).max(axis=0)
            if np.any(tightest > -np.inf):
                known = curves.get(name, -sign * np.inf)
                curves[name] = sign * np.maximum(tightest, sign * known)
    return least, largest


def refine_ends(
    design: Design,
    state: Rows,
    value: Array,
    angles: Array,
    flexion: Flags,
    bounds: Bounds,
    *,
    upper: bool,
    start: Array | None = None,
) -> tuple[Array, Rows, Array]:
    """Return ends of windows over all angles, from ends over the angles of `angle_grid`.

    Args:
        design: Designs, (N, 1, 1).
        state: Indices of the binding states over directions and grid angles, (N,).
        value: Ends of the windows in these states, (N,), N.
        angles: Angles of `angle_grid`, (K,), rad; a single one is where the ends are taken.
        flexion: Directions of motion, (D, 1).
        bounds: Limits of the designs.
        upper: True for upper ends of windows.
        start: Angles to begin from, (N,), rad. The ends are then sought only in the direction of
            their states and within part of a step, as another peak may be only a step away.

    Returns:
        Ends (N), states nearest to the angles that bind, and these angles (rad), (N,) each; the
        angle is NaN where the end over the grid angles stays the tightest.
    """
    sign = -1.0 if upper else 1.0
    step = (angles[-1] - angles[0]) / max(len(angles) - 1, 1)
    direction, place = np.divmod(state, len(angles))
    rows = np.arange(len(state))

    def tightness(where: Array, directions: Flags) -> Array:
        """Return ends of states at angles (N, angles), N, signed so that a larger one is tighter.

        The result has the shape (N, directions, angles).
        """
        ends = ends_of_states(State.of(design, where[:, np.newaxis, :], directions), bounds)
        values = sign * (ends.high if upper else ends.low)
        shape = len(state), directions.shape[-2], where.shape[1]
        return np.broadcast_to(np.where(np.isnan(values), -np.inf, values), shape)

    def flexion_of_each() -> Flags:
        """Return the direction in which each end is sought, (N, 1, 1)."""
        return flexion.ravel()[direction, np.newaxis, np.newaxis]

    centre = angles[place] if start is None else start
    first, last = _smooth_stretch(design, bounds, angles, centre)
    rounds = np.arange(float(_ROUNDS))
    if start is not None:
        rounds = rounds + 1.0
    for attempt, widest in enumerate(step * _NARROWER**-rounds):
        chooses_direction = start is None and attempt == 0
        width = np.minimum(widest, 0.5 * (last - first))  # (N,)
        middle = np.clip(centre, first + width, last - width)
        where = middle[:, np.newaxis] + width[:, np.newaxis] * np.array([-1.0, 0.0, 1.0])
        directions = flexion if chooses_direction else flexion_of_each()
        offset, top = _parabola_top(tightness(where, directions))
        best = top.argmax(axis=1)
        if chooses_direction:
            direction = best
        centre = middle + width * offset[rows, best]

    found = tightness(centre[:, np.newaxis], flexion_of_each())[:, 0, 0]
    nearest = direction * len(angles)
    if step > 0.0:
        nearest = nearest + np.rint((centre - angles[0]) / step).astype(np.int64)
    is_tighter = found > sign * value
    return (
        np.where(is_tighter, sign * found, value),
        np.where(is_tighter, nearest, state),
        np.where(is_tighter, centre, np.nan),
    )


def _smooth_stretch(
    design: Design, bounds: Bounds, angles: Array, centre: Array
) -> tuple[Array, Array]:
    """Return the ends of the stretches of the motion in which ends of windows are sought, rad.

    At the angle from which on the strap presses, a limit on its pressure begins at once: no stretch
    goes across it.

    Args:
        design: Designs, (N, 1, 1).
        bounds: Limits of the designs.
        angles: Angles of `angle_grid`, (K,), rad.
        centre: An angle in each stretch, (N,), rad.
    """
    first = np.full(len(centre), angles[0])
    last = np.full(len(centre), angles[-1])
    is_bounded = bounds.of(design).asks(CONTACT_PRESSURE)
    if not is_bounded.any():
        return first, last
    at_centre = centre[:, np.newaxis, np.newaxis]
    contact = np.broadcast_to(design.arm.first_contact, at_centre.shape)[:, 0, 0]
    is_pressed = np.broadcast_to(design.arm.is_pressed(at_centre), at_centre.shape)[:, 0, 0]
    before = np.clip(contact - _BEFORE, first, last)
    begins = np.broadcast_to(is_bounded, at_centre.shape)[:, 0, 0]
    return (
        np.where(begins & is_pressed, np.clip(contact, first, last), first),
        np.where(begins & ~is_pressed, before, last),
    )


def _parabola_top(values: Array) -> tuple[Array, Array]:
    """Return the top of the parabola through three equally spaced values, the last axis.

    The first result is its distance from the middle one in spacings, the second its height; where
    the parabola has no higher top between them, the largest of the three counts.
    """
    before, centre, after = np.moveaxis(values, -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = 0.5 * (before - after) / (before - 2.0 * centre + after)
        rise = 0.25 * (after - before) * offset
    largest = values.max(axis=-1)
    is_inside = (np.abs(offset) <= 1.0) & (rise > 0.0) & (centre + rise > largest)
    return (
        np.where(is_inside, offset, values.argmax(axis=-1) - 1.0),
        np.where(is_inside, centre + rise, largest),
    )
