"""An answer as text of 80 columns, made of its record: the answer in one sentence, then why, then alternatives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from tendon_cli import say
from tendon_cli.answers.answer import goals_or_usual
from tendon_cli.answers.front import Goal
from tendon_cli.answers.population_text import population_lines
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.words import (
    Row,
    aligned,
    bench_lines,
    conflict_lines,
    drift_words,
    end_words,
    everyone,
    fix_lines,
    high_of,
    in_choices,
    margins,
    parameter,
    row_words,
    tolerance,
)  # fmt: skip
from tendon_cli.space.axis import PRETENSION, split_side
from tendon_cli.studies.study import keys

_MOST_ALTERNATIVES = 8
_MOST_MOVES = 5
_EDGE = 1e-9


def text_of(problem: Problem, record: Row) -> str:
    """The whole answer, and what it is to persons or draws."""
    best = record["best"]
    lines = [*(_no_window(problem, record) if best is None else _answer(problem, record, best))]
    if record["population"] is not None:
        lines += [
            line for text, indent in population_lines(problem, record) for line in say.filled(text, indent) or [""]
        ]
    return "\n".join([*lines, *_paragraphs("Note: ", record["notes"])])


def _paragraphs(start: str, texts: Iterable[str]) -> list[str]:
    return [line for text in texts for line in say.filled(f"{start}{text}")]


# --- There is a window -----------------------------------------------------------------------------------------------


def _answer(problem: Problem, record: Row, best: Row) -> Iterator[str]:
    yield from say.filled(_first_sentence(problem, record, best))
    yield "\nWhy"
    yield from say.filled(end_words(problem, best, "from", "below"), "  ")
    yield from say.filled(end_words(problem, best, "to", "above") + drift_words(record), "  ")
    yield from say.filled(
        f"at {say.within(best['pretension'], best['pretension_from'], high_of(best))} N the worst is {_worst(best)}",
        "  ",
    )
    yield from _study_pretension(problem, record, best)
    yield from bench_lines(problem, record, best)
    yield from _edges(problem, best)
    yield from _moves(record)
    yield from _alternatives(problem, record)
    yield from _counts(problem, record)


def _first_sentence(problem: Problem, record: Row, best: Row) -> str:
    """The pretension, whom it serves, and between which ends that holds."""
    what = row_words(problem.choices, best)
    start = f"{what}: a pretension" if what else "A pretension"
    low, high = best["pretension_from"], high_of(best)
    serves = f"{start} of {say.within(best['pretension'], best['pretension_from'], high_of(best))} N"
    either_way = f", {tolerance(best)} % either way" if np.isfinite(high) else ""
    if problem.given is not None:
        share = f"{say.percent(best['served_at'])} of {_everyone(problem)}"
        whom = share if best["served_at"] < 1.0 else _all_of(problem)
        return f"{start} of {say.number(problem.given)} N suits {whom}; {margins(problem, best)}."
    if problem.enough >= 1.0:
        span = f"anything {_span(low, high)} does{either_way}"
        return f"{serves} suits {_all_of(problem)}; {span}.{_why_first(problem, record)}"
    share = f"{say.percent(best['served_at'])} of {_everyone(problem)}" if best["served_at"] < 1.0 else _all_of(problem)
    span = f"at least {say.percent(problem.enough)} are served {_span(low, high)}{either_way}"
    if (ends := record["window_for_all"]) is not None:
        everyone = np.inf if ends[1] is None else ends[1]
        span += ", all of them " + ("there" if (ends[0], everyone) == (low, high) else _span(ends[0], everyone))
    return f"{serves} serves {share}; {span}.{_why_first(problem, record)}"


def _span(low: float, high: float) -> str:
    return f"from {say.number(low)}" + (f" to {say.number(high)} N" if np.isfinite(high) else " N on")


def _all_of(problem: Problem) -> str:
    """What a pretension must suit."""
    whom = _everyone(problem)
    if problem.counted == "conditions" and len(problem.weighting) == 1:
        return "the design"
    if whom.startswith("this"):
        return f"all of {whom}" if len(problem.weighting) > 1 else whom
    return f"all {whom}"


def _everyone(problem: Problem) -> str:
    return everyone(problem.counts, len(problem.weighting), problem.counted)


def _why_first(problem: Problem, record: Row) -> str:
    """Why this choice is named first."""
    if record["choices"] == 1:
        return ""
    if record["given_up"] is not None:
        share = say.percent(record["given_up"])
        return f" It is the best compromise on the front: it gives up at most {share} of the range of any goal."
    return f" It has the {_superlative(goals_or_usual(problem)[0])} of {say.counted(record['choices'], 'choice')}."


def _superlative(goal: Goal) -> str:
    return f"{'largest' if goal.maximise else 'smallest'} {_named(goal.column)}"


def _named(column: str) -> str:
    return say.column(column).removeprefix("max ").removeprefix("min ").removeprefix("peak ")


def _worst(row: Row) -> str:
    names = {
        "max_tension": "a tension of", "max_spring_extension": "a spring extension of",
        "peak_motor_torque": "a motor torque of", "min_elbow_stiffness": "an elbow stiffness of",
        "max_contact_pressure": "a strap pressure of",
    }  # fmt: skip
    return say.listed([f"{word} {say.quantity(name, row[name])}" for name, word in names.items() if row[name]])


def _study_pretension(problem: Problem, record: Row, best: Row) -> Iterator[str]:
    """Whether the pretension of the study would do, if it asks of one design and has one."""
    given = {key: values for key, values in problem.study.numbers.items() if split_side(key)[0] == PRETENSION}
    if record["choices"] > 1 or list(given) != [PRETENSION] or given[PRETENSION].is_axis:
        return
    value = given[PRETENSION].single
    verdict = "suits, too" if best["pretension_from"] <= value <= high_of(best) else "is too little"
    verdict = "is too much" if value > high_of(best) else verdict
    yield from say.filled(f"the study's pretension of {say.number(value)} N {verdict}", "  ")


def _edges(problem: Problem, best: Row) -> Iterator[str]:
    """Where the best is at the end of a range that was asked for."""
    for factor in problem.choices.axes:
        if not factor.is_range:
            continue
        value, span = float(best[factor.column]), factor.values
        for edge, word in ((span.min(), "lower"), (span.max(), "upper")):
            if abs(value - edge) <= _EDGE * abs(edge):
                symbol = keys()[factor.key].number.quantity.symbol
                shown = parameter(factor.key, value)
                yield from say.filled(f"{symbol} is at its {word} end, {shown}: widen the range", "  ")


def _moves(record: Row) -> Iterator[str]:
    """What moves the ends of the window most."""
    moves = record["sensitivities"]
    if not moves:
        return
    yield "\nWhat moves the window most, per 1 %"
    for end, word in (("from", "lower"), ("to", "upper")):
        of_end = [each for each in moves if each["end"] == end and each["per_percent"]][:_MOST_MOVES]
        if of_end:
            yield from say.filled(f"{word} end: {', '.join(map(_move, of_end))}", "  ")
    if any(not each["steady"] for each in moves):
        yield from say.filled("* within 1 % another limit or state takes over", "  ")


def _move(each: Row) -> str:
    key = each["key"].removeprefix("limits.")
    name = keys()[each["key"]].number.quantity.symbol if each["key"] in keys() else say.column(key)
    return f"{name} {each['per_percent']:+.2g} N{'' if each['steady'] else '*'}"


def _alternatives(problem: Problem, record: Row) -> Iterator[str]:
    """The best by each goal, or the front, as a small table."""
    goals, front = goals_or_usual(problem), record["front"]
    by_goal = {goals[0].column: record["best"]} if record["goals"] else record["best_by"]
    rows = [(_superlative(goal), by_goal[goal.column]) for goal in goals if goal.column in by_goal]
    if front:
        yield f"\nThe front ({say.counted(len(front), 'choice')}; no other is better in every goal)"
        rows = [("", row) for row in front[:: max(1, len(front) // _MOST_ALTERNATIVES)]]
    elif record["choices"] + sum(bool(row["refined"]) for _, row in rows) < 2:
        return
    else:
        yield "\nBest by"
    yield from _table(problem, rows)
    if record["gains"]:
        gains = [f"{_named(column)} by {say.percent(gain)}" for column, gain in record["gains"].items()]
        yield from say.filled(f"~ between the points of the grid; better than it in {', '.join(gains)}", "  ")


def _table(problem: Problem, rows: list[tuple[str, Row]]) -> Iterator[str]:
    some = problem.enough < 1.0
    lines: list[tuple[str, ...]] = [("", "", "window N", "±%", "N", *["served"] * some, "tension", "spring", "torque")]
    for name, row in rows:
        high = "on" if np.isinf(high_of(row)) else f"to {say.number(high_of(row), 3)}"
        worst = ("max_tension", "max_spring_extension", "peak_motor_torque")
        lines.append((
            name, ("~" if row["refined"] else "") + row_words(problem.choices, row),
            f"{say.number(row['pretension_from'], 3)} {high}", tolerance(row), say.number(row["pretension"], 3),
            *[say.percent(row["served_at"])] * some,
            *("-" if row[each] is None else say.quantity(each, row[each]) for each in worst),
        ))  # fmt: skip
    yield from aligned(lines)


def _counts(problem: Problem, record: Row) -> Iterator[str]:
    """How many choices have a window, and what leaves the others without one."""
    if record["choices"] > 1:
        yield ""
        have = "has" if record["feasible"] == 1 else "have"
        counts = f"{record['feasible']:,} of {say.counted(record['choices'], 'choice')}"
        yield from say.filled(f"{counts} {have} a window.")
    for each in record["conflicts"]:
        yield from say.filled(in_choices(problem, each), "  ")


# --- There is none ----------------------------------------------------------------------------------------------------


def _no_window(problem: Problem, record: Row) -> Iterator[str]:
    choices = record["choices"]
    which = "" if choices == 1 else f", whichever of {choices:,} choices is taken"
    whom = _all_of(problem) if problem.enough >= 1.0 else f"{say.percent(problem.enough)} of {_everyone(problem)}"
    if problem.given is None:
        yield from say.filled(f"No pretension suits {whom}{which}.")
    else:
        yield from say.filled(f"A pretension of {say.number(problem.given)} N does not suit {whom}{which}.")
    yield "\nWhy"
    for each in record["conflicts"]:
        yield from conflict_lines(problem, record, each)
    if record["fixes"]:
        yield "\nWhat would help, all else equal"
        yield from fix_lines(record["fixes"])
