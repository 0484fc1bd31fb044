"""Short texts on studies, runs, estimates and rows of tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from tendon_cli import say
from tendon_cli.say import counted
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.study import keys

if TYPE_CHECKING:
    import pyarrow as pa

    from tendon_cli.cube.rows import TableRows
    from tendon_cli.engine.cost import Estimate
    from tendon_cli.engine.results import Run
    from tendon_cli.studies.study import Study
    from tendon_cli.studies.values import StudyNumber


_MAX_VALUES = 6
"""Values of an axis that are shown; of a longer one only the first and the last."""


def study_text(study: Study) -> str:
    """Return name, axes, limits and warnings of a study in a few lines."""
    lines = [("axis", f"{key}: {_axis_text(study, key)}") for key in study.axes]
    lines.append(("motion", _motion_text(study)))
    if study.conditions:
        lines.append(("conditions", ", ".join(study.conditions)))
    for name, value in study.limits.items():
        lines.append(("limit", f"{name} {say.quantity(name, value)}"))
    if study.uncertain:
        lines.append(("uncertain", ", ".join(study.uncertain)))
    lines += [("note", note) for note in study.notes]
    lines += [("warning", warning) for warning in study.warnings]
    title = f"{study.name}: {study.title}" if study.title else f"study {study.name}"
    return "\n".join([title, *(f"  {name:<11} {text}" for name, text in lines)])


def _motion_text(study: Study) -> str:
    """Return directions and angles of a motion, or the span of a trajectory."""
    if study.trajectory is None:
        angles = _values_text("elbow_angle", study.motion.elbow_angle)
        return f"{' and '.join(study.motion.direction)}, elbow angle {angles}"
    low, high = np.degrees([study.angles.min(), study.angles.max()])
    duration = study.trajectory.time[-1]
    return f"a trajectory of {duration:.4g} s from {low:.4g} to {high:.4g} deg"


def _axis_text(study: Study, key: str) -> str:
    """Return the values of an axis; the middle of a long one is left out."""
    if key in study.numbers:
        return _values_text(keys()[key].number.name, study.numbers[key])
    if key in study.words:
        return ", ".join(study.words[key])
    if key == DRAW_AXIS:
        return counted(study.draws, "draw")
    if study.people is not None and key == PERSON_AXIS:
        if study.people.file:
            return f"those of {study.people.file}"
        return counted(study.people.count, "person")
    names = [str(getattr(case, "name", "")) for case in study.cases]
    more = f", ... ({counted(len(names), 'case')})" if len(names) > _MAX_VALUES else ""
    return ", ".join(names[:_MAX_VALUES]) + more


def _values_text(quantity: str, values: StudyNumber) -> str:
    """Return the values of a number in words; the middle of a long axis is left out."""
    if len(values) > _MAX_VALUES:
        first = say.quantity(quantity, values.array[0])
        last = say.quantity(quantity, values.array[-1])
        return f"{first} to {last}, {len(values):,} values"
    return ", ".join(say.quantity(quantity, value) for value in values.array)


def run_text(run: Run) -> str:
    """Return the summary of a finished run."""
    record = run.record
    lines = [*run_facts(run), *(("warning", warning) for warning in record["warnings"])]
    if run.folder is not None:
        tables = dict.fromkeys(entry["path"].split("/")[0] for entry in record["files"])
        written = ", ".join([*tables, *record["figures"]])
        lines.append(("written to", f"{run.folder}: {written}"))
    return "\n".join([run_head(run), *(f"  {name:<14} {text}" for name, text in lines)])


def run_head(run: Run) -> str:
    """Return the size of a run and how long it took, in a line."""
    record = run.record
    designs = counted(record["designs"], "design")
    states = counted(record["states"], "state")
    head = f"{record['name']}: {designs}, {states}"
    if run.up_to_date:
        return f"{head}, up to date"
    drawing = ""
    if record.get("figure_seconds"):
        drawing = f", figures in {record['figure_seconds']:.2g} s"
    return f"{head} in {record['seconds']:.3g} s{drawing}"


def run_facts(run: Run) -> list[tuple[str, str]]:
    """Return the results of a run, each with its name."""
    record = run.record
    designs = record["designs"]
    feasible = say.share(record["feasible"], designs, "design")
    facts = [
        ("feasible", f"{feasible}: taut, stable and within every limit"),
        ("  taut", say.share(record["taut"], designs, "design")),
        ("  stable", say.share(record["stable"], designs, "design")),
    ]
    if record["choices"] != designs:
        share = say.share(record["feasible_choices"], record["choices"], "choice")
        facts.append(("choices", f"{share} feasible at every {_conditions(record)}"))
    facts.append(("slack", say.share(record["slack"], record["states"], "state")))
    if run.note:
        facts.append(("no slack map", run.note))
    return facts


def _conditions(record: dict[str, Any]) -> str:
    """Return the axes of conditions in words, such as "load" or "load and person at once"."""
    names = [_condition(key) for key in recorded_study(record).conditions]
    together = " at once" if len(names) > 1 else ""
    return say.join_words(names) + together


def _condition(key: str) -> str:
    """Return the word for an axis of conditions."""
    if key == "load.mass":
        return "load"
    if key in keys():
        return say.column(keys()[key].number.quantity.name)
    return key


def estimate_text(estimate: Estimate, name: str, free: int) -> str:
    """Return the page of `--dry-run`.

    Args:
        estimate: Estimate of the cost.
        name: Name of the study.
        free: Bytes that the disk has free.
    """
    width = max(len(axis.key) for axis in estimate.axes)
    lines = [f"{name}: nothing is written by --dry-run", "  axes, slowest first"]
    for axis in estimate.axes:
        span = axis.first if axis.count == 1 else f"{axis.first} to {axis.last}"
        lines.append(f"    {axis.key:<{width}}  {axis.count:>8,}  {span}")
    lines.append(f"  designs      {estimate.designs:,}")
    lines.append(f"  states       {estimate.states:,}")
    lines += [f"  rows         {rows:,} in {table}" for table, rows in estimate.rows.items()]
    if estimate.kept:
        lines.append(f"  kept         {', '.join(estimate.kept)} of the states' results")
    parts = counted(estimate.parts, "part")
    lines.append(
        f"  disk         {say.byte_size(estimate.bytes)} in {parts}, {say.byte_size(free)} are free"
    )
    drawing = ""
    if estimate.figure_seconds:
        drawing = f", of it {say.duration(estimate.figure_seconds)} for figures"
    lines.append(f"  time         about {say.duration(estimate.seconds)}{drawing}")
    lines.append(f"  peak memory  about {say.byte_size(estimate.peak_memory)}")
    return "\n".join(lines)


def rows_text(rows: TableRows, shown: pa.Table, total: int, width: int) -> str:
    """Return rows as a table in the units that people read; columns that do not fit come below.

    Args:
        rows: Rows with their columns and units.
        shown: Rows that are shown.
        total: Number of all rows.
        width: Characters in a line.
    """
    columns = [_column_text(rows, name, shown[name].to_pylist()) for name in rows.names]
    lines: list[str] = []
    while columns:
        fitting = _fitting_columns(columns, width)
        if lines:
            lines.append("")
        lines += ["  ".join(row).rstrip() for row in zip(*columns[:fitting], strict=True)]
        columns = columns[fitting:]
    return "\n".join([*lines, "", f"{shown.num_rows:,} of {counted(total, 'row')}"])


def _fitting_columns(columns: list[list[str]], width: int) -> int:
    """Return the number of first columns that fit beside each other, at least one."""
    used = len(columns[0][0])
    for count, column in enumerate(columns[1:], start=1):
        used += 2 + len(column[0])
        if used > width:
            return count
    return len(columns)


def _column_text(rows: TableRows, name: str, values: list[Any]) -> list[str]:
    """Return name, unit and cells of a column, all of one width."""
    quantity = rows.table_columns.quantities[name]
    unit = "1"
    factor = 1.0
    if quantity is not None:
        unit = quantity.shown_in
        factor = say.factor_of(quantity)
    texts = [name, "" if unit == "1" else unit, *(_cell_text(value, factor) for value in values)]
    width = max(map(len, texts))
    if quantity is None:
        return [text.ljust(width) for text in texts]
    return [text.rjust(width) for text in texts]


def _cell_text(value: Any, factor: float) -> str:
    """Return a value as text, a number divided by `factor`."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "-"
    if math.isinf(value):
        return "rigid"
    return f"{value / factor:.6g}"
