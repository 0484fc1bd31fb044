"""An answer as text of 80 columns: the answer in one sentence, then why, then alternatives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from tendon_cli.answers.answer import Findings, sought
from tendon_cli.answers.candidates import Candidates
from tendon_cli.answers.crowd import Crowd
from tendon_cli.answers.crowd_text import lines_of
from tendon_cli.answers.factors import PRETENSION
from tendon_cli.answers.no_window import no_window
from tendon_cli.answers.rank import Goal, losses
from tendon_cli.answers.sensitivity import Sensitivity
from tendon_cli.answers.sentences import WIDTH, conflict_named, end_said, filled, of_quantity, percent, row_of
from tendon_cli.answers.words import of_key, of_row, rounded
from tendon_cli.studies.study import keys, split_side
from tendon_cli.units import counted

_MOST_ALTERNATIVES = 8
_MOST_MOVES = 5
_EDGE = 1e-9


def text_of(found: Findings, crowd: Crowd | None = None) -> str:
    """The whole answer, and what it is to persons or draws."""
    chosen = found.chosen
    parts = [*(no_window(found) if chosen is None else _something(found, chosen))]
    if crowd is not None:
        parts += [line for text, indent in lines_of(crowd) for line in filled(text, indent) or [""]]
    return "\n".join([*parts, *_paragraphs("Note: ", found.notes)])


# --- Something suits -------------------------------------------------------------------------------------------------


def _something(found: Findings, chosen: Candidates) -> Iterator[str]:
    yield from filled(_first_sentence(found, chosen))
    yield from _why(found, chosen)
    yield from _at_its_pretension(chosen)
    yield from _own(found, chosen)
    yield from _edges(found, chosen)
    yield from _moves(found)
    yield from _alternatives(found)
    yield from _rest(found)


def _first_sentence(found: Findings, chosen: Candidates) -> str:
    solutions, problem = chosen.solutions, found.problem
    what = of_row(problem.choices, row_of(chosen))
    start = f"{what}: a pretension" if what else "A pretension"
    low, high = solutions.pretension_from[0], solutions.pretension_to[0]
    span = f"anything from {rounded(low, 4)}" + (f" to {rounded(high, 4)} N" if np.isfinite(high) else " N on")
    sentence = f"{start} of {rounded(solutions.pretension[0], 4)} N suits {_everyone(found, chosen)}; {span} does"
    if np.isfinite(high):
        sentence += f", {percent(solutions.tolerance[0])} % either way"
    return sentence + _as_what(found, chosen) + "."


def _everyone(found: Findings, chosen: Candidates) -> str:
    """Whom the pretension suits."""
    conditions = len(found.problem.conditions)
    if chosen.solutions.served[0] < 1.0:
        whom = "of them" if found.problem.conditions.groups is None else "of those asked about"
        return f"at least {rounded(100 * found.problem.enough)} % {whom}"
    return "the design" if conditions == 1 else f"all {conditions} conditions"


def _as_what(found: Findings, chosen: Candidates) -> str:
    """Why this choice stands first."""
    if found.gathered.choices == 1:
        return ""
    if len(found.goals) > 1 and found.front is not None:
        worth = found.front.worth(found.goals)
        given_up = losses(worth)[np.flatnonzero(found.front.row == chosen.row[0])[0]] if len(worth) > 1 else np.zeros(1)
        return f". It is the knee of the front: {rounded(100 * given_up.max(), 2)} % of what any goal spans is given up"
    goal = sought(found.problem)[0]
    return f". Of {counted(found.gathered.choices, 'choice')} it has the {_superlative(goal)}"


def _superlative(goal: Goal) -> str:
    return f"{'largest' if goal.maximise else 'least'} {_named(goal.column)}"


def _named(column: str) -> str:
    return (
        column.replace("served", "share served")
        .replace("max_", "")
        .replace("min_", "")
        .replace("peak_", "")
        .replace("_", " ")
    )


def _why(found: Findings, chosen: Candidates) -> Iterator[str]:
    yield "\nWhy"
    for end, word in (("from", "below"), ("to", "above")):
        yield from filled(f"{word} {end_said(found, chosen, end)}", "  ")


def _at_its_pretension(chosen: Candidates) -> Iterator[str]:
    solutions = chosen.solutions
    said = [
        f"tension {of_quantity('max_tension', solutions.max_tension[0])}",
        f"spring extension {of_quantity('max_spring_extension', solutions.max_spring_extension[0])}",
        f"motor torque {of_quantity('peak_motor_torque', solutions.peak_motor_torque[0])}",
        f"elbow stiffness {of_quantity('min_elbow_stiffness', solutions.min_elbow_stiffness[0])}",
    ]
    if not np.isnan(solutions.max_contact_pressure[0]):
        said.append(f"strap {of_quantity('max_contact_pressure', solutions.max_contact_pressure[0])}")
    yield from filled(f"at {rounded(solutions.pretension[0], 4)} N at worst: {', '.join(said)}", "  ")


def _own(found: Findings, chosen: Candidates) -> Iterator[str]:
    """Whether the study's own pretension would do, where it asks of one design and says one."""
    given = {key: values for key, values in found.problem.study.numbers.items() if split_side(key)[0] == PRETENSION}
    if found.gathered.choices > 1 or list(given) != [PRETENSION] or given[PRETENSION].is_axis:
        return
    own, low, high = given[PRETENSION].single, chosen.solutions.pretension_from[0], chosen.solutions.pretension_to[0]
    said = "suits, too" if low <= own <= high else "is too little" if own < low else "is too much"
    yield from filled(f"the study's own {rounded(own, 4)} N {said}", "  ")


def _edges(found: Findings, chosen: Candidates) -> Iterator[str]:
    """Where the best is at the end of a range that was asked for."""
    for factor in found.problem.choices.factors:
        if not factor.is_range:
            continue
        value, span = float(chosen.columns[factor.column][0]), factor.values
        for edge, word in ((span.min(), "lower"), (span.max(), "upper")):
            if abs(value - edge) <= _EDGE * abs(edge):
                symbol = keys()[factor.key].number.quantity.symbol
                yield from filled(f"{symbol} is at its {word} end, {of_key(factor.key, value)}: widen the range", "  ")


def _moves(found: Findings) -> Iterator[str]:
    """What moves the ends of the window most."""
    if not found.sensitivities:
        return
    yield "\nWhat moves the window most, per 1 %"
    for end, word in (("from", "lower"), ("to", "upper")):
        of_end = [each for each in found.sensitivities if each.end == end and each.per_percent][:_MOST_MOVES]
        if of_end:
            yield from filled(f"{word} end: {', '.join(map(_move, of_end))}", "  ")
    if any(not each.steady for each in found.sensitivities):
        yield from filled("* within 1 % another limit or state takes over", "  ")


def _move(each: Sensitivity) -> str:
    key = each.key.removeprefix("limits.")
    name = keys()[each.key].number.quantity.symbol if each.key in keys() else key
    return f"{name} {each.per_percent:+.2g} N{'' if each.steady else '*'}"


def _alternatives(found: Findings) -> Iterator[str]:
    """The best by each goal, or the front, as a small table."""
    if found.gathered.choices + len(found.beside) < 2:
        return
    if found.front is not None:
        step = max(1, len(found.front) // _MOST_ALTERNATIVES)
        rows = [("", found.front.taken(np.array([at]))) for at in range(0, len(found.front), step)]
        yield f"\nThe front ({counted(len(found.front), 'choice')}; no other is better in every goal)"
    else:
        rows = [(_superlative(goal), found.best[goal.column]) for goal in sought(found.problem)]
        yield "\nBest by"
    yield from _table(found, rows)
    if found.gains:
        said = [f"{_named(column)} by {rounded(100 * gain, 2)} %" for column, gain in found.gains.items()]
        yield from filled(f"~ between the points of the grid; better than it in {', '.join(said)}", "  ")


def _table(found: Findings, rows: list[tuple[str, Candidates]]) -> Iterator[str]:
    head = ("", "", "window N", "±%", "N", "tension", "spring", "torque")
    lines = [head]
    for name, one in rows:
        s = one.solutions
        high = rounded(s.pretension_to[0]) if np.isfinite(s.pretension_to[0]) else "on"
        lines.append((
            name, ("~" if one.row[0] < 0 else "") + of_row(found.problem.choices, row_of(one)),
            f"{rounded(s.pretension_from[0])} to {high}", percent(s.tolerance[0]), rounded(s.pretension[0]),
            of_quantity("max_tension", s.max_tension[0]),
            of_quantity("max_spring_extension", s.max_spring_extension[0]),
            of_quantity("peak_motor_torque", s.peak_motor_torque[0]),
        ))  # fmt: skip
    widths = [max(len(line[at]) for line in lines) for at in range(len(head))]
    while sum(widths) + 2 * len(widths) > WIDTH and len(widths) > 4:  # what does not fit is in the tables
        widths.pop()
    for line in lines:
        cells = [cell.ljust(width) for cell, width in zip(line, widths, strict=False)]
        yield ("  " + "  ".join(cell for cell in cells if cell)).rstrip()[:WIDTH]


def _rest(found: Findings) -> Iterator[str]:
    """How many choices suit, and what leaves the others without a window."""
    gathered = found.gathered
    if gathered.choices > 1:
        yield ""
        yield from filled(f"{gathered.feasible:,} of {counted(gathered.choices, 'choice')} have a window.")
    for each in found.conflicts:
        yield from filled(f"{conflict_named(each)} in {counted(each.choices, 'choice')}", "  ")


def _paragraphs(start: str, texts: Iterable[str]) -> list[str]:
    return [line for text in texts for line in filled(f"{start}{text}")]
