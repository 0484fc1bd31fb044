"""The pages print what they say: every snippet of every page is run."""

from pathlib import Path

import pytest

from docs.refresh import with_gaps
from docs.snippets import matches, run_page

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
JUDGED_BY_ALL = True
ALL_POINTS = True
DRAWS_USUAL = True


@pytest.mark.usefixtures("blank_figures")  # `make docs` draws those that pages show
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_prints_what_it_says(page, tmp_path):
    assert run_page(page.read_text(encoding="utf-8"), tmp_path) == []


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


def test_an_output_is_renewed_with_its_gaps():
    sentence = "Set 3 N:\n  works in\n  98.\n"
    setting = "  To set it  4 mm,\n             5\n"
    old = "Set 1 N:\n  works.\n...\n  To set it  2 mm\n...\nwritten in ... s\n"
    new = f"{sentence}\n  Why  x\n{setting}  More\nwritten in 0.7 s\n"
    renewed = with_gaps(old, new)
    assert renewed == f"{sentence}...\n{setting}...\nwritten in ... s\n"
    assert matches(renewed, new)
    assert with_gaps("a\n...\nnowhere\n", "a\nb\n") is None
