"""Figures of a table or a run, by one specification for studies, the command line and Python.

What draws is imported when something is drawn, so that the figures of a study are checked without matplotlib.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from tendon_cli.cube.cube import Cube, cube_of, cube_to_come
from tendon_cli.cube.source import table_of_study
from tendon_cli.errors import Fault, InputError, OutputError, StudyError, TendonError, UsageError
from tendon_cli.figures.layout import CurvePlan, MapPlan, long_axes, plan_curves, plan_maps
from tendon_cli.studies.figures import FigureSpec, read_size
from tendon_cli.studies.filters import Condition
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import AnyTable, open_table

if TYPE_CHECKING:
    from tendon_cli.figures.backend import Figure
    from tendon_cli.figures.frame import Page

Finish = Callable[[FigureSpec, "Figure"], None]
"""Adds to a figure before it is written; matplotlib is in the house style then."""


def plot(
    source: Path | AnyTable, spec: FigureSpec | None = None, out: Path | None = None
) -> list[Path]:
    """Draw a table, or of a run folder the one that has what is asked for; returns the files, page by page.

    `out` is a file (its ending gives the format), or a folder; by default the working directory. Further pages get
    -2, -3 before the ending. Raises UsageError, InputError for a table of another kind, OutputError.
    """
    spec = spec or FigureSpec()
    table = table_of(source, spec) if isinstance(source, Path) else source
    targets = _targets(table, spec, out)
    return _written(pages_of(table, spec), targets)


def pages_of(
    table: AnyTable, spec: FigureSpec | None = None, finish: Finish | None = None
) -> list[Page]:
    """The pages of a figure; raises UsageError where it does not fit the table, InputError for one of another kind.

    Without a wish states are drawn as curves, and designs as slack maps where they have two axes for one.
    """
    from tendon_cli.figures.style import house_style

    spec = spec or FigureSpec()
    cube = cube_of(table)
    with house_style():
        pages = _pages(cube, spec, *_planned(cube, spec))
        for page in pages:
            if finish is not None:
                finish(spec, page.figure)
    return [page.of_joint(cube.study) for page in pages]


def check_figures_of(study: Study) -> None:
    """Raise StudyError for every declared figure that is known beforehand to have nothing to draw.

    Costs no matplotlib. What it lets pass may still come out empty, which `draw_run` then tells as a warning.
    """
    faults: list[Fault] = []
    for at, spec in enumerate(study.figure):
        key = f"figure.{at}"
        if spec.table == "designs" and spec.table not in study.output.tables:
            hint = '[output] tables needs "designs"'
            problem = (
                f'figure "{spec.name}": {spec.quantity[0]} is of designs, which is not written'
            )
            faults.append(Fault(f"{key}.quantity", problem, hint))
            continue
        try:
            cube = cube_to_come(study, spec.table)
            _planned(cube, spec)
            null = [name for name in spec.quantity if cube.is_null(name)]
            if len(null) == len(spec.quantity):
                problem = (
                    f'figure "{spec.name}": {", ".join(null)}: null in every row of this study'
                )
                faults.append(Fault(f"{key}.quantity", problem))
        except UsageError as error:
            problem = f'figure "{spec.name}": {error.message}'
            faults.append(
                Fault(f"{key}{(error.where or '').replace('--', '.')}", problem, error.hint)
            )
    if faults:
        raise StudyError(faults)


def draw_run(
    study: Study, folder: Path, out: Path | None = None
) -> tuple[list[str], list[str], str | None]:
    """Slack maps of a finished run, and the figures that its study declares, into its folder unless `out` says where.

    Returns the names of the files, warnings of what could not be drawn, and why there is no slack map, where there is
    none: a figure never costs a run. Raises InputError only, for a table that is not whole.
    """
    files: list[Path] = []
    warnings: list[str] = []
    no_map = None
    asked: list[tuple[str, FigureSpec | None]] = [
        (f'figure "{spec.name}"', spec) for spec in study.figure
    ]
    for name, spec in [
        *([("the slack map", None)] if "designs" in study.output.tables else []),
        *asked,
    ]:
        try:
            files += (
                draw_declared(spec, folder, out) if spec else _slack_maps(folder, out or folder)
            )
        except InputError:
            raise
        except Exception as error:  # noqa: BLE001 - whatever it is, the run stands
            if spec is None and isinstance(error, UsageError):
                no_map = error.message
            else:
                warnings.append(f"{name} is not drawn: {_reason(error)}")
    return [file.name for file in files], warnings, no_map


def draw_declared(
    spec: FigureSpec, run: Path, out: Path | None = None, finish: Finish | None = None
) -> list[Path]:
    """Draw a declared figure of a run's tables, into its folder unless `out` says where.

    Returns the files written. Raises UsageError where it does not fit the tables, InputError for a damaged or missing
    one, OutputError.
    """
    pages = pages_of(table_of(run, spec, spec.table), spec, finish)
    targets = [(out or run) / f"{spec.name}.{kind}" for kind in dict.fromkeys(spec.format)]
    return _written(pages, targets)


def table_of(path: Path, spec: FigureSpec, wanted: str | None = None) -> AnyTable:
    """The table that a path means, or of a run folder the one that has what is asked for; raises as `table_in`."""
    return table_of_study(path, wanted, spec.asked)


def _planned(cube: Cube, spec: FigureSpec) -> tuple[MapPlan | CurvePlan, list[Condition]]:
    """What a figure shows of a table; raises UsageError where it does not fit."""
    asked = cube.of.conditions(spec.filters)
    chosen = cube.choose(asked)
    is_plain = not (spec.quantity or spec.x or spec.colour or spec.panels)
    on_axes = all(cube.axis(each.column) for each in asked)
    if cube.kind == "designs" and is_plain and on_axes and len(long_axes(cube, chosen)) > 1:
        return plan_maps(cube, chosen), asked
    return plan_curves(cube, chosen, spec), asked


def _pages(
    cube: Cube, spec: FigureSpec, plan: MapPlan | CurvePlan, asked: list[Condition]
) -> list[Page]:
    width, height = read_size(spec.size)
    if isinstance(plan, MapPlan):
        from tendon_cli.figures.map_data import map_data
        from tendon_cli.figures.maps import draw_maps

        return draw_maps(map_data(cube, plan, spec), width, height)
    from tendon_cli.figures.curve_data import curve_data
    from tendon_cli.figures.curves import draw_curves

    return draw_curves(curve_data(cube, plan, asked, spec), width, height)


def _slack_maps(run: Path, folder: Path) -> list[Path]:
    """slack_map.png, and slack_map-2.png and so on where the panels need more pages; of one axis as lines."""
    designs = open_table(run / "designs.parquet")
    cube = cube_of(designs)
    if not long_axes(cube, cube.choose([])):
        raise UsageError("no axis other than the load has more than one value")
    return _written(pages_of(designs), [folder / "slack_map.png"])


def _written(pages: list[Page], targets: list[Path]) -> list[Path]:
    return [
        page.save(target if number == 1 else target.with_stem(f"{target.stem}-{number}"))
        for number, page in enumerate(pages, 1)
        for target in targets
    ]


def _targets(table: AnyTable, spec: FigureSpec, out: Path | None) -> list[Path]:
    """The first file to write in each format."""
    from tendon_cli.figures.style import format_of

    if out is not None and not out.is_dir():
        format_of(out, "--out")
        return [out]
    cube = cube_of(table)
    words = (
        re.sub(r"[^\w.-]+", "_", str(cube.study.get("name", ""))),
        cube.kind,
        *spec.quantity[:3],
    )
    return [
        (out or Path()) / f"{spec.name or '-'.join(filter(None, words))}.{kind}"
        for kind in spec.format
    ]


def _reason(error: Exception) -> str:
    if not isinstance(error, TendonError):
        return f"{type(error).__name__}: {error}; this is a bug in tendon, the tables are whole"
    place = f"{error.where}: " if isinstance(error, OutputError) else ""
    return f"{place}{error.message}{f' ({error.hint})' if error.hint else ''}"
