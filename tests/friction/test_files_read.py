"""Files as they come: those that are read right, without editing."""

from __future__ import annotations

import pytest

from tendon_cli.errors import UsageError
from tendon_cli.fits.friction import fit_friction
from tendon_cli.fits.friction.budget import BEND
from tendon_cli.fits.friction.fit_result import DOUBT
from tests.readers.files import good
from verification.friction_rigs.cases import mentions

from .tables import BARE_ROWS, GERMAN, NAMED, TABLE, WRITTEN, added, called, changed

IN_GRAMS = called("cell 1 (g)", "cell 2 (kg)")
IN_GERMAN = called("Kraft Motor (N)", "Kraft Last (N)", GERMAN)
CELLS_OF_ROWS = [row.split(",") for row in BARE_ROWS.splitlines()]
REORDERED = [f"{cell_2},ok,{cell_1},{case}\n" for case, cell_1, cell_2 in CELLS_OF_ROWS]
TIMES_OF_DAY = [f"2024-05-01 12:00:0{second}" for second in range(6)]

READ_RIGHT: dict[str, str | bytes] = {
    **good(WRITTEN),
    "as the data set has it": TABLE,
    "units in brackets": TABLE.replace("_kg", " [kg]"),
    "units after a slash": TABLE.replace("_kg", " / N"),
    "units spoken": TABLE.replace("_kg", " in kilograms"),
    "cells in grams and kilograms": changed(IN_GRAMS, (",1.236", ",1236"), (",0.", ",")),
    "no units": TABLE.replace("_kg", ""),
    "numbers beside a word": called("Load 1 (kg)", "Load 2 (kg)"),
    "names that say nothing, units of force": called("alpha (N)", "beta (N)"),
    "Roman numerals": called("Load cell I", "Load cell Ⅱ"),
    "short names": called("F1", "F2"),
    "ends of the sheath": called("force_motor_N", "force_load_N"),
    "proximal and distal": called("proximal", "distal"),
    "German headers": changed(
        IN_GERMAN, ("case", "Richtung"), ("\n1;", "\nauf;"), ("\n2;", "\nab;")
    ),
    "columns in another order": "load cell 2,note,load cell 1,case\n" + "".join(REORDERED),
    "a further column of numbers": added("motor position (mm)", *["21.5"] * 6),
    "a column of comments, often empty": added("Comment", *["", "", "dry"] * 2),
    "directions named": NAMED,
    "directions as signs": changed(NAMED, ("up", "+1"), ("down", "-1")),
    "directions from the forces": changed(TABLE, ("case,", ""), ("\n1,", "\n"), ("\n2,", "\n")),
    "a column of time": added("time_s", *"012345"),
    "times of day": added("timestamp", *TIMES_OF_DAY),
    "exponents": changed(TABLE, ("1.236", "1.236e0"), ("0.858", "8.58E-1")),
    "plus signs and bare points": changed(TABLE, ("1.236", "+1.236"), ("0.858", ".858")),
    "a header that looks like a formula": added("=cmd()|x", *"012345"),
}


@pytest.mark.parametrize("name", READ_RIGHT)
def test_read_right(name: str, csv_file) -> None:
    fit = fit_friction(csv_file(READ_RIGHT[name]), bend_angle="144 deg")
    tolerance = 1e-4 if "grams" in name else 1e-5
    assert fit.friction == pytest.approx(0.0743048, abs=2e-7)
    assert fit.gain_ratio == pytest.approx(0.99784, rel=tolerance)
    assert [round(part.friction, 4) for part in fit.by_direction.values()] == [0.0734, 0.0752]
    assert (fit.rows.used.sum(), fit.is_log) == (6, False)


def test_a_number_beside_a_word_names_no_end(csv_file) -> None:
    fit = fit_friction(csv_file(called("Load 1 (N)", "Load 2 (N)")), bend_angle="144 deg")
    assert fit.motor == "1"
    assert not mentions(fit.warnings, "swapped")


def test_cells_that_their_unit_alone_names_are_said(csv_file) -> None:
    path = csv_file(called("alpha (N)", "beta (N)"))
    fit = fit_friction(path, bend_angle="144 deg")
    assert 'cells.csv: load cells by their unit alone: "alpha (N)", "beta (N)"' in fit.notes


def test_columns_by_their_numbers(csv_file) -> None:
    """A file without a header has numbers of columns alone."""
    named = called("alpha", "beta")
    for content in (named, "Rig 3,,\n" + named, BARE_ROWS, "# rig 3\n" + BARE_ROWS):
        path = csv_file(content)
        fit = fit_friction(path, bend_angle="144 deg", cell_1="2", cell_2="3", direction="1")
        assert fit.friction == pytest.approx(0.0743048, abs=2e-7)
        assert fit.rows.used.sum() == 6


@pytest.mark.parametrize("line", [2, 6])
@pytest.mark.parametrize(
    ("cells", "reason"),
    [
        ("NaN,1.036", "no reading"),
        (",1.036", "no reading"),
        ("0,1.036", "force at or below zero"),
        ("-0.858,1.036", "force at or below zero"),
        ("0.004,0.002", "no load"),
    ],
)
def test_a_row_that_is_no_reading_is_set_aside(
    cells: str, reason: str, line: int, csv_file
) -> None:
    lines = TABLE.splitlines()
    lines[line - 1] = lines[line - 1][:2] + cells
    fit = fit_friction(csv_file("\n".join(lines)), bend_angle="144 deg")
    assert fit.friction == pytest.approx(0.0743, abs=2e-4)
    (part,) = fit.set_aside
    assert part.reason.startswith(reason)
    assert part.lines == ((line, line),)


def test_headers_that_the_forces_contradict_are_warned_of(csv_file) -> None:
    swapped = csv_file(called("force load (kg)", "force motor (kg)"))
    assert mentions(fit_friction(swapped, bend_angle="144 deg").warnings, "swapped")
    right = csv_file(called("force motor (kg)", "force load (kg)"))
    assert not mentions(fit_friction(right, bend_angle="144 deg").warnings, "swapped")


def test_the_uncertainty_of_angles_in_a_column(csv_file) -> None:
    angles = added("bend_angle_deg", *["144"] * 6)
    both = added("bend_angle_deg,bend angle uncertainty (deg)", *["144,2"] * 6)
    parts = []
    for text, bend_angle in ((both, None), (angles, "+/- 2 deg"), (TABLE, "144 deg +/- 2 deg")):
        fit = fit_friction(csv_file(text), bend_angle=bend_angle)
        parts.append(fit.uncertainty.contribution_of(BEND))
    assert parts == pytest.approx([parts[0]] * 3, rel=1e-12)
    with pytest.raises(UsageError, match="twice"):
        fit_friction(csv_file(both), bend_angle="+/- 2 deg")
    with pytest.raises(UsageError, match="not given"):
        fit_friction(csv_file(TABLE), bend_angle="+/- 2 deg")


@pytest.mark.parametrize(
    ("angle", "factor", "words"),
    [("15 deg", 1.0, "not of 15 deg"), ("144 deg", 9.0, "one cell reads"), ("144 deg", 1.0, "")],
)
def test_a_number_that_no_sheath_has_is_doubted_first(
    angle: str, factor: float, words: str, csv_file
) -> None:
    """A ratio of the forces of e² is no sheath's, and a bend that is too small makes μ large."""
    rows = [f"1,{factor * 1.236:.6f},1.028"] * 3 + [f"2,{0.858 / factor:.6f},1.036"] * 3
    text = "\n".join(["case,load_cell_1_kg,load_cell_2_kg", *rows])
    fit = fit_friction(csv_file(text), bend_angle=angle)
    doubts = [warning for warning in fit.warnings if warning.startswith(DOUBT)]
    assert bool(doubts) == bool(words)
    assert words in "".join(doubts)
    assert not doubts or fit.text.startswith(f"warning: {DOUBT}")
