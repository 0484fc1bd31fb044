"""The pages print what they say: every snippet of every page is run."""

import re
import shlex
from pathlib import Path

import pytest

from tests.docs.snippets import matches, run_page

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
SUIT = ROOT / "docs" / "from-model-to-suit.md"
JUDGED_BY_ALL = True
ALL_POINTS = True
LONG = ("tendon design robust.toml --no-figures",)
"""Commands that take half a minute; `make torture` types them, too."""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_prints_what_it_says(page, tmp_path):
    assert run_page(page.read_text(encoding="utf-8"), tmp_path, without=LONG) == []


@pytest.mark.torture
def test_a_page_with_a_long_command_prints_what_it_says(tmp_path):
    text = SUIT.read_text(encoding="utf-8")
    assert all(f"$ {command}\n" in text for command in LONG)
    assert run_page(text, tmp_path) == []


def test_the_suit_of_the_long_command_serves_the_share_that_its_page_says(outside):
    """The page gives a command that answers for this suit alone, on the same fresh persons.

    Few persons and draws are enough, since the share is that of the fresh persons.
    """
    text = SUIT.read_text(encoding="utf-8")
    alone = re.search(r"^    (tendon design robust.toml .*?)\n\n", text, re.MULTILINE | re.DOTALL)
    words = shlex.split(alone[1].replace("\\\n", " "))[1:]
    few = ("--set", "people.count=8", "--set", "uncertainty.draws=8")
    outside("init", "--for", "robust", "robust.toml")
    ran = outside(*words, *few)
    said = re.search(r"[\d.]+ % of\s+10,000 newly drawn persons \([\d.]+ to [\d.]+ %\)", text)[0]
    assert " ".join(said.split()) in " ".join(ran.out.split())


@pytest.mark.parametrize(
    ("expected", "printed", "same"),
    [
        ("a ... c\n", "a b c\n", True),
        ("a", "b", False),
        ("1.5 N", "1x5 N", False),
        ("a  \nb", "a\nb\n", True),
    ],
)
def test_outputs_are_compared_except_where_they_are_left_open(expected, printed, same):
    assert matches(expected, printed) is same


def test_a_wrong_page_is_noticed(tmp_path):
    page = "```python\nprint(1)\n```\n\n```text\n2\n```\n\n```console\n$ echo yes\nno\n```\n"
    assert len(run_page(page, tmp_path)) == 2
