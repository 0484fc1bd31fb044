"""One state worked out line by line, with the equations' numbers, so that it can be checked by hand."""

from __future__ import annotations

import itertools
import textwrap
from dataclasses import asdict, dataclass
from functools import partial
from os import PathLike
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
from tendon_cli.state_page.lines import (
    PageLine,
    cycle_lines,
    motor_lines,
    one,
    reversal_lines,
    state_lines,
)
from tendon_cli.studies.load import AnyStudy, any_study
from tendon_cli.studies.people.person import Worn, worn_by
from tendon_cli.studies.spaces import case_place
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.values import drawn, in_si


@dataclass(frozen=True, repr=False)
class StatePage(Displayed):
    """The whole page, and the same numbers by the names of the table columns."""

    title: str
    notes: tuple[str, ...]
    status: str
    lines: tuple[PageLine, ...]
    columns: dict[str, float | None]
    study: Study
    """Whose arm it is."""
    has_equilibrium: bool = True

    @property
    def text(self) -> str:
        """The page for a terminal."""
        wrap = partial(
            textwrap.fill,
            width=80,
            initial_indent="  ",
            subsequent_indent="   ",
            break_on_hyphens=False,
        )
        parts = [self.title, *(wrap(f"({note})") for note in self.notes)]
        for section, lines in itertools.groupby(self.lines, key=lambda line: line.section):
            parts += ["", section, *(line.text for line in lines)]
        return "\n".join([*parts, "", f"Status: {self.status}"])

    @property
    def record(self) -> dict[str, Any]:
        """The page for a program."""
        lines = [
            {**asdict(line), "values": [*map(_null_if_nan, line.values)]} for line in self.lines
        ]
        about = {"title": self.title, "notes": list(self.notes), "status": self.status}
        return {**about, "results": self.columns, "lines": lines}


def state_page(
    study: AnyStudy,
    case: str | None = None,
    person: str | None = None,
    draw: int | None = None,
    *,
    reversal: bool = False,
    plot: str | PathLike[str] | None = None,
) -> StatePage:
    """The first state of a study's first design, or of a case's or a person's, with how its arm comes from the body.

    Uncertain numbers are nominal, or those of a `draw`, counted from 1. With a speed in the study the motor's part is
    added, with `reversal` what happens if the motion turns back there; both are drawn into `plot`. Raises UsageError.

    >>> import tendon_cli as tendon
    >>> page = tendon.state(tendon.study({"motion": {"elbow_angle": "75 deg"}}))
    >>> page.status, round(page.columns["motor_torque"], 4)
    ('taut', 0.3892)
    """
    study, target = any_study(study), None if plot is None else result_path(plot)
    names = study.people.nominal.names if study.people is not None else ()
    nominal, of_draw = _nominal(study) if draw is None else _drawn(study, draw)
    worn = worn_by(nominal, person or names[0]) if person is not None or names else None
    plan = Plan(worn.study if worn is not None else nominal)
    block = _only_state(plan, case)
    state, angle = plan.state(block), float(plan.elbow_angles[0])
    table = study.sources.get("joint.excursion", {}).get("file", "table in the study")
    lines = [*(_from_body(worn) if worn is not None else ()), *state_lines(state, angle, table)]
    status = STATUS_NAMES[int(state.status.flat[0])]
    has_equilibrium = int(state.status.flat[0]) != NO_EQUILIBRIUM
    if has_equilibrium:
        lines += _of_the_motor(plan, state, reversal=reversal)
    else:
        status += f": {_no_equilibrium(one(state.coupling.elbow_torque))}"
    if target is not None:
        from tendon_cli.state_page.plot import draw_motor  # only who draws pays for its import

        draw_motor(target, state, plan, turns=reversal)
    columns = {name: _null_if_nan(one(values)) for name, values in state.columns().items()}
    notes = (
        [f"{worn.name}; of the study's {len(names)} persons --person chooses another"]
        if worn and names[1:]
        else []
    )
    load = one(state.design.load_mass)
    return StatePage(
        f"{study.name}: {plan.directions[0]} at {np.degrees(angle):.6g} deg, load {load:.6g} kg",
        (*notes, *of_draw, *study.notes, *study.warnings, *_notes(plan, block)),
        status,
        tuple(lines),
        columns,
        plan.study,
        has_equilibrium,
    )


def _null_if_nan(value: float) -> float | None:
    return None if np.isnan(value) else value


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
    values = {
        key: float(each[draw - 1])
        for key, each in drawn(study.uncertain, count, asked.seed).items()
    }
    note = f"draw {draw} of {count}: {', '.join(f'{key} = {value:.6g}' for key, value in values.items())}"
    given = {
        key: in_si(value, keys()[key].number.quantity.dimension) for key, value in values.items()
    }
    return study.replaced({"uncertainty": None}).vary(**given), [note]


def _no_equilibrium(elbow_torque: float) -> str:
    if elbow_torque > 0.0:
        return "J is not above zero and τ_a is, so no pair of tensions balances the elbow"
    return "J is not above zero, so a balance may exist, but need not be the only one; the model does not answer"


def _of_the_motor(plan: Plan, state: State, *, reversal: bool) -> list[PageLine]:
    """What a speed adds, and what a turn does."""
    flexion, speed, lines = plan.directions[0] == "flexion", plan.study.motion.speed, []
    if speed is not None:
        lines += motor_lines(state, speed.single, flexion=flexion)
        lines += cycle_lines(state.design, plan, speed.single)
    return lines + (
        reversal_lines(state, float(plan.elbow_angles[0]), flexion=flexion) if reversal else []
    )


def _from_body(worn: Worn) -> list[PageLine]:
    """What the tape and the scale say, and the arm that follows."""
    steps = [(f"Body: {worn.name}", step) for step in worn.body] + [
        ("From body to arm", step) for step in worn.arm
    ]
    return [
        PageLine(title, quantity.symbol, step.formula, (step.value,), quantity.unit, step.source)
        for title, step in steps
        for quantity in [QUANTITIES[step.quantity]]
    ]


def _only_state(plan: Plan, case: str | None) -> Block:
    first = [slice(0, 1)] * len(plan.axes)
    if case is not None:
        at = case_place(plan.study, case)
        first[0] = slice(at, at + 1)
    return Block(0, tuple(first), slice(0, 1), slice(0, 1))


def _notes(plan: Plan, block: Block) -> list[str]:
    """Which values were chosen where the study has several."""
    notes = []
    for axis, chosen in zip(plan.axes, block.designs, strict=True):
        value = (
            axis.names[chosen.start]
            if axis.names
            else "lower end of its interval"
            if axis.is_interval
            else "first"
        )
        option = "--case" if axis.key == CASE_AXIS else f"--set {axis.key}=..."
        notes += (
            [f"{axis.key}: {value} of {len(axis)} values; {option} chooses another"]
            if len(axis) > 1
            else []
        )
    if plan.study.trajectory is not None:
        more = (
            ", with its inertia; `tendon sweep` and `tendon show RUN --table states` have them all"
        )
        notes.append(f"the first of the trajectory's {plan.states_per_design} samples{more}")
    elif plan.states_per_design > 1:
        more = (
            "--set 'motion.elbow_angle=75 deg' and --set motion.direction=extension choose another"
        )
        notes.append(f"the first of {plan.states_per_design} states; {more}")
    return notes
