"""An answer in blocks, made of its record: the answer in one sentence, then why, then alternatives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from tendon_cli import say
from tendon_cli.answers import phrases
from tendon_cli.answers.fixes import fixes_table
from tendon_cli.answers.phrases import COSTS, Row, costs, ends_of, parameter, row_words
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import Goal
from tendon_cli.answers.relax import relaxations_in_words
from tendon_cli.answers.setup import drift_in_words, on_whom, posture, to_set
from tendon_cli.studies.study import keys

_MOST_ALTERNATIVES, _MOST_MOVES = 8, 5
_WORST = {
    "max_tension": "a tension of",
    "max_spring_extension": "a spring extension of",
    "peak_motor_torque": "a motor torque of",
    "min_elbow_stiffness": "an elbow stiffness of",
    "max_contact_pressure": "a strap pressure of",
}


def blocks_of(problem: Problem, record: Row) -> Iterator[say.Block]:
    """The whole answer, what it is to persons or draws, and notes."""
    yield from _no_window(problem, record) if record["best"] is None else _answer(problem, record)
    if record["population"] is not None:
        yield from phrases.population_blocks(problem, record["population"])
    yield from ({"note": note} for note in record["notes"])


def _list(heading: str, texts: Iterable[str]) -> Iterator[say.Block]:
    """A list under its heading; nothing if it is empty."""
    some = [*texts]
    if some:
        yield say.heading(heading)
        yield from say.items(some)


# --- There is a window -----------------------------------------------------------------------------------------------


def _answer(problem: Problem, record: Row) -> Iterator[say.Block]:
    yield say.sentence(f"{_first_sentence(problem, record)} {say.proof(record['between_samples'])}")
    yield from _list("Why", _why(problem, record))
    yield from _list(
        f"To set it{on_whom(problem)}: {posture(problem, record['setting'])}",
        to_set(problem, record),
    )
    yield from _list(
        "Before you build it", (f"{each['text']} ({each['source']})" for each in record["remarks"])
    )
    yield from _list("What moves the window most, per 1 %", _moves(record["sensitivities"]))
    yield from _alternatives(problem, record)
    yield from _list("Question to be proved", (_proved(problem, row) for row in record["proved"]))
    if record["choices"] > 1:
        have = "has" if record["feasible"] == 1 else "have"
        yield say.sentence(
            f"{record['feasible']:,} of {say.counted(record['choices'], 'choice')} {have} a window."
        )
    yield from say.items(_in_choices(problem, each) for each in record["conflicts"])


def _first_sentence(problem: Problem, record: Row) -> str:
    """The pretension, whom it serves, and between which ends that holds."""
    best, (noun, at) = record["best"], say.reading(problem.study.setting.read)
    what = row_words(problem.choices, best)
    start, (low, high) = f"{what}: a {noun}" if what else f"A {noun}", ends_of(best)
    served = best["served_at"]
    whom = _all_of(problem) if served >= 1.0 else f"{say.percent(served)} of {_everyone(problem)}"
    if problem.given is not None:
        return f"{start} of {say.number(problem.given)} N{at} suits {whom}; {phrases.margins(problem, best)}."
    either_way = f", {_tolerance(best)} % either way" if np.isfinite(high) else ""
    if problem.enough >= 1.0 or len(problem.weighting) == 1:
        then = f"suits {whom}; anything {_span(low, high)} does{either_way}"
    else:
        then = f"serves {whom}; at least {say.percent(problem.enough)} are served {_span(low, high)}{either_way}"
        if (ends := record["window_for_all"]) is not None:
            of_all = (ends[0], np.inf if ends[1] is None else ends[1])
            then += ", all of them " + ("there" if of_all == (low, high) else _span(*of_all))
    return f"{start} of {_set(best)}{at} {then}.{_why_first(problem, record)}"


def _set(row: Row) -> str:
    return f"{say.within(row['pretension'], *ends_of(row))} N"


def _span(low: float, high: float) -> str:
    return f"from {say.number(low)}" + (
        f" to {say.number(high)} N" if np.isfinite(high) else " N on"
    )


def _tolerance(row: Row) -> str:
    """The tolerance in percent; what is hardly any is none."""
    return say.number(100.0 * row["tolerance"], 2) if row["tolerance"] > 1e-4 else "0"


def _everyone(problem: Problem) -> str:
    return phrases.everyone(problem.counts, len(problem.weighting), problem.counted)


def _all_of(problem: Problem) -> str:
    """What a pretension must suit."""
    whom = _everyone(problem)
    if problem.counted == "conditions" and len(problem.weighting) == 1:
        return "the design"
    if whom.startswith("this"):
        return f"all of {whom}" if len(problem.weighting) > 1 else whom
    return f"all {whom}"


def _why_first(problem: Problem, record: Row) -> str:
    """Why this choice is named first."""
    if record["choices"] == 1:
        return ""
    if record["given_up"] is not None:
        share = say.percent(record["given_up"])
        return f" It is the best compromise on the front: it gives up at most {share} of the range of any goal."
    return f" It has the {_superlative(problem.goals[0])} of {say.counted(record['choices'], 'choice')}."


def _superlative(goal: Goal) -> str:
    return f"{'largest' if goal.maximise else 'smallest'} {_name(goal.column)}"


def _name(column: str) -> str:
    return say.column(column).removeprefix("max ").removeprefix("min ").removeprefix("peak ")


def _why(problem: Problem, record: Row) -> Iterator[str]:
    """What binds at both ends, the worst in between, and ranges at whose ends the best is."""
    best = record["best"]
    yield phrases.end_words(problem, best, "from")
    yield f"{phrases.end_words(problem, best, 'to')}{drift_in_words(record['drift'])}"
    worst = [
        f"{word} {say.quantity(name, best[name])}" for name, word in _WORST.items() if best[name]
    ]
    yield f"at {_set(best)} the worst is {say.listed(worst)}"
    yield from _edges(problem, best)


def _proved(problem: Problem, row: Row) -> str:
    known = (
        f"{say.window(*ends_of(row))}, {say.proved(row['between_samples'])}"
        if row["feasible"]
        else "no window"
    )
    return f"{row_words(problem.choices, row) or 'the design'}: {known}"


def _edges(problem: Problem, best: Row) -> Iterator[str]:
    """Where the best is at the end of a range that was asked for."""
    for axis in (axis for axis in problem.choices.axes if axis.is_range):
        value = float(best[axis.column])
        for edge, word in ((axis.values.min(), "lower"), (axis.values.max(), "upper")):
            if abs(value - edge) <= 1e-9 * abs(edge):
                symbol = keys()[axis.key].number.quantity.symbol
                yield f"{symbol} is at its {word} end, {parameter(axis.key, value)}: widen the range"


def _moves(moves: list[Row]) -> Iterator[str]:
    """What moves the ends of the window most."""
    for end, word in (("from", "lower"), ("to", "upper")):
        of_end = [each for each in moves if each["end"] == end and each["per_percent"]][
            :_MOST_MOVES
        ]
        if of_end:
            yield f"{word} end: {', '.join(map(_move, of_end))}"
    if any(not each["steady"] for each in moves):
        yield "* within 1 % another limit or state takes over"


def _move(each: Row) -> str:
    key = each["key"].removeprefix("limits.")
    name = keys()[each["key"]].number.quantity.symbol if each["key"] in keys() else say.column(key)
    return f"{name} {each['per_percent']:+.2g} N{'' if each['steady'] else '*'}"


# --- Other choices ---------------------------------------------------------------------------------------------------


def _alternatives(problem: Problem, record: Row) -> Iterator[say.Block]:
    """The best by each goal, or the front, as a small table."""
    goals, front = problem.goals, record["front"]
    by_goal = {goals[0].column: record["best"]} if record["goals"] else record["best_by"]
    rows = [(_superlative(goal), by_goal[goal.column]) for goal in goals if goal.column in by_goal]
    head = "Best by"
    if front:
        head = f"The front ({say.counted(len(front), 'choice')}; no other is better in every goal)"
        rows = [("", row) for row in front[:: max(1, len(front) // _MOST_ALTERNATIVES)]]
    elif record["choices"] + sum(bool(row["refined"]) for _, row in rows) < 2:
        return
    some = problem.enough < 1.0
    lines = [["", "", "window N", "±%", "N", *["served"] * some, *COSTS.values()]]
    for name, row in rows:
        low, high = ends_of(row)
        lines.append(
            [
                name,
                ("~" if row["refined"] else "") + row_words(problem.choices, row),
                f"{say.number(low, 3)} {'on' if np.isinf(high) else f'to {say.number(high, 3)}'}",
                _tolerance(row),
                say.number(row["pretension"], 3),
                *[say.percent(row["served_at"])] * some,
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


# --- There is none ---------------------------------------------------------------------------------------------------


def _no_window(problem: Problem, record: Row) -> Iterator[say.Block]:
    choices, (noun, where) = record["choices"], say.reading(problem.study.setting.read)
    which = "" if choices == 1 else f", whichever of {choices:,} choices is taken"
    whom = (
        _all_of(problem)
        if problem.enough >= 1.0
        else f"{say.percent(problem.enough)} of {_everyone(problem)}"
    )
    at = f"No {noun}{where} suits"
    if problem.given is not None:
        at = f"A {noun} of {say.number(problem.given)} N{where} does not suit"
    yield say.sentence(f"{at} {whom}{which}.")
    yield from _list(
        "Why", (text for each in record["conflicts"] for text in _conflict(problem, record, each))
    )
    yield from _list(
        "What it would take, all else equal", relaxations_in_words(problem, record["would_take"])
    )
    if record["fixes"]:
        yield from fixes_table(record["fixes"])


def _in_choices(problem: Problem, conflict: Row) -> str:
    """In how many choices two limits exclude each other, and how."""
    choices, limits = say.counted(conflict["choices"], "choice"), conflict["limits"]
    if (
        problem.given is not None
        and conflict["nearest"]["pretension_from"] is not None
        and len(limits) == 1
    ):
        return f"in {choices} {say.number(problem.given)} N does not do: {phrases.broken(problem, limits[0])}"
    return f"in {choices} {say.conflict(limits, problem.study.limits)}"


def _conflict(problem: Problem, record: Row, conflict: Row) -> Iterator[str]:
    """What leaves some choices without a window, and what relaxing a limit would take."""
    row = conflict["nearest"]
    low, high = ends_of(row)
    if record["choices"] > 1:
        yield f"{_in_choices(problem, conflict)}; nearest to a window: {row_words(problem.choices, row)}"
    if low is None:
        yield f"at any pretension {phrases.broken(problem, row['from_by'])}{phrases.where(problem, row, 'from')}"
    elif problem.given is not None and low <= high:
        end = "from" if problem.given < low else "to"
        yield f"{phrases.end_words(problem, row, end)}; {phrases.margins(problem, row)}"
    else:
        yield f"{phrases.end_words(problem, row, 'from')},"
        yield f"{phrases.end_words(problem, row, 'to')}: {say.number(conflict['gap'], 3)} N apart"
        if row["served"] > 0.0 and problem.enough >= 1.0 and len(problem.conditions) > 1:
            served = f"{say.percent(row['served'])} of the {problem.counted}"
            yield f"one pretension, {say.number(row['pretension'], 3)} N, suits {served}"
