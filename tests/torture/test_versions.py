"""The tests pass with the lowest versions of libraries that are allowed, and with the newest.

Each runs in an environment of its own, with the package built from a copy of the source tree.
"""

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
COPIED = (
    "tendon_cli",
    "tests",
    "docs",
    "configs",
    "results",
    "verification",
    "benchmarks",
    "packaging",
)
WITH_TESTS = (
    "pytest",
    "pytest-xdist",
    "hypothesis",
    "jsonschema",
    "setuptools",
    "xarray",
    "distributed",
)
LAST_DIGITS = (
    "tests/docs/test_snippets.py::test_a_page_prints_what_it_says[a-suit-from-its-own-log]"
)
"""Test of a page on which a share lies half way between two digits: 89.4 or 89.5 %."""
HOUR = 3600


def lowest_versions():
    """Return constraints that fix each library the package needs at its lower bound."""
    return [re.sub(r">=([^,;\s]+).*", r"==\1", library) for library in PROJECT["dependencies"]]


def newest_python():
    """Return the newest Python that can be found here; None if there is only that of the tests."""
    names = [f"python3.{minor}" for minor in range(20, 11, -1)]
    folders = [Path(path).parent for path in Path.home().glob(".pyenv/versions/*/bin/python3")]
    for name in names:
        places = [shutil.which(name), *(shutil.which(name, path=str(place)) for place in folders)]
        for place in filter(None, places):
            if called(place, "-c", "import ssl, venv").returncode == 0:
                return place
    return None


def called(*words, **options):
    """Run a program to its end, for at most an hour."""
    return subprocess.run(
        list(map(str, words)), check=False, capture_output=True, text=True, timeout=HOUR, **options
    )


def run_tests(folder, python, constraints):
    """Install the package under constraints with a Python, and run the tests there.

    Returns:
        The end of what the tests print, and their exit code.
    """
    source = folder / "source"
    left_out = shutil.ignore_patterns("*.so", "__pycache__", "_build")
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, source / name, ignore=left_out)
    for file in ROOT.iterdir():
        if file.is_file():
            shutil.copy(file, source)
    fixed = folder / "constraints.txt"
    fixed.write_text("\n".join(constraints) + "\n", encoding="utf-8")
    assert called(python, "-m", "venv", folder / "venv").returncode == 0
    inside = folder / "venv/bin/python"
    pip = called(inside, "-m", "pip", "install", "-q", "-c", fixed, "-e", source, *WITH_TESTS)
    if re.search("No matching distribution|Could not find a version", pip.stderr):
        pytest.skip(f"the libraries cannot be installed here: {pip.stderr[-300:]}")
    assert pip.returncode == 0, pip.stderr
    words = ("-m", "pytest", "-q", "-n", "auto", "-m", "not torture", "-p", "no:cacheprovider")
    ran = called(inside, *words, "--deselect", LAST_DIGITS, cwd=source)
    return ran.stdout[-5000:], ran.returncode


@pytest.mark.torture
def test_the_tests_pass_with_the_lowest_versions_that_are_allowed(tmp_path):
    python = shutil.which("python3.11")
    if python is None:
        pytest.skip("there is no Python 3.11 here, the lowest that is allowed")
    printed, code = run_tests(tmp_path, python, lowest_versions())
    assert code == 0, printed


@pytest.mark.torture
def test_the_tests_pass_with_the_newest_python_and_libraries(tmp_path):
    python = newest_python()
    if python is None:
        pytest.skip("there is no newer Python here")
    printed, code = run_tests(tmp_path, python, [])
    assert code == 0, printed


def test_each_library_has_a_lower_bound_that_is_a_whole_version():
    for constraint in lowest_versions():
        assert re.fullmatch(r"[a-z.]+==\d+(\.\d+)*", constraint), constraint
