"""An answer as text of 80 columns, made of its record: the answer in one sentence, then why, then alternatives."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tendon_cli import say
from tendon_cli.answers import words as shared
from tendon_cli.answers.answer import goals_or_usual
from tendon_cli.answers.bench import bench_lines, drift_words, reading_words
from tendon_cli.answers.front import Goal
from tendon_cli.answers.question import Problem
from tendon_cli.answers.relax import relaxation_lines
from tendon_cli.answers.words import Row, ends_of, everyone, parameter, row_words
from tendon_cli.space.axis import PRETENSION, split_side
from tendon_cli.studies.study import keys

_MOST_ALTERNATIVES = 8
_COSTS = ("max_tension", "max_spring_extension", "peak_motor_torque")
_COST_HEADS = ("tension", "spring", "torque")


def text_of(problem: Problem, record: Row) -> str:
    """The whole answer, and what it is to persons or draws."""
    paragraphs = [*(_no_window(problem, record) if record["best"] is None else _answer(problem, record))]
    if record["population"] is not None:
        paragraphs += shared.population_lines(problem, record["population"])
    paragraphs += (f"Note: {note}" for note in record["notes"])
    texts = (say.of_joint(text, problem.study) for text in paragraphs)
    filled = (say.filled(text.lstrip(), text[: -len(text.lstrip()) or None]) or [""] for text in texts)
    return "\n".join(line for lines in filled for line in lines)


# --- There is a window -----------------------------------------------------------------------------------------------


def _answer(problem: Problem, record: Row) -> Iterator[str]:
    best = record["best"]
    yield f"{_first_sentence(problem, record, best)} {_between_words(record['between_samples'])}"
    yield from ("", "Why", f"  {shared.end_words(problem, best, 'from')}")
    yield f"  {shared.end_words(problem, best, 'to')}{drift_words(record['drift'])}"
    yield f"  at {_set(best)} the worst is {_worst(best)}"
    yield from _study_pretension(problem, record, best)
    yield from bench_lines(problem, record, best)
    yield from _edges(problem, best)
    yield from shared.move_lines(record["sensitivities"])
    yield from _alternatives(problem, record)
    yield from ["", "Asked to be proved"] if record["proved"] else []
    for row in record["proved"]:
        words = f"{say.window(*ends_of(row))}, {row['between_samples']}" if row["feasible"] else "no window"
        yield f"  {row_words(problem.choices, row) or 'the design'}: {words}"
    yield from _counts(problem, record)


def _first_sentence(problem: Problem, record: Row, best: Row) -> str:
    """The pretension, whom it serves, and between which ends that holds."""
    what = row_words(problem.choices, best)
    noun, at = reading_words(problem)
    start, (low, high) = f"{what}: a {noun}" if what else f"A {noun}", ends_of(best)
    served = best["served_at"]
    whom = _all_of(problem) if served >= 1.0 else f"{say.percent(served)} of {_everyone(problem)}"
    if problem.given is not None:
        return f"{start} of {say.number(problem.given)} N{at} suits {whom}; {shared.margins(problem, best)}."
    either_way = f", {_tolerance(best)} % either way" if np.isfinite(high) else ""
    if problem.enough >= 1.0:
        words = f"suits {_all_of(problem)}; anything {_span(low, high)} does{either_way}"
    else:
        words = f"serves {whom}; at least {say.percent(problem.enough)} are served {_span(low, high)}{either_way}"
        if (ends := record["window_for_all"]) is not None:
            of_all = (ends[0], np.inf if ends[1] is None else ends[1])
            words += ", all of them " + ("there" if of_all == (low, high) else _span(*of_all))
    return f"{start} of {_set(best)}{at} {words}.{_why_first(problem, record)}"


def _between_words(known: Row) -> str:
    """What holds between the angles and loads that were taken."""
    if known["status"] == "proven":
        return f"Proved for {known['scope']}."
    if known["status"] == "open":
        return f"Not proved for {known['scope']}: {known['cells']:,} cells were not enough."
    off = (
        "" if known["estimate"] is None else f": an end may be off by {say.number(known['estimate'], 2)} N between them"
    )
    return f"Sampled for {known['scope']}{off}."


def _set(row: Row) -> str:
    return f"{say.within(row['pretension'], *ends_of(row))} N"


def _span(low: float, high: float) -> str:
    return f"from {say.number(low)}" + (f" to {say.number(high)} N" if np.isfinite(high) else " N on")


def _tolerance(row: Row) -> str:
    """The tolerance in percent; what is hardly any is none."""
    return say.number(100.0 * row["tolerance"], 2) if row["tolerance"] > 1e-4 else "0"


def _everyone(problem: Problem) -> str:
    return everyone(problem.counts, len(problem.weighting), problem.counted)


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
    return f" It has the {_superlative(goals_or_usual(problem)[0])} of {say.counted(record['choices'], 'choice')}."


def _superlative(goal: Goal) -> str:
    return f"{'largest' if goal.maximise else 'smallest'} {_name(goal.column)}"


def _name(column: str) -> str:
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
    value, (low, high) = given[PRETENSION].single, ends_of(best)
    verdict = "is too little" if value < low else "is too much" if value > high else "suits, too"
    yield f"  the study's pretension of {say.number(value)} N {verdict}"


def _edges(problem: Problem, best: Row) -> Iterator[str]:
    """Where the best is at the end of a range that was asked for."""
    for axis in (axis for axis in problem.choices.axes if axis.is_range):
        value = float(best[axis.column])
        for edge, word in ((axis.values.min(), "lower"), (axis.values.max(), "upper")):
            if abs(value - edge) <= 1e-9 * abs(edge):
                symbol = keys()[axis.key].number.quantity.symbol
                yield f"  {symbol} is at its {word} end, {parameter(axis.key, value)}: widen the range"


# --- Choices beside it -----------------------------------------------------------------------------------------------


def _alternatives(problem: Problem, record: Row) -> Iterator[str]:
    """The best by each goal, or the front, as a small table."""
    goals, front = goals_or_usual(problem), record["front"]
    by_goal = {goals[0].column: record["best"]} if record["goals"] else record["best_by"]
    rows = [(_superlative(goal), by_goal[goal.column]) for goal in goals if goal.column in by_goal]
    head = "Best by"
    if front:
        head = f"The front ({say.counted(len(front), 'choice')}; no other is better in every goal)"
        rows = [("", row) for row in front[:: max(1, len(front) // _MOST_ALTERNATIVES)]]
    elif record["choices"] + sum(bool(row["refined"]) for _, row in rows) < 2:
        return
    some = problem.enough < 1.0
    lines: list[tuple[str, ...]] = [("", "", "window N", "±%", "N", *["served"] * some, *_COST_HEADS)]
    for name, row in rows:
        low, high = ends_of(row)
        lines.append((
            name, ("~" if row["refined"] else "") + row_words(problem.choices, row),
            f"{say.number(low, 3)} {'on' if np.isinf(high) else f'to {say.number(high, 3)}'}",
            _tolerance(row), say.number(row["pretension"], 3), *[say.percent(row["served_at"])] * some, *_costs(row),
        ))  # fmt: skip
    yield from ("", head, *say.aligned(lines))
    if record["gains"]:
        gains = [f"{_name(column)} by {say.percent(gain)}" for column, gain in record["gains"].items()]
        yield f"  ~ between the points of the grid; better than it in {', '.join(gains)}"


def _costs(row: Row) -> list[str]:
    return ["-" if row[name] is None else say.quantity(name, row[name]) for name in _COSTS]


def _counts(problem: Problem, record: Row) -> Iterator[str]:
    """How many choices have a window, and what leaves the others without one."""
    if record["choices"] > 1:
        have = "has" if record["feasible"] == 1 else "have"
        yield from ("", f"{record['feasible']:,} of {say.counted(record['choices'], 'choice')} {have} a window.")
    yield from (f"  {_in_choices(problem, each)}" for each in record["conflicts"])


# --- There is none ----------------------------------------------------------------------------------------------------


def _no_window(problem: Problem, record: Row) -> Iterator[str]:
    choices = record["choices"]
    which = "" if choices == 1 else f", whichever of {choices:,} choices is taken"
    whom = _all_of(problem) if problem.enough >= 1.0 else f"{say.percent(problem.enough)} of {_everyone(problem)}"
    noun, where = reading_words(problem)
    at = f"No {noun}{where} suits"
    if problem.given is not None:
        at = f"A {noun} of {say.number(problem.given)} N{where} does not suit"
    yield from (f"{at} {whom}{which}.", "", "Why")
    for each in record["conflicts"]:
        yield from (f"  {text}" for text in _conflict(problem, record, each))
    yield from relaxation_lines(problem, record["would_take"])
    if record["fixes"]:
        yield from ("", "What would help, all else equal", *_fixes(record["fixes"]))


def _in_choices(problem: Problem, conflict: Row) -> str:
    """In how many choices two limits exclude each other, and how."""
    choices, nearest = say.counted(conflict["choices"], "choice"), conflict["nearest"]
    if problem.given is not None and nearest["pretension_from"] is not None and len(conflict["limits"]) == 1:
        return (
            f"in {choices} {say.number(problem.given)} N does not do: {shared.broken(problem, conflict['limits'][0])}"
        )
    return f"in {choices} {say.conflict(conflict['limits'], problem.study.limits)}"


def _conflict(problem: Problem, record: Row, conflict: Row) -> Iterator[str]:
    """What leaves some choices without a window, and what relaxing a limit would take."""
    row = conflict["nearest"]
    low, high = ends_of(row)
    if record["choices"] > 1:
        yield f"{_in_choices(problem, conflict)}; nearest to a window: {row_words(problem.choices, row)}"
    if low is None:
        yield f"at any pretension {shared.broken(problem, row['from_by'])}{shared.where_words(problem, row, 'from')}"
    elif problem.given is not None and low <= high:
        end = "from" if problem.given < low else "to"
        yield f"{shared.end_words(problem, row, end)}; {shared.margins(problem, row)}"
    else:
        yield f"{shared.end_words(problem, row, 'from')},"
        yield f"{shared.end_words(problem, row, 'to')}: {say.number(conflict['gap'], 3)} N apart"
        if row["served"] > 0.0 and problem.enough >= 1.0 and len(problem.conditions) > 1:
            served = f"{say.percent(row['served'])} of the {problem.counted}"
            yield f"one pretension, {say.number(row['pretension'], 3)} N, suits {served}"
    over_all = {f"limits.{limit}" for limit in conflict["relaxed"]} & {each["key"] for each in record["would_take"]}
    for limit, value in conflict["relaxed"].items() if not over_all else ():
        toward = -np.inf if limit.startswith("min_") else np.inf
        opens = value is not None and f"{limit} = {say.quantity(limit, value, toward=toward)} would open a window"
        yield opens or f"relaxing {limit} does not help"


def _fixes(fixes: list[Row]) -> Iterator[str]:
    """What each parameter alone would have to become, as a table."""
    lines: list[tuple[str, ...]] = [("", "N", *_COST_HEADS)]
    for fix in (fix for fix in fixes if fix["after"] is not None):
        before = parameter(fix["parameter"], fix["before"])
        lines.append((f"{before} to {fix['printed']}", fix["printed_pretension"], *_costs(fix)))
    yield from say.aligned(lines) if len(lines) > 1 else ()
    idle = [keys()[fix["parameter"]].number.quantity.symbol for fix in fixes if fix["after"] is None]
    if idle:
        yield f"  no plausible value of these helps: {', '.join(idle)}"
