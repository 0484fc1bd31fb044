"""What stands in a table of a study: its numbers with their keys, and the table as a file would say it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args

from pydantic.fields import FieldInfo

from tendon_cli.studies.fields import Single
from tendon_cli.studies.parts import Part
from tendon_cli.studies.values import Values


def mark_of(field: FieldInfo) -> Single | None:
    """The Single that marks a field, alone or as one choice of a union with None."""
    marks = [*field.metadata, *(mark for choice in get_args(field.annotation) for mark in get_args(choice))]
    return next((mark for mark in marks if isinstance(mark, Single)), None)


def part_of(field: FieldInfo) -> type[Part] | None:
    """The table that a field holds, alone or as one choice of a union with None."""
    choices = (field.annotation, *get_args(field.annotation))
    return next((choice for choice in choices if isinstance(choice, type) and issubclass(choice, Part)), None)


def numbers_in(part: Part, prefix: str) -> list[tuple[str, Values]]:
    """The numbers that stand in a part and its sides, with their dotted keys."""
    return [(key, values) for key, _, values in marked(part, prefix)]


def case_numbers(case: Part) -> dict[str, float]:
    """The numbers that a case overrides, by dotted key, in SI."""
    parts = [(name, getattr(case, name)) for name in type(case).model_fields]
    return {
        key: values.single for name, part in parts if isinstance(part, Part) for key, values in numbers_in(part, name)
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
        value = getattr(part, name)
        if field.exclude:
            continue
        if isinstance(value, Part):
            shown[name] = document(value)
        elif isinstance(value, Values) and (number := mark_of(field)):
            shown[name] = value.document(number.quantity.dimension)
        elif isinstance(value, tuple):
            if value or field.default is None:
                shown[name] = [document(item) if isinstance(item, Part) else item for item in value]
        elif value is not None:
            shown[name] = value
    return shown
