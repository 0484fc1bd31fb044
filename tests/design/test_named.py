"""Readers join choices with the table of what only the whole answer knows of them."""

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.answers import choices as choices_module
from tendon_cli.cube.source import table_in
from tendon_cli.tables.named import open_choices

QUESTION = {
    "spring": {"stiffness": {"from": "2 kN/m", "to": "8 kN/m", "num": 5}},
    "spool": {"ratio": {"from": 0.5, "to": 0.7, "num": 4}},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "design": {"maximise": ["tolerance"], "minimise": ["max_tension"], "prove": ["3"]},
}


@pytest.fixture(scope="module", params=[20, 6], ids=["one part", "several"])
def answer(request, tmp_path_factory):
    """Yield an answer with a front, in one part or several."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(choices_module, "CHOICES_PER_PART", request.param)
        yield tendon.design(QUESTION, tmp_path_factory.mktemp("named") / "answer")


def frames(answer):
    """Return the choices as they are written, and the named ones, both by the row of the choice."""
    own = pd.read_parquet(answer.folder / "choices.parquet")
    named = pd.read_parquet(answer.folder / "named.parquet").set_index("choice")
    return own, named


def assert_same(left, right):
    """Check that two frames have the same values, NaN included."""
    pd.testing.assert_frame_equal(
        left.astype(object), right.astype(object), check_names=False, check_index_type=False
    )


def test_named_choices_stand_in_their_places_and_all_others_as_they_are(answer):
    own, named = frames(answer)
    joined = answer.choices
    assert 0 < len(named) < len(joined) == len(own)
    assert_same(joined.loc[named.index, named.columns], named)
    others = joined.index.difference(named.index)
    assert_same(joined.loc[others, own.columns], own.loc[others])
    assert set(joined.loc[others, "between_samples"]) == {"sampled"}
    assert not joined.loc[others, "on_front"].any()


def test_the_named_choices_are_those_of_the_record(answer):
    _, named = frames(answer)
    record = answer.record
    rows = [*record["front"], *record["proved"], record["best"]]
    assert set(named.index) == {row["choice"] for row in rows}
    assert 3 in named.index
    for row in rows:
        for column in ("pretension_from", "tolerance", "max_tension", "served"):
            assert named.loc[row["choice"], column] == row[column]
        assert named.loc[row["choice"], "between_samples"] == row["between_samples"]


def test_every_reader_joins_them(answer):
    joined = answer.choices
    file = answer.folder / "choices.parquet"
    for table in (table_in(answer.folder), table_in(file), open_choices(file)):
        assert table.schema.names == list(joined)
        read = table.read(["on_front", "tolerance"]).to_pandas()
        assert_same(read, joined[["on_front", "tolerance"]])
        assert_same(table.read(["on_front"]).to_pandas(), joined[["on_front"]])
    assert answer.choices.attrs["units"]["between_samples"] == "1"
    in_memory = tendon.design(QUESTION).choices
    assert_same(in_memory, joined)
    on_front = answer.to_xarray()["on_front"].to_numpy().astype(bool).ravel()
    np.testing.assert_array_equal(on_front, joined["on_front"].to_numpy())


def test_parts_do_not_depend_on_what_the_whole_says(answer, tmp_path):
    """The same choices under other goals have the same rows: a part knows nothing of the whole."""
    other = QUESTION | {"design": {"maximise": ["served"]}}
    own, _ = frames(answer)
    others, _ = frames(tendon.design(other, tmp_path / "other"))
    assert_same(own, others)
