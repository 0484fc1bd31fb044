"""Helpers of the tests of commands: studies to run them with, and words that set keys."""

import pytest


def set_options(*settings):
    """Return the words of a command line that set keys of a study, `--set` before every setting."""
    words = []
    for setting in settings:
        words += ["--set", setting]
    return words


@pytest.fixture
def write_study(workplace):
    """Return a function that writes a text into `study.toml` and returns that path."""

    def write(text):
        file = workplace / "study.toml"
        file.write_text(text, encoding="utf-8")
        return file

    return write
