"""The page of a sweep: its answer, its maps, the states behind them, its table and its record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.axes import thinned
from tendon_cli.cube.columns import TRUTHS, Values
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.results import Run
from tendon_cli.reports import html
from tendon_cli.reports.data import (
    PageAxis,
    number_record,
    packed_classes,
    page_axes,
    page_data,
    thinning_text,
    truths_record,
    within_size,
)
from tendon_cli.reports.states import MOST_DESIGNS, curves, states_record
from tendon_cli.studies.axes import space_of
from tendon_cli.summary import run_facts, run_head
from tendon_cli.tables.read import open_table

WORTH = (
    "margin", "pretension_from", "pretension_to", "required_pretension", "max_tension", "max_spring_extension",
    "peak_motor_torque", "min_elbow_stiffness", "max_contact_pressure", "min_flexor_tension", "min_extensor_tension",
    "max_slack", "slack_fraction", "unstable_fraction",
)  # fmt: skip
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


def sweep_page(folder: Path, run: Run) -> str:
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
    shown = [*({"axis": at} for at in range(len(axes))), *({"quantity": at} for at in range(len(maps)))]
    listed = {"rows": rows.size, "columns": [*shown, *truths_record({name: columns[name] for name in TRUTHS})]}
    data = page_data(
        axes=[axis.record() for axis in axes], quantities=maps, states=states, arms=arms,
        table=listed,
    )  # fmt: skip
    remarks = thinning_text(axes, left_out)
    if cube.study["motion"].get("trajectory"):
        remarks.append(_SLOWLY)
    answer = html.blocks([say.sentence(run_head(run))]) + html.table((), run_facts(run))
    answer += html.notes([f"Warning: {each}" for each in run.record["warnings"]], "warning") + html.notes(remarks)
    parts = {
        **({"map": ("Map", "Map of the designs", html.part("map"))} if axes else {}),
        "design": ("One design", "The states of one design", html.part("states")),
        "list": ("Table", "All designs of this page", html.part("table")),
    }
    return html.result_page(run.record, "a sweep", ("What came out", answer), parts, cube.study, data)


def _columns(cube: Cube) -> list[str]:
    """Numbers that are results, the most wanted first."""
    known = [name for name, quantity in cube.columns.items() if quantity is not None]
    keys = {axis.column for axis in cube.axes}
    results = known[known.index("min_flexor_tension") :]
    return [*(name for name in WORTH if name in results), *(n for n in results if n not in WORTH and n not in keys)]


def _outcomes(columns: Mapping[str, Values], no_equilibrium: npt.NDArray[np.bool_]) -> dict[str, Any]:
    """What each design comes to, as a map of classes."""
    worst = np.where(columns["feasible"], 0, 1)
    worst = np.where(columns["stable"], worst, 2)
    worst = np.where(columns["taut"], worst, 3)
    values = np.where(no_equilibrium, 4, worst)
    about = {"name": "outcome", "label": "what a design comes to", "unit": ""}
    return {**about, "classes": list(_CLASSES), "array": packed_classes(values)}


def _states(cube: Cube, axes: Sequence[PageAxis]) -> tuple[Any, Any]:
    kept, space = thinned([len(axis.kept) for axis in axes], MOST_DESIGNS), space_of(cube.asked)
    places = {each.axis.column: each.kept[at] for each, at in zip(axes, kept, strict=True)}
    rows = cube.rows(list(places), places).ravel()
    design = space.at(space.numbers(rows)).design()
    return states_record(cube.asked, kept, [("", curves(cube.asked, design, (len(rows),)))])
