"""Answers with usual deviations drawn: exported, drawn and read back as they were given."""

import csv
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.reports.report import write_report
from tendon_cli.verbs.answer_record import as_answer, as_read
from tests.report.test_page import data_of, item_with, unpacked

DRAWS_USUAL = True
SUIT = {
    "name": "suit",
    "spring": {"stiffness": ["2 kN/m", "3 kN/m"]},
    "spool": {"ratio": 0.4},
    "anchor": {"stiffness": "2 kN/m"},
    "load": {"mass": ["0 kg", "2 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 4}},
    "uncertainty": {"draws": 16},
    "design": {"verify": 100, "serve": 0.6},
}
PERSONS = "name,stature (cm),weight (kg),sex\nAda,168,60,f\nBo,181,80,m\nCy,175,70,m\n"
PROTOTYPES = [
    {"name": "P1", "sheath.friction": 0.06, "spring.flexor.stiffness": "2.9 kN/m"},
    {"name": "P2", "sheath.friction": 0.08, "spring.flexor.stiffness": "3.1 kN/m"},
]
CHANGES = {
    "suit": {},
    "survey": {"people": {"count": 12}},
    "file": {"people": {"file": "people.csv"}},
    "table": {
        "spring": {},
        "spool": {"ratio": [0.4, 0.45]},
        "table": [{"name": "prototype", "role": "draw", "rows": PROTOTYPES}],
    },
}


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """Return answers for draws alone, persons of a survey and of a file, and rows of a table."""
    folder = tmp_path_factory.mktemp("drawn")
    (folder / "people.csv").write_text(PERSONS)
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for kind, changed in CHANGES.items():
            found[kind] = tendon.design(SUIT | changed, folder / kind, jobs=1)
    return found


@pytest.fixture(params=CHANGES)
def answer(request, answers):
    return answers[request.param]


@pytest.fixture
def command(request):
    """Return a function that runs a command in this process."""
    return request.getfixturevalue("tendon")


def numbers_in_the_flexor(text):
    """Return the tensions in the flexor that a text names, N."""
    return [float(number) for number in re.findall(r"([\d.]+)\s+N\s+in\s+the\s+flexor", text)]


def names_the_setting(text, answer):
    """Return True if a text names the tension to set in the flexor, within its digits."""
    (setting, *_) = numbers_in_the_flexor(text)
    return setting == pytest.approx(answer.best["set_flexor_tension"], rel=6e-3)


# --- What is exported -----------------------------------------------------------------------------


def suit_of(row, **settings):
    """Return the stated study at the F0 of a row of choices, which no draw changes."""
    at_setting = {"tendon.pretension": row["pretension"]}
    at_setting["spring.stiffness"] = row["spring_stiffness"]
    return tendon.study(SUIT).vary(**at_setting, **settings)


@pytest.mark.parametrize("choice", [0, 1])
def test_a_controller_has_the_states_at_the_f0_of_the_choices(answers, choice, tmp_path):
    answer = answers["suit"]
    file = answer.export("controller", tmp_path / "c.csv", choice=choice)
    with file.open(newline="") as opened:
        heads, *rows = csv.reader(opened)
    assert heads[1:3] == ["load_mass (kg)", "elbow_angle (rad)"]
    written = np.array(rows, dtype=float)
    angles = answer.study.angles
    assert len(written) == 2 * 2 * len(angles)
    row = answer.choices.iloc[choice]
    for load in (0.0, 2.0):
        for sign in (1, -1):
            states = tendon.states(suit_of(row, **{"load.mass": load}), angles, sign == 1)
            kept = written[(written[:, 0] == sign) & (written[:, 1] == load)]
            for place, column in ((3, "motor_torque"), (4, "spool_angle")):
                np.testing.assert_allclose(kept[:, place], states[column], rtol=1e-9, atol=1e-9)


def test_a_state_page_has_the_torque_of_the_controller(answers, tmp_path):
    answer = answers["suit"]
    file = answer.export("controller", tmp_path / "c.csv")
    with file.open(newline="") as opened:
        _, first, *_ = csv.reader(opened)  # flexion, empty hand, 0 deg
    motion = {"motion.elbow_angle": 0.0, "motion.direction": "flexion", "load.mass": 0.0}
    page = tendon.state(suit_of(answer.best, **motion))
    torque = page.record["results"]["motor_torque"]
    assert float(first[3]) == pytest.approx(torque, rel=1e-9)


def test_a_model_for_mujoco_rests_at_the_f0_of_the_choices(answers, tmp_path):
    answer = answers["suit"]
    file = answer.export("mujoco", tmp_path / "suit.xml")
    exact = suit_of(answer.best, **{"sheath.friction": 0.0, "load.mass": 2.0})
    states = tendon.states(exact, np.radians([0.0, 45.0, 90.0]))
    keys = ET.fromstring(file.read_text()).iter("key")  # noqa: S314
    torques = [float(key.get("ctrl").split()[0]) for key in keys]
    np.testing.assert_allclose(torques, states["motor_torque"], rtol=1e-9, atol=1e-9)


def test_a_list_of_numbers_has_f0_and_says_which_is_a_reading(answer, tmp_path):
    file = answer.export("parameters", tmp_path / "p.csv")
    with file.open(newline="") as opened:
        listed = {row["name"]: row for row in csv.DictReader(opened)}
    best = answer.best
    for name in ("pretension", "pretension_from", "pretension_to", "set_flexor_tension"):
        assert float(listed[name]["value"]) == best[name]
        assert "as read" not in listed[name]["source"], name
    f0 = float(listed["flexor_model_pretension"]["value"])
    assert f0 == pytest.approx(best["pretension"], rel=1e-9)
    assert best["pretension"] < best["set_flexor_tension"]


# --- What is read back ----------------------------------------------------------------------------


def test_an_answer_that_is_opened_says_the_same(answer):
    opened = tendon.open(answer.folder)
    assert opened.short == answer.short
    assert opened.best == answer.best
    assert names_the_setting(opened.short, answer)
    data = opened.to_xarray()
    assert data["pretension"].sizes == data["set_flexor_tension"].sizes


def test_what_is_drawn_is_not_told_as_exact(answer):
    kinds = {entry["key"]: entry["kind"] for entry in answer.record["assumed"]}
    assert [key for key, kind in kinds.items() if kind == "exact"] == []
    assert {"spool.ratio", "tendon.flexor.length"} <= set(kinds)


def test_an_answer_passes_its_gate_and_has_not_moved_from_itself(answer):
    checked = tendon.check(answer.folder)
    assert checked.holds != answer.is_negative
    assert names_the_setting(checked.text, answer)
    again = tendon.check(answer.folder, answer.folder, tolerance=0.0)
    assert again.record["changes"] == []


def test_an_answer_is_equal_to_itself_and_says_what_to_set(answer):
    compared = tendon.compare(answer.folder, answer.folder)
    assert compared.record["is_equal"]
    assert names_the_setting(compared.text, answer)
    found = {quantity["name"]: quantity for quantity in compared.record["quantities"]}
    judged = answer.best["served_verified"]
    if judged is not None:
        assert found["served"]["a"] == found["served"]["b"] == judged["value"]
    read = as_read(as_answer(answer.record)).best
    for name in ("pretension", "pretension_from", "pretension_to"):
        if name in found:
            assert found[name]["a"] == found[name]["b"] == getattr(read, name)


def test_a_choice_is_compared_at_what_is_set(answers):
    answer = answers["suit"]
    compared = tendon.compare(answer, answer, choice=1)
    found = {quantity["name"]: quantity for quantity in compared.record["quantities"]}
    row = answer.choices.iloc[1]
    assert found["served"]["a"] == row["served_verified"]
    (setting, *_) = numbers_in_the_flexor(compared.text)
    assert setting == pytest.approx(row["set_flexor_tension"], rel=6e-3)


def test_draws_of_other_numbers_are_not_taken_for_the_same(answers):
    """Each number draws by its place among all: one more, and all draws are others."""
    known = SUIT | {"uncertainty": {"draws": 16, "exact": ["sheath.friction"]}}
    compared = tendon.compare(answers["suit"], tendon.design(known, jobs=1))
    assert not compared.record["paired"]
    assert compared.record["gained"] is None
    stiffer = SUIT | {"anchor": {"stiffness": "2.2 kN/m"}}
    assert tendon.compare(answers["suit"], tendon.design(stiffer, jobs=1)).record["paired"]


def test_the_title_of_its_drawings_says_what_to_set(answer):
    assert names_the_setting(answer.record["population"]["title"], answer)


def test_a_drawing_has_on_its_axis_what_the_axis_is_called(answer):
    figure = answer.plot("window")
    stars = [
        float(line.get_ydata()[0])
        for axes in figure.axes
        for line in axes.get_lines()
        if line.get_marker() == "*"
    ]
    is_reading = any("in the flexor" in axes.get_ylabel() for axes in figure.axes)
    column = "set_flexor_tension" if is_reading else "pretension"
    assert stars == [pytest.approx(answer.best[column])]


def test_a_page_has_the_states_at_the_f0_of_the_choices(answers, tmp_path):
    answer = answers["suit"]
    page = write_report(answer.folder, tmp_path / "page.html")
    groups = data_of(page)["states"]["groups"]
    group = item_with(groups, "label", "torque, load mass 2 kg")
    angles = answer.study.angles
    shown = unpacked(item_with(group["lines"], "label", "motor torque")["array"])
    shown = shown.reshape(2, 2, len(angles))  # (choices, directions, angles)
    for choice, row in answer.choices.iterrows():
        study = suit_of(row, **{"load.mass": 2.0})
        for direction, flexion in enumerate((True, False)):
            states = tendon.states(study, angles, flexion)
            expected = states["motor_torque"]
            np.testing.assert_allclose(shown[choice, direction], expected, rtol=1e-6)


def test_commands_read_an_answer_back(answer, command, workplace, blank_figures):
    for words in (
        ("check", answer.folder),
        ("compare", answer.folder, answer.folder, "--json"),
        ("show", answer.folder, "--json"),
        ("show", answer.folder, "--table", "conditions"),
        ("export", answer.folder, "choices.csv"),
        ("plot", answer.folder),
        ("report", answer.folder, "--out", "page.html"),
    ):
        done = command(*words)
        assert done.exit == 0, (words, done.err)
    with (workplace / "choices.csv").open(newline="") as opened:
        heads, first, *_ = csv.reader(opened)
    best = answer.choices.iloc[0]
    for column in ("pretension", "set_flexor_tension_from"):
        place = next(at for at, head in enumerate(heads) if head.partition(" ")[0] == column)
        assert float(first[place]) == pytest.approx(best[column])
    assert answer.short.partition(" in the flexor")[0] in joined(workplace / "page.html")


def joined(file):
    """Return the text of a page with one space for any stretch of white space."""
    return " ".join(file.read_text(encoding="utf-8").split())


def test_a_study_that_states_the_reading_is_another_study(tmp_path):
    study = SUIT | {"spring": {"stiffness": "2 kN/m"}}
    first = tendon.design(study, tmp_path / "a", jobs=1)
    assert tendon.design(study, tmp_path / "a", jobs=1).up_to_date
    second = tendon.design(study | {"setting": {"read": "flexor at joint"}}, jobs=1)
    assert second.best["pretension"] == pytest.approx(first.best["set_flexor_tension"])
    assert second.best["max_tension"] == pytest.approx(first.best["max_tension"])
    assert second.record["study_hash"] != first.record["study_hash"]
