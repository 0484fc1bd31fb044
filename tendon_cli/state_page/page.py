"""One state worked out line by line, with the equations' numbers, so that it can be checked by hand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.errors import UsageError
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.statics import NO_EQUILIBRIUM, STATUS_NAMES
from tendon_cli.quantities import QUANTITIES
from tendon_cli.state_page.lines import PageLine, PageSection, null_if_nan, one
from tendon_cli.state_page.motor import cycle_results, cycle_section, motor_section, reversal_section
from tendon_cli.study.fields import nearest
from tendon_cli.study.people.person import Step, Worn, worn_by
from tendon_cli.study.study import CASE_AXIS, Study
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Block, Plan
from tendon_cli.units import shorten


@dataclass(frozen=True)
class StatePage:
    """The whole page, and the same numbers by the names of the table columns."""

    title: str
    notes: tuple[str, ...]
    status: str
    sections: tuple[PageSection, ...]
    columns: dict[str, float | None]
    has_equilibrium: bool = True

    def text(self) -> str:
        """The page for a terminal."""
        parts = [self.title, *(f"  ({note})" for note in self.notes)]
        for section in self.sections:
            parts += ["", section.title, *(line.text for line in section.lines)]
        return "\n".join([*parts, "", f"Status: {self.status}"])

    def record(self) -> dict[str, Any]:
        """The page for a program."""
        lines = [
            {"section": section.title, "symbol": line.symbol, "formula": line.formula,
             "values": [*map(null_if_nan, line.values)], "unit": line.unit, "source": line.source}
            for section in self.sections for line in section.lines
        ]  # fmt: skip
        return {
            "title": self.title,
            "notes": list(self.notes),
            "status": self.status,
            "results": self.columns,
            "lines": lines,
        }


def state_page(
    study: Study,
    case: str | None = None,
    person: str | None = None,
    *,
    reversal: bool = False,
    plot: Path | None = None,
) -> StatePage:
    """The first state of a study's first design, or of a case's or a person's, with how its arm comes from the body.

    With a speed in the study the motor's part is added, with `reversal` what happens where the motion turns back; both
    are drawn into `plot`.
    """
    names = study.people.population.names if study.people is not None else ()
    worn = worn_by(study, person or names[0]) if person is not None or names else None
    plan = Plan(worn.study if worn is not None else study)
    inputs = Inputs(plan)
    block = _only_state(plan, case)
    state = State.of(inputs.situation(block))
    design = state.situation.design
    angle = float(np.degrees(plan.elbow_angles[0]))
    title = f"{study.name}: {plan.directions[0]} at {angle:.6g} deg, load {one(design.load_mass):.6g} kg"
    sections = _from_body(worn) if worn is not None else []
    sections += [_geometry(state, design, angle), _sheath(state, design), _load(state, design, angle)]
    status = STATUS_NAMES[int(state.status.flat[0])]
    has_equilibrium = int(state.status.flat[0]) != NO_EQUILIBRIUM
    if not has_equilibrium:
        status += f": {_no_equilibrium(one(state.coupling.elbow_torque))}"
        if plot is not None:
            hint = "--set 'motion.elbow_angle=60 deg' chooses another state"
            raise UsageError("this state has no equilibrium, so there is no motor to draw", where="--plot", hint=hint)
    else:
        sections += [_balance(state, design), _results(state, design)]
        of_motor, cycled = _of_the_motor(plan, state, design, reversal=reversal)
        sections += of_motor
        if plot is not None:
            from tendon_cli.state_page.plot import draw_motor  # only who draws pays for its import

            draw_motor(plot, design, state, plan, loss=cycled.get("friction_loss"), turns=reversal)
    columns = {name: null_if_nan(one(values)) for name, values in state.columns().items()}
    notes = [f"{worn.name}; of the study's {len(names)} persons --person chooses another"] if worn and names else []
    return StatePage(
        title,
        (*notes, *study.notes, *study.warnings, *_notes(plan, block)),
        status,
        tuple(sections),
        columns,
        has_equilibrium,
    )


def _no_equilibrium(elbow_torque: float) -> str:
    """What the status means here: with J ≤ 0 nothing balances, or nothing that the model could single out."""
    if elbow_torque > 0.0:
        return "J is not above zero and τ_a is, so no pair of tensions balances the elbow"
    return "J is not above zero, so a balance may exist, but need not be the only one; the model does not answer"


def _of_the_motor(
    plan: Plan, state: State, design: Design, *, reversal: bool
) -> tuple[list[PageSection], dict[str, float | None]]:
    """Its sections, and the columns of designs that a speed adds."""
    flexion, sections, results = plan.directions[0] == "flexion", [], {}
    speed = plan.study.motion.speed
    if speed is not None:
        results = cycle_results(design, plan, speed.single)
        sections += [motor_section(design, state, speed.single, flexion=flexion), cycle_section(results, speed.single)]
    if reversal:
        sections.append(reversal_section(design, state, flexion=flexion))
    return sections, results


def _from_body(worn: Worn) -> list[PageSection]:
    """What the tape and the scale say, and the arm that follows."""

    def line(step: Step) -> PageLine:
        quantity = QUANTITIES[step.quantity]
        return PageLine(quantity.symbol, step.formula, (step.value,), quantity.unit, step.source)

    parts = ((f"Body: {worn.name}", worn.body), ("From body to arm", worn.arm))
    return [PageSection(title, tuple(map(line, steps))) for title, steps in parts]


def _only_state(plan: Plan, case: str | None) -> Block:
    first = [slice(0, 1)] * len(plan.axes)
    if case is not None:
        names = next((axis.names for axis in plan.axes if axis.key == CASE_AXIS), ())
        if case not in names:
            listed = f"cases: {', '.join(names[:20])}" if names else "the study has no [[cases]]"
            hint = nearest(case, names) or listed
            raise UsageError(f'there is no case "{shorten(case)}"', where="--case", hint=hint)
        first[0] = slice(names.index(case), names.index(case) + 1)
    return Block(0, tuple(first), slice(0, 1), slice(0, 1))


def _notes(plan: Plan, block: Block) -> list[str]:
    """Which values were chosen where the study has several."""
    notes = []
    for axis, chosen in zip(plan.axes, block.designs, strict=True):
        if axis.names:
            notes.append(f"{axis.key} {axis.names[chosen.start]} of {len(axis)}; --case chooses another")
        elif len(axis) > 1:
            chooses = f"--set {axis.key}=... chooses"
            notes.append(f"{axis.key} is an axis of {len(axis)} values, this is the first; {chooses}")
    if plan.states_per_design > 1:
        notes.append(
            f"the first of {plan.states_per_design} states; --set 'motion.elbow_angle=75 deg' and "
            "--set motion.direction=extension choose another"
        )
    return notes


def _geometry(state: State, design: Design, angle: float) -> PageSection:
    motion, anchors = state.motion, design.arm.anchors
    theta = float(np.radians(angle))
    reference = "L_c(0) - L_c" if np.any(design.from_initial) else "(b1 + b2) - L_c"
    return PageSection(
        "Geometry",
        (
            PageLine("a1, b1", "proximal anchor of the flexor", (one(anchors.a1), one(anchors.b1)), "m", "Fig. 2"),
            PageLine("a2, b2", "distal anchor of the flexor", (one(anchors.a2), one(anchors.b2)), "m", "Fig. 2"),
            PageLine("θ", f"elbow angle, {angle:.6g} deg", (theta,), "rad"),
            PageLine("L_c", "distance between the anchors", (one(motion.flexor_path),), "m", "Eq. 1"),
            PageLine("H_f", reference, (one(motion.flexor_travel),), "m", "Eq. 2"),
            PageLine("H_e", "R_elb θ", (one(motion.extensor_travel),), "m", "Eq. 2"),
            PageLine("J", "-dL_c/dθ", (one(motion.flexor_moment_arm),), "m", "Eq. 5"),
            PageLine("R_elb", "moment arm of the extensor", (one(anchors.elbow_radius),), "m", "Fig. 2"),
        ),
    )


def _sheath(state: State, design: Design) -> PageSection:
    sides = (design.flexor, design.extensor)
    transmissions = (state.flexor, state.extensor)
    exponents = tuple(one(side.friction) * one(side.bend_angle) for side in sides)
    return PageSection(
        "Sheath, tendon and spring (flexor, extensor)",
        (
            PageLine("μφ", "friction x bend angle", exponents, "1", "Eq. 6"),
            PageLine(
                "e^(σμφ)",
                "distal / proximal tension",
                tuple(one(t.capstan) for t in transmissions),
                "1",
                "Eq. 6, A.17",
            ),
            PageLine(
                "c_Ten", "L/(AE) (1 - e^(-σμφ))/(σμφ)", tuple(one(t.tendon) for t in transmissions), "m/N", "Eq. 13"
            ),
            PageLine("1/K_SE", "series spring", tuple(one(t.spring) for t in transmissions), "m/N", "Eq. 14"),
            PageLine("c_f, c_e", "c_Ten + 1/K_SE", tuple(one(t.compliance) for t in transmissions), "m/N", "Eq. 16"),
            PageLine("F0", "pretension", tuple(one(side.pretension) for side in sides), "N", "Eq. 13"),
        ),
    )


def _load(state: State, design: Design, angle: float) -> PageSection:
    arm = design.arm
    mass_moment = one(arm.forearm_mass) * one(arm.forearm_com) + one(design.load_mass) * one(arm.load_distance)
    inclination = np.radians(angle) + one(arm.upper_arm_angle)
    return PageSection(
        "Load",
        (
            PageLine("M", "m_f d_com + m d_load", (mass_moment,), "kg m"),
            PageLine("θ + ψ", "inclination of the forearm", (float(inclination),), "rad"),
            PageLine("τ_a", "M g sin(θ + ψ), g = 9.81", (one(state.coupling.elbow_torque),), "N m", "Eq. 5"),
        ),
    )


def _balance(state: State, design: Design) -> PageSection:
    tied, ratio = state.coupling, one(design.ratio)
    c_f, c_e, moment_arm = one(tied.flexor_compliance), one(tied.extensor_compliance), one(tied.moment_arm)
    radius, torque = one(tied.elbow_radius), one(tied.elbow_torque)
    preload = one(tied.mismatch) + ratio * c_f * one(design.flexor.pretension) + c_e * one(design.extensor.pretension)
    determinant = ratio * c_f * radius + moment_arm * c_e
    x_both = (c_e * torque + radius * preload) / determinant
    y_both = (moment_arm * preload - ratio * c_f * torque) / determinant
    x, y = one(state.balance.flexor), one(state.balance.extensor)
    rule = "max(y_b, 0, -τ_a/R_elb)" if np.all(design.unilateral) else "y_b (bilateral: may be negative)"
    return PageSection(
        "Balance of elbow and spool",
        (
            PageLine("η", "R_e / R_f", (ratio,), "1", "Eq. 12"),
            PageLine("h", "H_e - η H_f", (one(tied.mismatch),), "m", "Eq. 12"),
            PageLine("D", "h + η c_f F0_f + c_e F0_e", (preload,), "m", "Eq. 16"),
            PageLine("Δ", "η c_f R_elb + J c_e", (determinant,), "m²/N"),
            PageLine("x_b", "(c_e τ_a + R_elb D) / Δ", (x_both,), "N", "Eqs. 5, 16"),
            PageLine("y_b", "(J D - η c_f τ_a) / Δ", (y_both,), "N", "Eqs. 5, 16"),
            PageLine("y", rule, (y,), "N"),
            PageLine("x", "(τ_a + R_elb y) / J", (x,), "N", "Eq. 5"),
            PageLine("σ", "η c_f x + c_e y - D, path that is loose", (one(state.balance.loose),), "m"),
        ),
    )  # fmt: skip


def _results(state: State, design: Design) -> PageSection:
    balance = state.balance
    distal = (one(balance.flexor), one(balance.extensor))
    proximal = (one(state.flexor_tension_proximal), one(state.extensor_tension_proximal))
    changes = (distal[0] - one(design.flexor.pretension), distal[1] - one(design.extensor.pretension))
    paired = list(zip((state.flexor, state.extensor), changes, strict=True))
    tendon_stretch = tuple(one(side.tendon) * change for side, change in paired)
    spring_stretch = tuple(one(side.spring) * change for side, change in paired)
    lines = [
        PageLine("F_o", "distal tension, flexor and extensor", distal, "N", "Eq. 5"),
        PageLine("F_I", "F_o / e^(σμφ), at the motor", proximal, "N", "Eq. 6"),
        PageLine("ΔL_Ten", "c_Ten (F_o - F0)", tendon_stretch, "m", "Eq. 13"),
        PageLine("ΔL_SE", "(F_o - F0) / K_SE", spring_stretch, "m", "Eq. 14"),
        PageLine("τ_m", "(F_I^f - η F_I^e) R_f", (one(state.motor_torque),), "N m", "Eq. 17"),
        PageLine("α", "spool angle", (one(state.spool_angle),), "rad", "Eq. 2"),
        PageLine("s", "slack of flexor and extensor", (one(state.flexor_slack), one(state.extensor_slack)), "m"),
        PageLine("k", "elbow stiffness, motor held", (one(state.elbow_stiffness),), "N m/rad"),
    ]  # fmt: skip
    return PageSection("Results", tuple(line for line in lines if not all(np.isnan(line.values))))
