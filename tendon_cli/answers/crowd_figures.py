"""The figures of a crowd, into the folder of an answer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tendon_cli.answers.crowd import Crowd
from tendon_cli.answers.crowd_text import name_of, why
from tendon_cli.answers.parts import Choices
from tendon_cli.answers.words import of_key, of_row, rounded
from tendon_cli.figures.crowd import Bars, Group, draw_for_whom, draw_how_sure, draw_served_map
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.study import keys
from tendon_cli.units import UNITS, counted

FOR_WHOM, HOW_SURE, SERVED_MAP = "for_whom.png", "how_sure.png", "served_map.png"
_USUAL = ("weight", "forearm_circumference")


def draw_crowd(crowd: Crowd, choices: Choices, folder: Path) -> list[str]:
    """Draw all that there is to be drawn; returns the files' names. Raises OutputError."""
    chosen = {name: values[0] for name, values in crowd.chosen.columns.items()}
    what = of_row(crowd.problem.choices, chosen)
    everyone = counted(len(crowd.windows.low), crowd.kind[:-1])
    title = ", ".join(filter(None, (what, f"{100 * crowd.share:.1f} % of {everyone} served")))
    _for_whom(crowd, folder / FOR_WHOM, title)
    _how_sure(crowd, folder / HOW_SURE, title)
    return [FOR_WHOM, HOW_SURE, *_served_map(crowd, choices, folder / SERVED_MAP)]


def _for_whom(crowd: Crowd, path: Path, title: str) -> None:
    windows, solutions = crowd.windows, crowd.chosen.solutions
    band = float(solutions.pretension_from[0]), float(solutions.pretension_to[0])
    bodies, labels, groups = None, ("", ""), []
    if crowd.people is not None:
        names = _most_different(crowd)
        body = crowd.people.body
        first, second = (np.asarray(getattr(body, name)) / _shown(name) for name in names)
        bodies = first, second
        labels = _body_label(names[0]), _body_label(names[1])
        groups = [Group(why(crowd, reason), reason.members) for reason in crowd.reasons[:4]]
    draw_for_whom(
        path, title, windows.low, windows.high, windows.held(crowd.pretension),
        band if band[0] <= band[1] else (np.nan, np.nan), crowd.pretension,
        bodies, labels, groups, crowd.kind,
    )  # fmt: skip


def _body_label(name: str) -> str:
    return f"{name.replace('_', ' ')} ({QUANTITIES[name].shown_in})"


def _most_different(crowd: Crowd) -> tuple[str, str]:
    """The two dimensions in which those left out differ most, whatever the reason."""
    apart = dict.fromkeys(DIMENSIONS, 0.0)
    for reason in crowd.reasons:
        for each in reason.differences:
            apart[each.dimension] += reason.share * abs(each.deviations)
    if not crowd.reasons:
        return _USUAL
    first, second = sorted(apart, key=lambda name: -apart[name])[:2]
    return first, second


def _shown(name: str) -> float:
    """SI per unit in which people read a quantity."""
    return float(UNITS[QUANTITIES[name].shown_in].factor)


def _how_sure(crowd: Crowd, path: Path, title: str) -> None:
    curve = crowd.curve
    bars = [
        Bars(f"{'lower' if each.end == 'pretension_from' else 'upper'} end, ± {rounded(each.deviation, 2)} N",
             each.first, each.first_error, each.total, each.total_error)
        for each in crowd.indices
    ]  # fmt: skip
    inputs = [name_of(name) for name in crowd.indices[0].inputs] if crowd.indices else []
    draw_how_sure(
        path, title, curve.pretension, curve.share, curve.low, curve.high, crowd.pretension, crowd.problem.enough,
        inputs, bars,
    )  # fmt: skip


def _served_map(crowd: Crowd, choices: Choices, path: Path) -> list[str]:
    """The share over the first two numbers of the choices, all others as in the one chosen; none of many parts."""
    factors = crowd.problem.choices.factors
    axes = [at for at, factor in enumerate(factors) if not factor.names and len(factor) > 1][:2]
    row = int(crowd.chosen.row[0])
    if len(axes) < 2 or row < 0 or choices.parts > 1:
        return []
    place = list(np.unravel_index(row, crowd.problem.choices.shape))
    at = tuple(slice(None) if axis in axes else place[axis] for axis in range(len(factors)))
    served = choices.only.solutions.served.reshape(crowd.problem.choices.shape)[at]  # (first, second)
    y, x = (factors[axis] for axis in axes)
    values, labels = [], []
    for factor in (x, y):
        quantity = keys()[factor.key].number.quantity
        values.append(factor.values / _shown(quantity.name))
        labels.append(f"{quantity.symbol}" + (f" ({quantity.shown_in})" if quantity.shown_in != "1" else ""))
    others = [of_key(factors[axis].key, factors[axis].values[place[axis]]) for axis in range(len(factors))
              if axis not in axes and not factors[axis].names]  # fmt: skip
    title = ", ".join(("Whom one pretension serves", *others))
    best = values[0][place[axes[1]]], values[1][place[axes[0]]]
    draw_served_map(path, title, values[0], values[1], served, (labels[0], labels[1]), best)
    return [path.name]
