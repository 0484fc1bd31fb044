"""What varies in a design question: choices, among which one picks, and conditions, which a design must survive."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array
from tendon_cli.studies.checks import case_numbers
from tendon_cli.studies.linked import Linked
from tendon_cli.studies.study import CASE_AXIS, PERSON_AXIS, Study, keys, split_side
from tendon_cli.studies.values import Grid

Numbers = Mapping[str, Array]
"""Numbers of some rows by dotted key, (rows,); NaN where a row leaves the number to the study."""

REFERENCE = "model.reference"
"""1 where a row measures the flexor's travel from the initial path, 0 where as published."""

PRETENSION = "tendon.pretension"


def scale_of(key: str) -> str:
    """The key under which a row says by what a number is multiplied, such as an anchor on a larger arm."""
    return f"scale of {key}"


@dataclass(frozen=True, eq=False)
class Factor:
    """One axis of the study: its dotted key (`case`, `person`, `draw`), its column, what values say of the numbers."""

    key: str
    column: str
    numbers: Numbers
    names: tuple[str, ...] = ()
    """Of linked values; a number has none."""
    is_range: bool = False
    """A grid, between whose points others may be chosen; a list is a catalogue."""
    is_log: bool = False
    weighting: Array | None = None
    """How much each value counts in a share; None where all count the same."""

    def __len__(self) -> int:
        return len(self.names) or len(self.values)

    @property
    def values(self) -> Array:
        """The values of a number in SI."""
        return self.numbers[self.key]


@dataclass(frozen=True, eq=False)
class Combinations:
    """Every combination of some factors, the last one fastest."""

    factors: tuple[Factor, ...]
    weighting: Array | None = None
    """Of each row; None where all count the same."""
    groups: npt.NDArray[np.int64] | None = None
    """Which rows must be served together to count, numbered from 0 and ascending; None where each counts by itself."""
    shape: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "shape", tuple(len(factor) for factor in self.factors))

    def __len__(self) -> int:
        return math.prod(self.shape)

    def places(self, rows: npt.NDArray[np.int64]) -> dict[str, npt.NDArray[np.int64]]:
        """Where rows stand on each factor."""
        if not self.factors:
            return {}
        at = np.unravel_index(rows, self.shape)
        return {factor.key: np.asarray(place) for factor, place in zip(self.factors, at, strict=True)}

    def numbers(self, rows: npt.NDArray[np.int64]) -> dict[str, Array]:
        """What rows say of the study's numbers."""
        at = self.places(rows)
        found: dict[str, Array] = {}
        for factor in self.factors:
            for key, values in factor.numbers.items():
                found[key] = values[at[factor.key]]
        return found

    def columns(self, rows: npt.NDArray[np.int64]) -> dict[str, npt.NDArray[np.generic]]:
        """Rows as a table has them: values, and of linked ones the position among their names."""
        at = self.places(rows)
        return {
            factor.column: at[factor.key] if factor.names else factor.values[at[factor.key]] for factor in self.factors
        }


def factors_of(study: Study) -> list[Factor]:
    """Every axis of a study but pretension, slowest first."""
    axes = [key for key in study.axes if split_side(key)[0] != PRETENSION]
    linked = {axis.key: _linked(study, axis) for axis in study.linked}
    return [linked.get(key) or (_cases(study) if key == CASE_AXIS else _number(study, key)) for key in axes]


def _linked(study: Study, axis: Linked) -> Factor:
    """Persons or draws, and how much each counts."""
    numbers = {key: values for key, values in axis.numbers.items() if split_side(key)[0] != PRETENSION}
    scales = {scale_of(key): values for key, values in axis.scales.items()}
    weighting = study.people.population.weighting if study.people is not None and axis.key == PERSON_AXIS else None
    return Factor(axis.key, axis.key, numbers | scales, tuple(axis.names), weighting=weighting)


def _number(study: Study, key: str) -> Factor:
    values = study.numbers[key]
    grid = values.source if isinstance(values.source, Grid) and values.source.num > 1 else None
    is_log = grid is not None and grid.log
    return Factor(key, keys()[key].column, {key: values.array}, is_range=grid is not None, is_log=is_log)


def _cases(study: Study) -> Factor:
    given = [case_numbers(case) for case in study.cases]
    named = dict.fromkeys(key for each in given for key in each)
    numbers = {key: np.array([each.get(key, np.nan) for each in given]) for key in named}
    references = [getattr(getattr(case, "model", None), "reference", None) for case in study.cases]
    if any(references):
        numbers[REFERENCE] = np.array([np.nan if each is None else float(each == "initial") for each in references])
    numbers = {key: values for key, values in numbers.items() if split_side(key)[0] != PRETENSION}
    return Factor(CASE_AXIS, CASE_AXIS, numbers, tuple(str(getattr(case, "name", "")) for case in study.cases))
