"""An answer as text of 80 columns: the answer in one sentence, then why, then alternatives."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Iterator

import numpy as np

from tendon_cli.design.answer import Findings, sought
from tendon_cli.design.candidates import Candidates
from tendon_cli.design.conflicts import Conflict
from tendon_cli.design.crowd import Crowd
from tendon_cli.design.crowd_text import lines_of
from tendon_cli.design.factors import PRETENSION
from tendon_cli.design.fixes import Fix
from tendon_cli.design.rank import Goal, losses
from tendon_cli.design.sensitivity import Sensitivity
from tendon_cli.design.words import broken, counted, of_key, of_row, rounded, shown
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.quantities import QUANTITIES
from tendon_cli.study.study import keys, split_side

WIDTH = 80
_MOST_ALTERNATIVES = 8
_MOST_MOVES = 5
_EDGE = 1e-9
_JOINED = "\u00a0"
_UNIT = re.compile(r"(?<=\d) (?=(?:N|kN|mm|m|deg|kPa|kg|%|rad|GPa|1)\b)|(?<=\d N) (?=m\b)|(?<=\b[A-Zημφψ]) (?=\d)")
"""Blanks within a quantity, where no line ends."""


def text_of(found: Findings, crowd: Crowd | None = None) -> str:
    """The whole answer, and what it is to persons or draws."""
    chosen = found.chosen
    parts = [*(_nothing(found) if chosen is None else _something(found, chosen))]
    if crowd is not None:
        parts += [line for text, indent in lines_of(crowd) for line in _filled(text, indent) or [""]]
    return "\n".join([*parts, *_paragraphs("Note: ", found.notes)])


# --- Something suits -------------------------------------------------------------------------------------------------


def _something(found: Findings, chosen: Candidates) -> Iterator[str]:
    yield from _filled(_first_sentence(found, chosen))
    yield from _why(found, chosen)
    yield from _at_its_pretension(chosen)
    yield from _own(found, chosen)
    yield from _edges(found, chosen)
    yield from _moves(found)
    yield from _alternatives(found)
    yield from _rest(found)


def _first_sentence(found: Findings, chosen: Candidates) -> str:
    solutions, problem = chosen.solutions, found.problem
    what = of_row(problem.choices, _row(chosen))
    start = f"{what}: a pretension" if what else "A pretension"
    low, high = solutions.pretension_from[0], solutions.pretension_to[0]
    span = f"anything from {rounded(low, 4)}" + (f" to {rounded(high, 4)} N" if np.isfinite(high) else " N on")
    sentence = f"{start} of {rounded(solutions.pretension[0], 4)} N suits {_everyone(found, chosen)}; {span} does"
    if np.isfinite(high):
        sentence += f", {_percent(solutions.tolerance[0])} % either way"
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
        yield from _filled(f"{word} {_end(found, chosen, end)}", "  ")


def _end(found: Findings, chosen: Candidates, end: str) -> str:
    """One end of a window, with what binds there."""
    solutions, problem = chosen.solutions, found.problem
    value, code = getattr(solutions, f"pretension_{end}")[0], int(getattr(solutions, f"{end}_by")[0])
    if code == NOTHING:
        return f"{rounded(value, 4)} N there is no pretension" if end == "from" else "nothing breaks a limit"
    said = f"{rounded(value, 4)} N {broken(LIMIT_NAMES[code], problem.study.limits)}"
    return f"{said}{_where(found, chosen, end)}"


def _where(found: Findings, chosen: Candidates, end: str) -> str:
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


def _at_its_pretension(chosen: Candidates) -> Iterator[str]:
    solutions = chosen.solutions
    said = [
        f"tension {_of('max_tension', solutions.max_tension[0])}",
        f"spring extension {_of('max_spring_extension', solutions.max_spring_extension[0])}",
        f"motor torque {_of('peak_motor_torque', solutions.peak_motor_torque[0])}",
        f"elbow stiffness {_of('min_elbow_stiffness', solutions.min_elbow_stiffness[0])}",
    ]
    if not np.isnan(solutions.max_contact_pressure[0]):
        said.append(f"strap {_of('max_contact_pressure', solutions.max_contact_pressure[0])}")
    yield from _filled(f"at {rounded(solutions.pretension[0], 4)} N at worst: {', '.join(said)}", "  ")


def _of(name: str, value: float) -> str:
    return shown(QUANTITIES[name], value)


def _own(found: Findings, chosen: Candidates) -> Iterator[str]:
    """Whether the study's own pretension would do, where it asks of one design and says one."""
    given = {key: values for key, values in found.problem.study.numbers.items() if split_side(key)[0] == PRETENSION}
    if found.gathered.choices > 1 or list(given) != [PRETENSION] or given[PRETENSION].is_axis:
        return
    own, low, high = given[PRETENSION].single, chosen.solutions.pretension_from[0], chosen.solutions.pretension_to[0]
    said = "suits, too" if low <= own <= high else "is too little" if own < low else "is too much"
    yield from _filled(f"the study's own {rounded(own, 4)} N {said}", "  ")


def _edges(found: Findings, chosen: Candidates) -> Iterator[str]:
    """Where the best is at the end of a range that was asked for."""
    for factor in found.problem.choices.factors:
        if not factor.is_range:
            continue
        value, span = float(chosen.columns[factor.column][0]), factor.values
        for edge, word in ((span.min(), "lower"), (span.max(), "upper")):
            if abs(value - edge) <= _EDGE * abs(edge):
                symbol = keys()[factor.key].number.quantity.symbol
                yield from _filled(f"{symbol} is at its {word} end, {of_key(factor.key, value)}: widen the range", "  ")


def _moves(found: Findings) -> Iterator[str]:
    """What moves the ends of the window most."""
    if not found.sensitivities:
        return
    yield "\nWhat moves the window most, per 1 %"
    for end, word in (("from", "lower"), ("to", "upper")):
        of_end = [each for each in found.sensitivities if each.end == end and each.per_percent][:_MOST_MOVES]
        if of_end:
            yield from _filled(f"{word} end: {', '.join(map(_move, of_end))}", "  ")
    if any(not each.steady for each in found.sensitivities):
        yield from _filled("* within 1 % another limit or state takes over", "  ")


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
        yield from _filled(f"~ between the points of the grid; better than it in {', '.join(said)}", "  ")


def _table(found: Findings, rows: list[tuple[str, Candidates]]) -> Iterator[str]:
    head = ("", "", "window N", "±%", "N", "tension", "spring", "torque")
    lines = [head]
    for name, one in rows:
        s = one.solutions
        high = rounded(s.pretension_to[0]) if np.isfinite(s.pretension_to[0]) else "on"
        lines.append((
            name, ("~" if one.row[0] < 0 else "") + of_row(found.problem.choices, _row(one)),
            f"{rounded(s.pretension_from[0])} to {high}", _percent(s.tolerance[0]), rounded(s.pretension[0]),
            _of("max_tension", s.max_tension[0]), _of("max_spring_extension", s.max_spring_extension[0]),
            _of("peak_motor_torque", s.peak_motor_torque[0]),
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
        yield from _filled(f"{gathered.feasible:,} of {counted(gathered.choices, 'choice')} have a window.")
    for each in found.conflicts:
        yield from _filled(f"{_in_conflict(each)} in {counted(each.choices, 'choice')}", "  ")


# --- Nothing suits ---------------------------------------------------------------------------------------------------


def _nothing(found: Findings) -> Iterator[str]:
    conditions = len(found.problem.conditions)
    whom = "the design" if conditions == 1 else f"all {conditions} conditions"
    if found.problem.enough < 1.0:
        whom = f"{rounded(100 * found.problem.enough)} % of them"
    choices = found.gathered.choices
    of_what = "" if choices == 1 else f", whichever of {choices:,} choices is taken"
    yield from _filled(f"No pretension suits {whom}{of_what}.")
    yield "\nWhy"
    for each in found.conflicts:
        yield from _conflict(found, each)
    if found.fixes:
        yield "\nWhat would fix it, all else equal"
        yield from _fixes(found)


def _conflict(found: Findings, each: Conflict) -> Iterator[str]:
    s = each.nearest.solutions
    what = of_row(found.problem.choices, _row(each.nearest))
    if found.gathered.choices > 1:
        yield from _filled(
            f"{_in_conflict(each)} in {counted(each.choices, 'choice')}; nearest to a window: {what}", "  "
        )
    if np.isnan(s.pretension_from[0]):
        limit = LIMIT_NAMES[int(s.from_by[0])]
        said = broken(limit, found.problem.study.limits)
        yield from _filled(f"whatever the pretension, {said}{_where(found, each.nearest, 'from')}", "  ")
    else:
        yield from _filled(f"below {_end(found, each.nearest, 'from')},", "  ")
        yield from _filled(f"above {_end(found, each.nearest, 'to')}: {rounded(each.gap)} N apart", "  ")
        if s.served[0] > 0.0 and found.problem.enough >= 1.0 and len(found.problem.conditions) > 1:
            share = f"{rounded(100 * s.served[0])} % of the conditions"
            yield from _filled(f"one pretension, {rounded(s.pretension[0])} N, suits {share}", "  ")
    for limit, value in each.relaxed.items():
        bound = shown(QUANTITIES[limit], value) if value is not None else ""
        yield from _filled(f"{limit} {bound} would do" if bound else f"relaxing {limit} does not help", "  ")


def _in_conflict(each: Conflict) -> str:
    return f"{each.limits[0]} against {each.limits[1]}" if len(each.limits) > 1 else f"{each.limits[0]}"


def _fixes(found: Findings) -> Iterator[str]:
    helps = [fix for fix in found.fixes if fix.after is not None]
    rows = [_fix(fix) for fix in helps]
    if rows:
        head = ("", "N", "tension", "spring", "torque")
        widths = [max(len(row[at]) for row in (head, *rows)) for at in range(len(head))]
        for row in (head, *rows):
            yield ("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))).rstrip()
    idle = [keys()[fix.knobs[0]].number.quantity.symbol for fix in found.fixes if fix.after is None]
    if idle:
        yield from _filled(f"none within its plausible range: {', '.join(idle)}; nor pretension", "  ")


def _fix(fix: Fix) -> tuple[str, ...]:
    changes = [
        f"{of_key(key, before)} to {shown(keys()[key].number.quantity, after)}"
        for key, before, after in zip(fix.knobs, fix.before, fix.after or (), strict=True)
    ]
    costs = fix.costs or {}
    names = ("max_tension", "max_spring_extension", "peak_motor_torque")
    return (" and ".join(changes), rounded(fix.pretension), *(_of(name, costs[name]) for name in names))


def _percent(share: float) -> str:
    """A share in percent; what is hardly any is none."""
    return rounded(100.0 * share, 2) if share > 1e-4 else "0"


def _row(one: Candidates) -> dict[str, float]:
    return {name: values[0] for name, values in one.columns.items()}


def _filled(text: str, indent: str = "") -> list[str]:
    """A sentence on as many lines as it takes."""
    lines = textwrap.wrap(
        _UNIT.sub(_JOINED, text), WIDTH, initial_indent=indent, subsequent_indent=indent + "  ",
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
    return [line.replace(_JOINED, " ") for line in lines]


def _paragraphs(start: str, texts: Iterable[str]) -> list[str]:
    return [line for text in texts for line in _filled(f"{start}{text}")]
