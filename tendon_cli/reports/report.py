"""Write the HTML page of the results in a folder: a sweep or an answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

from tendon_cli import say
from tendon_cli.cube.columns import TRUTHS, ColumnArray
from tendon_cli.cube.cube import Cube, cube_in
from tendon_cli.cube.outcomes import OF_OUTCOMES, OUTCOMES, outcomes
from tendon_cli.cube.room import bounded_column, is_default
from tendon_cli.engine.results import AnyResult, Result, Run, folder_of, open_result
from tendon_cli.engine.sweep_kind import DEFINING
from tendon_cli.files import check_output, result_path, write_output
from tendon_cli.reports import html
from tendon_cli.reports.data import (
    MOST_BYTES_OF_PAGE,
    MOST_CELLS,
    PageAxis,
    curves,
    given_columns,
    given_records,
    middle_of,
    most_designs,
    number_record,
    pack_classes,
    page_axes,
    page_data,
    rows_with_states,
    samples_text,
    states_record,
    thinning_text,
    truths_record,
    within_size,
)
from tendon_cli.reports.html import MARK
from tendon_cli.studies.spaces import space_of
from tendon_cli.verbs.registry import load

_FEWEST_CELLS = 100
"""Cells of a page that is never made smaller."""
NAME = "report.html"
"""Name of the page in the folder of its results."""

_FIRST = (
    "margin",
    "pretension_from",
    "pretension_to",
    "required_pretension",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
    "min_flexor_tension",
    "min_extensor_tension",
    "max_slack",
    "slack_fraction",
    "unstable_fraction",
)
"""Columns of designs that come first on the page, the most useful first; all others follow."""

_CLASSES = [{"label": one.label, "sign": one.letter, "colour": one.colour} for one in OUTCOMES]
"""Outcomes of a design as the scripts of a page take them."""


def write_report(
    result: AnyResult, out: str | PathLike[str] | None = None, *, overwrite: bool = False
) -> Path:
    """Write one HTML page with everything that a run or an answer holds.

    The page needs no network and no other file.

    Args:
        result: A run, an answer, or the folder of one.
        out: File to write; by default `report.html` in the folder of the result.
        overwrite: True to replace a file that tendon did not write.

    Returns:
        Path of the page.

    Raises:
        InputError: The folder holds no such result, or a damaged one.
        UsageError: The file exists and is not a page that tendon wrote.
        OutputError: The page cannot be written.

    >>> import tendon_cli as tendon
    >>> tendon.report(tendon.sweep({}, "results/mine"), "page.html")
    PosixPath('page.html')
    """
    folder = folder_of(result)
    target = folder / NAME if out is None else result_path(out)
    check_output(target, is_page, overwrite=overwrite)
    page = _page(folder)
    write_output(target, page.encode(), is_page, overwrite=overwrite)
    return target


def _page(folder: Path) -> str:
    """Return the page of the results in a folder."""
    result = open_result(folder)
    if not result.kind.page:
        return _plain_page(result)
    most = MOST_CELLS
    while True:
        page: str = load(result.kind.page)(result, most)
        if len(page) <= MOST_BYTES_OF_PAGE or most <= _FEWEST_CELLS:
            return page
        rows = min(most, max(entry.get("rows", 0) for entry in result.record["files"]))
        most = min(rows * MOST_BYTES_OF_PAGE // len(page), most // 2)


def _plain_page(result: Result) -> str:
    """Return the page of a result of any task: its text, its study and its record."""
    answer = html.blocks([say.sentence(line) for line in result.text.splitlines()])
    answer += html.notes([f"Warning: {text}" for text in result.record["warnings"]], "warning")
    section = ("What came out", answer)
    record = result.record
    return html.result_page(record, result.kind.noun, section, {}, record["study"], page_data())


def is_page(file: BinaryIO) -> bool:
    """Return True if a file is a page that tendon wrote."""
    return MARK.encode() in file.read(4096)


def sweep_page(run: Run, most: int) -> str:
    """Return the page of a finished sweep with at most so many designs."""
    cube = cube_in(run, "designs")
    axes = page_axes(cube, most)
    positions = {axis.axis.column: axis.positions for axis in axes}
    rows = cube.rows(list(positions), positions)
    names = _results(cube)
    given = [
        name for name in dict.fromkeys((*DEFINING, *given_columns(cube))) if name in cube.columns
    ]
    columns = cube.gather(rows, [*names, *given, *TRUTHS, *OF_OUTCOMES])
    records = (number_record(cube.shown(name), columns[name]) for name in names)
    maps, left_out = within_size([_outcomes(columns), *records])
    states, arms = _states(cube, axes)
    table_columns: list[dict[str, Any]] = [{"axis": index} for index in range(len(axes))]
    table_columns += [{"quantity": index} for index in range(len(maps))]
    table_columns += truths_record({name: columns[name] for name in TRUTHS})
    table_columns += given_records(cube, axes, {name: columns[name] for name in given})
    data = page_data(
        axes=[axis.record() for axis in axes],
        quantities=maps,
        states=states,
        arms=arms,
        table={"rows": rows.size, "columns": table_columns},
        start=middle_of(axes, columns["feasible"].astype(bool)),
    )

    warnings = [f"Warning: {warning}" for warning in run.record["warnings"]]
    remarks = [*thinning_text(axes, left_out), *samples_text(run.study)]
    answer = html.blocks([say.sentence(run.head())])
    answer += html.table((), run.facts())
    answer += html.notes(warnings, "warning")
    answer += html.notes(remarks)
    parts: dict[str, html.Part] = {}
    if axes:
        parts["map"] = ("Map", "Map of the designs", html.part("map"))
    is_in_time = run.study.trajectory is not None
    states_part = html.part("states", is_in_time=is_in_time)
    parts["design"] = ("One design", "The states of one design", states_part)
    parts["list"] = ("Table", "All designs of this page", html.part("table"))
    return html.result_page(
        run.record, run.kind.noun, ("What came out", answer), parts, cube.document, data
    )


def _results(cube: Cube) -> list[str]:
    """Return the columns of numbers that are results, the most useful first.

    After the margin come those that the study limits: a page that has no room for all has these.
    """
    numbers = [name for name, quantity in cube.columns.items() if quantity is not None]
    axis_columns = {axis.column for axis in cube.axes}
    results = numbers[numbers.index("min_flexor_tension") :]
    stated = [name for name, bound in cube.limits.items() if not is_default(name, bound)]
    limited = [bounded_column(name) for name in stated]
    most_useful = dict.fromkeys([_FIRST[0], *limited, *_FIRST[1:], *results])
    wanted = {*results, *limited}.intersection(numbers)
    return [name for name in most_useful if name in wanted and name not in axis_columns]


def _outcomes(columns: Mapping[str, ColumnArray]) -> dict[str, Any]:
    """Return the map of the outcomes of all designs, as classes."""
    about = {"name": "outcome", "label": "outcome", "unit": ""}
    return {**about, "classes": _CLASSES, "array": pack_classes(outcomes(columns))}


def _states(cube: Cube, axes: Sequence[PageAxis]) -> tuple[Any, Any]:
    """Return the states of some designs as curves, and their arms, as `states_record` does."""
    positions, rows = rows_with_states(cube, axes, most_designs(cube.study))
    space = space_of(cube.study)
    design = space.at(space.numbers(rows)).design()
    result = curves(cube.study, design, (len(rows),))
    return states_record(cube.study, positions, [("", result)])
