"""Words of earlier versions are refused, and each says to use something that exists."""

import re
import shlex
from pathlib import Path

import pytest

import tendon_cli
from tendon_cli.commands import cli
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


def test_rows_and_samples_are_told_what_to_use_instead_too():
    key = "limits.max_backlash"
    rows = {"rows": [{"name": "a", key: 1}]}
    sample = {"between": {key: "1 to 2"}, "sample": "sobol", "count": 4}
    for table in (rows, sample):
        with pytest.raises(StudyError, match=IS_GONE):
            any_study({"table": [{"name": "suits", **table}]})
    with pytest.raises(StudyError, match="unknown key"):
        any_study({"table": [{"name": "suits", "rows": [{"name": "a", "1.2": 1}]}]})


MAKEFILE = (Path(__file__).parents[2] / "Makefile").read_text("utf-8")


def test_every_command_and_option_that_is_gone_is_refused_with_something_that_exists(tendon):
    for name, instead in cli.GONE.items():
        commands = ("init", "sweep", "design", "export") if name.startswith("-") else ("--debug",)
        for command in commands:
            ran = tendon(command, name)
            assert (ran.exit, instead in ran.err) == (2, True), name
        for line in IN_BACKTICKS.findall(instead):
            program, *words = shlex.split(line)
            if program == "make":
                assert f"\n{words[0]}:" in MAKEFILE
            else:
                assert words[-1] in tendon(*words[:-1], "--help").out


def test_every_name_that_is_gone_is_refused_with_one_that_exists():
    for name, instead in tendon_cli._GONE.items():
        with pytest.raises(AttributeError, match=rf"use tendon\.{instead}$"):
            getattr(tendon_cli, name)
        assert instead in tendon_cli.__all__
