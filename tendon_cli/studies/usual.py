"""Usual deviations of numbers that a study states without one of their own.

An answer draws them, a fit to a log takes them as priors, and texts quote them. Sources: a tape on
a wearer; makers' tolerances; tables of body segments; the spread between sheaths, and between
persons. Nobody has measured how the cuffs of a suit spread, so that theirs is assumed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from tendon_cli import say
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import SIDES
from tendon_cli.space.axis import factor_of, of_side, shift_of, split_side
from tendon_cli.studies.contents import keys
from tendon_cli.studies.values import Uncertain

if TYPE_CHECKING:
    from tendon_cli.studies.study import Study

Kind = Literal["amount", "share", "factor"]
"""A deviation in the unit of the number, as a share of it, or as a factor either way."""
_TAPE = "a tape on a wearer"
_SEGMENTS = "tables of body segments"
_MAKER = "makers' tolerance"
_SHEATHS = "spread between sheaths"
_PROTRACTOR = "a protractor on a worn sheath"
_PERSONS = "scatter between persons"
_ASSUMED = "assumed: nobody has measured it"


@dataclass(frozen=True)
class UsualDeviation:
    """Usual standard deviation of a number."""

    size: float
    """Deviation in SI, as a share of the number, or a factor."""
    kind: Kind
    source: str
    """Origin of the deviation."""
    has_sides: bool = False
    """True if each side deviates by itself."""

    def of(self, value: float) -> float:
        """Return the deviation of a number from its value, both SI."""
        if self.kind == "amount":
            return self.size
        share = self.size if self.kind == "share" else math.log(self.size)
        return share * abs(value)

    def text(self, key: str) -> str:
        """Return the deviation in words: "5 mm", "20 %", "a factor of 1.4"."""
        if self.kind == "factor":
            return f"a factor of {self.size:g}"
        if self.kind == "share":
            return say.percent(self.size)
        return say.quantity(keys()[key].quantity, self.size)

    def law(self) -> Uncertain:
        """Return the distribution of the shift or factor that is drawn."""
        if self.kind == "amount":
            return Uncertain("normal", 0.0, self.size, -math.inf, math.inf, "")
        if self.kind == "share":
            return Uncertain("normal", 1.0, self.size, 0.0, math.inf, "")
        return Uncertain("log-normal", 1.0, math.log(self.size), 0.0, math.inf, "")


_ANCHOR = UsualDeviation(5e-3, "amount", _TAPE)
_LENGTH = UsualDeviation(0.02, "share", _TAPE)

USUAL = {
    "arm.a1": _ANCHOR,
    "arm.b1": _ANCHOR,
    "arm.a2": _ANCHOR,
    "arm.b2": _ANCHOR,
    "arm.elbow_radius": UsualDeviation(3e-3, "amount", _TAPE),
    "arm.load_distance": _LENGTH,
    "arm.forearm_com": _LENGTH,
    "arm.forearm_mass": UsualDeviation(0.05, "share", _SEGMENTS),
    "spring.stiffness": UsualDeviation(0.05, "share", _MAKER, has_sides=True),
    "spool.ratio": UsualDeviation(0.01, "share", _MAKER),
    "spool.flexor_radius": UsualDeviation(0.01, "share", _MAKER),
    "sheath.friction": UsualDeviation(0.2, "share", _SHEATHS, has_sides=True),
    "sheath.bend_angle": UsualDeviation(0.05, "share", _PROTRACTOR, has_sides=True),
    "tendon.youngs_modulus": UsualDeviation(0.1, "share", _MAKER, has_sides=True),
    "tendon.length": UsualDeviation(0.02, "share", _MAKER, has_sides=True),
    "joint.stiffness": UsualDeviation(0.3, "share", _PERSONS),
    "joint.rest_angle": UsualDeviation(math.radians(10.0), "amount", _PERSONS),
    "anchor.stiffness": UsualDeviation(1.4, "factor", _ASSUMED, has_sides=True),
}
"""Usual deviations by the common keys of numbers (`split_side`)."""
_JOINT = ("joint.stiffness", "joint.rest_angle")
_MEASURED_TRAVELS = ("arm.a1", "arm.b1", "arm.a2", "arm.b2", "arm.elbow_radius")
"""Numbers that count for nothing where a joint's travels were measured."""


def usual_deviations(study: Study) -> dict[str, UsualDeviation]:
    """Return what a study leaves to be drawn, by key; of a number with sides each side has its own.

    Left out are numbers with a deviation of their own, those named exact, conditions, stiffnesses
    that are rigid or zero in every design, and what a survey's persons scatter in themselves.
    """
    found = {}
    for common, deviation in USUAL.items():
        if not _matters(study, common):
            continue
        sides = SIDES if deviation.has_sides else (None,)
        for side in sides:
            key = common if side is None else of_side(common, side)
            if not _is_known(study, key):
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


def _is_known(study: Study, key: str) -> bool:
    """Return True if a number is exact, is a condition, or has a deviation of its own."""
    common = split_side(key)[0]
    own = study.uncertain.keys()
    drawn = {
        of_row
        for table in study.row_tables
        if table.key in study.drawn_tables
        for of_row in table.keys
    }
    is_stated = not own.isdisjoint((key, common)) or not drawn.isdisjoint((key, common))
    is_condition = not {key, common}.isdisjoint(study.conditions)
    return is_stated or is_condition or study.is_exact(key)


def drawn_numbers(study: Study, drawn: Mapping[str, Array]) -> dict[str, Array]:
    """Return draws of usual deviations as the shifts and factors of a space, and others as given.

    Args:
        study: The study.
        drawn: Draws by the keys of `Study.to_draw`, (draws,) each.
    """
    usual = study.usual
    numbers: dict[str, Array] = {}
    for key, values in drawn.items():
        if key not in usual:
            numbers[key] = values
        elif usual[key].kind == "amount":
            numbers[shift_of(key)] = values
        else:
            numbers[factor_of(key)] = values
    return numbers
