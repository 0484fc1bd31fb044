"""Public functions: their examples run, they import quickly, and give what the tables hold."""

import doctest
import inspect
import json
import pickle
import pydoc
import re
import shutil
import signal
import sys
import threading
import time
import traceback
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.engine import plan as plan_module
from tendon_cli.engine.states import WorkedOut
from tendon_cli.errors import FolderError, InputError, StudyError, UsageError

DRAWS_USUAL = True  # examples show what their readers see
READINGS = Path(__file__).parents[1] / "configs/friction/table_a1.csv"
SUIT = READINGS.parents[1] / "suit"
NAMES = [name for name in tendon.__all__ if name != "__version__" and not name.endswith("Error")]
CONTENT = {
    "tendon": {"pretension": ["90 N", "150 N"], "flexor": {"length": ["1.8 m", "2 m", "2.1 m"]}},
    "load": {"mass": ["0 kg", "5 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 4}},
    "cases": [
        {"name": "tall", "arm": {"b1": "160 mm"}},
        {"name": "short", "arm": {"b1": "140 mm"}},
    ],
}


@pytest.fixture
def study():
    return tendon.study(CONTENT)


# --- Examples and cost ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_every_function_has_an_example_that_runs(name, workplace):
    (workplace / "study.toml").write_text("", encoding="utf-8")
    shutil.copy(READINGS, workplace / "readings.csv")
    shutil.copytree(SUIT, workplace, dirs_exist_ok=True)
    (found,) = doctest.DocTestFinder(recurse=False).find(getattr(tendon, name), name)
    assert found.examples
    found.globs.clear()
    said = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(found, out=said.append)
    assert not said, "".join(said)


def test_importing_it_loads_nothing_else(outside):
    code = (
        "import sys; before = set(sys.modules); "
        "import tendon_cli; print(*sorted(set(sys.modules) - before))"
    )
    loaded = outside("-c", code, python=True).out.split()
    assert loaded == ["tendon_cli", "tendon_cli.version"]


def test_its_names_stay_functions_whatever_else_is_imported(outside):
    code = """
import importlib, pkgutil, types
import tendon_cli as tendon
for module in pkgutil.walk_packages(tendon.__path__, "tendon_cli."):
    if not module.name.endswith(("__main__", "_native")):
        importlib.import_module(module.name)
functions = [name for name in tendon.__all__ if name != "arms"]
print([name for name in functions if isinstance(getattr(tendon, name), types.ModuleType)])
"""
    ran = outside("-c", code, python=True)
    assert (ran.out, ran.err) == ("[]\n", "")


# --- Runs -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("jobs", [1, 2])
def test_in_memory_and_in_a_folder_it_is_the_same(study, workplace, monkeypatch, jobs):
    monkeypatch.setattr(plan_module, "STATES_PER_PART", 24)
    monkeypatch.setattr(plan_module, "STATES_PER_FILE", 24)
    in_folder = tendon.sweep(study, "run", jobs)
    before = sorted(workplace.rglob("*"))
    in_memory = tendon.sweep(study, jobs=jobs)
    assert sorted(workplace.rglob("*")) == before
    opened = tendon.open("run")
    for run in (in_folder, opened):
        pd.testing.assert_frame_equal(run.designs, in_memory.designs)
        pd.testing.assert_frame_equal(run.states, in_memory.states)
    assert in_memory.designs.attrs["units"]["pretension"] == "N"
    assert opened.record == json.loads(Path("run/run.json").read_bytes())
    counted = (
        "designs",
        "states",
        "feasible",
        "slack",
        "unstable",
        "no_equilibrium",
        "warnings",
        "study_hash",
    )
    assert {key: opened.record[key] for key in counted} == {
        key: in_memory.record[key] for key in counted
    }


def test_a_run_that_stands_is_up_to_date_and_another_study_is_refused(study, workplace):
    assert not tendon.sweep(study, "run").up_to_date
    assert tendon.sweep(study, Path("run")).up_to_date
    with pytest.raises(FolderError):
        tendon.sweep(tendon.study({}), "run")
    assert tendon.sweep(tendon.study({}), "run", overwrite=True).record["designs"] == 1


def test_figures_are_drawn_where_they_are_asked_for(study, workplace):
    assert tendon.sweep(study, "run").record["figures"] == []
    assert tendon.sweep(study, "run", figures=True).record["figures"] == ["slack_map.png"]
    assert Path("run/slack_map.png").exists()


@pytest.mark.parametrize(
    ("call", "kind"),
    [
        (lambda: tendon.study({"load": {"mas": 1.0}}), StudyError),
        (lambda: tendon.study("none.toml"), StudyError),
        (lambda: tendon.open("none"), InputError),
        (lambda: tendon.fit_friction("none.csv", bend_angle="144 deg"), InputError),
        (lambda: tendon.sweep({}, figures=True), UsageError),
    ],
)
def test_what_is_wrong_is_raised_by_its_kind(workplace, call, kind):
    with pytest.raises(kind):
        call()


def test_a_traceback_names_the_file(workplace):
    (workplace / "suit.toml").write_text('tendon.pretension = "110 m"\n')
    (workplace / "note.txt").write_text("nothing")
    for call, place in (
        (lambda: tendon.sweep("suit.toml"), "suit.toml: the study has 1 fault:"),
        (lambda: tendon.study("none.toml"), "none.toml: no such file"),
        (lambda: tendon.open("note.txt"), "note.txt: this is a file"),
        (lambda: tendon.sweep({"tendon": {"pretension": "110 m"}}), "the study has 1 fault:"),
    ):
        with pytest.raises(tendon.TendonError) as caught:
            call()
        last = traceback.format_exception_only(caught.value)[0]
        assert last.partition(": ")[2].startswith(place)


@pytest.mark.parametrize("compute", [tendon.sweep, tendon.design])
def test_an_unknown_option_is_named_with_those_that_there_are(compute):
    with pytest.raises(UsageError, match='has no option "foo"') as refused:
        compute({}, foo=1)
    options = "study, out, jobs, figures, resume, overwrite, scheduler, progress, stop"
    assert refused.value.hint == f"it has {options}"
    for option in options.split(", "):
        assert f"{option}: " in pydoc.render_doc(compute)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "arms"])
def test_every_function_refuses_an_unknown_option_in_the_same_words(name):
    with pytest.raises(UsageError, match=rf'^{name}\(\) has no option "foo"$') as refused:
        getattr(tendon, name)({}, foo=1)
    first = next(iter(inspect.signature(getattr(tendon, name)).parameters))
    assert refused.value.hint.startswith(f"it has {first}")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Return a result of each kind that has a picture."""
    study = tendon.study({"load": {"mass": ["0 kg", "3 kg"]}, "spool": {"ratio": 0.6}})
    answer = tendon.design(study)
    return {
        "study": study,
        "state": tendon.state({}),
        "run": tendon.sweep(study),
        "answer": answer,
        "fit": tendon.fit_friction(READINGS, bend_angle="144 deg"),
        "comparison": tendon.compare(answer, answer),
    }


@pytest.mark.parametrize("kind", ["study", "state", "run", "answer", "fit", "comparison"])
def test_plot_of_any_result_refuses_an_unknown_option(results, kind):
    result = results[kind]
    for draw in (result.plot, lambda **how: tendon.plot(result, **how)):
        with pytest.raises(UsageError, match=r'^plot\(\) has no option "foo"$') as refused:
            draw(foo=1)
        assert refused.value.hint.startswith("it has result, what, out, overwrite")


@pytest.mark.parametrize("kind", ["study", "state", "run", "answer", "fit", "comparison"])
def test_a_session_completes_what_the_page_says_of_a_result(results, kind):
    page = (Path(__file__).parents[1] / "docs" / "python.md").read_text("utf-8")
    result = results[kind]
    of_a_file = {*getattr(type(result), "model_fields", ())}
    assert {*dir(result)} >= {"plot", "record", "text", *of_a_file}
    for name in {*dir(result)} - of_a_file:
        assert hasattr(result, name)
        assert re.search(rf"[`.]{name}[`(]", page), name


def test_a_function_is_pickled_by_its_public_name():
    for name in NAMES:
        function = getattr(tendon, name)
        if name != "arms":
            assert function.__name__ == name
            assert pickle.loads(pickle.dumps(function)) is function  # noqa: S301


def test_what_has_no_picture_is_refused():
    with pytest.raises(UsageError, match="cannot be drawn"):
        tendon.plot(3.0)


def test_designs_that_are_worked_out_are_those_of_the_table(study):
    run = tendon.sweep(study)
    worked_out = WorkedOut(run.study, kind="designs")
    assert worked_out.read().equals(run.table("designs"))
    columns = ["max_tension", "feasible"]
    assert worked_out.read(columns).equals(run.table("designs").select(columns))


def test_designs_that_the_study_leaves_out_are_told_and_states_are_worked_out(workplace):
    run = tendon.sweep(tendon.study({"output": {"tables": ["states"]}}))
    with pytest.raises(UsageError, match="designs"):
        run.designs  # noqa: B018
    without = tendon.sweep(tendon.study({"output": {"tables": ["designs"]}}), "few")
    for one in (without, tendon.open("few")):
        pd.testing.assert_frame_equal(one.states, run.states)


# --- Interrupts -----------------------------------------------------------------------------------


def held(monkeypatch):
    """Parts that take a while, and are many."""
    from tendon_cli.engine.sweep import Sweep

    fill = Sweep.fill
    monkeypatch.setattr(plan_module, "STATES_PER_PART", 1)
    monkeypatch.setattr(plan_module, "STATES_PER_FILE", 1)
    monkeypatch.setattr(plan_module, "DESIGNS_PER_PART", 1)
    busy = []

    def slowly(self, tables, index):
        busy.append(index)
        try:
            for _ in range(10):
                time.sleep(0.01)
                self.check_stopped()
            return fill(self, tables, index)
        finally:
            busy.pop()

    monkeypatch.setattr(Sweep, "fill", slowly)
    return busy


@pytest.mark.parametrize(
    ("jobs", "out", "how"),
    [(1, "run", "signal"), (4, "run", "raised"), (1, None, "raised"), (4, None, "signal")],
)
def test_an_interrupt_leaves_nothing_broken(study, workplace, monkeypatch, jobs, out, how):
    before = signal.getsignal(signal.SIGINT)
    with monkeypatch.context() as patch:
        busy = held(patch)

        def progress(done, _all):
            if done == 3:
                if how == "raised":
                    raise KeyboardInterrupt
                signal.raise_signal(signal.SIGINT)

        with pytest.raises(KeyboardInterrupt):
            tendon.sweep(study, out, jobs, progress=progress)
        assert not busy, "a thread is still at work"
        assert signal.getsignal(signal.SIGINT) is before
        if out is None:
            assert not list(workplace.iterdir())
            return
        left = [path for path in Path(out).rglob("*") if path.name.endswith(".tmp")]
        assert left == []
        for again in (lambda: tendon.sweep(study, out, jobs), lambda: tendon.open(out)):
            with pytest.raises(FolderError, match="unfinished"):
                again()
        resumed = tendon.sweep(study, out, jobs, resume=True)
        assert resumed.record["resumed_parts"] >= 3
        whole = tendon.sweep(study)
    pd.testing.assert_frame_equal(resumed.states, whole.states)


def test_an_interrupt_within_the_pool_leaves_nothing_at_work(study, workplace, monkeypatch):
    """A second Ctrl-C does this, and a notebook whose handler raises wherever the program is."""
    busy = held(monkeypatch)
    main = threading.main_thread().ident

    def interrupt(_number, _frame):
        raise KeyboardInterrupt

    timer = threading.Timer(0.02, signal.pthread_kill, (main, signal.SIGINT))
    before = signal.signal(signal.SIGINT, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):
            tendon.sweep(
                study, "run", 4, progress=lambda done, _all: timer.start() if done == 3 else None
            )
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
    assert not busy
    assert not [path for path in Path("run").rglob("*") if path.name.endswith(".tmp")]
    assert tendon.sweep(study, "run", 4, resume=True).record["designs"] == 24


def test_a_stop_of_the_callers_own_is_told(study, workplace, monkeypatch):
    from tendon_cli.errors import Stopped

    stop = threading.Event()
    stop.set()
    with pytest.raises(Stopped):
        tendon.sweep(study, "run", stop=stop)


# --- xarray ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("content", [CONTENT, {}, {**CONTENT, "output": {"tables": ["designs"]}}])
def test_a_dataset_has_the_axes_as_dimensions_and_agrees_value_by_value(content):
    run = tendon.sweep(tendon.study(content))
    found = run.to_xarray()
    tables = {"designs": run.designs}
    if "states" in run.record["study"]["output"]["tables"]:
        tables["states"] = run.states
    axes = ["case", "pretension", "tendon_length_flexor", "load_mass"] if content else []
    for table, frame in tables.items():
        dimensions = axes + (["direction", "elbow_angle"] if table == "states" else [])
        sizes = {name: found.sizes[name] for name in dimensions}
        assert np.prod(list(sizes.values()), dtype=int) == len(frame)
        for column in frame.columns:
            cell = found[column].expand_dims(
                {n: found[n] for n in dimensions if n not in found[column].dims}
            )
            values = cell.transpose(*dimensions).values.ravel()
            expected = frame[column].to_numpy()
            same = (values == expected) | (pd.isna(values) & pd.isna(expected))
            assert same.all(), column
            assert found[column].attrs["units"] == frame.attrs["units"][column]
    for axis in axes:
        assert found[axis].dims == (axis,)
    assert set(axes) <= set(found.coords)
    assert found.attrs["study_hash"] == run.record["study_hash"]


def test_a_coordinate_that_a_case_overrides_lies_along_the_cases():
    cases = [{"name": "tall", "spring": {"stiffness": "4 kN/m"}}, {"name": "short"}]
    data = tendon.sweep({**CONTENT, "cases": cases}).to_xarray()
    assert data.sel(case="tall")["spring_stiffness"].item() == 4000.0
    assert (data["spring_stiffness"].dims, data["spool_ratio"].dims) == (("case",), ())


def test_without_xarray_the_extra_is_named(study, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(UsageError) as told:
        tendon.sweep(study).to_xarray()
    assert "-m pip install xarray" in told.value.hint


def test_a_study_without_a_name_prints_as_a_study():
    assert repr(tendon.study({})).startswith("study\n")
    assert repr(tendon.study({"name": "suit"})).startswith("study suit\n")
    assert repr(tendon.study({"name": "suit", "title": "Mine"})).startswith("suit: Mine\n")
