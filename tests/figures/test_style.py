"""The same input gives the same bytes in any working directory and environment."""

from __future__ import annotations

import contextlib
import io
import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import patch

import pytest

from tendon_cli.cube.labels import plain
from tendon_cli.figures.backend import Figure, mpl
from tendon_cli.figures.style import house_style, render
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
LANGUAGE = {"LANG": "de_DE.UTF-8", "LC_ALL": "tr_TR.UTF-8"}
NOWHERE = {"MPLCONFIGDIR": "/proc/nowhere", "MATPLOTLIBRC": "/nowhere", "HOME": "/proc"}


@pytest.fixture(scope="module")
def table_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the path of a table of designs."""
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
    """Draw three figures in a new folder and print their hashes, in a process of its own."""
    folder.mkdir()
    if settings is not None:
        (folder / "matplotlibrc").write_bytes(settings)
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("MPL", "MATPLOTLIB"))
    }
    return subprocess.run(
        [sys.executable, "-c", DRAW, str(table)],
        cwd=folder,
        env=environment | extra,
        capture_output=True,
        text=True,
        check=True,
    )


@pytest.fixture(scope="module")
def usual_hashes(table_path: Path) -> str:
    """Return the hashes of the figures drawn in this process."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), patch.object(sys, "argv", ["", str(table_path)]):
        exec(DRAW, {})  # noqa: S102 - the same lines as in the other processes
    assert len(printed.getvalue().splitlines()) == 3
    return printed.getvalue()


@pytest.mark.parametrize(
    ("environment", "settings"),
    [
        pytest.param(LANGUAGE | NOWHERE, SETTINGS, id="settings and no place"),
        pytest.param(LANGUAGE, SETTINGS, id="settings", marks=pytest.mark.torture),
        pytest.param(
            {"SOURCE_DATE_EPOCH": "12345", "TZ": "Asia/Tokyo"},
            b"\x00 : {",
            id="odd",
            marks=pytest.mark.torture,
        ),
        pytest.param(
            {"MPLBACKEND": "nonsense", "PYTHONHASHSEED": "7"},
            b"text.usetex: True\n",
            id="backend",
            marks=pytest.mark.torture,
        ),
        pytest.param(NOWHERE, b"", id="no place", marks=pytest.mark.torture),
    ],
)
def test_bytes_do_not_depend_on_the_surroundings(
    table_path: Path,
    tmp_path: Path,
    usual_hashes: str,
    environment: dict[str, str],
    settings: bytes,
) -> None:
    ended = draw(table_path, tmp_path / "there", environment, settings)
    assert not ended.stderr
    assert ended.stdout == usual_hashes


@pytest.mark.parametrize(
    "content",
    [
        pytest.param(b"\xff\xfe\x00 : {", marks=pytest.mark.torture),
        b"axes.formatter.use_locale: True\n",
        None,
    ],
)
def test_settings_that_stop_matplotlib_are_refused_at_once(
    table_path: Path, workplace: Path, content: bytes | None
) -> None:
    if content is None:
        os.mkfifo("matplotlibrc")
    else:
        Path("matplotlibrc").write_bytes(content)
    ended = subprocess.run(
        [sys.executable, "-m", "tendon_cli", "plot", str(table_path), "--out", "f.png"],
        env=os.environ | {"LC_ALL": "tr_TR.UTF-8"},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert ended.returncode == 3
    assert "matplotlibrc: matplotlib cannot use these settings" in ended.stderr
    assert not Path("f.png").exists()


def test_the_style_leaves_nothing_behind() -> None:
    before = dict(mpl.rcParams)
    with house_style():
        assert mpl.rcParams["font.size"] != before["font.size"]
    assert dict(mpl.rcParams) == before


def test_hostile_titles_are_drawn_as_text() -> None:
    assert plain("a\x00b\n$x$ \u202e") == r"a b \$x\$"
    assert plain("word " * 200, width=40, lines=3).count("\n") == 2
    with house_style():
        figure = Figure((3.0, 1.5))
        figure.text(0.0, 0.5, plain("$ {\\frac 図 \U0001f980 ^_"))
    assert render(figure, "svg") == render(figure, "svg")
    assert render(figure, "png")[:4] == b"\x89PNG"
