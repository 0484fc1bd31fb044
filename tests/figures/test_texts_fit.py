"""Texts of every kind of figure are whole, apart and set, whatever is drawn.

Each picture is a study that users may have, with long names, many rows, large and small numbers.
Its figures are drawn at the sizes there are and measured (`measure.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import tendon_cli as tendon
from tendon_cli.commands.cli import app
from tendon_cli.cube.cube import cube_in
from tendon_cli.face import write_comparison
from tendon_cli.figures.answer_figures import FIGURES, draw_answer, draw_over
from tendon_cli.figures.draw import pages_of, table_of
from tendon_cli.figures.frame import framed, text_width
from tendon_cli.figures.geometry import route_page
from tendon_cli.figures.scales import short_names
from tendon_cli.figures.style import house_style, named
from tendon_cli.studies.figures import WIDTHS, figure_spec
from tests.figures.measure import DRAWERS, capture, faults_of
from tests.figures.runs import EXACT, LOADS, grid

ROOT = Path(__file__).parents[2]
TITLE = (
    "A title with commas, dollars such as $F_0$, and WIDE WORDS, MMMMMMMMMM and WWWWWWWWWW, that "
    "goes on and on, far beyond the width of a page"
)
PART = "Sheath of PTFE, 1.8 mm bore, batch 2024-11, lot {}"
ANGLES = {"elbow_angle": grid("0 deg", "90 deg", 7)}
GRID = {
    "spring": {"stiffness": ["3 kN/m", "8 kN/m"]},
    "spool": {"ratio": [0.5, 0.6]},
    "load": {"mass": ["0 kg", "10 kg"]},
    "motion": ANGLES,
}
TIME = np.round(np.arange(0.0, 4.0, 0.02), 9)  # s
GAIT = {
    "trajectory": {
        "time": TIME.tolist(),
        "angle": [f"{float(50.0 - 30.0 * np.cos(np.pi * time))!r} deg" for time in TIME],
    }
}
FIGURE = "tendon_cli.figures."
OF_ANSWERS = {f"{FIGURE}choice_maps.draw_tolerance", f"{FIGURE}windows._window_pages"}
BETWEEN = f"{FIGURE}windows.draw_between"
CURVES = f"{FIGURE}curves._page"
MAPS = f"{FIGURE}maps.draw_maps"
TRADE_OFF = f"{FIGURE}windows.draw_trade_off"

Picture = Callable[[Path], None]
PICTURES: dict[str, tuple[Picture, set[str], bool]] = {}
"""Functions that draw, by name; what draws the figures; and whether they are always measured."""


def picture(*drawers: str, is_quick: bool = True) -> Callable[[Picture], Picture]:
    """Register a function that draws the figures of some drawers into a folder."""

    def register(draw: Picture) -> Picture:
        PICTURES[draw.__name__] = (draw, set(drawers), is_quick)
        return draw

    return register


def swept(study: Any, folder: Path, *specs: dict[str, Any], maps: bool = True) -> None:
    """Sweep a study with its own figures, and draw others at the width of a column and a page."""
    run = tendon.sweep({"name": "study", **study}, folder / "run", figures=maps)
    for spec in specs:
        for size in WIDTHS:
            asked = figure_spec(**spec, size=size)
            table = table_of(folder / "run", asked, None, run.study)
            for page in pages_of(table, asked, study=run.study):
                page.shown()


def answered(study: Any, folder: Path, *more: str, x: str | None = None) -> None:
    """Answer a study and draw all figures of the answer; the trade-off along x at both widths."""
    answer = tendon.design({"name": "study", **study}, folder / "answer")
    draw_answer(answer.study, folder / "answer", folder, answer.record)
    for name in more:
        answer.plot(name)
    if x is not None:
        choices = cube_in(answer, "choices")
        for size, width in WIDTHS.items():
            draw_over(choices, answer.record, x, None, folder / f"{size}.png", width=width)


def run(folder: Path, text: str, *arguments: str) -> None:
    """Run `tendon state` on a study."""
    (folder / "study.toml").write_text(text, encoding="utf-8")
    done = CliRunner().invoke(app, ["state", str(folder / "study.toml"), *arguments])
    assert done.exit_code == 0, done.output


# --- Sweeps ---------------------------------------------------------------------------------------


@picture(MAPS, CURVES)
def far_and_near_numbers(folder: Path) -> None:
    """Draw numbers whose labels are long and lie close together."""
    study = {
        "title": TITLE,
        "spring": {"stiffness": ["1.2345678 kN/m", "1.2345679 kN/m", "800 kN/m"]},
        "spool": {"ratio": [0.123456, 3.3]},
        "load": {"mass": ["0.001 kg", "0.0012 kg", "99.99 kg"]},
        "sheath": {"friction": [0.00001, 0.7]},
        "motion": ANGLES,
        "allow_implausible": True,
    }
    swept(study, folder, {"quantity": "margin", "x": "spring.stiffness"})


@picture(MAPS, CURVES, is_quick=False)
def many_cases(folder: Path) -> None:
    """Draw 40 cases with long names along x, in colours and in panels."""
    cases = [
        {"name": PART.format(place), "arm": {"forearm_mass": f"{1.0 + place / 10.0} kg"}}
        for place in range(40)
    ]
    study = {
        "cases": cases,
        "spool": {"ratio": [0.5, 0.6]},
        "load": {"mass": LOADS},
        "motion": ANGLES,
    }
    swept(
        study,
        folder,
        {"quantity": "margin", "x": "case"},
        {"quantity": "margin", "x": "spool.ratio", "colour": "case"},
        {"quantity": "motor_torque", "colour": "case"},
    )


@picture(CURVES, is_quick=False)
def long_names_of_rows(folder: Path) -> None:
    """Draw eight rows with long names along x, at the width of a column and a page."""
    rows = [
        {"name": PART.format(place), "spring.stiffness": f"{1 + place} kN/m"} for place in range(8)
    ]
    study = {"table": [{"name": "spring", "rows": rows}], "motion": ANGLES}
    swept(study, folder, {"quantity": "margin", "x": "spring"}, maps=False)


@picture(CURVES, is_quick=False)
def usual_figures_of_states(folder: Path) -> None:
    """Draw the usual panels of states, those of designs with a speed, and other units."""
    study = {"title": TITLE, "load": {"mass": LOADS}, "motion": {**ANGLES, "speed": "60 deg/s"}}
    swept(
        study,
        folder,
        {"quantity": []},
        {"quantity": ["motor_torque", "extensor_slack"]},
        {"quantity": ["flexor_travel", "extensor_travel"], "unit": ["cm"]},
        {"quantity": ["peak_motor_power", "efficiency", "max_torque_band"], "x": "load.mass"},
    )


@picture(MAPS, CURVES, is_quick=False)
def many_limits(folder: Path) -> None:
    """Draw maps of persons with many limits."""
    study = {
        **GRID,
        "people": {"count": 12, "seed": 1},
        "motion": {**ANGLES, "speed": "60 deg/s"},
        "limits": {
            "max_tension": "300 N",
            "peak_motor_torque": "12 N m",
            "max_spring_extension": "60 mm",
            "peak_motor_speed": "6 rad/s",
            "min_flexor_tension": "5 N",
        },
        "setting": {"read": "flexor at joint"},
    }
    swept(study, folder, {"quantity": "margin", "x": "spring.stiffness"})


@picture(CURVES, is_quick=False)
def a_sample(folder: Path) -> None:
    """Draw 64 rows of a sample as points."""
    between = {"spring.stiffness": "1 kN/m to 8 kN/m", "spool.ratio": "0.4 to 1.0"}
    table = {"name": "sample", "sample": "sobol", "count": 64, "seed": 1, "between": between}
    study = {"table": [table], "load": {"mass": LOADS}, "motion": ANGLES}
    swept(study, folder, {"quantity": "peak_motor_torque"})


@picture(CURVES, is_quick=False)
def a_motion_in_time(folder: Path) -> None:
    """Draw results over the time of a gait."""
    study = {"load": {"mass": ["0 kg", "2 kg"]}, "motion": GAIT, "spool": {"ratio": 0.6}}
    swept(study, folder, {"quantity": ["motor_torque", "flexor_tension_distal"]}, {"quantity": []})


@picture(MAPS, CURVES, is_quick=False)
def a_joint_with_a_long_name(folder: Path) -> None:
    """Draw the usual figures of a joint whose name is long, at the width of a column and a page."""
    study = {**GRID, "joint": {"name": "metacarpophalangeal joint"}}
    swept(
        study,
        folder,
        {"quantity": ["elbow_torque", "extensor_tension_distal"]},
        {"quantity": "margin", "x": "spring.stiffness"},
    )


# --- Answers --------------------------------------------------------------------------------------


@picture(*OF_ANSWERS, BETWEEN)
def an_answer(folder: Path) -> None:
    """Draw the figures of an answer with a long title, read at the joint."""
    study = {**GRID, **EXACT, "title": TITLE, "setting": {"read": "flexor at joint"}}
    answered(study, folder, "between")


@picture(
    *OF_ANSWERS,
    f"{FIGURE}choice_maps.draw_served",
    f"{FIGURE}served.for_whom",
    f"{FIGURE}served.how_sure",
)
def an_answer_for_people(folder: Path) -> None:
    """Draw the figures of an answer for some persons."""
    people = {"count": 12, "seed": 1}
    answered({**GRID, "title": TITLE, "people": people, "design": {"verify": 0}}, folder)


WITH_INDEX = {
    "spool": {"flexor_radius": ["30 mm", "40 mm"], "ratio": [0.6, 0.7]},
    "anchor": {"stiffness": ["20 kN/m", "40 kN/m"]},
    "arm": {"load_distance": ["280 mm", "320 mm"], "a1": "40 mm +/- 4 mm"},
    "joint": {"stiffness": "1 N m/rad +/- 0.4 N m/rad", "rest_angle": "73 deg"},
    "spring": {"stiffness": "5 kN/m"},
    "load": {"mass": ["0 kg", "5 kg"]},
    "motion": ANGLES,
    "uncertainty": {"draws": 16},
    "design": {"conditions": ["load.mass", "arm.load_distance"], "verify": 0},
}
"""A study whose choices, conditions and draws are of quantities that have symbols with an index."""


@picture(
    *OF_ANSWERS, f"{FIGURE}served.for_whom", f"{FIGURE}served.how_sure", BETWEEN, is_quick=False
)
def symbols_with_an_index(folder: Path) -> None:
    """Draw an answer for persons, some of whom are not served, and what it rests on."""
    answered(WITH_INDEX, folder / "draws")
    few = {**WITH_INDEX, "people": {"count": 24, "seed": 1}, "limits": {"max_tension": "330 N"}}
    answered({**few, "arm": {"load_distance": ["280 mm", "320 mm"]}}, folder / "people", "between")


@picture(MAPS, CURVES, is_quick=False)
def panels_of_symbols_with_an_index(folder: Path) -> None:
    """Draw maps and lines over quantities that have symbols with an index."""
    study = {name: WITH_INDEX[name] for name in ("spool", "anchor", "spring", "load", "motion")}
    swept(
        {**study, "arm": {"load_distance": ["280 mm", "320 mm"]}},
        folder,
        {"quantity": ["flexor_tension_distal", "elbow_torque"], "colour": "spool.flexor_radius"},
        {"quantity": "margin", "x": "spool.flexor_radius"},
    )


@picture(
    f"{FIGURE}windows._window_pages",
    f"{FIGURE}served.for_whom",
    f"{FIGURE}served.how_sure",
    is_quick=False,
)
def many_draws(folder: Path) -> None:
    """Draw 1,024 draws of six numbers and what each makes uncertain."""
    study = {
        "sheath": {
            "friction": {"value": 0.07, "tolerance": "30 %"},
            "bend_angle": {"mean": "180 deg", "std": "20 deg"},
        },
        "tendon": {"youngs_modulus": {"value": "145 GPa", "tolerance": "10 %"}},
        "arm": {
            "b1": {"value": "150 mm", "tolerance": "5 %"},
            "forearm_mass": {"value": "1.5 kg", "tolerance": "10 %"},
        },
        "joint": {
            "rest_angle": "73 deg",
            "stiffness": {"mean": "1 N m/rad", "std": "0.4 N m/rad"},
        },
        "spring": {"stiffness": ["3 kN/m", "5 kN/m"]},
        "load": {"mass": ["0 kg", "3 kg"]},
        "motion": ANGLES,
        "uncertainty": {"draws": 1024},
        "design": {"verify": 0},
        "setting": {"read": "flexor at joint"},
    }
    answered(study, folder)


@picture(
    f"{FIGURE}choice_maps.draw_tolerance",
    f"{FIGURE}windows._window_pages",
    f"{FIGURE}answer_figures.draw_front",
    TRADE_OFF,
)
def pairs_of_parts(folder: Path) -> None:
    """Draw 32 pairs of parts with long names and strange signs, and the front over their price."""
    springs = [
        {"name": PART.format(place), "spring.stiffness": f"{2 + place} kN/m", "price": 9 + place}
        for place in range(8)
    ]
    motors = [
        {
            "name": f"M{place} $wide$ _x",
            "spool.flexor_radius": f"{25 + 5 * place} mm",
            "limits.peak_motor_torque": f"{10 + place} N m",
            "price": 100 + 30 * place,
        }
        for place in range(4)
    ]
    study = {
        "title": TITLE,
        "table": [{"name": "spring", "rows": springs}, {"name": "motor", "rows": motors}],
        "spool": {"ratio": 0.6},
        "load": {"mass": LOADS},
        "motion": ANGLES,
        "design": {"minimise": ["price"], "maximise": ["tolerance_length"]},
        **EXACT,
    }
    answered(study, folder)


@picture(f"{FIGURE}windows._window_pages", TRADE_OFF, is_quick=False)
def a_limit_of_each_part(folder: Path) -> None:
    """Draw the trade-off over twelve parts with long names, by name and over their limit."""
    rows = [
        {
            "name": PART.format(place),
            "spring.stiffness": f"{2 + 2 * place} kN/m",
            "limits.max_tension": f"{300 + 20 * place} N",
        }
        for place in range(12)
    ]
    study = {
        "table": [{"name": "spring", "rows": rows}],
        "spool": {"ratio": 0.6},
        "load": {"mass": LOADS},
        "motion": ANGLES,
    }
    answered(study, folder, x="limits.max_tension")


@picture(f"{FIGURE}windows._window_pages", is_quick=False)
def forty_parts(folder: Path) -> None:
    """Draw 40 parts with long names."""
    rows = [
        {"name": PART.format(place), "spring.stiffness": f"{2.0 + place / 5.0} kN/m"}
        for place in range(40)
    ]
    study = {
        "table": [{"name": "spring", "rows": rows}],
        "load": {"mass": LOADS},
        "motion": ANGLES,
    }
    answered(study, folder)


@picture(f"{FIGURE}windows._draw_points")
def an_answer_for_a_sample(folder: Path) -> None:
    """Draw the windows of 64 choices over six numbers."""
    between = {
        "spring.stiffness": "1 kN/m to 8 kN/m",
        "spool.ratio": "0.4 to 1.0",
        "sheath.friction": "0.07 +/- 0.02",
        "sheath.bend_angle": "90 deg to 300 deg",
        "tendon.length": "1 m to 3 m",
        "tendon.diameter": "1 mm to 2 mm",
    }
    table = {"name": "sample", "sample": "sobol", "count": 64, "seed": 1, "between": between}
    loads = {"load": {"mass": ["0 kg", "10 kg"]}}
    answered({"table": [table], **loads, "motion": ANGLES, **EXACT}, folder)


@picture(*OF_ANSWERS, TRADE_OFF, is_quick=False)
def a_limit_along_an_axis(folder: Path) -> None:
    """Draw the trade-off along five values of a limit."""
    limits = {"max_tension": ["250 N", "300 N", "350 N", "400 N", "500 N"]}
    answered({**GRID, "title": TITLE, "limits": limits}, folder, x="limits.max_tension")


@picture(*OF_ANSWERS, is_quick=False)
def a_fine_grid(folder: Path) -> None:
    """Draw an answer over four axes, two of them with twelve values."""
    study = {
        "title": TITLE,
        "spring": {"stiffness": grid("1 kN/m", "8 kN/m", 12)},
        "spool": {"ratio": grid("0.4", "1.2", 12), "flexor_radius": ["20 mm", "30 mm"]},
        "sheath": {"friction": [0.03, 0.07]},
        "load": {"mass": LOADS},
        "motion": ANGLES,
        "limits": {"max_tension": "400 N"},
    }
    answered(study, folder)


@picture(f"{FIGURE}windows._window_pages", BETWEEN, is_quick=False)
def an_answer_over_time(folder: Path) -> None:
    """Draw the window over the time of a gait."""
    study = {
        "spring": {"stiffness": ["5 kN/m", "8 kN/m"]},
        "spool": {"ratio": 0.6},
        "load": {"mass": "2 kg"},
        "motion": GAIT,
    }
    answered(study, folder, "between")


# --- Arms, motors, fits, comparisons --------------------------------------------------------------


@picture(f"{FIGURE}arm.arm_page")
def two_arms(folder: Path) -> None:
    """Draw a straight arm with short limbs, and one that leans."""
    short = {"b1": "123.456 mm", "b2": "87.654 mm", "a1": "43.21 mm"}
    tendon.study({"title": TITLE, "arm": short}).plot(angles=[0.0])
    tendon.study({"arm": {"upper_arm_angle": "60 deg"}}).plot(angles=np.linspace(0.0, 1.8, 7))


@picture(f"{FIGURE}arm.arm_page", is_quick=False)
def many_arms(folder: Path) -> None:
    """Draw arms of many shapes at many angles."""
    for arm in (
        {},
        {"b2": "320 mm", "load_distance": "320 mm", "forearm_com": "318 mm"},
        {"a1": "5 mm", "a2": "5 mm", "elbow_radius": "20 mm"},
        {"upper_arm_angle": "90 deg"},
    ):
        study = tendon.study({"name": "arm", "arm": arm})
        for angles in ([], [0.0], [0.3], [1.2], [1.57]):
            study.plot(angles=angles)


@picture(f"{FIGURE}arm._travels_page")
def measured_travels(folder: Path) -> None:
    """Draw the travels of an ankle."""
    rows = ["-40,-31,-26.4", "-20,-14.6,-13.7", "0,0,0", "20,13,14", "30,18.9,20.8"]
    lines = ["angle (deg),flexor (mm),extensor (mm)", *rows]
    (folder / "ankle.csv").write_text("\n".join(lines), encoding="utf-8")
    study = {
        "name": "ankle",
        "title": TITLE,
        "joint": {"name": "ankle", "excursion": str(folder / "ankle.csv")},
        "motion": {"elbow_angle": grid("-20 deg", "20 deg", 5)},
    }
    tendon.study(study).plot()


@picture(f"{FIGURE}geometry.route_page")
def routes(folder: Path) -> None:
    """Draw a route whose ends lie behind each other, and one of kilometres."""
    along = np.linspace(0.0, 1.0, 40)
    bent = 1e3 * np.column_stack([0.3 * np.sin(3.0 * along), 0.2 * along, along**2])
    route_page(bent, bent, TITLE, ("A note with many words. " * 20,)).shown()
    straight = np.column_stack([along, 0.0 * along, 0.0 * along])
    route_page(straight, straight, "straight").shown()


@picture("tendon_cli.state_page.plot.draw_motor")
def motors(folder: Path) -> None:
    """Draw a motor over a cycle with limits and a turn, and the title of a study with no spaces."""
    text = """
        name = "a-study-with-a-long-name-that-goes-on-and-on-and-on-and-on"
        spring.stiffness = "5 kN/m"
        load.mass = "5 kg"
        motion.speed = "60 deg/s"
        motion.elbow_angle = { from = "90 deg", to = "0 deg", num = 31 }
        limits = { peak_motor_torque = "12 N m", peak_motor_speed = "6 rad/s" }
        """
    run(folder, text, "--reversal", "--plot", str(folder / "motor.png"))


@picture("tendon_cli.state_page.plot.draw_motor", is_quick=False)
def a_motor_over_time(folder: Path) -> None:
    """Draw a motor over the time of a gait."""
    angles = 50.0 - 30.0 * np.cos(np.pi * TIME)
    lines = ["time (s),angle (deg)", *(f"{t},{a}" for t, a in zip(TIME, angles, strict=True))]
    (folder / "gait.csv").write_text("\n".join(lines), encoding="utf-8")
    text = """
        spring.stiffness = "5 kN/m"
        spool.ratio = 0.6
        tendon.pretension = "150 N"
        load.mass = "2 kg"
        motion.trajectory = "gait.csv"
        limits = { peak_motor_torque = "12 N m", peak_motor_power = "20 W" }
        """
    run(folder, text, "--plot", str(folder / "motor.png"))


@picture(f"{FIGURE}friction.fit_page")
def fits_of_friction(folder: Path) -> None:
    """Draw a fit to settled readings from a file with a long name."""
    readings = (ROOT / "configs/friction/table_a1.csv").read_bytes()
    file = folder / ("readings of the left sheath on the bench " * 4 + ".csv")
    file.write_bytes(readings)
    tendon.fit_friction(file, bend_angle="144 deg").plot()


@picture(f"{FIGURE}friction.fit_page", is_quick=False)
def a_fit_to_a_log(folder: Path) -> None:
    """Draw fits to a log and to readings at several angles."""
    folder = ROOT / "configs/friction"
    tendon.fit_friction(folder / "raw_log.csv", bend_angle="144 deg").plot()
    tendon.fit_friction(folder / "several_angles.csv").plot()


@picture(f"{FIGURE}suit_fit.suit_fit_page", is_quick=False)
def a_fit_to_a_suit(folder: Path) -> None:
    """Draw the fit to a suit's log."""
    suit = ROOT / "configs/suit"
    tendon.fit_suit(suit / "suit.toml", [suit / "suit_log.csv"]).plot()


@picture(
    f"{FIGURE}side_by_side.windows_page",
    f"{FIGURE}side_by_side.margins_page",
    f"{FIGURE}choice_maps.draw_tolerance",
)
def comparisons(folder: Path) -> None:
    """Draw answers and runs with long names side by side."""
    few = {"uncertainty": {"draws": 16}, "design": {"verify": 200}}
    study = {"name": "suit", **GRID, **few}
    less = {**study, "limits": {"max_tension": "400 N"}}
    first = tendon.design(study, folder / "A suit with a rather long name, the first of March 2025")
    compared = tendon.compare(first, tendon.design(less, folder / "v2"))
    write_comparison(compared, folder / "page.html")
    before = tendon.sweep(study, folder / "before")
    now = tendon.sweep(less, folder / "a run with a long name that hardly fits beside an axis")
    tendon.compare(before, now).plot()


# --- The measurement ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if is_quick else pytest.mark.torture)
        for name, (_, _, is_quick) in PICTURES.items()
    ],
)
def test_texts_are_whole_and_apart(name: str, tmp_path: Path) -> None:
    draw, drawers, _ = PICTURES[name]
    with capture() as drawn:
        draw(tmp_path)
    faults = {
        f"{place}: {one.drawer.removeprefix(FIGURE)}": faults_of(one.figure)
        for place, one in enumerate(drawn)
    }
    assert {place: found for place, found in faults.items() if found} == {}
    assert drawers <= {one.drawer for one in drawn}


def test_every_kind_of_figure_is_measured() -> None:
    measured = set().union(*(drawers for _, drawers, _ in PICTURES.values()))
    assert measured == DRAWERS
    assert len(FIGURES) == 7, "a new figure of an answer needs a picture here"


def test_faults_are_found() -> None:
    with house_style():
        figure = framed("title", 60.0).figure
        panel = figure.subplots()
        panel.set(xlabel="$F_0$ (N)", title="tension F_{o} at the joint")
        panel.set_xticks([0.0, 0.01, 1.0], ["one label", "another label", "far"])
        assert len(faults_of(figure)) == 2
        figure.text(0.99, 0.5, "beyond the edge")
        panel.annotate("lost $dollar", (0.5, 0.5))
        panel.annotate("R_f 30 mm", (0.5, 0.1))
        faults = faults_of(figure)
    for words in ("is cut off by", "x of 0) and", "F_{o}", "$dollar", "R_f 30 mm"):
        assert any(words in fault for fault in faults)


# --- The rules by which texts fit -----------------------------------------------------------------


@pytest.mark.parametrize("joint", ["ankle", "left elbow", "elbow joint", "e"])
def test_a_joint_is_named_once(joint: str) -> None:
    text = "Elbow angle: an elbow at the elbow"
    with house_style(joint):
        once = named(text)
        assert named(once) == once
    assert once.casefold().count(f"the {joint}") == 1
    assert once.startswith(f"{joint[0].upper()}{joint[1:]} angle")
    assert named(text) == text


def test_names_that_begin_alike_keep_their_ends() -> None:
    names = ["short", *(PART.format(place) for place in range(3))]
    for width in (16, 30):
        texts = short_names(names, width)
        assert texts[0] == "short"
        assert len(set(texts)) == len(names)
        assert all(len(line) <= width for text in texts for line in text.split("\n"))
        assert all(text.endswith(str(place)) for place, text in enumerate(texts[1:]))


@pytest.mark.parametrize("word", ["MMMM", "iiii", "a b"])
def test_the_width_of_a_text_is_as_drawn(word: str) -> None:
    text = " ".join([word] * 12)
    with house_style():
        figure = framed("", 40.0).figure
        written = figure.text(0.0, 0.5, text, size=6.5)
        figure.draw_without_rendering()
        drawn = written.get_window_extent().width / figure.dpi * 25.4  # mm
    assert text_width(f"i\n{text}", 6.5) == pytest.approx(drawn, rel=0.06)


def test_symbols_are_set_in_sentences_of_an_answer_but_not_in_what_a_user_wrote() -> None:
    text = "R_f 30 mm, K_t of $5, my_R_f"
    with house_style():
        users = framed(text, 40.0)
        answers = framed(text, 40.0, is_of_answer=True)
    assert [page.title for page in (users, answers)] == [text, text]
    titles = [page.figure.texts[0].get_text() for page in (users, answers)]
    assert titles == [r"R_f 30 mm, K_t of \$5, my_R_f", r"$R_{f}$ 30 mm, $K_{t}$ of \$5, my_R_f"]
