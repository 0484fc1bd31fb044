"""Sessions and notebooks: numbers of NumPy and pandas, short reprs, pictures, errors by kind."""

import base64
import re

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon

from .test_face import READINGS

ASKED = {
    "load": {"mass": [0, 5]},
    "spring": {"stiffness": [3000, 5000]},
    "limits": {"max_tension": "400 N"},
    "spool": {"ratio": 0.6},
    "motion": {"elbow_angle": ["20 deg", "80 deg"]},
}


@pytest.fixture(scope="module")
def results():
    return {
        "study": tendon.study(ASKED),
        "run": tendon.sweep(ASKED),
        "answer": tendon.design(ASKED),
        "fit": tendon.fit_friction(READINGS, bend_angle="144 deg"),
        "state": tendon.state(ASKED),
    }


# --- What is taken --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "mass",
    [range(0, 6, 5), np.array([0, 5]), np.array([0.0, 5.0]), pd.Series([0, 5]), (0, np.float32(5))],
)
def test_lists_and_numbers_of_other_libraries_are_those_of_a_file(mass):
    assert (
        tendon.study({"load": {"mass": mass}}).hash == tendon.study({"load": {"mass": [0, 5]}}).hash
    )


def test_a_study_is_a_path_a_dictionary_or_a_study(workplace):
    (workplace / "own.toml").write_text("[load]\nmass = [0, 5]\n", encoding="utf-8")
    content = {"name": "own", "load": {"mass": [0, 5]}}
    hashes = {
        tendon.sweep(given).record["study_hash"]
        for given in ("own.toml", content, tendon.study(content))
    }
    assert len(hashes) == 1
    for verb in (tendon.design, tendon.estimate, tendon.state):
        assert verb("own.toml")


def test_a_fit_stands_where_a_friction_goes(results):
    fit = results["fit"]
    study = tendon.study({"sheath": {"friction": fit, "extensor": {"friction": fit}}})
    assert study.sheath.friction.single == fit.friction
    assert study.uncertain["sheath.extensor.friction"].spread == pytest.approx(fit.standard_error)


def test_to_vary_a_study_is_to_write_another():
    study = tendon.study(ASKED)
    varied = study.vary(**{"load.mass": "3 kg", "tendon.flexor.length": ["1 m", "2 m"]})
    written = tendon.study(
        {**ASKED, "load": {"mass": "3 kg"}, "tendon": {"flexor": {"length": ["1 m", "2 m"]}}}
    )
    assert varied.hash == written.hash
    assert study.hash == tendon.study(ASKED).hash
    with pytest.raises(tendon.StudyError, match="did you mean"):
        study.vary(**{"load.mas": 3})


def test_states_on_arrays_are_those_of_a_sweep():
    angles = np.radians([[0.0, 33.0], [90.0, 33.0]])
    states = tendon.states({"load": {"mass": [0, 5]}}, angles, [True, False])
    run = tendon.sweep(
        {"load": {"mass": [0, 5]}, "motion": {"elbow_angle": ["0 deg", "33 deg", "90 deg"]}}
    )
    rows = run.states.set_index(["load_mass", "direction", run.states.elbow_angle.round(12)])
    at = [
        (load, way, angle)
        for load in (0.0, 5.0)
        for row in angles.round(12)
        for way, angle in zip(("flexion", "extension"), row, strict=True)
    ]
    for name in ("motor_torque", "extensor_slack"):
        np.testing.assert_allclose(
            states[name], rows.loc[at, name].to_numpy().reshape(2, 2, 2), rtol=1e-12
        )
    assert states["status"].ravel().tolist() == rows.loc[at, "status"].tolist()


def loop():
    study = {}
    study["load"] = study
    return study


@pytest.mark.parametrize(
    "content",
    [
        [],
        None,
        3,
        "text",
        (x for x in ()),
        {1: 2},
        {"load": None},
        {"load": {"mass": iter([1])}},
        loop(),
        {"load": {"mass": object()}},
        {"load": {"mass": np.array(["a"])}},
        {"load": {"mass": np.zeros((2, 2))}},
        {"load": {"mass": np.array([np.nan])}},
    ],
    ids=lambda content: type(content).__name__,
)
def test_what_is_no_study_is_a_fault_of_the_study(content):
    with pytest.raises(tendon.TendonError) as fault:
        tendon.study(content)
    assert (fault.value.kind, fault.value.exit) == ("study", 2)


@pytest.mark.parametrize("jobs", [-1, 0, 1.5, "2", True])
def test_a_count_of_jobs_is_one(jobs):
    for verb in (tendon.sweep, tendon.design, tendon.estimate):
        with pytest.raises(tendon.UsageError, match="jobs"):
            verb({}, jobs=jobs)


# --- What is shown --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["study", "run", "answer", "fit", "state"])
def test_every_result_has_a_short_repr_a_text_a_record_and_a_picture(results, name):
    result = results[name]
    assert len(repr(result).splitlines()) <= 15
    if name != "answer":  # which is shown and printed in short
        assert result.text.startswith(repr(result).splitlines()[0])
    assert "<" not in repr(result)
    assert str(result) == (result.short if name == "answer" else result.text)
    assert isinstance(result.record, dict)
    page = result._repr_html_()
    encoded = re.search(r"data:image/png;base64,([^\"]+)", page)
    assert base64.b64decode(encoded[1])[:4] == b"\x89PNG"
    assert page.count("<pre ") == 1
    assert len(page) < 70_000


def test_a_run_and_an_answer_are_opened_and_drawn_from_their_folders(workplace):
    tendon.sweep(ASKED, "run")
    tendon.design(ASKED, "answer")
    run = tendon.open("run")
    answer = tendon.open("answer")
    assert run.record["designs"] == 4
    assert answer.record["choices"] == 2
    assert run.plot("motor_torque", "elbow_stiffness", where="load_mass = 5 kg").axes
    assert answer.plot("window")._repr_png_()[:4] == b"\x89PNG"
    assert tendon.report(answer).name == "report.html"
    assert tendon.check(run).record
    assert tendon.check(run, run).holds
    for missing in ("none", "run/designs.parquet"):
        with pytest.raises(tendon.InputError):
            tendon.open(missing)


@pytest.mark.parametrize(
    ("name", "what", "hint"),
    [
        ("answer", "windw", "window"),
        ("run", "motor_torqe", "motor_torque"),
        ("study", "x", "angles"),
    ],
)
def test_what_cannot_be_drawn_is_refused_with_what_can(results, name, what, hint):
    with pytest.raises(tendon.UsageError) as fault:
        results[name].plot(what)
    assert hint in fault.value.hint


def test_a_result_in_memory_has_no_page(results):
    with pytest.raises(tendon.UsageError, match="in memory"):
        tendon.report(results["run"])


@pytest.mark.parametrize(
    ("name", "b1"), [("paper", 0.15), ("mean_man", 0.15), ("mean_woman", 0.139)]
)
def test_an_arm_has_a_source_and_stands_in_a_study(name, b1):
    arm = getattr(tendon.arms, name)
    assert arm.source in repr(arm)
    assert tendon.study({"arm": arm}).arm.b1.single == pytest.approx(b1, rel=0.01)
    with pytest.raises(AttributeError, match="mean_man"):
        tendon.arms.nobody  # noqa: B018


@pytest.mark.parametrize(
    "goals",
    [{}, {"minimise": ["pretension"]}, {"minimise": ["pretension"], "maximise": ["tolerance"]}],
)
def test_the_best_is_one_row_and_the_best_by_goal_a_table(goals):
    asked = {
        "spool": {"ratio": [0.5, 0.6, 0.7]},
        "spring": {"stiffness": [5000, 8000]},
        "load": {"mass": [0, 10]},
    }
    answer = tendon.design({**asked, "design": goals})
    assert (
        answer.best["pretension_from"] <= answer.best["pretension"] <= answer.best["pretension_to"]
    )
    assert (answer.best_by["feasible"]).all()
    assert answer.best_by.attrs == answer.choices.attrs
    assert answer.best_by.attrs["units"]["pretension"] == "N"
    assert {"pretension"} <= set(answer.best_by.index)


def test_without_a_window_nothing_is_the_best():
    motion = {"elbow_angle": "60 deg", "direction": "flexion"}
    answer = tendon.design({"limits": {"max_tension": "10 N"}, "motion": motion})
    assert answer.best is None
    assert len(answer.best_by) == 0


def test_an_answer_as_a_dataset_agrees_with_its_table():
    asked = {
        "spool": {"ratio": [0.5, 0.6]},
        "spring": {"stiffness": [5000, 8000, 9000]},
        "load": {"mass": [0, 10]},
    }
    answer = tendon.design(asked)
    data = answer.to_xarray()
    assert data["window_from"].dims == ("spool_ratio", "spring_stiffness", "condition")
    both = data["window_from"].max("condition"), data["window_to"].min("condition")
    for name, ends in zip(("pretension_from", "pretension_to"), both, strict=True):
        np.testing.assert_allclose(ends, data[name].transpose(*ends.dims), rtol=1e-12)
    empty = tendon.design({**asked, "load": {"mass": 0}}).to_xarray()
    np.testing.assert_allclose(
        data["window_to"].isel(condition=0), empty["pretension_to"], rtol=1e-12
    )
    assert data["condition_load_mass"].values.tolist() == answer.conditions.load_mass.tolist()
    assert data["pretension_from"].attrs["units"] == "N"
    assert data["pretension_from"].attrs["long_name"] == "smallest pretension"
