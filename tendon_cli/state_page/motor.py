"""What motor and transmission do in a state, over the cycle and where the motion turns, line by line."""

from __future__ import annotations

import numpy as np

from tendon_cli.engine.plan import Plan
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.motor import cycle, motor_rates
from tendon_cli.model.reversal import reversal
from tendon_cli.quantities import OF_CYCLES, QUANTITIES
from tendon_cli.state_page.lines import PageSection, null_if_nan, one, section


def motor_section(design: Design, state: State, speed: float, *, flexion: bool) -> PageSection:
    """Speed and powers of one state; `speed` is that of the elbow, rad/s."""
    rates = motor_rates(design, state)
    moving = speed if flexion else -speed
    return section(
        f"Motor at {_per_second(speed)} of the elbow (slack sides left out)",
        ("θ̇", "speed of the elbow", moving, "rad/s"),
        ("dα/dθ", "k / (R_f (J/c_f + η R_elb/c_e))", rates.spool_speed, "1"),
        ("α̇", "dα/dθ θ̇, speed of the motor", one(rates.spool_speed) * moving, "rad/s"),
        ("P_m", "τ_m α̇, below 0 the motor brakes", one(rates.power) * moving, "W"),
        ("P_a", "τ_a θ̇, at the elbow", one(state.elbow_torque) * moving, "W"),
        ("P_U", "into tendons and springs", one(rates.storing) * moving, "W"),
        ("P_μ", "friction along both sheaths", one(rates.friction) * moving, "W"),
    )


def cycle_results(design: Design, plan: Plan, speed: float) -> dict[str, float | None]:
    """The columns of designs that a speed adds, over the study's angles and directions."""
    flexion = np.array([[direction == "flexion"] for direction in plan.directions])
    over = cycle(design, plan.elbow_angles[np.newaxis], flexion, speed)
    return {name: null_if_nan(one(getattr(over, name))) for name in OF_CYCLES}


def cycle_section(results: dict[str, float | None], speed: float) -> PageSection:
    """The same as lines."""
    rows = [
        (QUANTITIES[name].symbol, name, np.nan if value is None else value, QUANTITIES[name].unit)
        for name, value in results.items()
    ]
    return section(f"Over the study's angles and directions at {_per_second(speed)}", *rows)


def reversal_section(design: Design, state: State, elbow_angle: float, *, flexion: bool) -> PageSection:
    """What it takes until both far ends follow where the motion turns back at this state (flexor, extensor)."""
    turn = reversal(design, state, elbow_angle, np.asarray(flexion))
    sides = (turn.flexor, turn.extensor)
    turns = np.array([one(side.turn) for side in sides])
    torques = tuple(one(turn.motor_torque(end)) for end in (np.zeros(1), *np.sort(turns[~np.isnan(turns)])))
    return section(
        "Where the motion turns back here (elbow still; flexor, extensor)",
        ("F_I", "at the motor as the motion stops", tuple(side.tension_before for side in sides), "N"),
        ("F_I'", "F_I e^(2σμφ), as the far end follows", tuple(side.tension_after for side in sides), "N"),
        ("δ", "F_o |c_Ten - c_Ten'|, stretch until then", tuple(side.stretch for side in sides), "m"),
        ("Δα", "δ/R_f, δ/(η R_f), turn until then", tuple(turns.tolist()), "rad"),
        ("W_μ", "what friction takes until then", tuple(side.loss for side in sides), "J"),
        ("τ_m'", "motor torque as the motion stops", torques[:1], "N m"),
        ("τ_m''", "as the first, and the second end follows", torques[1:], "N m"),
    )


def _per_second(speed: float) -> str:
    return f"{np.degrees(speed):.6g} deg/s"
