"""Numbers, quantities, shares and columns in words.

Values are SI and are shown in the unit that people read. Thousands are grouped by commas, numbers
have as many significant digits as are asked for, and no exponent where people would write none.
"""

from __future__ import annotations

import json
import math
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context
from functools import lru_cache
from html import escape
from typing import TYPE_CHECKING, Any

from tendon_cli import units
from tendon_cli.quantities import QUANTITIES, SIDES, Quantity, bound_name
from tendon_cli.units import counted

if TYPE_CHECKING:
    from tendon_cli.verbs.answer_record import QuestionRecord

WIDTH = 80
"""Columns of a text."""
_NARROWEST = 24
"""Fewest columns in which words of a table are wrapped."""
_TWO_SIDED_95 = 1.959963984540054
"""Quantile of the normal distribution for an interval of 95 %."""
_SURELY = 1.0 + 1e-9
"""Factor by which a value must be beyond a bound to be so in spite of rounding."""
_SHORTEST = 1e-6
"""Length below which it is printed as 0, m."""
_TENTH = Context().create_decimal("0.1")
_JOINED = "\u00a0"
"""No-break space."""
_UNIT = re.compile(
    r"(?<=\d) (?=(?:N|kN|mm|m|deg|kPa|kg|rad|GPa|1)\b|%)|(?<=\d N) (?=m\b)|(?<=\b[A-Zημφψ]) (?=\d)"
    r"|(?<=±) (?=\d)| (?=[≤≥])|(?<=[≤≥]) (?=\d)"
)
"""Spaces within a quantity, at which no line is broken."""

# --- Numbers --------------------------------------------------------------------------------------


def number(value: float, digits: int = 4, *, toward: float | None = None) -> str:
    """Write a number to some significant digits: "0.0732", "12,500", "1e-07".

    A number that is not finite is "any" (infinity), "none" (minus infinity) or "-" (not a number).

    Args:
        value: Number to write.
        digits: Number of significant digits.
        toward: Infinity or minus infinity, to round that way; None to round to the nearest.
    """
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "any" if value > 0 else "none"
    rounding = ROUND_HALF_EVEN
    if toward is not None:
        rounding = ROUND_CEILING if toward > 0 else ROUND_FLOOR
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
    """Return the SI value of the unit that people read a quantity in."""
    return 1.0 if quantity.has_own_unit else units.factor_of(quantity.shown_in)


def quantity(
    of: Quantity | str, value: float, digits: int = 3, *, toward: float | None = None
) -> str:
    """Write an SI value in the unit that people read it in: "148 N", "65.8 mm".

    Args:
        of: Quantity, or its name.
        value: Value, SI.
        digits: Number of significant digits.
        toward: Infinity or minus infinity, to round that way; None to round to the nearest.
    """
    kind = QUANTITIES[of] if isinstance(of, str) else of
    if kind.dimension == "stiffness" and math.isinf(value):
        return "rigid"
    text = number(value / factor_of(kind), digits, toward=toward)
    return text if kind.shown_in == "1" else f"{text} {kind.shown_in}"


def parameter(of: Quantity, value: float, side: str = "", digits: int = 3) -> str:
    """Write a number of a study with its symbol: "K 3 kN/m", "K of the flexor 3 kN/m".

    A load has no symbol: "5 kg load".
    """
    text = quantity(of, value, digits)
    if of.name == "load_mass":
        return f"{text} load"
    if of.name == "load_scale":
        return f"{number(value, digits)} times the task"
    if side:
        return f"{of.symbol} of the {side} {text}"
    return f"{of.symbol} {text}"


def side_of(key: str) -> str:
    """Return the side that a dotted key or a column names: "flexor", "extensor", or ""."""
    for side in SIDES:
        if f".{side}." in key or key.endswith(f"_{side}"):
            return side
    return ""


def at_least(of: Quantity | str, value: float, digits: int = 3) -> str:
    """Write a quantity that is needed, rounded up, apart from errors of rounding."""
    return quantity(of, value / _SURELY, digits, toward=math.inf)


def at_most(of: Quantity | str, value: float, digits: int = 3) -> str:
    """Write a quantity that is allowed, rounded down, apart from errors of rounding."""
    return quantity(of, value * _SURELY, digits, toward=-math.inf)


def length_to_spare(value: float, digits: int = 2) -> str:
    """Write by how much a tendon may be too long or too short, rounded down: "8.7 mm"."""
    return "0 mm" if value < _SHORTEST else at_most("tolerance_length", value, digits)


def window_text(low: float, high: float, digits: int = 4, unit: str = "N") -> str:
    """Write an interval of pretension: "122.1 to 173.9 N", "62 N or more"."""
    if math.isinf(high):
        return f"{number(low, digits)} {unit} or more"
    return f"{number(low, digits)} to {number(high, digits)} {unit}"


def number_within(value: float, low: float, high: float, digits: int = 4) -> str:
    """Write a number of an interval so that the number as printed lies in it, too.

    It has at least `digits` significant digits, and more if needed.
    """
    if not low <= value <= high:
        return number(value, digits)
    for more in range(digits, 17):
        for toward in (None, math.inf, -math.inf):
            text = number(value, more, toward=toward)
            if low <= float(text.replace(",", "")) <= high:
                return text
    return repr(value)


def tolerance_that_is_enough(question: QuestionRecord, times: float = 1.0) -> str:
    """Write the tolerance of setting that is enough: "6 mm", or "15 N" if it is read as a tension.

    Args:
        question: Record of a question, with its accuracy and how many times this is enough.
        times: 2 for the width of a window of which the tolerance is half.
    """
    needed = times * question.needed
    length = question.accuracy.length
    tension = question.accuracy.tension
    if tension is not None:
        return f"{number(needed * tension, 3)} {question.unit}"
    return quantity("tolerance_length", needed * (length or 0.0))


def byte_size(count: float) -> str:
    """Write a number of bytes: "3.2 MB"."""
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if count < 1000:
            return f"{number(count, 3)} {unit}"
        count /= 1000
    return f"{number(count, 4)} PB"


def duration(seconds: float) -> str:
    """Write a duration: "2.5 min"."""
    for unit, length in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 2 * length:
            return f"{number(seconds / length, 2)} {unit}"
    return f"{number(seconds, 2)} s"


# --- Shares ---------------------------------------------------------------------------------------


def percent(share: float, digits: int = 3) -> str:
    """Write a share in percent.

    A share just below 1 is not rounded to 100 %, nor one just above 0 to none: "over 99.9 %",
    "under 0.1 %".

    Args:
        share: The share.
        digits: Significant digits.
    """
    step = 10.0 ** (2 - digits)  # of the last digit just below 100 %
    if 1.0 - 0.005 * step <= share < 1.0:
        return f"over {100.0 - step:g} %"
    if 0.0 < share < 0.005 * step:
        return f"under {step:g} %"
    return f"{number(100.0 * share, digits)} %"


def share(part: int, whole: int, noun: str) -> str:
    """Write a part of a whole that is counted: "3 of 12 designs (25 %)"."""
    text = f"{part:,} of {counted(whole, noun)}"
    if 0 < part < whole:
        text += f" ({percent(part / whole)})"
    return text


def interval(served: float, count: float) -> tuple[float, float]:
    """Return the 95 % interval of a share of a sample (Wilson 1927).

    Args:
        served: Share in the sample.
        count: Size of the sample, or its effective size (Σw)² / Σw².
    """
    z2 = _TWO_SIDED_95**2 / count
    centre = (served + z2 / 2.0) / (1.0 + z2)
    reach = math.sqrt(z2 * (served * (1.0 - served) + z2 / 4.0)) / (1.0 + z2)
    low = 0.0 if served <= 0.0 else max(centre - reach, 0.0)
    high = 1.0 if served >= 1.0 else min(centre + reach, 1.0)
    return low, high


def sampled_share(served: float, count: int, noun: str, effective: float | None = None) -> str:
    """Write the share served in a sample, with its 95 % interval for the population.

    "all 1,000 persons (at least 99.6 %)", "97.5 % of 1,000 persons (96.3 to 98.3 %)", "none of 40
    draws (at most 8.8 %)". A sample of one says nothing of others: "this person", "not this
    person".

    Args:
        served: Share in the sample.
        count: Size of the sample.
        noun: Singular noun for its members.
        effective: Effective size; `count` if it is None.
    """
    if count == 1:
        return f"this {noun}" if served > 0.5 else f"not this {noun}"
    low, high = interval(served, effective or count)
    return share_of(counted(count, noun), served, low, high)


def share_of(members: str, served: float, low: float, high: float, text: str = "") -> str:
    """Write a share with its interval: "all 40 draws (at least 91.2 %)", "none of 40 draws (...)".

    Args:
        members: Who or what is counted: "40 draws".
        served: The share.
        low: Lower end of its interval.
        high: Upper end.
        text: The share as it is written; in percent if empty.
    """
    span = interval_text(served, low, high)
    if served >= 1.0:
        return f"{all_of(members)} ({span})"
    if served <= 0.0:
        return f"none of {members} ({span})"
    return f"{text or percent(served)} of {members} ({span})"


def all_of(members: str) -> str:
    """Say all of who or what is counted: "all 40 draws", "both draws", "all of this man's"."""
    if members.startswith("this"):
        return f"all of {members}"
    if members.startswith("2 "):
        return f"both {members.removeprefix('2 ')}"
    return f"all {members}"


def interval_text(served: float, low: float, high: float) -> str:
    """Write the interval of a share, rounded outward: "at least 99.6 %", "96.3 to 98.3 %"."""
    if served >= 1.0:
        return f"at least {_bound(low, ROUND_FLOOR)} %"
    if served <= 0.0:
        return f"at most {_bound(high, ROUND_CEILING)} %"
    return f"{_bound(low, ROUND_FLOOR)} to {_bound(high, ROUND_CEILING)} %"


def _bound(share: float, rounding: str) -> str:
    """Write a share in percent, rounded up or down to a tenth."""
    exact = Context(rounding=rounding).create_decimal(repr(100.0 * share))
    return f"{exact.quantize(_TENTH, rounding):f}"


# --- Columns, sentences ---------------------------------------------------------------------------

_WORDS_OF_MARKS = {"_proximal": " at the motor", "_distal": " at the elbow"}
_BOUND = bound_name("")
"""Beginning of the name of a bound on a quantity."""
_COLUMNS = {
    "radius_ratio": "flexor over extensor travel",
    "served": "share served",
    "served_at": "share served at the pretension",
    "pretension_from": "smallest pretension",
    "pretension_to": "largest pretension",
    "motor_work_in": "motor work",
    **{name: f"anchor distance {name}" for name in ("a1", "b1", "a2", "b2")},
}


def column(name: str) -> str:
    """Return the words for a column or a quantity: "flexor tension at the elbow"."""
    if name.startswith(_BOUND):
        return f"limit on {column(name.removeprefix(_BOUND))}"
    words = _COLUMNS.get(name, name)
    for mark, word in _WORDS_OF_MARKS.items():
        words = words.replace(mark, word)
    return spaced(words)


def spaced(name: str) -> str:
    """Return a name as plain words, with spaces for underscores."""
    return name.replace("_", " ")


def join_words(words: Sequence[str], last: str = "and") -> str:
    """List words in a sentence: "a, b and c"."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def few(words: Sequence[str], most: int = 6) -> str:
    """Join words; of more than `most` name three and say how many others there are."""
    if len(words) <= most:
        return ", ".join(words)
    return f"{', '.join(words[:3])} and {len(words) - 3} more"


def setting_words(read: str) -> tuple[str, str]:
    """Return the word for the number that is set, and the place where it is read.

    "flexor at joint" is "tension" and " in the flexor at the joint"; a pretension and the torque of
    the motor have no place.
    """
    side, _, end = read.partition(" at ")
    if end:
        return "tension", f" in the {side} at the {end}"
    return read, ""


def unbroken(text: str) -> str:
    """Return a text in which no line may end within a quantity."""
    return _UNIT.sub(_JOINED, text)


def wrap(text: str, indent: str = "", width: int = WIDTH, later: str | None = None) -> list[str]:
    """Wrap a sentence to lines; no line ends within a quantity.

    Args:
        text: The sentence.
        indent: Beginning of the first line.
        width: Columns of a line; a longer word is broken if `later` is given.
        later: Beginning of the other lines; None for two spaces more than the first has.
    """
    lines = textwrap.wrap(
        unbroken(text),
        width,
        initial_indent=indent,
        subsequent_indent=indent + "  " if later is None else later,
        break_long_words=later is not None,
        break_on_hyphens=False,
    )
    return [line.replace(_JOINED, " ") for line in lines]


def align_cells(lines: Sequence[Sequence[str]], least: int = 4, width: int = WIDTH) -> list[str]:
    """Align the cells of a table in columns. Lines are indented and of at most `width` characters.

    Words in the last column are wrapped if they do not fit.

    Args:
        lines: Rows of the table, each with the same number of cells.
        least: Number of columns that are kept; further ones are dropped if they do not fit.
        width: Most characters of a line.
    """
    widths = [max(map(len, cells)) for cells in zip(*lines, strict=True)]
    room = width - 2 * len(widths) - sum(widths[:-1])
    if widths[-1] > room >= _NARROWEST:
        return [line for cells in lines for line in _with_wrapped_end(cells, widths, room)]
    while sum(widths) + 2 * len(widths) > width and len(widths) > least:
        widths.pop()
    return [_aligned(line, widths)[:width] for line in lines]


def _with_wrapped_end(cells: Sequence[str], widths: Sequence[int], room: int) -> list[str]:
    """Align a row of cells, the last of which takes as many lines as it needs."""
    first, *others = textwrap.wrap(cells[-1], room) or [""]
    rows = [[*cells[:-1], first], *([*("" for _ in cells[:-1]), text] for text in others)]
    return [_aligned(row, widths) for row in rows]


def _aligned(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = [cell.ljust(width) for cell, width in zip(cells, widths, strict=False) if width]
    return f"  {'  '.join(padded)}".rstrip()


# --- The joint ------------------------------------------------------------------------------------

_ELBOW = r"\b(?:(?P<article>an?) )?(?P<elbow>elbow)\b"
_MOST_OWN_WORDS = 1000
"""Most texts of a study about an elbow that are looked for."""


class JointName(str):
    """Name of a study's joint, with the texts of the study itself that speak of an elbow.

    These are the user's, such as the name of a part, and stay as they are in every text.
    """

    __slots__ = ("own_words",)
    own_words: tuple[str, ...]

    @classmethod
    def of(cls, name: str, texts: Iterable[str]) -> JointName:
        """Return the name of a joint, with those of some texts that speak of an elbow."""
        joint = cls(name)
        about = (text for text in texts if "elbow" in text.casefold())
        joint.own_words = tuple(dict.fromkeys(about))[:_MOST_OWN_WORDS]
        return joint


def joint_name(study: Any) -> JointName:
    """Return the name of a study's joint, "elbow" by default.

    `study` is a `Study`, its document, or a record that holds one.
    """
    study = getattr(study, "study", study)
    while isinstance(study, Mapping) and "study" in study:
        study = study["study"]
    if not isinstance(study, Mapping):
        return JointName.of(study.joint.name, _own_words(study))
    return JointName.of(study.get("joint", {}).get("name", "elbow"), _texts_in(study))


def _own_words(study: Any) -> Iterator[str]:
    """Yield texts that are the user's: title, names of files and rows, and what these carry."""
    yield study.title or ""
    yield from (str(source.get("file", "")) for source in study.sources.values())
    for table in study.row_tables:
        yield from table.names
        for column in table.carried:
            yield from column.words


def _texts_in(content: Any) -> Iterator[str]:
    """Yield all texts in the document of a study but its keys."""
    if isinstance(content, str):
        yield content
    elif isinstance(content, Mapping):
        for item in content.values():
            yield from _texts_in(item)
    elif isinstance(content, (list, tuple)):
        for item in content:
            yield from _texts_in(item)


def name_joint(text: str, study: Any) -> str:
    """Put the name of the study's joint into a text about the elbow: "the ankle", "a wrist".

    Keys and columns such as `elbow_angle` stay, and so do words of the study's own. `study` is what
    `joint_name` takes, or the word itself.
    """
    word = study if isinstance(study, str) else joint_name(study)
    if word == "elbow":
        return text
    own_words = word.own_words if isinstance(word, JointName) else ()
    ending = "n" if word[0].lower() in "aeiou" else ""  # "a" or "an"

    def named(match: re.Match[str]) -> str:
        """Return the joint with its article, capitalised as the elbow was."""
        article = match["article"]
        elbow = match["elbow"]
        if elbow is None:
            return match[0]
        joint = word[0].upper() + word[1:] if elbow[0].isupper() else word
        return joint if article is None else f"{article[0]}{ending} {joint}"

    return _elbow_or(own_words).sub(named, text)


@lru_cache(maxsize=32)
def _elbow_or(own_words: tuple[str, ...]) -> re.Pattern[str]:
    """Return a pattern of an elbow, or of a user's words as they stand in a text, HTML or JSON."""
    spelled = []
    for words in own_words:
        spelled += [words, escape(words), json.dumps(words)[1:-1]]
    by_length = sorted(set(spelled), key=len, reverse=True)
    # Lines of a text may be broken anywhere.
    kept = [r"\s+".join(map(re.escape, words.split())) for words in by_length]
    return re.compile("|".join([*kept, _ELBOW]), re.IGNORECASE)
