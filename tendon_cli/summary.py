"""Studies, runs, estimates and tables as short text."""

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
    from tendon_cli.studies.values import Values


_MOST_VALUES = 6


def study_text(study: Study) -> str:
    """Name, axes, limits and warnings of a study, in a few lines."""
    motion = f"{' and '.join(study.motion.direction)}, elbow angle "
    motion += _values_text("elbow_angle", study.motion.elbow_angle)
    if study.trajectory is not None:
        low, high = np.degrees([study.angles.min(), study.angles.max()])
        motion = (
            f"a trajectory of {study.trajectory.time[-1]:.4g} s from {low:.4g} to {high:.4g} deg"
        )
    lines = [
        *(("axis", f"{key}: {_axis_text(study, key)}") for key in study.axes),
        ("motion", motion),
        *([("conditions", ", ".join(study.conditions))] if study.conditions else []),
        *(("limit", f"{name} {say.quantity(name, value)}") for name, value in study.limits.items()),
        *([("uncertain", ", ".join(study.uncertain))] if study.uncertain else []),
        *(("note", note) for note in study.notes),
        *(("warning", warning) for warning in study.warnings),
    ]
    title = f"{study.name}: {study.title}" if study.title else f"study {study.name}"
    return "\n".join([title, *(f"  {name:<11} {text}" for name, text in lines)])


def _axis_text(study: Study, key: str) -> str:
    """The values of an axis, the middle of a long one left out."""
    if key in study.numbers:
        return _values_text(keys()[key].number.name, study.numbers[key])
    if key in study.words:
        return ", ".join(study.words[key])
    if key == DRAW_AXIS:
        return counted(study.draws, "draw")
    if study.people is not None and key == PERSON_AXIS:
        return (
            f"those of {study.people.file}"
            if study.people.file
            else counted(study.people.count, "person")
        )
    names = [str(getattr(case, "name", "")) for case in study.cases]
    more = f", ... ({counted(len(names), 'case')})" if len(names) > _MOST_VALUES else ""
    return ", ".join(names[:_MOST_VALUES]) + more


def _values_text(quantity: str, values: Values) -> str:
    """The values of a number as people write them, the middle of a long axis left out."""
    if len(values) > _MOST_VALUES:
        first, last = (
            say.quantity(quantity, value) for value in (values.array[0], values.array[-1])
        )
        return f"{first} to {last}, {len(values):,} values"
    return ", ".join(say.quantity(quantity, value) for value in values.array)


def run_text(run: Run) -> str:
    """The summary of a finished run."""
    record = run.record
    lines = [*run_facts(run), *(("warning", warning) for warning in record["warnings"])]
    written = [
        *dict.fromkeys(entry["path"].split("/")[0] for entry in record["files"]),
        *record["figures"],
    ]
    lines += (
        [("written to", f"{run.folder}: {', '.join(written)}")] if run.folder is not None else []
    )
    return "\n".join([run_head(run), *(f"  {what:<14} {text}" for what, text in lines)])


def run_head(run: Run) -> str:
    """What a run was of, and how long it took."""
    record = run.record
    took = f" in {record['seconds']:.3g} s"
    took += f", figures in {record['figure_seconds']:.2g} s" if record.get("figure_seconds") else ""
    head = f"{record['name']}: {counted(record['designs'], 'design')}, {counted(record['states'], 'state')}"
    return head + (", up to date" if run.up_to_date else took)


def run_facts(run: Run) -> list[tuple[str, str]]:
    """What came out of a run, with the name of each."""
    record = run.record
    designs = {
        name: say.share(record[name], record["designs"], "design")
        for name in ("feasible", "taut", "stable")
    }
    facts = [("feasible", f"{designs['feasible']}: taut, stable and within every limit")]
    facts += [(f"  {name}", designs[name]) for name in ("taut", "stable")]
    if record["choices"] != record["designs"]:
        share = say.share(record["feasible_choices"], record["choices"], "choice")
        facts.append(("choices", f"{share} feasible at every {_conditions(record)}"))
    facts.append(("slack", say.share(record["slack"], record["states"], "state")))
    return [*facts, *([("no slack map", run.note)] if run.note else [])]


def _conditions(record: dict[str, Any]) -> str:
    """The axes of a run that a design must survive: "load", "load and person at once"."""
    names = [
        "load"
        if key == "load.mass"
        else say.column(keys()[key].number.quantity.name)
        if key in keys()
        else key
        for key in recorded_study(record).conditions
    ]
    return say.listed(names) + (" at once" if len(names) > 1 else "")


def estimate_text(estimate: Estimate, name: str, free: int) -> str:
    """The page of `--dry-run`."""
    width = max(len(axis.key) for axis in estimate.axes)
    lines = [f"{name}: nothing is written by --dry-run", "  axes, slowest first"]
    for axis in estimate.axes:
        span = axis.first if axis.count == 1 else f"{axis.first} to {axis.last}"
        lines.append(f"    {axis.key:<{width}}  {axis.count:>8,}  {span}")
    lines.append(f"  designs      {estimate.designs:,}")
    lines.append(f"  states       {estimate.states:,}")
    lines += [f"  rows         {rows:,} in {table}" for table, rows in estimate.rows.items()]
    lines += (
        [f"  kept         {', '.join(estimate.kept)} of the states' results"]
        if estimate.kept
        else []
    )
    parts = counted(estimate.parts, "part")
    lines.append(f"  disk         {say.size(estimate.bytes)} in {parts}, {say.size(free)} are free")
    drawn = (
        f", of it {say.duration(estimate.figure_seconds)} for figures"
        if estimate.figure_seconds
        else ""
    )
    lines.append(f"  time         about {say.duration(estimate.seconds)}{drawn}")
    lines.append(f"  peak memory  about {say.size(estimate.peak_memory)}")
    return "\n".join(lines)


def rows_text(rows: TableRows, shown: pa.Table, total: int, width: int) -> str:
    """Rows as a table that is at most so wide, in the units that people read; further columns come below."""
    cells = [_column_text(rows, name, shown[name].to_pylist()) for name in rows.names]
    lines: list[str] = []
    while cells:
        taken, used = 0, 0
        while taken < len(cells) and (taken == 0 or used + 2 + len(cells[taken][0]) <= width):
            used += len(cells[taken][0]) + (2 if taken else 0)
            taken += 1
        lines += [
            *([""] if lines else []),
            *("  ".join(row).rstrip() for row in zip(*cells[:taken], strict=True)),
        ]
        cells = cells[taken:]
    return "\n".join([*lines, "", f"{shown.num_rows:,} of {counted(total, 'row')}"])


def _column_text(rows: TableRows, name: str, values: list[Any]) -> list[str]:
    """A column's cells, its name and unit first, all of one width."""
    quantity = rows.of.held[name]
    unit = quantity.shown_in if quantity is not None else "1"
    factor = say.factor_of(quantity) if quantity is not None else 1.0
    texts = [name, "" if unit == "1" else unit]
    for value in values:
        if isinstance(value, float):
            text = "rigid" if math.isinf(value) else f"{value / factor:.6g}"
            texts.append("-" if math.isnan(value) else text)
        else:
            texts.append(
                "-"
                if value is None
                else str(value).lower()
                if isinstance(value, bool)
                else str(value)
            )
    width = max(map(len, texts))
    return [text.ljust(width) if quantity is None else text.rjust(width) for text in texts]
