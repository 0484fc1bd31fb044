"""Usual deviations of numbers that a study states without one of their own.

An answer draws them, a fit to a log takes them as priors, and texts quote them. Sources: a tape on
a wearer; makers' tolerances; tables of body segments; the spread between sheaths, and between
persons. Nobody has measured how the cuffs of a suit spread, so that theirs is assumed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from tendon_cli import say
from tendon_cli.studies.contents import keys
from tendon_cli.studies.values import Uncertain

Kind = Literal["amount", "share", "factor"]
"""A deviation in the unit of the number, as a share of it, or as a factor either way."""
_TAPE = "a tape on a wearer"
_SEGMENTS = "tables of body segments"
_MAKER = "makers' tolerance"
_SHEATHS = "spread between sheaths"
_PROTRACTOR = "a protractor on a worn sheath"
_PERSONS = "scatter between persons"
_ASSUMED = "assumed: nobody has measured how far they differ"


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
