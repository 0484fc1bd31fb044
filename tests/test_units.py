"""One number and one unit, converted exactly; everything else is refused."""

import math
from decimal import Decimal, localcontext
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendon_cli.units import (
    EXAMPLES,
    SI_UNIT,
    UNITS,
    UnitError,
    known_units,
    measure_of_number,
    parse_measure,
    shorten,
    to_float,
    written_unit,
)

from .study.malformed.row import at_most

# The definition of each unit, independent of the code: what one of it is in SI. Angles are compared apart.
DEFINED = {
    "1": "1", "%": "1/100",
    "m": "1", "cm": "1/100", "mm": "1/1000", "um": "1/1000000", "km": "1000", "in": "254/10000",
    "N": "1", "mN": "1/1000", "kN": "1000", "kgf": "980665/100000",
    "cN": "1/100", "daN": "10", "gf": "980665/100000000",
    "N/m": "1", "kN/m": "1000", "N/mm": "1000", "N/cm": "100",
    "Pa": "1", "kPa": "1000", "MPa": "1000000", "GPa": "1000000000",
    "kg": "1", "g": "1/1000", "t": "1000", "lb": "45359237/100000000",
    "N m": "1", "Nm": "1", "N·m": "1", "N*m": "1", "N mm": "1/1000", "N·mm": "1/1000", "kN m": "1000",
    "mN m": "1/1000", "mNm": "1/1000", "N cm": "1/100", "kg cm": "980665/10000000",
    "N m/rad": "1", "N·m/rad": "1", "N m/A": "1", "Nm/A": "1", "N·m/A": "1", "mN m/A": "1/1000",
    "s": "1", "ms": "1/1000", "us": "1/1000000", "ns": "1/1000000000", "min": "60", "h": "3600",
    "rad": "1", "mrad": "1/1000",
    "kg m2": "1", "kg m^2": "1", "kg m²": "1", "kg·m²": "1", "kg cm2": "1/10000", "g cm2": "1/10000000",
    "Hz": "1", "rad/s": "1", "W": "1", "mW": "1/1000", "kW": "1000", "J": "1", "mJ": "1/1000", "kJ": "1000",
}  # fmt: skip
TURNS = {"deg": Fraction(1, 360), "°": Fraction(1, 360), "rev": Fraction(1),
         "deg/s": Fraction(1, 360), "°/s": Fraction(1, 360), "rpm": Fraction(1, 60), "rev/s": Fraction(1)}  # fmt: skip


def test_every_unit_is_defined_here():
    assert set(UNITS) - set(DEFINED) - set(TURNS) == {"lbf", "N m/deg", "oz in"}
    assert UNITS["oz in"].factor == UNITS["lbf"].factor / 16 * UNITS["in"].factor
    assert UNITS["lbf"].factor == UNITS["lb"].factor * UNITS["kgf"].factor
    assert UNITS["N m/deg"].factor * UNITS["rev"].factor / 360 == 1


def test_a_unit_is_worth_its_definition_exactly():
    for symbol, factor in DEFINED.items():
        unit = UNITS[symbol]
        text = "1.25" if symbol == "1" else f"1.25 {symbol}"
        assert parse_measure(text, unit.dimension).exact == Fraction("1.25") * Fraction(factor)


@pytest.mark.parametrize(("symbol", "turns"), TURNS.items())
def test_angles_are_shares_of_a_turn_to_fifty_digits(symbol, turns):
    assert abs(
        UNITS[symbol].factor / (2 * turns)
        - Fraction("3.14159265358979323846264338327950288419716939937511")
    ) < (Fraction(1, 10**48))


def test_degrees_are_rounded_once():
    for degrees in (0, 30, 45, 60, 90, 120, 144, 180, 270, 360, -90):
        value = parse_measure(f"{degrees} deg", "angle").si
        assert value == to_float(degrees * UNITS["rev"].factor / 360)
        assert value == pytest.approx(math.radians(degrees), rel=2.3e-16)


def test_each_dimension_has_its_si_unit_and_an_example():
    for dimension in SI_UNIT:
        assert UNITS[SI_UNIT[dimension]].factor == 1
        assert SI_UNIT[dimension] in known_units(dimension)
        parse_measure(EXAMPLES[dimension].strip('"'), dimension)
        if dimension != "number":
            with pytest.raises(UnitError, match="has no unit"):
                parse_measure("160", dimension)


def test_a_unit_serves_its_own_dimension_only():
    for unit in UNITS.values():
        for dimension in SI_UNIT:
            if dimension != unit.dimension:
                with pytest.raises(UnitError):
                    parse_measure(f"1 {unit.symbol}", dimension)


def test_a_slip_of_case_is_refused_and_the_unit_named():
    for unit in [
        unit for unit in UNITS.values() if unit.symbol.swapcase() not in {*UNITS, unit.symbol}
    ]:
        slip = unit.symbol.swapcase()
        with pytest.raises(UnitError) as caught:
            parse_measure(f"1 {slip}", unit.dimension)
        assert slip in caught.value.problem
        assert any(known in caught.value.hint for known in known_units(unit.dimension))


def test_no_hint_crosses_a_power_of_ten():
    """A unit that differs by a prefix is another unit: all are listed instead."""
    for symbol, dimension in (
        ("MN", "force"), ("\u00b5N", "force"), ("Mm", "length"), ("mN/m", "stiffness"), ("hPa", "pressure"),
        ("cN m", "torque"), ("dN", "force"),
    ):  # fmt: skip
        with pytest.raises(UnitError, match="unknown unit") as caught:
            parse_measure(f"1 {symbol}", dimension)
        assert caught.value.hint == f"known units: {', '.join(known_units(dimension))}"


WRITTEN = {
    "mNm": "mNm", "(Nm)": "Nm", "N-m": "N m", "nm": "N m", "[kilograms]": "kg", "LBS": "lb", "\u00b5s": "us",
    "Grad": "deg", "TIME_MS": None, "MS": "ms", "ticks": "counts", "mV/V": "mV/V", "MN": None, "MNm": None,
    "oz-in": "oz in", "kg\u00b7cm": "kg cm", "counts": "counts", "mpa": None, "a": "A", "": None, "newton meter": "N m",
}  # fmt: skip
"""Symbols by what a header writes."""


def test_units_as_headers_write_them():
    found = {text: written_unit(text) for text in WRITTEN}
    assert {text: unit and unit.symbol for text, unit in found.items()} == WRITTEN
    assert written_unit("nm", "length") is None


@pytest.mark.parametrize(
    ("text", "exact"),
    [("9 mm", "0.009"), ("9mm", "0.009"), ("  9   mm  ", "0.009"), ("9\tmm", "0.009"), ("9. mm", "0.009"),
     (".9 mm", "0.0009"), ("+9 mm", "0.009"), ("-9 mm", "-0.009"), ("0.9e1 mm", "0.009"), ("9E-3 m", "0.009"),
     ("9\u00a0mm", "0.009"), ("9\u202fmm", "0.009"), ("\u22129 mm", "-0.009"), ("9e+0 mm", "0.009"), ("009 mm", "0.009"), ("1e2m", "100"), ("0 m", "0")],
)  # fmt: skip
def test_the_ways_to_write_a_number(text, exact):
    assert parse_measure(text, "length").exact == Fraction(exact)


@pytest.mark.parametrize(
    "text",
    [
        "", " ", "m", "9", "mm 9", "9 mm 9 mm", "9 9 mm", "1 000 mm", "1,5 mm", "1.000,5 mm", "1.5.2 mm", "1e mm",
        "e3 m", "1e5.5 m", "1e9999 m", "--9 mm", "+-9 mm", "9 -mm", "9 mm²", "9 m m", "9 MM", "9 Mm", "9 M", "9 metre",
        "2 * 4 m", "2*4 m", "2^4 m", "9**9**9 m", "1/2 m", "(9) mm", "9 mm;", "9 mm # x", "9 mm\n8 mm",
        "nan m", "inf m", "infinity m", "NaN m", "0x10 m", "1_000 m", "½ m", "9 \u00b5m", "9\u2009mm",
        "9 kg", "9 N", "9 %", "9 N/m", "9 $", "9 {}", "9 %s", "True m", "None", "9 mm mm", "9 m/m",
        "9 1", "__import__('os') m",
        "1" * 81 + " m", "0." + "1" * 81 + " m", "9" + " " * 300 + "m", "9 " + "m" * 300, "9\x00 m", "9 m\x1b[31m",
    ],
)  # fmt: skip
def test_everything_else_is_refused(text):
    with pytest.raises(UnitError) as caught:
        parse_measure(text, "length")
    for said in (caught.value.problem, caught.value.hint or ""):
        assert said.isprintable()
        assert len(said) < 300


@pytest.mark.parametrize(
    ("text", "si"), [("0.07", 0.07), ("7 %", 0.07), ("7%", 0.07), ("1", 1.0), ("-2e-3", -0.002)]
)
def test_a_plain_number_needs_no_unit(text, si):
    assert parse_measure(text, "number").si == si


# --- Rounding and round trips ---------------------------------------------------------------------

SAFE = st.floats(allow_nan=False, allow_infinity=False)
SYMBOLS = st.sampled_from([unit for unit in UNITS.values() if unit.symbol != "1"])


def again(measure):
    """Read a measure back from its form in a study file."""
    written = measure.document()
    dimension = measure.unit.dimension
    if isinstance(written, str):
        return parse_measure(written, dimension)
    return measure_of_number(written, dimension)


@given(SAFE)
def test_a_bare_number_is_itself(value):
    assert measure_of_number(value, "length").si == value


@given(SAFE, SYMBOLS)
def test_what_a_measure_says_reads_back_as_the_same(value, unit):
    measure = parse_measure(f"{value!r} {unit.symbol}", unit.dimension)
    assert again(measure).exact == measure.exact
    assert again(measure).document() == measure.document()


@pytest.mark.parametrize(
    "text",
    ["1" * 80 + "." + "1" * 80 + "e-75 lbf", "1e-999 mN", "1e999 kN", "0." + "0" * 79 + "1 lbf", "-0 N", "1e-99 N",
     "10.000000000000000000001 %"],
)  # fmt: skip
def test_the_longest_numbers_read_back_as_the_same(text):
    measure = parse_measure(text, "number" if "%" in text else "force")
    assert again(measure).exact == measure.exact
    assert "%" not in text or measure.exact == Fraction("0.10000000000000000000001")


@pytest.mark.parametrize(
    ("dimension", "texts", "said"),
    [
        ("mass", ("1000 g", "1.0 kg", "1kg", "0.001 t", "1e0 kg"), "1 kg"),
        ("stiffness", ("3 kN/m", "3 N/mm", "30 N/cm", "3000.0 N/m"), "3000 N/m"),
        ("pressure", ("145 GPa", "145000 MPa"), "145000000000 Pa"),
        ("length", ("1e-30 km", "1e-27 m"), "1E-27 m"),
        ("angle", ("90 deg", "90.0°", "0.25 rev"), "90 deg"),
        ("angle", ("1 rad", "1000 mrad"), "1 rad"),
        ("angle", ("0 deg", "0 rad", "-0 rev"), "0 rad"),
        ("rotational stiffness", ("2 N m/deg", "2.0 N m/deg"), "2 N m/deg"),
        ("rotational stiffness", ("2 N m/rad", "2 N·m/rad"), "2 N m/rad"),
        ("number", ("7 %", "0.07", "0.070"), 0.07),
    ],
)
def test_a_number_is_said_in_one_way_only(dimension, texts, said):
    assert {parse_measure(text, dimension).document() for text in texts} == {said}


@given(
    st.decimals(
        allow_nan=False, allow_infinity=False, min_value=-(10**9), max_value=10**9, places=12
    )
)
def test_a_decimal_in_si_is_rounded_as_python_rounds_it(value):
    assert parse_measure(f"{value:f} m", "length").si == float(value)


@given(st.integers(-(10**15), 10**15), st.integers(0, 20))
def test_a_scaled_decimal_is_rounded_once(digits, places):
    with localcontext(prec=60):
        value = Decimal(digits).scaleb(-places)
        assert parse_measure(f"{value:f} mm", "length").si == float(value / 1000)
        assert parse_measure(f"{value:f} in", "length").si == float(value * Decimal("0.0254"))


@given(st.fractions(min_value=-(10**12), max_value=10**12))
def test_to_float_is_the_nearest_float(value):
    found = to_float(value)
    error = abs(Fraction(found) - value)
    assert error <= abs(Fraction(math.nextafter(found, math.inf)) - value)
    assert error <= abs(Fraction(math.nextafter(found, -math.inf)) - value)


@pytest.mark.parametrize(("power", "expected"), [(308, 1e308), (-400, 0.0), (400, math.inf)])
def test_numbers_beyond_a_float_are_infinite_or_zero(power, expected):
    assert to_float(Fraction(10) ** power) == expected
    assert to_float(-(Fraction(10) ** power)) == -expected


# --- Hostile text ---------------------------------------------------------------------------------


@given(st.text(max_size=60))
def test_any_text_is_a_measure_or_refused(text):
    for dimension in ("length", "number"):
        try:
            said = parse_measure(text, dimension).unit.symbol
        except UnitError as error:
            said = error.problem
        assert said.isprintable()


@pytest.mark.parametrize(
    "text",
    ["9" * 10**6, "9" * 10**6 + " m", " " * 10**6, "." * 10**6,
     "9" + " " * 10**6 + "m", "9 " + "m" * 10**6, "1e" + "9" * 10**6 + " m",
     "9" * 199 + "x", ("9 " * 99) + "m", "9" + "\t" * 198, "9.9" * 66, "1e999 " + "N" * 190],
    ids=range(12),
)  # fmt: skip
def test_hostile_text_is_refused_at_once(text):
    with at_most(30), pytest.raises(UnitError):
        parse_measure(text, "length")


@given(st.text(max_size=200), st.integers(2, 80))
def test_shortened_text_is_printable_and_short(text, width):
    assert shorten(text, width).isprintable()
    assert len(shorten(text, width)) <= width
