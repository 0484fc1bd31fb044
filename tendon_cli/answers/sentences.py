"""What the texts of an answer share: sentences of 80 columns, an end of a window with what binds there."""

from __future__ import annotations

import re
import textwrap

import numpy as np

from tendon_cli.answers.answer import Findings
from tendon_cli.answers.candidates import Candidates
from tendon_cli.answers.conflicts import Conflict
from tendon_cli.answers.words import broken, of_row, rounded, shown
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.quantities import QUANTITIES

WIDTH = 80
_JOINED = "\u00a0"
_UNIT = re.compile(r"(?<=\d) (?=(?:N|kN|mm|m|deg|kPa|kg|%|rad|GPa|1)\b)|(?<=\d N) (?=m\b)|(?<=\b[A-Zημφψ]) (?=\d)")
"""Blanks within a quantity, where no line ends."""


def end_said(found: Findings, chosen: Candidates, end: str) -> str:
    """One end of a window, with what binds there."""
    solutions, problem = chosen.solutions, found.problem
    value, code = getattr(solutions, f"pretension_{end}")[0], int(getattr(solutions, f"{end}_by")[0])
    if code == NOTHING:
        return f"{rounded(value, 4)} N there is no pretension" if end == "from" else "nothing breaks a limit"
    said = f"{rounded(value, 4)} N {broken(LIMIT_NAMES[code], problem.study.limits)}"
    return f"{said}{where_said(found, chosen, end)}"


def where_said(found: Findings, chosen: Candidates, end: str) -> str:
    """The condition and the state that bind, in brackets."""
    problem, state = found.problem, int(getattr(chosen.solutions, f"{end}_state")[0])
    condition = np.array([getattr(chosen.solutions, f"{end}_condition")[0]])
    said = [of_row(problem.conditions, {n: v[0] for n, v in problem.conditions.columns(condition).items()})]
    if state >= 0:
        direction, angle = divmod(state, problem.angles.size)
        at = shown(QUANTITIES["elbow_angle"], problem.angles[0, angle])
        said.append(f"{problem.study.motion.direction[direction]}, {at}")
    inside = ", ".join(word for word in said if word)
    return f" ({inside})" if inside else ""


def of_quantity(name: str, value: float) -> str:
    """A value in SI of a quantity by its name, with its unit."""
    return shown(QUANTITIES[name], value)


def conflict_named(each: Conflict) -> str:
    """The limits of a conflict."""
    return f"{each.limits[0]} against {each.limits[1]}" if len(each.limits) > 1 else f"{each.limits[0]}"


def row_of(one: Candidates) -> dict[str, float]:
    """The first of some choices by its columns."""
    return {name: values[0] for name, values in one.columns.items()}


def percent(share: float) -> str:
    """A share in percent; what is hardly any is none."""
    return rounded(100.0 * share, 2) if share > 1e-4 else "0"


def filled(text: str, indent: str = "") -> list[str]:
    """A sentence on as many lines as it takes."""
    lines = textwrap.wrap(
        _UNIT.sub(_JOINED, text), WIDTH, initial_indent=indent, subsequent_indent=indent + "  ",
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
    return [line.replace(_JOINED, " ") for line in lines]
