"""Files as they come: those that are read right, without editing."""

from __future__ import annotations

import codecs

import pytest

from tendon_cli.errors import UsageError
from tendon_cli.friction import fit_friction
from tendon_cli.friction.budget import BEND

from .tables import BARE_ROWS, CELLS_ONLY, GERMAN, GRAMS, NAMED, TABLE

READ_RIGHT: dict[str, str | bytes] = {
    "as the data set has it": TABLE,
    "semicolons and decimal commas": GERMAN,
    "tabs": TABLE.replace(",", "\t"),
    "tabs and decimal commas": TABLE.replace(",", "\t").replace(".", ","),
    "semicolons and decimal points": TABLE.replace(",", ";"),
    "UTF-8 with a mark": codecs.BOM_UTF8 + TABLE.encode(),
    "UTF-16 with a mark": TABLE.encode("utf-16"),
    "UTF-16 big-endian with a mark": codecs.BOM_UTF16_BE + GERMAN.encode("utf-16-be"),
    "Windows line ends": TABLE.replace("\n", "\r\n"),
    "old Macintosh line ends": TABLE.replace("\n", "\r"),
    "no last line end": TABLE.rstrip("\n"),
    "blank lines": TABLE.replace("\n", "\n\n"),
    "lines of separators only": TABLE + ",,\n,,\n",
    "comments above": "# rig 3, brake wire; 2024\n% second\n" + TABLE,
    "quoted comments above": '"# rig 3, brake wire"\n' + TABLE,
    "a title without a comment sign": "Rig 3 of the laboratory, brake wire\nmeasured, by hand\n" + TABLE,
    "a trailing separator": TABLE.replace("\n", ",\n"),
    "quotes around everything": "\n".join(
        ",".join(f'"{cell}"' for cell in line.split(",")) for line in TABLE.splitlines()
    ),
    "spaces around cells": TABLE.replace(",", " , "),
    "units in brackets": TABLE.replace("_kg", " [kg]"),
    "units after a slash": TABLE.replace("_kg", " / N"),
    "units spoken": TABLE.replace("_kg", " in kilograms"),
    "cells in grams and kilograms": GRAMS,
    "no units": TABLE.replace("_kg", ""),
    "Roman numerals": TABLE.replace("load_cell_1", "Load cell I").replace("load_cell_2", "Load cell II"),
    "typographic Roman numerals": TABLE.replace("cell_1", "cell Ⅰ").replace("cell_2", "cell Ⅱ"),
    "short names": TABLE.replace("load_cell_1_kg", "F1").replace("load_cell_2_kg", "F2"),
    "ends of the sheath": TABLE.replace("load_cell_1_kg", "force_motor_N").replace("load_cell_2_kg", "force_load_N"),
    "proximal and distal": TABLE.replace("load_cell_1_kg", "proximal").replace("load_cell_2_kg", "distal"),
    "columns in another order": "load cell 2,note,load cell 1,case\n"
    + "".join(f"{b},ok,{a},{c}\n" for c, a, b in (line.split(",") for line in BARE_ROWS.splitlines())),
    "extra columns of text and numbers": "".join(
        f"{line},{'temperature,note,motor position (mm)' if number == 0 else '21.5,dry,12'}\n"
        for number, line in enumerate(TABLE.splitlines())
    ),
    "directions named": NAMED,
    "directions as signs": NAMED.replace("up", "+1").replace("down", "-1"),
    "directions from the forces": CELLS_ONLY,
    "a column of time": "".join(
        f"{'time_s' if number == 0 else number * 0.5},{line}\n" for number, line in enumerate(TABLE.splitlines())
    ),
    "times of day": "".join(
        f"{'timestamp' if number == 0 else f'2024-05-01 12:00:0{number}'},{line}\n"
        for number, line in enumerate(TABLE.splitlines())
    ),
    "Latin-1": TABLE.replace("case", "case,Prüfer")
    .replace("\n1,", "\n1,Müller,")
    .replace("\n2,", "\n2,Müller,")
    .encode("latin-1"),
    "German headers": GERMAN.replace("case", "Richtung")
    .replace("load_cell_1_kg", "Kraft Motor (N)")
    .replace("load_cell_2_kg", "Kraft Last (N)")
    .replace("\n1;", "\nauf;")
    .replace("\n2;", "\nab;"),
    "a column of comments, often empty": TABLE.replace("2_kg", "2_kg,Comment").replace(
        "0.857,1.036", "0.857,1.036,dry"
    ),
    "exponents": TABLE.replace("1.236", "1.236e0").replace("0.858", "8.58E-1"),
    "plus signs and bare points": TABLE.replace("1.236", "+1.236").replace("0.858", ".858"),
    "a header that looks like a formula": TABLE.replace("case,", "=cmd()|x,case,")
    .replace("\n1,", "\n0,1,")
    .replace("\n2,", "\n0,2,"),
}


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("2,NaN,1.036", "no reading"),
        ("2,,1.036", "no reading"),
        ("2,0,1.036", "force at or below zero"),
        ("2,-0.858,1.036", "force at or below zero"),
        ("2,0.004,0.002", "no load"),
    ],
)
@pytest.mark.parametrize("line", [2, 4, 6, 7])
def test_a_row_that_is_no_reading_is_set_aside(row: str, reason: str, line: int, csv_file) -> None:
    lines = TABLE.splitlines()
    lines[line - 1] = row.replace("2,", lines[line - 1][:2], 1)
    fit = fit_friction(csv_file("\n".join(lines)), bend_angle="144 deg")
    assert fit.friction == pytest.approx(0.0743, abs=2e-4)
    assert [(part.reason.startswith(reason), part.lines) for part in fit.set_aside] == [(True, ((line, line),))]


def test_headers_that_the_forces_contradict_are_warned_of(csv_file) -> None:
    swapped = TABLE.replace("load_cell_1_kg", "force load (kg)").replace("load_cell_2_kg", "force motor (kg)")
    right = TABLE.replace("load_cell_1_kg", "force motor (kg)").replace("load_cell_2_kg", "force load (kg)")
    said = [fit_friction(csv_file(text), bend_angle="144 deg").warnings for text in (swapped, right)]
    assert [any("swapped" in text for text in warnings) for warnings in said] == [True, False]


def test_the_uncertainty_of_angles_in_a_column(csv_file) -> None:
    header, *rows = TABLE.splitlines()
    plain = "\n".join([f"{header},bend_angle_deg", *(f"{row},144" for row in rows)])
    column = "\n".join([f"{header},bend_angle_deg,bend angle uncertainty (deg)", *(f"{row},144,2" for row in rows)])
    by_column = fit_friction(csv_file(column), bend_angle=None).uncertainty
    by_option = fit_friction(csv_file(plain), bend_angle="+/- 2 deg").uncertainty
    at_once = fit_friction(csv_file(TABLE), bend_angle="144 deg +/- 2 deg").uncertainty
    assert by_column.of(BEND) == pytest.approx(at_once.of(BEND), rel=1e-12)
    assert by_option.of(BEND) == pytest.approx(at_once.of(BEND), rel=1e-12)
    with pytest.raises(UsageError, match="twice"):
        fit_friction(csv_file(column), bend_angle="+/- 2 deg")
    with pytest.raises(UsageError, match="not given"):
        fit_friction(csv_file(TABLE), bend_angle="+/- 2 deg")


@pytest.mark.parametrize("name", READ_RIGHT)
def test_read_right(name: str, csv_file) -> None:
    fit = fit_friction(csv_file(READ_RIGHT[name]), bend_angle="144 deg")
    assert fit.friction == pytest.approx(0.0743048, abs=2e-7)
    assert fit.gain_ratio == pytest.approx(0.99784, rel=1e-5 if "grams" not in name else 1e-4)
    assert round(fit.by_direction["toward_motor"].friction, 4) == 0.0734
    assert round(fit.by_direction["toward_load"].friction, 4) == 0.0752
    assert int(fit.rows.used.sum()) == 6
    assert not fit.is_log
