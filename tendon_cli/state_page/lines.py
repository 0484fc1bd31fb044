"""Lines of a page that works a state out for a check by hand, section by section, and how they are printed."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Anchors, flexor_path
from tendon_cli.model.setting import all_readings, per_length, setting_of
from tendon_cli.model.statics import NO_EQUILIBRIUM


@dataclass(frozen=True)
class PageLine:
    """A line of the page: a symbol, how it comes about, its values (one, or flexor and extensor), unit and source."""

    symbol: str
    formula: str
    values: tuple[float, ...]
    unit: str
    source: str = ""

    @property
    def text(self) -> str:
        """The line in a terminal."""
        values = "  ".join(f"{value:>13.7g}" if not np.isnan(value) else f"{'-':>13}" for value in self.values)
        symbol, formula = (_padded(text, width) for text, width in ((self.symbol, 9), (self.formula, 42)))
        return f"  {symbol}{formula}{values:<29}{self.unit:<9}{self.source}".rstrip()


@dataclass(frozen=True)
class PageSection:
    """Lines under a heading."""

    title: str
    lines: tuple[PageLine, ...]


Row = tuple[str, str, npt.ArrayLike | tuple[npt.ArrayLike, ...], str] | tuple[str, str, object, str, str]
"""Symbol, formula, the values of a state (a tuple: of flexor and extensor), unit, and perhaps the source."""


def section(title: str, *rows: Row) -> PageSection:
    """Lines from rows."""
    lines = []
    for symbol, formula, values, *rest in rows:
        each = values if isinstance(values, tuple) else (values,)
        lines.append(PageLine(symbol, formula, tuple(map(one, each)), *map(str, rest)))
    return PageSection(title, tuple(lines))


def _padded(text: str, width: int) -> str:
    """Dots above letters take no room of their own."""
    return text.ljust(width + sum(1 for sign in text if unicodedata.combining(sign)))


def one(values: object) -> float:
    """The first of some values."""
    return float(np.asarray(values).reshape(-1)[0])


def null_if_nan(value: float) -> float | None:
    """As JSON has it."""
    return None if np.isnan(value) else value


def sections_of(state: State, angle: float, table: str) -> list[PageSection]:
    """A state from its geometry on, at an elbow angle in degrees; up to its load where it has no equilibrium.

    `table` is the file of measured travels, if they are.
    """
    design = state.inputs.design
    sections = [_geometry(state, design, angle, table), _sheath(state, design, angle), _load(state, design, angle)]
    if int(state.status.flat[0]) != NO_EQUILIBRIUM:
        sections += [_balance(state, design), _results(state, design), _setting(design)]
    return sections


def _geometry(state: State, design: Design, angle: float, table: str) -> PageSection:
    motion, joint, at = state.motion, design.arm.joint, float(np.radians(angle))
    theta: Row = ("θ", f"elbow angle, {angle:.6g} deg", at, "rad")
    if not isinstance(joint, Anchors):
        return section(
            "Geometry", theta,
            ("H_f", "shortening of the flexor's path", motion.flexor_travel, "m", table),
            ("H_e", "lengthening of the extensor's", motion.extensor_travel, "m", table),
            ("J_f", "dH_f/dθ of the same curve", motion.flexor_moment_arm, "m", "Eq. 5"),
            ("J_e", "dH_e/dθ of the same curve", motion.extensor_moment_arm, "m", "Eq. 5"),
        )  # fmt: skip
    return section(
        "Geometry",
        ("a1, b1", "proximal anchor of the flexor", (joint.a1, joint.b1), "m", "Fig. 2"),
        ("a2, b2", "distal anchor of the flexor", (joint.a2, joint.b2), "m", "Fig. 2"),
        theta,
        ("L_c", "distance between the anchors", flexor_path(joint, at), "m", "Eq. 1"),
        (
            "H_f",
            "L_c(0) - L_c" if np.any(joint.from_initial) else "(b1 + b2) - L_c",
            motion.flexor_travel,
            "m",
            "Eq. 2",
        ),
        ("H_e", "R_elb θ", motion.extensor_travel, "m", "Eq. 2"),
        ("J", "-dL_c/dθ", motion.flexor_moment_arm, "m", "Eq. 5"),
        ("R_elb", "moment arm of the extensor", motion.extensor_moment_arm, "m", "Fig. 2"),
    )


def _sheath(state: State, design: Design, angle: float) -> PageSection:
    sides, transmissions = (design.flexor, design.extensor), (state.flexor, state.extensor)
    exponents = tuple(one(side.friction) * one(side.bend(np.radians(angle))[0]) for side in sides)
    return section(
        "Sheath, tendon and spring (flexor, extensor)",
        ("μφ", "friction x bend angle", exponents, "1", "Eq. 6"),
        ("e^(σμφ)", "distal / proximal tension", tuple(t.capstan for t in transmissions), "1", "Eq. 6, A.17"),
        ("c_Ten", "L/(AE) (1 - e^(-σμφ))/(σμφ)", tuple(t.tendon for t in transmissions), "m/N", "Eq. 13"),
        ("1/K_SE", "series spring", tuple(t.spring for t in transmissions), "m/N", "Eq. 14"),
        ("c_f, c_e", "c_Ten + 1/K_SE", tuple(t.compliance for t in transmissions), "m/N", "Eq. 16"),
        ("F0", "pretension", tuple(side.pretension for side in sides), "N", "Eq. 13"),
    )


def _load(state: State, design: Design, angle: float) -> PageSection:
    arm = design.arm
    mass_moment = one(arm.forearm_mass) * one(arm.forearm_com) + one(design.load_mass) * one(arm.load_distance)
    other = one(state.inputs.other_torque)
    others = [("τ_o", "asked for by joint, task and inertia", other, "N m")] if other else []
    asked = f"M g sin(θ + ψ){' + τ_o' if other else ''}, g = 9.81"
    return section(
        "Load",
        ("M", "m_f d_com + m d_load", mass_moment, "kg m"),
        ("θ + ψ", "inclination of the forearm", np.radians(angle) + one(arm.upper_arm_angle), "rad"),
        *others,
        ("τ_a", asked, state.coupling.elbow_torque, "N m", "Eq. 5"),
    )


def _setting(design: Design) -> PageSection:
    """What gauges show of the pretension where it is set, and what a length of both tendons adds to it."""
    posture, pretension = design.setting, np.asarray(design.flexor.pretension)
    after = "flexion" if np.all(posture.after_flexion) else "extension"
    where = f"at {np.degrees(one(posture.angle)):.6g} deg, {one(posture.load_mass):.6g} kg, after {after}"
    if one(design.flexor.pretension) != one(design.extensor.pretension):
        pretension = setting_of(design).coupling.common_pretension(pretension, design.extensor.pretension)
    shown = all_readings(design, pretension)
    joint, motor = (tuple(shown[f"{side} at {end}"] for side in ("flexor", "extensor")) for end in ("joint", "motor"))
    return section(
        f"Setting {where} (flexor, extensor)",
        ("F_o,set", "tension at the joint", joint, "N"),
        ("F_I,set", "tension at the motor", motor, "N"),
        ("dF0/dl", "(1 + η)/(η c_f + c_e), both tendons", per_length(design), "N/m"),
    )


def _balance(state: State, design: Design) -> PageSection:
    tied, ratio = state.coupling, one(design.ratio)
    c_f, c_e, moment_arm = one(tied.flexor_compliance), one(tied.extensor_compliance), one(tied.moment_arm)
    radius, torque = one(tied.extensor_arm), one(tied.elbow_torque)
    preload = one(tied.mismatch) + ratio * c_f * one(design.flexor.pretension) + c_e * one(design.extensor.pretension)
    determinant = ratio * c_f * radius + moment_arm * c_e
    x_both = (c_e * torque + radius * preload) / determinant
    y_both = (moment_arm * preload - ratio * c_f * torque) / determinant
    rule = "max(y_b, 0, -τ_a/R_elb)" if np.all(design.unilateral) else "y_b (bilateral: may be negative)"
    return section(
        "Balance of elbow and spool",
        ("η", "R_e / R_f", ratio, "1", "Eq. 12"),
        ("h", "H_e - η H_f", tied.mismatch, "m", "Eq. 12"),
        ("D", "h + η c_f F0_f + c_e F0_e", preload, "m", "Eq. 16"),
        ("Δ", "η c_f R_elb + J c_e", determinant, "m²/N"),
        ("x_b", "(c_e τ_a + R_elb D) / Δ", x_both, "N", "Eqs. 5, 16"),
        ("y_b", "(J D - η c_f τ_a) / Δ", y_both, "N", "Eqs. 5, 16"),
        ("y", rule, state.balance.extensor, "N"),
        ("x", "(τ_a + R_elb y) / J", state.balance.flexor, "N", "Eq. 5"),
        ("σ", "η c_f x + c_e y - D, path that is loose", state.balance.loose, "m"),
    )


def _results(state: State, design: Design) -> PageSection:
    distal = (one(state.balance.flexor), one(state.balance.extensor))
    changes = (distal[0] - one(design.flexor.pretension), distal[1] - one(design.extensor.pretension))
    paired = list(zip((state.flexor, state.extensor), changes, strict=True))
    results = section(
        "Results",
        ("F_o", "distal tension, flexor and extensor", distal, "N", "Eq. 5"),
        ("F_I", "F_o / e^(σμφ), at the motor", (state.flexor_tension_proximal, state.extensor_tension_proximal), "N",
         "Eq. 6"),
        ("ΔL_Ten", "c_Ten (F_o - F0)", tuple(one(side.tendon) * change for side, change in paired), "m", "Eq. 13"),
        ("ΔL_SE", "(F_o - F0) / K_SE", tuple(one(side.spring) * change for side, change in paired), "m", "Eq. 14"),
        ("τ_m", "(F_I^f - η F_I^e) R_f", state.motor_torque, "N m", "Eq. 17"),
        ("α", "spool angle", state.spool_angle, "rad", "Eq. 2"),
        ("s", "slack of flexor and extensor", (state.flexor_slack, state.extensor_slack), "m"),
        ("k", "elbow stiffness, motor held", state.elbow_stiffness, "N m/rad"),
    )  # fmt: skip
    return PageSection("Results", tuple(line for line in results.lines if not all(np.isnan(line.values))))
