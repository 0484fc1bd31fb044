"""Keys that a study no longer has: what each says to use instead exists."""

import re

import pytest

from tendon_cli.errors import StudyError
from tendon_cli.quantities import OF_DESIGNS, OF_STATES
from tendon_cli.studies.design_section import CHOICE_RESULTS
from tendon_cli.studies.gone import GONE, IS_GONE
from tendon_cli.studies.json_schema import key_words
from tendon_cli.studies.load import any_study

LISTS = ("table", "figures", "cases")
"""Keys of a study that are lists of tables."""
IN_BACKTICKS = re.compile("`([^`]+)`")


def test_every_key_that_is_gone_is_refused_with_something_that_exists():
    known = {*key_words(), *OF_STATES, *OF_DESIGNS, *CHOICE_RESULTS}
    for key, instead in GONE.items():
        table, _, name = key.partition(".")
        content = {name: "1"} if name else "1"
        with pytest.raises(StudyError) as raised:
            any_study({table: [content] if table in LISTS else content})
        assert (IS_GONE, instead) in [(one.problem, one.hint) for one in raised.value.faults], key
        assert set(IN_BACKTICKS.findall(instead)) <= known, key
