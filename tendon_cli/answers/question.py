"""From a study to the question that it asks: its choices, its conditions, its limits, and what is left out."""

from __future__ import annotations

from tendon_cli.answers.problem import Problem
from tendon_cli.engine.plan import bounds_of
from tendon_cli.space.axis import PRETENSION, split_side
from tendon_cli.studies.axes import space_of
from tendon_cli.studies.contents import case_numbers
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import Values

_ENDS_SUFFICE = ("load.mass", "load.scale", PRETENSION)
"""Of an interval of a load the ends suffice, as tensions and torques are linear in it; pretension is solved for."""
_SEVERAL = ("peak_motor_power", "max_motor_work_in", "max_friction_loss", "min_efficiency")


def question(study: Study) -> Problem:
    """What a study asks of `tendon design`."""
    space = space_of(study).unset()
    return Problem(
        study=study,
        choices=space.choices,
        conditions=space.conditions,
        bounds=bounds_of(study),
        enough=study.serve,
        middle=study.design.pretension == "middle",
        given=study.design.pretension.single if isinstance(study.design.pretension, Values) else None,
        notes=(*study.warnings, *_left_out(study), *_of_people_and_draws(study)),
    )


def _left_out(study: Study) -> list[str]:
    """What the study says of pretension, which is solved for."""
    given = [key for key in study.numbers if split_side(key)[0] == PRETENSION]
    notes = []
    if any(split_side(key)[1] for key in given):
        notes.append("the study's pretensions per side are left out: one of both sides is solved for")
    if any(study.numbers[key].is_axis for key in given):
        notes.append("the study's values of pretension are left out: the window is solved exactly, without them")
    if any(split_side(key)[0] == PRETENSION for case in study.cases for key in case_numbers(case)):
        notes.append("the pretensions of the study's cases are left out: one of all is solved for")
    ends = [key for key in study.intervals if split_side(key)[0] not in _ENDS_SUFFICE]
    if ends:
        notes.append(f"{', '.join(ends)}: solved at both ends of the interval; what lies between is not proved")
    several = [name for name in _SEVERAL if name in study.limits]
    if several:
        notes.append(f"{', '.join(several)}: where several intervals of pretension keep to this, the widest is used")
    return notes


def _of_people_and_draws(study: Study) -> list[str]:
    """What is assumed of persons, and whether what is uncertain is not drawn, or nothing is."""
    drawn = study.people is not None and study.people.content is None
    notes = list(study.people.population.notes) if study.people is not None and drawn else []
    if study.uncertain and study.uncertainty is None:
        notes.append("uncertain numbers stand at their middle; [uncertainty] draws them")
    if study.uncertainty is not None and not study.uncertain:
        notes.append("nothing in this study is uncertain, so that [uncertainty] draws nothing")
    return notes
