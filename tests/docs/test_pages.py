"""Documentation cannot lie: what it lists is what there is, and what it shows runs."""

import re
import shutil
import subprocess
from math import sin
from pathlib import Path

import pytest
import typer

import tendon_cli
from docs import figures, messages, reference
from tendon_cli import cli
from tendon_cli.errors import InterruptError, TendonError
from tendon_cli.studies.load import load_study, study_from
from tendon_cli.studies.study_file import read_toml
from tests.docs.snippets import FILE_NAME, blocks, write_file

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "tendon_cli"
README = (ROOT / "README.md").read_text()
PAGES = {page.name: page.read_text() for page in (ROOT / "docs").glob("*.md")}


MADE = {
    page: [image for _, _, image in figures.RECIPE.findall(text)]
    for page, text in {**PAGES, "README.md": README}.items()
}
"""Images that each page makes."""
ALL_MADE = {image.removeprefix("docs/") for images in MADE.values() for image in images}
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
    assert len(pairs) >= 8
    for name, file in pairs:
        assert any(
            re.search(rf"^ *(def|class) {name}\b", code, re.MULTILINE) for code in code_of(file)
        ), (name, file)


@pytest.mark.parametrize("page", ["README.md", *PAGES])
def test_every_study_that_is_shown_is_one(page, tmp_path, monkeypatch):
    """The page's own files are written; measured ones that it names are stood in for."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "me.csv").write_text("name,weight (kg)\nme,80\n", encoding="utf-8")
    text = README if page == "README.md" else PAGES[page]
    angles = range(-90, 181, 30)
    for key, name in re.findall(
        r'^(torque|excursion|trajectory) = "(\w+\.csv)"', text, re.MULTILINE
    ):
        if key == "torque":
            header = "angle (deg),torque (N m)"
            rows = [f"{angle},{angle / 3}" for angle in angles]
        elif key == "excursion":
            header = "angle (deg),flexor (mm),extensor (mm)"
            rows = [f"{angle},{angle / 3},{angle / 3}" for angle in angles]
        else:
            header = "time (s),angle (deg)"
            rows = [f"{step / 100},{20 * sin(step / 50)}" for step in range(300)]
        (tmp_path / name).write_text("\n".join([header, *rows]), encoding="utf-8")
    for name in set(re.findall(r'^file = "(\w+\.csv)"', text, re.MULTILINE)) - {"me.csv"}:
        for example in (ROOT / "configs").rglob(name):
            shutil.copy(example, tmp_path)
    shown = blocks(text)
    for block in shown:
        write_file(block)
    bases = re.findall(r'^extends = "(.+)"', text, re.MULTILINE)
    for block in shown:
        if block.kind != "toml" or re.search("(friction|fitted)_from", block.text):
            continue
        name = FILE_NAME.match(block.text)
        if name and name[1] in bases:
            continue  # A base may be half a study: it is read with the studies that extend it.
        if name:
            load_study(tmp_path / name[1])
        else:
            study_from(read_toml(block.text).content)


def test_the_suit_of_the_readme_is_that_of_the_demo():
    shown = re.search(r"```toml\n# file: suit.toml\n(.*?)```", README, re.DOTALL)[1]
    kept = (ROOT / "configs" / "suit.toml").read_text(encoding="utf-8")
    assert kept.endswith(f"\n\n{shown}")
    assert kept.count("\n\n") == 1
    assert "configs/suit.toml" in (ROOT / "Makefile").read_text(encoding="utf-8")


@pytest.mark.parametrize("first", ["README.md", "index.md"])
def test_the_way_to_a_set_suit_is_short(first):
    """Whoever begins with the README or the index sets a suit after 4,000 words at most."""
    pages = {"README.md": README, **PAGES}
    way = [pages[page] for page in (first, "install.md", "tutorial.md", "bench.md")]
    assert sum(len(page.split()) for page in way) <= 4000


def test_every_link_leads_somewhere():
    lost = []
    for page in ("README.md", "CONTRIBUTING.md", *PAGES):
        file = ROOT / page if (ROOT / page).exists() else ROOT / "docs" / page
        made = ALL_MADE if page == "gallery.md" else MADE.get(page, ())
        targets = re.findall(r"\]\(([^)#:]+)\)", file.read_text())
        there = {target for target in targets if (file.parent / target).exists()}
        lost += [(page, target) for target in targets if target not in there.union(made)]
    assert lost == []


def test_the_tables_of_reference_are_those_of_the_code():
    """`python docs/reference.py` writes them anew."""
    old = [page for page, text in PAGES.items() if reference.renewed(text) != text]
    assert old == []


def test_every_table_of_reference_has_its_place():
    placed = [match[2] for page in PAGES.values() for match in reference.MARKED.finditer(page)]
    options = {f"options {name}" for name in COMMANDS}
    assert sorted(placed) == sorted(({*reference.TABLES} - {"options"}) | options)
    assert [name for name in COMMANDS if f"\n## `tendon {name}" not in PAGES["commands.md"]] == []


def test_every_image_is_made_by_what_stands_above_it():
    """The gallery shows pictures of other pages, too."""
    for page, text in {"README.md": README, **PAGES}.items():
        shown = re.findall(r"!\[[^\]]*\]\((\S+?)\)", text)
        if page == "gallery.md":
            assert set(MADE[page]) <= set(shown) <= ALL_MADE
        else:
            assert MADE[page] == shown, page


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
    assert [name for name in (*errors, "arms") if name not in page] == []


def test_what_is_to_be_typed_keeps_its_signs():
    """Typographic dashes and quotes in a copied command would make it fail."""
    assert "smartquotes = False" in (ROOT / "docs/conf.py").read_text()


@pytest.fixture(scope="module")
def found():
    """Return the messages of the package, with their hints and kinds."""
    return messages.messages()


def test_the_page_of_questions_has_every_message(found):
    """Messages of a few known cases are in the list that the page is built with."""
    assert len(found) > 250
    patterns = [re.escape(message).replace(re.escape("..."), ".+") for message, _, _ in found]
    for known in (
        '"9" has no unit, expected a length such as "9 mm"',
        "--resume and --overwrite conflict",
        "144 may be degrees or radians, expected an angle",
        "holds an unfinished run",
        "the study has 2 faults:\n  arm.a1: too long",
        "stopped by SIGTERM; the parts that were finished are kept",
    ):
        assert any(re.match(pattern, known) for pattern in patterns), known
    sources = [
        *(message for message, _, _ in found),
        *(path.read_text() for path in PACKAGE.rglob("*.py")),
    ]
    plain = [re.sub(r"\W+", " ", source) for source in sources]
    for asked in re.findall(r"^\*\*`([^`]+)`", PAGES["questions.md"], re.MULTILINE):
        words = " ".join(re.sub(r"\W+", " ", asked.replace("...", " ")).split()[-2:])
        assert words == "No pretension" or any(words in source for source in plain), asked


def test_the_page_of_questions_says_kind_and_exit_of_every_error():
    kinds = messages.KINDS
    for error in TendonError.__subclasses__():
        code = "128 + signal" if error is InterruptError else error.exit
        assert kinds[error.__name__] == f"{error.kind}, exit {code}"


def test_a_message_is_listed_with_its_own_hint(found):
    """Two messages of one function have hints of their own."""
    hints = {message: hint for message, hint, _ in found}
    assert hints["another run is writing here"].startswith("wait for it")
    assert hints["cannot be locked: ..."] == ""
