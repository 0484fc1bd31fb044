"""Units: a strict grammar of one number and one unit, converted to SI exactly.

"9 mm" is 0.009 and not 0.009000000000000001, because the text is read as a rational number and
rounded to a float64 only once, at the end. Anything else that looks like a quantity ("1,5 mm",
"3 kn/m", "2 * 4 m") is refused: a unit that is guessed is a number that nobody can trust.
"""

from __future__ import annotations

import difflib
import math
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date, time
from decimal import Decimal, Inexact, localcontext
from fractions import Fraction

# 50 digits of pi, so that degrees are rounded once, from a value far more precise than a float64.
_PI = Fraction("3.14159265358979323846264338327950288419716939937511")

_OUNCE_INCH = Fraction("0.45359237") / 16 * Fraction("9.80665") * Fraction("0.0254")
"""Weight of an ounce at an inch, N m."""

# Mantissas and exponents are bounded, so that reading "1e999999999 m" costs no memory.
_NUMBER = r"[+-]?(?:\d{1,80}(?:\.\d{0,80})?|\.\d{1,80})(?:[eE][+-]?\d{1,3})?"
_PLAIN_DIGITS = 16  # numbers of more decimal places are written with an exponent
_MAX_TEXT = 200  # signs of a text that is read as a quantity
_TYPESET = str.maketrans({"\u2212": "-", "\u00a0": " ", "\u202f": " "})
"""Minus and spaces as pages and word processors set them."""
_QUANTITY = re.compile(rf"((?>{_NUMBER}))(?:[ \t]*([^\s\d].*))?")


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of `dimension`, worth `factor` of its SI unit."""

    symbol: str
    dimension: str
    factor: Fraction


def _units(dimension: str, factors: dict[str, str | int | Fraction]) -> dict[str, Unit]:
    return {symbol: Unit(symbol, dimension, Fraction(factor)) for symbol, factor in factors.items()}


UNITS: dict[str, Unit] = (
    _units("number", {"1": 1, "%": "0.01"})
    | _units(
        "length",
        {"m": 1, "cm": "0.01", "mm": "0.001", "um": "0.000001", "km": 1000, "in": "0.0254"},
    )
    | _units(
        "force", {"N": 1, "mN": "0.001", "kN": 1000, "kgf": "9.80665", "lbf": "4.4482216152605"}
    )
    | _units("force", {"cN": "0.01", "daN": 10, "gf": "0.00980665"})
    | _units("stiffness", {"N/m": 1, "kN/m": 1000, "N/mm": 1000, "N/cm": 100})
    | _units("pressure", {"Pa": 1, "kPa": 10**3, "MPa": 10**6, "GPa": 10**9})
    | _units("mass", {"kg": 1, "g": "0.001", "t": 1000, "lb": "0.45359237"})
    | _units("angle", {"deg": _PI / 180, "°": _PI / 180, "rad": 1, "mrad": "0.001", "rev": 2 * _PI})
    | _units(
        "torque",
        {"N m": 1, "Nm": 1, "N·m": 1, "N*m": 1, "N mm": "0.001", "N·mm": "0.001", "kN m": 1000},
    )
    | _units("torque", {"mN m": "0.001", "mNm": "0.001", "N cm": "0.01"})
    | _units("torque", {"kg cm": "0.0980665", "oz in": _OUNCE_INCH})
    | _units("rotational stiffness", {"N m/rad": 1, "N·m/rad": 1, "N m/deg": 180 / _PI})
    | _units("torque constant", {"N m/A": 1, "Nm/A": 1, "N·m/A": 1, "mN m/A": "0.001"})
    | _units(
        "time",
        {"s": 1, "ms": "0.001", "us": "0.000001", "ns": "0.000000001", "min": 60, "h": 3600},
    )
    | _units(
        "angular speed",
        {"rad/s": 1, "deg/s": _PI / 180, "°/s": _PI / 180, "rpm": _PI / 30, "rev/s": 2 * _PI},
    )
    | _units(
        "inertia",
        {"kg m2": 1, "kg m^2": 1, "kg m²": 1, "kg·m²": 1, "kg cm2": "0.0001", "g cm2": "0.0000001"},
    )
    | _units("frequency", {"Hz": 1})
    | _units("power", {"W": 1, "mW": "0.001", "kW": 1000})
    | _units("energy", {"J": 1, "mJ": "0.001", "kJ": 1000})
)

SENSOR_UNITS: dict[str, Unit] = (
    _units("voltage", {"V": 1, "mV": "0.001", "mV/V": 1})
    | _units("current", {"A": 1, "mA": "0.001"})
    | _units("counts", {"counts": 1})
)
"""Units in which sensors are logged, and no study states a number."""

STANDARD_GRAVITY = Fraction("9.80665")
"""Standard acceleration of gravity, m/s²."""

SI_UNIT = {unit.dimension: unit.symbol for unit in reversed(UNITS.values()) if unit.factor == 1}
"""Unit of each dimension in which numbers are computed and stored."""

# Pi does not terminate, so that degrees stay degrees if a text has to be exact.
_UNIT_WITH_PI = {"angle": "deg", "rotational stiffness": "N m/deg", "angular speed": "deg/s"}

EXAMPLES = {
    "number": "0.07",
    "length": '"40 mm"',
    "force": '"100 N"',
    "stiffness": '"3 kN/m"',
    "pressure": '"145 GPa"',
    "mass": '"5 kg"',
    "angle": '"90 deg"',
    "torque": '"2 N m"',
    "rotational stiffness": '"2 N m/rad"',
    "torque constant": '"0.12 N m/A"',
    "time": '"1 s"',
    "angular speed": '"60 deg/s"',
    "inertia": '"0.08 kg m2"',
    "frequency": '"6 Hz"',
    "power": '"20 W"',
    "energy": '"5 J"',
}
"""Example of a value of each dimension, as a study file states it."""

_UNITS_OF_ANGLES = {"angle": ("deg", "rad"), "angular speed": ("deg/s", "rad/s")}
"""Units of which a number says by itself in which it may be."""


class UnitError(ValueError):
    """Text is not one number and one unit of the expected dimension; `hint` says what would be."""

    def __init__(self, problem: str, hint: str | None = None) -> None:
        super().__init__(problem)
        self.problem = problem
        self.hint = hint


@dataclass(frozen=True, slots=True)
class Measure:
    """One number as written, and its unit. It is a rational number until `si` rounds it."""

    text: str
    unit: Unit

    @property
    def exact(self) -> Fraction:
        """The SI value as a rational number."""
        return Fraction(self.text) * self.unit.factor

    @property
    def si(self) -> float:
        """The SI value, rounded once."""
        return to_float(self.exact)

    @property
    def quoted(self) -> str:
        """Measure as a study file has it, with its unit."""
        return self.text if self.unit.symbol == "1" else f'"{self.text} {self.unit.symbol}"'

    def document(self) -> float | str:
        """Return the shortest exact form of this measure in a study file.

        It is the same for "1000 g" and "1.0 kg". A number without unit is a float.
        """
        dimension = self.unit.dimension
        value = self.si
        if dimension == "number" and math.isfinite(value) and Fraction(repr(value)) == self.exact:
            return value
        symbols = [SI_UNIT[dimension]]
        if dimension in _UNIT_WITH_PI:
            symbols.append(_UNIT_WITH_PI[dimension])
        texts = []
        for symbol in symbols:
            digits = terminating(self.exact / UNITS[symbol].factor)
            if digits is not None:
                texts.append(f"{digits} {symbol}".removesuffix(" 1"))
        if not texts:
            return f"{self.text} {self.unit.symbol}"
        return min(texts, key=len)


def factor_of(symbol: str) -> float:
    """Return one unit in SI, by which SI values are divided to be shown; 1 if it is not known."""
    return float(UNITS[symbol].factor) if symbol in UNITS else 1.0


def force_factor(symbol: str | None) -> float | None:
    """Return newtons per unit of force, or per unit of mass by its weight; None for others."""
    unit = UNITS.get(symbol or "")
    if unit is None or unit.dimension not in {"force", "mass"}:
        return None
    return float(unit.factor * (STANDARD_GRAVITY if unit.dimension == "mass" else 1))


def terminating(value: Fraction) -> str | None:
    """Return the decimal digits of a rational number, or None if they do not end."""
    with localcontext(prec=200) as context:
        context.clear_flags()
        number = (Decimal(value.numerator) / Decimal(value.denominator)).normalize()
        if context.flags[Inexact]:
            return None
    digits = format(number, "f") if abs(number.adjusted()) < _PLAIN_DIGITS else str(number)
    return digits if re.fullmatch(_NUMBER, digits) else None


def to_float(value: Fraction) -> float:
    """Return the float64 nearest to a rational number, or infinity if it is too large for one."""
    try:
        return value.numerator / value.denominator
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def known_units(dimension: str) -> list[str]:
    """Return the symbols that may follow a number of this dimension, common ones first."""
    return [unit.symbol for unit in UNITS.values() if unit.dimension == dimension]


def parse_measure(text: str, dimension: str) -> Measure:
    """Read one number and one unit of a dimension.

    Args:
        text: Text such as "9 mm".
        dimension: Dimension of the quantity, such as "length".

    Raises:
        UnitError: The text is anything else; the error says what was expected.
    """
    expected = wanted(dimension)
    plain = text.translate(_TYPESET).strip()
    match = _QUANTITY.fullmatch(plain) if len(text) <= _MAX_TEXT else None
    symbol = (match.group(2) or "").strip() if match is not None else ""
    if match is None or symbol.startswith(","):
        problem = f'"{shorten(text)}" is not one number and one unit, expected {expected}'
        raise UnitError(problem, _advice(text[:_MAX_TEXT]))
    number = match.group(1)
    if not symbol:
        if dimension == "number":
            return Measure(number, UNITS["1"])
        problem = f'"{number}" has no unit, expected {expected}'
        raise UnitError(problem, f"write {with_unit(number, dimension)}")
    return Measure(number, find_unit(symbol, dimension))


def usual_units(dimension: str) -> tuple[str, ...]:
    """Return the units in which people write a dimension: two for angles, else that of EXAMPLES."""
    if dimension in _UNITS_OF_ANGLES:
        return _UNITS_OF_ANGLES[dimension]
    _number, _, symbol = EXAMPLES[dimension].strip('"').partition(" ")
    return (symbol,)


def with_unit(number: str, dimension: str) -> str:
    """Return a bare number with its usual unit, for a hint: an angle in degrees or in radians."""
    return " or ".join(f'"{number} {symbol}"' for symbol in usual_units(dimension))


def _advice(text: str) -> str | None:
    """Return a hint for a text that is not a number and a unit, None if no fault is recognised."""
    if not text.isprintable():
        return "a sign that cannot be printed is shown as ?"
    if re.search(r"\d,\d", text):
        return "the decimal sign is a point"
    if re.search(r"\d +\d", text):
        return "write digits without spaces between them"
    return None


def measure_of_number(value: float, dimension: str) -> Measure:
    """Return a bare number as a measure in SI, exact as its shortest text: 0.1 is one tenth."""
    return Measure(repr(value), UNITS[SI_UNIT[dimension]])


def written_unit(text: str, dimension: str | None = None) -> Unit | None:
    """Return the unit that a header writes, such as "(Nm)", "kilograms" or "µs"; None if none.

    Signs between the parts of a unit do not matter, nor does case, unless it may be that of a
    prefix: "MN" is no way to write mN.

    Args:
        text: Text of a header, or a part of it.
        dimension: Dimension that its quantity has, if known.
    """
    bare = unicodedata.normalize("NFKC", text).strip().strip("()[]{} ")
    exact = UNITS.get(bare) or SENSOR_UNITS.get(bare)
    if exact is not None and dimension in (None, exact.dimension):
        return exact
    for unit in _written_alike(_plain(bare)):
        if dimension in (None, unit.dimension):
            return unit
    return None


def _plain(symbol: str) -> str:
    """Return a unit without signs between its parts."""
    return re.sub(r"[\s_·*.-]", "", unicodedata.normalize("NFKC", symbol))


def _written_alike(plain: str) -> Iterator[Unit]:
    """Yield the units that a text without signs may mean: exactly, or in another case.

    The case of a first m is that of a prefix, and counts but in capitals throughout: "MS" is ms.
    """
    yield from _WRITTEN.get(plain, ())
    for unit in _WRITTEN.get(plain.lower(), ()):
        has_prefix = plain[:1] == "M" and unit.symbol[:1] == "m"
        is_usual = unit.dimension in ("length", "time") and plain.isupper()
        if not has_prefix or is_usual:
            yield unit


def _written_units() -> dict[str, list[Unit]]:
    """Return the units by their forms in headers without signs, and by words for them."""
    written: dict[str, list[Unit]] = {}
    every = {**UNITS, **SENSOR_UNITS}
    for unit in every.values():
        plain = _plain(unit.symbol)
        forms = {plain, *_WORDS.get(unit.symbol, "").split()}
        if plain not in ("MPa", "mN", "mV", "mW", "mJ"):  # mPa, MN and others are units, too
            forms.add(plain.lower())
        for form in forms:
            written.setdefault(form, []).append(unit)
    return written


_WORDS = {
    "N": "newton newtons",
    "N m": "newtonmeter newtonmetre newtonmeters",
    "mN m": "mnm",
    "deg": "degree degrees grad",
    "rad": "radian radians",
    "rev": "turns revolutions umdrehungen",
    "s": "sec second seconds sekunden",
    "ms": "millis millisecond milliseconds",
    "um": "μm",
    "us": "μs micros microsecond microseconds",
    "ns": "nanos nanosecond nanoseconds",
    "kg": "kilogram kilograms",
    "g": "gram grams gramm",
    "lb": "lbs",
    "V": "volt volts",
    "A": "ampere amps",
    "counts": "count ticks cts inkremente",
}
"""Words for units in headers, English and German."""
_WRITTEN = _written_units()


def find_unit(symbol: str, dimension: str) -> Unit:
    """Return the unit with this symbol.

    Raises:
        UnitError: There is no such unit, or it is one of another dimension.
    """
    unit = UNITS.get(symbol) or SENSOR_UNITS.get(symbol)
    if unit is None:
        hint = _hint_of_unknown_unit(symbol, dimension)
        raise UnitError(f'unknown unit "{shorten(symbol)}", expected {wanted(dimension)}', hint)
    if unit.dimension != dimension:
        hint = f"units of {dimension}: {', '.join(known_units(dimension))}"
        if dimension == "number":
            hint = "a number without unit, or %"
        problem = f'"{symbol}" is {_with_article(unit.dimension)}, expected {wanted(dimension)}'
        raise UnitError(problem, hint)
    return unit


def _hint_of_unknown_unit(symbol: str, dimension: str) -> str:
    """Return the nearest unit, or a list of units, for a symbol that is not one.

    A unit that differs by a prefix is not meant: it would be another power of ten.
    """
    known = known_units(dimension)
    same = written_unit(symbol, dimension)
    if same is not None:
        return f'did you mean "{same.symbol}"?'
    if any(sign.isdigit() for sign in symbol):
        return "only one number fits here; several form a list, a range is { from, to, num }"
    near = difflib.get_close_matches(symbol, known, n=len(known))
    similar = [other for other in near if not _stems(symbol) & _stems(other)]
    if similar and not _stems(symbol) & set(map(_plain, known)):
        return f'did you mean "{similar[0]}"?'
    return f"known units: {', '.join(known)}"


def _stems(symbol: str) -> set[str]:
    """Return a symbol without signs, as it is and without what may be a prefix."""
    plain = _plain(symbol)
    return {plain, re.sub(r"^(da|[kMGTmuμnchd])(?=.)", "", plain)}


def wanted(dimension: str) -> str:
    """Return words for the value that was expected: a length such as "40 mm"."""
    return f"{_with_article(dimension)} such as {EXAMPLES[dimension]}"


def _with_article(word: str) -> str:
    return f"an {word}" if word[0] in "aeiou" else f"a {word}"


def described(value: object) -> str:
    """Return a value as the author of a study would name it, short and fit to print."""
    if isinstance(value, str):
        return f'"{shorten(value)}"'
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return f"the truth value {str(value).lower()}"
    if isinstance(value, (list, tuple)):
        return "a list"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, (date, time)):
        return f"the date or time {value.isoformat()}"
    if isinstance(value, int) and value.bit_length() > 200:
        return f"an integer of {round(value.bit_length() * math.log10(2)):,} digits"
    return shorten(str(value))


def counted(count: int, noun: str) -> str:
    """Return a count with its noun, in the plural unless it is 1."""
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"


def shorten(text: str, width: int = 60) -> str:
    """Return text for one line of an error message: printable, at most `width` characters."""
    clean = "".join(sign if sign.isprintable() else "?" for sign in text)
    return clean if len(clean) <= width else f"{clean[: width - 1]}…"
