"""Hostile surroundings: links in a run folder, no home, no network."""

import json
from pathlib import Path

import pytest

from tests.sampled import quick_and_torture
from tools.torture.runs import READINGS, SMALL, STATES, launched, study_in

SWEEP = ("sweep", "study.toml", "--out", "run", "--jobs", "2", "--json")
NAMES = [
    "run.json",
    "design.json",
    "journal.jsonl",
    ".lock",
    "designs.parquet",
    "states.parquet",
    "slack_map.png",
    ".tendon-run-0123456789ab.tmp",
    ".tendon-figures-0123456789ab",
    "states.parquet/part-00003.parquet",
    "states.parquet/.tendon-run-0123456789ab.tmp",
    "designs.parquet/part-00000.parquet",
]


@pytest.mark.parametrize("target", quick_and_torture(["file"], ["nothing", "folder"]))
@pytest.mark.parametrize("name", NAMES)
def test_a_link_in_the_run_folder_is_not_written_through(
    tendon, tmp_path, small_parts, name, target
):
    place = study_in(tmp_path / "place")
    if "/" in name:
        small_parts(STATES)
    precious = tmp_path / "precious"
    if target == "folder":
        precious.mkdir()
        (precious / "mine").write_text("mine", encoding="utf-8")
    elif target == "file":
        precious.write_text("mine", encoding="utf-8")
    link = place / "run" / name
    link.parent.mkdir(parents=True)
    link.symlink_to(precious)
    words = ["sweep", place / "study.toml", "--out", place / "run", "--json"]
    if "png" not in name:
        words.append("--no-figures")
    for mode in ((), ("--resume",), ("--overwrite",)):
        ran = tendon(*words, *mode)
        assert ran.exit in (0, 5, 7), ran.out
        if target == "file":
            assert precious.read_text(encoding="utf-8") == "mine"
        elif target == "folder":
            assert [item.name for item in precious.iterdir()] == ["mine"]
        else:
            assert not precious.exists()


# --- No home, no network --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "home", quick_and_torture(["/nonexistent"], ["study.toml", "locked", "/proc/1/nothing"])
)
def test_without_a_home_figures_are_drawn_and_nothing_is_said(place, home):
    """The home is missing, a file, without permission, or kept by the system to itself."""
    (place / "locked").mkdir(mode=0o500)
    environment = {
        "HOME": str(place / home),
        "PATH": "/usr/bin:/bin",
        "XDG_CACHE_HOME": "/proc/1/nothing",
    }
    code, out, err = launched(place, {}, *SWEEP, env=environment)
    assert (code, err) == (0, "")
    assert json.loads(out)["figures"] == ["slack_map.png"]
    assert not list((place / "locked").iterdir())


COMMANDS = [
    SWEEP,
    ("--version",),
    ("init", "new.toml"),
    ("init", "--schema"),
    ("state", "study.toml"),
    ("sweep", "study.toml", "--dry-run"),
    ("plot", "run", "--out", "figure.svg"),
    ("plot", "study.toml", "--arm", "--out", "arm.pdf"),
    ("fit-friction", "cells.csv", "--bend-angle", "144 deg", "--plot", "fit.png"),
]


@pytest.mark.torture
def test_no_command_reaches_for_the_network(place):
    (place / "cells.csv").write_text(READINGS, encoding="utf-8")
    for words in COMMANDS:
        code, out, err = launched(place, {"offline": True}, *words)
        assert code == 0, out + err


@pytest.mark.torture
def test_the_watch_over_the_network_works(place):
    pytest.importorskip("distributed")
    code, _, err = launched(place, {"offline": True}, *SWEEP, "--scheduler", "tcp://127.0.0.1:9")
    assert code == 99
    assert "network: " in err


def test_a_run_leaves_nothing_outside_its_folder_and_needs_no_network(place, tmp_path):
    scratch = tmp_path / "scratch"
    home = tmp_path / "home"
    scratch.mkdir()
    home.mkdir()
    environment = {"HOME": str(home), "TMPDIR": str(scratch), "PATH": "/usr/bin:/bin"}
    code, _, _ = launched(place, SMALL | {"offline": True}, *SWEEP, env=environment)
    assert code == 0
    assert sorted(item.name for item in place.iterdir()) == ["run", "study.toml"]
    assert not list(scratch.iterdir())
    left = {str(file.relative_to(home)) for file in home.rglob("*") if file.is_file()}
    assert all("matplotlib" in Path(name).parts or "fontlist" in name for name in left), left
