"""Hostile surroundings: links in a run folder, no home, no network."""

import json
import os
import shutil
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from .tools import SMALL, STATES, command, launched, some, study_in

ONE_PART = {}
SWEEP = ("sweep", "study.toml", "--out", "run", "--jobs", "2", "--json")
NAMES = [
    "run.json", "design.json", "journal.jsonl", ".lock", "designs.parquet", "states.parquet", "slack_map.png",
    ".tendon-run-0123456789ab.tmp", ".tendon-figures-0123456789ab", "states.parquet/part-00003.parquet",
    "states.parquet/.tendon-run-0123456789ab.tmp", "designs.parquet/part-00000.parquet",
]  # fmt: skip


@pytest.mark.parametrize("target", some(["file"], ["nothing", "folder"]))
@pytest.mark.parametrize("name", NAMES)
def test_a_link_in_the_run_folder_is_not_written_through(tendon, tmp_path, small_parts, name, target):
    place = study_in(tmp_path / "place")
    if "/" in name:
        small_parts(STATES)
    link, precious = place / "run" / name, tmp_path / "precious"
    link.parent.mkdir(parents=True)
    if target == "folder":
        precious.mkdir()
        (precious / "mine").write_text("mine", encoding="utf-8")
    elif target == "file":
        precious.write_text("mine", encoding="utf-8")
    link.symlink_to(precious)
    common = ("sweep", place / "study.toml", "--out", place / "run", "--json")
    common += () if "png" in name else ("--no-figures",)
    for words in ((), ("--resume",), ("--overwrite",)):
        ran = tendon(*common, *words)
        assert ran.exit in (0, 5, 7), ran.out
        if target == "file":
            assert precious.read_text(encoding="utf-8") == "mine"
        elif target == "folder":
            assert [item.name for item in precious.iterdir()] == ["mine"]
        else:
            assert not precious.exists()


# --- No home ---------------------------------------------------------------------------------------------------------


def homes(folder):
    """Homes that cannot be written to: none, a file, one without permission, one that the system keeps to itself."""
    (folder / "file").write_text("", encoding="utf-8")
    (folder / "locked").mkdir(mode=0o500)
    made = {name: str(folder / name) for name in ("file", "locked")}
    return {"missing": "/nonexistent", "proc": "/proc/1/nothing"} | made


@pytest.mark.torture
@pytest.mark.parametrize("home", ["missing", "file", "locked", "proc"])
def test_without_a_home_figures_are_drawn_and_nothing_is_said(place, tmp_path, home):
    environment = {"HOME": homes(tmp_path)[home], "PATH": "/usr/bin:/bin", "XDG_CACHE_HOME": "/proc/1/nothing"}
    code, out, said = launched(place, ONE_PART, *SWEEP, env=environment)
    assert (code, said) == (0, "")
    assert json.loads(out)["figures"] == ["slack_map.png"]
    code, out, said = launched(place, ONE_PART, "plot", "run", "--out", "figure.png", env=environment)
    assert (code, said) == (0, "")
    assert not list((tmp_path / "locked").iterdir())


# --- Modules in the working directory --------------------------------------------------------------------------------


@pytest.mark.torture
def test_no_module_in_the_working_directory_is_executed_whatever_its_name(outside, workplace):
    """All names of the standard library, and of everything that is installed here."""
    installed = {name for name in packages_distributions() if name.isidentifier()}
    for name in {*sys.stdlib_module_names, *installed, "sitecustomize", "usercustomize"}:
        (workplace / f"{name}.py").write_text("open('executed', 'a').write(__name__)\n", encoding="utf-8")
    study_in(workplace, "[load]\nmass = [0, 3]\n")
    (workplace / "cells.csv").write_text(READINGS, encoding="utf-8")
    for words in (*COMMANDS, ("sweep", "study.toml", "--out", "run", "--overwrite", "--jobs", "2")):
        ran = outside(*words)
        assert (ran.exit, (workplace / "executed").exists()) == (0, False), (words, ran.err)


# --- No network ------------------------------------------------------------------------------------------------------

READINGS = "cell 1,cell 2\n1.2,1\n2.4,2\n1,1.2\n2,2.4\n"
COMMANDS = [
    ("--version",),
    ("init", "new.toml"),
    ("schema",),
    ("state", "study.toml"),
    ("sweep", "study.toml", "--dry-run"),
    SWEEP,
    ("plot", "run", "--out", "figure.svg"),
    ("plot", "study.toml", "--arm", "--out", "arm.pdf"),
    ("fit-friction", "cells.csv", "--bend-angle", "144 deg", "--plot", "fit.png"),
]


@pytest.mark.torture
def test_no_command_reaches_for_the_network(place):
    (place / "cells.csv").write_text(READINGS, encoding="utf-8")
    for words in COMMANDS:
        code, _, said = launched(place, {"offline": True}, *words)
        assert (code, said if words[0] != "sweep" else "") == (0, ""), words


@pytest.mark.torture
def test_the_watch_over_the_network_works(place):
    pytest.importorskip("distributed")
    code, _, said = launched(place, {"offline": True}, *SWEEP, "--scheduler", "tcp://127.0.0.1:9")
    assert code == 99
    assert "network: " in said


def test_a_sweep_needs_no_network_at_all(place, hashes_in):
    if shutil.which("unshare") is None:
        pytest.skip("no name space without a network can be made here")
    words = ["unshare", "--net"] if os.geteuid() == 0 else ["unshare", "--net", "--map-root-user"]
    if subprocess.run([*words, "true"], check=False, capture_output=True).returncode:
        pytest.skip("no name space without a network can be made here")
    ran = subprocess.run([*words, *command({}, *SWEEP)], check=False, capture_output=True, text=True, cwd=place)
    assert ran.returncode == 0, ran.stderr
    assert len(hashes_in(place / "run")) == 2


def test_what_a_run_leaves_outside_its_folder_is_nothing(place, tmp_path):
    scratch, home = tmp_path / "scratch", tmp_path / "home"
    scratch.mkdir()
    home.mkdir()
    environment = {"HOME": str(home), "TMPDIR": str(scratch), "PATH": "/usr/bin:/bin"}
    assert launched(place, SMALL, *SWEEP, env=environment)[0] == 0
    assert sorted(item.name for item in place.iterdir()) == ["run", "study.toml"]
    assert not list(scratch.iterdir())
    left = {str(file.relative_to(home)) for file in home.rglob("*") if file.is_file()}
    assert all("matplotlib" in Path(name).parts or "fontlist" in name for name in left), left
