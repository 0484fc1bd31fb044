"""Numbers, quantities, shares and columns in words.

Values are SI and are shown in the unit that people read. Thousands are grouped by commas, numbers have as many
significant digits as are asked for, and no exponent where people would write none.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context
from typing import Any

from tendon_cli import units
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.units import counted

WIDTH = 80
_TWO_SIDED_95 = 1.959963984540054
_JOINED = "\u00a0"
_UNIT = re.compile(
    r"(?<=\d) (?=(?:N|kN|mm|m|deg|kPa|kg|rad|GPa|1)\b|%)|(?<=\d N) (?=m\b)|(?<=\b[A-Zημφψ]) (?=\d)"
)
"""Blanks within a quantity, where no line ends."""

# --- Numbers ---------------------------------------------------------------------------------------------------------


def number(value: float, digits: int = 4, *, toward: float | None = None) -> str:
    """A number to some significant digits: "0.0732", "12,500", "1e-07".

    It is the nearest one, or with `toward` the next one on the way to infinity or minus infinity. Raises nothing: what
    is not finite is "any" (infinity), "none" (minus infinity) or "-" (not a number).
    """
    if not math.isfinite(value):
        return "-" if math.isnan(value) else "any" if value > 0 else "none"
    rounding = ROUND_HALF_EVEN if toward is None else ROUND_CEILING if toward > 0 else ROUND_FLOOR
    short = float(Context(prec=digits, rounding=rounding).create_decimal(repr(float(value))))
    size = abs(short)
    if short == 0.0:
        return "0"
    if size >= 10**digits and size < 1e15:
        return f"{short:,.0f}"
    if not 1e-5 < size < 1e15:
        return f"{short:.{digits}g}"
    places = max(0, digits - 1 - math.floor(math.log10(size)))
    text = f"{short:,.{places}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def factor_of(quantity: Quantity) -> float:
    """What SI values of a quantity are divided by to be in the unit that people read it in."""
    return units.factor_of(quantity.shown_in)


def quantity(
    of: Quantity | str, value: float, digits: int = 3, *, toward: float | None = None
) -> str:
    """An SI value in the unit that people read it in: "148 N", "65.8 mm". `of` may be the name of a quantity."""
    kind = QUANTITIES[of] if isinstance(of, str) else of
    if kind.dimension == "stiffness" and math.isinf(value):
        return "rigid"
    text = number(value / factor_of(kind), digits, toward=toward)
    return text if kind.shown_in == "1" else f"{text} {kind.shown_in}"


def parameter(of: Quantity, value: float, side: str = "", digits: int = 3) -> str:
    """A number of a study with its symbol: "K 3 kN/m", "K of the flexor 3 kN/m"; a load without: "5 kg load"."""
    if of.name == "load_mass":
        return f"{quantity(of, value, digits)} load"
    if of.name == "load_scale":
        return f"{number(value, digits)} times the task"
    return f"{of.symbol}{f' of the {side}' if side else ''} {quantity(of, value, digits)}"


def side_of(key: str) -> str:
    """The side that a dotted key or a column names: "flexor", "extensor" or none."""
    return next(
        (side for side in ("flexor", "extensor") if f".{side}." in key or key.endswith(f"_{side}")),
        "",
    )


def window(low: float, high: float, digits: int = 4, unit: str = "N") -> str:
    """An interval of pretension: "122.1 to 173.9 N", "62 N or more"."""
    if math.isinf(high):
        return f"{number(low, digits)} {unit} or more"
    return f"{number(low, digits)} to {number(high, digits)} {unit}"


def within(value: float, low: float, high: float, digits: int = 4) -> str:
    """A number of an interval with at least so many digits, and as many as it takes to lie in it as printed."""
    if not low <= value <= high:
        return number(value, digits)
    for more in range(digits, 17):
        for toward in (None, math.inf, -math.inf):
            text = number(value, more, toward=toward)
            if low <= float(text.replace(",", "")) <= high:
                return text
    return repr(value)


def size(count: float) -> str:
    """Bytes: "3.2 MB"."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if count < 1000:
            return f"{number(count, 3)} {unit}"
        count /= 1000
    return f"{number(count, 4)} PB"


def duration(seconds: float) -> str:
    """Time that something takes: "2.5 min"."""
    for unit, length in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 2 * length:
            return f"{number(seconds / length, 2)} {unit}"
    return f"{number(seconds, 2)} s"


# --- Shares ----------------------------------------------------------------------------------------------------------


def percent(share: float) -> str:
    """A share in percent. Nearly all is not all, and hardly any is not none: "over 99.9 %", "under 0.1 %"."""
    if 0.9995 <= share < 1.0:
        return "over 99.9 %"
    if 0.0 < share < 0.0005:
        return "under 0.1 %"
    return f"{number(100.0 * share, 3)} %"


def share(part: int, whole: int, noun: str) -> str:
    """A part of a whole that is counted: "3 of 12 designs (25 %)"."""
    return f"{part:,} of {counted(whole, noun)}" + (
        f" ({percent(part / whole)})" if 0 < part < whole else ""
    )


def interval(served: float, count: float) -> tuple[float, float]:
    """The 95 % interval of a share of a sample (Wilson 1927); `count` may be an effective one, (Σw)² / Σw²."""
    z2 = _TWO_SIDED_95**2 / count
    centre = (served + z2 / 2.0) / (1.0 + z2)
    reach = math.sqrt(z2 * (served * (1.0 - served) + z2 / 4.0)) / (1.0 + z2)
    low = 0.0 if served <= 0.0 else max(centre - reach, 0.0)
    return low, 1.0 if served >= 1.0 else min(centre + reach, 1.0)


def sampled_share(served: float, count: int, noun: str, effective: float | None = None) -> str:
    """A share of a sample with what it says of everyone.

    "all 1,000 persons (at least 99.6 %)", "97.5 % of 1,000 persons (96.3 to 98.3 %)", "none of 40 draws (at most
    8.8 %)". A sample of one says nothing of others: "this person", "not this person".
    """
    if count == 1:
        return f"this {noun}" if served > 0.5 else f"not this {noun}"
    low, high = interval(served, effective or count)
    if served >= 1.0:
        return f"all {counted(count, noun)} (at least {_bound(low, ROUND_FLOOR)} %)"
    if served <= 0.0:
        return f"none of {counted(count, noun)} (at most {_bound(high, ROUND_CEILING)} %)"
    span = f"{_bound(low, ROUND_FLOOR)} to {_bound(high, ROUND_CEILING)} %"
    return f"{percent(served)} of {counted(count, noun)} ({span})"


def _bound(share: float, rounding: str) -> str:
    return f"{Context(rounding=rounding).create_decimal(repr(100.0 * share)).quantize(_TENTH, rounding):f}"


_TENTH = Context().create_decimal("0.1")

# --- Columns, sentences ----------------------------------------------------------------------------------------------

_PLACES = {"_proximal": " at the motor", "_distal": " at the elbow", "_": " "}
_COLUMNS = {
    "radius_ratio": "flexor over extensor travel",
    "served": "share served",
    "served_at": "share served at the pretension",
    "pretension_from": "smallest pretension",
    "pretension_to": "largest pretension",
    **{name: f"anchor distance {name}" for name in ("a1", "b1", "a2", "b2")},
}


def column(name: str) -> str:
    """A column or a quantity by its name: "flexor tension at the elbow", "largest pretension"."""
    words = _COLUMNS.get(name, name)
    for mark, word in _PLACES.items():
        words = words.replace(mark, word)
    return words


def listed(words: Sequence[str], last: str = "and") -> str:
    """Several in a sentence: "a, b and c"."""
    return f"{', '.join(words[:-1])} {last} {words[-1]}" if len(words) > 1 else "".join(words)


def reading(read: str) -> tuple[str, str]:
    """What is set, and where it is read: "tension" " in the flexor at the joint"; a pretension nowhere."""
    side, _, end = read.partition(" at ")
    return ("tension", f" in the {side} at the {end}") if end else ("pretension", "")


def filled(text: str, indent: str = "") -> list[str]:
    """A sentence on as many lines of 80 columns as it takes; no line ends within a quantity."""
    lines = textwrap.wrap(
        _UNIT.sub(_JOINED, text),
        WIDTH,
        initial_indent=indent,
        subsequent_indent=indent + "  ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(_JOINED, " ") for line in lines]


def aligned(lines: Sequence[Sequence[str]], least: int = 4) -> list[str]:
    """Cells as columns of a table of 80 signs at most, indented; its last columns go if they do not fit."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    while sum(widths) + 2 * len(widths) > WIDTH and len(widths) > least:
        widths.pop()
    rows = (
        [cell.ljust(width) for cell, width in zip(line, widths, strict=False) if width]
        for line in lines
    )
    return [f"  {'  '.join(cells)}".rstrip()[:WIDTH] for cells in rows]


# --- The joint -------------------------------------------------------------------------------------------------------

_ELBOW = re.compile(r"\b(?:(an?) )?(elbow)\b", re.IGNORECASE)


def joint_word(study: Any) -> str:
    """What a study calls its joint, "elbow" by default: of a `Study`, its document, or a record that holds one."""
    while isinstance(study, Mapping) and "study" in study:
        study = study["study"]
    if isinstance(study, Mapping):
        return str(study.get("joint", {}).get("name", "elbow"))
    return str(study.joint.name)


def of_joint(text: str, study: Any) -> str:
    """A text of ours about the elbow, with the study's own joint in it: "the ankle", "a wrist"; keys and columns stay.

    `study` is what `joint_word` takes, or the word itself.
    """
    word = study if isinstance(study, str) else joint_word(study)
    if word == "elbow":
        return text

    def named(match: re.Match[str]) -> str:
        article, elbow = match.groups()
        put = word[0].upper() + word[1:] if elbow[0].isupper() else word
        return (
            put
            if article is None
            else f"{article[0]}{'n' if word[0].lower() in 'aeiou' else ''} {put}"
        )

    return _ELBOW.sub(named, text)
