"""An answer in blocks, from its record: one sentence, then the reasons, then alternatives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from tendon_cli import say
from tendon_cli.answers import phrases
from tendon_cli.answers.fixes import fixes_table
from tendon_cli.answers.phrases import COSTS, Row, costs, ends_of, parameter, row_words
from tendon_cli.answers.relax import relaxations_in_words
from tendon_cli.answers.setup import drift_in_words, on_whom, posture, to_set
from tendon_cli.studies.study import keys
from tendon_cli.windows.question import Goal, Question

_MOST_ALTERNATIVES = 8
_MOST_MOVES = 5
_HARDLY_ANY = 1e-4
"""Tolerance up to which it is printed as 0."""
_WORST = {
    "max_tension": "a tension of",
    "max_spring_extension": "a spring extension of",
    "peak_motor_torque": "a motor torque of",
    "min_elbow_stiffness": "an elbow stiffness of",
    "max_contact_pressure": "a strap pressure of",
}


def answer_blocks(problem: Question, record: Row) -> Iterator[say.Block]:
    """Yield the blocks of the whole answer, with its part on persons or draws, and its notes."""
    if record["best"] is None:
        yield from _no_window(problem, record)
    else:
        yield from _answer(problem, record)
    if record["population"] is not None:
        yield from phrases.population_blocks(problem, record["population"])
    yield from ({"note": note} for note in record["notes"])


def _list(heading: str, texts: Iterable[str]) -> Iterator[say.Block]:
    """Yield a list under its heading; nothing if it is empty."""
    items = [*texts]
    if items:
        yield say.heading(heading)
        yield from say.items(items)


# --- There is a window ----------------------------------------------------------------------------


def _answer(problem: Question, record: Row) -> Iterator[say.Block]:
    """Yield the answer if a choice has a window."""
    yield say.sentence(
        f"{_first_sentence(problem, record)} {say.proof_sentence(record['between_samples'])}"
    )
    yield from _list("Why", _why(problem, record))
    in_posture = posture(problem, record["setting"])
    yield from _list(f"To set it{on_whom(problem)}: {in_posture}", to_set(problem, record))
    remarks = (f"{remark['text']} ({remark['source']})" for remark in record["remarks"])
    yield from _list("Before you build it", remarks)
    yield from _list("What moves the window most, per 1 %", _moves(record["sensitivities"]))
    yield from _alternatives(problem, record)
    yield from _list("Choices to be proved", (_proved(problem, row) for row in record["proved"]))
    if record["choices"] > 1:
        choices = say.counted(record["choices"], "choice")
        have = "has" if record["feasible"] == 1 else "have"
        yield say.sentence(f"{record['feasible']:,} of {choices} {have} a window.")
    yield from say.items(_in_choices(problem, conflict) for conflict in record["conflicts"])


def _first_sentence(problem: Question, record: Row) -> str:
    """Say the best pretension, whom it serves, and the window."""
    best = record["best"]
    noun, where = say.setting_words(problem.study.setting.read)
    low, high = ends_of(best)
    choice = row_words(problem.choices, best)
    start = f"{choice}: a {noun}" if choice else f"A {noun}"
    served = best["served_at"]
    whom = _all_of(problem) if served >= 1.0 else f"{say.percent(served)} of {_everyone(problem)}"
    if problem.placement.given is not None:
        pretension = say.number(problem.placement.given)
        margins = phrases.margins(problem, best)
        return f"{start} of {pretension} N{where} suits {whom}; {margins}."
    either_way = f", {_tolerance(best)} % either way" if np.isfinite(high) else ""
    if problem.serve >= 1.0 or len(problem.groups.weighting) == 1:
        then = f"suits {whom}; anything {_span(low, high)} does{either_way}"
    else:
        enough = say.percent(problem.serve)
        then = f"serves {whom}; at least {enough} are served {_span(low, high)}{either_way}"
        window_for_all = record["window_for_all"]
        if window_for_all is not None:
            all_low, all_high = window_for_all
            all_high = np.inf if all_high is None else all_high
            is_same = (all_low, all_high) == (low, high)
            then += ", all of them " + ("there" if is_same else _span(all_low, all_high))
    return f"{start} of {_pretension(best)}{where} {then}.{_why_first(problem, record)}"


def _pretension(row: Row) -> str:
    """Say the pretension of a choice, rounded so that it stays in its window."""
    return f"{say.number_within(row['pretension'], *ends_of(row))} N"


def _span(low: float, high: float) -> str:
    """Say a window: "from 100 to 120 N"."""
    if np.isfinite(high):
        return f"from {say.number(low)} to {say.number(high)} N"
    return f"from {say.number(low)} N on"


def _tolerance(row: Row) -> str:
    """Say the tolerance in percent, "0" if there is hardly any."""
    if row["tolerance"] > _HARDLY_ANY:
        return say.number(100.0 * row["tolerance"], 2)
    return "0"


def _everyone(problem: Question) -> str:
    """Say who or what a share is counted in: "1,000 persons"."""
    return phrases.everyone(
        problem.groups.counts, len(problem.groups.weighting), problem.groups.noun
    )


def _all_of(problem: Question) -> str:
    """Say whom or what a pretension must suit: "all 1,000 persons", "the design"."""
    whom = _everyone(problem)
    is_single = len(problem.groups.weighting) == 1
    if problem.groups.noun == "conditions" and is_single:
        return "the design"
    if whom.startswith("this"):
        return whom if is_single else f"all of {whom}"
    return f"all {whom}"


def _why_first(problem: Question, record: Row) -> str:
    """Say why this choice is named first."""
    if record["choices"] == 1:
        return ""
    if record["given_up"] is not None:
        share = say.percent(record["given_up"])
        return (
            f" It is the best compromise on the front: it gives up at most {share} of the range of"
            " any goal."
        )
    choices = say.counted(record["choices"], "choice")
    return f" It has the {_superlative(problem.ranking[0])} of {choices}."


def _superlative(goal: Goal) -> str:
    """Say what is best by a goal: "largest tolerance"."""
    return f"{'largest' if goal.maximise else 'smallest'} {_name(goal.column)}"


def _name(column: str) -> str:
    """Say the name of a column without its extreme: "tension" of "max tension"."""
    return say.column(column).removeprefix("max ").removeprefix("min ").removeprefix("peak ")


def _why(problem: Question, record: Row) -> Iterator[str]:
    """Say the limits that bind at both ends, the worst values, and ranges that should be wider."""
    best = record["best"]
    yield phrases.end_words(problem, best, "from")
    yield f"{phrases.end_words(problem, best, 'to')}{drift_in_words(record['drift'])}"
    worst = [
        f"{words} {say.quantity(name, best[name])}" for name, words in _WORST.items() if best[name]
    ]
    yield f"at {_pretension(best)} the worst is {say.join_words(worst)}"
    yield from _edges(problem, best)


def _proved(problem: Question, row: Row) -> str:
    """Say the window of a choice that was to be proved."""
    result = "no window"
    if row["feasible"]:
        result = f"{say.window_text(*ends_of(row))}, {say.proved_word(row['between_samples'])}"
    return f"{row_words(problem.choices, row) or 'the design'}: {result}"


def _edges(problem: Question, best: Row) -> Iterator[str]:
    """Say which ranges of the study have the best choice at their end."""
    for axis in problem.choices.axes:
        if not axis.is_range:
            continue
        value = float(best[axis.column])
        for edge, word in ((axis.values.min(), "lower"), (axis.values.max(), "upper")):
            if abs(value - edge) <= 1e-9 * abs(edge):
                symbol = keys()[axis.key].number.quantity.symbol
                at_edge = parameter(axis.key, value)
                yield f"{symbol} is at its {word} end, {at_edge}: widen the range"


def _moves(moves: list[Row]) -> Iterator[str]:
    """Say which numbers move the ends of the window most."""
    for end, word in (("from", "lower"), ("to", "upper")):
        of_end = [move for move in moves if move["end"] == end and move["per_percent"]]
        if of_end:
            yield f"{word} end: {', '.join(_move(move) for move in of_end[:_MOST_MOVES])}"
    if any(not move["steady"] for move in moves):
        yield "* within 1 % another limit or state takes over"


def _move(move: Row) -> str:
    """Say how a number moves an end: "K +1.2 N"."""
    key = move["key"]
    name = say.column(key.removeprefix("limits."))
    if key in keys():
        name = keys()[key].number.quantity.symbol
    return f"{name} {move['per_percent']:+.2g} N{'' if move['steady'] else '*'}"


# --- Other choices --------------------------------------------------------------------------------


def _alternatives(problem: Question, record: Row) -> Iterator[say.Block]:
    """Yield the best by each goal, or the front, as a small table."""
    front = record["front"]
    if front:
        head = f"The front ({say.counted(len(front), 'choice')}; no other is better in every goal)"
        rows = [("", row) for row in front[:: max(1, len(front) // _MOST_ALTERNATIVES)]]
    else:
        head = "Best by"
        goals = problem.ranking
        best_by = {goals[0].column: record["best"]} if record["goals"] else record["best_by"]
        rows = [
            (_superlative(goal), best_by[goal.column]) for goal in goals if goal.column in best_by
        ]
        refined = sum(bool(row["refined"]) for _, row in rows)
        if record["choices"] + refined < 2:
            return
    shows_share = problem.serve < 1.0
    share_head = ["served"] if shows_share else []
    lines = [["", "", "window N", "±%", "N", *share_head, *COSTS.values()]]
    for name, row in rows:
        low, high = ends_of(row)
        mark = "~" if row["refined"] else ""
        upper = "on" if np.isinf(high) else f"to {say.number(high, 3)}"
        share = [say.percent(row["served_at"])] if shows_share else []
        lines.append(
            [
                name,
                mark + row_words(problem.choices, row),
                f"{say.number(low, 3)} {upper}",
                _tolerance(row),
                say.number(row["pretension"], 3),
                *share,
                *costs(row),
            ]
        )
    yield say.heading(head)
    yield say.table(lines)
    if record["gains"]:
        gains = [
            f"{_name(column)} by {say.percent(gain)}" for column, gain in record["gains"].items()
        ]
        yield from say.items(
            [f"~ between the points of the grid; better than it in {', '.join(gains)}"]
        )


# --- There is no window ---------------------------------------------------------------------------


def _no_window(problem: Question, record: Row) -> Iterator[say.Block]:
    """Yield the answer if no choice has a window."""
    choices = record["choices"]
    noun, where = say.setting_words(problem.study.setting.read)
    whichever = "" if choices == 1 else f", whichever of {choices:,} choices is taken"
    whom = _all_of(problem)
    if problem.serve < 1.0:
        whom = f"{say.percent(problem.serve)} of {_everyone(problem)}"
    start = f"No {noun}{where} suits"
    if problem.placement.given is not None:
        start = f"A {noun} of {say.number(problem.placement.given)} N{where} does not suit"
    yield say.sentence(f"{start} {whom}{whichever}.")
    reasons = (
        text for conflict in record["conflicts"] for text in _conflict(problem, record, conflict)
    )
    yield from _list("Why", reasons)
    changes = relaxations_in_words(problem, record["would_take"])
    yield from _list("What it would take, all else equal", changes)
    if record["fixes"]:
        yield from fixes_table(record["fixes"])


def _in_choices(problem: Question, conflict: Row) -> str:
    """Say in how many choices which limits leave no window."""
    choices = say.counted(conflict["choices"], "choice")
    limits = conflict["limits"]
    has_window = conflict["nearest"]["pretension_from"] is not None
    if problem.placement.given is not None and has_window and len(limits) == 1:
        broken = phrases.broken(problem, limits[0])
        return f"in {choices} {say.number(problem.placement.given)} N does not work: {broken}"
    return f"in {choices} {say.conflict(limits, problem.study.limits)}"


def _conflict(problem: Question, record: Row, conflict: Row) -> Iterator[str]:
    """Say what leaves some choices without a window, and how far the nearest is from one."""
    row = conflict["nearest"]
    low, high = ends_of(row)
    if record["choices"] > 1:
        nearest = row_words(problem.choices, row)
        yield f"{_in_choices(problem, conflict)}; nearest to a window: {nearest}"
    if low is None:
        broken = phrases.broken(problem, row["from_by"])
        yield f"at any pretension {broken}{phrases.where(problem, row, 'from')}"
    elif problem.placement.given is not None and low <= high:
        end = "from" if problem.placement.given < low else "to"
        yield f"{phrases.end_words(problem, row, end)}; {phrases.margins(problem, row)}"
    else:
        yield f"{phrases.end_words(problem, row, 'from')},"
        yield f"{phrases.end_words(problem, row, 'to')}: {say.number(conflict['gap'], 3)} N apart"
        if row["served"] > 0.0 and problem.serve >= 1.0 and len(problem.conditions) > 1:
            served = f"{say.percent(row['served'])} of the {problem.groups.noun}"
            yield f"one pretension, {say.number(row['pretension'], 3)} N, suits {served}"
