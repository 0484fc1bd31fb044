"""The page of a sweep: its answer, its maps, the states behind them, its table and its record."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.cube.axes import thinned
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.results import Run
from tendon_cli.reports import html
from tendon_cli.reports.data import NO_DATA
from tendon_cli.reports.product import (
    MOST_CELLS,
    OUTCOME,
    PageAxis,
    outcomes,
    quantities,
    said_of_thinning,
)
from tendon_cli.reports.states import MOST_DESIGNS, curves_of_sweep, states_record
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.study import Study
from tendon_cli.summary import run_text
from tendon_cli.tables.read import open_table

WORTH = (
    "margin", "pretension_from", "pretension_to", "required_pretension", "max_tension", "max_spring_extension",
    "peak_motor_torque", "min_elbow_stiffness", "max_contact_pressure", "min_flexor_tension", "min_extensor_tension",
    "max_slack", "slack_fraction", "unstable_fraction",
)  # fmt: skip
"""Columns of designs in the order in which they earn their room on the page; all others follow."""


def sweep_page(folder: Path, run: Run) -> str:
    """The page of a finished sweep's folder."""
    table = open_table(folder / "designs.parquet")
    cube = cube_of(table)
    axes = _axes(cube)
    positions = {axis.shown.column: axis.kept for axis in axes}
    rows = cube.rows(list(positions), positions)
    names = _columns(cube)
    columns = cube.gather(rows, [*names, "feasible", "stable", "taut", "slack_fraction", "min_elbow_stiffness"])
    nowhere = np.isnan(columns["min_elbow_stiffness"].astype(float)) & (columns["slack_fraction"] > 0)
    chosen = {OUTCOME: outcomes(columns, nowhere)} | {name: columns[name] for name in names}
    labels = {name: cube.shown(name) for name in names}
    maps, left_out = quantities(chosen, labels)
    document = dict(cube.study)
    states, arms = _states(cube, recorded_study(table.facts["study"]), axes)
    data = NO_DATA | {
        "kind": "sweep", "axes": [axis.record() for axis in axes], "quantities": maps, "states": states, "arms": arms,
        "table": _table(axes, maps, rows.size),
    }  # fmt: skip
    record = run.record
    title = record["title"] or record["name"]
    return html.html_page(title, _sections(title, run, document, said_of_thinning(axes, left_out)), data)


def _axes(cube: Cube) -> list[PageAxis]:
    kept = thinned([axis.length for axis in cube.axes], MOST_CELLS)
    found = []
    for axis, positions in zip(cube.axes, kept, strict=True):
        values = axis.values
        names = tuple(str(value) for value in values) if axis.is_text else ()
        label = cube.shown(axis.column)
        found.append(PageAxis(label, None if axis.is_text else values, names, axis.is_log, positions))
    return found


def _columns(cube: Cube) -> list[str]:
    """Numbers that are results, the most wanted first."""
    known = [name for name, quantity in cube.columns.items() if quantity is not None]
    keys = {axis.column for axis in cube.axes}
    results = known[known.index("min_flexor_tension") :]
    return [*(name for name in WORTH if name in results), *(n for n in results if n not in WORTH and n not in keys)]


def _states(cube: Cube, study: Study, axes: Sequence[PageAxis]) -> tuple[Any, Any]:
    kept = thinned([len(axis.kept) for axis in axes], MOST_DESIGNS)
    position = {axis.key: of.kept[at] for axis, of, at in zip(cube.axes, axes, kept, strict=True)}
    found = curves_of_sweep(study, [position[key] for key in study.axes])
    return states_record(study, kept, [("", found)])


def _table(axes: Sequence[PageAxis], maps: Sequence[dict[str, Any]], rows: int) -> dict[str, Any]:
    columns: list[dict[str, Any]] = [{"axis": at} for at in range(len(axes))]
    columns += [{"quantity": at} for at in range(len(maps))]
    return {"rows": rows, "columns": columns, "cells": None}


def _sections(title: str, run: Run, document: dict[str, Any], thinning: str) -> list[str]:
    record = run.record
    links = {"answer": "Answer", "map": "Map", "design": "One design", "list": "Table", "study": "Study"}
    answer = html.text(run_text(run)) + html.warnings([thinning] if thinning else [])
    parts = [
        html.head(title, f"a sweep by tendon, study {record['study_hash'][:12]}", links | {"record": "Record"}),
        html.section("answer", "What came out", answer, "answer"),
        html.section("map", "Map of the designs", html.MAP),
    ]
    return [
        *parts,
        html.section("design", "The states of one design", html.STATES),
        html.section("list", "All designs of this page", html.TABLE),
        *ending(record, document),
    ]


def ending(record: dict[str, Any], document: Mapping[str, Any]) -> list[str]:
    """What every run's page ends with: its study, and what was computed by what."""
    return [
        html.section("study", "The study", html.folded("Every number, in SI units", json.dumps(document, indent=1))),
        html.section("record", "What was computed, by what", _record_table(record)),
    ]


def _record_table(record: dict[str, Any]) -> str:
    """Versions, counts and the checksum of every file."""
    rows = [("study, SHA-256", record["study_hash"])]
    rows += [(f"version of {name}", version) for name, version in record["versions"].items()]
    rows += [(name, record[name]) for name in ("designs", "states", "seconds") if name in record]
    rows += [(f"{entry['path']}, {entry['size']} bytes, SHA-256", entry["sha256"]) for entry in record["files"]]
    return html.table(("what", "value"), rows)
