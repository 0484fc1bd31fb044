"""Tables of a study: their numbers with keys and columns, and each table as a file would say it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, get_args

from pydantic import AfterValidator, StringConstraints
from pydantic.fields import FieldInfo

from tendon_cli.quantities import QUANTITIES, Quantity, bound_name
from tendon_cli.studies.design_section import Limits
from tendon_cli.studies.fields import SingleField, fault
from tendon_cli.studies.number import NumberField
from tendon_cli.studies.parts import (
    Anchor,
    Arm,
    Joint,
    Load,
    Model,
    Motion,
    Part,
    Setting,
    Sheath,
    Spool,
    Spring,
    Tendon,
)
from tendon_cli.studies.space.axis import limit_of, split_side
from tendon_cli.studies.values import StudyNumber

_NOTABLE_SHARE = 1e-3
"""Largest share of a distribution that may be cut off without a warning."""


# --- Numbers of a table --------------------------------------------------------------------------


@cache
def field_kinds(part: type[Part]) -> dict[str, SingleField | type[Part] | None]:
    """Return what each field of a table holds: the mark of a number, the type of a table, or None.

    Both may stand on one choice of a union, and the type is that of each table of a list.
    """
    return {name: _kind_of(field) for name, field in part.model_fields.items()}


def _kind_of(field: FieldInfo) -> SingleField | type[Part] | None:
    marks = [*field.metadata]
    for choice in (field.annotation, *get_args(field.annotation)):
        if isinstance(choice, type) and issubclass(choice, Part):
            return choice
        marks += get_args(choice)
    return next((mark for mark in marks if isinstance(mark, SingleField)), None)


@cache
def fields_in(part: type[Part]) -> dict[str, SingleField | type[Part] | None]:
    """Return what the fields of a table and of all tables in it hold, by dotted key."""
    fields: dict[str, SingleField | type[Part] | None] = {}
    for name, kind in field_kinds(part).items():
        fields[name] = kind
        if isinstance(kind, type):
            fields |= {f"{name}.{inner}": held for inner, held in fields_in(kind).items()}
    return fields


def values_in(part: Part, prefix: str) -> Iterator[tuple[str, Any, Any]]:
    """Yield every value of a table that is no table, with its dotted key and what its field holds.

    Args:
        part: The table; the tables inside it are searched, too, but no lists of tables.
        prefix: Dotted key of the table itself; empty for a whole study.
    """
    for name, kind in field_kinds(type(part)).items():
        value = getattr(part, name)
        key = f"{prefix}.{name}".removeprefix(".")
        if isinstance(value, Part):
            yield from values_in(value, key)
        else:
            yield key, kind, value


def marked_numbers(part: Part, prefix: str) -> Iterator[tuple[str, SingleField, StudyNumber]]:
    """Yield every number that a table holds, with its dotted key and the mark of its field."""
    for key, kind, value in values_in(part, prefix):
        if isinstance(value, StudyNumber) and isinstance(kind, SingleField):
            yield key, kind, value


def part_document(part: Part) -> dict[str, Any]:
    """Return a table with its defaults, in SI, such that it reads back as the same table."""
    content: dict[str, Any] = {}
    for name, field in type(part).model_fields.items():
        value = None if field.exclude else getattr(part, name)
        kind = field_kinds(type(part))[name]
        if isinstance(value, Part):
            content[name] = part_document(value)
        elif isinstance(value, StudyNumber) and isinstance(kind, SingleField):
            content[name] = value.document(kind.quantity.dimension)
        elif value is not None and hasattr(value, "document"):
            content[name] = value.document()
        elif isinstance(value, tuple):
            # An empty list differs from a key that is left out only if the default is None.
            if value or field.default is None:
                content[name] = [
                    item.document() if hasattr(item, "document") else item for item in value
                ]
        elif value is not None:
            content[name] = value
    return content


def warn_of_distributions(
    numbers: Iterable[tuple[str, SingleField, StudyNumber]],
) -> Iterator[str]:
    """Yield a sentence for each uncertain number of whose distribution some is impossible."""
    for key, mark, values in numbers:
        distribution = values.uncertain
        if distribution is not None and distribution.cut_share > _NOTABLE_SHARE:
            unit = f" {mark.quantity.unit}".removesuffix(" 1")
            span = f"{distribution.low:g} to {distribution.high:g}{unit}"
            cut_off = f"{distribution.cut_share:.1%} of its distribution is cut off"
            yield f"{key} can only be {span}: {cut_off}"


# --- Titles and tables ---------------------------------------------------------------------------


def _check_printable(text: str) -> str:
    """Return a text that can stand in metadata, figures and terminals; refuse any other."""
    if not text.isprintable():
        raise fault("holds characters that cannot be printed, expected plain text")
    return text


Title = Annotated[
    str, StringConstraints(max_length=300, strict=True), AfterValidator(_check_printable)
]
DESIGN_PARTS: dict[str, type[Part]] = {
    part.__name__.lower(): part
    for part in (Arm, Sheath, Tendon, Spring, Anchor, Joint, Spool, Load, Model, Setting, Limits)
}
"""Tables that describe a design, by their keys."""


# --- Keys and columns ----------------------------------------------------------------------------

_SHORT_COLUMNS = {
    "sheath.friction": "friction",
    "sheath.bend_angle": "bend_angle",
    "tendon.pretension": "pretension",
}


@dataclass(frozen=True)
class Key:
    """The dotted key of a number, such as `tendon.flexor.pretension`."""

    path: str
    """The key itself."""
    number: NumberField
    """Mark of the field: the quantity and the range of the number."""

    @property
    def column(self) -> str:
        """Column of the tables that holds the number."""
        return column_of(self.path)

    @property
    def quantity(self) -> Quantity:
        """Quantity of the number: of a limit the bound, not what it bounds."""
        limit = limit_of(self.path)
        return self.number.quantity if limit is None else QUANTITIES[bound_name(limit)]


def column_of(key: str) -> str:
    """Return the column of an axis: its key joined by `_`, with the side last.

    The keys of three common numbers are shortened, such as `sheath.friction` to `friction`. The
    column of a limit is its name after "limit_".
    """
    limit = limit_of(key)
    if limit is not None:
        return bound_name(limit)
    common, side = split_side(key)
    column = _SHORT_COLUMNS.get(common, common.replace(".", "_"))
    return f"{column}_{side}" if side else column


@cache
def _fields() -> dict[str, SingleField | type[Part] | None]:
    """Return what the tables of the suit and of its motion hold, and these, by dotted key."""
    fields: dict[str, SingleField | type[Part] | None] = {}
    tables: dict[str, type[Part]] = {**DESIGN_PARTS, "motion": Motion}
    for name, part in tables.items():
        fields[name] = part
        fields |= {f"{name}.{inner}": held for inner, held in fields_in(part).items()}
    return fields


@cache
def keys() -> dict[str, Key]:
    """Return every number that may be an axis, by its dotted key, in the order of the schema."""
    return {
        path: Key(path, mark) for path, mark in _fields().items() if isinstance(mark, NumberField)
    }


def is_key_of_study(path: str) -> bool:
    """Return True for a key that says something of the suit or its motion, or for its table."""
    return path in _fields()
