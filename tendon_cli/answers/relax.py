"""What it would take that some choice has a window: the least change of one thing that is asked for, all else equal.

Eased more, each thing leaves more choices with a window, so that bisection over these finds the least change; of
postures and anchors that is not proved.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.answers.fixes import edge
from tendon_cli.answers.phrases import Row, row_words
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import Solutions, solve
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.space.axis import Numbers, Rows
from tendon_cli.space.space import Space
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID
from tendon_cli.units import parse_measure

_MOST = (
    2**28
)  # states of all choices under all conditions; of more choices some are tried, evenly taken
_ROUNDS = 12
_FARTHEST = 10.0  # times a limit
_SOFTER = 40.0  # by how much less stiffness than asked for is tried, N m/rad
_WIDTH, _WIDEST = "arm.contact_width", 0.2  # of a strap, m
_ANCHOR, _FIRMEST = "anchor.stiffness", 1e5  # of tissue and cuff, N/m


class Ask(NamedTuple):
    """Something that is asked for, and could be asked less of."""

    key: str
    before: float  # SI; of several values the largest magnitude
    farthest: float
    rows: Rows  # the choices for which it counts

    @property
    def quantity(self) -> Quantity:
        """What it is."""
        return _quantity_of(self.key)

    def eased(
        self, problem: Problem, value: float, numbers: Numbers, count: int
    ) -> tuple[Problem, Numbers]:
        """The question for `count` choices with a value in its place; those of a condition drawn together toward 0."""
        if self.key.startswith("limits."):
            return problem.bounded(self.key.removeprefix("limits."), value), numbers
        given = problem.condition_numbers.get(self.key)
        if given is None:
            return problem, {**numbers, self.key: np.full(count, value)}
        return problem.saying({self.key: given * (value / np.abs(given).max())}), numbers


def _quantity_of(key: str) -> Quantity:
    limit = key.removeprefix("limits.")
    return (
        keys()[key].number.quantity
        if limit == key
        else QUANTITIES.get(limit, QUANTITIES["pretension"])
    )


def relaxations(problem: Problem, limits: set[str]) -> list[dict[str, Any]]:
    """For each thing asked for the least change that gives some choice a window, as recorded; SI.

    `limits` are those that leave choices without one. `after` is null if even `farthest` gives none; `served` is the
    largest share then, else that of the choice named at `pretension`, N.
    """
    count = len(problem.choices)
    most = max(1, _MOST // (len(problem.conditions) * problem.states_per_design))
    rows = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))
    return [_least(problem, ask) for ask in _asks(problem, limits, rows)]


def _asks(problem: Problem, limits: set[str], rows: Rows) -> Iterator[Ask]:
    for name in sorted(limits & set(problem.bounds)):
        value, is_stiffness = float(problem.bounds[name]), name == "min_elbow_stiffness"
        farthest = (
            value - _SOFTER
            if is_stiffness
            else 0.0
            if LIMITS[name].from_below
            else _FARTHEST * value
        )
        if (value > 0.0 or is_stiffness) and np.isfinite(value):
            yield Ask(f"limits.{name}", value, farthest, rows)
    single = problem.choices.single
    widths = np.asarray(
        problem.choices.numbers(rows).get(_WIDTH, np.full(len(rows), single.get(_WIDTH, np.nan)))
    )
    of_choices = [Ask(_ANCHOR, float(single.get(_ANCHOR, np.inf)), _FIRMEST, rows)]
    if "max_contact_pressure" in limits:
        of_choices.insert(
            0, Ask(_WIDTH, float(widths.max()), _WIDEST, rows[widths == widths.max()])
        )
    for ask in of_choices:
        if 0.0 < ask.before < ask.farthest and ask.key not in problem.condition_numbers:
            yield ask
    for key in ("load.mass", "arm.upper_arm_angle"):
        values = problem.condition_numbers.get(key)
        if values is not None and np.ptp(values) > 0.0:
            yield Ask(key, float(np.abs(values).max()), 0.0, rows)


def _least(problem: Problem, ask: Ask) -> dict[str, Any]:
    def tried(value: float, rows: Rows) -> Solutions:
        asked, numbers = ask.eased(problem, value, problem.choices.numbers(rows), len(rows))
        solved = solve(asked, numbers, len(rows), with_worst=False)
        return Solutions(solved.results, rows, problem.choices.columns(rows))

    record: dict[str, Any] = {
        "key": ask.key,
        "before": ask.before,
        "farthest": ask.farthest,
        "after": None,
    }
    solved = tried(ask.farthest, ask.rows)
    if not solved["feasible"].any():
        return record | {"printed": "", "choice": None, "served": float(solved["served"].max())}
    rows = solved.row[solved["feasible"]]

    def first(values: Array) -> tuple[int | None, int]:
        nonlocal rows
        some = tried(values.item(), rows)["feasible"]
        rows = rows[some] if some.any() else rows
        return 0 if some.any() else None, 0

    spaced = np.geomspace if ask.key == _ANCHOR else np.linspace
    least = edge(first, ask.before, ask.farthest, 3, _ROUNDS, spaced)
    printed = say.quantity(
        ask.quantity, least, toward=np.inf if ask.farthest > ask.before else -np.inf
    )
    after = parse_measure(printed.replace(",", ""), ask.quantity.dimension).si
    solved = tried(after, rows)
    best = solved.select([int(np.lexsort((-solved["tolerance"], -solved["served_at"]))[0])])
    columns = {
        axis.column: axis.names[best[axis.column][0]] if axis.names else best.scalar(axis.column)
        for axis in problem.choices.axes
    }
    values = {name: RIGID if value == np.inf else value for name, value in columns.items()}
    record |= {"after": after, "printed": printed, "choice": int(best.row[0]), "values": values}
    return record | {"pretension": best.scalar("pretension"), "served": best.scalar("served_at")}


# --- In words --------------------------------------------------------------------------------------------------------

_WORDS = {
    "load.mass": "loads of at most {} instead of {}",
    "arm.upper_arm_angle": "an upper arm tilted by at most {} instead of {}",
    "arm.contact_width": "a strap of {} instead of {}",
    "anchor.stiffness": "tissue and cuffs of {} behind each anchor instead of {}",
}


def relaxations_in_words(problem: Problem, relaxations: list[Row]) -> Iterator[str]:
    """What each thing that is asked for would have to become."""
    idle = []
    for each in relaxations:
        key, of = each["key"], _quantity_of(each["key"])
        text = _WORDS.get(key, f"{key.removeprefix('limits.')} = {{}} instead of {{}}")
        if each["after"] is None:
            idle.append(text.partition(" instead of")[0].format(say.quantity(of, each["farthest"])))
            continue
        share = "all" if each["served"] >= 1.0 else f"{say.percent(each['served'])} of the"
        others = Space(tuple(axis for axis in problem.choices.axes if axis.key != key))
        what = ", ".join(
            filter(None, (row_words(others, each["values"]), f"{say.number(each['pretension'])} N"))
        )
        changed = text.format(each["printed"], say.quantity(of, each["before"]))
        yield f"{changed}: {what} serves {share} {problem.counted}"
    if idle:
        yield f"not enough alone: {', '.join(idle)}"
