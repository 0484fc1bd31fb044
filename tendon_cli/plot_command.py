"""`tendon plot` without its printing: which table is meant, and what is drawn of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tendon_cli.errors import InputError, UsageError
from tendon_cli.figures.arm import draw_arm
from tendon_cli.figures.plot import plot
from tendon_cli.figures.request import PlotRequest
from tendon_cli.figures.route import draw_route
from tendon_cli.study.load import load_study
from tendon_cli.study.reading import read_document
from tendon_cli.study.route import MAX_BYTES, read_route
from tendon_cli.sweep.run_folder import RECORD
from tendon_cli.tables.read import TableFiles, open_table
from tendon_cli.units import UnitError, parse_measure


def table_of(path: Path, wanted: str | None, request: PlotRequest) -> TableFiles:
    """The table that a path means: a table, or of a run folder the one that has what is asked for.

    Raises InputError where there is none, UsageError for a table that the run does not have.
    """
    if not (path / RECORD).exists() and not (path.is_dir() and path.suffix != ".parquet"):
        return open_table(path)
    found = {name: path / f"{name}.parquet" for name in ("states", "designs") if (path / f"{name}.parquet").exists()}
    if not found:
        raise InputError("holds neither designs.parquet nor states.parquet", where=str(path), hint="run `tendon sweep`")
    if wanted is not None:
        if wanted not in found:
            raise UsageError(f'the run has no table "{wanted}"', where=str(path), hint=f"it has {', '.join(found)}")
        return open_table(found[wanted])
    tables = [open_table(file) for file in found.values()]
    asked = {*request.quantities, *(name for name in (request.x,) if name)}
    return next((table for table in tables if asked <= set(table.schema.names)), tables[0])


def draw_table(path: Path, wanted: str | None, request: PlotRequest, out: Path | None) -> list[Path]:
    """Figures of a run folder or of one of its tables; without any wish those that suit the table."""
    return plot(table_of(path, wanted, request), request, out)


def draw_geometry(study_file: Path, settings: tuple[str, ...], angles: Sequence[str], out: Path | None) -> list[Path]:
    """The arm of a study to scale; and the route of its sheath, where it names one."""
    study = load_study(study_file, settings)
    target = out or Path(f"{study.name}-arm.png")
    drawn = [draw_arm(study, [_angle(text) for text in angles], target)]
    sheath = read_document(study_file).content.get("sheath")
    name = sheath.get("path") if isinstance(sheath, dict) else None
    if isinstance(name, str):
        with (study_file.parent / name).open("rb") as file:
            points = read_route(file.read(MAX_BYTES), name)
        drawn.append(draw_route(points, target.with_stem(f"{target.stem}-route")))
    return drawn


def _angle(text: str) -> float:
    try:
        return parse_measure(text, "angle").si
    except UnitError as error:
        raise UsageError(error.problem, where="--angle", hint=error.hint) from None
