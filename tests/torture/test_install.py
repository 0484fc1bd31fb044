"""The package installs with and without a C compiler.

It is installed into an environment of its own from an sdist, which is made of a copy of the tree.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from tools.torture.runs import study_in

ROOT = Path(__file__).parents[2]
STUDY = """
[tendon]
pretension = { from = "20 N", to = "240 N", num = 12 }
[load]
mass = ["0 kg", "3 kg", "10 kg"]
[motion]
elbow_angle = { from = "-30 deg", to = "170 deg", num = 21 }
"""
SOURCES = (
    "pyproject.toml",
    "setup.py",
    "MANIFEST.in",
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "CITATION.cff",
)
SWEEP = ("sweep", "study.toml", "--out", "run", "--no-figures", "--allow-no-equilibrium")


def called(*words, **options):
    """Run a program to its end."""
    return subprocess.run(
        list(map(str, words)), check=False, capture_output=True, text=True, timeout=300, **options
    )


def installed(folder, compiler):
    """Install with a compiler; return the environment's folders of programs and of packages."""
    home = str(folder / "venv")
    venv.create(home, with_pip=False)
    places = {"base": home, "platbase": home}
    programs = Path(sysconfig.get_path("scripts", "venv", places))
    packages = Path(sysconfig.get_path("platlib", "venv", places))
    left_out = shutil.ignore_patterns("*.so", "*.pyd", "__pycache__")
    shutil.copytree(ROOT / "tendon_cli", folder / "source/tendon_cli", ignore=left_out)
    shutil.copytree(ROOT / "configs", folder / "source/configs")
    for name in SOURCES:
        shutil.copy(ROOT / name, folder / "source")
    code = "from setuptools import build_meta; print(build_meta.build_sdist('.'))"
    made = called(sys.executable, "-c", code, cwd=folder / "source")
    assert made.returncode == 0, made.stderr
    sdist = folder / "source" / made.stdout.splitlines()[-1]
    words = ("--python", programs / "python", "install", "--no-deps", sdist)
    pip = called(sys.executable, "-m", "pip", *words, env=os.environ | {"CC": compiler})
    if "No matching distribution found for setuptools" in pip.stderr:
        pytest.skip("setuptools cannot be installed here")
    assert pip.returncode == 0, pip.stderr
    (packages / "others.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return programs, packages


@pytest.mark.torture
@pytest.mark.parametrize("name", ["false", "cc"])
def test_it_installs_whatever_the_compiler_and_writes_the_same_bytes(
    tmp_path, outside, workplace, hashes_in, name
):
    compiler = shutil.which(name)
    if compiler is None:
        pytest.skip(f"there is no {name} here")
    programs, packages = installed(tmp_path / "install", compiler)
    kernels = list((packages / "tendon_cli/kernel").glob("_native.*"))
    assert bool(kernels) == (name == "cc")
    study_in(workplace, STUDY)
    assert outside(*SWEEP).exit == 0
    place = study_in(tmp_path / "place", STUDY)
    ran = called(programs / "tendon", *SWEEP, cwd=place)
    assert ran.returncode == 0, ran.stderr
    assert ("NumPy did it all" in ran.stdout) == (name == "false")
    assert hashes_in(place / "run") == hashes_in(workplace / "run")
    assert len(hashes_in(place / "run")) == 2
