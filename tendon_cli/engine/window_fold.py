"""The ends of windows of pretension, folded from states: of a box of designs or of single ones.

A sweep takes them at the states that it samples; an answer seeks them between these, too.
"""

from __future__ import annotations

from tendon_cli import kernel
from tendon_cli.model import window
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.window import Ends

_ANGLES_AT_ONCE = 2**16
"""Most elbow angles that are folded together."""


def fold_ends(
    design: Design, shape: tuple[int, ...], elbow_angle: Array, flexion: Flags, bounds: Bounds
) -> Ends:
    """Return the ends of the windows of designs over states, as F0.

    The limit on power is left out, but along a trajectory: there ends have all limits, and are a
    `Window`.

    Args:
        design: Designs, few enough that the arrays of all of them fit into memory.
        shape: Their axes.
        elbow_angle: Angles, (1, K) or (*shape, 1, K), rad; along a trajectory it has its own.
        flexion: Directions of motion, (D, 1).
        bounds: Limits of the designs.
    """
    if design.trajectory is not None:
        from tendon_cli.model.motion_window import window_along  # only these pay for its import

        return window_along(design, design.trajectory, bounds)
    tightest = window.begin(shape)
    count = elbow_angle.shape[-1]
    for first in range(0, count, _ANGLES_AT_ONCE):
        stretch = elbow_angle[..., first : first + _ANGLES_AT_ONCE]
        state = State.of(design, stretch, flexion)
        lengths = (*shape, len(flexion), stretch.shape[-1])
        kernel.fold_window(tightest, state, bounds, lengths, first, count)
    return window.finish(tightest, design, bounds)


def named_ends(
    ends: Ends,
    design: Design,
    elbow_angle: Array,
    flexion: Flags,
    bounds: Bounds,
    loads: tuple[float, float] | None = None,
) -> window.Window:
    """Return ends with the limits that bind, as F0, within the limit on power.

    Args:
        ends: Ends that limits on forms set, at states or between them; not along a trajectory.
        design: Designs.
        elbow_angle: Angles, (1, K), rad.
        flexion: Directions of motion, (D, 1).
        bounds: Limits of the designs.
        loads: Least and largest load, kg; power counts at those between, too.
    """
    named = window.with_binding_limits(ends, design, elbow_angle, flexion, bounds)
    if not bounds.asks_power:
        return named
    from tendon_cli.model.power_window import within_power  # only power pays for its import

    return within_power(named, design, elbow_angle, flexion, bounds, loads)
