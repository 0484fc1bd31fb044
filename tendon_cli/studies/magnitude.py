"""Slips of magnitude: numbers far from any arm, and the units in which they would be plausible."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from tendon_cli.errors import Fault, InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import PLAUSIBLE, QUANTITIES
from tendon_cli.readers.table import Table
from tendon_cli.units import (
    UNITS,
    Measure,
    counted,
    described,
    factor_of,
    known_units,
    shorten,
    terminating,
    to_float,
)

_RARE = frozenset(
    (
        *("um", "km", "in", "mN", "cN", "daN", "gf", "kgf", "lbf", "N/cm", "t", "lb", "mrad"),
        *("rev", "mN m", "mNm", "N cm", "kg cm", "oz in", "us", "ns", "min", "h", "rev/s"),
    )
)
"""Units that are suggested only if no other fits."""
_MOST_SUGGESTED = 2
"""Largest number of units that a hint suggests."""
_MOST_LISTED = 5
"""Largest number of slips of one key that are listed one by one."""
_SMALLEST_SHARE = 64.0
"""Ratio of the largest plausible value to a small one, where the plausible range begins at 0."""


@dataclass(frozen=True)
class Slip:
    """Number of a study, or of one of its files, outside of the plausible range of its quantity."""

    quantity: str
    """Name of the quantity."""
    measure: Measure
    """The number with its unit, as it was understood."""
    given: str
    """The number as its author wrote it."""
    low: float
    """Smallest plausible value, SI."""
    high: float
    """Largest plausible value, SI."""
    place: str = ""
    """Place in the value of its key, such as "item 2"; empty if it is the value."""
    word: str | None = None
    """Word for infinity if the number may be infinite."""
    column: str = ""
    """Name of the column of a file that holds the number; empty for a number of the study."""

    @property
    def problem(self) -> str:
        """The number, how it was understood, and the plausible range."""
        quantity = QUANTITIES[self.quantity]
        unit_size = factor_of(quantity.shown_in)
        shown_in = "" if quantity.shown_in == "1" else f" {quantity.shown_in}"
        expected = f"expected {self.low / unit_size:,.6g} to {self.high / unit_size:,.6g}{shown_in}"
        says_its_unit = quantity.unit == "1" or self.given.rstrip('"').endswith(
            self.measure.unit.symbol
        )
        understood = "" if says_its_unit else f" {_value_text(self.measure)},"
        whose = "person" if self.quantity in DIMENSIONS else "arm"
        place = f"{self.place}: " if self.place else ""
        return f"{place}{self.given} is{understood} far from any {whose}, {expected}"

    @property
    def suggestions(self) -> list[str]:
        """Values that the author may have meant, the most plausible first."""
        meant = units_that_fit(self.measure, self.low, self.high)
        if self.word is not None and self.measure.si > self.high:
            meant.append(self.word)
        return meant

    @property
    def note(self) -> str:
        """The number in SI and the plausible range, for a study that accepts it."""
        unit = f" {QUANTITIES[self.quantity].unit}".removesuffix(" 1")
        value = self.measure.si
        words = ", ".join(filter(None, (self.place, self.column)))
        place = f" {words}" if words else ""
        whose = "person" if self.quantity in DIMENSIONS else "arm"
        span = f"{self.low:g} to {self.high:g}{unit}"
        return f"{place} = {value:g} is {value:g}{unit}, far from any {whose} ({span})"


def slip_of(
    quantity: str, measure: Measure, given: object, place: str = "", word: str | None = None
) -> Slip | None:
    """Return the slip of a number; None if it is plausible, or if no range is known.

    Zero is none: it is zero in every unit.

    Args:
        quantity: Name of the quantity.
        measure: The number with its unit.
        given: The number as the study has it.
        place: Place in the value of its key.
        word: Word for infinity if the number may be infinite.
    """
    known = PLAUSIBLE.get(quantity)
    value = measure.si
    if known is None or known[0] <= value <= known[1] or value == 0.0:
        return None
    return Slip(quantity, measure, described(given), *known, place, word)


def spread_slip(quantity: str, spread: Measure, given: object, place: str) -> Slip | None:
    """Return the slip of a tolerance or standard deviation wider than the plausible range."""
    known = PLAUSIBLE.get(quantity)
    if known is None or spread.si <= known[1] - known[0]:
        return None
    return Slip(quantity, spread, described(given), 0.0, known[1] - known[0], place)


def column_slips(
    quantity: str, values: Array, unit: str, name: str, places: Sequence[str]
) -> tuple[Slip, ...]:
    """Return the slips of a column of a file.

    Args:
        quantity: Name of the quantity.
        values: Numbers of the column, SI; NaN where it has none.
        unit: Symbol of the unit of the column.
        name: Name of the column.
        places: File and line of each number.
    """
    if quantity not in PLAUSIBLE:
        return ()
    low, high = PLAUSIBLE[quantity]
    slips = []
    for row in np.flatnonzero((values < low) | (values > high)).tolist():
        written = float(values[row]) / factor_of(unit)
        measure = Measure(f"{written:.12g}", UNITS[unit])
        slip = slip_of(quantity, measure, "", places[row])
        if slip is not None:
            given = f"{name} of {_value_text(measure)}"
            slips.append(replace(slip, given=given, column=name))
    return tuple(slips)


def raise_with_slips(table: Table, slips: Sequence[Slip]) -> None:
    """Raise the faults of a table with values far from any arm beside them, if there are faults.

    Such values are no faults by themselves: a study may accept them.
    """
    if table.faults:
        for slip in slips:
            problem = replace(slip, place="").problem
            hint = hint_at_units(slip.suggestions)
            table.faults.append(InputError(problem, where=slip.place, hint=hint))
    table.raise_faults()


def step_slips(times: Array, unit: str, place: str) -> tuple[Slip, ...]:
    """Return the slip of the usual time between two samples of a motion in time, if it is one.

    Args:
        times: Times in order, s.
        unit: Symbol of their unit.
        place: File or key of the times.
    """
    step = np.array([np.median(np.diff(times))])
    return column_slips("time", step, unit, "a time between samples", [place])


def units_that_fit(measure: Measure, low: float, high: float) -> list[str]:
    """Return the number in each unit of its dimension in which it is plausible.

    The first is the one in which it is nearest to the middle of the range, by its factor. Rare
    units are named if it fits in no other. The numbers are as a study has them, such as "11 cm".

    Args:
        measure: The number with the unit that makes it implausible.
        low: Smallest plausible value, SI.
        high: Largest plausible value, SI.
    """
    number = Fraction(measure.text)
    if not number:
        return []
    smallest = low if low > 0.0 else high / _SMALLEST_SHARE
    middle = math.sqrt(abs(smallest * high))
    distances: dict[str, float] = {}
    factors = {measure.unit.factor}
    for symbol in known_units(measure.unit.dimension):
        unit = UNITS[symbol]
        value = to_float(number * unit.factor)
        if unit.factor not in factors and low <= value <= high:
            factors.add(unit.factor)
            distances[symbol] = abs(math.log(abs(value) / middle)) if value else math.inf
    digits = _digits(measure)
    usual = [symbol for symbol in distances if symbol not in _RARE]
    ordered = sorted(usual or distances, key=lambda symbol: distances[symbol])
    return [f"{digits} {symbol}".removesuffix(" 1") for symbol in ordered[:_MOST_SUGGESTED]]


def hint_at_units(meant: Iterable[str]) -> str | None:
    """Return the question for values that may have been meant; None if there are none."""
    listed = " or ".join(f'"{value}"' for value in meant)
    return f"did you mean {listed}?" if listed else None


def slip_faults(key: str, slips: Sequence[Slip]) -> Iterator[Fault]:
    """Yield a fault for each slip of a key; of many only the first ones, and their number."""
    for slip in slips[:_MOST_LISTED]:
        hint = hint_at_units(slip.suggestions)
        yield Fault(key, slip.problem, hint, is_implausible=True)
    for more in _more(slips):
        yield Fault(key, more, is_implausible=True)


def slip_notes(key: str, slips: Sequence[Slip]) -> Iterator[str]:
    """Yield a note for each slip of a key; of many only the first ones, and their number."""
    for slip in slips[:_MOST_LISTED]:
        yield f"{key}{slip.note}"
    for more in _more(slips):
        yield f"{key}: {more}"


def _more(slips: Sequence[Slip]) -> Iterator[str]:
    """Yield how many slips there are besides those that are listed, if there are any."""
    if len(slips) > _MOST_LISTED:
        yield f"and {counted(len(slips) - _MOST_LISTED, 'more value')} far from any arm"


def _digits(measure: Measure) -> str:
    """Return the number of a measure in plain digits."""
    digits = terminating(Fraction(measure.text))
    return shorten(measure.text if digits is None else digits, 40)


def _value_text(measure: Measure) -> str:
    """Return a measure with six digits and its unit."""
    value = to_float(Fraction(measure.text))
    return f"{value:.6g} {measure.unit.symbol}".removesuffix(" 1")
