"""Files as they come: those that are refused, each with file, line and column."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest

from tendon_cli.errors import InputError, TendonError, UsageError
from tendon_cli.fits.friction import fit_friction
from tests.readers.files import hostile

from .tables import BARE_ROWS, GERMAN, NAMED, TABLE, WRITTEN, added, called, changed

FIFTH = "2,0.858,1.036\n2,0.858"
"""Text of the table's fifth line and its sixth that stands there once."""


def fifth(cell: str) -> str:
    """Return the table with another first cell in its fifth line."""
    return changed(TABLE, (FIFTH, f"2,{cell},1.036\n2,0.858"))


WHOLE = "case,cell 1,cell 2,temperature,humidity\n1,1,236,1,028\n1,1,237,1,029\n2,1,858,1,036\n"
ZEROS = "case,note,cell 1,rpm,cell 2\n1,1,236,1,028\n2,0,858,1,036\n"
ONE_SIDE = "case,cell 1,cell 2\n1,1.4,1\n1,1.41,1\n1,1.4,1\n2,1.2,1\n2,1.21,1\n2,1.2,1\n"
REFUSED: dict[str, tuple[str | bytes, str, str]] = {
    **hostile(WRITTEN, 1),
    "no header": (BARE_ROWS, "line 1", "no header"),
    "names that say nothing": (called("alpha", "beta"), "line 1", "no header"),
    "three cells": ("cell 1,cell 2,load cell 2\n1,2,3\n", "line 1", "several columns"),
    "one cell twice": (
        "cell 1 (N),cell 1 (N)\n1,2\n",
        "line 1",
        "stands twice, in columns 1 and 2",
    ),
    "decimal commas between commas": (
        GERMAN.replace(";", ","),
        "line 2",
        "5 cells where the header has 3",
    ),
    "decimal commas that fill the columns": (WHOLE, "cells.csv", "whole numbers"),
    "decimal commas with zeros in front": (ZEROS, "line 2, column 5", "begins with a zero"),
    "both decimal signs": (GERMAN.replace("0,857", "0.857"), "line 7, column 2", "decimal sign"),
    "thousands separators": (
        "cell 1;cell 2\n1,236;1,028\n858;1,036\n857;1,036\n",
        "line 2, column 1",
        "thousands",
    ),
    "points that separate thousands": (
        "cell 1,cell 2\n1.236,1.028\n858,1.036\n857,1.036\n",
        "line 2",
        "thousands",
    ),
    "both in one number": (
        GERMAN.replace("0,857", "1.000,857"),
        "line 7, column 2",
        "expected a number",
    ),
    "one row with cells swapped": (
        changed(TABLE, ("0.857,1.036", "1.036,0.857")),
        "line 7",
        "friction would help",
    ),
    "both directions alike": (
        TABLE.replace("0.858,1.036", "1.236,1.028"),
        "cells.csv",
        "friction would help",
    ),
    "both directions on one side": (ONE_SIDE, "cells.csv", "friction would help"),
    "two groups without directions": (
        "cell 1,cell 2\n1.4,1\n1.41,1\n1.2,1\n1.21,1\n",
        "cells.csv",
        "two groups",
    ),
    "motor named, friction helping": (
        called("load", "motor", NAMED),
        "cells.csv",
        "friction would help",
    ),
    "everything constant": (
        "case,cell 1,cell 2\n1,1,1\n1,1,1\n2,1,1\n",
        "cells.csv",
        "same in every row",
    ),
    "forces that no cell reads": (
        "cell 1,cell 2\n1.2e13,1e13\n1e13,1.2e13\n",
        "cells.csv",
        "more than any load cell measures",
    ),
    "next to nothing": (
        "cell 1,cell 2\n1.2e-300,1e-300\n1e-300,1.2e-300\n",
        "cells.csv",
        "above zero",
    ),
    "one reading": ("cell 1,cell 2\n1.236,1.028\n", "cells.csv", "fewer than the 2"),
    "one with a direction": ("cell 1,cell 2\n1.2,1\n1.1,1.1\n", "cells.csv", "fewer than the 2"),
    "one reading per direction": (
        "cell 1,cell 2\n1.236,1.028\n0.858,1.036\n",
        "cells.csv",
        "fewer than the 3",
    ),
    "one unit missing": (
        TABLE.replace("cell_2_kg", "cell_2"),
        "line 1, column 3",
        'unit of "load_cell_2" is missing',
    ),
    "units that do not compare": (
        TABLE.replace("cell_2_kg", "cell_2 (V)"),
        "line 1",
        "cannot be compared",
    ),
    "counts": (
        TABLE.replace("_kg", "").replace(",1.", ",21").replace(",0.", ",20"),
        "line 1, column 2",
        "not yet calibrated",
    ),
    "counts by name": (TABLE.replace("_kg", " (counts)"), "line 1, column 2", "not yet calibrated"),
    "an unknown unit": (TABLE.replace("_kg", " (foo)"), "line 1, column 2", 'unknown unit "foo"'),
    "volts": (TABLE.replace("_kg", " (V)"), "line 1, column 2", "not yet calibrated"),
    "direction missing": (changed(TABLE, (FIFTH, FIFTH[1:])), "line 5", "direction is missing"),
    "directions in two languages": (NAMED.replace("down", "2"), "cells.csv", "are mixed"),
    "HTML": ("<html>\n<body>, <p>\ncell\n</html>\n", "cells.csv", ""),
}
COLUMNS = {
    "bend_angle,cell 1,cell 2\n90,1.2,1\n90,1.2,1\n": ("line 1, column 1", "has no unit"),
    "bend_angle_deg,cell 1,cell 2\n90,1.2,1\n-90,1,1.2\n": ("line 3, column 1", "negative"),
    "bend_angle_rad,cell 1,cell 2\n144,1.2,1\n144,1,1.2\n": ("line 1", "reach 144 rad"),
    "bend_angle_deg,cell 1,cell 2\n0,1.2,1\n0,1,1.2\n": ("line 1", "expected above 0"),
    "bend_angle_deg,wrap_angle_rad,cell 1,cell 2\n1,1,1,1\n": ("line 1", "two columns"),
}
"""Columns of bend angles, each with its fault."""


def told(error: InputError) -> list[str]:
    """Return the place that an error names, and each of its faults; several have their own."""
    heading, *listed = (error.message or "").splitlines()
    return [error.where or "", *(listed or [heading])]


@pytest.mark.parametrize(
    ("content", "where", "message", "angle"),
    [(*case, "144 deg") for case in REFUSED.values()]
    + [(text, *case, None) for text, case in COLUMNS.items()],
    ids=[*REFUSED, *(message for _, message in COLUMNS.values())],
)
def test_refused(
    content: str | bytes, where: str, message: str, angle: str | None, csv_file
) -> None:
    with pytest.raises(InputError) as caught:
        fit_friction(csv_file(content), bend_angle=angle)
    place, *faults = told(caught.value)
    assert "cells.csv" in place
    first = faults[0]
    assert message in first
    assert where in f"{place}, {first}"
    assert all(len(fault) < 400 for fault in faults)


def test_every_bad_cell_is_told_with_its_line_ten_at_most(csv_file) -> None:
    lines = ["motor (N),load (N)", *(f"{1.2 + 0.001 * row:.3f},1.000" for row in range(40))]
    bad = {4: "oops", 6: "x", 9: "1e999"}
    for line, cell in bad.items():
        lines[line - 1] = f"1.2,{cell}"
    with pytest.raises(InputError) as caught:
        fit_friction(csv_file("\n".join(lines)), bend_angle="144 deg")
    faults = told(caught.value)[1:]
    assert len(faults) == len(bad)
    for line, cell in bad.items():
        named = [fault for fault in faults if f"line {line}, column 2" in fault]
        assert len(named) == 1
        assert f'"{cell}"' in named[0]


def test_of_many_bad_cells_ten_are_told_and_the_others_counted(csv_file) -> None:
    lines = ["motor (N),load (N)", *(f"bad{row},1.000" for row in range(23))]
    with pytest.raises(InputError) as caught:
        fit_friction(csv_file("\n".join(lines)), bend_angle="144 deg")
    faults = told(caught.value)[1:]
    assert len(faults) == 11
    assert "13 more" in faults[-1]


def test_every_missing_direction_and_bad_angle_is_told(csv_file) -> None:
    no_direction = "direction,cell 1,cell 2\nup,1.2,1\n,1.2,1\ndown,1,1.2\n,1,1.2\n"
    bad_angle = "bend_angle_deg,cell 1,cell 2\n90,1.2,1\n-90,1.2,1\n90,1,1.2\n,1,1.2\n"
    for content, angle in ((no_direction, "144 deg"), (bad_angle, None)):
        with pytest.raises(InputError) as caught:
            fit_friction(csv_file(content), bend_angle=angle)
        faults = told(caught.value)[1:]
        assert ["line 3" in fault for fault in faults] == [True, False]
        assert ["line 5" in fault for fault in faults] == [False, True]


def test_a_note_names_the_columns_that_are_not_read(csv_file) -> None:
    content = added("torque (Nm)", *"654321")
    first = csv_file(content, "first.csv")
    second = csv_file(content.replace("\n", "\n\n", 1), "second.csv")
    notes = fit_friction([first, second], bend_angle="144 deg").notes
    assert "first.csv: columns not read: torque (Nm)" in notes
    assert "second.csv: columns not read: torque (Nm)" in notes
    alone = fit_friction(csv_file(TABLE), bend_angle="144 deg").notes
    assert not any("not read" in note for note in alone)


def test_a_column_of_directions_by_option(csv_file) -> None:
    words = ("up", "up", "up", "down", "down", "down")
    directed = csv_file(added("winch", *words), "winch.csv")
    told_note = '; if "winch" says the direction, name it direction or give --direction'
    case_off = TABLE.replace("case,", "trial,")
    bare = csv_file(changed(added("winch", *words), ("case,", "trial,")), "bare.csv")
    note = next(
        note for note in fit_friction(bare, bend_angle="144 deg").notes if "not read" in note
    )
    assert note == f"bare.csv: columns not read: trial, winch{told_note}"
    fit = fit_friction(bare, bend_angle="144 deg", direction="winch")
    assert fit.friction == fit_friction(directed, bend_angle="144 deg").friction
    assert not any(told_note in text for text in fit.notes)
    # A column that is read, one that is often empty, and numbers say no direction.
    for content in (added("winch", *words), case_off, added("Comment", *["", "", "dry"] * 2)):
        notes = fit_friction(csv_file(content), bend_angle="144 deg").notes
        assert not any("--direction" in text for text in notes)
    with pytest.raises(UsageError) as caught:
        fit_friction(bare, bend_angle="144 deg", direction="winch_2")
    assert caught.value.where == "--direction"
    assert '"winch"' in caught.value.hint


def test_column_names_by_option(csv_file) -> None:
    path = csv_file(called("α", "rate"))
    fit = fit_friction(path, bend_angle="144 deg", cell_1="α", cell_2="rate")
    assert fit.friction == pytest.approx(0.0743048, abs=1e-6)
    with pytest.raises(UsageError, match="no line of"):
        fit_friction(path, bend_angle="144 deg", cell_1="α", cell_2="nothing")
    with pytest.raises(UsageError, match="named"):
        fit_friction(path, bend_angle="144 deg", cell_1="α")


@pytest.mark.parametrize(
    ("angle", "offered"),
    [
        ("144", 'write "144 deg" or "144 rad"'),
        ("144 deg +/- 2", 'write "2 deg" or "2 rad"'),
        ("144 mm", ""),
        ("-144 deg", ""),
        ("0 deg", ""),
        ("nan deg", ""),
        ("144 rad", ""),
        ("1e-300 rad", ""),
    ],
)
def test_bend_angle_is_never_guessed_but_offered_with_its_units(
    angle: str, offered: str, csv_file
) -> None:
    with pytest.raises(UsageError) as caught:
        fit_friction(csv_file(TABLE), bend_angle=angle)
    assert caught.value.where == "--bend-angle"
    assert (caught.value.hint or "").startswith(offered)


def test_bend_angle_given_twice(csv_file) -> None:
    path = csv_file("bend_angle_deg,cell 1,cell 2\n90,1.2,1\n90,1.2,1\n90,1,1.2\n90,1,1.2\n")
    with pytest.raises(UsageError, match="twice"):
        fit_friction(path, bend_angle="144 deg")
    assert fit_friction(path, bend_angle="90 deg").friction == fit_friction(path).friction


def test_a_file_that_is_none(tmp_path: Path) -> None:
    missing = tmp_path / "missing.csv"
    too_long = tmp_path / ("x" * 5000)
    for path in (tmp_path, missing, too_long, Path("/dev/zero"), Path("a\0b")):
        with pytest.raises((InputError, UsageError)):
            fit_friction(path, bend_angle="144 deg")


def test_a_hundred_megabytes_of_junk(tmp_path: Path) -> None:
    path = tmp_path / "cells.csv"
    with path.open("wb") as file:
        file.truncate(100 * 2**20)
    with pytest.raises(InputError, match="larger than 64 MB"):
        fit_friction(path, bend_angle="144 deg")


def test_no_piece_of_a_file_is_a_traceback(csv_file) -> None:
    for cut in range(0, len(TABLE), 5):
        before = TABLE[:cut]
        after = TABLE[cut:]
        for between in ("", '"', ",;\t"):
            for text in {before + between + after, before, after}:
                with contextlib.suppress(TendonError):
                    assert fit_friction(csv_file(text), bend_angle="144 deg").friction > 0.0


def test_a_row_of_another_length_hides_no_bad_cell(csv_file) -> None:
    content = "motor (N),load (N)\n1.2,1\n1.2,x\n1.2\ny,1\n"
    with pytest.raises(InputError) as caught:
        fit_friction(csv_file(content), bend_angle="144 deg")
    text = str(caught.value)
    assert all(f"line {line}" in text for line in (3, 4, 5))
