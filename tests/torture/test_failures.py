"""Parts that fail are told of with where they stand on the axes, while all others come to their end."""

import pytest

from tendon_cli.engine import sweep as sweep_module

from .tools import PARTS, STATES, journalled, some, study_in

DESIGNS = 3
"""In each part."""
FAILING = {0, 17, 59}


@pytest.mark.parametrize("jobs", some([2], [1, 4]))
def test_all_parts_but_those_that_fail_are_kept_and_the_first_is_named(
    tendon, tmp_path, small_parts, monkeypatch, muttered, uninterrupted, hashes_in, jobs
):
    small_parts(STATES)
    place, state_rows = study_in(tmp_path / "place"), sweep_module.state_rows
    words = ("sweep", place / "study.toml", "--out", place / "run", "--no-figures", "--json", "--jobs", jobs)

    def fails(inputs, block, keys):
        if block.first_design // DESIGNS in FAILING:
            raise FloatingPointError("something odd")
        return state_rows(inputs, block, keys)

    with monkeypatch.context() as patch:
        patch.setattr(sweep_module, "state_rows", fails)
        ran = tendon(*words)
    error = ran.json["error"]
    assert (ran.exit, error["kind"], ran.err) == (6, "workers", "")
    assert f"{len(FAILING)} of {PARTS} parts failed" in error["message"]
    assert any(f"part {part} (designs {part * DESIGNS} to {part * DESIGNS + 2}" in error["message"] for part in FAILING)
    assert "tendon.pretension=" in error["message"]
    assert journalled(place / "run") == PARTS - len(FAILING)
    again = tendon(*words, "--resume")
    assert (again.exit, again.json["resumed_parts"]) == (0, PARTS - len(FAILING))
    assert hashes_in(place / "run") == uninterrupted
