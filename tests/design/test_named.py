"""Choices are one table, in which those that the answer names stand as it records them."""

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.answers import choices as choices_module
from tendon_cli.answers.tables import VERIFIED, flat
from tendon_cli.cube.source import table_in

QUESTION = {
    "spring": {"stiffness": {"from": "2 kN/m", "to": "8 kN/m", "num": 5}},
    "spool": {"ratio": {"from": 0.5, "to": 0.7, "num": 4}},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "design": {"maximise": ["tolerance"], "minimise": ["max_tension"], "prove": ["3"]},
}
DRAWN = QUESTION | {
    "sheath": {"friction": "0.07 +/- 0.02"},
    "uncertainty": {"draws": 16},
    "design": QUESTION["design"] | {"verify": 200},
}


@pytest.fixture(scope="module", params=["one part", "several", "draws"])
def answer(request, tmp_path_factory):
    """Yield an answer with a front, in one part or several."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(choices_module, "CHOICES_PER_PART", 20 if request.param == "one part" else 6)
        question = DRAWN if request.param == "draws" else QUESTION
        yield tendon.design(question, tmp_path_factory.mktemp("named") / "answer")


def rows_of(answer):
    """Return the choices that an answer names by their rows, with values as a table has them."""
    record = answer.answer
    rows = [*record.front, *record.proved, record.best]
    return {row.choice: flat(row) for row in rows}


def test_named_choices_are_those_of_the_record_and_of_others_nothing_is_judged(answer):
    choices = pd.read_parquet(answer.folder / "choices.parquet")
    named = rows_of(answer)
    assert 3 in named
    assert 0 < len(named) < len(choices) == 20
    for row, recorded in named.items():
        for column in choices.columns:
            value = recorded[column]
            if value is None:
                assert pd.isna(choices.loc[row, column]) or choices.loc[row, column] == "", column
            else:
                assert choices.loc[row, column] == value, column
    others = choices.drop(index=[*named])
    assert set(others["between_samples"]) == {"sampled"}
    assert not others["on_front"].any()
    assert others[[*VERIFIED]].isna().all(axis=None)


def test_the_table_is_that_of_every_reader(answer):
    choices = pd.read_parquet(answer.folder / "choices.parquet")
    for table in (table_in(answer.folder), table_in(answer.folder / "choices.parquet")):
        pd.testing.assert_frame_equal(table.read().to_pandas(), choices)
    pd.testing.assert_frame_equal(answer.choices, choices)
    pd.testing.assert_frame_equal(tendon.design(answer.study).choices, choices)
    on_front = answer.to_xarray()["on_front"].to_numpy().astype(bool).ravel()
    np.testing.assert_array_equal(on_front, choices["on_front"].to_numpy())


def test_nothing_is_left_of_the_parts_of_an_unfinished_run(answer):
    assert {item.name.partition(".")[0] for item in answer.folder.iterdir()} <= {
        *("", "choices", "conditions", "draws", "design"),
    }
