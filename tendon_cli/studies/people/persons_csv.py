"""Real persons from a CSV: some of the dimensions each, with units in the headers."""

from __future__ import annotations

import difflib
import re
import unicodedata
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.csv_columns import Sheet, name_and_unit, unit_factor
from tendon_cli.studies.people.survey import PLAUSIBLE
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


def read_listed(content: bytes, where: str) -> Listed:
    """The rows of a CSV file of persons.

    A header is a dimension with its unit, such as `weight (kg)` or `weight_kg`, or `name`, `weighting`, `sex`. Raises
    InputError.
    """
    sheet = Sheet.of(content, where, "person")
    units, ignored = _headers(sheet)
    values, weighting = (
        np.full((len(sheet.kept), len(DIMENSIONS)), np.nan),
        np.ones(len(sheet.kept)),
    )
    for name, (at, unit) in units.items():
        if name in DIMENSIONS:
            values[:, DIMENSIONS.index(name)] = _dimension(sheet, at, name, unit)
        elif name == "weighting":
            weighting = _weighting(sheet, at)
    empty = np.isnan(values).all(axis=1)
    if empty.any():
        raise InputError("a person without any dimension", where=sheet.place(int(np.argmax(empty))))
    sexes = _sexes(sheet, units["sex"][0]) if "sex" in units else None
    unnamed = tuple(f"person {at + 1}" for at in range(len(values)))
    names = _names(sheet, units["name"][0]) if "name" in units else unnamed
    return Listed(tuple(units), names, sexes, values, weighting, ignored)


def _headers(sheet: Sheet) -> tuple[dict[str, tuple[int, str]], list[str]]:
    """Place and unit of the columns that are read, by what they are, and a note on those that are not."""
    units: dict[str, tuple[int, str]] = {}
    ignored = []
    for at, text in enumerate(sheet.header):
        named = name_and_unit(text, DIMENSIONS)
        if text.casefold() in _OTHERS:
            named = text.casefold(), ""
        if named is None:
            _refuse_other_words(text, sheet.where)
            ignored.append(shorten(text, 30))
        elif named[0] in units:
            both = " and ".join(
                f'"{shorten(sheet.header[each], 30)}"' for each in (units[named[0]][0], at)
            )
            problem = f"{named[0]} stands in two columns, {both}"
            raise InputError(problem, where=sheet.where, hint="leave one of them out")
        else:
            units[named[0]] = at, named[1]
    if not set(units).intersection(DIMENSIONS):
        hint = f"such as weight (kg), stature (cm); dimensions: {', '.join(DIMENSIONS)}"
        problem = f"no column is a dimension of a body, the headers read: {shorten(', '.join(sheet.header))}"
        raise InputError(problem, where=sheet.where, hint=hint)
    more = f" and {len(ignored) - 5} more" if len(ignored) > 5 else ""
    return units, [
        f"{sheet.where}: columns not read: {', '.join(ignored[:5])}{more}"
    ] if ignored else []


def _refuse_other_words(text: str, where: str) -> None:
    """Raises InputError for a header that is nearly known, or is in another language."""
    plain = unicodedata.normalize("NFKD", text.casefold().replace("ß", "ss"))
    words = re.sub(
        r"[^a-z0-9]+", "_", "".join(sign for sign in plain if not unicodedata.combining(sign))
    ).split("_")
    german = _GERMAN.get(re.sub("(?<=[aou])e", "", words[0]))  # ae, oe, ue stand for one with dots
    name = text.partition("(")[0].partition("[")[0].strip().casefold()
    if meant := german or "".join(difflib.get_close_matches(name, _KNOWN, n=1, cutoff=0.8)):
        quantity = QUANTITIES.get(meant)
        unit = next(
            (word for word in words if quantity and word in known_units(quantity.dimension)), None
        )
        given = f" ({unit or quantity.shown_in})" if quantity else ""
        hint = f'write "{meant}{given}"; known are: {", ".join(_KNOWN)}'
        raise InputError(f'the header "{shorten(text)}" is not known', where=where, hint=hint)


def _dimension(sheet: Sheet, at: int, name: str, unit: str) -> Array:
    """A dimension in SI; raises InputError for a person that nobody is: three metres tall, or in another unit."""
    quantity, (low, high) = QUANTITIES[name], PLAUSIBLE[name]
    factor = unit_factor(name, unit, quantity.dimension, sheet.where)
    numbers = sheet.numbers(at, name, _MISSING) * factor
    odd = np.flatnonzero((numbers < low) | (numbers > high))
    if not odd.size:
        return numbers
    row, shown = int(odd[0]), factor_of(quantity.shown_in)
    written = numbers[row] / factor
    possible = [
        symbol
        for symbol in known_units(quantity.dimension)
        if low <= written * factor_of(symbol) <= high
    ]
    count = f" (and {odd.size - 1} persons more)" if odd.size > 1 else ""
    problem = f"{name} is {numbers[row] / shown:.6g} {quantity.shown_in}{count}"
    problem += f", expected {low / shown:g} to {high / shown:g} {quantity.shown_in}"
    mixed = f"{written:.6g} {possible[0]} would be possible: are units mixed?" if possible else None
    raise InputError(problem, where=sheet.place(row), hint=mixed)


def _weighting(sheet: Sheet, at: int) -> Array:
    weighting = sheet.numbers(at, "weighting")
    if (weighting < 0.0).any():
        row = int(np.argmax(weighting < 0.0))
        raise InputError(
            f"weighting is {weighting[row]:g}, expected 0 or more", where=sheet.place(row)
        )
    if not weighting.any():
        raise InputError("every weighting is 0, so that nobody counts", where=sheet.where)
    return weighting


def _names(sheet: Sheet, at: int) -> tuple[str, ...]:
    """The names of the persons, each once."""
    rows: dict[str, int] = {}
    for row, name in enumerate(shorten(name, 200) for name in sheet.columns[at].to_pylist()):
        if not name:
            raise InputError("a person without a name in a file of names", where=sheet.place(row))
        if rows.setdefault(name, row) != row:
            problem = f'"{shorten(name)}" names two persons, the other in line {sheet.kept[rows[name]] + 1}'
            raise InputError(problem, where=sheet.place(row), hint="each name stands once")
    return tuple(rows)


def _sexes(sheet: Sheet, at: int) -> npt.NDArray[np.str_]:
    words = [_SEX_WORDS.get(word.casefold()) for word in sheet.columns[at].to_pylist()]
    if None in words:
        row = words.index(None)
        problem = f'sex is "{shorten(sheet.columns[at][row].as_py())}", expected male or female'
        raise InputError(problem, where=sheet.place(row))
    return np.array(words)
