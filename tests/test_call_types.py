"""An argument of another type is refused by its name, in every public function."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import UsageError

STUDY = {"motion": {"elbow_angle": "45 deg"}, "uncertainty": {"usual": False}}


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    return tendon.design(STUDY, tmp_path_factory.mktemp("calls") / "answer")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return tendon.sweep(STUDY, tmp_path_factory.mktemp("calls") / "run")


WRONG = {
    "choice": lambda it: tendon.compare(it.answer, it.answer, choice="1"),
    "stop": lambda _: tendon.sweep(STUDY, stop=5),
    "progress": lambda _: tendon.design(STUDY, progress=3),
    "resume": lambda _: tendon.sweep(STUDY, resume="yes"),
    "scheduler": lambda _: tendon.sweep(STUDY, scheduler=5),
    "worst": lambda it: tendon.check(it.run, worst="a"),
    "tolerance": lambda it: tendon.check(it.run, baseline=it.run, tolerance="a"),
    "apart": lambda it: tendon.check(it.run, baseline=it.run, apart=5),
    "case": lambda _: tendon.state(STUDY, case=5),
    "rows": lambda _: tendon.state(STUDY, rows=5),
    "reversal": lambda _: tendon.state(STUDY, reversal="up"),
    "settings": lambda _: tendon.study(STUDY, 5),
    "settings = a list": lambda _: tendon.study(STUDY, [5]),
    "to": lambda it: it.answer.export(["mujoco"], "suit.xml"),
    "overwrite": lambda it: it.answer.export("mujoco", "suit.xml", overwrite="no"),
    "logs": lambda _: tendon.fit_suit([]),
    "no log": lambda _: tendon.fit_suit(STUDY, []),
    "there is no log": lambda _: tendon.fit_friction([]),
}


@pytest.mark.parametrize("name", WRONG)
def test_an_argument_of_another_type_is_refused_by_its_name(run, answer, name):
    with pytest.raises(UsageError, match=name.partition(" = ")[0]):
        WRONG[name](SimpleNamespace(run=run, answer=answer))


def test_numbers_and_truths_of_numpy_are_taken(run, answer):
    assert tendon.compare(answer, answer, choice=np.int64(0)).text
    assert tendon.check(run, worst=np.int32(3), tolerance=np.float32(0.1)).text
    assert tendon.state(STUDY, reversal=np.bool_(True)).text
    assert tendon.sweep(STUDY, stop=threading.Event(), scheduler=None).text


def test_the_same_log_twice_is_refused(tmp_path):
    rows = "".join(f"{10 + load},{20 + load}\n" for load in range(20))
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text(f"cell 1 (N),cell 2 (N)\n{rows}")
    files = [tmp_path / "a.csv", tmp_path / "b.csv"]
    for given in (files, [str(file) for file in files]):
        with pytest.raises(UsageError, match="has the same readings as"):
            tendon.fit_friction(given, "144 deg")
