"""What stands in a table of a study: its numbers with their keys, and the table as a file would say it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from types import UnionType
from typing import Annotated, Any, get_args

from pydantic import AfterValidator, Field, StringConstraints, create_model
from pydantic.fields import FieldInfo

from tendon_cli.quantities import PLAUSIBLE
from tendon_cli.studies.curves import CurveColumns, CurveTable
from tendon_cli.studies.fields import Single, fault
from tendon_cli.studies.parts import Anchor, Arm, Joint, Load, Model, Part, Setting, Sheath, Spool, Spring, Tendon
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
        if isinstance(value, (Part, CurveTable)):
            shown[name] = value.document() if isinstance(value, CurveTable) else document(value)
        elif isinstance(value, Values) and (number := mark_of(field)):
            shown[name] = value.document(number.quantity.dimension)
        elif isinstance(value, tuple):
            if value or field.default is None:
                shown[name] = [document(item) if isinstance(item, Part) else item for item in value]
        elif value is not None:
            shown[name] = value
    return shown


_SHARE_TO_TELL = 1e-3


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
        if known is not None and known.cut_share > _SHARE_TO_TELL:
            span = f"{known.low:g} to {known.high:g}{unit}"
            yield f"{key} can only be {span}: {known.cut_share:.1%} of its distribution is cut off"


def printable(text: str) -> str:
    """Text that can stand in a table's metadata, a figure and a terminal."""
    if not text.isprintable():
        raise fault("holds characters that cannot be printed, expected plain text")
    return text


CaseName = Annotated[str, StringConstraints(min_length=1, max_length=200, strict=True), AfterValidator(printable)]


def _not_dots(name: str) -> str:
    if set(name) == {"."}:
        raise fault(f'"{name}" cannot name a run folder, expected a name such as fig07')
    return name


RunName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9._-]{1,64}$", strict=True), AfterValidator(_not_dots)]
Title = Annotated[str, StringConstraints(max_length=300, strict=True), AfterValidator(printable)]


_NOT_OF_CASES = ("smoothing", "scale_with", "read")


def _single_valued(part: type[Part]) -> type[Part]:
    """The same table where no key has a default and none may be an axis: what a case may override."""
    fields: dict[str, Any] = {}
    for name, field in part.model_fields.items():
        number, nested = mark_of(field), part_of(field)
        if name in _NOT_OF_CASES or any(isinstance(mark, CurveColumns) for mark in field.metadata):
            continue  # a case has numbers of its own, not another joint
        if number is not None:
            kind: Any = Annotated[Values, Single(number.name, number.low, number.high, number.word)]
        else:
            kind = _single_valued(nested) if nested else field.annotation
        optional = kind if isinstance(kind, UnionType) else kind | None
        fields[name] = (optional, Field(default=None, description=field.description))
    return create_model(f"Case{part.__name__}", __base__=Part, __doc__=part.__doc__, **fields)


DESIGN_PARTS: dict[str, type[Part]] = {
    "arm": Arm,
    "sheath": Sheath,
    "tendon": Tendon,
    "spring": Spring,
    "anchor": Anchor,
    "joint": Joint,
    "spool": Spool,
    "load": Load,
    "model": Model,
    "setting": Setting,
}


def case_tables() -> Any:
    """The type of `[[cases]]`, which few studies have."""
    fields: dict[str, Any] = {"name": (CaseName, Field(description="name of the case, each once"))}
    fields |= {name: (_single_valued(part) | None, None) for name, part in DESIGN_PARTS.items()}
    doc = "One case, such as a person: a name, and the keys in which it differs."
    return tuple[create_model("Case", __base__=Part, __doc__=doc, **fields), ...]  # type: ignore[misc]
