"""The lines of a state's page as data, section by section, for a check by hand."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.engine.plan import Block, Plan
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Anchors, flexor_path
from tendon_cli.model.motor import cycle_columns, motor_rates
from tendon_cli.model.moving import Moving, motion_columns
from tendon_cli.model.reversal import reversal
from tendon_cli.model.setting import all_readings, pretension_per_length, setting_of
from tendon_cli.model.statics import NO_EQUILIBRIUM
from tendon_cli.quantities import OF_CYCLES, OF_TRAJECTORIES, QUANTITIES, SIDES

_SYMBOL_WIDTH = 9
_FORMULA_WIDTH = 42


@dataclass(frozen=True)
class PageLine:
    """A line of the page."""

    section: str
    symbol: str
    formula: str
    """Formula of the value, or what it is in words."""
    values: tuple[float, ...]
    """One value, or one each of flexor and extensor; in `unit`."""
    unit: str
    source: str = ""
    """Equation, figure or file that the line is taken from."""

    @property
    def text(self) -> str:
        """The line in a terminal."""
        values = "  ".join(map(_value_text, self.values))
        symbol = _pad(self.symbol, _SYMBOL_WIDTH)
        formula = _pad(self.formula, _FORMULA_WIDTH)
        return f"  {symbol}{formula}{values:<29}{self.unit:<9}{self.source}".rstrip()


def _value_text(value: float) -> str:
    """Write a value; a dash stands for NaN."""
    return f"{'-':>13}" if np.isnan(value) else f"{value:>13.7g}"


def _pad(text: str, width: int) -> str:
    """Pad a text to a width; dots above letters take no room."""
    return text.ljust(width + sum(1 for sign in text if unicodedata.combining(sign)))


def section(title: str, *rows: tuple[Any, ...]) -> list[PageLine]:
    """Return the lines of a section.

    Args:
        title: Title of the section.
        *rows: Symbol, formula, value of the state (a tuple for flexor and extensor), unit and, if
            there is one, source.
    """
    lines = []
    for symbol, formula, values, *rest in rows:
        parts = values if isinstance(values, tuple) else (values,)
        lines.append(PageLine(title, symbol, formula, tuple(map(scalar, parts)), *rest))
    return lines


def scalar(values: object) -> float:
    """Return the first value of an array, or the number itself."""
    return float(np.asarray(values).reshape(-1)[0])


def state_lines(state: State, angle: float, table: str) -> list[PageLine]:
    """Return the lines of a state, from geometry to setting.

    If it has no equilibrium, they end with the load.

    Args:
        state: The state.
        angle: Elbow angle, rad.
        table: File of the measured travels, if the joint is given by them.
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
    """Return lines of travels and moment arms, from anchors (Fig. 2) or from measured travels."""
    motion = state.motion
    joint = design.arm.joint
    theta = ("θ", f"elbow angle, {say.quantity('elbow_angle', angle, 6)}", angle, "rad")
    if not isinstance(joint, Anchors):
        return section(
            "Geometry",
            theta,
            ("H_f", "shortening of the flexor's path", motion.flexor_travel, "m", table),
            ("H_e", "lengthening of the extensor's path", motion.extensor_travel, "m", table),
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
    """Return lines of friction, compliance and pretension of both tendons."""
    flexor = state.flexor
    extensor = state.extensor
    sides = (design.flexor, design.extensor)
    exponents = tuple(side.friction * side.bend(angle)[0] for side in sides)
    capstans = (flexor.capstan, extensor.capstan)
    tendons = (flexor.tendon, extensor.tendon)
    springs = (flexor.spring, extensor.spring)
    compliances = (flexor.compliance, extensor.compliance)
    pretensions = (design.flexor.pretension, design.extensor.pretension)
    return section(
        "Sheath, tendon and spring (flexor, extensor)",
        ("μφ", "friction x bend angle", exponents, "1", "Eq. 6"),
        ("e^(σμφ)", "distal / proximal tension", capstans, "1", "Eq. 6, A.17"),
        ("c_Ten", "L/(AE) (1 - e^(-σμφ))/(σμφ)", tendons, "m/N", "Eq. 13"),
        ("1/K_SE", "series spring", springs, "m/N", "Eq. 14"),
        ("c_f, c_e", "c_Ten + 1/K_SE", compliances, "m/N", "Eq. 16"),
        ("F0", "pretension", pretensions, "N", "Eq. 13"),
    )


def _load(state: State, design: Design, angle: float) -> list[PageLine]:
    """Return lines of the elbow torque that the load asks for (Eq. 5)."""
    arm = design.arm
    forearm_moment = scalar(arm.forearm_mass) * scalar(arm.forearm_com)
    load_moment = scalar(design.load_mass) * scalar(arm.load_distance)
    inclination = angle + scalar(arm.upper_arm_angle)
    rows: list[tuple[Any, ...]] = [
        ("M", "m_f d_com + m d_load", forearm_moment + load_moment, "kg m"),
        ("θ + ψ", "inclination of the forearm", inclination, "rad"),
    ]
    formula = "M g sin(θ + ψ), g = 9.81"
    other = scalar(state.other_torque)
    if other:
        rows.append(("τ_o", "for the joint, the task and inertia", other, "N m"))
        formula = "M g sin(θ + ψ) + τ_o, g = 9.81"
    rows.append(("τ_a", formula, state.coupling.elbow_torque, "N m", "Eq. 5"))
    return section("Load", *rows)


def _balance(state: State, design: Design) -> list[PageLine]:
    """Return lines of the balance (Eqs. 5, 16): tensions x of the flexor and y of the extensor."""
    coupling = state.coupling
    balance = state.balance
    ratio = scalar(design.ratio)
    c_f = scalar(coupling.flexor_compliance)
    c_e = scalar(coupling.extensor_compliance)
    moment_arm = scalar(coupling.moment_arm)
    radius = scalar(coupling.extensor_arm)
    torque = scalar(coupling.elbow_torque)
    preload = (
        scalar(coupling.mismatch)
        + ratio * c_f * scalar(design.flexor.pretension)
        + c_e * scalar(design.extensor.pretension)
    )
    determinant = ratio * c_f * radius + moment_arm * c_e
    x_both = (c_e * torque + radius * preload) / determinant
    y_both = (moment_arm * preload - ratio * c_f * torque) / determinant
    rule = "y_b (bilateral: may be negative)"
    if np.all(design.unilateral):
        rule = "max(y_b, 0, -τ_a/R_elb)"
    return section(
        "Balance of elbow and spool",
        ("η", "R_e / R_f", ratio, "1", "Eq. 12"),
        ("h", "H_e - η H_f", coupling.mismatch, "m", "Eq. 12"),
        ("D", "h + η c_f F0_f + c_e F0_e", preload, "m", "Eq. 16"),
        ("Δ", "η c_f R_elb + J c_e", determinant, "m²/N"),
        ("x_b", "(c_e τ_a + R_elb D) / Δ", x_both, "N", "Eqs. 5, 16"),
        ("y_b", "(J D - η c_f τ_a) / Δ", y_both, "N", "Eqs. 5, 16"),
        ("y", rule, balance.extensor, "N"),
        ("x", "(τ_a + R_elb y) / J", balance.flexor, "N", "Eq. 5"),
        ("σ", "η c_f x + c_e y - D, loose length", balance.loose, "m"),
    )


def _results(state: State, design: Design) -> list[PageLine]:
    """Return lines of the results of a state; those that are NaN are left out."""
    distal = (state.balance.flexor, state.balance.extensor)
    proximal = (state.flexor_tension_proximal, state.extensor_tension_proximal)
    slack = (state.flexor_slack, state.extensor_slack)
    flexor_change = scalar(distal[0]) - scalar(design.flexor.pretension)
    extensor_change = scalar(distal[1]) - scalar(design.extensor.pretension)
    tendons = (
        scalar(state.flexor.tendon) * flexor_change,
        scalar(state.extensor.tendon) * extensor_change,
    )
    springs = (
        scalar(state.flexor.spring) * flexor_change,
        scalar(state.extensor.spring) * extensor_change,
    )
    lines = section(
        "Results",
        ("F_o", "distal tension, flexor and extensor", distal, "N", "Eq. 5"),
        ("F_I", "F_o / e^(σμφ), at the motor", proximal, "N", "Eq. 6"),
        ("ΔL_Ten", "c_Ten (F_o - F0)", tendons, "m", "Eq. 13"),
        ("ΔL_SE", "(F_o - F0) / K_SE", springs, "m", "Eq. 14"),
        ("τ_m", "(F_I^f - η F_I^e) R_f", state.motor_torque, "N m", "Eq. 17"),
        ("α", "spool angle", state.spool_angle, "rad", "Eq. 2"),
        ("s", "slack of flexor and extensor", slack, "m"),
        ("k", "elbow stiffness, motor held", state.elbow_stiffness, "N m/rad"),
    )
    return [line for line in lines if not all(np.isnan(line.values))]


def _setting(design: Design) -> list[PageLine]:
    """Return lines of the tensions that gauges show where the pretension is set.

    The last line is the pretension gained per length by which both tendons are shortened.
    """
    posture = design.setting
    pretension = np.asarray(design.flexor.pretension)
    if scalar(design.flexor.pretension) != scalar(design.extensor.pretension):
        coupling = setting_of(design).coupling
        pretension = coupling.common_pretension(pretension, design.extensor.pretension)
    readings = all_readings(design, pretension)
    joint = tuple(readings[f"{side} at joint"] for side in SIDES)
    motor = tuple(readings[f"{side} at motor"] for side in SIDES)
    angle = say.quantity("elbow_angle", scalar(posture.angle), 6)
    load = say.quantity("load_mass", scalar(posture.load_mass), 6)
    after = "flexion" if np.all(posture.after_flexion) else "extension"
    where = f"at {angle}, {load}, after {after}"
    return section(
        f"Setting {where} (flexor, extensor)",
        ("F_o,set", "tension at the joint", joint, "N"),
        ("F_I,set", "tension at the motor", motor, "N"),
        ("dF0/dl", "(1 + η)/(η c_f + c_e), both tendons", pretension_per_length(design), "N/m"),
    )


# --- The state on the page ------------------------------------------------------------------------


def place_text(plan: Plan, block: Block) -> str:
    """Return where the state of a block stands: direction and angle, and the time of a motion."""
    place = block.angles.start
    angle = say.quantity("elbow_angle", plan.elbow_angles[place], 6)
    trajectory = plan.study.trajectory
    if trajectory is None:
        return f"{plan.directions[0]} at {angle}"
    direction = "flexion" if trajectory.is_flexing[place] else "extension"
    return f"{say.quantity('time', trajectory.time[place], 6)}, {direction} at {angle}"


def slides_in_flexion(plan: Plan, state: State) -> bool:
    """Return True if the tendons of a single state slide as in flexion."""
    if state.sliding is None:
        return plan.directions[0] == "flexion"
    return bool(np.ravel(state.sliding.flexion)[0])


# --- Motor and transmission -----------------------------------------------------------------------


def motor_lines(state: State, speed: float, *, flexion: bool) -> list[PageLine]:
    """Return lines of speed and power at one state; `speed` is that of the elbow, rad/s."""
    rates = motor_rates(state)
    moving = speed if flexion else -speed
    return section(
        f"Motor at {_per_second(speed)} of the elbow (slack sides left out)",
        ("θ̇", "speed of the elbow", moving, "rad/s"),
        ("dα/dθ", "k / (R_f (J/c_f + η R_elb/c_e))", rates.spool_speed, "1"),
        ("α̇", "dα/dθ θ̇, speed of the motor", rates.spool_speed * moving, "rad/s"),
        ("P_m", "τ_m α̇, below 0 the motor brakes", rates.power * moving, "W"),
        ("P_a", "τ_a θ̇, at the elbow", state.elbow_torque * moving, "W"),
        ("P_U", "into tendons and springs", rates.storage_rate * moving, "W"),
        ("P_μ", "friction along both sheaths", rates.friction * moving, "W"),
    )


def moving_lines(state: State, time: float) -> list[PageLine]:
    """Return lines of speed, power and sliding at one state of a motion in time; `time` in s."""
    rates = motor_rates(state)
    speed = np.asarray(0.0 if state.rates is None else state.rates.speed)
    formula = "speed of the motor, springs stretching"
    lines = section(
        f"Motor at {say.quantity('time', time, 6)} (slack sides left out)",
        ("θ̇", "speed of the elbow", speed, "rad/s"),
        ("α̇", formula, rates.spool_speed, "rad/s"),
        ("P_m", "τ_m α̇, below 0 the motor brakes", rates.power, "W"),
        ("P_a", "τ_a θ̇, at the elbow", state.elbow_torque * speed, "W"),
        ("P_U", "into tendons and springs", rates.storage_rate, "W"),
        ("P_μ", "friction along both sheaths", rates.friction, "W"),
    )
    if state.sliding is not None:
        title = lines[0].section
        way = 1.0 if np.ravel(state.sliding.flexion)[0] else -1.0
        lines += section(title, ("s", "tendons slide: 1 as in flexion, else -1", way, "1"))
        if np.ravel(state.sliding.turning)[0]:
            other = state.sliding.other_torque
            lines += section(title, ("τ_m'", "turning: torque between τ_m and this", other, "N m"))
    return lines


def motion_lines(moving: Moving) -> list[PageLine]:
    """Return lines of the results of a single design over its motion in time."""
    totals = motion_columns(moving)
    rows = []
    for name in (*OF_CYCLES, *OF_TRAJECTORIES):
        quantity = QUANTITIES[name]
        symbol = quantity.symbol if len(quantity.symbol) < _SYMBOL_WIDTH else ""
        rows.append((symbol, name, totals[name], quantity.unit))
    counted = moving.trajectory.time[moving.trajectory.counted]
    start, end = (say.quantity("time", time, 6) for time in (counted[0], counted[-1]))
    lines = section(f"Over the motion from {start} to {end}", *rows)
    return [line for line in lines if not all(np.isnan(line.values))]


def cycle_lines(design: Design, plan: Plan, speed: float) -> list[PageLine]:
    """Return lines of the results of a design that need a speed, over all angles and directions.

    `speed` is that of the elbow, rad/s.
    """
    flexion = np.array([[direction == "flexion"] for direction in plan.directions])
    totals = cycle_columns(design, plan.elbow_angles[np.newaxis], flexion, speed)
    rows = []
    for name in OF_CYCLES:
        quantity = QUANTITIES[name]
        rows.append((quantity.symbol, name, totals[name], quantity.unit))
    return section(f"Over the study's angles and directions at {_per_second(speed)}", *rows)


def reversal_lines(state: State, elbow_angle: float, *, flexion: bool) -> list[PageLine]:
    """Return lines of the motor's turn until both far ends follow, if the motion turns back here.

    Most values are a pair: flexor and extensor.

    Args:
        state: The state at which the motion turns back.
        elbow_angle: Elbow angle, rad.
        flexion: True if the motion was flexion.
    """
    turned = reversal(state, elbow_angle, np.asarray(flexion))
    sides = (turned.flexor, turned.extensor)
    before = tuple(side.tension_before for side in sides)
    after = tuple(side.tension_after for side in sides)
    stretches = tuple(side.stretch for side in sides)
    losses = tuple(side.loss for side in sides)
    turns = np.array([scalar(side.turn) for side in sides])
    follows = np.sort(turns[~np.isnan(turns)])
    at_start = turned.motor_torque(np.zeros(1))
    at_follows = tuple(turned.motor_torque(turn) for turn in follows)
    return section(
        "Where the motion turns back here (elbow still; flexor, extensor)",
        ("F_I", "at the motor as the motion stops", before, "N"),
        ("F_I'", "F_I e^(2σμφ), as the far end follows", after, "N"),
        ("δ", "F_o |c_Ten - c_Ten'|, stretch until then", stretches, "m"),
        ("Δα", "δ/R_f, δ/(η R_f), turn until then", tuple(turns), "rad"),
        ("W_μ", "lost to friction until then", losses, "J"),
        ("τ_m'", "motor torque as the motion stops", at_start, "N m"),
        ("τ_m''", "as the first and the second end follow", at_follows, "N m"),
    )


def _per_second(speed: float) -> str:
    """Write a speed given in rad/s."""
    return say.quantity("elbow_speed", speed, 6)
