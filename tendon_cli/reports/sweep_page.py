"""The page of a sweep: its answer, its maps, the states behind them, its table and its record."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.axes import thinned
from tendon_cli.cube.columns import TRUTHS
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.results import Run
from tendon_cli.reports import html
from tendon_cli.reports.data import (
    OUTCOME,
    PageAxis,
    outcomes,
    page_axes,
    page_data,
    quantities,
    thinning_text,
    truths_record,
)
from tendon_cli.reports.states import MOST_DESIGNS, curves_of_sweep, states_record
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.study import Study
from tendon_cli.summary import run_facts, run_head
from tendon_cli.tables.read import open_table

WORTH = (
    "margin", "pretension_from", "pretension_to", "required_pretension", "max_tension", "max_spring_extension",
    "peak_motor_torque", "min_elbow_stiffness", "max_contact_pressure", "min_flexor_tension", "min_extensor_tension",
    "max_slack", "slack_fraction", "unstable_fraction",
)  # fmt: skip
"""Columns of designs in the order in which they earn their room on the page; all others follow."""

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
    chosen = {OUTCOME: outcomes(columns, nowhere)} | {name: columns[name] for name in names}
    maps, left_out = quantities(chosen, {name: cube.shown(name) for name in names})
    states, arms = _states(recorded_study(table.facts["study"]), axes)
    shown = [*({"axis": at} for at in range(len(axes))), *({"quantity": at} for at in range(len(maps)))]
    listed = {"rows": rows.size, "columns": [*shown, *truths_record({name: columns[name] for name in TRUTHS})]}
    data = page_data(
        "sweep", axes=[axis.record() for axis in axes], quantities=maps, states=states, arms=arms,
        table={**listed, "cells": None},
    )  # fmt: skip
    title = run.record["title"] or run.record["name"]
    remarks = thinning_text(axes, left_out)
    if cube.study["motion"].get("trajectory"):
        remarks.append(_SLOWLY)
    sections = _sections(title, run, dict(cube.study), remarks, has_map=bool(axes))
    return html.html_page(title, sections, data, say.joint_word(cube.study))


def _columns(cube: Cube) -> list[str]:
    """Numbers that are results, the most wanted first."""
    known = [name for name, quantity in cube.columns.items() if quantity is not None]
    keys = {axis.column for axis in cube.axes}
    results = known[known.index("min_flexor_tension") :]
    return [*(name for name in WORTH if name in results), *(n for n in results if n not in WORTH and n not in keys)]


def _states(study: Study, axes: Sequence[PageAxis]) -> tuple[Any, Any]:
    kept = thinned([len(axis.kept) for axis in axes], MOST_DESIGNS)
    position = {each.axis.key: each.kept[at] for each, at in zip(axes, kept, strict=True)}
    return states_record(study, kept, [("", curves_of_sweep(study, [position[key] for key in study.axes]))])


def _sections(
    title: str, run: Run, document: dict[str, Any], thinning: Sequence[str], *, has_map: bool
) -> list[str]:  # fmt: skip
    record = run.record
    links = {"answer": "Answer", **({"map": "Map"} if has_map else {}), "design": "One design", "list": "Table"}
    answer = html.blocks([say.sentence(run_head(run))]) + html.table((), run_facts(run))
    answer += html.warnings(record["warnings"]) + html.notes(thinning)
    return [
        html.head(
            title,
            f"a sweep by tendon, study {record['study_hash'][:12]}",
            links | {"study": "Study", "record": "Record"},
        ),
        html.section("answer", "What came out", answer, "answer"),
        *([html.section("map", "Map of the designs", html.part("map"))] if has_map else []),
        html.section("design", "The states of one design", html.part("states")),
        html.section("list", "All designs of this page", html.part("table")),
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
