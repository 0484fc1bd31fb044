"""What a command takes in: no library before it is needed, nothing from the folder it is started in."""

import json
import os
import shutil
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import tendon_cli

HEAVY = ("numpy", "pandas", "pyarrow", "scipy", "matplotlib", "joblib", "distributed")
LOADED = """
import contextlib, io, json, sys
from tendon_cli import cli
with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):
    cli.main(sys.argv[1:])
print(json.dumps(sorted(sys.modules)))
"""
VARIABLES = ("OPENBLAS_NUM_THREADS", "PYDANTIC_DISABLE_PLUGINS", "ARROW_DEFAULT_MEMORY_POOL")


def loaded_after(outside, *words):
    return json.loads(outside("-c", LOADED, *words, python=True).out)


def heavy_after(outside, *words):
    loaded = loaded_after(outside, *words)
    return [name for name in HEAVY if name in loaded]


@pytest.mark.parametrize("words", [["--help"], ["sweep", "--help"], ["--version"], ["swoop"]])
def test_help_imports_none_of_the_heavy_libraries_and_reads_no_study(outside, words):
    loaded = loaded_after(outside, *words)
    assert [
        name
        for name in loaded
        if name.startswith((*HEAVY, "tendon_cli.studies.", "tendon_cli.engine."))
    ] == []


def test_a_small_sweep_without_figures_imports_only_what_it_needs(outside, workplace):
    (workplace / "study.toml").write_text("[load]\nmass = [0.0, 3.0]\n", encoding="utf-8")
    loaded = loaded_after(outside, "sweep", "study.toml", "--no-figures")
    assert [name for name in HEAVY if name in loaded] == ["numpy", "pyarrow"]
    assert [
        name for name in ("tendon_cli.engine.cost", "tendon_cli.figures", "rich") if name in loaded
    ] == []
    assert (workplace / "results/study/run.json").exists()


@pytest.mark.parametrize("command", ["check", "report"])
def test_what_is_said_of_a_run_needs_no_library_that_draws(outside, tendon, workplace, command):
    (workplace / "study.toml").write_text("[load]\nmass = [0.0, 3.0]\n", encoding="utf-8")
    assert tendon("sweep", "study.toml", "--no-figures").exit == 0
    assert heavy_after(outside, command, "results/study") == ["numpy", "pyarrow"]


@pytest.mark.parametrize("given", [{}, dict.fromkeys(VARIABLES, "0")])
def test_what_the_environment_says_counts_more_than_a_quick_start(outside, given):
    code = f"from tendon_cli.startup import spare_time; spare_time(); import os; print(*map(os.getenv, {VARIABLES}))"
    clean = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    words = outside("-c", code, python=True, env=clean | given).out.split()
    assert words == ([*given.values()] or ["1", "__all__", "system"])


INSTALLED = Path(tendon_cli.__file__).parents[1]
UNINSTALLED = {
    "PYTHONPATH": os.pathsep.join(path for path in sys.path if path.endswith("site-packages"))
}
"""With -S no hook of an installation is read, and less is imported before tendon is."""


def traps_except(folder, names):
    """A module under every name of the standard library and of what is installed that says if it is executed."""
    installed = {name for name in packages_distributions() if name.isidentifier()}
    for name in {*sys.stdlib_module_names, *installed} - names:
        (folder / f"{name}.py").write_text(
            "open('executed', 'a').write(__name__ + ' ')\n", encoding="utf-8"
        )


def test_modules_in_the_working_directory_are_not_executed(outside, workplace):
    traps_except(workplace, set())
    (workplace / "sitecustomize.py").write_text("open('executed', 'a')", encoding="utf-8")
    (workplace / "study.toml").write_text("[load]\nmass = [0, 3]\n", encoding="utf-8")
    for words in (
        ("sweep", "study.toml", "--jobs", "2"),
        ("state", "study.toml"),
        ("plot", "results/study"),
    ):
        ran = outside(*words)
        assert (ran.exit, (workplace / "executed").exists()) == (0, False), (words, ran.err)


@pytest.mark.parametrize("flags", [(), ("-S",)], ids=["installed", "uninstalled"])
def test_python_m_executes_no_module_in_the_working_directory_either(
    outside, workplace, tmp_path_factory, flags
):
    paths = (
        {"PYTHONPATH": os.pathsep.join([str(INSTALLED), UNINSTALLED["PYTHONPATH"]])}
        if flags
        else {}
    )
    options = {"python": True, "env": os.environ | paths}
    probe = tmp_path_factory.mktemp("probe")
    (probe / "probe.py").write_text("import sys; print(*sys.modules)", encoding="utf-8")
    # What any `python -m` has imported before the module is asked: contextlib, functools, warnings and such.
    beyond_reach = set(outside(*flags, "-m", "probe", **options, cwd=probe).out.split())
    assert not {"json", "typing", "signal", "typer", "pydantic", "numpy"} & beyond_reach
    traps_except(workplace, {*beyond_reach, "tendon_cli"})
    (workplace / "study.toml").write_text("", encoding="utf-8")
    for words in (("--help",), ("sweep", "study.toml", "--json")):
        ran = outside(*flags, "-m", "tendon_cli", *words, **options)
        assert (ran.exit, ran.err, (workplace / "executed").exists()) == (0, "", False), words


def test_python_m_with_p_executes_nothing_at_all(outside, workplace):
    traps_except(workplace, set())
    ran = outside("-P", "-m", "tendon_cli", "--help", python=True)
    assert (ran.exit, ran.err, (workplace / "executed").exists()) == (0, "", False)


@pytest.fixture
def checkout(workplace):
    """The sources in the working directory, of a version that nobody has installed."""
    shutil.copytree(
        INSTALLED / "tendon_cli",
        workplace / "tendon_cli",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    (workplace / "tendon_cli/version.py").write_text(
        '__version__ = "9"\nRESULTS_VERSION = 9\n', encoding="utf-8"
    )
    return workplace


def test_a_checkout_that_is_not_installed_runs(outside, checkout):
    options = {"python": True, "env": os.environ | UNINSTALLED}
    assert outside("-S", "-m", "tendon_cli", "--version", **options).out == "tendon 9\n"
    assert outside("-S", "-m", "tendon_cli", "init", **options).exit == 0
    ran = outside("-S", "-m", "tendon_cli", "sweep", "study.toml", "--json", **options)
    assert (ran.exit, ran.err, ran.json["results_version"], ran.json["figures"]) == (
        0,
        "",
        9,
        ["slack_map.png"],
    )


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
        *(({"LC_ALL": locale}, "utf-8") for locale in ("C", "POSIX", "C.UTF-8")),
        ({"PYTHONIOENCODING": "latin-1"}, "latin-1"),
    ],
)
def test_any_locale_and_encoding_can_show_a_state(outside, workplace, setting, encoding):
    (workplace / "study.toml").write_text('title = "σ μ φ"\n', encoding="utf-8")
    ran = outside("state", "study.toml", env=setting | {"PATH": "/usr/bin:/bin"}, encoding=encoding)
    assert (ran.exit, "θ" in ran.out) == (0, encoding == "utf-8")


def test_names_with_spaces_and_letters_of_any_script_are_fine(tendon, workplace):
    folder = workplace / "Bärbel's study äöü 力"
    folder.mkdir()
    file = folder / "my study.toml"
    file.write_text('name = "fine"\n', encoding="utf-8")
    ran = tendon("sweep", file, "--no-figures", "--json", "--out", folder / "my run")
    assert (ran.exit, ran.err) == (0, "")
    assert (folder / "my run/designs.parquet").exists()
