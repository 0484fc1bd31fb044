"""Two results side by side: every number is the record's, and only paired shares are made anew."""

import json
import re

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers import paired
from tendon_cli.answers.paired import paired_interval, unpaired_interval
from tendon_cli.checks.compare import labels_of
from tendon_cli.errors import FolderError, InputError, UsageError
from tendon_cli.model.limits import LIMIT_NAMES
from tests.check.conftest import ANSWERED, STUDY, swept


@pytest.fixture(scope="session")
def suits(tmp_path_factory):
    """Return folders of answers for one load each: with a smaller spool, and with a larger one."""
    folder = tmp_path_factory.mktemp("suits")
    study = {
        "spring": {"stiffness": ["4 kN/m", "5 kN/m"]},
        "load": {"mass": ["0 kg", "5 kg"]},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    }
    found = {}
    for name, ratio in (("small", 0.6), ("large", 0.7)):
        tendon.design(study | {"name": name, "spool": {"ratio": ratio}}, folder / name)
        found[name] = folder / name
    return found


@pytest.fixture
def command(request):
    """Return a function that runs a command in this process."""
    return request.getfixturevalue("tendon")


def of(comparison, name):
    """Return a quantity of a comparison of two results."""
    return next(found for found in comparison.record["quantities"] if found["name"] == name)


# --- Answers --------------------------------------------------------------------------------------


MORE_IS_BETTER = {
    "tolerance_length": True,
    "max_tension": False,
    "max_spring_extension": False,
    "peak_motor_torque": False,
    "min_elbow_stiffness": True,
    "contact_width": False,
}
"""True for a quantity of an answer of which more is better, by what it does to suit and wearer."""


def test_less_load_and_more_room_are_better(suits):
    record = tendon.compare(suits["small"], suits["large"]).record
    found = {quantity["name"]: quantity for quantity in record["quantities"]}
    assert set(MORE_IS_BETTER) <= set(found)
    for name, is_more_better in MORE_IS_BETTER.items():
        before, now = (abs(found[name][side]) for side in ("a", "b"))
        assert before != now
        is_better = (now > before) == is_more_better
        assert found[name]["verdict"] == ("better" if is_better else "worse"), name


def test_every_number_of_an_answer_stands_in_its_record(suits, monkeypatch):
    def solve_again(*_):
        raise AssertionError("a window is solved again")

    monkeypatch.setattr("tendon_cli.engine.windows.solver.Solver.ends", solve_again)
    compared = tendon.compare(suits["small"], suits["large"])
    for key, folder in (("a", suits["small"]), ("b", suits["large"])):
        best = json.loads((folder / "design.json").read_text())["best"]
        for name in ("pretension_from", "pretension_to", "tolerance_length", "max_tension"):
            assert of(compared, name)[key] == best[name]
        assert compared.record["binds"][key]["lower"] == best["from_by"]
    assert of(compared, "tolerance_length")["verdict"] == "worse"
    assert compared.record["differences"] == [
        {"key": "spool.ratio", "a": 0.6, "b": 0.7, "unit": "1"}
    ]


def test_shares_of_the_same_persons_are_paired(answered):
    compared = tendon.compare(answered["v1"], answered["v2"])
    record = compared.record
    served = of(compared, "served")
    for key, name in (("a", "v1"), ("b", "v2")):
        best = json.loads((answered[name] / "design.json").read_text())["best"]
        assert served[key] == best["served_verified"]["value"]
    moved = record["gained"]["share"] - record["lost"]["share"]
    assert moved == pytest.approx(served["b"] - served["a"])
    low, high = served["interval"]
    assert low < served["b"] - served["a"] < high
    intervals = [
        json.loads((answered[name] / "design.json").read_text())["best"]["served_verified"]
        for name in ("v1", "v2")
    ]
    apart = unpaired_interval(
        served["a"], intervals[0]["interval_95"], served["b"], intervals[1]["interval_95"]
    )
    assert high - low < apart[1] - apart[0]
    assert record["paired"]
    assert any("computed again" in note for note in record["notes"])


def test_shares_of_other_persons_are_not_paired(answered):
    compared = tendon.compare(answered["v1"], answered["others"])
    assert not compared.record["paired"]
    assert compared.record["gained"] is None
    assert of(compared, "served")["interval"] is not None
    assert any("they draw different persons" in note for note in compared.record["notes"])


def test_the_same_choice_of_both_can_be_compared(suits):
    compared = tendon.compare(suits["small"], suits["large"], choice=1)
    for key, folder in (("a", suits["small"]), ("b", suits["large"])):
        row = tendon.open(folder).choices.iloc[1]
        assert row["spring_stiffness"] == 5000.0
        assert of(compared, "max_tension")[key] == row["max_tension"]
    with pytest.raises(UsageError, match="has no choice 2"):
        tendon.compare(suits["small"], suits["large"], choice=2)


def test_a_choice_that_the_other_answer_has_not_is_named(suits, tmp_path):
    study = {"name": "other", "spring": {"stiffness": ["6 kN/m", "7 kN/m"]}}
    other = tendon.design(study | {"motion": {"elbow_angle": ["0 deg", "90 deg"]}})
    with pytest.raises(UsageError, match=r"small has no choice 5, expected 0 to 1"):
        tendon.compare(tendon.open(suits["small"]), other, choice=5)
    with pytest.raises(UsageError, match=r"other has no choice with spring_stiffness 4000\.0"):
        tendon.compare(suits["small"], other, choice=0)


def test_an_answer_without_a_window_is_worse(suits):
    study = {
        "name": "none",
        "spring": {"stiffness": "1 kN/m"},
        "load": {"mass": ["0 kg", "10 kg"]},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    }
    compared = tendon.compare(suits["small"], tendon.design(study))
    assert of(compared, "tolerance_length")["verdict"] == "worse"
    assert of(compared, "max_tension")["verdict"] is None
    assert "none has no window" in " ".join(compared.record["notes"])


DRAWN = {
    "name": "before",
    "spring": {"stiffness": {"value": "5 kN/m", "tolerance": "20 %"}},
    "sheath": {"friction": {"mean": 0.08, "std": 0.02}},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "10 kg"]},
    "arm": {
        "b1": {"value": "150 mm", "tolerance": "4 %"},
        "elbow_radius": {"value": "45 mm", "tolerance": "3 %"},
    },
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "design": {"verify": 1000, "serve": 0.5},
}
"""A suit for uncertain numbers whose window is narrow."""


@pytest.fixture(scope="session")
def drawn(tmp_path_factory):
    """Return the answer for draws, and the one with a larger spool, in folders to be quoted."""
    folder = tmp_path_factory.mktemp("drawn")
    after = DRAWN | {"name": "after", "spool": {"ratio": 0.65}}
    return tendon.design(DRAWN, folder / "first one"), tendon.design(after, folder / "o'two")


def test_a_lost_draw_is_named_with_the_limit_that_loses_it(drawn):
    before, after = drawn
    compared = tendon.compare(before, after)
    lost = compared.record["lost"]
    pretension = of(compared, "pretension")["b"]
    rows = after.table("draws").to_pandas().set_index("draw")
    why = compared.record["why_lost"]
    assert [one["name"] for one in why] == lost["names"][: len(why)]
    assert len(why) == min(3, lost["count"]) > 0
    for one in why:
        row = rows.loc[one["name"]]
        assert row["served"] == 0.0
        end = "from" if pretension < row["pretension_from"] else "to"
        assert not row["pretension_from"] <= pretension <= row["pretension_to"]
        assert one["why"] == row[f"{end}_by"]
        assert f"after loses {one['name']}: {one['why']}" in " ".join(compared.text.split())


def test_the_limit_that_loses_is_the_one_that_no_longer_gains(drawn):
    before, after = drawn
    forth = tendon.compare(before, after).record
    back = tendon.compare(after, before).record
    assert forth["why_lost"]
    assert back["why_gained"] == forth["why_lost"]


def test_a_lost_person_is_named_too(answered, tmp_path):
    looser = ANSWERED | {"spool": {"ratio": 0.7}, "design": {"verify": 200, "serve": 0.6}}
    after = tendon.design(looser, tmp_path / "after")
    record = tendon.compare(answered["v1"], after).record
    assert record["lost"]["named"] > 0
    persons = after.persons.set_index("person")
    for one in record["why_lost"]:
        row = persons.loc[one["name"]]
        assert row["served"] == 0.0
        assert one["why"] in (row["from_by"], row["to_by"])


def test_a_new_person_who_is_lost_has_numbers_and_a_limit(answered):
    compared = tendon.compare(answered["v1"], answered["v2"])
    assert compared.record["lost"]["named"] == 0 < compared.record["lost"]["count"]
    (one,) = compared.record["why_lost"]
    assert " kg" in one["name"]
    assert one["why"] in LIMIT_NAMES
    said = f"v2 loses a new person with {one['name']}: {one['why']}"
    assert said in " ".join(compared.text.split())


def test_draws_of_another_seed_are_not_taken_for_the_same_by_their_names(drawn):
    before, _ = drawn
    other = tendon.design(DRAWN | {"uncertainty": {"seed": 2}})
    more = DRAWN | {"tendon": {"length": {"value": "1.9 m", "tolerance": "0.1 m"}}}
    for after in (other, tendon.design(more)):
        record = tendon.compare(before, after).record
        assert record["gained"] is record["lost"] is None
        assert record["why_gained"] == record["why_lost"] == []


# --- Intervals ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("gained", "lost"), [(0.05, 0.02), (0.004, 0.0), (0.3, 0.3)])
def test_the_interval_of_a_difference_holds_the_truth_as_often_as_it_says(gained, lost):
    random = np.random.default_rng(1)
    members = 500
    counts = random.multinomial(members, [gained, lost, 1.0 - gained - lost], size=2000)
    holds = 0
    for found_gained, found_lost, _ in counts / members:
        low, high = paired_interval(found_gained, found_lost, members)
        holds += low <= gained - lost <= high
    assert 0.93 < holds / len(counts) <= 1.0


def test_nobody_gained_or_lost_leaves_room_for_few(answered):
    low, high = paired_interval(0.0, 0.0, 10_000.0)
    assert low < 0.0 < high
    assert high < 1e-3


# --- Runs -----------------------------------------------------------------------------------------


def test_numbers_of_runs_are_those_of_their_tables(limited, tmp_path):
    limits = json.loads((limited / "run.json").read_text())["study"]["limits"]
    rougher = swept(
        tmp_path / "rougher",
        limits=limits,
        arm={"contact_width": "50 mm"},
        sheath={"friction": 0.1},
    )
    record = tendon.compare(limited, rougher).record
    before = tendon.open(limited).designs
    now = tendon.open(rougher).designs
    margin = next(found for found in record["quantities"] if found["name"] == "margin")
    moved = (now.margin - before.margin).abs()
    assert (margin["a"], margin["b"]) == (before.margin.min(), now.margin.min())
    assert margin["most"] == pytest.approx(moved.max())
    assert margin["rows"] == (moved > 0).sum()
    assert margin["where"]["pretension"] == before.pretension[moved.idxmax()]
    assert record["gained"]["count"] == (now.feasible & ~before.feasible).sum()
    assert record["lost"]["count"] == (before.feasible & ~now.feasible).sum()


def test_only_designs_in_both_runs_are_compared(plain):
    study = STUDY | {"tendon": {"pretension": ["80 N", "100 N", "500 N"]}}
    compared = tendon.compare(tendon.open(plain), tendon.sweep(study))
    assert any("4 designs in both" in note for note in compared.record["notes"])
    apart = tendon.sweep(STUDY | {"tendon": {"pretension": ["1 N", "2 N"]}})
    nothing = tendon.compare(tendon.open(plain), apart)
    assert nothing.record["quantities"] == []
    assert any("the runs share no design" in note for note in nothing.record["notes"])


# --- What is printed ------------------------------------------------------------------------------


def test_several_results_are_columns_of_one_table(answered, suits):
    folders = [*suits.values(), answered["v1"]]
    compared = tendon.compare(*folders)
    assert [side.label for side in compared.sides] == ["small", "large", "v1"]
    assert all(value is not None for value in compared.values("max_tension"))
    assert len(compared.record["comparisons"]) == 2
    assert max(map(len, compared.text.splitlines())) <= 80
    many = tendon.compare(*[suits["small"]] * 30)
    assert len({side.label for side in many.sides}) == 30


def test_names_from_studies_are_text_in_markdown(plain):
    case = {"name": "<b>|`x`[y](z)", "arm": {"b1": "120 mm"}}
    odd = tendon.sweep(STUDY | {"cases": [case]})
    markdown = tendon.compare(tendon.open(plain), odd).markdown
    assert "&lt;b&gt;" in markdown
    assert "<b>" not in markdown


def test_the_command_prints_one_of_three_forms_and_a_page(command, suits, tmp_path):
    words = ("compare", str(suits["small"]), str(suits["large"]))
    plain_text = command(*words)
    assert plain_text.exit == 0
    assert plain_text.out.startswith("large compared with small\n")
    done = command(*words, "--json")
    assert set(done.json) >= {"a", "b", "differences", "quantities", "binds", "gained", "lost"}
    assert "| spool.ratio | 0.6 | 0.7 |" in command(*words, "--markdown").out
    page = tmp_path / "page.html"
    assert command(*words, "--html", str(page)).exit == 0
    assert page.read_text().count("data:image/png") == 1
    assert command(*words, "--json", "--markdown").exit == 2


def test_a_comparison_has_a_short_repr_and_a_picture(suits, plain, limited):
    for compared in (
        tendon.compare(suits["small"], suits["large"]),
        tendon.compare(plain, limited),
    ):
        assert len(repr(compared).splitlines()) <= 15
        assert len(compared.plot().axes) == 1


# --- What cannot be compared ----------------------------------------------------------------------


def test_a_run_against_an_answer_ends_with_3(command, suits, plain):
    done = command("compare", str(plain), str(suits["small"]))
    assert done.exit == 3
    assert "holds an answer, which cannot be compared with a sweep" in done.err


def test_what_is_no_result_is_named(suits, tmp_path):
    with pytest.raises(InputError, match="is not a run folder"):
        tendon.compare(suits["small"], tmp_path)
    with pytest.raises(InputError, match="no such folder"):
        tendon.compare(tmp_path / "nowhere", suits["small"])
    with pytest.raises(UsageError, match="nothing to compare with"):
        tendon.compare(suits["small"])


def test_harmed_and_foreign_results_are_refused(suits, tmp_path, monkeypatch):
    import shutil

    harmed = tmp_path / "harmed"
    shutil.copytree(suits["small"], harmed)
    table = harmed / "choices.parquet"
    table.write_bytes(table.read_bytes()[:-40] + bytes(40))
    with pytest.raises(InputError, match="not as it was written"):
        tendon.compare(suits["small"], harmed)
    record = harmed / "design.json"
    record.write_text(record.read_text().replace('"small"', '"other"'))
    with pytest.raises(FolderError, match="not as tendon wrote it"):
        tendon.compare(suits["small"], harmed)
    monkeypatch.setattr("tendon_cli.tables.read.RESULTS_VERSION", 999)
    with pytest.raises(InputError, match="this tendon reads version 999"):
        tendon.compare(suits["small"], suits["large"])


def test_results_are_told_apart_by_name_or_folder_or_letter(suits):
    small = tendon.open(suits["small"])
    large = tendon.open(suits["large"])
    assert labels_of([small, large]) == ["small", "large"]
    assert labels_of([small, small]) == ["A", "B"]


def test_the_sample_of_another_seed_or_size_is_another_one(answered):
    study = tendon.open(answered["v1"]).study
    for key, value, reason in (
        ("people.seed", 2, "different persons"),
        ("design.verify", 100, "size"),
        ("sheath.friction", 0.07, "different numbers|different seeds"),
    ):
        varied = study.vary(**{key: value})
        found = paired._why_other_sample(study, varied)
        assert found is not None
        assert any(word in found for word in reason.split("|"))
    assert paired._why_other_sample(study, study.vary(**{"spool.ratio": 0.9})) is None


def test_runs_along_a_motion_in_time_are_compared_by_what_the_motor_does(tmp_path):
    time = np.arange(0.0, 4.0, 0.02)
    angle = 45.0 - 30.0 * np.cos(2.0 * np.pi * 0.5 * time)
    rows = "\n".join(f"{at:.2f},{value:.5f}" for at, value in zip(time, angle, strict=True))
    (tmp_path / "motion.csv").write_text(f"time (s),angle (deg)\n{rows}\n")
    motion = {"trajectory": str(tmp_path / "motion.csv"), "cutoff": "4 Hz"}
    runs = [
        tendon.sweep({"motion": motion, "spring": {"stiffness": stiffness}})
        for stiffness in ("3 kN/m", "6 kN/m")
    ]
    compared = tendon.compare(*runs)
    less_is_better = ("peak_motor_speed", "peak_motor_power", "motor_work_in", "rms_motor_torque")
    for name in (*less_is_better, "efficiency"):
        found = of(compared, name)
        values = [float(run.designs[name].iloc[0]) for run in runs]
        assert [found["a"], found["b"]] == pytest.approx(values)
        gains = values[1] > values[0] if name == "efficiency" else values[1] < values[0]
        assert found["verdict"] == ("better" if gains else "worse")
    assert "largest motor power" in compared.text
    assert "largest motor work  " in compared.text
    assert "motor work in" not in compared.text


def test_two_results_are_judged_in_a_column_and_three_by_signs(answered):
    """With v2 the tension is larger, which is worse."""
    two = tendon.compare(answered["v1"], answered["v2"]).text
    three = tendon.compare(answered["v1"], answered["v2"], answered["v1"]).text
    (in_two,) = re.findall(r"^  largest tension .*$", two, re.MULTILINE)
    (in_three,) = re.findall(r"^  largest tension .*$", three, re.MULTILINE)
    assert re.search(r"v1 +v2 +v2 is$", two, re.MULTILINE)
    assert in_two.endswith(" worse")
    assert " is\n" not in three
    assert re.search(r"N +[\d.]+ N - +[\d.]+ N =$", in_three)
