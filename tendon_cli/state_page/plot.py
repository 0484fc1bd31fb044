"""The figure of a motor: its torque against its speed over the cycle, the loop that friction opens, and a turn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.plan import Plan
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import Axes, Line2D
from tendon_cli.figures.frame import framed
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, format_of, house_style
from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.motor import cycle, motor_rates
from tendon_cli.model.reversal import reversal
from tendon_cli.model.statics import NO_EQUILIBRIUM
from tendon_cli.quantities import QUANTITIES

Array = npt.NDArray[np.float64]

_POINTS = 721
_LIMITS = ("peak_motor_torque", "peak_motor_speed", "peak_motor_power")
_BOTH = np.array([[True], [False]])
_WAYS: dict[str, dict[str, Any]] = {
    "flexion": {"color": OKABE_ITO[0], "linestyle": "solid"},
    "extension": {"color": OKABE_ITO[1], "linestyle": (0, (3.2, 1.4))},
}


@dataclass(frozen=True, eq=False)
class Stroke:
    """One direction of a cycle, along the way: arrays of one length, in SI."""

    elbow_angle: Array
    spool_angle: Array
    motor_speed: Array
    motor_torque: Array


def draw_motor(path: Path, state: State, plan: Plan, *, turns: bool) -> Path:
    """Draw the strokes of a state's design if the study has a speed, and if `turns` the turn at that state.

    Raises OutputError, and UsageError if there is nothing to draw or for an ending that no figure has.
    """
    speed, limits, design = plan.study.motion.speed, plan.study.limits, state.design
    if int(state.status.flat[0]) == NO_EQUILIBRIUM:
        hint = "--set 'motion.elbow_angle=60 deg' chooses another state"
        raise UsageError(
            "this state has no equilibrium, so there is no motor to draw", where="--plot", hint=hint
        )
    if speed is None and not turns:
        hint = "--set 'motion.speed=60 deg/s', or --reversal"
        raise UsageError(
            "the study has no speed, so there is no motor to draw", where="--plot", hint=hint
        )
    format_of(path, "--plot")
    strokes = (
        {}
        if speed is None
        else {way: stroke_of(design, plan, way, speed.single) for way in plan.directions}
    )
    at = "" if speed is None else f", elbow at {np.degrees(speed.single):.6g} deg/s"
    title = f"{plan.study.name}: the motor, load {float(np.ravel(design.load_mass)[0]):.6g} kg{at}"
    with house_style():
        key = [Line2D([], [], label=way, **style) for way, style in _WAYS.items() if way in strokes]
        page = framed(title, 74.0, key, _notes(design, plan, turns=turns))
        panels = page.figure.subplots(1, 2 * bool(strokes) + turns, squeeze=False)[0]
        if strokes:
            _torque_and_speed(panels[0], strokes, limits)
            _loop(panels[1], strokes)
        if turns:
            _turn(panels[-1], *turn_of(state, plan))
            panels[-1].set_title(
                f"Turn from {plan.directions[0]} at {np.degrees(plan.elbow_angles[0]):.6g}°"
            )
        for axes in panels:
            axes.yaxis.set_major_formatter(plain_numbers())
            axes.set_ylabel("motor torque $\\tau_m$ (N m)")
    return page.of_joint(plan.study).save(path)


def stroke_of(design: Design, plan: Plan, direction: str, speed: float) -> Stroke:
    """One way through the study's angles, finely; `speed` is that of the elbow, rad/s."""
    flexion = direction == "flexion"
    angles = np.linspace(plan.elbow_angles.min(), plan.elbow_angles.max(), _POINTS)[
        :: 1 if flexion else -1
    ]
    state = evaluate(design, angles[np.newaxis], np.array([[flexion]]))
    rates = motor_rates(state)
    motor_speed = (speed if flexion else -speed) * rates.spool_speed
    lines = (rates.spool_angle, motor_speed, state.motor_torque)
    return Stroke(
        angles, *(np.array(np.broadcast_to(values.reshape(-1), _POINTS)) for values in lines)
    )


def turn_of(state: State, plan: Plan) -> tuple[Array, Array, dict[str, tuple[float, float]]]:
    """The spool's turn back (rad), the motor's torque on it, and by side where the far end of a taut tendon follows."""
    turned = reversal(
        state, float(plan.elbow_angles[0]), np.asarray(plan.directions[0] == "flexion")
    )
    ends = {side: float(np.ravel(getattr(turned, side).turn)[0]) for side in ("flexor", "extensor")}
    path = (
        1.15
        * max([end for end in ends.values() if end > 0.0] or [1e-3])
        * np.linspace(0.0, 1.0, _POINTS)
    )
    torque = np.array(
        [
            float(np.ravel(turned.motor_torque(np.asarray(turn)))[0])
            for turn in (*path, *ends.values())
        ]
    )
    follows = {
        side: (end, at)
        for (side, end), at in zip(ends.items(), torque[-2:], strict=True)
        if np.isfinite(end)
    }
    return path, torque[:_POINTS], follows


def _notes(design: Design, plan: Plan, *, turns: bool) -> list[str]:
    speed, limits, notes = plan.study.motion.speed, plan.study.limits, list[str]()
    bounds = [f"{limits[name]:.4g} {QUANTITIES[name].unit}" for name in _LIMITS if name in limits]
    if speed is not None and bounds:
        notes.append(f"Dotted: the limits, {', '.join(bounds)}.")
    if speed is not None and len(plan.directions) == 2:
        loss = cycle(design, plan.elbow_angles[np.newaxis], _BOTH, speed.single)["friction_loss"]
        if np.isfinite(loss).all():
            notes.append(
                f"The shaded area is what friction takes over both strokes, {loss.item():.3g} J."
            )
    return notes + (["Dots: where the far end of each tendon follows the spool."] if turns else [])


def _torque_and_speed(
    axes: Axes, strokes: Mapping[str, Stroke], limits: Mapping[str, float]
) -> None:
    """Torque against speed, with the motor's limits, which widen the view, so that one sees what is left of them."""
    for way, stroke in strokes.items():
        axes.plot(stroke.motor_speed, stroke.motor_torque, gid="curve", **_WAYS[way])
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    axes.axvline(0.0, color=FAINT, linewidth=0.5)
    axes.margins(0.08)
    style: dict[str, Any] = {
        "color": INK,
        "linewidth": 0.8,
        "linestyle": (0, (1.0, 1.2)),
        "gid": "limit",
    }
    torque, speed, power = (limits.get(name, 0.0) for name in _LIMITS)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    left, right = min(left, -1.12 * speed), max(right, 1.12 * speed)
    low, high = min(low, -1.12 * torque), max(high, 1.12 * torque)
    for sign, stop in ((1.0, right), (-1.0, left)):
        if speed:
            axes.axvline(sign * speed, **style)
        if torque:
            axes.axhline(sign * torque, **style)
        if power:
            turning = np.linspace(sign * power / high, stop, 200)
            axes.plot(turning, power / turning, **style)
    axes.set(
        title="Torque against speed",
        xlabel="motor speed (rad/s)",
        xlim=(left, right),
        ylim=(low, high),
    )


def _loop(axes: Axes, strokes: Mapping[str, Stroke]) -> None:
    """The loop against the spool's angle, so that its area is work."""
    for way, stroke in strokes.items():
        axes.plot(np.degrees(stroke.spool_angle), stroke.motor_torque, gid="curve", **_WAYS[way])
    if len(strokes) == 2:
        x, y = (
            np.concatenate([getattr(stroke, name) for stroke in strokes.values()])
            for name in ("spool_angle", "motor_torque")
        )
        known = np.isfinite(x) & np.isfinite(y)
        axes.fill(
            np.degrees(x[known]), y[known], color="#eceff2", linewidth=0.0, zorder=0.5, gid="loss"
        )
    stroke = next(iter(strokes.values()))
    for end in (0, -1):
        place = np.degrees(stroke.spool_angle[end]), stroke.motor_torque[end]
        axes.annotate(
            f"θ = {np.degrees(stroke.elbow_angle[end]):.3g}°", place, ha="center", size=6.5
        )
    axes.margins(0.12)
    axes.set(title="Hysteresis", xlabel="spool angle α (deg)")


def _turn(
    axes: Axes, turn: Array, torque: Array, follows: Mapping[str, tuple[float, float]]
) -> None:
    axes.plot(np.degrees(turn), torque, color=INK, gid="curve")
    for place, (side, (end, at)) in enumerate(sorted(follows.items(), key=lambda each: each[1])):
        axes.plot([np.degrees(end)], [at], "o", color=INK, markersize=4.0, gid="mark")
        axes.annotate(
            f"{side}, {np.degrees(end):.2f}°",
            (np.degrees(end), at),
            xytext=(4, 4 - 8 * (place > 0)),
            textcoords="offset points",
            va="top" if place else "bottom",
            size=6.5,
        )
    axes.margins(0.08, 0.12)
    axes.set_xlim(right=1.9 * float(np.degrees(turn[-1])))
    axes.set_xlabel("spool turned back (deg)")
