"""What stands in a table of a study: its numbers with their keys and columns, and the table as a file would say it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, Field, StringConstraints, create_model
from pydantic.fields import FieldInfo

from tendon_cli.quantities import PLAUSIBLE
from tendon_cli.space.axis import split_side
from tendon_cli.studies.angle_curves import CurveColumns, CurveTable
from tendon_cli.studies.fields import OneOf, Single, fault
from tendon_cli.studies.number import Number
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
from tendon_cli.studies.values import Values


def mark_of(field: FieldInfo) -> Single | None:
    """The Single that marks a field, alone or as one choice of a union with None."""
    marks = [
        *field.metadata,
        *(mark for choice in get_args(field.annotation) for mark in get_args(choice)),
    ]
    return next((mark for mark in marks if isinstance(mark, Single)), None)


def part_of(field: FieldInfo) -> type[Part] | None:
    """The table that a field holds, alone or as one choice of a union with None."""
    choices = (field.annotation, *get_args(field.annotation))
    return next(
        (choice for choice in choices if isinstance(choice, type) and issubclass(choice, Part)),
        None,
    )


def case_numbers(case: Part) -> dict[str, float]:
    """The numbers that a case overrides, by dotted key, in SI."""
    parts = [(name, getattr(case, name)) for name in type(case).model_fields]
    return {
        key: each.single
        for name, part in parts
        if isinstance(part, Part)
        for key, _, each in marked(part, name)
    }


def marked(part: Part, prefix: str) -> Iterator[tuple[str, Single, Values]]:
    """The numbers of a part with their dotted keys, and what each may be."""
    for name, field in type(part).model_fields.items():
        value = getattr(part, name)
        if isinstance(value, Values) and (number := mark_of(field)):
            yield f"{prefix}.{name}", number, value
        elif isinstance(value, Part):
            yield from marked(value, f"{prefix}.{name}")


def document(part: Part) -> dict[str, Any]:
    """A table with its defaults, in SI; reads back as the same table."""
    shown: dict[str, Any] = {}
    for name, field in type(part).model_fields.items():
        value = None if field.exclude else getattr(part, name)
        if isinstance(value, CurveTable):
            shown[name] = value.document()
        elif isinstance(value, Part):
            shown[name] = document(value)
        elif isinstance(value, Values) and (number := mark_of(field)):
            shown[name] = value.document(number.quantity.dimension)
        elif isinstance(value, tuple):
            if value or field.default is None:
                shown[name] = [document(item) if isinstance(item, Part) else item for item in value]
        elif value is not None:
            shown[name] = value
    return shown


def remarks(numbers: Iterable[tuple[str, Single, Values]]) -> Iterator[str]:
    """A sentence for each number that is far from any arm, or whose distribution reaches where it is impossible."""
    for key, number, values in numbers:
        low, high = PLAUSIBLE.get(number.name, (number.low, number.high))
        unit = f" {number.quantity.unit}".removesuffix(" 1")
        for value in dict.fromkeys(values.extremes):
            if not low <= value <= high and not math.isinf(value):
                yield f"{key} = {value:g} is {value:g}{unit}, far from any arm ({low:g} to {high:g}{unit})"
                break
        known = values.uncertain
        if known is not None and known.cut_share > 1e-3:
            span = f"{known.low:g} to {known.high:g}{unit}"
            yield f"{key} can only be {span}: {known.cut_share:.1%} of its distribution is cut off"


def printable(text: str) -> str:
    """Text that can stand in a table's metadata, a figure and a terminal."""
    if not text.isprintable():
        raise fault("holds characters that cannot be printed, expected plain text")
    return text


CaseName = Annotated[
    str, StringConstraints(min_length=1, max_length=200, strict=True), AfterValidator(printable)
]
Title = Annotated[str, StringConstraints(max_length=300, strict=True), AfterValidator(printable)]


_NOT_OF_CASES = ("smoothing", "scale_with", "read")


def _single_valued(part: type[Part]) -> type[Part]:
    """The same table where no key has a default and none may be an axis: what a case may override."""
    fields: dict[str, Any] = {}
    for name, field in part.model_fields.items():
        number, nested = mark_of(field), part_of(field)
        choice = next((mark for mark in field.metadata if isinstance(mark, OneOf)), None)
        if name in _NOT_OF_CASES or any(isinstance(mark, CurveColumns) for mark in field.metadata):
            continue  # the numbers of a case differ, not the joint
        if number is not None:
            kind: Any = Annotated[Values, Single(number.name, number.low, number.high, number.word)]
        elif choice is not None:
            kind = Literal[choice.words]
        else:
            kind = _single_valued(nested) if nested else field.annotation
        fields[name] = (kind | None, Field(default=None, description=field.description))
    return create_model(f"Case{part.__name__}", __base__=Part, __doc__=part.__doc__, **fields)


DESIGN_PARTS: dict[str, type[Part]] = {
    part.__name__.lower(): part
    for part in (Arm, Sheath, Tendon, Spring, Anchor, Joint, Spool, Load, Model, Setting)
}


def case_tables() -> Any:
    """The type of `[[cases]]`, which few studies have."""
    fields: dict[str, Any] = {"name": (CaseName, Field(description="name of the case, each once"))}
    fields |= {name: (_single_valued(part) | None, None) for name, part in DESIGN_PARTS.items()}
    doc = "One case, such as a person: a name, and the keys in which it differs."
    return tuple[create_model("Case", __base__=Part, __doc__=doc, **fields), ...]  # type: ignore[misc]


_SHORT_COLUMNS = {
    "sheath.friction": "friction",
    "sheath.bend_angle": "bend_angle",
    "tendon.pretension": "pretension",
}


@dataclass(frozen=True)
class Key:
    """The dotted key of a number, such as `tendon.flexor.pretension`."""

    path: str
    number: Number

    @property
    def column(self) -> str:
        """The column that holds it."""
        return column_of(self.path)


def column_of(key: str) -> str:
    """The column of an axis: its key joined with `_`, the side last, three of the common ones shortened."""
    common, side = split_side(key)
    column = _SHORT_COLUMNS.get(common, common.replace(".", "_"))
    return f"{column}_{side}" if side else column


@cache
def keys() -> dict[str, Key]:
    """Every number that may be an axis, by its dotted key, in the order of the schema."""
    tables: dict[str, type[Part]] = {**DESIGN_PARTS, "motion": Motion}
    return {
        key: Key(key, number)
        for name, part in tables.items()
        for key, number in _numbers_of(part, name)
    }


def _numbers_of(part: type[Part], prefix: str) -> Iterator[tuple[str, Number]]:
    for name, field in part.model_fields.items():
        number, inner = mark_of(field), part_of(field)
        if isinstance(number, Number):
            yield f"{prefix}.{name}", number
        elif inner is not None:
            yield from _numbers_of(inner, f"{prefix}.{name}")
