"""Real persons from a CSV: some of the dimensions each, with units in the headers."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.people.headers import Header, cells_of, read_headers
from tendon_cli.studies.people.survey import PLAUSIBLE
from tendon_cli.units import UNITS, known_units, shorten

_SEX_WORDS = {"m": "male", "male": "male", "man": "male", "f": "female", "female": "female", "woman": "female"}
_MISSING = ("", "na", "n/a", "nan", "null", "-")
_SEPARATORS = ("\t", ";", ",")


@dataclass(frozen=True, eq=False)
class Listed:
    """What a file of persons says, a row each, and nothing else."""

    columns: tuple[str, ...]
    """What its columns are, in their order: dimensions, `name`, `sex`, `weighting`."""
    names: tuple[str, ...]
    sexes: npt.NDArray[np.str_] | None
    values: Array
    """Dimensions in the order of `DIMENSIONS`, shape (n, 8), SI, NaN where the file has none."""
    weighting: Array
    ignored: list[str]
    """A note on columns that are not read."""


def read_listed(content: bytes, where: str) -> Listed:
    """The rows of a CSV file of persons.

    A header is a dimension with its unit, such as `weight (kg)` or `weight_kg`, or `name`, `weighting`, `sex`. Raises
    InputError.
    """
    lines = _text(content, where).rstrip().split("\n", 1)
    separator = max(_SEPARATORS, key=lines[0].count)
    headers, ignored = read_headers(lines[0], separator, where)
    if len(lines) < 2:
        raise InputError("holds no persons, expected a row for each below the headers", where=where)
    columns = _columns(lines[1], headers, lines[0], separator, where)
    count = len(next(iter(columns.values())))
    weighting = _weighting(columns, headers, separator, where)
    values = np.full((count, len(DIMENSIONS)), np.nan)
    for header in headers:
        if header.name in DIMENSIONS:
            numbers = _numbers(columns[header.name], header, separator, where) * header.factor
            _check_plausible(numbers, header, where)
            values[:, DIMENSIONS.index(header.name)] = numbers
    _check_something_known(values, where)
    sexes = _sexes(columns["sex"], where) if "sex" in columns else None
    names = _names(columns.get("name"), count, where)
    return Listed(tuple(header.name for header in headers), names, sexes, values, weighting, ignored)


def _text(content: bytes, where: str) -> str:
    """The file's text; UTF-8, UTF-16 with its mark, else Latin-1."""
    if b"\0" in content[:4096] and not content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError("this is a binary file, expected a CSV of persons", where=where)
    try:
        encoding = "utf-16" if content.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
        text = content.decode(encoding)
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _columns(rows: str, headers: list[Header], first: str, separator: str, where: str) -> dict[str, Any]:
    """The cells of the columns that are read, as Arrow arrays of text, spaces around them taken off."""
    import pyarrow as pa  # only files of people pay for its import
    import pyarrow.compute as pc
    from pyarrow import csv as arrow_csv

    names = [str(at) for at in range(len(cells_of(first, separator, where)))]
    ragged: list[tuple[int, int]] = []

    def refuse(row: Any) -> str:
        ragged.append((row.number + 1, row.actual_columns))
        return "skip"

    try:
        table = arrow_csv.read_csv(
            io.BytesIO(rows.encode()),
            read_options=arrow_csv.ReadOptions(column_names=names, use_threads=False),
            parse_options=arrow_csv.ParseOptions(
                delimiter=separator, ignore_empty_lines=False, invalid_row_handler=refuse
            ),
            convert_options=arrow_csv.ConvertOptions(
                column_types=dict.fromkeys(names, pa.string()), include_columns=[str(header.at) for header in headers],
                strings_can_be_null=False,
            ),
        )  # fmt: skip
    except pa.ArrowInvalid as error:
        raise InputError(f"not a CSV: {shorten(str(error), 120)}", where=where) from None
    if ragged:
        line, cells = ragged[0]
        hint = "a decimal comma read as a separator? separate the columns by semicolons" if separator == "," else None
        problem = f"{cells} cells where the headers have {len(names)}"
        raise InputError(problem, where=f"{where}, line {line}", hint=hint)
    return {header.name: pc.utf8_trim_whitespace(table[str(header.at)]) for header in headers}


def _numbers(cells: Any, header: Header, separator: str, where: str) -> Array:
    """A column's numbers as they are written, NaN where a cell is empty."""
    import pyarrow as pa
    import pyarrow.compute as pc

    if separator != ",":
        cells = pc.replace_substring(cells, ",", ".")
    known = pc.if_else(pc.is_in(pc.utf8_lower(cells), pa.array(_MISSING)), pa.scalar(None, pa.string()), cells)
    try:
        numbers = pc.cast(known, pa.float64())
    except pa.ArrowInvalid:
        at, text = next((at, text) for at, text in enumerate(known.to_pylist()) if not _is_number(text))
        hint = "units belong in the header, and the decimal sign is a point"
        raise InputError(
            f'{header.name} is "{shorten(text)}", not a number', where=_line(where, at), hint=hint
        ) from None
    return np.asarray(numbers.to_numpy())


def _is_number(text: str | None) -> bool:
    import pyarrow as pa

    try:
        pa.array([text]).cast(pa.float64())
    except pa.ArrowInvalid:
        return False
    return True


def _line(where: str, at: int) -> str:
    return f"{where}, line {at + 2}"


def _check_plausible(numbers: Array, header: Header, where: str) -> None:
    """Refuse a person that nobody is: three metres tall, or in another unit than the header says."""
    low, high = PLAUSIBLE[header.name]
    odd = (numbers < low) | (numbers > high)
    if not odd.any():
        return
    at = int(np.argmax(odd))
    quantity = QUANTITIES[header.name]
    shown = float(UNITS[quantity.shown_in].factor)
    given = f"{numbers[at] / shown:.6g} {quantity.shown_in}"
    others = [
        symbol for symbol in known_units(quantity.dimension)
        if low <= numbers[at] / header.factor * float(UNITS[symbol].factor) <= high
    ]  # fmt: skip
    mixed = f"{numbers[at] / header.factor:.6g} {others[0]} would be possible: are units mixed?" if others else None
    count = f" (and {int(odd.sum()) - 1} persons more)" if odd.sum() > 1 else ""
    problem = f"{header.name} is {given}{count}, expected {low / shown:g} to {high / shown:g} {quantity.shown_in}"
    raise InputError(problem, where=_line(where, at), hint=mixed)


def _check_something_known(values: Array, where: str) -> None:
    empty = np.isnan(values).all(axis=1)
    if empty.any():
        raise InputError("a person without any dimension", where=_line(where, int(np.argmax(empty))))


def _weighting(columns: dict[str, Any], headers: list[Header], separator: str, where: str) -> Array:
    header = next((header for header in headers if header.name == "weighting"), None)
    if header is None:
        return np.ones(len(next(iter(columns.values()))))
    weighting = _numbers(columns["weighting"], header, separator, where)
    wrong = ~(np.isfinite(weighting) & (weighting >= 0.0))
    if wrong.any():
        at = int(np.argmax(wrong))
        problem = f"weighting is {columns['weighting'][at].as_py() or 'empty'}, expected 0 or more"
        raise InputError(problem, where=_line(where, at))
    if not weighting.any():
        raise InputError("every weighting is 0, so that nobody counts", where=where)
    return weighting


def _names(cells: Any | None, count: int, where: str) -> tuple[str, ...]:
    """The names of the persons, their lines where the file gives none."""
    if cells is None:
        return tuple(f"person {at + 1}" for at in range(count))
    names = [shorten(name, 200) for name in cells.to_pylist()]
    lines: dict[str, int] = {}
    for at, name in enumerate(names):
        if not name:
            raise InputError("a person without a name in a file of names", where=_line(where, at))
        if name in lines:
            problem = f'"{shorten(name)}" names two persons, the other in line {lines[name] + 2}'
            raise InputError(problem, where=_line(where, at), hint="each name stands once")
        lines[name] = at
    return tuple(names)


def _sexes(cells: Any, where: str) -> npt.NDArray[np.str_]:
    words = [_SEX_WORDS.get(word.casefold()) for word in cells.to_pylist()]
    if None in words:
        at = words.index(None)
        problem = f'sex is "{shorten(cells[at].as_py())}", expected male or female'
        raise InputError(problem, where=_line(where, at))
    return np.array(words)
