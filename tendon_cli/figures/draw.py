"""Draw figures of a table or a run. Studies, commands and Python describe them by `FigureSpec`.

The modules that draw are imported when something is drawn, so that the figures of a study are
checked without matplotlib.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tendon_cli import say
from tendon_cli.cube.columns import column_named
from tendon_cli.cube.cube import Cube, cube_of, cube_to_come
from tendon_cli.cube.source import table_in
from tendon_cli.errors import Fault, InputError, OutputError, StudyError, TendonError, UsageError
from tendon_cli.figures.layout import (
    MOST_NUMBERS,
    CurvePlan,
    has_many_rows,
    is_table_of_loads,
    long_axes,
    map_axes,
    numbers_of_many_rows,
    plan_curves,
)
from tendon_cli.model.kinematics import Rows
from tendon_cli.studies.figures import FigureSpec, read_size
from tendon_cli.studies.filters import Condition
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.study import Study, keys
from tendon_cli.tables.read import AnyTable, open_table
from tendon_cli.verbs.registry import by_name

if TYPE_CHECKING:
    from tendon_cli.figures.backend import Figure
    from tendon_cli.figures.frame import Page

Finish = Callable[[FigureSpec, "Figure"], None]
"""Function that adds to a figure before it is written; matplotlib is in the house style then."""


def plot(
    source: Path | AnyTable,
    spec: FigureSpec | None = None,
    out: Path | None = None,
    *,
    overwrite: bool = False,
) -> list[Path]:
    """Draw a figure of a table.

    Args:
        source: A table, its file, or the folder of a run. Of a run the table is drawn that has the
            quantities of the figure.
        spec: The figure; by default the usual one of the table.
        out: A file, whose ending gives the format, or a folder; by default the working directory.
        overwrite: True to replace files that tendon did not write.

    Returns:
        The files, page by page. Further pages have _2, _3 before the ending.

    Raises:
        UsageError: The figure does not fit the table, or tendon did not write a file.
        InputError: The table is of another kind.
        OutputError: A file cannot be written.
    """
    spec = spec or FigureSpec()
    cube = cube_of(table_of(source, spec) if isinstance(source, Path) else source)
    targets = _targets(cube, spec, out)
    return _save_pages(_pages(cube, spec), targets, overwrite=overwrite)


def pages_of(
    table: AnyTable,
    spec: FigureSpec | None = None,
    finish: Finish | None = None,
    study: Study | None = None,
) -> list[Page]:
    """Draw the pages of a figure.

    By default states are drawn as curves, and designs as slack maps if two axes other than the load
    have several values.

    Args:
        table: The table.
        spec: The figure; by default the usual one of the table.
        finish: Function that adds to each page.
        study: Study of the table, if the caller has it already.

    Raises:
        UsageError: The figure does not fit the table.
        InputError: The table is of another kind.
    """
    return _pages(cube_of(table, study), spec or FigureSpec(), finish)


def _pages(cube: Cube, spec: FigureSpec, finish: Finish | None = None) -> list[Page]:
    """Draw the pages of a figure. Raise UsageError if it does not fit the table."""
    from tendon_cli.figures.style import house_style

    with house_style(say.joint_name(cube.document)):
        pages = _draw_pages(cube, spec)
        if finish is not None:
            for page in pages:
                finish(spec, page.figure)
    return pages


def check_figures_of(study: Study) -> None:
    """Check that every declared figure of a study has something to draw.

    Matplotlib is not imported for it. A figure that it accepts may still come out empty; `draw_run`
    then warns of it.

    Raises:
        StudyError: Some figures have nothing to draw.
    """
    faults: list[Fault] = []
    for place, spec in enumerate(study.figure):
        key = f"figure.{place}"
        name = f'figure "{spec.name}"'
        if spec.table == "designs" and spec.table not in study.output.tables:
            quantity = spec.quantity[0]
            problem = f"{name}: {quantity} is in the table of designs, which is not written"
            hint = '[output] tables needs "designs"'
            faults.append(Fault(f"{key}.quantity", problem, hint))
            continue
        try:
            cube = cube_to_come(study, spec.table)
            _plan(cube, spec)
            null = [quantity for quantity in spec.quantity if cube.is_null(quantity)]
            if len(null) == len(spec.quantity):
                problem = f"{name}: {', '.join(null)}: null in every row of this study"
                faults.append(Fault(f"{key}.quantity", problem))
        except UsageError as error:
            option = (error.where or "").replace("--", ".")
            faults.append(Fault(f"{key}{option}", f"{name}: {error.message}", error.hint))
    if faults:
        raise StudyError(faults)


def draw_run(
    study: Study, folder: Path, out: Path | None = None, record: dict[str, Any] | None = None
) -> tuple[list[str], list[str], str | None]:
    """Draw the slack maps of a finished run, and the figures that its study declares.

    A figure never costs a run: errors become warnings, unless a table is damaged.

    Args:
        study: The study of the run.
        folder: Folder of the run.
        out: Folder of the figures; by default that of the run.
        record: Record of the run, if the caller has it already.

    Returns:
        The names of the files; warnings of what could not be drawn; and the reason why there is no
        slack map, None if there is one or nobody expects one.

    Raises:
        InputError: A table is damaged.
    """
    files: list[Path] = []
    warnings: list[str] = []
    no_map = None
    records = None if record is None else by_name(record)
    if "designs" in study.output.tables:
        try:
            files += _slack_maps(study, folder, out or folder, records)
        except InputError:
            raise
        except UsageError as error:
            expects_map = record is None or (not study.figure and record["designs"] > 1)
            no_map = error.message if expects_map else None
        except Exception as error:  # noqa: BLE001 - whatever it is, the run is valid
            warnings.append(f"the slack map is not drawn: {_reason(error)}")
    for spec in study.figure:
        try:
            files += draw_declared(spec, folder, out, study=study, records=records)
        except InputError:
            raise
        except Exception as error:  # noqa: BLE001 - whatever it is, the run is valid
            warnings.append(f'figure "{spec.name}" is not drawn: {_reason(error)}')
    return [file.name for file in files], warnings, no_map


def draw_declared(
    spec: FigureSpec,
    run: Path,
    out: Path | None = None,
    finish: Finish | None = None,
    study: Study | None = None,
    records: Mapping[str, Any] | None = None,
    *,
    overwrite: bool = False,
) -> list[Path]:
    """Draw a figure that a study declares from the tables of a run, in each of its formats.

    Args:
        spec: The figure.
        run: Folder of the run.
        out: Folder of the figure; by default that of the run.
        finish: Function that adds to each page.
        study: Study of the run, if the caller has it already.
        records: Records in the folder by the names of their files, if the caller has them already.

        overwrite: True to replace files that tendon did not write.

    Returns:
        The files.

    Raises:
        UsageError: The figure does not fit the tables, or tendon did not write a file.
        InputError: A table is damaged or missing.
        OutputError: A file cannot be written.
    """
    table = table_of(run, spec, spec.table, study, records)
    pages = pages_of(table, spec, finish, study)
    return _save_pages(pages, declared_files(spec, out or run), overwrite=overwrite)


def declared_files(spec: FigureSpec, folder: Path) -> list[Path]:
    """Return the files of the first page of a declared figure, one for each format."""
    return [folder / f"{spec.name}.{kind}" for kind in dict.fromkeys(spec.format)]


def table_of(
    path: Path,
    spec: FigureSpec,
    wanted: str | None = None,
    study: Study | None = None,
    records: Mapping[str, Any] | None = None,
) -> AnyTable:
    """Open a table from its file, or from a run's folder the one that has the figure's columns.

    A map over two axes is of designs.

    Args:
        path: File of a table, or folder of a run.
        spec: The figure.
        wanted: Kind of the table to open; None if the columns decide.
        study: Its study, if the caller has it already.
        records: Records in the folder by the names of their files, if the caller has them already.

    Raises the errors of `table_in`.
    """
    inputs = {key.column for path_, key in keys().items() if not path_.startswith("motion.")}
    drawn = [column_named(name) for name in (spec.x, *spec.quantity) if name]
    if wanted is None and len(inputs.intersection(drawn)) > 1 and spec.x is not None:
        wanted = "designs"
    columns = spec.named_columns
    return table_in(path, wanted, columns, is_drawn=True, study=study, records=records)


def _plan(
    cube: Cube, spec: FigureSpec
) -> tuple[tuple[Axis, Axis] | CurvePlan, dict[str, Rows], list[Condition]]:
    """Lay out a figure of a table.

    Designs are a map over the axes that the user names with -x and -y, or over their two longest.

    Returns:
        The axes of a map, or the layout of curves; the positions to choose from, by the column of
        the axis; and the conditions that rows must meet.

    Raises:
        UsageError: The figure does not fit the table.
    """
    conditions = cube.conditions(spec.filters)
    chosen = cube.choose(conditions)
    on_axes = all(
        cube.axis(condition.column) or condition.column in cube.columns_of_names
        for condition in conditions
    )
    if cube.kind == "designs" and on_axes and not spec.panels:
        x = None if spec.x is None else cube.axis(column_named(spec.x))
        named = [cube.axis(column_named(name)) for name in spec.quantity]
        y = next((axis for axis in named if axis is not None), None)
        is_plain = not (spec.quantity or spec.x or spec.colour)
        is_usual = len(long_axes(cube, chosen)) > 1 or is_table_of_loads(cube, chosen)
        if (is_plain and is_usual) or (y is not None and (x is not None or spec.x is None)):
            axes = map_axes(cube, chosen, x, y)
            if axes is not None:
                return axes, chosen, conditions
    return plan_curves(cube, chosen, spec), chosen, conditions


def _draw_pages(cube: Cube, spec: FigureSpec) -> list[Page]:
    width, height = read_size(spec.size)
    plan, chosen, conditions = _plan(cube, spec)
    if isinstance(plan, tuple):
        from tendon_cli.figures.maps import draw_maps

        pages = draw_maps(cube, plan, chosen, spec, width, height)
    else:
        from tendon_cli.figures.curves import curve_data, draw_curves

        pages = draw_curves(curve_data(cube, plan, conditions, spec), width, height)
    if height is not None:
        for page in pages:
            page.check_fits()
    return pages


def _slack_maps(
    study: Study, run: Path, folder: Path, records: Mapping[str, Any] | None
) -> list[Path]:
    """Draw slack_map.png, and slack_map_2.png and so on if the panels need more pages.

    Designs along one axis are drawn as lines, and those of many rows as points over each number.
    """
    cube = cube_of(open_table(run / "designs.parquet", records), study)
    axes = long_axes(cube, cube.choose([]))
    if not axes:
        raise UsageError("no axis other than the load has more than one value")
    specs = [FigureSpec()]
    if has_many_rows(axes):
        names = numbers_of_many_rows(cube)[:MOST_NUMBERS]
        specs = [FigureSpec(x=name) for name in names] or specs
    pages = [page for spec in specs for page in _pages(cube, spec)]
    return _save_pages(pages, [folder / "slack_map.png"])


def _save_pages(pages: list[Page], targets: list[Path], *, overwrite: bool = False) -> list[Path]:
    """Write pages to each target, with a number in the name from the second page on."""
    from tendon_cli.figures.frame import numbered, save_pages

    files = [file for target in targets for file in numbered(pages, target)]
    return save_pages(files, overwrite=overwrite)


def _targets(cube: Cube, spec: FigureSpec, out: Path | None) -> list[Path]:
    """Return the file of the first page in each format."""
    from tendon_cli.figures.style import format_of

    if out is not None and not out.is_dir():
        format_of(out, "--out")
        return [out]
    name = spec.name
    if not name:
        study = re.sub(r"[^\w.-]+", "_", str(cube.document.get("name", "")))
        name = "-".join(word for word in (study, cube.kind, *spec.quantity[:3]) if word)
    return [(out or Path()) / f"{name}.{kind}" for kind in spec.format]


def _reason(error: Exception) -> str:
    """Return the reason why a figure is not drawn."""
    if not isinstance(error, TendonError):
        return f"{type(error).__name__}: {error}; this is a bug in tendon, the tables are whole"
    place = f"{error.where}: " if isinstance(error, OutputError) else ""
    hint = f" ({error.hint})" if error.hint else ""
    return f"{place}{error.message}{hint}"
