"""What the columns of a file of persons are, from their headers: a dimension and its unit, a name, sex or weighting."""

from __future__ import annotations

import csv
import difflib
import re
import unicodedata
from dataclasses import dataclass

from tendon_cli.errors import InputError
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.units import UNITS, known_units, shorten

_OTHERS = ("name", "sex", "weighting")
_GERMAN = {
    "gewicht": "weight",
    "korpergewicht": "weight",
    "masse": "weight",
    "korpermasse": "weight",
    "grosse": "stature",
    "korpergrosse": "stature",
    "korperhohe": "stature",
    "oberarmlange": "acromion_radiale_length",
    "unterarmlange": "radiale_stylion_length",
    "oberarmumfang": "biceps_circumference",
    "unterarmumfang": "forearm_circumference",
    "handgelenkumfang": "wrist_circumference",
    "geschlecht": "sex",
    "gewichtung": "weighting",
}
"""What a German header would be here, without its dots: it is refused, since what it says would be guessed anew."""


@dataclass(frozen=True)
class Header:
    """A column that is read: its place in the file, its header, what it is, and SI units per unit of its numbers."""

    at: int
    text: str
    name: str
    factor: float = 1.0


def read_headers(line: str, separator: str, where: str) -> tuple[list[Header], list[str]]:
    """The columns that are read, and a note on those that are not."""
    known: dict[str, Header] = {}
    ignored = []
    for at, text in enumerate(cells_of(line, separator, where)):
        header = _header(at, text, where)
        if header is None:
            ignored.append(shorten(text, 30))
            continue
        if header.name in known:
            both = f'"{shorten(known[header.name].text, 30)}" and "{shorten(text, 30)}"'
            raise InputError(f"{header.name} stands in two columns, {both}", where=where, hint="leave one of them out")
        known[header.name] = header
    if not set(known).intersection(DIMENSIONS):
        headers = shorten(line.strip())
        hint = f"such as weight (kg), stature (cm); dimensions: {', '.join(DIMENSIONS)}"
        raise InputError(f"no column is a dimension of a body, the headers read: {headers}", where=where, hint=hint)
    more = f" and {len(ignored) - 5} more" if len(ignored) > 5 else ""
    note = [f"{where}: columns not read: {', '.join(ignored[:5])}{more}"] if ignored else []
    return list(known.values()), note


def cells_of(line: str, separator: str, where: str) -> list[str]:
    """The cells of one line, quotes removed."""
    try:
        return next(csv.reader([line], delimiter=separator, strict=True), [])
    except csv.Error as error:
        raise InputError(f"the headers are no row of CSV: {error}", where=where) from None


def _header(at: int, text: str, where: str) -> Header | None:
    """What one header says; None for a column that is nothing of ours."""
    letters = unicodedata.normalize("NFKD", text.casefold())
    plain = re.sub(r"[^a-z0-9]+", "_", "".join(each for each in letters if not unicodedata.combining(each))).strip("_")
    if plain in _OTHERS:
        return Header(at, text, plain)
    name, _, symbol = plain.rpartition("_")
    if plain in DIMENSIONS or (name in DIMENSIONS and symbol not in UNITS):
        dimension = QUANTITIES[plain if plain in DIMENSIONS else name]
        given = "has no unit" if plain in DIMENSIONS else f'has the unknown unit "{symbol}"'
        units = ", ".join(known_units(dimension.dimension))
        hint = f"such as {dimension.name} ({dimension.shown_in}); units of {dimension.dimension}: {units}"
        raise InputError(f'the header "{shorten(text)}" {given}', where=where, hint=hint)
    if name in DIMENSIONS:
        unit, wanted = UNITS[symbol], QUANTITIES[name].dimension
        if unit.dimension != wanted:
            hint = f"units of {wanted}: {', '.join(known_units(wanted))}"
            raise InputError(f'the header "{shorten(text)}" has a unit of {unit.dimension}', where=where, hint=hint)
        return Header(at, text, name, float(unit.factor))
    word = re.sub("(?<=[aou])e", "", plain.partition("_")[0])  # ae, oe, ue stand for one with dots
    if german := _GERMAN.get(plain.partition("_")[0], _GERMAN.get(word)):
        in_unit = f" ({symbol if symbol in UNITS else QUANTITIES[german].shown_in})" if german in DIMENSIONS else ""
        hint = f'write "{german}{in_unit}"; known are: {", ".join((*DIMENSIONS, *_OTHERS))}'
        raise InputError(f'the header "{shorten(text)}" is not in English', where=where, hint=hint)
    near = difflib.get_close_matches(name or plain, (*DIMENSIONS, *_OTHERS), n=1, cutoff=0.8)
    if near:
        problem = f'the header "{shorten(text)}" is not known'
        raise InputError(problem, where=where, hint=f'did you mean "{near[0]}", with its unit?')
    return None
