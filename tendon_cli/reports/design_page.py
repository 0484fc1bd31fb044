"""The page of an answer: the answer, maps of the choices, their windows and front, and the states behind them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import question
from tendon_cli.cube.axes import evenly, thinned
from tendon_cli.cube.columns import as_numpy
from tendon_cli.cube.labels import Shown
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.reports import html
from tendon_cli.reports.data import NO_DATA
from tendon_cli.reports.packed import packed, packed_classes
from tendon_cli.reports.people import people_record
from tendon_cli.reports.product import MOST_CELLS, PageAxis, number_record, quantities, said_of_thinning
from tendon_cli.reports.states import MOST_DESIGNS, OF_TAUT, curves, states_record
from tendon_cli.reports.sweep_page import ending
from tendon_cli.space.axis import Axis
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.study import keys
from tendon_cli.tables.read import TableFiles, open_table

RESULTS = (
    "tolerance", "served", "pretension", "pretension_from", "pretension_to", "max_tension", "max_spring_extension",
    "peak_motor_torque", "min_elbow_stiffness", "max_contact_pressure",
)  # fmt: skip
GOALS = ("tolerance", "served", "pretension", "max_tension", "max_spring_extension", "peak_motor_torque")
MOST_CONDITIONS = 4
"""Whose states the page keeps, evenly chosen."""

_COLOURS = ("slack", "unstable", "beyond", "nowhere")


def design_page(folder: Path, record: dict[str, Any]) -> str:
    """The page of the answer in a folder, opened by `open_answer`."""
    table = open_table(folder / "choices.parquet")
    problem = question(recorded_study(table.facts["study"]))
    axes = [_axis(factor, kept) for factor, kept in _kept(problem)]
    rows = _rows(problem, table, axes)
    whole = table.read()
    kept = pa.Array.from_buffers(pa.int64(), len(rows), [None, pa.py_buffer(rows)])  # pa.array() imports pandas
    choices = whole.take(kept)
    columns = {name: as_numpy(choices.column(name)) for name in RESULTS if name in choices.schema.names}
    columns = {name: values for name, values in columns.items() if np.isfinite(values).any()}
    labels = {name: Shown.of(name, QUANTITIES[name]) for name in columns}
    cells = int(np.prod([len(axis.kept) for axis in axes]))
    maps, left_out = quantities({name: values[:cells] for name, values in columns.items()}, labels)
    maps.insert(1, _conflicts(choices.slice(0, cells)))
    states, arms = _states(problem, axes, columns["pretension"][:cells])
    people = people_record(problem, whole, record.get("population"))
    data = NO_DATA | {
        "kind": "design", "axes": [axis.record() for axis in axes], "quantities": maps, "states": states, "arms": arms,
        "design": _answers(choices, columns, labels, cells), "table": _table(problem, axes, choices, columns, labels),
        "start": _start(record, axes), "people": people,
    }  # fmt: skip
    thinning = said_of_thinning(axes, left_out)
    title = record["title"] or record["name"]
    return html.html_page(
        title, _sections(title, record, thinning, has_map=bool(axes), has_people=people is not None), data
    )


def _kept(problem: Problem) -> list[tuple[Axis, npt.NDArray[np.int64]]]:
    factors = problem.choices.axes
    return list(zip(factors, thinned(problem.choices.shape, MOST_CELLS), strict=True))


def _axis(factor: Axis, kept: npt.NDArray[np.int64]) -> PageAxis:
    words = Quantity(factor.column, factor.column, "number", "1", "1", factor.column)
    quantity = words if factor.names else keys()[factor.key].number.quantity
    shown = Shown.of(factor.column, quantity)
    return PageAxis(shown, None if factor.names else factor.values, factor.names, factor.is_log, kept)


def _rows(problem: Problem, table: TableFiles, axes: Sequence[PageAxis]) -> npt.NDArray[np.int64]:
    """Rows of the choices on the page's axes, then those between the points of the grid."""
    grid = np.zeros(1, dtype=np.int64)
    if axes:
        grid = np.ravel_multi_index(np.meshgrid(*(axis.kept for axis in axes), indexing="ij"), problem.choices.shape)
    return np.concatenate([grid.ravel(), np.arange(len(problem.choices), table.rows)])


def _answers(table: pa.Table, columns: Any, labels: Any, cells: int) -> dict[str, Any]:
    """Windows and front, a number a choice."""
    found = {name: number_record(labels[name], values) for name, values in columns.items()}
    found["on_front"] = {"label": "on the front", "unit": "", "array": packed(as_numpy(table.column("on_front")))}
    goals = [name for name in GOALS if name in found]
    shown = [goals.index(name) for name in ("max_tension", "tolerance") if name in goals]
    return {
        "columns": found,
        "texts": {name: table.column(name).to_pylist() for name in ("from_by", "to_by")},
        "rows": list(range(cells)),
        "cells": [row if row < cells else -1 for row in range(table.num_rows)],
        "goals": goals,
        "display": [*shown, 0, min(1, len(goals) - 1)][:2],
    }


def _conflicts(table: pa.Table) -> dict[str, Any]:
    """Which limits leave a choice without a window, as a map of classes."""
    pairs = [
        None if feasible else " against ".join(dict.fromkeys(limit for limit in (low, high) if limit))
        for feasible, low, high in zip(
            *(table.column(n).to_pylist() for n in ("feasible", "from_by", "to_by")), strict=True
        )
    ]
    names = list(dict.fromkeys(pair for pair in pairs if pair is not None))
    classes = [{"label": "has a window", "letter": "W", "colour": "feasible"}]
    classes += [
        {"label": name, "letter": "ABCDEFGHIJ"[at % 10], "colour": _COLOURS[at % len(_COLOURS)]}
        for at, name in enumerate(names)
    ]
    values = [0 if pair is None else 1 + names.index(pair) for pair in pairs]
    return {
        "name": "conflict",
        "label": "what conflicts",
        "unit": "",
        "classes": classes,
        "array": packed_classes(values),
    }


def _table(problem: Problem, axes: Sequence[PageAxis], table: pa.Table, columns: Any, labels: Any) -> dict[str, Any]:
    shown: list[dict[str, Any]] = []
    for factor, axis in zip(problem.choices.axes, axes, strict=True):
        if factor.names:
            shown.append({"label": axis.shown.name, "unit": "", "texts": table.column(factor.column).to_pylist()})
        else:
            shown.append(number_record(axis.shown, as_numpy(table.column(factor.column))))
    shown += [number_record(labels[name], values) for name, values in columns.items()]
    shown += [
        {"label": label, "unit": "", "texts": [text or "none" for text in table.column(name).to_pylist()]}
        for name, label in (("from_by", "bound below by"), ("to_by", "bound above by"))
    ]
    cells = int(np.prod([len(axis.kept) for axis in axes]))
    where = [row if row < cells else -1 for row in range(table.num_rows)]
    return {"rows": table.num_rows, "columns": shown, "cells": where}


def _start(record: dict[str, Any], axes: Sequence[PageAxis]) -> list[int] | None:
    """Where the map opens: at the best choice, or the nearest that the page keeps."""
    best = record.get("best") or {}
    row = next((each for each in (best, *best.values()) if isinstance(each, dict) and "choice" in each), None)
    if row is None or any(axis.values is None for axis in axes):
        return None
    found = []
    for axis in axes:
        value = row.get(axis.shown.column)
        if axis.values is None or not isinstance(value, int | float):
            return None
        found.append(int(np.argmin(np.abs(axis.values[axis.kept] - value))))
    return found


def _states(problem: Problem, axes: Sequence[PageAxis], pretension: npt.NDArray[np.float64]) -> tuple[Any, Any]:
    """Curves of some choices at their pretensions, under a few of the conditions."""
    lengths = [len(axis.kept) for axis in axes]
    few = evenly(len(problem.conditions), MOST_CONDITIONS)
    kept = thinned(lengths, MOST_DESIGNS // len(few))
    cells = np.ravel_multi_index(np.meshgrid(*kept, indexing="ij"), lengths).ravel() if axes else np.zeros(1, np.int64)
    rows = _grid_rows(problem, axes, cells)
    numbers, found = problem.choices.numbers(rows), []
    for at in few:
        design = problem.under(at[np.newaxis]).design(numbers, None, pretension[cells])
        found.append((_said(problem, int(at)), curves(problem.study, design, (len(rows), 1), OF_TAUT)))
    return states_record(problem.study, kept, found)


def _grid_rows(problem: Problem, axes: Sequence[PageAxis], cells: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """The rows of the whole product for cells of the page's."""
    if not axes:
        return cells
    at = np.unravel_index(cells, [len(axis.kept) for axis in axes])
    whole = tuple(axis.kept[index] for axis, index in zip(axes, at, strict=True))
    return np.asarray(np.ravel_multi_index(whole, problem.choices.shape))


def _said(problem: Problem, condition: int) -> str:
    """A condition in words."""
    places = problem.conditions.places(np.array([condition]))
    said = []
    for factor in problem.conditions.axes:
        at = int(places[factor.key][0])
        shown = None if factor.names else Shown.of(factor.column, keys()[factor.key].number.quantity)
        said.append(factor.names[at] if shown is None else f"{shown.name} {shown.text(float(factor.values[at]))}")
    return ", ".join(said)


def _sections(title: str, record: dict[str, Any], thinning: str, *, has_map: bool, has_people: bool) -> list[str]:
    links = {"answer": "Answer", "map": "Map", "windows": "Windows", "front": "Front", "design": "One choice"}
    answer = html.text(record["text"]) + html.warnings([*record["notes"], *([thinning] if thinning else [])])
    parts = [
        html.head(title, f"an answer by tendon, study {record['study_hash'][:12]}", links | {"list": "Table"}),
        html.section("answer", "The answer", answer, "answer"),
    ]
    if has_map:
        parts += [html.section("map", "Map of the choices", html.MAP)]
        parts += [html.section("windows", "Windows of pretension", html.WINDOWS)]
    if has_people:
        parts += [html.section("people", "For whom", html.PEOPLE)]
    return [
        *parts,
        html.section("front", "What is traded for what", html.FRONT),
        html.section("design", "The states of one choice, at its pretension", html.STATES),
        html.section("list", "All choices of this page", html.TABLE),
        *ending(record, record["study"]),
    ]
