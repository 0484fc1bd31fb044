"""The page of an answer: its text, maps of the choices, windows, front, and states behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from tendon_cli.cube.choice_grid import conflicts_of, over_motion, position, pretension_name
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube, CubeAsRead, cube_in
from tendon_cli.cube.labels import ColumnLabel
from tendon_cli.cube.outcomes import BEYOND, EXTENSOR_SLACK, NO_EQUILIBRIUM, TAUT, UNSTABLE
from tendon_cli.engine.results import Result
from tendon_cli.model.kinematics import Rows
from tendon_cli.quantities import OF_CYCLES, OF_TRAJECTORIES, QUANTITIES
from tendon_cli.reports import html
from tendon_cli.reports.data import (
    GROUPS,
    OF_TAUT,
    OTHER_TORQUE,
    PageAxis,
    curves,
    exact_record,
    given_columns,
    given_records,
    middle_of,
    most_designs,
    number_record,
    pack_classes,
    pack_numbers,
    page_axes,
    page_data,
    rows_with_states,
    samples_text,
    states_record,
    thinning_text,
    truths_record,
    within_size,
)
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.axis_words import name_words
from tendon_cli.studies.space.axis import PRETENSION, Axis, evenly_spaced
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import keys
from tendon_cli.tables.schema import as_numpy, finite_or_none
from tendon_cli.verbs.answer_record import AnswerRecord, as_answer, value_of

_COLOUR_OF_LIMIT = {
    "extensor slack": "extensor",
    "flexor slack": "mark",
    "min_elbow_stiffness": "flexor",
    "peak_motor_torque": "motor",
}
"""Colours of the limits that bind most often, as the style of the page names them."""
RESULTS = (
    "tolerance_length",
    "tolerance",
    "served",
    "served_at",
    "set_flexor_tension",
    "set_extensor_tension",
    "pretension",
    "pretension_from",
    "pretension_to",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
    *OF_CYCLES,
    *OF_TRAJECTORIES,
)
"""Columns of numbers that the page shows, the most useful first."""
GOALS = (
    "tolerance_length",
    "tolerance",
    "served",
    "pretension",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    *OF_CYCLES,
    *OF_TRAJECTORIES,
)
"""Columns that the front can be drawn over."""
MOST_CONDITIONS = 4
"""Largest number of conditions whose states the page has, evenly chosen."""

_COLOURS = [one.colour for one in (EXTENSOR_SLACK, UNSTABLE, BEYOND, NO_EQUILIBRIUM)]
_SIGNS = "ABCDEFGHIJ"
"""Colours and signs of the reasons why choices have no window, used in turn."""
_TRUTHS = ("feasible", "on_front")
"""Columns of true and false."""
_WORDS = ("from_by", "to_by")
"""Columns of words: the limits that bound the window below and above."""


def design_page(answer: Result, most: int) -> str:
    """Return the page of an answer with at most so many choices, and the best one."""
    record = as_answer(answer.record)
    cube = cube_in(answer, "choices")
    on_gauge = CubeAsRead.of(cube) if record.question.shows_own_f0 else cube
    axes = page_axes(cube, most, _places_of_best(record, cube.axes))
    positions = {axis.axis.column: axis.positions for axis in axes}
    rows = cube.rows(list(positions), positions).ravel()
    read = _read_choices(on_gauge, axes, rows)
    of_model = read if on_gauge is cube else _read_choices(cube, axes, rows)

    columns = {
        name: read[name] for name in RESULTS if name in read and np.isfinite(read[name]).any()
    }
    labels = {name: on_gauge.shown(name) for name in columns}
    maps, left_out = within_size(
        number_record(labels[name], read[name], _no_value(read, name)) for name in columns
    )
    maps.insert(min(1, len(maps)), _conflicts(cube, read))
    states, arms = _states(cube, axes, of_model["pretension"])
    people = people_record(record, _persons(answer))
    design = _answers(read, columns, labels, pretension_name(on_gauge.document))
    between = _between(record, cube.limits)
    data = page_data(
        axes=[axis.record() for axis in axes],
        quantities=maps,
        states=states,
        arms=arms,
        design=design,
        table=_table(cube, axes, of_model, [*columns]),
        start=_start(record, axes, read["feasible"]),
        people=people,
        between=between,
    )

    is_in_time = cube.study.trajectory is not None
    words = _words(record)
    words += html.notes([*thinning_text(axes, left_out), *samples_text(cube.study)])
    parts: dict[str, html.Part] = {}
    if axes:
        parts["map"] = ("Map", "Map of the choices", html.part("map"))
    if axes and "pretension_from" in columns:
        parts["windows"] = ("Windows", "Windows of pretension", html.part("windows"))
    if between is not None:
        heading = "What binds where, for the choice named first"
        tab = "Times" if is_in_time else "Angles"
        parts["between"] = (tab, heading, html.part("between", is_in_time=is_in_time))
    if people is not None:
        parts["people"] = ("People", "For whom", html.part("people"))
    if len(design["goals"]) > 1:
        parts["front"] = ("Front", "What one goal costs the other", html.part("front"))
    if states is not None:
        heading = "The states of one choice, at its pretension"
        states_part = html.part("states", is_in_time=is_in_time)
        parts["design"] = ("One choice", heading, states_part)
    parts["list"] = ("Table", "All choices of this page", html.part("table"))
    return html.result_page(
        answer.record, answer.kind.noun, ("The answer", words), parts, record.study, data
    )


def _words(record: AnswerRecord) -> str:
    """Return the short answer as HTML, with the tables of the record folded below it."""
    blocks = [block for block in record.blocks if "note" not in block]
    notes = [block for block in record.blocks if "note" in block]
    kinds = [next(iter(block)) for block in blocks]
    first = kinds.index("table") - 1 if "table" in kinds else len(blocks)  # with its heading
    tables = html.folded("All numbers of the answer, as tables", html.blocks(blocks[first:]))
    return html.blocks(blocks[:first]) + tables + html.blocks(notes)


def _read_choices(cube: Cube, axes: Sequence[PageAxis], rows: Rows) -> dict[str, ColumnArray]:
    """Read the choices of the page."""
    axis_columns = [axis.axis.column for axis in axes]
    wanted = dict.fromkeys((*axis_columns, *given_columns(cube), *RESULTS, *_TRUTHS, *_WORDS))
    names = [name for name in wanted if name in cube.columns]
    return cube.gather(rows, names)


def _persons(answer: Result) -> pa.Table | None:
    """Read the table of an answer's persons; None if it has none."""
    return answer.table("persons") if "persons.parquet" in answer.table_files else None


def _answers(
    read: Mapping[str, ColumnArray],
    columns: Mapping[str, ColumnArray],
    labels: Mapping[str, ColumnLabel],
    pretension: str,
) -> dict[str, Any]:
    """Return windows and front as JSON, one number per choice; `pretension` labels their axis."""
    records = {name: number_record(labels[name], values) for name, values in columns.items()}
    records["on_front"] = {
        "label": "on the front",
        "unit": "",
        "array": pack_numbers(read["on_front"]),
    }
    goals = [name for name in GOALS if name in records]
    display = [goals.index(name) for name in ("max_tension", "tolerance_length") if name in goals]
    display += [0, min(1, len(goals) - 1)]
    return {
        "columns": records,
        "pretension": pretension,
        "texts": {name: read[name].tolist() for name in _WORDS},
        "goals": goals,
        "display": display[:2],
    }


def _conflicts(cube: Cube, read: Mapping[str, ColumnArray]) -> dict[str, Any]:
    """Return the map of the reasons why choices have no window, as classes."""
    texts = conflicts_of(read, cube.limits).tolist()
    reasons = list(dict.fromkeys(text for text in texts if text))
    classes = [{"label": "has a window", "sign": "W", "colour": TAUT.colour}]
    for number, reason in enumerate(reasons):
        sign = _SIGNS[number % len(_SIGNS)]
        colour = _COLOURS[number % len(_COLOURS)]
        classes.append({"label": reason, "sign": sign, "colour": colour})
    values = [1 + reasons.index(text) if text else 0 for text in texts]
    about = {"name": "conflict", "label": "why there is no window", "unit": ""}
    return {**about, "classes": classes, "array": pack_classes(values)}


def _table(
    cube: Cube,
    axes: Sequence[PageAxis],
    read: Mapping[str, ColumnArray],
    columns: Sequence[str],
) -> dict[str, Any]:
    """Return the table of all choices of the page as JSON, with F0 for their pretensions."""
    records: list[dict[str, Any]] = []
    for axis in axes:
        name = axis.axis.column
        if axis.axis.is_text:
            about = {"name": name, "label": axis.shown.name, "unit": ""}
            names = axis.axis.values[axis.positions].tolist()
            records.append({**about, "texts": read[name].tolist(), "stated": names})
        else:
            records.append(exact_record(axis.shown, read[name], axis.stated))
    records += [number_record(cube.shown(name), read[name]) for name in columns]
    for name, label in zip(_WORDS, ("bound below by", "bound above by"), strict=True):
        records.append({"name": name, "label": label, "unit": "", "texts": read[name].tolist()})
    records += truths_record({name: read[name] for name in _TRUTHS})
    records += given_records(cube, axes, {name: read[name] for name in given_columns(cube)})
    return {"rows": len(read["feasible"]), "columns": records}


def _no_value(read: Mapping[str, ColumnArray], name: str) -> str:
    """Say what it means that a choice has no value of a column."""
    is_empty = np.isnan(read[name])
    if not (is_empty & read["feasible"].astype(bool)).any():
        return "no window"
    if name in ("pretension_to", "tolerance_length"):
        return "no window, or nothing bounds it above"
    return "no value"


def _start(record: AnswerRecord, axes: Sequence[PageAxis], is_feasible: ColumnArray) -> list[int]:
    """Return the page's position at which the map opens: nearest to the best choice.

    Without a best choice it is the middle.
    """
    if record.best is None:
        return middle_of(axes, is_feasible.astype(bool))
    places = _places_of_best(record, [axis.axis for axis in axes])
    return [int(np.argmin(np.abs(axis.positions - places[axis.axis.column]))) for axis in axes]


def _places_of_best(record: AnswerRecord, axes: Sequence[Axis]) -> dict[str, int]:
    """Return the positions of the best choice by the columns of axes; none without a best one."""
    best = record.best
    if best is None:
        return {}
    return {axis.column: int(position(axis, value_of(best, axis.column))[0]) for axis in axes}


def _states(cube: Cube, axes: Sequence[PageAxis], pretension: ColumnArray) -> tuple[Any, Any]:
    """Return the states of some choices at their pretensions, under a few of the conditions.

    Args:
        cube: The choices.
        axes: The axes of the page.
        pretension: Pretension of each choice on the page's grid, flat, N; NaN without a window.

    Returns:
        Curves and arms as `states_record` returns them; None and an empty list if no choice has a
        pretension.
    """
    if cube.table is None or not np.isfinite(pretension).any():
        return None, []
    study = cube.study
    space = space_of(study).without_pretension()
    selected = evenly_spaced(len(space.conditions), MOST_CONDITIONS)
    positions, rows = rows_with_states(cube, axes, most_designs(study) // len(selected))
    cells = np.zeros(1, np.int64)  # of a grid without axes
    if axes:
        lengths = [len(axis.positions) for axis in axes]
        cells = np.ravel_multi_index(np.meshgrid(*positions, indexing="ij"), lengths).ravel()
    numbers = {**space.choices.numbers(rows), PRETENSION: pretension[cells]}
    # Without a pretension a choice has no states.
    has_pretension = np.isfinite(pretension[cells]).reshape(-1, 1, 1)
    named_curves = []
    for index in selected:
        condition = np.array([index])
        design = space.at(numbers, space.conditions.numbers(condition)).design()
        name = _condition_name(space.conditions, condition)
        of_condition = curves(study, design, (len(rows), 1), OF_TAUT)
        shown = [column for label in OF_TAUT for column in GROUPS[label]]
        for column in (*shown, OTHER_TORQUE):
            if column in of_condition:
                of_condition[column] = np.where(has_pretension, of_condition[column], np.nan)
        named_curves.append((name, of_condition))
    return states_record(study, positions, named_curves)


def _condition_name(conditions: Space, condition: Rows) -> str:
    """Return the values of a condition in words; `condition` is its row, in an array."""
    words = []
    for axis, places in zip(conditions.axes, conditions.places(condition).values(), strict=True):
        place = int(places[0])
        if axis.names:
            words.append(name_words(axis, axis.names[place], in_brackets=True))
        else:
            shown = ColumnLabel.of(axis.column, keys()[axis.key].quantity)
            words.append(f"{shown.name} {shown.text(float(axis.values[place]))}")
    return ", ".join(words)


def _between(record: AnswerRecord, bounds: limit_phrases.LimitValues) -> dict[str, Any] | None:
    """Return each limit's bound on the pretension over the angle, for the choice named first.

    Args:
        record: Record of the answer.
        bounds: The limits of the study, SI; None for one that differs between choices.

    Returns:
        The curves as JSON; None if the answer has none.
    """
    drawn = over_motion(record)
    if drawn is None:
        return None
    lines = []
    points = []
    for end, bounds_of_end, at_samples in zip(
        ("from", "to"), drawn.ends, drawn.at_samples, strict=True
    ):
        for angle, value in zip(drawn.samples.tolist(), at_samples.tolist(), strict=True):
            if np.isfinite(value):
                points.append((angle, value))
        for limit, values in bounds_of_end.items():
            label = limit_phrases.limit_words(limit, bounds).label
            rounded = [_rounded(value) for value in drawn.shown(values).tolist()]
            colour = _COLOUR_OF_LIMIT.get(limit, "joint")
            lines.append({"label": label, "end": end, "values": rounded, "colour": colour})
    low, high = drawn.window
    return {
        "along": drawn.along.round(6).tolist(),
        "at_end": (~drawn.does_count).astype(int).tolist() if drawn.is_in_time else None,
        "lines": lines,
        "window": [low, finite_or_none(high)],
        "top": drawn.top,
        "samples": {"x": [angle for angle, _ in points], "y": [value for _, value in points]},
        "says": " ".join([*drawn.texts, f"The shaded pretension {drawn.works[0]}."]),
    }


def _rounded(value: float) -> float | None:
    """Return a number with six digits; None if it is not finite."""
    return finite_or_none(float(f"{value:.6g}"))


MOST_PERSONS = 5000
"""Largest number of persons that the page draws, evenly chosen."""
_USUAL_MEASURES = ("biceps_circumference", "weight")


def people_record(record: AnswerRecord, persons: pa.Table | None) -> dict[str, Any] | None:
    """Return the persons of an answer as JSON, over two measures of the body.

    These are measures that explain who is not served, or else the usual ones.

    Args:
        record: Record of the answer.
        persons: Table of its persons.

    Returns:
        Both measures, and which persons are served; None if the answer is not for people.
    """
    population = record.population
    if population is None or persons is None or population.pretension is None:
        return None
    selected = evenly_spaced(persons.num_rows, MOST_PERSONS)
    explaining = [measure for reason in population.not_served for measure in reason.bodies]
    first, second = list(dict.fromkeys((*explaining, *_USUAL_MEASURES)))[:2]
    axes = {}
    for name, measure in (("x", first), ("y", second)):
        shown = ColumnLabel.of(measure, QUANTITIES[measure])
        axes[name] = number_record(shown, as_numpy(persons.column(measure))[selected])
    enough = 1.0 if population.kind == "persons" else record.serve
    is_served = as_numpy(persons.column("served"))[selected] >= enough - 1e-9
    return {**axes, "served": {"array": pack_classes(is_served)}, "title": population.title}
