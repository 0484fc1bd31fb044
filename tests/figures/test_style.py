"""The same input gives the same bytes, whatever stands in the working directory or the environment."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tendon_cli.cube.labels import plain
from tendon_cli.figures.backend import Figure, mpl
from tendon_cli.figures.style import house_style, render, wrapped
from tests.figures.runs import designs, grid

DRAW = """
import hashlib, sys
from pathlib import Path
from tendon_cli.figures.arm import arm_page
from tendon_cli.figures.draw import pages_of
from tendon_cli.figures.style import render
from tendon_cli.studies.load import study_from
from tendon_cli.tables.read import open_table
(page,) = pages_of(open_table(Path(sys.argv[1])))
arm = arm_page(study_from({"name": "arm"}))
for drawn, kind in ((page.figure, "png"), (page.figure, "pdf"), (arm.figure, "svg")):
    print(hashlib.sha256(render(drawn, kind)).hexdigest())
"""

SETTINGS = b"axes.facecolor: red\nfont.size: 40\nsvg.hashsalt: x\nbackend: nonsense\n"
HOSTILE: dict[str, tuple[dict[str, str], bytes]] = {
    "settings": ({"LANG": "de_DE.UTF-8", "LC_ALL": "tr_TR.UTF-8"}, SETTINGS),
    "odd": ({"SOURCE_DATE_EPOCH": "12345", "TZ": "Asia/Tokyo"}, b"\x00 : {"),
    "backend": ({"MPLBACKEND": "nonsense", "PYTHONHASHSEED": "7"}, b"text.usetex: True\n"),
    "no place": (
        {"MPLCONFIGDIR": "/proc/nowhere", "MATPLOTLIBRC": "/nowhere", "HOME": "/proc"},
        b"",
    ),
}


@pytest.fixture(scope="module")
def table_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("style") / "run"
    content = {
        "tendon": {"pretension": grid("0 N", "300 N", 9)},
        "spring": {"stiffness": ["1 kN/m", "3 kN/m"]},
    }
    designs(folder, content)
    return folder / "designs.parquet"


def draw(
    table: Path, folder: Path, extra: dict[str, str], settings: bytes | None
) -> subprocess.CompletedProcess[str]:
    folder.mkdir()
    if settings is not None:
        (folder / "matplotlibrc").write_bytes(settings)
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("MPL", "MATPLOTLIB"))
    }
    command = [sys.executable, "-c", DRAW, str(table)]
    return subprocess.run(
        command, cwd=folder, env={**kept, **extra}, capture_output=True, text=True, check=True
    )


@pytest.fixture(scope="module")
def calm(table_path: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    ran = draw(table_path, tmp_path_factory.mktemp("calm") / "here", {"PYTHONHASHSEED": "1"}, None)
    assert len(ran.stdout.splitlines()) == 3
    assert not ran.stderr
    return ran.stdout


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.torture if name in ("odd", "backend") else ())
        for name in HOSTILE
    ],
)
def test_bytes_do_not_depend_on_the_surroundings(
    table_path: Path, tmp_path: Path, calm: str, name: str
) -> None:
    hostile = draw(table_path, tmp_path / "there", *HOSTILE[name])
    assert not hostile.stderr
    assert hostile.stdout == calm


@pytest.mark.parametrize(
    "content", [b"\xff\xfe\x00 : {", b"axes.formatter.use_locale: True\n", None]
)
def test_settings_that_stop_matplotlib_are_refused_at_once(
    table_path: Path, workplace: Path, content: bytes | None
) -> None:
    if content is None:
        os.mkfifo("matplotlibrc")
    else:
        Path("matplotlibrc").write_bytes(content)
    command = [sys.executable, "-m", "tendon_cli", "plot", str(table_path), "--out", "f.png"]
    environment = os.environ | {"LC_ALL": "tr_TR.UTF-8"}
    ran = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=60, env=environment
    )
    assert ran.returncode == 3
    assert "matplotlibrc: matplotlib cannot use these settings" in ran.stderr
    assert not Path("f.png").exists()


def test_the_style_leaves_nothing_behind() -> None:
    before = dict(mpl.rcParams)
    with house_style():
        assert mpl.rcParams["font.size"] != before["font.size"]
    assert dict(mpl.rcParams) == before


def test_hostile_titles_are_drawn_as_text() -> None:
    assert plain("a\x00b\n$x$ \u202e") == r"a b \$x\$"
    assert plain("word " * 200, width=40, lines=3).count("\n") == 2
    assert wrapped("5 kg load, $F_{o}$ = 3 N, η = 1", 12) == "5 kg load,\n$F_{o}$ = 3 N,\nη = 1"
    with house_style():
        figure = Figure((3.0, 1.5))
        figure.text(0.0, 0.5, plain("$ {\\frac 図 \U0001f980 ^_"))
    assert render(figure, "svg") == render(figure, "svg")
    assert render(figure, "png")[:4] == b"\x89PNG"
