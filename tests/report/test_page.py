"""The page of a run is whole in one file, safe, and true to the tables."""

import base64
import hashlib
import html
import json
import re
import shutil
import zlib
from importlib.resources import files

import numpy as np
import pyarrow.parquet as pq
import pytest

import tendon_cli as tendon
from tendon_cli.cube.axes import thin_axes
from tendon_cli.errors import InputError, UsageError
from tendon_cli.reports.data import pack_exact, pack_numbers
from tendon_cli.reports.report import write_report


def data_of(path):
    """Return the data in a page."""
    text = path.read_text(encoding="utf-8")
    script = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    return json.loads(script[1])


def unpacked(array):
    """Return the numbers that are packed for a page."""
    content = np.frombuffer(zlib.decompress(base64.b64decode(array["data"])), np.uint8)
    if array["type"] == "u1":
        return content.astype(float)
    size = int(array["type"][1])
    planes = np.ascontiguousarray(content.reshape(size, -1).T)
    bits = np.cumsum(planes.view(f"<u{size}").ravel(), dtype=f"<u{size}")
    return bits.view(f"<f{size}").astype(float)


def item_with(items, key, value):
    """Return the first item with this value of a key."""
    return next(item for item in items if item[key] == value)


@pytest.mark.parametrize("count", [0, 1, 100_000])
def test_packed_numbers_are_the_numbers(count):
    values = np.random.default_rng(1).normal(100.0, 30.0, count)
    values[::7] = np.nan
    np.testing.assert_array_equal(unpacked(pack_numbers(values)), values.astype("f4").astype(float))
    values[::11] = np.inf
    np.testing.assert_array_equal(unpacked(pack_exact(values)), values)


@pytest.mark.parametrize(
    ("lengths", "most"),
    [
        ((400, 400, 4), 700_000),
        ((3, 5000), 1000),
        ((1,), 5),
        ((2, 2, 2), 3),
        ((3,) * 6, 400),
        ((4, 3, 2), 1),
    ],
)
def test_thinning_keeps_both_ends_and_the_bound(lengths, most):
    kept = thin_axes(lengths, most)
    assert np.prod([len(positions) for positions in kept]) <= most
    for positions, length in zip(kept, lengths, strict=True):
        assert positions[0] == 0
        if len(positions) > 1:
            assert positions[-1] == length - 1


def test_the_maps_are_the_designs_of_the_run(swept, page_file):
    designs = tendon.open(swept).designs
    data = data_of(page_file)
    assert [len(axis["values"]) for axis in data["axes"]] == [9, 7, 2]
    margin = item_with(data["quantities"], "name", "margin")
    assert unpacked(margin["array"]) == pytest.approx(designs["margin"].to_numpy(), rel=1e-6)
    outcome = unpacked(data["quantities"][0]["array"])
    assert ((outcome == 0) == designs["feasible"].to_numpy()).all()
    assert ((outcome == 3) == ~designs["taut"].to_numpy()).all()


STUDIES = {
    "persons with a draw each": {
        "people": {"count": 5},
        "sheath": {"friction": {"mean": 0.07, "std": 0.005}},
        "uncertainty": {"draws": 8},
        "spring": {"stiffness": [3e3, 5e3]},
    },
    "draws": {"arm": {"b1": {"value": "150 mm", "tolerance": "5 %"}}, "uncertainty": {"draws": 4}},
    "cases, of a mixed model": {
        "cases": [
            {"name": "short", "arm": {"b1": 0.14}},
            {"name": "paper", "model": {"slack": "bilateral"}},
        ],
        "tendon": {"flexor": {"pretension": [90.0, 120.0]}},
    },
    "persons along an arm": {
        "people": {"count": 3},
        "arm": {"a1": {"from": 0.03, "to": 0.05, "num": 3}},
    },
}


@pytest.mark.parametrize("name", STUDIES)
def test_a_page_shows_the_states_of_its_run(tmp_path, name):
    motion = {"motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}}
    run = tendon.sweep(tendon.study(STUDIES[name] | motion), tmp_path / "run")
    data = data_of(write_report(tmp_path / "run"))
    (group,) = (
        group for group in data["states"]["groups"] if group["label"] == "tension at the motor"
    )
    for side, line in zip(("flexor", "extensor"), group["lines"], strict=True):
        tensions = run.states[f"{side}_tension_proximal"].to_numpy()
        assert unpacked(line["array"]) == pytest.approx(tensions, rel=1e-6, abs=1e-6)
    is_straight = run.states["elbow_angle"].to_numpy() == 0.0
    travels = run.states["flexor_travel"].to_numpy()[is_straight]
    one_direction = travels[::2]  # of two, with the same travel
    arm = {name: np.array(values) for name, values in data["arms"][0].items()}
    along = arm["b1"] + arm["b2"]
    straight_travel = along - np.hypot(along, arm["a1"] - arm["a2"])  # H_f(0)
    assert straight_travel == pytest.approx(one_direction, abs=1e-6)


def test_the_page_is_one_small_file_that_evaluates_nothing_and_a_title_with_a_script_is_a_title(
    page_file,
):
    text = page_file.read_text(encoding="utf-8")
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    assert "default-src 'none'" in policy
    assert "unsafe-eval" not in policy
    assert "unsafe-inline" not in policy.partition("script-src")[2].partition(";")[0]
    assert page_file.stat().st_size <= 5_000_000
    assert "<script>document.title" not in text
    assert "&lt;script&gt;document.title" in text


def test_what_is_no_run_or_a_damaged_one_is_refused(answered, tmp_path):
    with pytest.raises(InputError, match="is not a run folder"):
        write_report(tmp_path)
    folder = shutil.copytree(answered, tmp_path / "answer")
    (folder / "choices.parquet").write_bytes(b"PAR1")
    with pytest.raises(InputError, match="not as it was written"):
        write_report(folder)


def test_a_file_of_somebody_else_is_left_as_it_is(swept, tmp_path):
    strange = tmp_path / "page.html"
    strange.write_text("<html>mine</html>")
    with pytest.raises(UsageError, match="tendon did not write it"):
        write_report(swept, strange)
    assert strange.read_text() == "<html>mine</html>"
    assert write_report(swept, tmp_path / "new.html").stat().st_size > 0
    write_report(swept, tmp_path / "new.html")  # ours may be written again


def test_the_library_of_figures_is_the_one_that_was_published():
    """The file is that of version 4.1.1 of the npm package plotly.js-cartesian-dist-min, MIT."""
    library = files("tendon_cli.reports") / "plotly" / "plotly-cartesian-4.1.1.min.js"
    published = "79542150855a52c567260e3137095dbe2b744e6d702a5cabe67da246942fba7a"
    assert hashlib.sha256(library.read_bytes()).hexdigest() == published


def test_the_choices_of_an_answer_are_those_of_its_table(answered, answer_page):
    choices = pq.read_table(answered / "choices.parquet").to_pandas()
    data = data_of(answer_page)
    assert [len(axis["values"]) for axis in data["axes"]] == [4, 3]
    low = unpacked(data["design"]["columns"]["pretension_from"]["array"])
    assert low == pytest.approx(choices["pretension_from"].to_numpy(), rel=1e-6, nan_ok=True)
    conflict = item_with(data["quantities"], "name", "conflict")
    has_no_conflict = unpacked(conflict["array"]) == 0
    assert (has_no_conflict == choices["feasible"].to_numpy()[:12]).all()
    # A quantity that only some choices have is mapped all the same.
    assert choices["tolerance_length"].isna().any()
    mapped = unpacked(item_with(data["quantities"], "name", "tolerance_length")["array"])
    in_millimetres = 1e3 * choices["tolerance_length"].to_numpy()[:12]
    assert mapped == pytest.approx(in_millimetres, rel=1e-6, nan_ok=True)


def test_windows_are_what_the_gauge_shows_with_f0_in_the_table(tmp_path):
    study = {
        "spring": {"stiffness": ["4 kN/m", "5 kN/m"]},
        "spool": {"ratio": 0.6},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
        "sheath": {"friction": "0.07 +/- 0.01"},
        "uncertainty": {"draws": 16},
        "design": {"verify": 100},
    }
    answer = tendon.design(study, tmp_path / "answer", figures=False)
    assert answer.answer.question.shows_own_f0
    data = data_of(write_report(tmp_path / "answer"))
    shown = data["design"]["columns"]
    listed = {column["name"]: column for column in data["table"]["columns"]}
    for name, gauge in (
        ("pretension", "set_flexor_tension"),
        ("pretension_from", "set_flexor_tension_from"),
    ):
        assert unpacked(shown[name]["array"]) == pytest.approx(answer.choices[gauge], rel=1e-6)
        assert unpacked(listed[name]["array"]) == pytest.approx(answer.choices[name], rel=1e-6)


def test_the_states_of_a_choice_are_those_of_a_sweep_at_its_pretension(answered, answer_page):
    choice = pq.read_table(answered / "choices.parquet").to_pylist()[10]
    study = {
        "spring": {"stiffness": choice["spring_stiffness"]},
        "spool": {"ratio": choice["spool_ratio"]},
        "tendon": {"pretension": choice["pretension"]},
        "load": {"mass": 5.0},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}},
    }
    states = tendon.sweep(tendon.study(study)).states
    groups = data_of(answer_page)["states"]["groups"]
    group = item_with(groups, "label", "torque, load mass 5 kg")
    # (choices, directions, angles), N m
    shown = unpacked(group["lines"][1]["array"]).reshape(12, 2, 19)
    expected = states["motor_torque"].to_numpy().reshape(2, 19)
    assert shown[10] == pytest.approx(expected, rel=1e-6)


def test_a_choice_without_a_pretension_has_no_states(tmp_path):
    study = {
        "spring": {"stiffness": "4 kN/m"},
        "spool": {"ratio": [0.5, 0.6, 1]},
        "load": {"mass": ["0 kg", "25 kg"]},
        "limits": {"max_tension": "50 N"},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}},
    }
    tendon.design(study, tmp_path / "answer")
    choices = pq.read_table(tmp_path / "answer" / "choices.parquet").to_pandas()
    has_pretension = choices["pretension"].notna().to_numpy()
    assert 0 < has_pretension.sum() < 3
    for group in data_of(write_report(tmp_path / "answer"))["states"]["groups"]:
        for line in group["lines"]:
            shown = unpacked(line["array"]).reshape(3, -1)
            assert (np.isfinite(shown).any(axis=1) == has_pretension).all()


@pytest.mark.parametrize("name", ["max_spring_extension", "peak_motor_torque"])
def test_a_column_that_is_limited_comes_before_those_that_find_no_room(tmp_path, name):
    study = {
        "tendon": {"pretension": ["90 N", "150 N"]},
        "limits": {name: 1.0},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    }
    tendon.sweep(tendon.study(study), tmp_path / "run")
    names = [each["name"] for each in data_of(write_report(tmp_path / "run"))["quantities"]]
    assert names[1:3] == ["margin", name]


def test_a_map_opens_at_the_best_choice_or_at_a_feasible_design(
    swept, page_file, answered, answer_page
):
    designs = tendon.open(swept).designs
    start = np.ravel_multi_index(data_of(page_file)["start"], (9, 7, 2))
    assert designs["feasible"][start]
    record = json.loads((answered / "design.json").read_text(encoding="utf-8"))
    data = data_of(answer_page)
    for axis, place in zip(data["axes"], data["start"], strict=True):
        best = record["best"][axis["name"]]
        distance = np.abs(np.array(axis["values"]) * axis["factor"] - best)
        assert place == np.argmin(distance)


def test_the_persons_of_an_answer_are_served_as_it_says(answered_for_people):
    people = data_of(write_report(answered_for_people))["people"]
    served = unpacked(people["served"]["array"])
    assert len(served) == 60
    persons = tendon.open(answered_for_people).persons
    assert served.mean() == pytest.approx((persons["served"] >= 1.0).mean())
    assert 0 < served.sum() < 60
    assert "of 500 newly drawn persons" in people["title"]


def test_an_answer_that_serves_nobody_has_a_page(tmp_path):
    study = {"people": {"count": 3}, "load": {"mass": ["0 kg", "5 kg"]}}
    answer = tendon.design(tendon.study(study), tmp_path / "answer")
    assert not answer.feasible
    text = write_report(tmp_path / "answer").read_text(encoding="utf-8")
    assert "No tension in the flexor at the joint works" in text
    assert 'id="design-section"' not in text


def test_the_answer_of_a_page_is_that_of_the_terminal_without_its_80_columns(answered, answer_page):
    record = json.loads((answered / "design.json").read_text(encoding="utf-8"))
    text = answer_page.read_text(encoding="utf-8")
    answer = text[text.index('id="answer-section"') :].partition("</section>")[0]
    assert "<pre" not in answer
    words = html.unescape(re.sub(r"<[^>]*>", " ", answer.replace("<wbr>", "")))
    words = re.sub("[:;]", "", words).split()
    for word in set(re.sub("[:;]", "", record["text"]).split()):
        assert word in words, word
    first = " ".join(record["text"].partition("\n\n")[0].split())
    assert html.escape(first) in answer.replace("\u00a0", " ")
    assert not re.search(r"\d (?:N|mm|kg|deg)\b", answer), "a line may end before a unit"
    assert "<h3>Why</h3>" in answer
