"""Installed with and without a C compiler, from a copy of the source tree into an environment of its own."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest

from .tools import study_in

ROOT = Path(__file__).parents[2]
SETUPTOOLS = 77
STUDY = """
[tendon]
pretension = { from = "20 N", to = "240 N", num = 12 }
[load]
mass = ["0 kg", "3 kg", "10 kg"]
[motion]
elbow_angle = { from = "-30 deg", to = "170 deg", num = 21 }
"""
SWEEP = ("sweep", "study.toml", "--out", "run", "--no-figures", "--allow-no-equilibrium")


def called(*words, **options):
    return subprocess.run(list(map(str, words)), check=False, capture_output=True, text=True, timeout=300, **options)


def setuptools(folder):
    """Where there is a setuptools that knows extensions in pyproject.toml: here, else put into a folder."""
    try:
        found = distribution("setuptools")
    except PackageNotFoundError:
        found = None
    if found is not None and int(found.version.partition(".")[0]) >= SETUPTOOLS:
        return Path(str(found.locate_file("")))
    pip = called(sys.executable, "-m", "pip", "install", "--quiet", "--target", folder, f"setuptools>={SETUPTOOLS}")
    if pip.returncode:
        pytest.skip(f"setuptools >= {SETUPTOOLS} is neither here nor to be had: {pip.stderr[-200:]}")
    return folder


def source(folder):
    """A copy of what is installed from, with nothing compiled."""
    left_out = shutil.ignore_patterns("*.so", "*.pyd", "__pycache__")
    shutil.copytree(ROOT / "tendon_cli", folder / "tendon_cli", ignore=left_out)
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder / name)
    return folder


def installed(folder, compiler):
    """Install by a compiler; returns the environment's folders of programs and of packages."""
    venv.create(folder / "venv", with_pip=False)
    places = {"base": str(folder / "venv"), "platbase": str(folder / "venv")}
    programs, packages = (Path(sysconfig.get_path(name, "venv", places)) for name in ("scripts", "platlib"))
    tools = setuptools(folder / "tools")
    words = ("--no-build-isolation", "--no-deps", "--no-index", "--ignore-installed", source(folder / "source"))
    environment = os.environ | {"CC": compiler, "PYTHONPATH": str(tools)}
    pip = called(sys.executable, "-m", "pip", "--python", programs / "python", "install", *words, env=environment)
    assert pip.returncode == 0, pip.stderr
    assert (packages / "tendon_cli").is_dir()
    (packages / "others.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return programs, packages


@pytest.mark.torture
@pytest.mark.parametrize("name", ["false", "cc"])
def test_it_installs_whatever_the_compiler_and_writes_the_same_bytes(tmp_path, outside, workplace, hashes_in, name):
    compiler = shutil.which(name)
    if compiler is None:
        pytest.skip(f"there is no {name} here")
    programs, packages = installed(tmp_path / "install", compiler)
    assert bool(list((packages / "tendon_cli/kernel").glob("_native.*"))) == (name == "cc")
    study_in(workplace, STUDY)
    assert outside(*SWEEP).exit == 0
    here = hashes_in(workplace / "run")
    place = study_in(tmp_path / "place", STUDY)
    ran = called(programs / "tendon", *SWEEP, cwd=place)
    assert ran.returncode == 0, ran.stderr
    assert hashes_in(place / "run") == here
    assert len(here) == 2
