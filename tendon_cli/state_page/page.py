"""One state worked out line by line, with the equations' numbers, so that it can be checked by hand."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.display import Displayed
from tendon_cli.engine.plan import Block, Plan
from tendon_cli.errors import UsageError
from tendon_cli.files import result_path
from tendon_cli.model.actuator import State
from tendon_cli.model.statics import NO_EQUILIBRIUM, STATUS_NAMES
from tendon_cli.quantities import QUANTITIES
from tendon_cli.space.axis import CASE_AXIS
from tendon_cli.state_page.lines import PageLine, PageSection, null_if_nan, one, sections_of
from tendon_cli.state_page.motor import cycle_results, cycle_section, motor_section, reversal_section
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.load import AnyStudy, any_study
from tendon_cli.studies.people.person import Step, Worn, with_numbers, worn_by
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import drawn
from tendon_cli.units import shorten


@dataclass(frozen=True, repr=False)
class StatePage(Displayed):
    """The whole page, and the same numbers by the names of the table columns."""

    title: str
    notes: tuple[str, ...]
    status: str
    sections: tuple[PageSection, ...]
    columns: dict[str, float | None]
    study: Study
    """Whose arm it is."""
    has_equilibrium: bool = True

    @property
    def text(self) -> str:
        """The page for a terminal."""
        wrap = partial(textwrap.fill, width=80, initial_indent="  ", subsequent_indent="   ", break_on_hyphens=False)
        parts = [self.title, *(wrap(f"({note})") for note in self.notes)]
        for section in self.sections:
            parts += ["", section.title, *(line.text for line in section.lines)]
        return "\n".join([*parts, "", f"Status: {self.status}"])

    @property
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
    study: AnyStudy, case: str | None = None, person: str | None = None, draw: int | None = None, *,
    reversal: bool = False, plot: str | PathLike[str] | None = None,
) -> StatePage:  # fmt: skip
    """The first state of a study's first design, or of a case's or a person's, with how its arm comes from the body.

    Uncertain numbers are nominal, or those of a `draw`, counted from 1. With a speed in the study the motor's part is
    added, with `reversal` what happens if the motion turns back there; both are drawn into `plot`. Raises UsageError.

    >>> import tendon_cli as tendon
    >>> page = tendon.state(tendon.study({"motion": {"elbow_angle": "75 deg"}}))
    >>> page.status, round(page.columns["motor_torque"], 4)
    ('taut', 0.3892)
    """
    study, plot = any_study(study), None if plot is None else result_path(plot)
    names = study.people.nominal.names if study.people is not None else ()
    nominal, of_draw = _nominal(study) if draw is None else _drawn(study, draw)
    worn = worn_by(nominal, person or names[0]) if person is not None or names else None
    plan = Plan(worn.study if worn is not None else nominal)
    block = _only_state(plan, case)
    state = State.of(plan.inputs(block))
    angle = float(np.degrees(plan.elbow_angles[0]))
    load = one(state.inputs.design.load_mass)
    table = study.sources.get("joint.excursion", {}).get("file", "table in the study")
    sections = [*(_from_body(worn) if worn is not None else ()), *sections_of(state, angle, table)]
    status = STATUS_NAMES[int(state.status.flat[0])]
    has_equilibrium = int(state.status.flat[0]) != NO_EQUILIBRIUM
    if has_equilibrium:
        sections += _of_the_motor(plan, state, reversal=reversal, plot=plot)
    else:
        status += f": {_no_equilibrium(one(state.coupling.elbow_torque))}"
        if plot is not None:
            hint = "--set 'motion.elbow_angle=60 deg' chooses another state"
            raise UsageError("this state has no equilibrium, so there is no motor to draw", where="--plot", hint=hint)
    columns = {name: null_if_nan(one(values)) for name, values in state.columns().items()}
    notes = [f"{worn.name}; of the study's {len(names)} persons --person chooses another"] if worn and names[1:] else []
    return StatePage(
        f"{study.name}: {plan.directions[0]} at {angle:.6g} deg, load {load:.6g} kg",
        (*notes, *of_draw, *study.notes, *study.warnings, *_notes(plan, block)), status, tuple(sections), columns,
        plan.study, has_equilibrium,
    )  # fmt: skip


def _nominal(study: Study) -> tuple[Study, list[str]]:
    """A study with its uncertain numbers at their middle, and a note of it."""
    if study.uncertainty is None or not study.uncertain:
        return study, []
    chooses = " or ".join(f"--set {key}=..." for key in study.uncertain)
    note = f"uncertain numbers are nominal; --draw 1 takes those of the first draw, {chooses} chooses a value"
    return study.replaced({"uncertainty": None}), [note]


def _drawn(study: Study, draw: int) -> tuple[Study, list[str]]:
    """A study with its uncertain numbers as one of its draws has them, and a note of it."""
    asked = study.uncertainty
    if asked is None or not study.uncertain:
        hint = "[uncertainty] draws numbers such as friction = { mean = 0.07, std = 0.01 }"
        raise UsageError("nothing is drawn in this study", where="--draw", hint=hint)
    count = study.draws or len(study.people.population if study.people is not None else ())
    if not 1 <= draw <= count:
        raise UsageError(f"there is no draw {draw}", where="--draw", hint=f"1 to {count}")
    values = {key: float(each[draw - 1]) for key, each in drawn(study.uncertain, count, asked.seed).items()}
    note = f"draw {draw} of {count}: {', '.join(f'{key} = {value:.6g}' for key, value in values.items())}"
    return with_numbers(study, values).replaced({"uncertainty": None}), [note]


def _no_equilibrium(elbow_torque: float) -> str:
    """What the status means here: with J ≤ 0 nothing balances, or nothing that the model could single out."""
    if elbow_torque > 0.0:
        return "J is not above zero and τ_a is, so no pair of tensions balances the elbow"
    return "J is not above zero, so a balance may exist, but need not be the only one; the model does not answer"


def _of_the_motor(plan: Plan, state: State, *, reversal: bool, plot: Path | None) -> list[PageSection]:
    """The motor's sections: what a speed adds, and what a turn does; both drawn into `plot`."""
    flexion, design, sections, loss = plan.directions[0] == "flexion", state.inputs.design, [], None
    speed = plan.study.motion.speed
    if speed is not None:
        results = cycle_results(design, plan, speed.single)
        sections += [motor_section(design, state, speed.single, flexion=flexion), cycle_section(results, speed.single)]
        loss = results["friction_loss"]
    if reversal:
        sections.append(reversal_section(design, state, float(plan.elbow_angles[0]), flexion=flexion))
    if plot is not None:
        from tendon_cli.state_page.plot import draw_motor  # only who draws pays for its import

        draw_motor(plot, design, state, plan, loss=loss, turns=reversal)
    return sections


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
            option = "--case" if axis.key == CASE_AXIS else f"--set {axis.key}=..."
            notes.append(f"{axis.key} {axis.names[chosen.start]} of {len(axis)}; {option} chooses another")
        elif axis.is_interval:
            notes.append(f"{axis.key}: the lower end of its interval; --set {axis.key}=... chooses")
        elif len(axis) > 1:
            notes.append(f"{axis.key}: the first of {len(axis)} values; --set {axis.key}=... chooses")
    if plan.study.trajectory is not None:
        notes.append(f"the first of {plan.states_per_design} samples; `tendon sweep` writes all of them")
    elif plan.states_per_design > 1:
        notes.append(
            f"the first of {plan.states_per_design} states; --set 'motion.elbow_angle=75 deg' and "
            "--set motion.direction=extension choose another"
        )
    return notes
