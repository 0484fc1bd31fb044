"""An answer in blocks, made of its record: the answer in one sentence, then why, then alternatives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from tendon_cli import say
from tendon_cli.answers import words
from tendon_cli.answers.bench import FEW, SET
from tendon_cli.answers.front import Goal
from tendon_cli.answers.question import Problem
from tendon_cli.answers.words import Row, ends_of, parameter, row_words
from tendon_cli.quantities import QUANTITIES
from tendon_cli.space.axis import PERSON_AXIS, PRETENSION, split_side
from tendon_cli.space.space import Space
from tendon_cli.studies.study import keys

_MOST_ALTERNATIVES, _MOST_MOVES = 8, 5
_COSTS = {"max_tension": "tension", "max_spring_extension": "spring", "peak_motor_torque": "torque"}
_WORST = {
    "max_tension": "a tension of", "max_spring_extension": "a spring extension of",
    "peak_motor_torque": "a motor torque of", "min_elbow_stiffness": "an elbow stiffness of",
    "max_contact_pressure": "a strap pressure of",
}  # fmt: skip
_EASED = {
    "load.mass": "loads of at most {} instead of {}",
    "arm.upper_arm_angle": "an upper arm tilted by at most {} instead of {}",
    "arm.contact_width": "a strap of {} instead of {}",
    "anchor.stiffness": "tissue and cuffs of {} behind each anchor instead of {}",
}


def blocks_of(problem: Problem, record: Row) -> Iterator[say.Block]:
    """The whole answer, what it is to persons or draws, and notes."""
    yield from _no_window(problem, record) if record["best"] is None else _answer(problem, record)
    if record["population"] is not None:
        yield from words.population_blocks(problem, record["population"])
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
    yield from _list(f"To set it{_on_whom(problem)}: {_posture(problem, record['setting'])}", _to_set(problem, record))
    yield from _list("Before you build it", (f"{each['text']} ({each['source']})" for each in record["remarks"]))
    yield from _list("What moves the window most, per 1 %", _moves(record["sensitivities"]))
    yield from _alternatives(problem, record)
    yield from _list("Asked to be proved", (_proved(problem, row) for row in record["proved"]))
    if record["choices"] > 1:
        have = "has" if record["feasible"] == 1 else "have"
        yield say.sentence(f"{record['feasible']:,} of {say.counted(record['choices'], 'choice')} {have} a window.")
    yield from say.items(_in_choices(problem, each) for each in record["conflicts"])


def _first_sentence(problem: Problem, record: Row) -> str:
    """The pretension, whom it serves, and between which ends that holds."""
    best, (noun, at) = record["best"], say.reading(problem.study.setting.read)
    what = row_words(problem.choices, best)
    start, (low, high) = f"{what}: a {noun}" if what else f"A {noun}", ends_of(best)
    served = best["served_at"]
    whom = _all_of(problem) if served >= 1.0 else f"{say.percent(served)} of {_everyone(problem)}"
    if problem.given is not None:
        return f"{start} of {say.number(problem.given)} N{at} suits {whom}; {words.margins(problem, best)}."
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
    return f"from {say.number(low)}" + (f" to {say.number(high)} N" if np.isfinite(high) else " N on")


def _tolerance(row: Row) -> str:
    """The tolerance in percent; what is hardly any is none."""
    return say.number(100.0 * row["tolerance"], 2) if row["tolerance"] > 1e-4 else "0"


def _everyone(problem: Problem) -> str:
    return words.everyone(problem.counts, len(problem.weighting), problem.counted)


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
    """What binds at both ends and the worst in between; whether the study's pretension would do; ends of ranges."""
    best = record["best"]
    yield words.end_words(problem, best, "from")
    yield f"{words.end_words(problem, best, 'to')}{_drift(record['drift'])}"
    worst = [f"{word} {say.quantity(name, best[name])}" for name, word in _WORST.items() if best[name]]
    yield f"at {_set(best)} the worst is {say.listed(worst)}"
    given = {key: values for key, values in problem.study.numbers.items() if split_side(key)[0] == PRETENSION}
    if record["choices"] == 1 and list(given) == [PRETENSION] and not given[PRETENSION].is_axis:
        value, (low, high) = given[PRETENSION].single, ends_of(best)
        verdict = "is too little" if value < low else "is too much" if value > high else "suits, too"
        yield f"the study's pretension of {say.number(value)} N {verdict}"
    yield from _edges(problem, best)


def _drift(drift: Row | None) -> str:
    """How far the elbow goes beyond the upper end of its window, if it is stability that ends it."""
    if drift is None:
        return ""
    start, end = (say.quantity("elbow_angle", drift[name]) for name in ("start", "end"))
    if start == end:
        return ": at 10 % more it still stays"
    far = f"drifts from {start} to {end}" if drift["balanced"] else f"goes on from {start} beyond {end}"
    return f": at 10 % more it {far}, driven by at most {say.quantity('elbow_torque', drift['torque'], 2)}"


def _proved(problem: Problem, row: Row) -> str:
    known = f"{say.window(*ends_of(row))}, {row['between_samples']}" if row["feasible"] else "no window"
    return f"{row_words(problem.choices, row) or 'the design'}: {known}"


# --- On the bench ----------------------------------------------------------------------------------------------------


def _on_whom(problem: Problem) -> str:
    return " on the mean man" if PERSON_AXIS in problem.counts else ""


def _posture(problem: Problem, setting: Row) -> str:
    """The posture in which a pretension is set."""
    joint, (angle, tilt, load) = say.joint_word(problem.study), (setting[name] for name in _POSTURE)
    if joint != "elbow":
        limb, hand = f"{joint} at {say.quantity('elbow_angle', angle)}", "without a load"
    else:
        tilted = f", upper arm at {say.quantity('upper_arm_angle', tilt)}" if tilt else ""
        limb = f"elbow at {say.quantity('elbow_angle', angle)}{tilted}" if angle or tilt else "arm hanging straight"
        hand = "hand empty"
    held = hand if load == 0.0 else f"a load of {say.quantity('load_mass', load)}"
    return f"{limb}, {held}, after {setting['after']}"


_POSTURE = ("angle", "upper_arm_angle", "load")


def _to_set(problem: Problem, record: Row) -> Iterator[str]:
    """What gauges show at the joint and at the motor, and what a length of the tendons does."""
    row = record["best"]
    joint, joint_extensor, motor, motor_extensor = (say.quantity(name, row[name], 4) for name in SET)
    yield f"{joint} in the flexor and {joint_extensor} in the extensor at the joint"
    yield f"{motor} and {motor_extensor} at the motor"
    if _on_whom(problem):
        flexor, extensor = (_spread(name, record["population"]["set"][name]) for name in SET[:2])
        persons = problem.counts[PERSON_AXIS]
        whom = "nine persons of ten" if persons >= FEW else "these persons" if persons > 1 else "this person"
        yield f"on {whom} {flexor} in the flexor and {extensor} in the extensor at the joint"
    length, per_mm = row["tolerance_length"], say.number(1e-3 * record["setting"]["newtons_per_metre"], 2)
    window = "" if length is None else f", so the window is ± {say.quantity('tolerance_length', length, 2)}"
    yield f"1 mm taken from both tendons adds {per_mm} N{window}"


def _spread(name: str, ends: Sequence[float]) -> str:
    low, high = (say.quantity(name, end, 3) for end in ends)
    return low if low == high else f"{low.partition(' ')[0]} to {high}"


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
        of_end = [each for each in moves if each["end"] == end and each["per_percent"]][:_MOST_MOVES]
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
    lines = [["", "", "window N", "±%", "N", *["served"] * some, *_COSTS.values()]]
    for name, row in rows:
        low, high = ends_of(row)
        lines.append([
            name, ("~" if row["refined"] else "") + row_words(problem.choices, row),
            f"{say.number(low, 3)} {'on' if np.isinf(high) else f'to {say.number(high, 3)}'}",
            _tolerance(row), say.number(row["pretension"], 3), *[say.percent(row["served_at"])] * some, *_costs(row),
        ])  # fmt: skip
    yield say.heading(head)
    yield say.table(lines)
    if record["gains"]:
        gains = [f"{_name(column)} by {say.percent(gain)}" for column, gain in record["gains"].items()]
        yield from say.items([f"~ between the points of the grid; better than it in {', '.join(gains)}"])


def _costs(row: Row) -> list[str]:
    return ["-" if row[name] is None else say.quantity(name, row[name]) for name in _COSTS]


# --- There is none ---------------------------------------------------------------------------------------------------


def _no_window(problem: Problem, record: Row) -> Iterator[say.Block]:
    choices, (noun, where) = record["choices"], say.reading(problem.study.setting.read)
    which = "" if choices == 1 else f", whichever of {choices:,} choices is taken"
    whom = _all_of(problem) if problem.enough >= 1.0 else f"{say.percent(problem.enough)} of {_everyone(problem)}"
    at = f"No {noun}{where} suits"
    if problem.given is not None:
        at = f"A {noun} of {say.number(problem.given)} N{where} does not suit"
    yield say.sentence(f"{at} {whom}{which}.")
    yield from _list("Why", (text for each in record["conflicts"] for text in _conflict(problem, record, each)))
    yield from _list("What it would take, all else equal", _relaxations(problem, record["would_take"]))
    if record["fixes"]:
        yield from _fixes(record["fixes"])


def _in_choices(problem: Problem, conflict: Row) -> str:
    """In how many choices two limits exclude each other, and how."""
    choices, limits = say.counted(conflict["choices"], "choice"), conflict["limits"]
    if problem.given is not None and conflict["nearest"]["pretension_from"] is not None and len(limits) == 1:
        return f"in {choices} {say.number(problem.given)} N does not do: {words.broken(problem, limits[0])}"
    return f"in {choices} {say.conflict(limits, problem.study.limits)}"


def _conflict(problem: Problem, record: Row, conflict: Row) -> Iterator[str]:
    """What leaves some choices without a window, and what relaxing a limit would take."""
    row = conflict["nearest"]
    low, high = ends_of(row)
    if record["choices"] > 1:
        yield f"{_in_choices(problem, conflict)}; nearest to a window: {row_words(problem.choices, row)}"
    if low is None:
        yield f"at any pretension {words.broken(problem, row['from_by'])}{words.where(problem, row, 'from')}"
    elif problem.given is not None and low <= high:
        end = "from" if problem.given < low else "to"
        yield f"{words.end_words(problem, row, end)}; {words.margins(problem, row)}"
    else:
        yield f"{words.end_words(problem, row, 'from')},"
        yield f"{words.end_words(problem, row, 'to')}: {say.number(conflict['gap'], 3)} N apart"
        if row["served"] > 0.0 and problem.enough >= 1.0 and len(problem.conditions) > 1:
            served = f"{say.percent(row['served'])} of the {problem.counted}"
            yield f"one pretension, {say.number(row['pretension'], 3)} N, suits {served}"
    over_all = {f"limits.{limit}" for limit in conflict["relaxed"]} & {each["key"] for each in record["would_take"]}
    for limit, value in conflict["relaxed"].items() if not over_all else ():
        toward = -np.inf if limit.startswith("min_") else np.inf
        opens = value is not None and f"{limit} = {say.quantity(limit, value, toward=toward)} would open a window"
        yield opens or f"relaxing {limit} does not help"


def _relaxations(problem: Problem, relaxations: list[Row]) -> Iterator[str]:
    """What each thing that is asked for would have to become."""
    idle = []
    for each in relaxations:
        key, limit = each["key"], each["key"].removeprefix("limits.")
        of = QUANTITIES.get(limit, QUANTITIES["pretension"]) if key != limit else keys()[key].number.quantity
        text = _EASED.get(key, f"{limit} = {{}} instead of {{}}")
        if each["after"] is None:
            idle.append(text.partition(" instead of")[0].format(say.quantity(of, each["farthest"])))
            continue
        share = "all" if each["served"] >= 1.0 else f"{say.percent(each['served'])} of the"
        others = Space(tuple(axis for axis in problem.choices.axes if axis.key != key))
        what = ", ".join(filter(None, (row_words(others, each["values"]), f"{say.number(each['pretension'])} N")))
        changed = text.format(each["printed"], say.quantity(of, each["before"]))
        yield f"{changed}: {what} serves {share} {problem.counted}"
    if idle:
        yield f"not enough alone: {', '.join(idle)}"


def _fixes(fixes: list[Row]) -> Iterator[say.Block]:
    """What each parameter alone would have to become, as a table."""
    lines = [["", "N", *_COSTS.values()]]
    for fix in (fix for fix in fixes if fix["after"] is not None):
        before = parameter(fix["parameter"], fix["before"])
        lines.append([f"{before} to {fix['printed']}", fix["printed_pretension"], *_costs(fix)])
    yield say.heading("What would help, all else equal")
    yield from [say.table(lines)] if len(lines) > 1 else ()
    idle = [keys()[fix["parameter"]].number.quantity.symbol for fix in fixes if fix["after"] is None]
    yield from say.items([f"no plausible value of these helps: {', '.join(idle)}"] if idle else [])
