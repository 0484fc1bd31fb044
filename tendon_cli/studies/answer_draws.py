"""The study as an answer takes it: whatever is not exact is drawn, by usual deviations as well."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import SIDES
from tendon_cli.studies import usual
from tendon_cli.studies.design_section import Uncertainty
from tendon_cli.studies.space.axis import factor_of, of_side, shift_of, split_side
from tendon_cli.studies.space.space import ANCHORS
from tendon_cli.studies.study import Study, is_exact, states_reading
from tendon_cli.studies.usual import UsualDeviation
from tendon_cli.studies.values import OF_THE_STUDY, Sampler, Stream, draw_numbers

READ_WHERE_DRAWN = "flexor at joint"
"""Gauge by which suits are set that differ, unless the study says how pretensions are read."""


def drawn(study: Study) -> Study:
    """Return a study with its uncertain numbers drawn, unless it states otherwise."""
    stated = study.uncertainty
    if not study.uncertain or (stated is not None and stated.asks_for_draws):
        return study
    return study.replaced({"uncertainty": _drawing(study)})


def for_answer(study: Study) -> Study:
    """Return a study as an answer takes it: all that is not exact is drawn.

    Usual deviations are among it, unless the study states otherwise. All draws and persons then get
    the same reading of a gauge, as suits do that are built alike; F0 is not to be seen.
    """
    drawing = _drawing(study)
    taken = study.replaced({"uncertainty": drawing})
    if drawing.usual and drawing.draws:
        taken._usual = usual_deviations(study)  # noqa: SLF001 - what no file of a study states
    if taken.drawing is None and study.people is None:
        return study
    if not states_reading(study):
        setting = study.setting.model_copy(update={"read": READ_WHERE_DRAWN})
        taken = taken.replaced({"setting": setting})
    return taken


def _drawing(study: Study) -> Uncertainty:
    """Return the draws of whoever draws although the study may not ask for it."""
    stated = study.uncertainty
    if stated is None or stated.asks_for_draws:
        return stated or Uncertainty()
    known = {"exact": stated.exact, "usual": stated.usual, "draws": Uncertainty().draws}
    return Uncertainty().model_copy(update=known)


def numbers_of_paper(study: Study) -> list[str]:
    """Return the keys of the arm's numbers that a study does not state: they are the paper's."""
    if study.people is not None or study.joint.excursion is not None:
        return []
    of_rows = {key for table in study.row_tables for key in table.keys}
    names = [*ANCHORS, "forearm_mass", "forearm_com", "load_distance"]
    unstated = [f"arm.{name}" for name in names if name not in study.arm.model_fields_set]
    return [key for key in unstated if key not in of_rows]


_JOINT = ("joint.stiffness", "joint.rest_angle")
_MEASURED_TRAVELS = ("arm.a1", "arm.b1", "arm.a2", "arm.b2", "arm.elbow_radius")
"""Numbers that count for nothing where a joint's travels were measured."""


def usual_deviations(study: Study) -> dict[str, UsualDeviation]:
    """Return what a study leaves to be drawn, by key; of a number with sides each side has its own.

    Left out are numbers with a deviation of their own, those named exact, conditions, stiffnesses
    that are rigid or zero in every design, and what a survey's persons scatter in themselves.
    """
    drawn_tables = study.drawn_tables
    known = {*study.uncertain, *study.conditions}
    for table in study.row_tables:
        if table.key in drawn_tables:
            known.update(table.keys)
    found = {}
    for common, deviation in usual.USUAL.items():
        if not _matters(study, common):
            continue
        sides = SIDES if deviation.has_sides else (None,)
        for side in sides:
            key = common if side is None else of_side(common, side)
            if known.isdisjoint((key, common)) and not is_exact(study, key):
                found[key] = deviation
    return found


def _matters(study: Study, common: str) -> bool:
    """Return True if a number counts in some design, and is not another's scatter."""
    if common in _MEASURED_TRAVELS and study.joint.excursion is not None:
        return False
    if common.startswith("arm.") and study.people is not None and not study.people.is_from_file:
        return common not in (*study.body_numbers, *_MEASURED_TRAVELS)
    if common in _JOINT:
        return any(value != 0.0 for value in _values(study, "joint.stiffness"))
    if common == "sheath.bend_angle" and common not in study.numbers:
        return False  # a curve over the joint's angle
    if common == "anchor.stiffness":
        return any(math.isfinite(value) for value in _values(study, common))
    return True


def _values(study: Study, common: str) -> list[float]:
    """Return all values that a study gives for a number, those of sides and rows among them."""
    values: list[float] = []
    for key, number in study.numbers.items():
        if split_side(key)[0] == common:
            values += number.array.tolist()
    for rows in study.row_tables:
        for key, column in rows.numbers.items():
            if split_side(key)[0] == common:
                values += [value for value in column.tolist() if not math.isnan(value)]
    return values


def draws_of(study: Study, count: int, stream: Stream = OF_THE_STUDY) -> dict[str, Array]:
    """Return draws of what a study draws, (count,) each; none if it draws nothing.

    Args:
        study: The study.
        count: Number of draws.
        stream: Stream of the random numbers; those of a fresh sample are independent points.
    """
    if study.drawing is None:
        return {}
    sampler: Sampler = "random"
    if stream == OF_THE_STUDY:
        sampler = "even" if study.usual else "sobol"
    drawn = draw_numbers(
        study.to_draw, count, study.drawing.seed, study.correlation, sampler=sampler, stream=stream
    )
    return drawn_numbers(study, drawn)


def drawn_numbers(study: Study, drawn: Mapping[str, Array]) -> dict[str, Array]:
    """Return draws of usual deviations as the shifts and factors of a space, and others as given.

    Args:
        study: The study.
        drawn: Draws by the keys of `Study.to_draw`, (draws,) each.
    """
    deviations = study.usual
    numbers: dict[str, Array] = {}
    for key, values in drawn.items():
        if key not in deviations:
            numbers[key] = values
        elif deviations[key].kind == "amount":
            numbers[shift_of(key)] = values
        else:
            numbers[factor_of(key)] = values
    return numbers
