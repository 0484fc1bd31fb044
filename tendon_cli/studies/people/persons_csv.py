"""Real persons from a CSV: some dimensions of each, with units in the headers."""

from __future__ import annotations

import difflib
import re
import unicodedata
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.csv_columns import Sheet, name_and_unit, unit_symbol
from tendon_cli.studies.magnitude import Slip, column_slips
from tendon_cli.units import factor_of, known_units, shorten

_SEX_WORDS = {
    "m": "male",
    "male": "male",
    "man": "male",
    "f": "female",
    "female": "female",
    "woman": "female",
}
_MISSING = ("", "na", "n/a", "nan", "null", "-")
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


class _Header(NamedTuple):
    place: int
    """Place of the column."""
    unit: str
    """Unit as written, empty if there is none."""


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
    sheet = Sheet.of(content, where, "person")
    faulty_rows = len(sheet.faults)
    headers, ignored = _headers(sheet)
    has_faulty_header = len(sheet.faults) > faulty_rows
    values = np.full((len(sheet.kept), len(DIMENSIONS)), np.nan)
    is_empty = np.ones(len(sheet.kept), dtype=bool)
    weighting = np.ones(len(sheet.kept))
    sexes = None
    names = tuple(f"person {row + 1}" for row in range(len(values)))
    slips: list[Slip] = []
    for name, (place, unit) in headers.items():
        with sheet.collected():
            if name in DIMENSIONS:
                is_empty &= sheet.is_missing(place, _MISSING)
                numbers, slips_of_column = _dimension(sheet, place, name, unit)
                values[:, DIMENSIONS.index(name)] = numbers
                slips += slips_of_column
            elif name == "weighting":
                weighting = _weighting(sheet, place)
            elif name == "sex":
                sexes = _sexes(sheet, place)
            else:
                names = _names(sheet, place)
    if not has_faulty_header:
        for row in np.flatnonzero(is_empty).tolist():
            sheet.refuse(row, "a person without any dimension")
    sheet.raise_faults(() if accepts_slips else slips)
    return PersonRows(tuple(headers), names, sexes, values, weighting, ignored, tuple(slips))


def _headers(sheet: Sheet) -> tuple[dict[str, _Header], list[str]]:
    """Return the columns that are read by name, and a note on those that are not.

    Headers that are nearly known, or given twice, are faults of the sheet.

    Raises:
        InputError: No column is a dimension of a body.
    """
    headers: dict[str, _Header] = {}
    dimensions = [name_and_unit(text, DIMENSIONS) for text in sheet.header]
    given = {name for name, _ in filter(None, dimensions)}
    given.update(text.casefold() for text in sheet.header if text.casefold() in _OTHERS)
    for place, text in enumerate(sheet.header):
        known = name_and_unit(text, DIMENSIONS)
        if text.casefold() in _OTHERS:
            known = text.casefold(), ""
        with sheet.collected():
            if known is None:
                _refuse_near_misses(text, given, sheet.where)
                continue
            name, unit = known
            if name in headers:
                first = shorten(sheet.header[headers[name].place], 30)
                second = shorten(text, 30)
                problem = f'{name} is given by two columns, "{first}" and "{second}"'
                raise InputError(problem, where=sheet.where, hint="leave one of them out")
            headers[name] = _Header(place, unit)
    if not set(headers).intersection(DIMENSIONS):
        sheet.raise_faults()
        found = shorten(", ".join(sheet.header))
        problem = f"no column is a dimension of a body, the headers read: {found}"
        hint = f"such as weight (kg), stature (cm); dimensions: {', '.join(DIMENSIONS)}"
        raise InputError(problem, where=sheet.where, hint=hint)
    return headers, sheet.ignored({header.place for header in headers.values()})


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


def _dimension(sheet: Sheet, place: int, name: str, unit: str) -> tuple[Array, tuple[Slip, ...]]:
    """Return a column of a dimension in SI, and its values that are far from any person.

    Values of 0 or less are faults of the sheet.

    Raises:
        InputError: The column has no unit of its dimension.
    """
    numbers = sheet.numbers(place, name, _MISSING)
    symbol = unit_symbol(name, unit, QUANTITIES[name].dimension, sheet.where)
    is_impossible = numbers <= 0.0
    for row in np.flatnonzero(is_impossible).tolist():
        sheet.refuse(row, f"{name} is {numbers[row]:.6g} {symbol}, expected more than 0")
    values = np.where(is_impossible, np.nan, numbers) * factor_of(symbol)
    places = [sheet.place(row) for row in range(len(values))]
    return values, column_slips(name, values, symbol, name, places)


def _weighting(sheet: Sheet, place: int) -> Array:
    """Return the weights of the persons; negative ones are faults of the sheet.

    Raises:
        InputError: All are 0.
    """
    weighting = sheet.numbers(place, "weighting")
    for row in np.flatnonzero(weighting < 0.0).tolist():
        sheet.refuse(row, f"weighting is {weighting[row]:g}, expected 0 or more")
    if not weighting.any():
        raise InputError("every weighting is 0, so nobody counts", where=sheet.where)
    return weighting


def _names(sheet: Sheet, place: int) -> tuple[str, ...]:
    """Return the names of the persons; empty ones and those of several are faults of the sheet."""
    rows: dict[str, int] = {}
    for row, text in enumerate(sheet.columns[place].to_pylist()):
        name = shorten(text, 200)
        if not name:
            sheet.refuse(row, "a person without a name in a file of names")
        elif name in rows:
            line = sheet.kept[rows[name]] + 1
            problem = f'"{shorten(name)}" is the name of two persons, the other in line {line}'
            sheet.refuse(row, problem, "each name may be used only once")
        else:
            rows[name] = row
    return tuple(rows)


def _sexes(sheet: Sheet, place: int) -> npt.NDArray[np.str_]:
    """Return "male" or "female" for each person; any other word is a fault of the sheet."""
    texts = sheet.columns[place].to_pylist()
    words = [_SEX_WORDS.get(text.casefold(), "") for text in texts]
    for row, word in enumerate(words):
        if not word:
            sheet.refuse(row, f'sex is "{shorten(texts[row])}", expected male or female')
    return np.array(words)
