"""The columns of a table by name: their quantities, filters on them, and derived quantities."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli import say
from tendon_cli.errors import UsageError
from tendon_cli.quantities import (
    OF_CYCLES,
    OF_DESIGNS,
    OF_FIGURES,
    OF_STATES,
    OF_TRAJECTORIES,
    QUANTITIES,
    SIDES,
    Quantity,
)
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.filters import Condition, Filter, read_filter
from tendon_cli.studies.study import keys
from tendon_cli.units import SI_UNIT, shorten

ColumnArray = npt.NDArray[Any]
"""Numbers, NaN where there is none; truths as 1 and 0; words, "" where there is none."""

TRUTHS = ("taut", "stable", "feasible")
"""Columns of designs that are true or false."""


_OF_MOTION = ("motion.elbow_angle", "motion.direction")
"""Keys of the motion that are columns of states."""


@dataclass(frozen=True)
class TableColumns:
    """Columns of a table, and the derived quantities that follow from them."""

    quantities: Mapping[str, Quantity | None]
    """Quantity of each column; None for words and truths."""
    truths: frozenset[str] = frozenset(TRUTHS)
    """Columns that are true or false."""

    @classmethod
    def of(cls, schema: pa.Schema) -> TableColumns:
        """Return the columns of a table on the disk or in memory."""
        held = {
            field.name: quantity_in(field) if _is_number(field.type) else None for field in schema
        }
        truths = frozenset(field.name for field in schema if field.type == pa.bool_())
        return cls(with_derived(held), truths)

    def find(self, name: str, option: str) -> str:
        """Return a column by its name or by its key in a study.

        Args:
            name: The name or key.
            option: The option that names it, for messages.

        Raises:
            UsageError: There is no such column; the hint has the nearest name.
        """
        if name in self.quantities:
            return name
        column = column_named(name)
        if column in self.quantities:
            return column
        its_keys = [key for key, field in keys().items() if field.column in self.quantities]
        hint = (
            _hint_at_other_tables(column)
            or hint_at_nearest(name, [*self.quantities, *its_keys])
            or f"columns: {', '.join(self.quantities)}"
        )
        raise UsageError(f'the table has no column "{shorten(name)}"', where=option, hint=hint)

    def find_numbers(self, name: str, option: str) -> str:
        """Return a column of numbers, as `find` does; raises UsageError."""
        column = self.find(name, option)
        if self.quantities[column] is None:
            raise UsageError(f"{column} holds words, expected a column of numbers", where=option)
        return column

    def conditions(
        self, filters: Iterable[Filter | str], axis_values: Mapping[str, ColumnArray]
    ) -> list[Condition]:
        """Return the conditions that filters set on the columns; raises UsageError.

        Args:
            filters: The filters.
            axis_values: Values that axes give columns, as `axis_values_of` returns them.
        """
        read = [read_filter(item) if isinstance(item, str) else item for item in filters]
        columns = [self.find(item.name, "--where") for item in read]
        return [
            item.condition_on(
                column,
                self.quantities[column],
                axis_values.get(column),
                is_truth=column in self.truths,
            )
            for item, column in zip(read, columns, strict=True)
        ]

    def stored(self, names: Iterable[str]) -> list[str]:
        """Return the columns to be read from the table, so that `compute` can give some columns."""
        stored: list[str] = []
        for name in names:
            stored += needs(name, self.quantities) or [name]
        return list(dict.fromkeys(stored))

    def compute(self, names: Iterable[str], read: dict[str, ColumnArray]) -> dict[str, ColumnArray]:
        """Return columns by name, the derived ones by their formulas.

        Args:
            names: Names of the columns.
            read: Values of the columns that `stored` names.
        """
        columns = {}
        for name in names:
            if name in DERIVED:
                arguments = [read[need] for need in needs(name, self.quantities)]
                columns[name] = np.asarray(DERIVED[name].formula(*arguments), dtype=np.float64)
            else:
                columns[name] = read[name]
        return columns


def _hint_at_other_tables(column: str) -> str:
    """Say which table has a column that this one lacks; empty if none of a sweep has it."""
    if column in OF_CYCLES:
        return "designs of a sweep have it, if its study states motion.speed or motion.trajectory"
    if column in OF_TRAJECTORIES:
        return "designs of a sweep have it, if its study states motion.trajectory"
    if column in OF_DESIGNS:
        return "designs of a sweep have it"
    if column in OF_STATES:
        return "states of a sweep have it"
    return ""


def column_named(name: str) -> str:
    """Return the column of a name, which may be a key of a study such as load.mass."""
    if name in _OF_MOTION:
        return name.removeprefix("motion.")
    return keys()[name].column if name in keys() else name


def needs(name: str, columns: Mapping[str, object]) -> list[str]:
    """Return the columns that a derived quantity follows from; none for any other column.

    If a column differs by side, that of the quantity's side counts.
    """
    derived = DERIVED.get(name)
    if derived is None:
        return []
    needed = []
    for need in derived.needs:
        of_side = f"{need}_{derived.side}"
        needed.append(of_side if of_side in columns else need)
    return needed


def with_derived(held: Mapping[str, Quantity | None]) -> dict[str, Quantity | None]:
    """Return the columns of a table and the derived quantities that follow from them."""
    offered = {
        name: derived.quantity
        for name, derived in DERIVED.items()
        if set(needs(name, held)) <= set(held)
    }
    return {**held, **offered}


def quantity_in(field: pa.Field) -> Quantity:
    """Return the quantity of a column, as it is read; an unknown one has the name and the unit."""
    metadata = field.metadata or {}
    name = metadata.get(b"quantity", b"").decode()
    unit = metadata.get(b"unit", b"1").decode()
    words = say.spaced(field.name)
    unknown = Quantity(field.name, words, "number", unit, unit, field.name)
    known = QUANTITIES.get(name, unknown)
    if unit == known.unit:
        return known
    dimension = next((key for key, si in SI_UNIT.items() if si == unit), known.dimension)
    return replace(known, dimension=dimension, unit=unit, shown_in=unit)


def _is_number(kind: pa.DataType) -> bool:
    return bool(pa.types.is_floating(kind) or pa.types.is_integer(kind))


# --- Derived quantities ---------------------------------------------------------------------------
#
# No table has them, and a figure may show them: each follows from columns of states, row by row.


@dataclass(frozen=True)
class Derived:
    """A quantity that follows from some columns."""

    quantity: Quantity
    needs: tuple[str, ...]
    """Columns; if a table has one for each side, that of `side` counts."""
    side: str
    formula: Callable[..., ColumnArray]
    """Takes the columns in the order of `needs`, SI."""


def _radius_ratio(flexor_travel: ColumnArray, extensor_travel: ColumnArray) -> ColumnArray:
    """Return the ratio of the travels; NaN where the extensor does not move."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(extensor_travel == 0.0, np.nan, flexor_travel / extensor_travel)


def _elongation(
    tension: ColumnArray,
    pretension: ColumnArray,
    tendon_stretch: ColumnArray,
    spring_stretch: ColumnArray,
) -> ColumnArray:
    """Return the elongation from no load, c F, m.

    Stretches are from the pretensioned state and linear in tension, c (F - F0).
    """
    change = tension - pretension
    with np.errstate(divide="ignore", invalid="ignore"):
        compliance = np.where(change == 0.0, np.nan, (tendon_stretch + spring_stretch) / change)
    return np.asarray(compliance * tension)


def _derived_of_side(side: str) -> dict[str, Derived]:
    """Return the derived quantities of one side by their names."""
    tension = f"{side}_tension_distal"
    stretches = (f"{side}_tendon_stretch", f"{side}_spring_stretch")
    formulas: dict[str, tuple[tuple[str, ...], Callable[..., ColumnArray]]] = {
        "length_change": (stretches, np.add),
        "elongation": ((tension, "pretension", *stretches), _elongation),
        "spring_elongation": ((tension, "spring_stiffness"), np.divide),
    }
    return {
        f"{side}_{name}": Derived(OF_FIGURES[f"{side}_{name}"], needed, side, formula)
        for name, (needed, formula) in formulas.items()
    }


DERIVED = {
    "radius_ratio": Derived(
        OF_FIGURES["radius_ratio"], ("flexor_travel", "extensor_travel"), "", _radius_ratio
    )
}
"""Derived quantities by their names."""
for _side in SIDES:
    DERIVED |= _derived_of_side(_side)
