"""The record of a check as text for a terminal, or Markdown for a job's summary."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import Shown, number
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.units import counted

NO_EQUILIBRIUM, SLACK = "no equilibrium", "slack"
WORST = 10
"""How many breaches or flips are listed."""

Record = Mapping[str, Any]


@dataclass(frozen=True)
class Checked:
    """What came of a check."""

    holds: bool
    text: str
    record: dict[str, Any]


def finite(value: Any) -> Any:
    """A record for a program: what is infinite is null."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: finite(each) for name, each in value.items()}
    return [finite(each) for each in value] if isinstance(value, list) else value


def verdict_text(record: Record, cube: Cube, name: str) -> str:
    """One line if all is well, else what is broken and where, the worst first."""
    designs = record["designs"]
    if record["holds"]:
        return f"{name}: " + (
            "the design is within its limits"
            if designs == 1
            else f"all {designs:,} designs are within their limits"
        )
    lines = [
        f"{name}: {designs - record['feasible']:,} of {designs:,} designs are not within their limits"
    ]
    lines += [
        f"  {limit:<22} broken by {counted(count, 'design')}"
        for limit, count in record["broken"].items()
    ]
    lines += ["worst first", *(f"  {_breach(each, cube)}" for each in record["breaches"])]
    return "\n".join(lines)


def _breach(breach: Record, cube: Cube) -> str:
    design, limit = breach["design"], breach["limit"]
    place = {
        axis.column: axis.values[design // cube.strides[axis.column] % len(axis)]
        for axis in cube.axes
    }
    if limit == NO_EQUILIBRIUM:
        words = "has a state without equilibrium"
    elif limit == SLACK:
        words = f"is slack, {_shown('margin', -breach['value'])} short of the pretension it needs"
    else:
        column = LIMITS[limit].column
        value, bound = (_shown(column, breach[each]) for each in ("value", "bound"))
        words = f"has {column} {value}, {'below' if limit.startswith('min_') else 'above'} {bound}"
        words += f" by {100 * breach['excess']:.3g} %" if breach["bound"] else ""
    if breach["direction"] is not None:
        words += (
            f"; worst in {breach['direction']} at {number(math.degrees(breach['elbow_angle']))} deg"
        )
    return f"design {design}{f' ({_where(place, cube)})' if place else ''}: {words}"


def _shown(column: str, value: float) -> str:
    return (
        Shown.of(column, QUANTITIES[column]).text(value) if column in QUANTITIES else number(value)
    )


def comparison_text(record: Record, cube: Cube, names: tuple[str, str]) -> str:
    """What was compared, then columns and designs that changed, the worst first, and what could not be compared."""
    head = "nothing changed" if record["holds"] else "changed"
    compared = " and ".join(
        f"{counted(columns, 'column')} of {counted(record[table], table[:-1])}"
        for table, columns in record["columns"].items()
    )
    compared += "" if "states" in record["columns"] else "; no states, which are not kept by both"
    lines = [f"{names[0]}: {head} since {names[1]}", f"  compared: {compared}"]
    if record["within"] is not None:
        lines.append(
            f"  within the tolerance, the largest difference: {_change(record['within'], cube)}"
        )
    lines += [f"  not compared, as it may differ: {text}" for text in record["excepted"]]
    lines += [f"  not compared: {text}" for text in record["missing"]]
    lines += [f"  {_change(each, cube)}" for each in record["changes"]]
    if record["flipped"]:
        lines.append(
            f"feasible in one run only: {counted(record['flipped'], 'design')}, worst first"
        )
        lines += [f"  {_flip(each, cube)}" for each in record["flips"]]
    return "\n".join(lines)


def _change(change: Record, cube: Cube) -> str:
    head, place = (
        f"{change['table']}.{change['column']}: {counted(change['rows'], 'row')}",
        _where(change["where"], cube),
    )
    difference, share = change["difference"], change["share"]
    if difference is None:
        return f"{head}, first at {place}"
    by = (
        "null in one only"
        if math.isinf(difference)
        else f"by {_shown(change['column'], difference)}"
    )
    return (
        f"{head}, most {by}{'' if math.isinf(share) else f' ({share:.3g} of its scale)'} at {place}"
    )


def _flip(flip: Record, cube: Cube) -> str:
    now = "feasible now, was not" if flip["now"] else "not feasible now, was"
    margins = flip["margin_before"], flip["margin_now"]
    moved = (
        "; margin {}, now {}".format(*(_shown("margin", each) for each in margins))
        if None not in margins
        else ""
    )
    return f"{_where(flip['where'], cube)}: {now}{moved}"


def _where(where: Record, cube: Cube) -> str:
    """A row by its axes."""
    words = []
    for column, value in where.items():
        shown = Shown.of(column, QUANTITIES[column]) if column in QUANTITIES else None
        text = value if isinstance(value, str) else (shown or cube.shown(column)).text(float(value))
        words.append(f"{column} {text}")
    return ", ".join(words) or "the only row"


def as_markdown(text: str, *, holds: bool) -> str:
    """The same for a job's summary."""
    head, *rest = text.split("\n")
    mark = "within limits" if holds else "not as hoped"
    body = "\n".join(
        f"- {line.strip()}" if line.startswith("  ") else f"\n**{line}**\n" for line in rest
    )
    return f"### tendon check: {mark}\n\n{_escaped(head)}\n\n{_escaped(body)}".rstrip() + "\n"


def _escaped(text: str) -> str:
    """Names from studies say no Markdown and no HTML."""
    for sign, harmless in (
        ("&", "&amp;"),
        ("<", "&lt;"),
        (">", "&gt;"),
        ("|", "\\|"),
        ("`", "\\`"),
        ("[", "\\["),
    ):
        text = text.replace(sign, harmless)
    return text
