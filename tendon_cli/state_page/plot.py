"""The figure of a motor.

It shows the motor's torque against its speed over the cycle, the loop that friction opens, and the
torque while the spool turns back. Along a motion in time it shows the torque over time instead of
the loop.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.engine.plan import Block, Plan
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import Axes, Line2D
from tendon_cli.figures.curves import ZEROS_OF_SPOOL
from tendon_cli.figures.frame import framed, source_of_study
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, format_of, house_style
from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.motor import cycle_columns, motor_rates
from tendon_cli.model.reversal import reversal
from tendon_cli.model.statics import NO_EQUILIBRIUM
from tendon_cli.quantities import SIDES
from tendon_cli.state_page.lines import scalar, slides_in_flexion
from tendon_cli.state_page.motion_plot import (
    MOTOR_STYLE,
    MotorMotion,
    draw_torque_over_time,
    limit_style,
    motion_key,
)

Array = npt.NDArray[np.float64]
Curves = dict[str, tuple[Array, Array]]
"""Speeds of a motor, rad/s, and its torques, N m, by direction; of a motion in time by ""."""

_MARGIN = 0.08
"""Room around the curves, as a share of what they span."""
_ROOM_FOR_LIMIT = 1.12
"""End of the view over a limit on torque or speed, as a factor."""
_ROOM_FOR_ANGLES = 0.45
"""Room on either side of the loop for the angles at its ends, as a share of its width."""
_POINTS = 721
"""Points of each curve."""
_LIMITS = ("peak_motor_torque", "peak_motor_speed", "peak_motor_power")
_BOTH_DIRECTIONS = np.array([[True], [False]])
"""True for flexion, (directions, angles)."""
_DIRECTIONS: dict[str, dict[str, Any]] = {
    "flexion": {"color": OKABE_ITO[0], "linestyle": "solid"},
    "extension": {"color": OKABE_ITO[1], "linestyle": (0, (3.2, 1.4))},
}
"""Style of each direction."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """One direction of a cycle: arrays of _POINTS along the motion, in SI."""

    elbow_angle: Array
    spool_angle: Array
    motor_speed: Array
    motor_torque: Array


def draw_motor(
    path: Path, state: State, plan: Plan, block: Block, *, turns: bool, overwrite: bool = False
) -> Path:
    """Draw the motor of a state's design into a file.

    Args:
        path: The file.
        state: The state.
        plan: The plan of the study. Both strokes are drawn if the study has a speed, the whole
            motion if it has one in time.
        block: The block of that state.
        turns: True to draw the torque while the spool turns back at that state.
        overwrite: True to replace a file that tendon did not write.

    Raises:
        OutputError: The file cannot be written.
        UsageError: There is nothing to draw, the ending is not that of a figure, or tendon did not
            write the file.
    """
    speed = plan.study.motion.speed
    trajectory = plan.study.trajectory
    design = state.design
    if int(state.status.flat[0]) == NO_EQUILIBRIUM:
        raise UsageError(
            "this state has no equilibrium, so the motor cannot be drawn",
            where="--plot",
            hint="--set 'motion.elbow_angle=60 deg' chooses another state",
        )
    if speed is None and trajectory is None and not turns:
        raise UsageError(
            "the study has no speed, so the motor cannot be drawn",
            where="--plot",
            hint="--set 'motion.speed=60 deg/s', or --reversal",
        )
    format_of(path, "--plot")
    load = float(np.ravel(design.load_mass)[0])
    title = f"{plan.study.name}: the motor, load {say.quantity('load_mass', load, 6)}"
    strokes = {}
    motion = None
    if speed is not None:
        joint = say.joint_name(plan.study)
        title = f"{title}, {joint} at {say.quantity('elbow_speed', speed.single, 6)}"
        for direction in plan.directions:
            strokes[direction] = stroke_of(design, plan, direction, speed.single)
    if trajectory is not None:
        motion = MotorMotion.of(plan.moving(block))
    limits = _limits_of(design, plan)
    curves = _curves_of(strokes, motion)
    view = _View.of(curves, limits)
    with house_style():
        key = [
            Line2D([], [], label=direction, **style)
            for direction, style in _DIRECTIONS.items()
            if direction in strokes
        ]
        if motion is not None:
            key = motion_key(motion)
        notes = [*_limit_notes(view, limits)] if curves else []
        notes += _notes(design, plan, turns=turns)
        page = framed(title, 74.0, key, notes, study=source_of_study(plan.study))
        count = 2 * bool(curves) + turns
        widths = [1.0] * count
        if motion is not None:
            widths[0] = 2.0
        panels = page.figure.subplots(1, count, squeeze=False, width_ratios=widths)[0]
        if strokes:
            _draw_torque_and_speed(panels[0], curves, limits, view)
            _draw_loop(panels[1], strokes)
        if motion is not None:
            draw_torque_over_time(panels[0], motion, limits.get("peak_motor_torque"))
            _draw_torque_and_speed(panels[1], curves, limits, view)
        if turns:
            angles, torque, follows = turn_of(state, plan)
            _draw_turn(panels[-1], angles, torque, follows)
            panels[-1].set_title(_turn_title(plan, block))
        for axes in panels:
            axes.yaxis.set_major_formatter(plain_numbers())
            axes.set_ylabel("motor torque $\\tau_m$ (N m)")
        if motion is not None:
            panels[0].set_ylabel("torque (N m)")
    return page.of_joint(plan.study).save(path, overwrite=overwrite)


def _curves_of(strokes: Mapping[str, Stroke], motion: MotorMotion | None) -> Curves:
    """Return torque and speed along a motion in time, or else along both strokes."""
    if motion is not None:
        return {"": motion.speed_and_torque}
    return {
        direction: (stroke.motor_speed, stroke.motor_torque)
        for direction, stroke in strokes.items()
    }


def _limits_of(design: Design, plan: Plan) -> dict[str, float]:
    """Return the limits of one design, SI, by name: its own before those of the study."""
    own = {name: float(np.ravel(bound)[0]) for name, bound in design.limits.items()}
    stated = {name: bound for name, bound in own.items() if not np.isnan(bound)}
    return {**plan.study.limits, **stated}


def stroke_of(design: Design, plan: Plan, direction: str, speed: float) -> Stroke:
    """Evaluate one direction of motion through the study's angles, in fine steps.

    Args:
        design: The design.
        plan: The plan of the study.
        direction: "flexion" or "extension".
        speed: Speed of the elbow, rad/s.
    """
    flexion = direction == "flexion"
    angles = np.linspace(plan.elbow_angles.min(), plan.elbow_angles.max(), _POINTS)
    if not flexion:
        angles = angles[::-1]
    state = evaluate(design, angles[np.newaxis], np.array([[flexion]]))
    rates = motor_rates(state)
    motor_speed = (speed if flexion else -speed) * rates.spool_speed
    return Stroke(
        elbow_angle=angles,
        spool_angle=_along_motion(state.spool_angle),
        motor_speed=_along_motion(motor_speed),
        motor_torque=_along_motion(state.motor_torque),
    )


def _along_motion(values: Array) -> Array:
    """Return values at all points of a stroke; a constant is repeated."""
    return np.array(np.broadcast_to(values.reshape(-1), _POINTS))


def turn_of(state: State, plan: Plan) -> tuple[Array, Array, dict[str, tuple[float, float]]]:
    """Evaluate the motor's torque while the spool turns back at a state.

    Returns:
        The angles by which the spool is turned back, rad; the motor's torque at each, N m; and by
        side the angle and the torque at which the far end of a taut tendon follows.
    """
    flexion = np.asarray(slides_in_flexion(plan, state))
    turned = reversal(state, scalar(state.elbow_angle), flexion)
    ends = {side: float(np.ravel(getattr(turned, side).turn)[0]) for side in SIDES}
    positive = [end for end in ends.values() if end > 0.0]
    turns = 1.15 * max(positive or [1e-3]) * np.linspace(0.0, 1.0, _POINTS)

    def torque_at(turn: float) -> float:
        return float(np.ravel(turned.motor_torque(np.asarray(turn)))[0])

    torque = np.array([torque_at(turn) for turn in turns])
    follows = {side: (end, torque_at(end)) for side, end in ends.items() if np.isfinite(end)}
    return turns, torque, follows


def _notes(design: Design, plan: Plan, *, turns: bool) -> list[str]:
    """Return sentences that say what is drawn, with the loss of a cycle."""
    speed = plan.study.motion.speed
    notes: list[str] = []
    if speed is not None and len(plan.directions) == 2:
        angles = plan.elbow_angles[np.newaxis]
        loss = cycle_columns(design, angles, _BOTH_DIRECTIONS, speed.single)["friction_loss"]
        if np.isfinite(loss).all():
            lost = say.quantity("friction_loss", loss.item())
            notes.append(f"Friction takes {lost} over both strokes.")
    if speed is not None:
        notes.append(ZEROS_OF_SPOOL)
    if plan.study.trajectory is not None:
        notes.append(
            "Torque against speed shows the counted samples, with friction in the direction in "
            "which the tendons slide."
        )
    if turns:
        notes.append("Dots: where the far end of each tendon begins to follow the spool.")
    return notes


@dataclass(frozen=True)
class _View:
    """Part of the plane of speed and torque that is drawn, rad/s and N m."""

    left: float
    right: float
    low: float
    high: float

    @classmethod
    def of(cls, curves: Curves, limits: Mapping[str, float]) -> _View:
        """Return a view that shows all curves, zero, and the limits on torque and speed.

        Both signs of a limit are shown, so that the distance to it is seen.
        """
        torque, speed, _ = (limits.get(name, 0.0) for name in _LIMITS)
        left, right = _padded([speeds for speeds, _ in curves.values()])
        low, high = _padded([torques for _, torques in curves.values()])
        return cls(
            left=min(left, -_ROOM_FOR_LIMIT * speed),
            right=max(right, _ROOM_FOR_LIMIT * speed),
            low=min(low, -_ROOM_FOR_LIMIT * torque),
            high=max(high, _ROOM_FOR_LIMIT * torque),
        )

    def shows_power(self, power: float) -> bool:
        """Return True if the curve along which the motor gives a power, W, is in the view."""
        return power < max(self.right * self.high, self.left * self.low)


def _padded(curves: Sequence[Array]) -> tuple[float, float]:
    """Return the ends of curves and zero, with a margin; NaN counts for nothing."""
    values = np.concatenate([[0.0], *curves])
    low = float(np.nanmin(values))
    high = float(np.nanmax(values))
    margin = _MARGIN * (high - low)
    return low - margin, high + margin


def _limit_notes(view: _View, limits: Mapping[str, float]) -> Iterator[str]:
    """Say which of the motor's limits are drawn, and that one on power is out of sight."""
    power = limits.get("peak_motor_power")
    is_power_drawn = power is not None and view.shows_power(power)
    drawn = [name for name in ("peak_motor_torque", "peak_motor_speed") if name in limits]
    if is_power_drawn:
        drawn.append("peak_motor_power")
    if drawn:
        bounds = [say.quantity(name, limits[name], 4) for name in drawn]
        yield f"Dotted: the limits, {', '.join(bounds)}."
    if power is not None and not is_power_drawn:
        bound = say.quantity("peak_motor_power", power, 4)
        yield f"The limit on power, {bound}, lies outside what is shown."


def _draw_torque_and_speed(
    axes: Axes, curves: Curves, limits: Mapping[str, float], view: _View
) -> None:
    """Draw torque against speed, with the motor's limits.

    Args:
        axes: The panel.
        curves: Curves by direction.
        limits: Limits of the study.
        view: What the panel shows.
    """
    for direction, (motor_speed, motor_torque) in curves.items():
        style = _DIRECTIONS.get(direction, MOTOR_STYLE)
        axes.plot(motor_speed, motor_torque, gid="curve", **style)
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    axes.axvline(0.0, color=FAINT, linewidth=0.5)
    dotted = limit_style()
    torque, speed, power = (limits.get(name, 0.0) for name in _LIMITS)
    for sign, farthest in ((1.0, view.right), (-1.0, view.left)):
        if speed:
            axes.axvline(sign * speed, **dotted)
        if torque:
            axes.axhline(sign * torque, **dotted)
        if power and view.shows_power(power):
            turning = np.linspace(sign * power / view.high, farthest, 200)
            axes.plot(turning, power / turning, **dotted)
    axes.set_title("Torque against speed")
    axes.set_xlabel("motor speed (rad/s)")
    axes.set_xlim(view.left, view.right)
    axes.set_ylim(view.low, view.high)


def _turn_title(plan: Plan, block: Block) -> str:
    """Return the title of the panel of a turn: the time or the angle at which it is."""
    place = block.angles.start
    if plan.study.trajectory is not None:
        return f"Turn at {say.quantity('time', plan.study.trajectory.time[place], 4)}"
    angle = say.quantity("elbow_angle", plan.elbow_angles[place], 6)
    return f"Turn from {plan.directions[0]} at {angle}"


def _draw_loop(axes: Axes, strokes: Mapping[str, Stroke]) -> None:
    """Draw torque over the spool's angle, which each direction counts from its own zero."""
    for direction, stroke in strokes.items():
        angle = np.degrees(stroke.spool_angle)
        axes.plot(angle, stroke.motor_torque, gid="curve", **_DIRECTIONS[direction])
    first = next(iter(strokes.values()))
    for end, beside in ((0, -1), (-1, 0)):
        place = (np.degrees(first.spool_angle[end]), first.motor_torque[end])
        text = f"θ = {say.quantity('elbow_angle', first.elbow_angle[end])}"
        # Beyond its end of the loop, where no curve is.
        is_left = first.spool_angle[end] < first.spool_angle[beside]
        style: dict[str, Any] = {"ha": "right" if is_left else "left", "va": "center", "size": 6.5}
        offset = (-3.0 if is_left else 3.0, 0.0)
        axes.annotate(text, place, xytext=offset, textcoords="offset points", **style)
    axes.margins(x=_ROOM_FOR_ANGLES, y=0.12)
    axes.set(title="Hysteresis", xlabel="spool angle α (deg)")


def _draw_turn(
    axes: Axes, turn: Array, torque: Array, follows: Mapping[str, tuple[float, float]]
) -> None:
    """Draw the torque over the turn, and the points at which the far ends follow.

    The name of the first point is above its dot, that of the second below.
    """
    axes.plot(np.degrees(turn), torque, color=INK, gid="curve")
    ascending = sorted(follows.items(), key=lambda item: item[1])
    for place, (side, (end, torque_there)) in enumerate(ascending):
        degrees = np.degrees(end)
        axes.plot([degrees], [torque_there], "o", color=INK, markersize=4.0, gid="mark")
        axes.annotate(
            f"{side}, {say.number(degrees, 3)}°",
            (degrees, torque_there),
            xytext=(4, -4 if place else 4),
            textcoords="offset points",
            va="top" if place else "bottom",
            size=6.5,
        )
    axes.margins(0.08, 0.12)
    axes.set_xlim(right=1.9 * float(np.degrees(turn[-1])))
    axes.set_xlabel("spool turned back (deg)")
