"""Real persons from a CSV: some of the dimensions each, with units in the headers."""

from __future__ import annotations

import csv
import difflib
import io
import re
import unicodedata
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.people.survey import PLAUSIBLE
from tendon_cli.units import UNITS, factor_of, known_units, shorten

_SEX_WORDS = {"m": "male", "male": "male", "man": "male", "f": "female", "female": "female", "woman": "female"}
_MISSING = ("", "na", "n/a", "nan", "null", "-")
_OTHERS = ("name", "sex", "weighting")
_GERMAN = {
    **dict.fromkeys(("gewicht", "korpergewicht", "masse", "korpermasse"), "weight"),
    **dict.fromkeys(("grosse", "korpergrosse", "korperhohe"), "stature"),
    "oberarmlange": "acromion_radiale_length",
    "unterarmlange": "radiale_stylion_length",
    "oberarmumfang": "biceps_circumference",
    "unterarmumfang": "forearm_circumference",
    "handgelenkumfang": "wrist_circumference",
    "geschlecht": "sex",
    "gewichtung": "weighting",
}
"""What a German header, without its dots, would be here: it is refused, since what it says would be guessed."""


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


@dataclass(frozen=True)
class _Header:
    """A column's place in the file, its header, what it is, and SI values per value in it."""

    at: int
    text: str
    name: str
    factor: float = 1.0


def read_listed(content: bytes, where: str) -> Listed:
    """The rows of a CSV file of persons.

    A header is a dimension with its unit, such as `weight (kg)` or `weight_kg`, or `name`, `weighting`, `sex`. Raises
    InputError.
    """
    lines = _text(content, where).rstrip().split("\n", 1)
    separator = max("\t;,", key=lines[0].count)
    try:
        texts = next(csv.reader([lines[0]], delimiter=separator, strict=True), [])
    except csv.Error as error:
        raise InputError(f"the headers are no row of CSV: {error}", where=where) from None
    headers, ignored = _read_headers(texts, where)
    if len(lines) < 2:
        raise InputError("holds no persons, expected a row for each below the headers", where=where)
    columns = _columns(lines[1], headers, len(texts), separator, where)
    count = len(next(iter(columns.values())))
    values, weighting = np.full((count, len(DIMENSIONS)), np.nan), np.ones(count)
    for name, header in headers.items():
        if name in DIMENSIONS:
            values[:, DIMENSIONS.index(name)] = _plausible(
                _numbers(columns[name], header, separator, where), header, where
            )
        elif name == "weighting":
            weighting = _weighting(_numbers(columns[name], header, separator, where), where)
    empty = np.isnan(values).all(axis=1)
    if empty.any():
        raise InputError("a person without any dimension", where=_line(where, int(np.argmax(empty))))
    sexes = _sexes(columns["sex"], where) if "sex" in columns else None
    names = _names(columns["name"], where) if "name" in columns else tuple(f"person {at + 1}" for at in range(count))
    return Listed(tuple(headers), names, sexes, values, weighting, ignored)


def _text(content: bytes, where: str) -> str:
    """The file's text; UTF-8, UTF-16 with its mark, else Latin-1."""
    is_utf_16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in content[:4096] and not is_utf_16:
        raise InputError("this is a binary file, expected a CSV of persons", where=where)
    try:
        text = content.decode("utf-16" if is_utf_16 else "utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _read_headers(texts: list[str], where: str) -> tuple[dict[str, _Header], list[str]]:
    """The columns that are read, by what they are, and a note on those that are not."""
    known: dict[str, _Header] = {}
    ignored = []
    for at, text in enumerate(texts):
        header = _header(at, text, where)
        if header is None:
            ignored.append(shorten(text, 30))
        elif header.name in known:
            both = f'"{shorten(known[header.name].text, 30)}" and "{shorten(text, 30)}"'
            raise InputError(f"{header.name} stands in two columns, {both}", where=where, hint="leave one of them out")
        else:
            known[header.name] = header
    if not set(known).intersection(DIMENSIONS):
        hint = f"such as weight (kg), stature (cm); dimensions: {', '.join(DIMENSIONS)}"
        problem = f"no column is a dimension of a body, the headers read: {shorten(', '.join(texts))}"
        raise InputError(problem, where=where, hint=hint)
    more = f" and {len(ignored) - 5} more" if len(ignored) > 5 else ""
    return known, [f"{where}: columns not read: {', '.join(ignored[:5])}{more}"] if ignored else []


def _header(at: int, text: str, where: str) -> _Header | None:
    """What one header says; None for a column that is nothing of ours."""
    letters = unicodedata.normalize("NFKD", text.casefold())
    plain = re.sub(r"[^a-z0-9]+", "_", "".join(each for each in letters if not unicodedata.combining(each))).strip("_")
    if plain in _OTHERS:
        return _Header(at, text, plain)
    name, symbol = (plain, "") if plain in DIMENSIONS else plain.rpartition("_")[::2]
    if name in DIMENSIONS:
        dimension = QUANTITIES[name].dimension
        if symbol in UNITS and UNITS[symbol].dimension == dimension:
            return _Header(at, text, name, factor_of(symbol))
        given = f'has the unknown unit "{symbol}"' if symbol else "has no unit"
        given = f"has a unit of {UNITS[symbol].dimension}" if symbol in UNITS else given
        units = ", ".join(known_units(dimension))
        hint = f"such as {name} ({QUANTITIES[name].shown_in}); units of {dimension}: {units}"
        raise InputError(f'the header "{shorten(text)}" {given}', where=where, hint=hint)
    word = re.sub("(?<=[aou])e", "", plain.partition("_")[0])  # ae, oe, ue stand for one with dots
    near = difflib.get_close_matches(name or plain, (*DIMENSIONS, *_OTHERS), n=1, cutoff=0.8)
    meant = _GERMAN.get(word) or "".join(near)
    if not meant:
        return None
    unit = f" ({symbol if symbol in UNITS else QUANTITIES[meant].shown_in})" if meant in DIMENSIONS else ""
    hint = f'write "{meant}{unit}"; known are: {", ".join((*DIMENSIONS, *_OTHERS))}'
    raise InputError(f'the header "{shorten(text)}" is not known', where=where, hint=hint)


def _columns(rows: str, headers: dict[str, _Header], count: int, separator: str, where: str) -> dict[str, Any]:
    """The cells of the columns that are read, as Arrow arrays of text, spaces around them taken off."""
    import pyarrow as pa  # only files of people pay for its import
    import pyarrow.compute as pc
    from pyarrow import csv as arrow_csv

    names = [str(at) for at in range(count)]
    ragged: list[tuple[int, int]] = []

    def refuse(row: Any) -> str:
        ragged.append((row.number + 1, row.actual_columns))
        return "skip"

    parse = arrow_csv.ParseOptions(delimiter=separator, ignore_empty_lines=False, invalid_row_handler=refuse)
    wanted = dict.fromkeys((str(header.at) for header in headers.values()), pa.string())
    convert = arrow_csv.ConvertOptions(column_types=wanted, include_columns=[*wanted], strings_can_be_null=False)
    try:
        reading = arrow_csv.ReadOptions(column_names=names, use_threads=False)
        table = arrow_csv.read_csv(io.BytesIO(rows.encode()), reading, parse, convert)
    except pa.ArrowInvalid as error:
        raise InputError(f"not a CSV: {shorten(str(error), 120)}", where=where) from None
    if ragged:
        line, cells = ragged[0]
        hint = "a decimal comma read as a separator? separate the columns by semicolons" if separator == "," else None
        problem = f"{cells} cells where the headers have {len(names)}"
        raise InputError(problem, where=f"{where}, line {line}", hint=hint)
    return {name: pc.utf8_trim_whitespace(table[str(header.at)]) for name, header in headers.items()}


def _numbers(cells: Any, header: _Header, separator: str, where: str) -> Array:
    """A column's numbers in SI, NaN where a cell is empty."""
    import pandas as pd

    texts = cells.to_pandas()
    texts = texts.str.replace(",", ".", regex=False) if separator != "," else texts
    numbers = pd.to_numeric(texts, errors="coerce")
    for at in np.flatnonzero(numbers.isna()).tolist():
        if texts[at].lower() not in _MISSING:
            problem = f'{header.name} is "{shorten(texts[at])}", not a number'
            hint = "units belong in the header, and the decimal sign is a point"
            raise InputError(problem, where=_line(where, at), hint=hint)
    return np.asarray(numbers, dtype=np.float64) * header.factor


def _line(where: str, at: int) -> str:
    return f"{where}, line {at + 2}"


def _plausible(numbers: Array, header: _Header, where: str) -> Array:
    """The numbers, unless one is of a person that nobody is: three metres tall, or in another unit than stated."""
    low, high = PLAUSIBLE[header.name]
    odd = (numbers < low) | (numbers > high)
    if not odd.any():
        return numbers
    at, quantity = int(np.argmax(odd)), QUANTITIES[header.name]
    unit, written = factor_of(quantity.shown_in), numbers[at] / header.factor
    possible = [symbol for symbol in known_units(quantity.dimension) if low <= written * factor_of(symbol) <= high]
    count = f" (and {int(odd.sum()) - 1} persons more)" if odd.sum() > 1 else ""
    given = f"{numbers[at] / unit:.6g} {quantity.shown_in}{count}"
    problem = f"{header.name} is {given}, expected {low / unit:g} to {high / unit:g} {quantity.shown_in}"
    mixed = f"{written:.6g} {possible[0]} would be possible: are units mixed?" if possible else None
    raise InputError(problem, where=_line(where, at), hint=mixed)


def _weighting(weighting: Array, where: str) -> Array:
    wrong = ~(np.isfinite(weighting) & (weighting >= 0.0))
    if wrong.any():
        at = int(np.argmax(wrong))
        given = "empty" if np.isnan(weighting[at]) else f"{weighting[at]:g}"
        raise InputError(f"weighting is {given}, expected 0 or more", where=_line(where, at))
    if not weighting.any():
        raise InputError("every weighting is 0, so that nobody counts", where=where)
    return weighting


def _names(cells: Any, where: str) -> tuple[str, ...]:
    """The names of the persons, each once."""
    lines: dict[str, int] = {}
    for at, name in enumerate(shorten(name, 200) for name in cells.to_pylist()):
        if not name:
            raise InputError("a person without a name in a file of names", where=_line(where, at))
        if lines.setdefault(name, at) != at:
            problem = f'"{shorten(name)}" names two persons, the other in line {lines[name] + 2}'
            raise InputError(problem, where=_line(where, at), hint="each name stands once")
    return tuple(lines)


def _sexes(cells: Any, where: str) -> npt.NDArray[np.str_]:
    words = [_SEX_WORDS.get(word.casefold()) for word in cells.to_pylist()]
    if None in words:
        at = words.index(None)
        problem = f'sex is "{shorten(cells[at].as_py())}", expected male or female'
        raise InputError(problem, where=_line(where, at))
    return np.array(words)
