"""The columns of a table by name: what each holds, which one a name means, what a filter asks of it, its values."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.errors import UsageError
from tendon_cli.quantities import OF_FIGURES, QUANTITIES, Quantity
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.filters import Condition, Filter, read_filter
from tendon_cli.studies.study import keys
from tendon_cli.units import shorten

Values = npt.NDArray[Any]
"""Numbers, NaN where there is none; truths as 1 and 0; words, "" where there is none."""

TRUTHS = ("taut", "stable", "feasible")
"""Columns of designs that are true or false."""


@dataclass(frozen=True)
class Columns:
    """The columns of a table, those included that follow from others."""

    held: Mapping[str, Quantity | None]
    """What each holds; words and truths are no quantity."""
    truths: frozenset[str] = frozenset(TRUTHS)

    @classmethod
    def of(cls, schema: pa.Schema) -> Columns:
        """Those of a table on the disk or in memory."""
        held = {each.name: quantity_in(each) if _is_number(each.type) else None for each in schema}
        return cls(
            with_derived(held), frozenset(each.name for each in schema if each.type == pa.bool_())
        )

    def find(self, name: str, option: str) -> str:
        """A column by its name or by its key in a study; raises UsageError with the nearest name."""
        known, column = keys(), column_named(name)
        if name in self.held or column in self.held:
            return name if name in self.held else column
        hint = nearest(
            name, [*self.held, *(key for key, at in known.items() if at.column in self.held)]
        )
        hint = hint or f"columns: {', '.join(self.held)}"
        raise UsageError(f'the table has no column "{shorten(name)}"', where=option, hint=hint)

    def find_numbers(self, name: str, option: str) -> str:
        """A column of numbers by its name; raises UsageError."""
        column = self.find(name, option)
        if self.held[column] is None:
            raise UsageError(f"{column} holds words, expected a column of numbers", where=option)
        return column

    def conditions(self, filters: Iterable[Filter | str]) -> list[Condition]:
        """What filters ask of the columns, wherever they are written; raises UsageError."""
        asked = [read_filter(each) if isinstance(each, str) else each for each in filters]
        columns = [self.find(each.name, "--where") for each in asked]
        return [
            each.on(column, self.held[column], is_truth=column in self.truths)
            for each, column in zip(asked, columns, strict=True)
        ]

    def stored(self, names: Iterable[str]) -> list[str]:
        """The columns that must be read for some columns, each once."""
        return list(
            dict.fromkeys(need for name in names for need in (needs(name, self.held) or [name]))
        )

    def work_out(self, names: Iterable[str], read: dict[str, Values]) -> dict[str, Values]:
        """Columns by name from those that were read, the derived ones by their formulas."""
        return {
            name: np.asarray(
                DERIVED[name].of(*(read[need] for need in needs(name, self.held))), dtype=np.float64
            )
            if name in DERIVED
            else read[name]
            for name in names
        }


def column_named(name: str) -> str:
    """The column that a name means, which may be the key of a study."""
    return keys()[name].column if name in keys() else name


def needs(name: str, columns: Mapping[str, object]) -> list[str]:
    """The columns that a derived quantity follows from, those of its side if the sides differ; else none."""
    derived = DERIVED.get(name)
    return [
        side if derived and (side := f"{need}_{derived.side}") in columns else need
        for need in (derived.needs if derived else ())
    ]


def with_derived(held: Mapping[str, Quantity | None]) -> dict[str, Quantity | None]:
    """Columns, and the derived quantities that follow from them."""
    offered = {
        name: each.quantity for name, each in DERIVED.items() if set(needs(name, held)) <= set(held)
    }
    return {**held, **offered}


def quantity_in(field: pa.Field) -> Quantity:
    """What a column of a table holds; of one that we do not know its name and unit."""
    metadata = field.metadata or {}
    name, unit = (
        metadata.get(key, other).decode() for key, other in ((b"quantity", b""), (b"unit", b"1"))
    )
    return QUANTITIES.get(
        name, Quantity(field.name, field.name.replace("_", " "), "number", unit, unit, field.name)
    )


def _is_number(kind: pa.DataType) -> bool:
    return bool(pa.types.is_floating(kind) or pa.types.is_integer(kind))


# --- Quantities that no table has and a figure may show: each follows from columns of states, row by row --------------


@dataclass(frozen=True)
class Derived:
    """A quantity and how it follows from some columns."""

    quantity: Quantity
    needs: tuple[str, ...]
    """Columns; where a table has one per side, that of `side` counts."""
    side: str
    of: Callable[..., Values]
    """Takes the columns in the order of `needs`, SI values."""


def _ratio(flexor_travel: Values, extensor_travel: Values) -> Values:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(extensor_travel == 0.0, np.nan, flexor_travel / extensor_travel)


def _elongation(
    tension: Values, pretension: Values, tendon_stretch: Values, spring_stretch: Values
) -> Values:
    """Stretches are from the pretensioned state, and linear in tension, c (F - F0). From no load, c F."""
    change = tension - pretension
    with np.errstate(divide="ignore", invalid="ignore"):
        compliance = np.where(change == 0.0, np.nan, (tendon_stretch + spring_stretch) / change)
    return np.asarray(compliance * tension)


DERIVED = {
    "radius_ratio": Derived(
        OF_FIGURES["radius_ratio"], ("flexor_travel", "extensor_travel"), "", _ratio
    )
}
for _side in ("flexor", "extensor"):
    _stretches, _tension = (
        (f"{_side}_tendon_stretch", f"{_side}_spring_stretch"),
        f"{_side}_tension_distal",
    )
    for _name, _needs, _of in (
        ("length_change", _stretches, np.add),
        ("elongation", (_tension, "pretension", *_stretches), _elongation),
        ("spring_elongation", (_tension, "spring_stiffness"), np.divide),
    ):
        DERIVED[f"{_side}_{_name}"] = Derived(OF_FIGURES[f"{_side}_{_name}"], _needs, _side, _of)
