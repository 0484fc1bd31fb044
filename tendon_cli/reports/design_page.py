"""The page of an answer: the answer, maps of the choices, their windows and front, and the states behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from tendon_cli import say
from tendon_cli.cube.axes import Ints, evenly
from tendon_cli.cube.choice_grid import conflicts_of, over_angle, position, pretension_name
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube, choices_of
from tendon_cli.cube.labels import Shown
from tendon_cli.quantities import QUANTITIES
from tendon_cli.reports import html
from tendon_cli.reports.data import (
    MOST_DESIGNS,
    OF_TAUT,
    PageAxis,
    curves,
    number_record,
    packed,
    packed_classes,
    page_axes,
    page_data,
    rows_with_states,
    states_record,
    thinning_text,
    truths_record,
    within_size,
)
from tendon_cli.space.axis import PRETENSION
from tendon_cli.space.space import Space
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import keys
from tendon_cli.tables.read import open_table
from tendon_cli.tables.schema import as_numpy

RESULTS = (
    "tolerance",
    "served",
    "served_at",
    "pretension",
    "pretension_from",
    "pretension_to",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
)
GOALS = (
    "tolerance",
    "served",
    "pretension",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
)
MOST_CONDITIONS = 4
"""Whose states the page keeps, evenly chosen."""

_BINDS, _COSTS = "What binds where, for the choice named first", "What one goal costs the other"
_STATES = "The states of one choice, at its pretension"
_COLOURS = ("slack", "unstable", "beyond", "nowhere")
_TRUTHS, _WORDS = ("feasible", "refined", "on_front"), ("from_by", "to_by")


def design_page(folder: Path, record: dict[str, Any]) -> str:
    """The page of the answer in a folder, opened by `open_answer`."""
    table = open_table(folder / "choices.parquet")
    cube = choices_of(table)
    axes = page_axes(cube)
    kept = {each.axis.column: each.kept for each in axes}
    grid = cube.rows(list(kept), kept).ravel()
    product = int(np.prod([axis.length for axis in cube.axes]))
    rows = np.concatenate([grid, np.arange(product, table.rows)])
    read = cube.gather(
        rows, [name for name in (*kept, *RESULTS, *_TRUTHS, *_WORDS) if name in cube.columns]
    )
    columns = {
        name: read[name] for name in RESULTS if name in read and np.isfinite(read[name]).any()
    }
    labels = {name: cube.shown(name) for name in columns}
    maps, left_out = within_size(
        number_record(labels[name], values[: len(grid)]) for name, values in columns.items()
    )
    maps.insert(
        min(1, len(maps)),
        _conflicts(cube, {name: values[: len(grid)] for name, values in read.items()}),
    )
    states, arms = _states(cube, axes, read["pretension"][: len(grid)])
    persons = folder / "persons.parquet"
    people = people_record(record, open_table(persons).read() if persons.exists() else None)
    design = _answers(read, columns, labels, pretension_name(cube.study))
    between = _between(record, cube.limits)
    data = page_data(
        axes=[axis.record() for axis in axes],
        quantities=maps,
        states=states,
        arms=arms,
        design=design,
        table=_table(axes, read, columns, labels),
        start=_start(record, axes),
        people=people,
        between=between,
    )
    answer = html.blocks(record.get("blocks") or [say.sentence(record["text"])])
    answer += html.notes(thinning_text(axes, left_out))
    has_windows = bool(axes) and "pretension_from" in columns
    parts = {
        **({"map": ("Map", "Map of the choices", html.part("map"))} if axes else {}),
        **(
            {"windows": ("Windows", "Windows of pretension", html.part("windows"))}
            if has_windows
            else {}
        ),
        **({"between": ("Angles", _BINDS, html.part("between"))} if between is not None else {}),
        **({"people": ("People", "For whom", html.part("people"))} if people is not None else {}),
        **({"front": ("Front", _COSTS, html.part("front"))} if len(design["goals"]) > 1 else {}),
        **({"design": ("One choice", _STATES, html.part("states"))} if states is not None else {}),
        "list": ("Table", "All choices of this page", html.part("table")),
    }
    return html.result_page(
        record, "an answer", ("The answer", answer), parts, record["study"], data
    )


def _answers(
    read: Mapping[str, Values],
    columns: Mapping[str, Values],
    labels: Mapping[str, Shown],
    name: str,
) -> dict[str, Any]:
    """Windows and front, a number a choice."""
    records = {name: number_record(labels[name], values) for name, values in columns.items()}
    records["on_front"] = {"label": "on the front", "unit": "", "array": packed(read["on_front"])}
    goals = [name for name in GOALS if name in records]
    shown = [goals.index(name) for name in ("max_tension", "tolerance") if name in goals]
    return {
        "columns": records,
        "pretension": name,
        "texts": {name: read[name].tolist() for name in _WORDS},
        "goals": goals,
        "display": [*shown, 0, min(1, len(goals) - 1)][:2],
    }


def _conflicts(cube: Cube, read: Mapping[str, Values]) -> dict[str, Any]:
    """Why a choice has no window, as a map of classes."""
    texts = conflicts_of(read, cube.limits).tolist()
    names = list(dict.fromkeys(text for text in texts if text))
    classes = [{"label": "has a window", "sign": "W", "colour": "feasible"}]
    classes += [
        {"label": name, "sign": "ABCDEFGHIJ"[at % 10], "colour": _COLOURS[at % len(_COLOURS)]}
        for at, name in enumerate(names)
    ]
    values = [1 + names.index(text) if text else 0 for text in texts]
    about = {"name": "conflict", "label": "why there is no window", "unit": ""}
    return {**about, "classes": classes, "array": packed_classes(values)}


def _table(
    axes: Sequence[PageAxis],
    read: Mapping[str, Values],
    columns: Mapping[str, Values],
    labels: Mapping[str, Shown],
) -> dict[str, Any]:
    shown: list[dict[str, Any]] = []
    for each in axes:
        values, name = read[each.axis.column], each.axis.column
        is_text = each.axis.is_text
        about = {"name": name, "key": each.axis.key, "label": each.shown.name, "unit": ""}
        shown.append(
            {**about, "texts": values.tolist()} if is_text else number_record(each.shown, values)
        )
    shown += [number_record(labels[name], values) for name, values in columns.items()]
    shown += [
        {
            "name": name,
            "label": label,
            "unit": "",
            "texts": [text or "none" for text in read[name].tolist()],
        }
        for name, label in zip(_WORDS, ("bound below by", "bound above by"), strict=True)
    ]
    shown += truths_record({name: read[name] for name in _TRUTHS})
    return {"rows": len(read["feasible"]), "columns": shown}


def _start(record: dict[str, Any], axes: Sequence[PageAxis]) -> list[int] | None:
    """Where the map opens: at the best choice, or the nearest that the page keeps."""
    row = record.get("best")
    if row is None:
        return None
    at = [int(position(each.axis, row[each.axis.column])[0]) for each in axes]
    return [int(np.argmin(np.abs(each.kept - place))) for each, place in zip(axes, at, strict=True)]


def _states(cube: Cube, axes: Sequence[PageAxis], pretension: Values) -> tuple[Any, Any]:
    """Curves of some choices at their pretensions, under a few of the conditions; None if no choice has one."""
    if cube.files is None or not np.isfinite(pretension).any():
        return None, []
    study = recorded_study(cube.files.facts["study"])
    space = space_of(study).unset()
    lengths = [len(axis.kept) for axis in axes]
    few = evenly(len(space.conditions), MOST_CONDITIONS)
    kept, rows = rows_with_states(cube, axes, MOST_DESIGNS // len(few))
    cells = (
        np.ravel_multi_index(np.meshgrid(*kept, indexing="ij"), lengths).ravel()
        if axes
        else np.zeros(1, np.int64)
    )
    numbers, of_conditions = {**space.choices.numbers(rows), PRETENSION: pretension[cells]}, []
    for at in few:
        one = np.array([at])
        design = space.at(numbers, space.conditions.numbers(one)).design()
        of_conditions.append(
            (_in_words(space.conditions, one), curves(study, design, (len(rows), 1), OF_TAUT))
        )
    return states_record(study, kept, of_conditions)


def _in_words(conditions: Space, one: Ints) -> str:
    """One of the conditions."""
    words = []
    for factor, place in zip(conditions.axes, conditions.places(one).values(), strict=True):
        at = int(place[0])
        shown = (
            None if factor.names else Shown.of(factor.column, keys()[factor.key].number.quantity)
        )
        words.append(
            factor.names[at]
            if shown is None
            else f"{shown.name} {shown.text(float(factor.values[at]))}"
        )
    return ", ".join(words)


def _between(record: dict[str, Any], bounds: Mapping[str, float]) -> dict[str, Any] | None:
    """What each limit asks of the pretension over the angle, for the choice named first; None without such curves."""
    drawn = over_angle(record)
    if drawn is None:
        return None
    lines, points = [], []
    for end, of_end, on_line in zip(("from", "to"), drawn.ends, drawn.at_samples, strict=True):
        points += [
            each
            for each in zip(drawn.samples.tolist(), on_line.tolist(), strict=True)
            if np.isfinite(each[1])
        ]
        for limit, values in of_end.items():
            shown = [
                float(f"{value:.6g}") if np.isfinite(value) else None
                for value in drawn.shown(values).tolist()
            ]
            lines.append(
                {"label": say.limit_words(limit, bounds).label, "end": end, "values": shown}
            )
    low, high = drawn.window
    return {
        "angles": drawn.angle.round(6).tolist(),
        "lines": lines,
        "window": [low, None if np.isinf(high) else high],
        "top": drawn.top,
        "samples": {"x": [x for x, _ in points], "y": [y for _, y in points]},
        "says": " ".join([*drawn.texts, f"Shaded is what {drawn.works[0]}."]),
    }


MOST_PERSONS = 5000
_USUAL = ("biceps_circumference", "weight")


def people_record(record: dict[str, Any], persons: pa.Table | None) -> dict[str, Any] | None:
    """What the page draws of the persons of an answer, from their table; None if it was not asked of people."""
    population = record["population"]
    if population is None or persons is None or population["pretension"] is None:
        return None
    kept = evenly(persons.num_rows, MOST_PERSONS)
    named = [dimension for reason in population["not_served"] for dimension in reason["bodies"]]
    first, second = list(dict.fromkeys((*named, *_USUAL)))[:2]
    axes = {}
    for name, dimension in (("x", first), ("y", second)):
        shown = Shown.of(dimension, QUANTITIES[dimension])
        axes[name] = number_record(shown, as_numpy(persons.column(dimension))[kept])
    enough = 1.0 if population["kind"] == "persons" else record["serve"]
    served = as_numpy(persons.column("served"))[kept] >= enough - 1e-9
    return {**axes, "served": {"array": packed_classes(served)}, "title": population["title"]}
