"""What the texts of an answer share: choices, conditions, ends of windows and tables of 80 columns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.problem import Problem
from tendon_cli.space.axis import PERSON_AXIS
from tendon_cli.space.space import Space
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID

Row = Mapping[str, Any]
"""A row of `choices.parquet` as the record of an answer has it."""


def parameter(key: str, value: float) -> str:
    """A number of a study with its symbol, by its key."""
    return say.parameter(keys()[key].number.quantity, value, say.side_of(key))


def row_words(product: Space, row: Row) -> str:
    """A choice or a condition: what it has of each axis; empty if there is none."""
    values = ((axis, row[axis.column]) for axis in product.axes)
    return ", ".join(
        value if axis.names else parameter(axis.key, math.inf if value == RIGID else value) for axis, value in values
    )


def condition_words(conditions: Space, condition: int, *, but_first: bool = False) -> str:
    """A condition by its row of conditions.parquet; `but_first` leaves out the person or draw that it is of."""
    columns = conditions.columns(np.array([condition]))
    words = [
        factor.names[int(columns[factor.column][0])]
        if factor.names
        else parameter(factor.key, columns[factor.column][0])
        for factor in conditions.axes[int(but_first) :]
    ]
    return ", ".join(words)


def everyone(counts: Mapping[str, int], count: int, kind: str) -> str:
    """What a share is of: "1,000 persons", "this person's 256 draws", "192 pairs of 3 persons and 64 draws"."""
    persons, draws = (counts.get(key, 0) for key in ("person", "draw"))
    if persons == 1 and draws > 1:
        return f"this person's {say.counted(draws, 'draw')}"
    if persons > 1 and draws > 1 and kind == "pairs":
        return f"{count:,} pairs of {say.counted(persons, 'person')} and {say.counted(draws, 'draw')}"
    return f"this {kind[:-1]}" if count == 1 else say.counted(count, kind[:-1])


def high_of(row: Row) -> float:
    """The upper end of a row's window, N; infinite if there is none."""
    return np.inf if row["pretension_to"] is None else float(row["pretension_to"])


def tolerance(row: Row) -> str:
    """The tolerance in percent; what is hardly any is none."""
    return say.number(100.0 * row["tolerance"], 2) if row["tolerance"] > 1e-4 else "0"


def end_words(problem: Problem, row: Row, end: str, word: str) -> str:
    """One end of a window, with what binds there."""
    limit, value = row[f"{end}_by"], row[f"pretension_{end}"]
    if limit is None:
        return "no lower limit: taut without pretension" if end == "from" else "no upper limit"
    broken = say.limit_words(limit, problem.study.limits).broken
    return f"{word} {say.number(value)} N {broken}{where_words(problem, row, end)}"


def where_words(problem: Problem, row: Row, end: str) -> str:
    """The condition and the state that bind, in brackets."""
    words = [condition_words(problem.conditions, row[f"{end}_condition"])]
    if row[f"{end}_direction"] is not None:
        words += [row[f"{end}_direction"], say.quantity("elbow_angle", row[f"{end}_elbow_angle"])]
    inside = ", ".join(word for word in words if word)
    return f" ({inside})" if inside else ""


def aligned(lines: list[tuple[str, ...]]) -> Iterator[str]:
    """Lines of cells as columns of 80 signs at most; what does not fit is in the tables."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    while sum(widths) + 2 * len(widths) > say.WIDTH and len(widths) > 4:
        widths.pop()
    for line in lines:
        cells = [cell.ljust(width) for cell, width in zip(line, widths, strict=False) if width]
        yield f"  {'  '.join(cells)}".rstrip()[: say.WIDTH]


def margins(problem: Problem, row: Row) -> str:
    """By what a given pretension lies within, or misses, the window of a choice."""
    low, high, at = row["pretension_from"], high_of(row), problem.given
    if at is None or low is None or not low <= high:
        return "there is no window"
    window = say.window(low, high)
    if at < low:
        return f"it is {say.number(low - at, 3)} N less than the window, {window}"
    if at > high:
        return f"it is {say.number(at - high, 3)} N more than the window, {window}"
    upper = "" if np.isinf(high) else f" and {say.number(high - at, 3)} N below the upper end"
    return f"that is {say.number(at - low, 3)} N above the lower end{upper} of the window, {window}"


def drift_words(record: Row) -> str:
    """How far the elbow goes beyond the upper end of its window, if it is stability that ends it."""
    drift = record["drift"]
    if drift is None:
        return ""
    start, end = (say.quantity("elbow_angle", drift[name]) for name in ("start", "end"))
    if start == end:
        return ": at 10 % more it still stays"
    far = f"drifts from {start} to {end}" if drift["balanced"] else f"goes on from {start} beyond {end}"
    return f": at 10 % more it {far}, driven by at most {say.quantity('elbow_torque', drift['torque'], 2)}"


def posture_words(setting: Row) -> str:
    """The posture in which a pretension is set."""
    if setting["angle"] == setting["upper_arm_angle"] == 0.0:
        limb = "arm hanging straight"
    else:
        limb = f"joint at {say.quantity('elbow_angle', setting['angle'])}"
        tilted = say.quantity("upper_arm_angle", setting["upper_arm_angle"])
        limb += "" if setting["upper_arm_angle"] == 0.0 else f", upper arm at {tilted}"
    hand = "hand empty" if setting["load"] == 0.0 else f"{say.quantity('load_mass', setting['load'])} in the hand"
    return f"{limb}, {hand}, after {setting['after']}"


def bench_lines(problem: Problem, record: Row, row: Row) -> Iterator[str]:
    """What to set on the bench, and what speaks against building or wearing the suit."""
    whose = " on the mean man" if PERSON_AXIS in (axis.key for axis in problem.conditions.axes) else ""
    yield f"\nTo set it{whose}: {posture_words(record['setting'])}"
    names = ([f"set_{side}_tension{end}" for side in ("flexor", "extensor")] for end in ("", "_motor"))
    joint, motor = ([say.quantity(name, row[name], 4) for name in pair] for pair in names)
    yield from say.filled(f"{joint[0]} in the flexor and {joint[1]} in the extensor at the joint", "  ")
    yield from say.filled(f"{motor[0]} and {motor[1]} at the motor", "  ")
    adds = f"1 mm taken from both tendons adds {say.number(1e-3 * record['setting']['newtons_per_metre'], 2)} N"
    length = row["tolerance_length"]
    window = "" if length is None else f", so the window is ± {say.quantity('tolerance_length', length, 2)}"
    yield from say.filled(f"{adds}{window}", "  ")
    if record["remarks"]:
        yield "\nBefore you build it"
    for remark in record["remarks"]:
        yield from say.filled(f"{remark['text']} ({remark['source']})", "  ")


# --- Conflicts and fixes ----------------------------------------------------------------------------------------------


def in_choices(problem: Problem, conflict: Row) -> str:
    """In how many choices two limits exclude each other, and how."""
    choices, nearest = say.counted(conflict["choices"], "choice"), conflict["nearest"]
    if problem.given is not None and nearest["pretension_from"] is not None and len(conflict["limits"]) == 1:
        broken = say.limit_words(conflict["limits"][0], problem.study.limits).broken
        return f"in {choices} {say.number(problem.given)} N does not do: {broken}"
    return f"in {choices} {say.conflict(conflict['limits'], problem.study.limits)}"


def conflict_lines(problem: Problem, record: Row, conflict: Row) -> Iterator[str]:
    """What leaves some choices without a window, and what relaxing a limit would take."""
    row = conflict["nearest"]
    if record["choices"] > 1:
        nearest = row_words(problem.choices, row)
        yield from say.filled(f"{in_choices(problem, conflict)}; nearest to a window: {nearest}", "  ")
    if row["pretension_from"] is None:
        broken = say.limit_words(row["from_by"], problem.study.limits).broken
        yield from say.filled(f"at any pretension {broken}{where_words(problem, row, 'from')}", "  ")
    elif problem.given is not None and row["pretension_from"] <= high_of(row):
        end, word = ("from", "below") if problem.given < row["pretension_from"] else ("to", "above")
        yield from say.filled(f"{end_words(problem, row, end, word)}; {margins(problem, row)}", "  ")
    else:
        yield from say.filled(f"{end_words(problem, row, 'from', 'below')},", "  ")
        gap = say.number(conflict["gap"], 3)
        yield from say.filled(f"{end_words(problem, row, 'to', 'above')}: {gap} N apart", "  ")
        if row["served"] > 0.0 and problem.enough >= 1.0 and len(problem.conditions) > 1:
            served = f"{say.percent(row['served'])} of the {problem.counted}"
            yield from say.filled(f"one pretension, {say.number(row['pretension'], 3)} N, suits {served}", "  ")
    for limit, value in conflict["relaxed"].items():
        toward = -np.inf if limit.startswith("min_") else np.inf
        words = f"relaxing {limit} does not help"
        if value is not None:
            words = f"{limit} = {say.quantity(limit, value, toward=toward)} would open a window"
        yield from say.filled(words, "  ")


def fix_lines(fixes: list[Row]) -> Iterator[str]:
    """What each parameter alone would have to become, as a table."""
    names = ("max_tension", "max_spring_extension", "peak_motor_torque")
    lines: list[tuple[str, ...]] = [("", "N", "tension", "spring", "torque")]
    for fix in (fix for fix in fixes if fix["after"] is not None):
        before = parameter(fix["parameter"], fix["before"])
        worst = ("-" if fix[name] is None else say.quantity(name, fix[name]) for name in names)
        lines.append((f"{before} to {fix['printed']}", fix["printed_pretension"], *worst))
    if len(lines) > 1:
        yield from aligned(lines)
    idle = [keys()[fix["parameter"]].number.quantity.symbol for fix in fixes if fix["after"] is None]
    if idle:
        yield from say.filled(f"no plausible value of these helps: {', '.join(idle)}", "  ")
