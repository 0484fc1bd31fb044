"""Small runs to draw, computed as `tendon sweep` does, and readers of the figures drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.text import Text

from tendon_cli.engine.folder import RunFolder
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.run import RunOptions, compute_parts
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.threads import in_threads
from tendon_cli.figures.draw import pages_of
from tendon_cli.files import locked
from tendon_cli.studies.figures import figure_spec
from tendon_cli.studies.load import study_from
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableFiles, open_table

EXACT = {"uncertainty": {"usual": False}}
"""Nothing is drawn, so that an answer of which only names and windows are looked at comes fast."""
LOADS = ["0 kg", "3 kg", "5 kg", "10 kg"]


# --- Runs -----------------------------------------------------------------------------------------


def grid(start: str, stop: str, num: int, **more: str) -> dict[str, Any]:
    """Return an axis of `num` values from `start` to `stop`."""
    return {"from": start, "to": stop, "num": num, **more}


def _axis_order(content: dict[str, Any], prefix: str = "") -> tuple[str, ...]:
    """Return the keys in the order in which a test names them; an unnamed load comes last."""
    keys: list[str] = []
    for name, value in content.items():
        is_section = isinstance(value, dict) and "from" not in value
        if is_section:
            keys += _axis_order(value, f"{prefix}{name}.")
        else:
            keys.append(f"{prefix}{name}")
    return tuple(keys)


def study_of(content: dict[str, Any]) -> Study:
    """Return the study of some content, without a load unless the content has one."""
    whole = {"name": "test", "load": {"mass": ["0 kg"]}, **content}
    return study_from(whole, order=_axis_order(content))


def sweep(folder: Path, content: dict[str, Any]) -> Path:
    """Run a study into a folder; axes vary in the order of `content`."""
    target = RunFolder(folder, Sweep(Plan(study_of(content))))
    with locked(target.path):
        compute_parts(target, RunOptions(), in_threads(1))
    return folder


def table(folder: Path, name: str) -> TableFiles:
    """Open a table of a run."""
    return open_table(folder / f"{name}.parquet")


def designs(folder: Path, content: dict[str, Any]) -> TableFiles:
    """Run a study over 7 angles and open its table of designs."""
    motion = {"elbow_angle": grid("0 deg", "90 deg", 7)}
    whole = {"motion": motion, "output": {"tables": ["designs"]}, **content}
    return table(sweep(folder, whole), "designs")


def states(folder: Path, content: dict[str, Any]) -> TableFiles:
    """Run a study over 16 angles and open its table of states."""
    motion = {"elbow_angle": grid("0 deg", "90 deg", 16)}
    return table(sweep(folder, {"motion": motion, **content}), "states")


def select(rows: Any, **equal: Any) -> Any:
    """Return the rows of a data frame in which some columns have given values."""
    for name, value in equal.items():
        rows = rows[rows[name] == value]
    return rows


# --- Contents of a figure -------------------------------------------------------------------------


def figures_of(files: TableFiles, **spec: Any) -> list[Any]:
    """Draw a table and return the figure of each page."""
    return [page.figure for page in pages_of(files, figure_spec(**spec))]


def figure_of(files: TableFiles, **spec: Any) -> Any:
    """Draw a table on a single page and return its figure."""
    (figure,) = figures_of(files, **spec)
    return figure


def panels(figure: Any) -> list[Any]:
    """Return the visible axes, without those of colour bars."""
    return [axes for axes in figure.axes if axes.get_visible() and axes.get_label() != "<colorbar>"]


def lines(axes: Any, gid: str = "curve") -> list[Any]:
    """Return the lines of a panel that have an identifier."""
    return [line for line in axes.lines if line.get_gid() == gid]


def by_gid(holder: Any, gid: str) -> list[Any]:
    """Return the artists of a figure or panel that have an identifier."""
    return list(holder.findobj(lambda artist: artist.get_gid() == gid))


def covers(area: Any, across: float, up: float) -> bool:
    """Return True if a point of a map lies in an area, or within a line around cells."""
    return any(path.contains_point((across, up)) for path in area.get_paths())


def words(figure: Any) -> str:
    """Return every text of a figure, a line each."""
    return "\n".join(text.get_text() for text in figure.findobj(Text))
