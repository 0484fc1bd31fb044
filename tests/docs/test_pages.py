"""Documentation cannot lie: what it lists is what there is, and what it shows runs."""

import re
import subprocess
from pathlib import Path

import pytest
import typer

import tendon_cli
from docs import figures, reference
from tendon_cli.commands import cli
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.studies.contents import column_of, keys
from tendon_cli.studies.json_schema import key_words
from tendon_cli.studies.space.axis import split_side
from tests.answers import answered, merged

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "tendon_cli"
README = (ROOT / "README.md").read_text()
PAGES = {page.name: page.read_text() for page in (ROOT / "docs").glob("*.md")}


MADE = {
    page: [image for _, _, image in figures.RECIPE.findall(text)]
    for page, text in {**PAGES, "README.md": README}.items()
}
"""Images that each page makes."""
LOOK_UP = ("study.md", "tables.md", "commands.md", "python.md")
UNDERSTAND = ("design.md", "how-it-answers.md", "physics.md", "friction-fit.md", "does-not.md")
COMMANDS = typer.main.get_command(cli.app).commands


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_in_the_readme(command):
    assert f"`tendon {command}" in README or f"$ tendon {command} " in README


def test_the_page_for_contributors_names_modules_and_functions_that_there_are():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    sources = {
        path.as_posix(): path.read_text()
        for ending in ("py", "h")
        for path in PACKAGE.rglob(f"*.{ending}")
    }

    def code_of(name):
        return [code for path, code in sources.items() if path.endswith(f"/{name}")]

    for file in re.findall(r"`([a-z_/]+\.(?:py|h))`", text):
        assert code_of(file), file
    pairs = re.findall(r"`(?:\w+\.)?(\w+)`[^`()]{0,12}\(`([a-z_/]+\.py)`\)", text)
    pairs += [(name, file) for file, name in re.findall(r"`([\w/]+\.py)` `(\w+)`", text)]
    assert pairs
    for name, file in pairs:
        assert any(
            re.search(rf"^ *(def|class) {name}\b", code, re.MULTILINE) for code in code_of(file)
        ), (name, file)


def test_the_suit_of_the_readme_is_that_of_the_demo():
    shown = re.search(r"```toml\n# file: suit.toml\n(.*?)```", README, re.DOTALL)[1]
    kept = (ROOT / "configs" / "suit.toml").read_text(encoding="utf-8")
    assert kept.endswith(f"\n\n{shown}")
    assert kept.count("\n\n") == 1
    assert "configs/suit.toml" in (ROOT / "Makefile").read_text(encoding="utf-8")


def test_no_page_is_longer_than_a_reader_has_time_for():
    """Most words of each page, and of all; those to look things up in may be longer."""
    words = {name: len(text.split()) for name, text in PAGES.items()}
    words["README.md"] = len(README.split())
    words["CONTRIBUTING.md"] = len((ROOT / "CONTRIBUTING.md").read_text().split())
    words["CHANGELOG.md"] = len((ROOT / "CHANGELOG.md").read_text().split())
    words["understand"] = sum(words[name] for name in UNDERSTAND)
    words["docs"] = sum(words[name] for name in PAGES)
    most = {"docs": 24_000, "understand": 5_000, "tutorial.md": 1_500, "README.md": 1_300}
    most |= {"CONTRIBUTING.md": 1_500, "CHANGELOG.md": 1_200}
    most |= dict.fromkeys({*PAGES} - {*UNDERSTAND, *LOOK_UP, "tutorial.md"}, 800)
    assert {name: words[name] for name, bound in most.items() if words[name] > bound} == {}


def test_every_link_leads_somewhere():
    lost = []
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    for page in (*pages, *ROOT.glob("docs/*.md"), *ROOT.glob("verification/*.md")):
        targets = {*re.findall(r"\]\(([^)#:]+)[)#]", page.read_text())}
        made = MADE.get(page.name, ())
        lost += [each for each in targets.difference(made) if not (page.parent / each).exists()]
    assert lost == []


def test_the_tables_of_reference_are_those_of_the_code():
    """`python docs/refresh.py` writes them anew."""
    old = [page for page, text in PAGES.items() if reference.renewed(text) != text]
    assert old == []


def test_every_column_of_every_table_is_on_a_page():
    """Columns of axes are named by their keys, which a table of reference lists."""
    suit = {"load": {"mass": ["0 kg", "3 kg"]}, "motion": {"elbow_angle": ["0 deg", "90 deg"]}}
    few = {"design": {"verify": 100, "serve": 0.5}, "uncertainty": {"draws": 4}}
    people = {"people": {"count": 8, "seed": 1}, "sheath": {"friction": "0.07 +/- 0.01"}}
    results = [
        tendon_cli.sweep({**suit, "motion": {"speed": "60 deg/s"}}),
        answered(merged(suit, few, {"sheath": {"friction": "0.07 +/- 0.01"}})),
        answered(merged(suit, few, people)),
    ]
    known = {column_of(key) for key in keys()} | {*DIMENSIONS, "draw", "person"}
    text = PAGES["tables.md"]
    for result in results:
        for name in (*result.tables, *result.table_files):
            for column in result.table(name.removesuffix(".parquet")).schema.names:
                stem = re.sub("_(motor|low|high)$", "", column)
                assert column in known or f"`{column}`" in text or f"`{stem}`" in text, column


def test_every_key_of_a_study_is_on_its_page():
    """A side overrides the common key, and a curve written out has the columns of its file."""
    page = PAGES["study.md"]
    for key in key_words():
        _, side = split_side(key)
        curve = key.rpartition(".")[0]
        in_a_table = f"`{key.rpartition('.')[2]}`" in page
        assert side or in_a_table or f"`{key}`" in page or f"`{curve}`" in page, key


def test_every_table_of_reference_has_its_place():
    placed = [match[2] for page in PAGES.values() for match in reference.MARKED.finditer(page)]
    options = {f"options {name}" for name in COMMANDS}
    assert sorted(placed) == sorted(({*reference.TABLES} - {"options"}) | options)
    assert [name for name in COMMANDS if f"\n## `tendon {name}" not in PAGES["commands.md"]] == []


def test_every_image_is_made_by_what_stands_above_it():
    for page, text in {"README.md": README, **PAGES}.items():
        assert MADE[page] == re.findall(r"!\[[^\]]*\]\((\S+?)\)", text), page


def test_every_page_of_html_that_a_page_links_to_is_made():
    for text in PAGES.values():
        made = [link for _, _, link in figures.PAGE.findall(text)]
        assert made == re.findall(r'<a href="(\S+?)">', text)


def test_no_image_is_kept_but_that_of_the_readme():
    kept = subprocess.run(
        ["git", "ls-files", "docs/images"], cwd=ROOT, check=False, capture_output=True, text=True
    )
    assert kept.returncode or kept.stdout.split() == ["docs/images/slack_map.png"]


def test_a_figure_is_made_the_same_each_time(tmp_path):
    study = '```toml\n# file: study.toml\n[load]\nmass = "3 kg"\n```\n'
    page = tmp_path / "page.md"
    comment = "<!-- made by: tendon plot --arm study.toml --out a.png -> a.png -->"
    page.write_text(f"{study}{comment}\n![An arm](made/arm.png)\n")
    (made,) = figures.make_figures(page)
    first = made.read_bytes()
    assert first.startswith(b"\x89PNG")
    figures.make_figures(page)
    assert made.read_bytes() == first
    page.write_text(page.read_text().replace("--arm study", "--arm other"))
    with pytest.raises(subprocess.CalledProcessError):
        figures.make_figures(page)


def test_the_page_about_python_names_every_function():
    page = PAGES["python.md"]
    errors = {name for name in tendon_cli.__all__ if name.endswith("Error")}
    functions = {*tendon_cli.__all__} - errors - {"__version__", "arms"}
    assert [name for name in functions if f"`{name}(" not in page] == []
    assert [name for name in errors if f"`{name}`" not in page + PAGES["commands.md"]] == []


def test_what_is_to_be_typed_keeps_its_signs():
    """Typographic dashes and quotes in a copied command would make it fail."""
    assert "smartquotes = False" in (ROOT / "docs/conf.py").read_text()
