"""Reading the rows of a table: headers with units, names, numbers, and columns carried along.

Every fault is collected, with the row and the column in which it stands.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, partial
from typing import Any, Self

import numpy as np
from pydantic_core import PydanticCustomError

from tendon_cli.errors import Fault
from tendon_cli.model.body import DIMENSIONS as BODY_DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.readers.heading import Heading
from tendon_cli.readers.table import Table
from tendon_cli.studies.contents import is_key_of_study, keys
from tendon_cli.studies.design_section import CHOICE_RESULTS
from tendon_cli.studies.fields import SingleField, fault, hint_at_nearest, parts_of_text
from tendon_cli.studies.gone import IS_GONE, instead_of
from tendon_cli.studies.magnitude import Slip
from tendon_cli.studies.model_words import KEYS_OF_WORDS, WORDS_OF
from tendon_cli.studies.row_table import NAME, RowTable, StatedRole, carried_header
from tendon_cli.studies.space.axis import CASE_AXIS, NAMED_AXES, CarriedColumn, split_side
from tendon_cli.units import (
    UNITS,
    Measure,
    Unit,
    UnitError,
    described,
    find_unit,
    known_units,
    shorten,
    to_float,
    written_unit,
)

_MOST_OF_COLUMN = 5
"""Largest number of faulty cells of a column that are listed."""
_LONGEST_NAME = 200
"""Most characters of the name of a row."""
_NEAR = 0.75
"""Similarity from which a header is taken for a slip of a key of the study."""
_NEAR_OF_UNIT = 0.4
"""Similarity from which a header is taken for a key with the same unit."""
_SPELLED_OUT = {"mu": "μ", "eta": "η"}
"""Symbols of keys that a header may spell out."""
_LARGEST = 1e300
"""Bound below which a number counts as finite."""
_UNSTATED = ("inf", "+inf", "-inf", "infinity", "\u221e", "nan", "na", "n/a", "-")
"""Cells of a limit that a maker does not state: they are as empty."""
CASES = "cases"
"""Key of the rows whose table is called `case`."""
_HEADER = re.compile(r"^(.*?)\s*(?:[(\[](.*)[)\]])?\s*$", re.DOTALL)
_NUMBER = re.compile(r"[+-]?([0-9]{1,40}\.?[0-9]{0,40}|\.[0-9]{1,40})([eE][+-]?[0-9]{1,3})?")
_OTHER_COLUMNS = (
    *(
        "condition",
        "design",
        "direction",
        "status",
        "taut",
        "stable",
        "feasible",
        "on_front",
        "advice",
    ),
    *("windows", "weighting", "from_by", "to_by", "between_samples", "choice", "sex"),
    *("from_condition", "to_condition", "from_direction", "to_direction"),
    *("from_elbow_angle", "to_elbow_angle", NAME),
)
"""Columns of tables that are neither a number of the study nor a quantity of its results."""


@cache
def row_keys() -> tuple[str, ...]:
    """Return the dotted keys that a row may set, in the order of the schema."""
    numbers = (key for key in keys() if not key.startswith("motion."))
    return (*numbers, *KEYS_OF_WORDS)


@cache
def _tables_of_keys() -> frozenset[str]:
    """Return the keys of the tables in which numbers of a row stand, such as `tendon.flexor`."""
    ends = (match for key in row_keys() for match in re.finditer(r"\.", key))
    return frozenset(match.string[: match.start()] for match in ends)


@cache
def known_columns() -> frozenset[str]:
    """Return the columns that tables of tendon have whatever a study carries along."""
    numbers = {key.column for key in keys().values()}
    results = QUANTITIES.keys() - set(BODY_DIMENSIONS)
    return frozenset({*numbers, *results, *CHOICE_RESULTS, *_OTHER_COLUMNS, *NAMED_AXES})


def flat_keys(table: Mapping[Any, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of a row by dotted keys, whether these are quoted or nested."""
    for name, value in table.items():
        key = f"{prefix}{name}"
        if isinstance(value, dict) and key in _tables_of_keys():
            yield from flat_keys(value, f"{key}.")
        else:
            yield key, value


def columns_set(columns: Sequence[Heading]) -> Sequence[Heading]:
    """Return the columns of a line if it is a header of rows: it has names, or sets a number."""
    headers = [row_heading(column.index, column.header, column) for column in columns]
    is_header = any(one.name == NAME or one.name in row_keys() for one in headers)
    return columns if is_header else []


def row_heading(index: int, text: str, heading: Heading | None = None) -> Heading:
    """Return the header of a column of rows: what it names, and what stands in its brackets.

    Args:
        index: Place of the column.
        text: Header as written.
        heading: Column of a file, which may have its unit elsewhere: in a row of its own, or behind
            the key of a number.
    """
    header = text.strip()
    match = _HEADER.match(header)
    name, unit = (header, "") if match is None else (match[1].strip(), (match[2] or "").strip())
    if heading is not None and not unit:
        is_below = heading.unit and not Heading.of(0, text).unit
        if is_below or heading.name in row_keys():
            name = heading.name
            unit = heading.unit
    if name.casefold() == NAME:  # a spreadsheet may begin it with a capital
        name = NAME
    return Heading(index, header, name, unit)


@dataclass
class RowReader:
    """Reader of the rows of one table; it collects every fault."""

    key: str
    """Name of the table."""
    where: str
    """Place of the table, for errors: "springs.csv", "table.0"."""
    headers: Sequence[Heading]
    """Headers of the columns."""
    columns: Sequence[Sequence[Any]]
    """Cells of each column: texts, or numbers of a study; None or "" for an empty cell."""
    place: Callable[[int], str]
    """Returns the place of a row, for errors."""
    header_place: str
    """Place of the headers, for errors; empty for cases, each of which states its own keys."""
    are_texts: bool = False
    """True for a file of text, whose numbers need a unit."""
    faults: list[Fault] = field(default_factory=list)
    """Faults found so far."""
    slips: dict[str, list[Slip]] = field(default_factory=dict)
    """Values that are far from any arm, by the place of the table, or of a case's key."""

    @classmethod
    def of_table(cls, key: str, table: Table) -> Self:
        """Return the reader of a file; a sign that may separate thousands is a fault of it."""
        headers = [row_heading(one.index, one.header, one) for one in table.columns]
        columns = [
            table.texts(heading) if one.name == NAME else table.measures(heading)
            for one, heading in zip(headers, table.columns, strict=True)
        ]
        place = partial(table.place, None)
        return cls(key, table.source, headers, columns, place, table.place(), are_texts=True)

    @classmethod
    def of_columns(cls, key: str, columns: Mapping[str, Sequence[Any]], where: str) -> Self:
        """Return the reader of columns that a program states by their headers."""
        headers = [row_heading(at, text) for at, text in enumerate(columns)]
        rows = f"{where}.rows"
        cells = [[None if _is_nan(cell) else cell for cell in one] for one in columns.values()]
        return cls(key, where, headers, cells, lambda row: f"{rows}, row {row + 1}", rows)

    @classmethod
    def of_rows(cls, key: str, rows: Sequence[Mapping[str, Any]], where: str) -> Self:
        """Return the reader of rows that a study states, by their dotted keys."""
        place = f"{where}.rows"
        header_place = place
        keys_given = dict.fromkeys(stated for row in rows for stated in row)
        if where == CASES:
            place = CASES
            header_place = ""
            order = {known: at for at, known in enumerate(row_keys())}
            ordered = (sorted(row, key=lambda one: order.get(one, len(order))) for row in rows)
            keys_given = dict.fromkeys((NAME, *(stated for row in ordered for stated in row)))
        columns = [[row.get(stated) for row in rows] for stated in keys_given]
        headers = [row_heading(at, str(stated)) for at, stated in enumerate(keys_given)]
        return cls(key, where, headers, columns, lambda row: f"{place}.{row}", header_place)

    @property
    def _is_of_cases(self) -> bool:
        return self.key == CASE_AXIS

    def read(self, role: StatedRole | None) -> RowTable:
        """Return the table; of a faulty one what could be read."""
        numbers: dict[str, Array] = {}
        readings: dict[str, str] = {}
        carried: dict[str, CarriedColumn] = {}
        unused: list[Heading] = []
        names: tuple[str, ...] | None = None
        for header, column in self._named_columns():
            if header.name == NAME:
                names = self._names(column)
            elif header.name in KEYS_OF_WORDS:
                numbers[header.name] = self._words(header, column)
            elif header.name in row_keys():
                numbers[header.name], reading = self._numbers(header, column)
                readings |= {header.name: reading} if reading else {}
            elif self._may_be_carried(header):
                carried[header.column] = self._carried(header, column)
                unused.append(header)
        if not (numbers or self.faults or self._is_of_cases):
            self._refuse_nothing_set(unused)
        if names is None:
            names = tuple(map(str, range(1, len(self.columns[0]) + 1)))
            found = shorten(", ".join(header.header for header in self.headers), 200)
            problem = f'no column "{NAME}", the headers read: {found}'
            hint = f"a column {NAME} that tells the rows apart"
            self.faults.append(Fault(self.header_place, problem, hint))
        return RowTable(
            self.key,
            self.key,
            numbers,
            names,
            stated_role=role,
            carried=tuple(carried.values()),
            readings=readings,
            slips=self.slips,
            where=self.where,
        )

    # --- Headers ---------------------------------------------------------------------------------

    def _named_columns(self) -> Iterator[tuple[Heading, Sequence[Any]]]:
        """Yield the columns with a header, each name once; an empty column needs none."""
        seen: dict[str, str] = {}
        for header, column in zip(self.headers, self.columns, strict=True):
            if not header.name:
                if not all(map(_is_empty, column)):
                    self._refuse_header(header, "a column without a header", "give it a name")
                continue
            name = header.name if "." in header.name else header.column
            if name in seen:
                both = f'"{seen[name]}" and "{header.header}"'
                self._refuse_header(header, f"{header.name} is given twice, {both}", None)
                continue
            seen[name] = header.header
            yield header, column

    def _refuse_header(self, header: Heading, problem: str, hint: str | None) -> None:
        """Collect a fault of a header; that of a case is a key of the first case that states it."""
        place = self.header_place
        shown = f'"{shorten(header.header)}": ' if header.header else ""
        if not place:
            column = self.columns[header.index]
            first = next((row for row, cell in enumerate(column) if cell is not None), 0)
            place = shorten(self._cell_place(first, header), 120)
            shown = ""
        self.faults.append(Fault(place, f"{shown}{problem}", hint))

    def _may_be_carried(self, header: Heading) -> bool:
        """Return True for a header that names no key of the study, but a column of its own."""
        meant = {key.column: path for path, key in keys().items() if path in row_keys()}
        own = f"{self.key}_{header.column}"
        if "." in header.name or header.name in meant or self._is_of_cases:
            problem, hint = self._unknown_key(header, meant.get(header.name))
        elif not header.column:
            problem = "has neither letters nor digits"
            hint = "give it a name"
        elif own in known_columns():
            problem = f"would be the column {own}, which tables have"
            hint = "rename the column"
            if own in meant:
                hint = _with_unit(f'did you mean "{meant[own]}"?', header)
        else:
            return True
        self._refuse_header(header, problem, hint)
        return False

    def _unknown_key(self, header: Heading, meant: str | None) -> tuple[str, str]:
        """Return problem and hint of a header that no row can set.

        Args:
            header: The header.
            meant: Key whose column in tables it names; None for any other.
        """
        name = header.name
        instead = instead_of(name.split("."))
        if instead is not None:
            return IS_GONE, instead
        if is_key_of_study(name):
            hint = f"state {name} for the whole study, or write a study for each row"
            return "is the same for all rows", hint
        like = meant or _key_like(header)
        near = hint_at_nearest(name, (NAME, *row_keys()), cutoff=0.6)
        if meant is not None or (near is None and like is not None):
            near = f'did you mean "{like}"?'
        if near is None:
            return "unknown key", "keys such as spring.stiffness (kN/m)"
        return "unknown key", _with_unit(near, header)

    def _refuse_nothing_set(self, headers: Sequence[Heading]) -> None:
        """Refuse rows that set no number of the study; name keys that headers may have meant."""
        meant = []
        for header in headers:
            key = _key_like(header)
            if key is not None:
                meant.append(f'"{key}" for "{shorten(header.header)}"')
        hint = "headers such as spring.stiffness (kN/m)"
        if meant:
            hint = f"did you mean {', '.join(meant)}?"
        problem = "no column is a key of the study, so all rows would be the same suit"
        self.faults.append(Fault(self.header_place, problem, hint))

    # --- Columns ---------------------------------------------------------------------------------

    def _names(self, column: Sequence[Any]) -> tuple[str, ...]:
        """Return the names of the rows, all different; faulty ones are replaced."""
        if _are_different_names(column):
            return tuple(column)
        rows: dict[str, int] = {}
        names = []
        wrong: list[Fault] = []
        for row, cell in enumerate(column):
            name = "" if _is_empty(cell) else str(cell).strip()
            problem = ""
            hint: str | None = None
            if not name:
                problem = "is missing or empty, expected a name for each row"
            elif isinstance(cell, bool) or not isinstance(cell, str | int | float):
                problem = f"{described(cell)} is not a name, expected text in quotes"
            elif len(name) > _LONGEST_NAME or not name.isprintable():
                problem = f"{described(name)} is not a name, expected {_LONGEST_NAME} characters"
                problem += " at most that can be printed"
            elif name in rows:
                problem = f'"{shorten(name)}" is the name of two rows'
                hint = f"the other is {self.place(rows[name])}"
            if problem:
                place = self._cell_place(row, Heading.of(0, NAME))
                wrong.append(Fault(place, problem, hint))
                name = f"row {row + 1}"
            rows.setdefault(name, row)
            names.append(name)
        self._list(wrong, NAME)
        return tuple(names)

    def _words(self, header: Heading, column: Sequence[Any]) -> Array:
        """Return a column of words of the model as the numbers that they are to it."""
        words = WORDS_OF[split_side(header.name)[0]]

        def read(cell: Any) -> float:
            if cell in words:
                return float(words.index(cell))
            expected = " or ".join(f'"{word}"' for word in words)
            problem = f"{described(cell)} is not possible, expected {expected}"
            raise fault(problem, hint_at_nearest(str(cell), words))

        return self._values(header, column, read)

    def _numbers(self, header: Heading, column: Sequence[Any]) -> tuple[Array, str]:
        """Return a column of numbers in SI, and the dimension in which a reading is stated."""
        mark = keys()[header.name].number
        unit = None
        if header.unit:
            unit = self._unit(header, mark)
            if unit is None:
                return np.full(len(column), np.nan), ""
        if header.name.startswith("limits."):
            column = ["" if str(cell).strip().lower() in _UNSTATED else cell for cell in column]
        cells = _ColumnCells(mark, unit, are_texts=self.are_texts)
        values = cells.of_record(column)
        if values is None:
            values = self._values(header, column, cells.value)
        if cells.without_unit:
            problem = f"has no unit, and neither have {cells.without_unit:,} of its cells"
            quantity = mark.quantity
            units = ", ".join(known_units(quantity.dimension))
            hint = f'write "{header.name} ({quantity.shown_in})"; units: {units}'
            self._refuse_header(header, problem, hint)
        self._note_slips(header, column, values, cells)
        dimensions = cells.readings
        if len(dimensions) > 1:
            self._refuse_header(header, "mixes tensions and torques, expected one of both", None)
        return values, next(iter(sorted(dimensions)), "")

    def _values(
        self, header: Heading, column: Sequence[Any], read: Callable[[Any], float]
    ) -> Array:
        """Return the values of the cells of a column; NaN for an empty or a faulty one."""
        values = np.full(len(column), np.nan)
        wrong = []
        for row, cell in enumerate(column):
            if _is_empty(cell):
                continue
            try:
                values[row] = read(cell)
            except PydanticCustomError as error:
                context = error.context or {}
                place = self._cell_place(row, header)
                wrong.append(Fault(place, context["problem"], context["hint"]))
        self._list(wrong, header.header)
        return values

    def _note_slips(
        self, header: Heading, column: Sequence[Any], values: Array, cells: _ColumnCells
    ) -> None:
        """Collect the values of a column that are far from any arm."""
        mark = cells.mark
        low, high = mark.plausible
        is_far = np.isfinite(values) & (values != 0.0) & ~((low <= values) & (values <= high))
        for row in np.flatnonzero(is_far).tolist():
            measure = cells.measure(column[row])
            written = column[row] if cells.unit is None else measure.quoted.strip('"')
            place = self._cell_place(row, header)
            where = place if self._is_of_cases else self.where
            place = place.removeprefix(where).lstrip("., ")
            self.slips.setdefault(where, []).extend(mark.slips((place, written, measure)))

    def _carried(self, header: Heading, column: Sequence[Any]) -> CarriedColumn:
        """Return a column that sets nothing: of numbers if every cell is one, else of text."""
        digits = [_number_text(cell) for cell in column]
        numbers = np.full(len(column), np.nan)
        for row, text in enumerate(digits):
            if text is not None:
                numbers[row] = self._finite(text, row, header)
        are_plain = (text or _is_empty(cell) for text, cell in zip(digits, column, strict=True))
        has_numbers = any(digits)
        if has_numbers and all(are_plain):
            return CarriedColumn(header.column, header.unit, numbers)
        texts = ["" if _is_empty(cell) else str(cell) for cell in column]
        words = tuple(dict.fromkeys(("", *texts)))
        places = {word: place for place, word in enumerate(words)}
        positions = np.array([places[text] for text in texts], dtype=np.int64)
        known = numbers if has_numbers else None
        return CarriedColumn(header.column, header.unit, positions, words, known)

    def _finite(self, text: str, row: int, header: Heading) -> float:
        """Return the number of a text; collect a fault for one that is out of range."""
        value = float(text)
        if math.isinf(value):
            problem = f"{shorten(text)} is out of range"
            self.faults.append(Fault(self._cell_place(row, header), problem))
        return value

    def _unit(self, header: Heading, mark: SingleField) -> Unit | None:
        """Return the unit of a header; None if it is none of the number's, which is a fault."""
        for dimension in mark.dimensions:
            unit = written_unit(header.unit, dimension)
            if unit is not None:
                return unit
        try:
            return find_unit(header.unit, mark.quantity.dimension)
        except UnitError as error:
            self._refuse_header(header, error.problem, error.hint)
        return None

    def _cell_place(self, row: int, header: Heading) -> str:
        """Return the place of a cell, for errors; that of a case is the key in the study."""
        if self._is_of_cases:
            return f"{self.place(row)}.{header.header}"
        return f"{self.place(row)}, {shorten(header.header)}"

    def _list(self, wrong: list[Fault], column: str) -> None:
        """Add the faults of a column, of many only the first and their number."""
        self.faults += wrong[:_MOST_OF_COLUMN]
        if len(wrong) > _MOST_OF_COLUMN:
            more = len(wrong) - _MOST_OF_COLUMN
            cells = "1 more cell" if more == 1 else f"{more:,} more cells"
            self.faults.append(Fault(f"{self.where}, {column}", f"and {cells} at fault"))


@dataclass
class _ColumnCells:
    """Numbers of one column, exact in the unit of its header or in their own."""

    mark: SingleField
    """Mark of the number."""
    unit: Unit | None
    """Unit of the header; None if each cell has its own."""
    are_texts: bool
    """True if a number without a unit is not taken as SI."""
    readings: set[str] = field(default_factory=set)
    """Dimensions in which readings of a gauge are stated."""
    without_unit: int = 0
    """Number of cells of which neither they nor the header say the unit."""

    def __post_init__(self) -> None:
        self._known: dict[Any, float] = {}
        self._shift = None if self.unit is None else _power_of_ten(self.unit.factor)
        has_unit = self.mark.quantity.dimension != "number"
        self._needs_unit = self.are_texts and self.unit is None and has_unit
        if self.unit is not None:
            self._note_reading(self.unit.dimension)

    def of_record(self, column: Sequence[Any]) -> Array | None:
        """Return numbers in SI as a record has them; None for any other column."""
        is_angle = self.mark.quantity.dimension == "angle"
        if self.unit is not None or self.are_texts or is_angle or {*map(type, column)} != {float}:
            return None
        values = np.array(column)
        is_possible = (self.mark.low <= values) & (values <= self.mark.high)
        return values if is_possible.all() else None

    def value(self, cell: Any) -> float:
        """Return the value of a cell in SI; NaN if nothing says its unit.

        Raises:
            PydanticCustomError: The cell holds no number of this dimension.
        """
        if isinstance(cell, bool) or not isinstance(cell, str | int | float):
            number = SingleField.form(self.mark, cell)  # a fault, and nothing to look up
            return number.single
        if self._needs_unit and _number_text(cell) is not None:
            self.without_unit += 1
            return math.nan
        known = self._known.get(cell)
        if known is None:
            known = self._read(cell)
            self._known[cell] = known
        return known

    def _read(self, cell: Any) -> float:
        if cell == self.mark.word:
            return math.inf
        text = _number_text(cell) if self._shift is not None else None
        value = self.measure(cell).si if text is None else _shifted(text, self._shift or 0)
        if not self.mark.low <= value <= self.mark.high:
            self.mark.bounded(self.measure(cell))
        return value

    def measure(self, cell: Any) -> Measure:
        """Return a cell as a number with its unit; raises as `value` does."""
        text = _number_text(cell)
        if text is not None and self.unit is not None:
            return Measure(text, self.unit)
        if isinstance(cell, str) and len(parts_of_text(cell)) > 1:
            problem = f"{described(cell)} is not one number, expected {self.mark.wanted}"
            hint = "a row sets exact numbers; ranges and distributions belong to a sample"
            raise fault(problem, hint)
        measure = self.mark.measure(cell)
        if isinstance(cell, str):
            self._note_reading(measure.unit.dimension)
        return measure

    def _note_reading(self, dimension: str) -> None:
        if self.mark.is_reading:
            self.readings.add(dimension)


def _are_different_names(cells: Sequence[Any]) -> bool:
    """Return True if all cells are good names of rows, and all different."""
    if set(map(type, cells)) != {str} or len(set(cells)) < len(cells):
        return False
    is_long = max(map(len, cells)) > _LONGEST_NAME
    has_spaces = any(cell.strip() != cell or not cell for cell in cells)
    return not (is_long or has_spaces) and "".join(cells).isprintable()


def _power_of_ten(factor: Fraction) -> int | None:
    """Return the exponent of a factor that is a power of ten; None for any other."""
    exponent = round(math.log10(to_float(factor)))
    return exponent if factor == Fraction(10) ** exponent else None


def _shifted(text: str, exponent: int) -> float:
    """Return a number times a power of ten, rounded once."""
    mantissa, _, power = text.lower().partition("e")
    return float(f"{mantissa}e{int(power or 0) + exponent}")


def _number_text(cell: Any) -> str | None:
    """Return the digits of a cell that is a plain number; None for any other."""
    if isinstance(cell, bool):
        return None
    if isinstance(cell, float):
        cell = float(cell)  # NumPy's has a text of its own
    if isinstance(cell, (int, float)):
        return repr(cell) if abs(cell) < _LARGEST else None
    text = str(cell).strip()
    return text if _NUMBER.fullmatch(text) else None


def _is_empty(cell: Any) -> bool:
    """Return True for a cell that holds nothing, as a spreadsheet or a DataFrame has it."""
    return cell is None or (isinstance(cell, str) and not cell.strip())


def _with_unit(hint: str, header: Heading) -> str:
    """Return a hint at keys with the unit of a header behind each that can have it."""
    unit = UNITS.get(header.unit)

    def written(quoted: re.Match[str]) -> str:
        key = keys().get(quoted[1])
        fits = unit is not None and key is not None and unit.dimension in key.number.dimensions
        return f'"{quoted[1]} ({header.unit})"' if fits else quoted[0]

    return re.sub(r'"([^"]+)"', written, hint)


def _is_nan(cell: Any) -> bool:
    return isinstance(cell, float) and math.isnan(cell)


def _key_like(header: Heading) -> str | None:
    """Return the key of a study that a header may mean; None if none is like it.

    It ends in the header, such as "stiffness", or has it as its symbol, such as "mu", or is nearest
    to it among keys of the same unit.
    """
    plain = header.column.lower()
    symbol = _SPELLED_OUT.get(plain, header.name)
    like = [key for key in row_keys() if key.rpartition(".")[2] == plain]
    like += [key for key in row_keys() if key in keys() and keys()[key].quantity.symbol == symbol]
    if like:
        return like[0]
    unit = UNITS.get(header.unit) if header.unit else None
    among = [key for key in row_keys() if key in keys() and "." in key]
    cutoff = _NEAR
    if unit is not None:
        among = [key for key in among if keys()[key].number.quantity.dimension == unit.dimension]
        cutoff = _NEAR_OF_UNIT
    near = difflib.get_close_matches(plain.replace("_", "."), among, n=1, cutoff=cutoff)
    return near[0] if near else None


def carried_faults(tables: Sequence[RowTable]) -> list[Fault]:
    """Return faults of columns that tables carry: names that exist, and sums of different units."""
    faults = []
    columns: dict[str, str] = {table.key: table.where for table in tables}
    sums: dict[str, tuple[RowTable, CarriedColumn]] = {}
    for at, table in enumerate(tables):
        if table.key in [other.key for other in tables[:at]]:
            problem = f'"{table.key}" is the name of two tables, expected each name once'
            faults.append(Fault(table.where, problem))
        for column in table.carried:
            header = f'{table.where}: "{carried_header(column)}"'
            own = f"{table.key}_{column.name}"
            if own in columns:
                problem = f"would be the column {own}, which {columns[own]} gives, too"
                faults.append(Fault(header, problem, "rename one of them"))
            columns[own] = table.where
            if column.addends is None:
                continue
            if column.name in known_columns() or column.name in columns:
                path = next((path for path, key in keys().items() if key.column == column.name), "")
                hint = f'did you mean "{path}"?' if path else "rename the column"
                problem = f"would be summed as {column.name}, which is a column of its own"
                faults.append(Fault(header, problem, hint))
                continue
            first = sums.setdefault(column.name, (table, column))
            if first[1].unit != column.unit:
                other = f'{first[0].where} "{carried_header(first[1])}"'
                problem = f"cannot be added to {other}: their units differ"
                faults.append(Fault(header, problem, "give both the same unit, or another name"))
    return faults
