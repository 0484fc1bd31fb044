"""What the figure of a motor shows: a design's cycle at the study's speed, and the turn at its first state."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.plan import Plan
from tendon_cli.errors import UsageError
from tendon_cli.figures.motor import MotorFigure, Stroke, Turn, draw
from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.motor import motor_rates
from tendon_cli.model.reversal import reversal
from tendon_cli.state_page.lines import one

_POINTS = 721


def draw_motor(path: Path, design: Design, state: State, plan: Plan, *, loss: float | None, turns: bool) -> Path:
    """Draw a design's strokes where the study has a speed, and where `turns` the turn at the plan's first state.

    `loss` is what friction takes over the strokes (J). Raises OutputError, and UsageError where there is nothing to
    draw or for an ending that no figure has.
    """
    speed = plan.study.motion.speed
    if speed is None and not turns:
        hint = "--set 'motion.speed=60 deg/s', or --reversal"
        raise UsageError("the study has no speed, so there is no motor to draw", where="--plot", hint=hint)
    at = "" if speed is None else f", elbow at {np.degrees(speed.single):.6g} deg/s"
    given = MotorFigure(
        title=f"{plan.study.name}: the motor, load {one(design.load_mass):.6g} kg{at}",
        strokes={} if speed is None else {way: _stroke(design, plan, way, speed.single) for way in plan.directions},
        limits=dict(plan.study.limits),
        loss=np.nan if loss is None else loss,
        turn=_turn(design, state, plan) if turns else None,
    )
    return draw(given, path)


def _stroke(design: Design, plan: Plan, direction: str, speed: float) -> Stroke:
    """One way through the study's angles, finely."""
    flexion = direction == "flexion"
    angles = np.linspace(plan.elbow_angles.min(), plan.elbow_angles.max(), _POINTS)[:: 1 if flexion else -1]
    state = evaluate(design, angles[np.newaxis], np.array([[flexion]]))
    rates = motor_rates(design, state)

    def line(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.array(np.broadcast_to(values.reshape(-1), _POINTS))

    motor_speed = (speed if flexion else -speed) * rates.spool_speed
    return Stroke(angles, line(rates.spool_angle), line(motor_speed), line(state.motor_torque))


def _turn(design: Design, state: State, plan: Plan) -> Turn:
    turned = reversal(design, state, float(plan.elbow_angles[0]), np.asarray(plan.directions[0] == "flexion"))
    ends = {"flexor": one(turned.flexor.turn), "extensor": one(turned.extensor.turn)}
    path = 1.15 * max([end for end in ends.values() if end > 0.0] or [1e-3]) * np.linspace(0.0, 1.0, _POINTS)

    def torque(turn: float) -> float:
        return one(turned.motor_torque(np.asarray(turn)))

    return Turn(
        title=f"Turn from {plan.directions[0]} at {np.degrees(plan.elbow_angles[0]):.6g}°",
        spool_turn=path,
        motor_torque=np.array([torque(float(turn)) for turn in path]),
        follows={side: (end, torque(end)) for side, end in ends.items() if np.isfinite(end)},
    )
