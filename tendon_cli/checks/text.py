"""The result of a check, as text for a terminal, Markdown for a job's summary, or a record for a program."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from tendon_cli.checks.compare import Change, Comparison, Flip
from tendon_cli.checks.limits import NO_EQUILIBRIUM, SLACK, Breach, LimitCheck, column_of
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import Shown, number
from tendon_cli.quantities import QUANTITIES
from tendon_cli.units import counted


def record_of(result: LimitCheck | Comparison) -> dict[str, Any]:
    """The result, with `holds`; what is infinite is null."""
    record = asdict(result) | {"holds": result.holds}
    return {name: _finite(value) for name, value in record.items()}


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value


def verdict_text(result: LimitCheck, cube: Cube, name: str) -> str:
    """One line where all is well, else what is broken and where, the worst first."""
    if result.holds:
        all_of_them = (
            "the design is within its" if result.designs == 1 else f"all {result.designs:,} designs are within their"
        )
        return f"{name}: {all_of_them} limits"
    lines = [f"{name}: {result.designs - result.feasible:,} of {result.designs:,} designs are not within their limits"]
    lines += [f"  {limit:<22} broken by {counted(count, 'design')}" for limit, count in result.broken.items()]
    lines += ["worst first", *(f"  {_breach(each, cube)}" for each in result.breaches)]
    return "\n".join(lines)


def _breach(breach: Breach, cube: Cube) -> str:
    design = f"design {breach.design}{_at(cube, breach.design)}"
    if breach.limit == NO_EQUILIBRIUM:
        words = "has a state without equilibrium"
    elif breach.limit == SLACK:
        words = f"is slack, {_shown('margin', -(breach.value or 0.0))} short of the pretension it needs"
    else:
        column = column_of(breach.limit)
        value, bound = (_shown(column, each or 0.0) for each in (breach.value, breach.bound))
        past = "below" if breach.limit.startswith("min_") else "above"
        words = f"has {column} {value}, {past} {bound}"
        words += f" by {100 * breach.excess:.3g} %" if breach.bound else ""
    return f"{design}: {words}{_state(breach)}"


def _state(breach: Breach) -> str:
    if breach.direction is None or breach.elbow_angle is None:
        return ""
    return f"; worst in {breach.direction} at {number(math.degrees(breach.elbow_angle))} deg"


def _at(cube: Cube, design: int) -> str:
    """A design's place on the axes."""
    words = []
    for axis in cube.axes:
        value = axis.values[design // axis.stride % axis.length]
        words.append(f"{axis.column} {value if axis.is_text else cube.shown(axis.column).text(float(value))}")
    return f" ({', '.join(words)})" if words else ""


def _shown(column: str, value: float) -> str:
    return Shown.of(column, QUANTITIES[column]).text(value) if column in QUANTITIES else number(value)


def comparison_text(result: Comparison, cube: Cube, names: tuple[str, str]) -> str:
    """What was compared, then columns and designs that changed, the worst first, and what could not be compared."""
    head = "nothing changed" if result.holds else "changed"
    lines = [f"{names[0]}: {head} since {names[1]}", f"  compared: {_compared(result)}"]
    if result.within is not None:
        lines.append(f"  within the tolerance, the largest difference: {_change(result.within, cube)}")
    lines += [f"  not compared, as it may differ: {text}" for text in result.excepted]
    lines += [f"  not compared: {text}" for text in result.missing]
    lines += [f"  {_change(each, cube)}" for each in result.changes]
    if result.flipped:
        lines.append(f"feasible in one run only: {counted(result.flipped, 'design')}, worst first")
        lines += [f"  {_flip(each, cube)}" for each in result.flips]
    return "\n".join(lines)


def _compared(result: Comparison) -> str:
    """Rows and columns that both runs have."""
    rows = {"designs": result.designs, "states": result.states}
    texts = [
        f"{counted(columns, 'column')} of {counted(rows[table], table[:-1])}"
        for table, columns in result.columns.items()
    ]
    return " and ".join(texts) + ("" if "states" in result.columns else "; no states, which are not kept by both")


def _change(change: Change, cube: Cube) -> str:
    head = f"{change.table}.{change.column}: {counted(change.rows, 'row')}"
    if change.difference is None:
        return f"{head}, first at {_where(change.where, cube)}"
    by = "null in one only" if math.isinf(change.difference) else f"by {_shown(change.column, change.difference)}"
    share = "" if math.isinf(change.share) else f" ({change.share:.3g} of its scale)"
    return f"{head}, most {by}{share} at {_where(change.where, cube)}"


def _flip(flip: Flip, cube: Cube) -> str:
    now = "feasible now, was not" if flip.now else "not feasible now, was"
    margins = [None if each is None else _shown("margin", each) for each in (flip.margin_before, flip.margin_now)]
    moved = f"; margin {margins[0]}, now {margins[1]}" if None not in margins else ""
    return f"{_where(flip.where, cube)}: {now}{moved}"


def _where(where: Mapping[str, float | str], cube: Cube) -> str:
    words = []
    for column, value in where.items():
        shown = Shown.of(column, QUANTITIES[column]) if column in QUANTITIES else None
        if isinstance(value, str):
            words.append(f"{column} {value}")
        else:
            words.append(f"{column} {(shown or cube.shown(column)).text(value)}")
    return ", ".join(words) or "the only row"


def as_markdown(text: str, *, holds: bool) -> str:
    """The same for a job's summary."""
    head, *rest = text.split("\n")
    mark = "within limits" if holds else "not as hoped"
    body = "\n".join(f"- {line.strip()}" if line.startswith("  ") else f"\n**{line}**\n" for line in rest)
    return f"### tendon check: {mark}\n\n{_escaped(head)}\n\n{_escaped(body)}".rstrip() + "\n"


def _escaped(text: str) -> str:
    """Names from studies say no Markdown and no HTML."""
    for letter, harmless in (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("|", "\\|"), ("`", "\\`"), ("[", "\\[")):
        text = text.replace(letter, harmless)
    return text
