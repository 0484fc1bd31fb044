"""From a folder to its page: of a sweep, with its maps, states and table, of an answer, or of the paper."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.columns import TRUTHS, Values
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.results import AnyResult, Run, folder_of, verified_record
from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import open_file, output_errors, read_file, result_path, write_whole
from tendon_cli.reports import html
from tendon_cli.reports.data import (
    MOST_DESIGNS,
    PageAxis,
    curves,
    number_record,
    packed_classes,
    page_axes,
    page_data,
    rows_with_states,
    states_record,
    thinning_text,
    truths_record,
    within_size,
)
from tendon_cli.reports.design_page import design_page
from tendon_cli.reports.html import MARK
from tendon_cli.studies.spaces import space_of
from tendon_cli.summary import run_facts, run_head
from tendon_cli.tables.read import open_table

NAME, LEDGER = "report.html", "ledger.json"
_MOST_PICTURES, _MOST_DATA = 3_000_000, 10**6
"""Bytes of all figures of the paper together, those beyond are named; and of what it found."""
_FIELDS = ("id", "verdict", "finding", "value")


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
"""Columns of designs in the order in which they earn their room on the page; all others follow."""

_CLASSES = (
    {"label": "feasible", "sign": "F", "colour": "feasible"},
    {"label": "beyond a limit", "sign": "L", "colour": "beyond"},
    {"label": "unstable", "sign": "U", "colour": "unstable"},
    {"label": "slack", "sign": "S", "colour": "slack"},
    {"label": "no equilibrium", "sign": "N", "colour": "nowhere"},
)
"""What a design comes to, the best first; signs say what colours do."""
_SLOWLY = "One design is shown over the angle, moved slowly; `tendon plot` draws its motion in time, with inertia."


def write_report(result: AnyResult, out: str | PathLike[str] | None = None) -> Path:
    """Write one HTML page of a run, an answer or the reproduced paper, with everything in it; returns its path.

    By default it is `report.html` in the folder of the result. Raises InputError for any other folder, UsageError if
    something else stands under that name, OutputError.

    >>> import tendon_cli as tendon
    >>> tendon.report(tendon.sweep({}, "results/mine"), "page.html")
    PosixPath('page.html')
    """
    folder = folder_of(result)
    target = folder / NAME if out is None else result_path(out)
    if not _is_ours(target):
        raise UsageError(
            "is no page of tendon, and is left as it is", where=str(target), hint="another --out"
        )
    page = _page_of(folder)
    write_whole(target, page.encode())
    return target


def _page_of(folder: Path) -> str:
    if (folder / LEDGER).exists():
        return _paper_page(folder)
    record = verified_record(folder)
    return (
        design_page(folder, record)
        if record["verb"] == "design"
        else _sweep_page(folder, Run(record, folder))
    )


def _is_ours(target: Path) -> bool:
    """Whether a name is free, or bears a page that was written here before."""
    with output_errors(target):
        if not target.exists():
            return True
        with open_file(target) as file:
            return MARK.encode() in file.read(4096)


def _paper_page(folder: Path) -> str:
    """The page of what `tendon paper` left in a folder; raises InputError for a damaged ledger."""
    try:
        entries = json.loads(read_file(folder / LEDGER, _MOST_DATA))
        rows = [tuple(str(entry[name]) for name in _FIELDS) for entry in entries]
    except (OSError, ValueError, KeyError, TypeError) as error:
        hint = "`tendon paper` writes it anew"
        raise InputError(f"is no ledger: {error}", where=str(folder / LEDGER), hint=hint) from None
    pictures, left_out = _pictures(folder)
    table = html.table(("id", "verdict", "what the paper says", "result"), rows)
    parts = [
        html.head(
            "The paper, reproduced",
            "findings and claims, each with its number",
            {"ledger": "Findings", "figures": "Figures"},
        ),
        html.section("ledger", "Findings and claims", table),
        html.section("figures", "Figures", pictures + html.notes(left_out, "warning")),
    ]
    return html.html_page("The paper, reproduced", parts, page_data())


def _pictures(folder: Path) -> tuple[str, list[str]]:
    room, pictures, left_out = _MOST_PICTURES, [], []
    for file in sorted(folder.glob("*.png")):
        if file.stat().st_size > room:
            left_out.append(f"{file.name} is not on this page, which is kept small")
            continue
        content = file.read_bytes()
        room -= len(content)
        data = base64.b64encode(content).decode("ascii")
        name = escape(file.stem)
        image = f'<img src="data:image/png;base64,{data}" alt="{name}">'
        pictures.append(f"<figure>{image}<figcaption>{name}</figcaption></figure>")
    return "".join(pictures), left_out


def _sweep_page(folder: Path, run: Run) -> str:
    """The page of a finished sweep's folder."""
    table = open_table(folder / "designs.parquet")
    cube = cube_of(table)
    axes = page_axes(cube)
    positions = {each.axis.column: each.kept for each in axes}
    rows = cube.rows(list(positions), positions)
    names = _columns(cube)
    columns = cube.gather(rows, [*names, *TRUTHS, "slack_fraction", "min_elbow_stiffness"])
    nowhere = np.isnan(columns["min_elbow_stiffness"]) & (columns["slack_fraction"] > 0)
    records = (number_record(cube.shown(name), columns[name]) for name in names)
    maps, left_out = within_size([_outcomes(columns, nowhere), *records])
    states, arms = _states(cube, axes)
    shown = [
        *({"axis": at} for at in range(len(axes))),
        *({"quantity": at} for at in range(len(maps))),
    ]
    listed = {
        "rows": rows.size,
        "columns": [*shown, *truths_record({name: columns[name] for name in TRUTHS})],
    }
    data = page_data(
        axes=[axis.record() for axis in axes],
        quantities=maps,
        states=states,
        arms=arms,
        table=listed,
    )
    remarks = thinning_text(axes, left_out)
    if cube.study["motion"].get("trajectory"):
        remarks.append(_SLOWLY)
    answer = html.blocks([say.sentence(run_head(run))]) + html.table((), run_facts(run))
    answer += html.notes(
        [f"Warning: {each}" for each in run.record["warnings"]], "warning"
    ) + html.notes(remarks)
    parts = {
        **({"map": ("Map", "Map of the designs", html.part("map"))} if axes else {}),
        "design": ("One design", "The states of one design", html.part("states")),
        "list": ("Table", "All designs of this page", html.part("table")),
    }
    return html.result_page(
        run.record, "a sweep", ("What came out", answer), parts, cube.study, data
    )


def _columns(cube: Cube) -> list[str]:
    """Numbers that are results, the most wanted first."""
    known = [name for name, quantity in cube.columns.items() if quantity is not None]
    keys = {axis.column for axis in cube.axes}
    results = known[known.index("min_flexor_tension") :]
    return [
        *(name for name in _FIRST if name in results),
        *(n for n in results if n not in _FIRST and n not in keys),
    ]


def _outcomes(
    columns: Mapping[str, Values], no_equilibrium: npt.NDArray[np.bool_]
) -> dict[str, Any]:
    """What each design comes to, as a map of classes."""
    worst = np.where(columns["feasible"], 0, 1)
    worst = np.where(columns["stable"], worst, 2)
    worst = np.where(columns["taut"], worst, 3)
    values = np.where(no_equilibrium, 4, worst)
    about = {"name": "outcome", "label": "what a design comes to", "unit": ""}
    return {**about, "classes": list(_CLASSES), "array": packed_classes(values)}


def _states(cube: Cube, axes: Sequence[PageAxis]) -> tuple[Any, Any]:
    (kept, rows), space = rows_with_states(cube, axes, MOST_DESIGNS), space_of(cube.asked)
    design = space.at(space.numbers(rows)).design()
    return states_record(cube.asked, kept, [("", curves(cube.asked, design, (len(rows),)))])
