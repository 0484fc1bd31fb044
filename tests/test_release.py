"""A release holds all that the package needs; its wheel works on every Python it is for."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tendon_cli import __version__
from tools import release

ROOT = Path(__file__).parent.parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PROJECT = PYPROJECT["project"]
PATTERNS = PYPROJECT["tool"]["setuptools"]["package-data"]["tendon_cli"]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
STUDY = '[tendon]\npretension = ["100 N", "150 N"]\n[load]\nmass = ["0 kg", "5 kg"]\n'
KIND = "from tendon_cli.kernel import kind; print(kind())"


def test_every_file_of_the_package_goes_into_the_wheel():
    data = {
        file.relative_to(ROOT).as_posix()
        for pattern in PATTERNS
        for file in (ROOT / "tendon_cli").glob(pattern)
    }
    others = {name for name in release.of_the_package() if not name.endswith((".py", ".c", ".h"))}
    assert release.NEEDED <= others <= data


def test_nothing_goes_into_the_wheel_twice():
    """Packages without a word of code are alike; of others, none is a copy."""
    sources = [ROOT / name for name in (*release.of_the_package(), *release.of_the_configs())]
    contents = [content for file in sources if len(content := file.read_bytes()) > 200]
    assert len(contents) == len(set(contents))


def test_development_tools_are_no_extras_of_the_package():
    """Whoever installs tendon is offered what it can use, not what it is made with."""
    assert set(PROJECT["optional-dependencies"]) == {"dask", "xarray", "docs"}
    assert {"dev", "release", "readers", "torture"} == set(PYPROJECT["dependency-groups"])


AS_SET_UP = """
import runpy
import sysconfig
import setuptools
asked = {}
setuptools.setup = lambda **words: asked.update(words)
known = sysconfig.get_config_var
sysconfig.get_config_var = lambda name: FREE if name == "Py_GIL_DISABLED" else known(name)
runpy.run_path("setup.py")
print(asked["ext_modules"][0].py_limited_api, "bdist_wheel" in asked["options"])
"""


@pytest.mark.parametrize(("free_threaded", "is_limited"), [(0, True), (1, False)])
def test_a_python_without_its_lock_gets_compiled_code_of_its_own(free_threaded, is_limited):
    """The stable interface, on which one wheel for all rests, is not there without the lock."""
    code = AS_SET_UP.replace("FREE", str(free_threaded))
    ran = called(sys.executable, "-c", code, cwd=ROOT)
    assert ran.stdout.split() == [str(is_limited)] * 2


def test_the_conda_recipe_asks_for_what_the_package_asks_for():
    recipe = YAML(typ="safe").load((ROOT / "packaging/conda/recipe.yaml").read_text())
    asked = {
        name.replace(" ", "").replace("matplotlib-base", "matplotlib")
        for name in recipe["requirements"]["run"]
    }
    assert asked - {"python" + PROJECT["requires-python"]} == set(PROJECT["dependencies"])
    assert recipe["context"]["version"] == __version__


def test_the_image_is_built_of_what_a_release_is_built_of():
    """The Dockerfile copies all that .dockerignore lets through, and that is all of the build."""
    dockerfile = (ROOT / "Dockerfile").read_text().splitlines()
    ignored = (ROOT / ".dockerignore").read_text().splitlines()
    copies = [
        line.split()[1:-1]
        for line in dockerfile
        if line.startswith("COPY ") and "--from" not in line
    ]
    copied = {word for words in copies for word in words}
    assert copied == {line[1:] for line in ignored if line.startswith("!")}
    assert copied == release.OF_THE_SOURCE | {"constraints.txt", "tendon_cli", "configs"}


@pytest.mark.parametrize("tool", ["docker", "buildah"])
def test_an_image_is_built_and_asked_for_its_version_or_that_is_told(tmp_path, monkeypatch, tool):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "neither Docker nor Buildah" in release.image_of(ROOT)
    (tmp_path / tool).write_text("#!/bin/sh\n[ $1 = run ] && echo tendon 9 || echo container\n")
    (tmp_path / tool).chmod(0o755)
    assert release.image_of(ROOT) == "the image answers tendon 9"
    (tmp_path / tool).write_text("#!/bin/sh\necho no daemon >&2; exit 1\n")
    assert release.image_of(ROOT) == "the image was not built: no daemon"


WHOLE = release.of_a_wheel() | {"tendon_cli/kernel/_native.abi3.so"}
LACKING = ["tendon_cli/studies/starter.yaml", "tendon_cli/py.typed", "tendon_cli/commands/cli.py"]
WHEELS = [
    (WHOLE, "any", []),
    *((WHOLE - {name}, "any", [f"lacks {name}"]) for name in LACKING),
    (WHOLE | {"tests/test_face.py"}, "any", ["has tests/test_face.py"]),
    (release.of_a_wheel(), "any", ["has no compiled kernel"]),
    (WHOLE, "linux_x86_64", ["is tagged for this machine's Linux only (no manylinux)"]),
]


@pytest.mark.parametrize(("names", "platform", "faults"), WHEELS, ids=range(len(WHEELS)))
def test_what_a_wheel_lacks_or_has_too_much_is_told(tmp_path, names, platform, faults):
    path = tmp_path / f"tendon_cli-1-cp311-abi3-{platform}.whl"
    with zipfile.ZipFile(path, "w") as wheel:
        for name in names:
            wheel.writestr(name, "")
    assert release.faults_of_wheel(path) == faults


def called(*words, **options):
    return subprocess.run(
        [*map(str, words)], check=False, capture_output=True, text=True, timeout=900, **options
    )


def python_of(version):
    """A Python of this version, on the path or one of pyenv's; None where there is none."""
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for found in (shutil.which(f"python{version}"), *sorted(kept.glob(f"{version}.*/bin/python"))):
        if found and re.match(rf"Python {version}\.", called(found, "--version").stdout):
            return found
    return None


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Build the wheel of `make release` from a copy of the sources."""
    needed = ["build"]
    if sys.platform == "linux":
        needed.append("auditwheel")
    for name in needed:
        reason = f"`{name}` is not installed: pip install -c constraints.txt --group release"
        pytest.importorskip(name, reason=reason)
    source, out = (tmp_path_factory.mktemp("release") / name for name in ("source", "dist"))
    left_out = shutil.ignore_patterns("*.so", "*.pyd", "__pycache__")
    for name in ("tendon_cli", "configs"):
        shutil.copytree(ROOT / name, source / name, ignore=left_out)
    for name in release.OF_THE_SOURCE:
        shutil.copy(ROOT / name, source / name)
    release.build(source, out)
    assert release.main(out) == 0
    return next(out.glob("*.whl"))


@pytest.mark.torture
@pytest.mark.parametrize("version", PYTHONS)
def test_the_wheel_installs_and_computes_by_compiled_code(wheel, tmp_path, version):
    python = python_of(version)
    if python is None:
        pytest.skip(f"there is no Python {version} here")
    assert called(python, "-m", "venv", tmp_path / "venv").returncode == 0
    programs = tmp_path / "venv/bin"
    words = (
        "-m",
        "pip",
        "install",
        "--quiet",
        "--only-binary",
        ":all:",
        "-c",
        ROOT / "constraints.txt",
        wheel,
    )
    installed = called(programs / "python", *words)
    assert installed.returncode == 0, installed.stderr
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    assert called(programs / "tendon", "--version", cwd=tmp_path).stdout.startswith("tendon ")
    swept = called(programs / "tendon", "sweep", "study.toml", "--out", "run", cwd=tmp_path)
    assert swept.returncode == 0, swept.stderr
    assert (tmp_path / "run/designs.parquet").is_file()
    for words in (("mine.yaml",), ("--from", "universal")):
        assert called(programs / "tendon", "init", *words, cwd=tmp_path).returncode == 0
    kind = called(programs / "python", "-P", "-c", KIND, cwd=tmp_path)
    assert kind.stdout.strip() not in ("", "None"), kind.stderr
