"""A state worked out for a check by hand: the lines of its page as data, section by section."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.engine.plan import Plan
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Anchors, flexor_path
from tendon_cli.model.motor import cycle, motor_rates
from tendon_cli.model.reversal import reversal
from tendon_cli.model.setting import all_readings, per_length, setting_of
from tendon_cli.model.statics import NO_EQUILIBRIUM
from tendon_cli.quantities import OF_CYCLES, QUANTITIES
from tendon_cli.space.axis import SIDES


@dataclass(frozen=True)
class PageLine:
    """A line of the page: a symbol, how it comes about, its values (one, or flexor and extensor), unit and source."""

    section: str
    symbol: str
    formula: str
    values: tuple[float, ...]
    unit: str
    source: str = ""

    @property
    def text(self) -> str:
        """The line in a terminal."""
        values = "  ".join(
            f"{value:>13.7g}" if not np.isnan(value) else f"{'-':>13}" for value in self.values
        )
        symbol, formula = (
            _padded(text, width) for text, width in ((self.symbol, 9), (self.formula, 42))
        )
        return f"  {symbol}{formula}{values:<29}{self.unit:<9}{self.source}".rstrip()


def _padded(text: str, width: int) -> str:
    """Dots above letters take no room."""
    return text.ljust(width + sum(1 for sign in text if unicodedata.combining(sign)))


def section(title: str, *rows: tuple[Any, ...]) -> list[PageLine]:
    """Lines from rows: symbol, formula, a value of the state (a tuple: of flexor and extensor), unit, source if any."""
    lines = []
    for symbol, formula, values, *rest in rows:
        each = values if isinstance(values, tuple) else (values,)
        lines.append(PageLine(title, symbol, formula, tuple(map(one, each)), *rest))
    return lines


def one(values: object) -> float:
    """The first of some values."""
    return float(np.asarray(values).reshape(-1)[0])


def state_lines(state: State, angle: float, table: str) -> list[PageLine]:
    """A state from its geometry on, at an elbow angle in rad; up to its load if it has no equilibrium.

    `table` is the file of measured travels, if they are.
    """
    design = state.design
    lines = [
        *_geometry(state, design, angle, table),
        *_sheath(state, design, angle),
        *_load(state, design, angle),
    ]
    if int(state.status.flat[0]) == NO_EQUILIBRIUM:
        return lines
    return [*lines, *_balance(state, design), *_results(state, design), *_setting(design)]


def _geometry(state: State, design: Design, angle: float, table: str) -> list[PageLine]:
    motion, joint = state.motion, design.arm.joint
    theta = ("θ", f"elbow angle, {np.degrees(angle):.6g} deg", angle, "rad")
    if not isinstance(joint, Anchors):
        return section(
            "Geometry",
            theta,
            ("H_f", "shortening of the flexor's path", motion.flexor_travel, "m", table),
            ("H_e", "lengthening of the extensor's", motion.extensor_travel, "m", table),
            ("J_f", "dH_f/dθ of the same curve", motion.flexor_moment_arm, "m", "Eq. 5"),
            ("J_e", "dH_e/dθ of the same curve", motion.extensor_moment_arm, "m", "Eq. 5"),
        )
    travel = "L_c(0) - L_c" if np.any(joint.from_initial) else "(b1 + b2) - L_c"
    return section(
        "Geometry",
        ("a1, b1", "proximal anchor of the flexor", (joint.a1, joint.b1), "m", "Fig. 2"),
        ("a2, b2", "distal anchor of the flexor", (joint.a2, joint.b2), "m", "Fig. 2"),
        theta,
        ("L_c", "distance between the anchors", flexor_path(joint, angle), "m", "Eq. 1"),
        ("H_f", travel, motion.flexor_travel, "m", "Eq. 2"),
        ("H_e", "R_elb θ", motion.extensor_travel, "m", "Eq. 2"),
        ("J", "-dL_c/dθ", motion.flexor_moment_arm, "m", "Eq. 5"),
        ("R_elb", "moment arm of the extensor", motion.extensor_moment_arm, "m", "Fig. 2"),
    )


def _sheath(state: State, design: Design, angle: float) -> list[PageLine]:
    flexor, extensor, sides = state.flexor, state.extensor, (design.flexor, design.extensor)
    exponents = tuple(side.friction * side.bend(angle)[0] for side in sides)
    return section(
        "Sheath, tendon and spring (flexor, extensor)",
        ("μφ", "friction x bend angle", exponents, "1", "Eq. 6"),
        (
            "e^(σμφ)",
            "distal / proximal tension",
            (flexor.capstan, extensor.capstan),
            "1",
            "Eq. 6, A.17",
        ),
        ("c_Ten", "L/(AE) (1 - e^(-σμφ))/(σμφ)", (flexor.tendon, extensor.tendon), "m/N", "Eq. 13"),
        ("1/K_SE", "series spring", (flexor.spring, extensor.spring), "m/N", "Eq. 14"),
        ("c_f, c_e", "c_Ten + 1/K_SE", (flexor.compliance, extensor.compliance), "m/N", "Eq. 16"),
        ("F0", "pretension", tuple(side.pretension for side in sides), "N", "Eq. 13"),
    )


def _load(state: State, design: Design, angle: float) -> list[PageLine]:
    arm, other = design.arm, one(state.other_torque)
    mass_moment = one(arm.forearm_mass) * one(arm.forearm_com) + one(design.load_mass) * one(
        arm.load_distance
    )
    others = [("τ_o", "asked for by joint, task and inertia", other, "N m")] if other else []
    return section(
        "Load",
        ("M", "m_f d_com + m d_load", mass_moment, "kg m"),
        ("θ + ψ", "inclination of the forearm", angle + one(arm.upper_arm_angle), "rad"),
        *others,
        (
            "τ_a",
            f"M g sin(θ + ψ){' + τ_o' if other else ''}, g = 9.81",
            state.coupling.elbow_torque,
            "N m",
            "Eq. 5",
        ),
    )


def _balance(state: State, design: Design) -> list[PageLine]:
    tied, ratio = state.coupling, one(design.ratio)
    c_f, c_e, moment_arm = (
        one(tied.flexor_compliance),
        one(tied.extensor_compliance),
        one(tied.moment_arm),
    )
    radius, torque = one(tied.extensor_arm), one(tied.elbow_torque)
    preload = (
        one(tied.mismatch)
        + ratio * c_f * one(design.flexor.pretension)
        + c_e * one(design.extensor.pretension)
    )
    determinant = ratio * c_f * radius + moment_arm * c_e
    rule = (
        "max(y_b, 0, -τ_a/R_elb)"
        if np.all(design.unilateral)
        else "y_b (bilateral: may be negative)"
    )
    return section(
        "Balance of elbow and spool",
        ("η", "R_e / R_f", ratio, "1", "Eq. 12"),
        ("h", "H_e - η H_f", tied.mismatch, "m", "Eq. 12"),
        ("D", "h + η c_f F0_f + c_e F0_e", preload, "m", "Eq. 16"),
        ("Δ", "η c_f R_elb + J c_e", determinant, "m²/N"),
        (
            "x_b",
            "(c_e τ_a + R_elb D) / Δ",
            (c_e * torque + radius * preload) / determinant,
            "N",
            "Eqs. 5, 16",
        ),
        (
            "y_b",
            "(J D - η c_f τ_a) / Δ",
            (moment_arm * preload - ratio * c_f * torque) / determinant,
            "N",
            "Eqs. 5, 16",
        ),
        ("y", rule, state.balance.extensor, "N"),
        ("x", "(τ_a + R_elb y) / J", state.balance.flexor, "N", "Eq. 5"),
        ("σ", "η c_f x + c_e y - D, path that is loose", state.balance.loose, "m"),
    )


def _results(state: State, design: Design) -> list[PageLine]:
    distal, sides = (state.balance.flexor, state.balance.extensor), (state.flexor, state.extensor)
    proximal = state.flexor_tension_proximal, state.extensor_tension_proximal
    change = [
        one(distal[0]) - one(design.flexor.pretension),
        one(distal[1]) - one(design.extensor.pretension),
    ]
    tendons = tuple(one(side.tendon) * by for side, by in zip(sides, change, strict=True))
    springs = tuple(one(side.spring) * by for side, by in zip(sides, change, strict=True))
    lines = section(
        "Results",
        ("F_o", "distal tension, flexor and extensor", distal, "N", "Eq. 5"),
        ("F_I", "F_o / e^(σμφ), at the motor", proximal, "N", "Eq. 6"),
        ("ΔL_Ten", "c_Ten (F_o - F0)", tendons, "m", "Eq. 13"),
        ("ΔL_SE", "(F_o - F0) / K_SE", springs, "m", "Eq. 14"),
        ("τ_m", "(F_I^f - η F_I^e) R_f", state.motor_torque, "N m", "Eq. 17"),
        ("α", "spool angle", state.spool_angle, "rad", "Eq. 2"),
        ("s", "slack of flexor and extensor", (state.flexor_slack, state.extensor_slack), "m"),
        ("k", "elbow stiffness, motor held", state.elbow_stiffness, "N m/rad"),
    )
    return [line for line in lines if not all(np.isnan(line.values))]


def _setting(design: Design) -> list[PageLine]:
    """What gauges show of the pretension where it is set, and what a length of both tendons adds to it."""
    posture, pretension = design.setting, np.asarray(design.flexor.pretension)
    after = "flexion" if np.all(posture.after_flexion) else "extension"
    where = f"at {np.degrees(one(posture.angle)):.6g} deg, {one(posture.load_mass):.6g} kg, after {after}"
    if one(design.flexor.pretension) != one(design.extensor.pretension):
        pretension = setting_of(design).coupling.common_pretension(
            pretension, design.extensor.pretension
        )
    shown = all_readings(design, pretension)
    joint, motor = (
        tuple(shown[f"{side} at {end}"] for side in SIDES) for end in ("joint", "motor")
    )
    return section(
        f"Setting {where} (flexor, extensor)",
        ("F_o,set", "tension at the joint", joint, "N"),
        ("F_I,set", "tension at the motor", motor, "N"),
        ("dF0/dl", "(1 + η)/(η c_f + c_e), both tendons", per_length(design), "N/m"),
    )


# --- Motor and transmission ------------------------------------------------------------------------------------------


def motor_lines(state: State, speed: float, *, flexion: bool) -> list[PageLine]:
    """Speed and powers of one state; `speed` is that of the elbow, rad/s."""
    rates, moving = motor_rates(state), speed if flexion else -speed
    return section(
        f"Motor at {_per_second(speed)} of the elbow (slack sides left out)",
        ("θ̇", "speed of the elbow", moving, "rad/s"),
        ("dα/dθ", "k / (R_f (J/c_f + η R_elb/c_e))", rates.spool_speed, "1"),
        ("α̇", "dα/dθ θ̇, speed of the motor", rates.spool_speed * moving, "rad/s"),
        ("P_m", "τ_m α̇, below 0 the motor brakes", rates.power * moving, "W"),
        ("P_a", "τ_a θ̇, at the elbow", state.elbow_torque * moving, "W"),
        ("P_U", "into tendons and springs", rates.storing * moving, "W"),
        ("P_μ", "friction along both sheaths", rates.friction * moving, "W"),
    )


def cycle_lines(design: Design, plan: Plan, speed: float) -> list[PageLine]:
    """The columns of designs that a speed adds, over the study's angles and directions."""
    flexion = np.array([[direction == "flexion"] for direction in plan.directions])
    over = cycle(design, plan.elbow_angles[np.newaxis], flexion, speed)
    rows = [
        (QUANTITIES[name].symbol, name, over[name], QUANTITIES[name].unit) for name in OF_CYCLES
    ]
    return section(f"Over the study's angles and directions at {_per_second(speed)}", *rows)


def reversal_lines(state: State, elbow_angle: float, *, flexion: bool) -> list[PageLine]:
    """What it takes until both far ends follow where the motion turns back at this state (flexor, extensor)."""
    turn = reversal(state, elbow_angle, np.asarray(flexion))
    sides = (turn.flexor, turn.extensor)
    turns = np.array([one(side.turn) for side in sides])
    torques = tuple(
        turn.motor_torque(end) for end in (np.zeros(1), *np.sort(turns[~np.isnan(turns)]))
    )
    return section(
        "Where the motion turns back here (elbow still; flexor, extensor)",
        (
            "F_I",
            "at the motor as the motion stops",
            tuple(side.tension_before for side in sides),
            "N",
        ),
        (
            "F_I'",
            "F_I e^(2σμφ), as the far end follows",
            tuple(side.tension_after for side in sides),
            "N",
        ),
        (
            "δ",
            "F_o |c_Ten - c_Ten'|, stretch until then",
            tuple(side.stretch for side in sides),
            "m",
        ),
        ("Δα", "δ/R_f, δ/(η R_f), turn until then", tuple(turns), "rad"),
        ("W_μ", "what friction takes until then", tuple(side.loss for side in sides), "J"),
        ("τ_m'", "motor torque as the motion stops", torques[:1], "N m"),
        ("τ_m''", "as the first, and the second end follows", torques[1:], "N m"),
    )


def _per_second(speed: float) -> str:
    return f"{np.degrees(speed):.6g} deg/s"
