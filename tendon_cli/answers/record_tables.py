"""The record of an answer as tables: each number with its name, value, unit and meaning."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from tendon_cli import say
from tendon_cli.answers.phrases import value_words
from tendon_cli.quantities import AS_READ as COLUMNS_AS_READ
from tendon_cli.quantities import QUANTITIES, Quantity, in_unit_of_reading
from tendon_cli.studies.space.axis import evenly_spaced
from tendon_cli.studies.study import keys
from tendon_cli.verbs.answer_record import (
    AnswerResults,
    ChoiceRecord,
    QuestionRecord,
    SuitRecord,
    value_of,
)
from tendon_cli.verbs.typed_record import AS_READ, Record, RecordField, fields_of

_SECTIONS = {
    "best": "The choice named first",
    "setting": "Where it is set",
    "decided": "Why it is named first",
    "parts_needed": "Parts that it needs",
    "drift": "Beyond the upper end of its window",
    "between_samples": "Between the samples",
    "checks": "What the cutoff decides",
    "sensitivities": "What moves the window most",
    "assumed": "Assumed, and what each does to the window",
    "listed": "Pretensions that the study lists",
    "population": "For whom, or how sure",
    "best_by": "Best by each goal",
    "front": "Pareto front",
    "trade_offs": "What each limit buys",
    "proved": "Choices to be proved",
    "conflicts": "Why choices have no window",
    "fixes": "What changing one number would give, all else equal",
    "would_take": "What relaxing one demand would give, all else equal",
    "verified_by": "The fresh sample",
    "question": "The question",
}
"""Headings of the sections by the entries of the record, in the order in which they are printed."""
_HEAD = ("name", "value", "unit", "meaning")
_SHOWN_IN = {
    "m": ("mm", 1e-3),
    "rad": ("deg", math.radians(1.0)),
    "Pa": ("kPa", 1e3),
    "N/m": ("kN/m", 1e3),
}
"""Unit in which people read an SI unit, and its SI value."""
_TOLERANCES = ("tolerance_length", "too_long", "too_short")
_LONGEST = 8
"""Most entries of a list that stand in a cell."""
_LONGEST_WORDS = 32
"""Most characters of a value that stands in a cell; a longer one stands below the table."""
_MOST_ROWS = 12
"""Most records of a list that are printed."""
_MOST_CHOICES = 5
"""Most choices side by side."""
_COLUMNS = {
    "SensitivityRecord": ("end", "key", "value", "per_percent", "steady"),
    "AssumedRecord": (
        "key",
        "value",
        "deviation_words",
        "from",
        "moves_from",
        "moves_to",
        "served",
    ),
    "FixRecord": ("parameter", "before", "printed", "printed_pretension", "max_tension"),
    "RelaxationRecord": ("key", "before", "printed", "printed_pretension", "served", "values"),
    "ConflictRecord": ("limits", "choices", "gap", "fails"),
    "ReasonRecord": ("needs", "count", "share", "text"),
    "SizeRecord": ("served", "interval_95", "persons", "values_tried", "choices"),
    "AxisRecord": ("key", "range", "step"),
}
"""Entries that a table of several records has, by their class; of others all that have one value"""
_OF_CHOICES = (
    "set_flexor_tension",
    "set_extensor_tension",
    "pretension",
    "pretension_from",
    "pretension_to",
    "tolerance_length",
    "tolerance",
    "served_at",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
)
"""Columns of choices that stand side by side, behind those of their axes."""


def record_blocks(record: AnswerResults) -> Iterator[say.Block]:
    """Yield the sections of a record as tables."""
    tables = _Tables(record.question)
    for name, heading in _SECTIONS.items():
        yield from tables.section(heading, getattr(record, name))


class _Tables:
    """Tables of an answer's records, in the units in which people read them."""

    def __init__(self, question: QuestionRecord) -> None:
        self.question = question
        self.axes = {axis.column: axis for axis in question.choices}
        self.all_axes = self.axes | {axis.column: axis for axis in question.conditions}
        self.along = ""
        """Column of the axis along which sizes are listed."""

    def section(self, heading: str, content: Any) -> Iterator[say.Block]:
        """Yield a record, or several of them, under a heading; nothing if there is none."""
        if isinstance(content, Record):
            yield say.heading(heading)
            rows = [*self._rows(content)]
            yield say.table([_HEAD, *(row for row in rows if len(row[1]) <= _LONGEST_WORDS)])
            yield from say.items(
                f"{name}: {text}" for name, text, *_ in rows if len(text) > _LONGEST_WORDS
            )
            for field in fields_of(type(content)):
                inner = getattr(content, field.name)
                if _has_records(inner):
                    yield from self.section(f"{heading}: {field.key}", inner)
        elif content:
            entries = content
            if not isinstance(content, Mapping):
                entries = {str(place + 1): entry for place, entry in enumerate(content)}
            yield from self._several(heading, entries)

    def _several(self, heading: str, entries: Mapping[str, Any]) -> Iterator[say.Block]:
        """Yield several records of one class: choices side by side, others below each other."""
        first = next(iter(entries.values()))
        if isinstance(first, list):
            for self.along, inner in entries.items():
                yield from self.section(f"{heading}: {self.along}", inner)
            return
        if not isinstance(first, ChoiceRecord) and hasattr(first, "best"):
            for trade_off in entries.values():
                values = [self._value(trade_off.key, value) for value in trade_off.values]
                best = dict(zip(values, trade_off.best, strict=True))
                yield say.heading(f"{heading}: {trade_off.key}")
                yield self._side_by_side({name: row for name, row in best.items() if row})
            return
        yield say.heading(heading)
        if isinstance(first, ChoiceRecord):
            yield self._side_by_side(entries)
            return
        shown = dict(list(entries.items())[:_MOST_ROWS])
        yield self._below_each_other(shown, is_named=not next(iter(entries)).isdigit())
        if len(entries) > len(shown):
            yield from say.items([f"{len(entries) - len(shown):,} more are in design.json"])
        nearest = {name: entry.nearest for name, entry in shown.items() if _has_nearest(entry)}
        yield from self.section(f"{heading}: the nearest to a window", nearest)
        for name, entry in shown.items():
            for field in fields_of(type(entry)):
                inner = getattr(entry, field.name)
                if isinstance(inner, dict) and _has_records(inner):
                    yield from self.section(f"{heading}: {name}, {field.key}", inner)

    # --- Records ------------------------------------------------------------------------------

    def _rows(self, record: Record, prefix: str = "") -> Iterator[list[str]]:
        """Yield name, value, unit and meaning of each entry.

        Entries without a value, and long lists such as curves, are left out.
        """
        for field in fields_of(type(record)):
            value = getattr(record, field.name)
            if field.holds_others:
                yield from ([name, *self._column(name, entry)] for name, entry in value.items())
            elif isinstance(value, Record):
                yield from self._rows(value, f"{prefix}{field.key}.")
            elif _is_plain(value):
                text, unit = self._cell(record, field)
                meaning = field.meaning.partition("; null")[0]
                yield [f"{prefix}{field.key}", text, unit, meaning]

    def _below_each_other(self, entries: Mapping[str, Record], *, is_named: bool) -> say.Block:
        """Return a table with a row for each record."""
        first = next(iter(entries.values()))
        every = {field.key: field for field in fields_of(type(first))}
        names = _COLUMNS.get(type(first).__name__)
        if names is None:
            names = tuple(
                name
                for name, field in every.items()
                if not isinstance(getattr(first, field.name), list | dict | Record)
            )
        fields = [every[name] for name in names]
        columns = [["", *entries]] if is_named else []
        for field in fields:
            cells = [self._with_unit(record, field) for record in entries.values()]
            if any(cell != "-" for cell in cells):
                columns.append([field.key, *cells])
        return say.table(zip(*columns, strict=True))

    def _with_unit(self, record: Record, field: RecordField) -> str:
        text, unit = self._cell(record, field)
        if text in ("", "-"):
            return "-"
        return f"{text} {unit}" if unit else text

    def _cell(self, record: Record, field: RecordField) -> tuple[str, str]:
        """Return an entry as text, and its unit."""
        value = getattr(record, field.name)
        unit = field.unit
        if unit == AS_READ:
            return self._text(value), self.question.unit
        if isinstance(value, Mapping) and unit == "SI":
            entries = [f"{key} {self._value(key, entry)}" for key, entry in value.items()]
            return ", ".join(entries), ""
        if unit == "SI":
            key = getattr(record, "key", getattr(record, "parameter", ""))
            quantity = _quantity_of(key)
            if quantity is None:
                return self._text(value), "SI"
            unit = "" if quantity.has_own_unit else quantity.shown_in
            return self._text(value, say.factor_of(quantity)), "" if unit == "1" else unit
        if field.name in _TOLERANCES:
            return _to_spare(value)
        shown, factor = _SHOWN_IN.get(unit, (unit, 1.0))
        return self._text(value, factor), shown

    def _text(self, value: Any, factor: float = 1.0) -> str:
        """Return a value of JSON in a cell."""
        if value is None:
            return "-"
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, int):
            return f"{value:,}"
        if isinstance(value, float):
            return say.number(value / factor)
        if isinstance(value, SuitRecord):
            suit = self._entry(self.along, value.value, factor)
            return f"{suit} at {say.number(value.pretension)} {self.question.unit}"
        if isinstance(value, Record):
            return " at ".join(self._with_unit(value, field) for field in fields_of(type(value)))
        if isinstance(value, str):
            return value
        if isinstance(value, Mapping):
            return ", ".join(self._entry(name, entry, factor) for name, entry in value.items())
        return ", ".join(self._text(entry, factor) for entry in value) or "none"

    def _entry(self, name: str, value: Any, factor: float) -> str:
        """Return an entry of a table, such as a value by the column of its axis."""
        if name in self.all_axes and isinstance(value, str | float):
            return value_words(self.all_axes[name], value)
        return f"{name} {self._text(value, factor)}"

    # --- Choices ------------------------------------------------------------------------------

    def _side_by_side(self, choices: Mapping[str, ChoiceRecord]) -> say.Block:
        """Return a table with a column for each choice, of evenly spaced ones if they are many."""
        places = evenly_spaced(len(choices), _MOST_CHOICES).tolist()
        names = [[*choices][place] for place in places]
        rows = [["", "unit", *names]]
        goals = [goal.column for goal in self.question.ranked_by]
        for name in dict.fromkeys((*self.axes, *_OF_CHOICES, *goals)):
            cells = [self._column(name, value_of(choices[of], name)) for of in names]
            if any(cell[0] != "-" for cell in cells):
                rows.append([name, cells[0][1], *(cell[0] for cell in cells)])
        return say.table(rows)

    def _column(self, name: str, value: Any) -> tuple[str, str, str]:
        """Return the value of a choice in a column as text, with the unit and the meaning."""
        carried = self.question.carried.get(name)
        if carried is not None:
            return self._text(value), carried.unit, "sum over the tables of parts"
        quantity = QUANTITIES.get(name)
        if name in self.axes and not self.axes[name].named:
            quantity = _quantity_of(self.axes[name].key) or quantity
        if quantity is None or isinstance(value, str | bool):
            return self._text(value), "", "" if quantity is None else quantity.long_name
        if name in _TOLERANCES and value is not None:
            return (*_to_spare(value), quantity.long_name)
        if name in COLUMNS_AS_READ:
            quantity = in_unit_of_reading(quantity, self.question.read)
        unit = "" if quantity.shown_in == "1" else quantity.shown_in
        return self._text(value, say.factor_of(quantity)), unit, quantity.long_name

    def _value(self, key: str, value: float | str) -> str:
        """Return a value on the axis of a key, with its unit."""
        quantity = _quantity_of(key)
        if isinstance(value, str) or quantity is None:
            return str(value)
        return say.quantity(quantity, value)


def _to_spare(length: float) -> tuple[str, str]:
    """Return how far a setting may be off as everybody says it, and its unit."""
    text, _, unit = say.length_to_spare(length).partition(" ")
    return text, unit


def _has_nearest(record: Record) -> bool:
    return isinstance(getattr(record, "nearest", None), ChoiceRecord)


def _is_plain(value: Any) -> bool:
    """Return True for a value that stands in a cell: one number or text, or a few of them."""
    if isinstance(value, str | int | float):
        return True
    is_few = value is not None and 0 < len(value) <= _LONGEST
    entries = value.values() if isinstance(value, Mapping) else value
    return is_few and all(isinstance(entry, str | int | float) for entry in entries)


def _has_records(value: Any) -> bool:
    """Return True for a list or a table of records, or of lists of them."""
    if isinstance(value, Mapping):
        value = list(value.values())
    if not isinstance(value, Sequence) or isinstance(value, str) or not value:
        return False
    return isinstance(value[0], Record) or _has_records(value[0])


def _quantity_of(key: str) -> Quantity | None:
    """Return the quantity of a number, or of a limit, by its key; None for a name."""
    return keys()[key].quantity if key in keys() else QUANTITIES.get(key)
