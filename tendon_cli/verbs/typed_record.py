"""Records as trees of dataclasses: as JSON, and back from it by the types of their fields.

Each field says what it means and its unit: `angle: Annotated[float, "Elbow angle", "rad"]`. In JSON
it stands under its name, without a final underscore (`from_`). A field with a default is left out
where it has it. Values are SI; a number that is missing or not finite is null.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, fields
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Self, Union, get_args, get_origin, get_type_hints

AS_READ = "as read"
"""Unit of a number that is in the unit of what the gauge reads."""
OTHERS = "Other columns by their names"
"""Meaning of a field whose entries stand beside those of the other fields."""


@dataclass(frozen=True)
class RecordField:
    """A field of a record: where it stands, its type, and what it means."""

    name: str
    key: str
    """Name in JSON."""
    type: Any
    meaning: str
    unit: str
    """Unit, SI; empty for what has none, "SI" for that of the number that `key` names."""
    default: Any
    """Value of an entry that JSON leaves out; MISSING for one that always stands there."""

    @property
    def holds_others(self) -> bool:
        """True if its entries stand beside the other fields."""
        return self.meaning == OTHERS


class Record:
    """Dataclass that says what each of its fields means."""

    @classmethod
    def from_json(cls, content: Any, where: str = "") -> Self:
        """Return the record that JSON holds.

        Args:
            content: What was read.
            where: Its place, for the error.

        Raises:
            ValueError: An entry is missing, of another type, or not known.
        """
        if not isinstance(content, Mapping):
            raise _unfit(where, "a record", content)
        left = dict(content)
        values: dict[str, Any] = {}
        others = None
        for field in fields_of(cls):
            if field.holds_others:
                others = field
            elif field.key in left:
                place = f"{where}.{field.key}" if where else field.key
                values[field.name] = _read(field.type, left.pop(field.key), place)
            elif field.default is MISSING:
                raise ValueError(f"{where}: there is no {field.key}")
        if others is not None:
            values[others.name] = _read(others.type, left, where)
        elif left and not cls.has_more():
            raise ValueError(f"{where}: {', '.join(map(str, left))} is not known")
        return cls(**values)

    @classmethod
    def has_more(cls) -> bool:
        """Return True if JSON may hold entries that the record does not have."""
        return False


_FIELDS: dict[type[Record], tuple[RecordField, ...]] = {}


def fields_of(record: type[Record]) -> tuple[RecordField, ...]:
    """Return the fields of a class of records."""
    if record not in _FIELDS:
        hints = get_type_hints(record, include_extras=True)
        own = fields(record)  # type: ignore[arg-type]
        _FIELDS[record] = tuple(_field(field, hints[field.name]) for field in own)
    return _FIELDS[record]


def _field(field: Field[Any], hint: Any) -> RecordField:
    meaning = ""
    unit = ""
    if get_origin(hint) is Annotated:
        hint, meaning, *units = get_args(hint)
        unit = units[0] if units else ""
    default = field.default
    if field.default_factory is not MISSING:
        default = field.default_factory()
    return RecordField(
        name=field.name,
        key=field.name.removesuffix("_"),
        type=hint,
        meaning=meaning,
        unit=unit,
        default=default,
    )


def to_json(value: Any) -> Any:
    """Return a record, or what it holds, as JSON has it."""
    if isinstance(value, Record):
        content: dict[str, Any] = {}
        for field in fields_of(type(value)):
            entry = getattr(value, field.name)
            if field.holds_others:
                content |= to_json(entry)
            elif entry != field.default:
                content[field.key] = to_json(entry)
        return content
    if isinstance(value, Mapping):
        return {key: to_json(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [to_json(entry) for entry in value]
    return value


# --- Reading --------------------------------------------------------------------------------------

_PLAIN = {str: "a text", bool: "true or false", int: "a whole number", float: "a number"}


def _read(kind: Any, value: Any, where: str) -> Any:
    """Return a value of a type; raises ValueError if it is of another one."""
    origin = get_origin(kind)
    inner = get_args(kind)
    if kind is Any:
        return value
    if origin in (Union, UnionType):
        return _read_any_of(inner, value, where)
    if origin is Literal:
        if value not in inner:
            raise _unfit(where, " or ".join(map(repr, inner)), value)
        return value
    if origin is tuple:
        if not isinstance(value, list | tuple) or len(value) != len(inner):
            raise _unfit(where, f"a list of {len(inner)}", value)
        return tuple(_read(of, entry, where) for of, entry in zip(inner, value, strict=True))
    if origin in (list, Sequence):
        if not isinstance(value, list | tuple):
            raise _unfit(where, "a list", value)
        return [_read(inner[0], entry, f"{where}[{place}]") for place, entry in enumerate(value)]
    if origin is dict:
        if not isinstance(value, Mapping):
            raise _unfit(where, "a table", value)
        return {key: _read(inner[1], entry, f"{where}.{key}") for key, entry in value.items()}
    if isinstance(kind, type) and issubclass(kind, Record):
        return kind.from_json(value, where)
    if not _is_plain(kind, value):
        raise _unfit(where, _PLAIN[kind], value)
    return value


def _read_any_of(kinds: Sequence[Any], value: Any, where: str) -> Any:
    if value is None and NoneType in kinds:
        return None
    known = [kind for kind in kinds if kind is not NoneType]
    for kind in known[:-1]:
        try:
            return _read(kind, value, where)
        except ValueError:
            continue
    return _read(known[-1], value, where)


def _is_plain(kind: type, value: Any) -> bool:
    if kind is float:
        return type(value) in (int, float) and math.isfinite(value)
    return type(value) is kind


def _unfit(where: str, expected: str, value: Any) -> ValueError:
    return ValueError(f"{where}: expected {expected}, got {type(value).__name__}")
