"""`[[cases]]`: one axis, each entry a table of the study in which every key has one value or none."""

from __future__ import annotations

from types import UnionType
from typing import Annotated, Any

from pydantic import AfterValidator, Field, StringConstraints, create_model

from tendon_cli.studies.contents import mark_of, part_of
from tendon_cli.studies.fields import Single, fault
from tendon_cli.studies.parts import Anchor, Arm, Joint, Load, Model, Part, Setting, Sheath, Spool, Spring, Tendon
from tendon_cli.studies.values import Values


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


def _single_valued(part: type[Part]) -> type[Part]:
    """The same table where no key has a default and none may be an axis: what a case may override."""
    fields: dict[str, Any] = {}
    for name, field in part.model_fields.items():
        number, nested = mark_of(field), part_of(field)
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
