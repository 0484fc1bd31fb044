"""Real persons from a CSV: some dimensions of each, with units in the headers."""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.readers.heading import Heading, columns_named
from tendon_cli.readers.table import Table, read_table
from tendon_cli.studies.magnitude import Slip, column_slips, raise_with_slips
from tendon_cli.units import factor_of, known_units, shorten

_SEX_WORDS = {
    "m": "male",
    "male": "male",
    "man": "male",
    "f": "female",
    "female": "female",
    "woman": "female",
}
_OTHERS = ("name", "sex", "weighting")
_KNOWN = (*DIMENSIONS, *_OTHERS)
_ENGLISH = {
    **dict.fromkeys(("height", "body_height", "standing_height"), "stature"),
    **dict.fromkeys(("mass", "body_mass", "body_weight", "bodyweight", "bodymass"), "weight"),
    "gender": "sex",
    **dict.fromkeys(("upper_arm_length", "upperarm_length"), "acromion_radiale_length"),
    **dict.fromkeys(("forearm_length", "lower_arm_length"), "radiale_stylion_length"),
    **dict.fromkeys(("upper_arm_circumference", "biceps"), "biceps_circumference"),
}
"""Names of columns by other English headers. Such a header is refused with a hint, too."""
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
"""Names of columns by German headers, without their dots. Such a header is refused with a hint,
since its meaning would be guessed."""


@dataclass(frozen=True, eq=False)
class PersonRows:
    """Content of a file of persons, a row each."""

    columns: tuple[str, ...]
    """Columns that are read, in their order: dimensions, `name`, `sex`, `weighting`."""
    names: tuple[str, ...]
    """Names, all different."""
    sexes: npt.NDArray[np.str_] | None
    """"male" or "female", (n,); None if the file does not say."""
    values: Array
    """Dimensions in the order of `DIMENSIONS`, (n, 8), SI, NaN where the file has none."""
    weighting: Array
    """Weight of each person in a share, (n,)."""
    ignored: list[str]
    """Note on columns that are not read, if there are any."""
    slips: tuple[Slip, ...]
    """Values that are far from any person."""


def read_persons(content: bytes, where: str, *, accepts_slips: bool = True) -> PersonRows:
    """Return the rows of a CSV file of persons.

    A header is a dimension with its unit, such as `weight (kg)` or `weight_kg`, or `name`,
    `weighting`, `sex`.

    Args:
        content: The file.
        where: Name of the file in errors.
        accepts_slips: False to list values far from any person among the faults of a file that has
            others.

    Raises:
        InputError: The file cannot be used; it lists all faults.
    """
    table = read_table(content, _known, source=where, noun="person")
    faulty_rows = len(table.faults)
    headers = _headers(table)
    has_faulty_header = len(table.faults) > faulty_rows
    values = np.full((len(table), len(DIMENSIONS)), np.nan)
    is_empty = np.ones(len(table), dtype=bool)
    weighting = np.ones(len(table))
    sexes = None
    names = tuple(f"person {row + 1}" for row in range(len(values)))
    slips: list[Slip] = []
    for name, column in headers.items():
        with table.collected():
            if name in DIMENSIONS:
                is_empty &= table.is_missing(column)
                numbers, slips_of_column = _dimension(table, column, name)
                values[:, DIMENSIONS.index(name)] = numbers
                slips += slips_of_column
            elif name == "weighting":
                weighting = _weighting(table, column)
            elif name == "sex":
                sexes = _sexes(table, column)
            else:
                names = _names(table, column)
    if not has_faulty_header:
        for row in np.flatnonzero(is_empty).tolist():
            table.refuse("a person without any dimension", row=row)
    raise_with_slips(table, () if accepts_slips else slips)
    notes = [*table.unread(headers.values()), *table.notes]
    return PersonRows(tuple(headers), names, sexes, values, weighting, notes, tuple(slips))


def _known(columns: Sequence[Heading]) -> list[Heading]:
    """Return the columns of a line that names a dimension of a body."""
    found = [column for name in DIMENSIONS for column in columns_named(columns, [name])]
    others = [column for column in columns if column.header.casefold() in _OTHERS]
    return [*found, *others] if found else []


def _headers(table: Table) -> dict[str, Heading]:
    """Return the columns that are read by name.

    Headers that are nearly known, or given twice, are faults of the table.

    Raises:
        InputError: No column is a dimension of a body.
    """
    by_name = {name: table.named(name) for name in DIMENSIONS}
    for name in _OTHERS:
        by_name[name] = [one for one in table.columns if one.header.casefold() == name]
    given = {name for name, found in by_name.items() if found}
    known = {column.index for found in by_name.values() for column in found}
    headers: dict[str, Heading] = {}
    for name, found in by_name.items():
        with table.collected():
            column = table.only(found, name)
            if column is not None:
                headers[name] = column
    for column in table.columns:
        if column.index not in known:
            with table.collected():
                _refuse_near_misses(column.header, given, table.place(column))
    if not given.intersection(DIMENSIONS):
        table.raise_faults()
        problem = f"no column is a dimension of a body, the columns are {table.shown}"
        hint = f"such as weight (kg), stature (cm); dimensions: {', '.join(DIMENSIONS)}"
        raise InputError(problem, where=table.place(), hint=hint)
    return dict(sorted(headers.items(), key=lambda pair: pair[1].index))


def _refuse_near_misses(text: str, given: set[str], where: str) -> None:
    """Raise InputError for a header that is nearly known, or known by another word.

    Args:
        text: The header.
        given: Dimensions that other columns give; another word for one of them is no mistake.
        where: Name of the file in errors.
    """
    plain = unicodedata.normalize("NFKD", text.casefold().replace("ß", "ss"))
    without_marks = "".join(sign for sign in plain if not unicodedata.combining(sign))
    words = re.sub(r"[^a-z0-9]+", "_", without_marks).split("_")
    german = _GERMAN.get(re.sub("(?<=[aou])e", "", words[0]))  # ae, oe, ue stand for one with dots
    name = text.partition("(")[0].partition("[")[0].strip().casefold()
    english = _ENGLISH.get(_without_unit(words))
    if english in given:
        return
    others = {other: known for other, known in _ENGLISH.items() if known not in given}
    near = "".join(difflib.get_close_matches(name, (*_KNOWN, *others), n=1, cutoff=0.8))
    meant = english or german or others.get(near, near)
    if not meant:
        return
    expected = meant
    if quantity := QUANTITIES.get(meant):
        units = known_units(quantity.dimension)
        unit = next((word for word in words if word in units), quantity.shown_in)
        expected = f"{meant} ({unit})"
    hint = f'write "{expected}"; known headers: {", ".join(_KNOWN)}'
    raise InputError(f'the header "{shorten(text)}" is not known', where=where, hint=hint)


def _without_unit(words: list[str]) -> str:
    """Return the words of a header without the unit at its end: "height" of "height_cm"."""
    units = {
        unit.casefold() for name in DIMENSIONS for unit in known_units(QUANTITIES[name].dimension)
    }
    last = len(words)
    while last > 1 and (not words[last - 1] or words[last - 1] in units):
        last -= 1
    return "_".join(words[:last])


def _dimension(table: Table, column: Heading, name: str) -> tuple[Array, tuple[Slip, ...]]:
    """Return a column of a dimension in SI, and its values that are far from any person.

    Values of 0 or less, and a unit of another dimension, are faults of the table.
    """
    numbers = table.numbers(column, may_lack=True)
    symbol = table.unit_of(column, QUANTITIES[name].dimension)
    is_impossible = numbers <= 0.0
    for row in np.flatnonzero(is_impossible).tolist():
        problem = f"{name} is {numbers[row]:.6g} {symbol}, expected more than 0"
        table.refuse(problem, column=column, row=row)
    values = np.where(is_impossible, np.nan, numbers) * factor_of(symbol)
    if not symbol:
        return values, ()
    places = [table.place(row=row) for row in range(len(table))]
    return values, column_slips(name, values, symbol, name, places)


def _weighting(table: Table, column: Heading) -> Array:
    """Return the weights of the persons; negative ones are faults of the table.

    Raises:
        InputError: All are 0.
    """
    weighting = table.numbers(column)
    for row in np.flatnonzero(weighting < 0.0).tolist():
        problem = f"weighting is {weighting[row]:g}, expected 0 or more"
        table.refuse(problem, column=column, row=row)
    if not weighting.any():
        raise InputError("every weighting is 0, so nobody counts", where=table.source)
    return weighting


def _names(table: Table, column: Heading) -> tuple[str, ...]:
    """Return the names of the persons; empty ones and those of several are faults of the table."""
    rows: dict[str, int] = {}
    for row, text in enumerate(table.texts(column)):
        name = shorten(text, 200)
        if not name:
            table.refuse("a person without a name in a file of names", row=row)
        elif name in rows:
            line = table.lines[rows[name]]
            problem = f'"{shorten(name)}" is the name of two persons, the other in line {line}'
            table.refuse(problem, "each name may be used only once", row=row)
        else:
            rows[name] = row
    return tuple(rows)


def _sexes(table: Table, column: Heading) -> npt.NDArray[np.str_]:
    """Return "male" or "female" for each person; any other word is a fault of the table."""
    texts = table.texts(column)
    words = [_SEX_WORDS.get(text.casefold(), "") for text in texts]
    for row, word in enumerate(words):
        if not word:
            problem = f'sex is "{shorten(texts[row])}", expected male or female'
            table.refuse(problem, column=column, row=row)
    return np.array(words)
