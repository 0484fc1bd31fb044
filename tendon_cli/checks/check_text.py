"""Text of a check, for a terminal, or in Markdown for a job's summary."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tendon_cli import say
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import ColumnLabel, number
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.units import counted

NO_EQUILIBRIUM = "no equilibrium"
SLACK = "slack"
NEGATIVE = "negative result"
WORST = 10
"""Number of breaches, or of designs whose feasibility changed, that are listed by default."""

_MOST_ANNOTATED = 12
"""Most lines of a check that an annotation has."""

_ESCAPES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", "|": "\\|", "`": "\\`", "[": "\\["}

Record = Mapping[str, Any]


@dataclass(frozen=True)
class CheckResult:
    """Result of a check."""

    holds: bool
    """True if every design is within its limits, or if nothing changed."""
    text: str
    record: dict[str, Any]
    verdict: str
    """The result in two or three words."""


def finite(value: Any) -> Any:
    """Replace numbers of a record that are infinite or NaN by None, for JSON."""
    if isinstance(value, float):
        return finite_or_none(value)
    if isinstance(value, Mapping):
        return {name: finite(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value


def verdict_text(record: Record, cube: Cube, name: str) -> str:
    """Return one line if every design is within its limits, else the breaches, the worst first."""
    designs = record["designs"]
    if record["holds"] and designs == 1:
        return f"{name}: the design is within its limits"
    if record["holds"]:
        return f"{name}: all {designs:,} designs are within their limits"
    failing = designs - record["feasible"]
    are = "is" if failing == 1 else "are"
    lines = [f"{name}: {failing:,} of {counted(designs, 'design')} {are} not within the limits"]
    for limit, count in record["broken"].items():
        lines.append(f"  {limit:<22} broken by {counted(count, 'design')}")
    lines.append("the worst first")
    lines += [f"  {_breach_text(breach, cube)}" for breach in record["breaches"]]
    return "\n".join(lines)


def _breach_text(breach: Record, cube: Cube) -> str:
    """Say which limit a design breaks, by how much, and in which state."""
    design = breach["design"]
    values = {
        axis.column: axis.values[design // cube.strides[axis.column] % len(axis)]
        for axis in cube.axes
    }
    place = f" ({place_text(values, cube)})" if values else ""
    text = f"design {design}{place}: {_excess_text(breach)}"
    if breach["direction"] is not None:
        angle = number(math.degrees(breach["elbow_angle"]))
        moment = "" if breach["time"] is None else f" at {shown('time', breach['time'])},"
        text += f"; worst{moment} in {breach['direction']} at {angle} deg"
    return text


def _excess_text(breach: Record) -> str:
    """Say by how much a design breaks a limit."""
    limit = breach["limit"]
    if limit == NO_EQUILIBRIUM:
        return "has a state without equilibrium"
    if limit == SLACK:
        missing = shown("margin", -breach["value"])
        return f"goes slack, {missing} short of the pretension that it needs"
    column = LIMITS[limit].column
    value = shown(column, breach["value"])
    bound = shown(column, breach["bound"])
    side = "below" if limit.startswith("min_") else "above"
    text = f"has {column} {value}, {side} {bound}"
    if breach["bound"]:
        text += f" by {say.percent(breach['excess'])}"
    return text


def shown(column: str, value: float) -> str:
    """Write a value of a column in the unit that people read."""
    if column not in QUANTITIES:
        return number(value)
    return ColumnLabel.of(column, QUANTITIES[column]).text(value)


def place_text(where: Record, cube: Cube) -> str:
    """Name a design or a state by its values on the axes."""
    words = []
    for column, value in where.items():
        if isinstance(value, str):
            text = value
        else:
            quantity = QUANTITIES.get(column)
            shown = ColumnLabel.of(column, quantity) if quantity else cube.shown(column)
            text = shown.text(float(value))
        words.append(text if text.startswith(f"{column} ") else f"{column} {text}")
    return ", ".join(words) or "the only row"


def escaped(text: str) -> str:
    """Escape names from studies, so that nothing in them is read as Markdown or HTML."""
    for sign, escape in _ESCAPES.items():
        text = text.replace(sign, escape)
    return text


def annotation(text: str, verdict: str) -> str:
    """Return the line by which GitHub shows a failed check beside the job, and in the summary.

    Ends of lines and the signs that such a line reserves are written as it demands.
    """
    shown = "\n".join(text.split("\n")[:_MOST_ANNOTATED])
    for sign, escape in (("%", "%25"), ("\r", "%0D"), ("\n", "%0A")):
        shown = shown.replace(sign, escape)
    return f"::error title=tendon check - {verdict}::{shown}"


def as_markdown(text: str, verdict: str) -> str:
    """Convert the text of a check to Markdown, for a job's summary, with the verdict above it."""
    head, *rest = text.split("\n")
    lines = []
    for line in rest:
        is_item = line.startswith("  ")
        lines.append(f"- {line.strip()}" if is_item else f"\n**{line}**\n")
    body = escaped("\n".join(lines))
    return f"### tendon check: {verdict}\n\n{escaped(head)}\n\n{body}".rstrip() + "\n"
