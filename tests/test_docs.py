"""Documentation cannot lie: what it lists is what there is, and what it shows runs."""

import re
import subprocess
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest
import typer

import tendon_cli
from tendon_cli import cli
from tendon_cli.quantities import OF_DESIGNS, OF_STATES, QUANTITIES
from tendon_cli.space.axis import split_side
from tendon_cli.studies.load import study_from
from tendon_cli.studies.reading import read_toml
from tendon_cli.studies.study import keys
from tendon_cli.units import UNITS

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
PAGES = {page.name: page.read_text() for page in (ROOT / "docs").glob("*.md")}


def script(name):
    """A script of the documentation, which is no package."""
    source = spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    module = module_from_spec(source)
    source.loader.exec_module(module)
    return module


FIGURES = script("figures")
COMMANDS = typer.main.get_command(cli.app).commands
COMMON_KEYS = [path for path in keys() if split_side(path)[1] is None]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_in_the_readme(command):
    assert f"`tendon {command}" in README


def test_the_page_for_contributors_names_modules_and_functions_that_there_are():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    sources = (file for ending in ("py", "h") for file in (ROOT / "tendon_cli").rglob(f"*.{ending}"))
    files = {f"/{file.relative_to(ROOT)}": file.read_text() for file in sources}
    for path in re.findall(r"`([a-z_/]+\.(?:py|h))`", text):
        assert [name for name in files if name.endswith(f"/{path}")], path
    for name, path in re.findall(r"`([\w.]+)`[^`()]{0,12}\(`([a-z_/]+\.py)`\)", text):
        definition = re.compile(rf"(?:def|class) {name.split('.')[-1]}\b")
        assert any(definition.search(code) for file, code in files.items() if file.endswith(f"/{path}")), (name, path)


@pytest.mark.parametrize("path", COMMON_KEYS)
def test_every_key_is_documented_with_its_meaning_and_column(path):
    row = next(line for line in PAGES["study.md"].splitlines() if line.startswith(f"| `{path}` |"))
    assert keys()[path].number.quantity.long_name in row
    assert f"`{keys()[path].column}`" in row


@pytest.mark.parametrize("column", [*OF_STATES, *OF_DESIGNS])
def test_every_result_is_documented_with_its_unit_and_meaning(column):
    quantity = QUANTITIES[column]
    assert f"| `{column}` | {quantity.unit} | {quantity.symbol} | {quantity.long_name} |" in PAGES["tables.md"]


@pytest.mark.parametrize(
    "unit", [unit.symbol for unit in UNITS.values() if unit.dimension in ("length", "force", "angle")]
)
def test_every_unit_is_documented(unit):
    assert f"`{unit}`" in PAGES["study.md"]


@pytest.mark.parametrize("page", ["README.md", *PAGES])
def test_every_study_that_is_shown_is_one(page, tmp_path, monkeypatch):
    """Files of curves that it names are stood in for."""
    monkeypatch.chdir(tmp_path)
    text = README if page == "README.md" else PAGES[page]
    for key, name in re.findall(r'^(torque|excursion) = "(\w+\.csv)"', text, re.MULTILINE):
        columns = "angle (deg),torque (N m)" if key == "torque" else "angle (deg),flexor (mm),extensor (mm)"
        rows = [",".join([str(angle)] + [str(angle / 3)] * columns.count(",")) for angle in range(-90, 181, 30)]
        (tmp_path / name).write_text("\n".join([columns, *rows]), encoding="utf-8")
    for block in re.findall(r"```toml\n(.*?)```", text, re.DOTALL):
        if "friction_from" not in block:
            study_from(read_toml(block).content)


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", *PAGES])
def test_every_link_leads_somewhere(page):
    file = ROOT / page if (ROOT / page).exists() else ROOT / "docs" / page
    for target in re.findall(r"\]\(([^)#:]+)\)", file.read_text()):
        is_made = any(image == target for _, _, image in FIGURES.RECIPE.findall(file.read_text()))
        assert is_made or (file.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES)
def test_the_tables_of_reference_are_those_of_the_code(page):
    """`python docs/reference.py` writes them anew."""
    assert script("reference").renewed(PAGES[page]) == PAGES[page]


@pytest.mark.parametrize("page", ["README.md", *PAGES])
def test_every_image_is_made_by_what_stands_above_it(page):
    text = README if page == "README.md" else PAGES[page]
    assert [image for _, _, image in FIGURES.RECIPE.findall(text)] == re.findall(r"!\[[^\]]*\]\((\S+?)\)", text)


def test_no_image_is_kept_but_that_of_the_readme():
    kept = subprocess.run(["git", "ls-files", "docs/images"], cwd=ROOT, check=False, capture_output=True, text=True)
    assert kept.returncode or kept.stdout.split() == ["docs/images/design.png"]


def test_a_figure_is_made_the_same_each_time(tmp_path):
    study = '```toml\n# file: study.toml\n[load]\nmass = "3 kg"\n```\n'
    page = tmp_path / "page.md"
    page.write_text(
        f"{study}<!-- made by: tendon plot --arm study.toml --out a.png -> a.png -->\n![An arm](made/arm.png)\n"
    )
    (made,) = FIGURES.make_figures(page)
    first = made.read_bytes()
    assert first.startswith(b"\x89PNG")
    FIGURES.make_figures(page)
    assert made.read_bytes() == first
    page.write_text(page.read_text().replace("--arm study", "--arm other"))
    with pytest.raises(subprocess.CalledProcessError):
        FIGURES.make_figures(page)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_a_section_with_its_options(command):
    section = PAGES["commands.md"].partition(f"\n## `tendon {command}")[2].partition("\n## ")[0]
    options = [name for parameter in COMMANDS[command].params for name in parameter.opts if name.startswith("--")]
    assert [name for name in options if f"`{name}" not in section] == []


def test_the_exit_codes_are_those_of_the_errors():
    from tendon_cli import errors

    kinds = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, errors.TendonError)]
    for kind in {kind for kind in kinds if kind is not errors.InterruptError}:
        assert re.search(rf"^\| {kind.exit} \|.*`{kind.kind}`", PAGES["commands.md"], re.MULTILINE)


def test_the_page_about_python_names_every_function():
    page = PAGES["python.md"]
    plain = {name for name in tendon_cli.__all__ if name.endswith("Error")} | {"__version__", "arms"}
    assert [name for name in tendon_cli.__all__ if name not in plain and f"`{name}(" not in page] == []
    assert [name for name in plain - {"__version__"} if name not in page] == []


def test_what_is_to_be_typed_keeps_its_signs():
    """Two dashes and quotes of a command would be turned into typographic ones, and a copied command would fail."""
    assert "smartquotes = False" in (ROOT / "docs/conf.py").read_text()


def test_who_walks_from_a_study_to_a_written_part_finds_every_name():
    """Files that CONTRIBUTING names are there, and what it says that a file has, the file has."""
    text = (ROOT / "CONTRIBUTING.md").read_text()
    package = ROOT / "tendon_cli"
    walk = text.partition("## From a study")[2].partition("\n## ")[0]
    pairs = re.findall(r"`(?:\w+\.)?(\w+)`(?:'s)? \(`([\w/]+\.py)`\)", walk)
    pairs += [(name, file) for file, name in re.findall(r"`([\w/]+\.py)` `(\w+)`", walk)]
    assert len(pairs) >= 8
    for name, file in pairs:
        source = next(path for path in (package / file, package / "engine" / file) if path.exists()).read_text()
        assert re.search(rf"^ *(def|class) {name}\b", source, re.MULTILINE), (name, file)
    for file in re.findall(r"`([a-z_]+(?:/[a-z_]+)*\.(?:py|h))`", text):
        assert list(package.rglob(file)), file


def test_the_page_of_questions_has_every_message():
    """What is printed in a few known cases stands in the list that the page is built with."""
    found = script("messages").messages()
    assert len(found) > 250
    said = [re.escape(message).replace(re.escape("..."), ".+") for message, _, _ in found]
    for known in ('"9" has no unit, expected a length such as "9 mm"', "--resume and --overwrite exclude each other",
                  "144 may be degrees or radians, expected an angle", "holds an unfinished run"):  # fmt: skip
        assert any(re.match(each, known) for each in said), known
    page = PAGES["questions.md"]
    for asked in re.findall(r"^\*\*`([^`]+)`", page, re.MULTILINE):
        words = re.sub(r"\W+", " ", asked.replace("...", " ")).split()[-2:]
        assert (
            any(" ".join(words) in re.sub(r"\W+", " ", m) for m, _, _ in found)
            or "No pretension" in asked
            or any(
                " ".join(words) in re.sub(r"\W+", " ", path.read_text()) for path in (ROOT / "tendon_cli").rglob("*.py")
            )
        ), asked
