"""One state worked out line by line, so that it can be checked by hand.

Each line names the equation it comes from.
"""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from os import PathLike
from typing import Any, ClassVar

import numpy as np

from tendon_cli import say
from tendon_cli.engine.plan import Block, Plan
from tendon_cli.errors import UsageError
from tendon_cli.files import result_path
from tendon_cli.model.actuator import State
from tendon_cli.model.statics import NO_EQUILIBRIUM, STATUS_NAMES
from tendon_cli.quantities import QUANTITIES
from tendon_cli.say.display import Displayed
from tendon_cli.state_page.lines import (
    PageLine,
    cycle_lines,
    motion_lines,
    motor_lines,
    moving_lines,
    place_text,
    reversal_lines,
    scalar,
    slides_in_flexion,
    state_lines,
)
from tendon_cli.studies.answer_draws import drawn as with_draws
from tendon_cli.studies.axis_words import name_words
from tendon_cli.studies.load import AnyStudy, any_study
from tendon_cli.studies.people.person import PersonStudy, person_study
from tendon_cli.studies.space.axis import CASE_AXIS, PRETENSION, READING_ERROR, NamedAxis
from tendon_cli.studies.spaces import row_place
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.values import StudyNumber, draw_numbers, si_document

_MOST_LISTED = 6
"""Uncertain numbers that a note lists."""


@dataclass(frozen=True, repr=False)
class StatePage(Displayed):
    """The page of one state, and the same numbers by the names of the table columns."""

    drawn_by: ClassVar[str] = "tendon_cli.face.page_of_state"
    title: str
    notes: tuple[str, ...]
    status: str
    lines: tuple[PageLine, ...]
    columns: dict[str, float | None]
    """Values by column, in SI; None for null."""
    study: Study
    """The study with its numbers for this person or draw."""
    has_equilibrium: bool = True

    @property
    def text(self) -> str:
        """The page for a terminal."""
        parts = [self.title, *map(_wrap_note, self.notes)]
        for section, lines in itertools.groupby(self.lines, key=lambda line: line.section):
            parts += ["", section, *(line.text for line in lines)]
        return "\n".join([*parts, "", f"Status: {self.status}"])

    @property
    def record(self) -> dict[str, Any]:
        """The page for a program."""
        lines = [
            {**asdict(line), "values": [*map(_null_unless_finite, line.values)]}
            for line in self.lines
        ]
        about = {"title": self.title, "notes": list(self.notes), "status": self.status}
        return {**about, "results": self.columns, "lines": lines}


def _wrap_note(note: str) -> str:
    """Put a note into brackets and break it for a terminal."""
    return textwrap.fill(
        f"({note})",
        width=80,
        initial_indent="  ",
        subsequent_indent="   ",
        break_on_hyphens=False,
    )


def state_page(
    study: AnyStudy,
    case: str | None = None,
    person: str | None = None,
    draw: int | None = None,
    *,
    rows: Mapping[str, str] | None = None,
    reversal: bool = False,
    plot: str | PathLike[str] | None = None,
    overwrite: bool = False,
) -> StatePage:
    """Work out the first state of a study's first design, line by line.

    Along a motion in time it is the first sample that counts. For a person the page begins with the
    steps from body to arm. If the study has a speed or a motion in time, speed and power of the
    motor are added.

    Args:
        study: The study.
        case: Name of one of its cases; by default the first.
        person: Name of one of its persons; by default the first, if it has persons.
        draw: Number of a draw, from 1, from which uncertain numbers are taken. By default they are
            nominal.
        rows: Names of rows by their tables; by default the first of each.
        reversal: True to add what happens if the motion turns back at this state.
        plot: File of a figure of the motor, and of the turn if `reversal` is true.
        overwrite: True to replace a file that tendon did not write.

    Raises:
        UsageError: The study does not have this case, row, person or draw, there is nothing to
            plot, or tendon did not write the file.

    >>> import tendon_cli as tendon
    >>> page = tendon.state(tendon.study({"motion": {"elbow_angle": "75 deg"}}))
    >>> page.status, round(page.columns["motor_torque"], 4)
    ('taut', 0.3892)
    """
    study = any_study(study)
    target = None if plot is None else result_path(plot)
    certain, draw_notes = _nominal(study) if draw is None else _drawn(study, draw)
    names = study.people.nominal.names if study.people is not None else ()
    wearer = None
    person_notes = []
    if person is not None or names:
        wearer = person_study(certain, person or names[0])
        certain = wearer.study
        if len(names) > 1:
            count = f"one of {len(names)} persons in the study"
            person_notes.append(f"{wearer.name}, {count}; --person chooses another")
    plan = Plan(certain)
    block = _first_state(plan, case, rows or {})
    state = plan.state(block)
    angle = scalar(state.elbow_angle)
    table = study.sources.get("joint.excursion", {}).get("file", "table in the study")
    lines = [*_body_lines(wearer), *_fitted_lines(study), *state_lines(state, angle, table)]
    code = int(state.status.flat[0])
    status = STATUS_NAMES[code]
    has_equilibrium = code != NO_EQUILIBRIUM
    if has_equilibrium:
        lines += _motor_part(plan, block, state, reversal=reversal)
    else:
        status = f"{status}: {_no_equilibrium(scalar(state.coupling.elbow_torque))}"
    if target is not None:
        from tendon_cli.state_page.plot import draw_motor  # imports matplotlib

        draw_motor(target, state, plan, block, turns=reversal, overwrite=overwrite)
    columns = {
        name: _null_unless_finite(scalar(values)) for name, values in state.columns().items()
    }
    load = say.quantity("load_mass", scalar(state.design.load_mass), 6)
    where = f"{place_text(plan, block)}, load {load}"
    notes = (*person_notes, *draw_notes, *study.notes, *study.warnings, *_notes(plan, block))
    return StatePage(
        title=f"{study.name}: {where}",
        notes=notes,
        status=status,
        lines=tuple(lines),
        columns=columns,
        study=plan.study,
        has_equilibrium=has_equilibrium,
    )


def _null_unless_finite(value: float) -> float | None:
    """Return a value, or None for one that JSON does not have."""
    return value if np.isfinite(value) else None


def _nominal(study: Study) -> tuple[Study, list[str]]:
    """Return a study with its uncertain numbers at their middle, and notes that say so."""
    if not study.uncertain:
        return study, []
    chooses = " or ".join(f"--set {key}=..." for key in [*study.uncertain][:_MOST_LISTED])
    if len(study.uncertain) > _MOST_LISTED:
        chooses = f"--set KEY=... for any of these {len(study.uncertain)} numbers"
    note = (
        "uncertain numbers take their nominal values; --draw 1 takes those of the first draw, "
        f"{chooses} sets a value"
    )
    return study.replaced({"uncertainty": None}), [note]


def _drawn(study: Study, draw: int) -> tuple[Study, list[str]]:
    """Return a study with its uncertain numbers from one of its draws, and notes that say so.

    Raises:
        UsageError: Nothing is drawn in the study, or it does not have this draw.
    """
    study = with_draws(study)
    drawing = study.drawing
    if drawing is None:
        hint = "a number such as friction = { mean = 0.07, std = 0.01 } is drawn"
        raise UsageError("this study draws nothing", where="--draw", hint=hint)
    count = study.draws or len(study.people.population if study.people is not None else ())
    if not 1 <= draw <= count:
        raise UsageError(f"there is no draw {draw}", where="--draw", hint=f"expected 1 to {count}")
    draws = draw_numbers(study.uncertain, count, drawing.seed, study.correlation)
    values = {key: float(of_draws[draw - 1]) for key, of_draws in draws.items()}
    texts = [f"{key} = {say.number(value, 6)}" for key, value in values.items()]
    note = f"draw {draw} of {count}: {', '.join(texts)}"
    error = values.pop(READING_ERROR, None)
    given: dict[str, Any] = {
        key: si_document(value, keys()[key].quantity.dimension) for key, value in values.items()
    }
    if "pretension" not in study.tendon.model_fields_set:
        # The same as in the table of states, where one default holds for all draws.
        given[PRETENSION] = study.numbers[PRETENSION].single
    drawn = study.replaced({"uncertainty": None}).vary(**given)
    if error is not None:
        # A study file states the standard deviation of the error, and not one error.
        known = {"reading_error": StudyNumber.of(error)}
        drawn = drawn.replaced({"setting": drawn.setting.model_copy(update=known)})
    return drawn, [note]


def _no_equilibrium(elbow_torque: float) -> str:
    """Return the reason why there is no equilibrium at an elbow torque in N m."""
    if elbow_torque > 0.0:
        return "J is not positive but τ_a is, so no pair of tensions balances the elbow"
    return (
        "J is not positive; a balance may exist, but it need not be the only one, "
        "so the model gives none"
    )


def _motor_part(plan: Plan, block: Block, state: State, *, reversal: bool) -> list[PageLine]:
    """Return lines of the motor if the study has a motion, and of a turn back if `reversal`."""
    speed = plan.study.motion.speed
    trajectory = plan.study.trajectory
    lines: list[PageLine] = []
    if speed is not None:
        flexion = slides_in_flexion(plan, state)
        lines += motor_lines(state, speed.single, flexion=flexion)
        lines += cycle_lines(state.design, plan, speed.single)
    if trajectory is not None:
        lines += moving_lines(state, float(trajectory.time[block.angles.start]))
        lines += motion_lines(plan.moving(block))
    if reversal:
        flexion = slides_in_flexion(plan, state)
        lines += reversal_lines(state, scalar(state.elbow_angle), flexion=flexion)
    return lines


def _body_lines(wearer: PersonStudy | None) -> list[PageLine]:
    """Return lines of a person's measured body, and of the arm that follows; empty without one."""
    if wearer is None:
        return []
    lines = []
    for title, steps in ((f"Body: {wearer.name}", wearer.body), ("From body to arm", wearer.arm)):
        for step in steps:
            quantity = QUANTITIES[step.quantity]
            values = (step.value,)
            line = PageLine(
                title, quantity.symbol, step.formula, values, quantity.unit, step.source
            )
            lines.append(line)
    return lines


def _fitted_lines(study: Study) -> list[PageLine]:
    """Return lines of the numbers that were fitted to logs, beside those stated; empty without."""
    source = study.sources.get("fitted_from")
    if source is None:
        return []
    title = "Fitted to the suit's logs, and stated in the study"
    lines = []
    for key, fitted in source["fitted"].items():
        quantity = keys()[key].number.quantity
        values = (fitted, source["stated"].get(key, np.nan))
        symbol = quantity.symbol
        lines.append(PageLine(title, symbol, key, values, quantity.unit, source["file"]))
    return lines


def _first_state(plan: Plan, case: str | None, rows: Mapping[str, str]) -> Block:
    """Return the block of the first state of the first design with some rows of tables.

    Along a motion in time it is the first sample that counts.

    Args:
        plan: The plan of the study.
        case: Name of a case; None for the first.
        rows: Names of rows by their tables; the first of any other.
    """
    trajectory = plan.study.trajectory
    first = 0 if trajectory is None else trajectory.counted.start
    designs = {axis.key: slice(0, 1) for axis in plan.axes}
    chosen = [(table, name, "--row") for table, name in rows.items()]
    if case is not None:
        chosen.append((CASE_AXIS, case, "--case"))
    for table, name, option in chosen:
        place = row_place(plan.study, table, name, option)
        designs[table] = slice(place, place + 1)
    return Block(0, tuple(designs.values()), slice(0, 1), slice(first, first + 1))


def _notes(plan: Plan, block: Block) -> list[str]:
    """Return notes that say which value and which state are shown if the study has several."""
    notes = []
    for axis, chosen in zip(plan.axes, block.designs, strict=True):
        if len(axis) == 1:
            continue
        if axis.names:
            value = axis.names[chosen.start]
        elif axis.is_interval:
            value = "lower end of its interval"
        else:
            value = "first"
        option = f"--set {axis.key}=..."
        if isinstance(axis, NamedAxis):
            option = "--case" if axis.key == CASE_AXIS else f"--row {axis.key}=..."
            value = name_words(axis, value).removeprefix(f"{axis.key} ")
        notes.append(f"{axis.key}: {value} of {len(axis)} values; {option} chooses another")
    count = plan.states_per_design
    if plan.study.trajectory is not None:
        notes.append(
            f"the first counted sample of the trajectory's {count}, with its inertia; "
            "`tendon sweep` computes all, `tendon show RUN --table states` shows them"
        )
    elif count > 1:
        options = []
        if len(plan.elbow_angles) > 1:
            options.append("--set 'motion.elbow_angle=75 deg'")
        if len(plan.directions) > 1:
            options.append("--set motion.direction=extension")
        choose = "chooses" if len(options) == 1 else "choose"
        notes.append(f"the first of {count} states; {' and '.join(options)} {choose} another")
    return notes
