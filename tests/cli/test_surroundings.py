"""A command imports no library before it needs it, and nothing from the folder it starts in."""

import json
import os
import re
import shutil
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import tendon_cli
from tendon_cli.verbs.registry import KINDS

HEAVY = ("numpy", "pandas", "pyarrow", "scipy", "matplotlib", "joblib", "distributed")
LOADED = """
import contextlib, io, json, sys
from tendon_cli.commands import cli
with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):
    cli.main(sys.argv[1:])
print(json.dumps(sorted(sys.modules)))
"""
QUICK_START = {
    "OPENBLAS_NUM_THREADS": "1",
    "PYDANTIC_DISABLE_PLUGINS": "__all__",
    "ARROW_DEFAULT_MEMORY_POOL": "system",
}
"""Variables of the environment that a quick start sets."""


def loaded_after(outside, *words):
    """Return the names of the modules that a command has imported."""
    return json.loads(outside("-c", LOADED, *words, python=True).out)


@pytest.mark.parametrize("words", [["--help"], ["sweep", "--help"], ["--version"], ["swoop"]])
def test_help_imports_none_of_the_heavy_libraries_and_reads_no_study(outside, words):
    needless = (*HEAVY, "tendon_cli.studies.", "tendon_cli.engine.", "tendon_cli.answers.")
    of_kinds = [name.rpartition(".")[0] for name in KINDS]
    loaded = loaded_after(outside, *words)
    assert [name for name in loaded if name.startswith(needless) and name not in of_kinds] == []


def test_a_small_sweep_without_figures_imports_only_what_it_needs(outside, workplace, write_study):
    write_study("[load]\nmass = [0.0, 3.0]\n")
    loaded = loaded_after(outside, "sweep", "study.toml", "--no-figures")
    assert [name for name in HEAVY if name in loaded] == ["numpy", "pyarrow"]
    assert not {"tendon_cli.engine.cost", "tendon_cli.figures", "rich"} & set(loaded)
    assert (workplace / "results/study/run.json").exists()


def test_what_is_said_of_a_run_needs_no_library_that_draws(outside, tendon, write_study):
    write_study("")
    assert tendon("sweep", "study.toml", "--no-figures").exit == 0
    for command in ("check", "report"):
        loaded = loaded_after(outside, command, "results/study")
        assert [name for name in HEAVY if name in loaded] == ["numpy", "pyarrow"]


SHOW_VARIABLES = f"""
import os
from tendon_cli.commands.startup import spare_time

spare_time()
print(*map(os.getenv, {list(QUICK_START)}))
"""


@pytest.mark.parametrize("given", [{}, dict.fromkeys(QUICK_START, "0")])
def test_what_the_environment_says_counts_more_than_a_quick_start(outside, given):
    clean = {name: value for name, value in os.environ.items() if name not in QUICK_START}
    values = outside("-c", SHOW_VARIABLES, python=True, env=clean | given).out.split()
    expected = QUICK_START | given
    assert values == list(expected.values())


INSTALLED = Path(tendon_cli.__file__).parents[1]
SITE_PACKAGES = os.pathsep.join(path for path in sys.path if path.endswith("site-packages"))
UNINSTALLED = {"PYTHONPATH": SITE_PACKAGES}
"""With -S no hook of an installation is read, and less is imported before tendon is."""


def write_traps(folder, except_for=()):
    """Write modules that say if they are executed.

    They have the names of the standard library and of every installed module, but for some.
    """
    installed = {name for name in packages_distributions() if name.isidentifier()}
    for name in {*sys.stdlib_module_names, *installed} - set(except_for):
        trap = "open('executed', 'a').write(__name__ + ' ')\n"
        (folder / f"{name}.py").write_text(trap, encoding="utf-8")


def is_trapped(folder):
    """Return True if a module of `write_traps` was executed in a folder."""
    return (folder / "executed").exists()


def test_modules_in_the_working_directory_are_not_executed(outside, workplace, write_study):
    write_traps(workplace)
    (workplace / "sitecustomize.py").write_text("open('executed', 'a')", encoding="utf-8")
    write_study("[load]\nmass = [0, 3]\n")
    for line in ("sweep study.toml --jobs 2 --no-figures", "plot results/study"):
        ran = outside(*line.split())
        assert ran.exit == 0, (line, ran.err)
        assert not is_trapped(workplace), line


@pytest.mark.parametrize("flags", [(), ("-S",)], ids=["installed", "uninstalled"])
def test_python_m_executes_no_module_in_the_working_directory_either(
    outside, workplace, write_study, tmp_path_factory, flags
):
    environment = dict(os.environ)
    if flags:
        environment["PYTHONPATH"] = os.pathsep.join([str(INSTALLED), SITE_PACKAGES])
    options = {"python": True, "env": environment}
    probe = tmp_path_factory.mktemp("probe")
    (probe / "probe.py").write_text("import sys; print(*sys.modules)", encoding="utf-8")
    # Any `python -m` imports contextlib, functools, warnings and such before the module.
    imported = outside(*flags, "-m", "probe", **options, cwd=probe).out
    beyond_reach = set(imported.split())
    assert not {"json", "typing", "signal", "typer", "pydantic", "numpy"} & beyond_reach
    write_traps(workplace, except_for={*beyond_reach, "tendon_cli"})
    write_study("")
    ran = outside(*flags, "-m", "tendon_cli", "state", "study.toml", **options)
    assert (ran.exit, ran.err) == (0, "")
    assert not is_trapped(workplace)


def test_python_m_with_p_executes_nothing_at_all(outside, workplace):
    write_traps(workplace)
    ran = outside("-P", "-m", "tendon_cli", "--help", python=True)
    assert (ran.exit, ran.err) == (0, "")
    assert not is_trapped(workplace)


@pytest.fixture
def checkout(workplace):
    """Copy the sources into the working directory, as a version that nobody has installed."""
    package = workplace / "tendon_cli"
    shutil.copytree(INSTALLED / "tendon_cli", package)
    source = (package / "version.py").read_text(encoding="utf-8")
    source = re.sub("^__version__ = .*$", '__version__ = "9"', source, flags=re.MULTILINE)
    source = re.sub("^RESULTS_VERSION = .*$", "RESULTS_VERSION = 9", source, flags=re.MULTILINE)
    (package / "version.py").write_text(source, encoding="utf-8")


@pytest.mark.usefixtures("checkout")
def test_a_checkout_that_is_not_installed_runs(outside, write_study):
    options = {"python": True, "env": os.environ | UNINSTALLED}
    write_study("")
    ran = outside(
        "-S", "-m", "tendon_cli", "sweep", "study.toml", "--json", "--no-figures", **options
    )
    assert (ran.exit, ran.err) == (0, "")
    assert ran.json["results_version"] == 9


@pytest.mark.parametrize("flags", [(), ("-P",)])
def test_a_working_directory_that_pythonpath_names_is_looked_into(outside, workplace, flags):
    (workplace / "typer.py").write_text("raise SystemExit(77)\n", encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(workplace)}
    assert outside(*flags, "-m", "tendon_cli", "--version", python=True, env=environment).exit == 77


def test_python_m_runs_where_the_working_directory_is_gone(outside, tmp_path_factory):
    gone = tmp_path_factory.mktemp("gone")
    ran = outside("-m", "tendon_cli", "--version", python=True, cwd=gone, preexec_fn=gone.rmdir)
    assert (ran.exit, ran.err) == (0, "")


@pytest.mark.parametrize(
    ("setting", "encoding"),
    [
        ({"LC_ALL": "C"}, "utf-8"),
        ({"LC_ALL": "C.UTF-8"}, "utf-8"),
        ({"PYTHONIOENCODING": "latin-1"}, "latin-1"),
    ],
)
def test_any_locale_and_encoding_can_show_a_state(outside, write_study, setting, encoding):
    write_study('title = "σ μ φ"\n')
    environment = setting | {"PATH": "/usr/bin:/bin"}
    ran = outside("state", "study.toml", env=environment, encoding=encoding)
    assert ran.exit == 0
    assert ("θ" in ran.out) is (encoding == "utf-8")


def test_names_with_spaces_and_letters_of_any_script_are_fine(tendon, workplace):
    folder = workplace / "Bärbel's study äöü 力"
    folder.mkdir()
    file = folder / "my study.toml"
    file.write_text('name = "fine"\n', encoding="utf-8")
    ran = tendon("sweep", file, "--no-figures", "--json", "--out", folder / "my run")
    assert (ran.exit, ran.err) == (0, "")
    assert (folder / "my run/designs.parquet").exists()
