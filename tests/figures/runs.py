"""Small runs to draw, computed as `tendon sweep` does, and what stands in a figure."""

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

LOADS = ["0 kg", "3 kg", "5 kg", "10 kg"]


def grid(start: str, stop: str, num: int, **more: str) -> dict[str, Any]:
    return {"from": start, "to": stop, "num": num, **more}


def _axis_order(content: dict[str, Any], prefix: str = "") -> tuple[str, ...]:
    """Keys in the order in which a test speaks of them; the load is last unless it is spoken of."""
    found: list[str] = []
    for name, value in content.items():
        is_part = isinstance(value, dict) and "from" not in value
        found += _axis_order(value, f"{prefix}{name}.") if is_part else [f"{prefix}{name}"]
    return tuple(found)


def study_of(content: dict[str, Any]) -> Study:
    return study_from(
        {"name": "test", "load": {"mass": ["0 kg"]}, **content}, order=_axis_order(content)
    )


def sweep(folder: Path, content: dict[str, Any]) -> Path:
    """Run a study into a folder; axes vary in the order of `content`."""
    target = RunFolder(folder, Sweep(Plan(study_of(content))))
    with locked(target.path):
        compute_parts(target, RunOptions(), in_threads(1))
    return folder


def table(folder: Path, name: str) -> TableFiles:
    return open_table(folder / f"{name}.parquet")


def designs(folder: Path, content: dict[str, Any]) -> TableFiles:
    angles = {"motion": {"elbow_angle": grid("0 deg", "90 deg", 7)}}
    return table(sweep(folder, {**angles, "output": {"tables": ["designs"]}, **content}), "designs")


def states(folder: Path, content: dict[str, Any]) -> TableFiles:
    angles = {"motion": {"elbow_angle": grid("0 deg", "90 deg", 16)}}
    return table(sweep(folder, {**angles, **content}), "states")


# --- What stands in a figure ----------------------------------------------------------------------


def figures_of(of: TableFiles, **spec: Any) -> list[Any]:
    return [page.figure for page in pages_of(of, figure_spec(**spec))]


def figure_of(of: TableFiles, **spec: Any) -> Any:
    (figure,) = figures_of(of, **spec)
    return figure


def panels(figure: Any) -> list[Any]:
    return [axes for axes in figure.axes if axes.get_visible() and axes.get_label() != "<colorbar>"]


def lines(axes: Any, gid: str = "curve") -> list[Any]:
    return [line for line in axes.lines if line.get_gid() == gid]


def by_gid(holder: Any, gid: str) -> list[Any]:
    return list(holder.findobj(lambda artist: artist.get_gid() == gid))


def words(figure: Any) -> str:
    return "\n".join(text.get_text() for text in figure.findobj(Text))
