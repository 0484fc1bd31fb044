"""The choices of an answer by the axes of their grid."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.axes import Ints
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import reading
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import Axis


def position(axis: Axis, value: Any) -> Ints:
    """The position of a value on an axis, or of the nearest, as an array of one."""
    same = np.array(axis.values == value)
    at = np.argmax(same) if same.any() or axis.is_text else np.argmin(np.abs(axis.values - value))
    return np.array([int(at)], dtype=np.int64)


def value_text(cube: Cube, axis: Axis, value: Any) -> str:
    """One value of an axis, as titles have it."""
    return str(value) if axis.is_text else cube.shown(axis.column).equation(float(value))


def conflicts_of(read: Mapping[str, Values], bounds: Mapping[str, float]) -> Values:
    """Why each of some choices has no window, in words; empty if it has one. `read` has both ends and what they are of.

    An end that nothing bounds is not a number, as in the table.
    """
    low, high = read["pretension_from"], read["pretension_to"]
    texts = np.full(low.shape, "", dtype=object)
    has_window = (low <= high) | (np.isnan(high) & ~np.isnan(low))
    for at in np.argwhere(~has_window):
        place = tuple(at)
        limits = list(
            dict.fromkeys(
                str(read[name][place]) for name in ("from_by", "to_by") if read[name][place]
            )
        )
        limits = limits if np.isfinite(low[place]) else limits[:1]
        texts[place] = say.conflict_label(limits, bounds) if limits else "no window"
    return texts


def pretension_name(document: Mapping[str, Any]) -> str:
    """What an axis of pretensions says, by the resolved study: "tension in the flexor at the joint"."""
    words = reading(document)
    return "pretension F₀" if words == "pretension" else words


# --- The window over the angle ---------------------------------------------------------------------------------------

_ROOM = 1.6
"""How far above the window a picture goes, as a factor."""


@dataclass(frozen=True)
class OverAngle:
    """What each limit asks of the choice named first over the elbow angle (deg), N: lower ends, then upper ones."""

    angle: Array
    ends: tuple[dict[str, Array], dict[str, Array]]
    """By limit; NaN where it asks for nothing."""
    tightest: tuple[Array, Array]
    samples: Array
    """The study's angles."""
    at_samples: tuple[Array, Array]
    """The tightest there; NaN outside of the picture."""
    window: tuple[float, float]
    """Infinite where nothing bounds it."""
    top: float
    """Of the picture."""
    texts: tuple[str, str]
    """What is proved, and what the lines stand for."""
    works: tuple[str, str]
    """What the window does, and what the room between the tightest lines does: "works at every angle"."""

    def shown(self, values: Array) -> Array:
        """Those that lie in the picture, others are NaN."""
        return np.where((values >= 0.0) & (values <= 1.02 * self.top), values, np.nan)


def over_angle(record: Mapping[str, Any]) -> OverAngle | None:
    """That of an answer's record; None if it has none."""
    between, best = record.get("between_samples"), record["best"]
    if not between or best is None:
        return None
    curves = between["curves"]
    low, high = (
        best["pretension_from"],
        math.inf if best["pretension_to"] is None else best["pretension_to"],
    )
    top = _ROOM * (high if math.isfinite(high) else max(2.0 * low, 1.0))
    angle, samples = np.degrees(curves["elbow_angle"]), np.degrees(curves["samples"])
    lower, upper = (
        {name: np.array(values, dtype=np.float64) for name, values in curves[end].items()}
        for end in ("lower", "upper")
    )
    floor = np.fmax.reduce([*lower.values(), np.zeros(len(angle))])
    roof = np.fmin.reduce([*upper.values(), np.full(len(angle), np.inf)])
    at_samples = [np.interp(samples, angle, each) for each in (floor, roof)]
    first, second = (np.where(each <= top, each, np.nan) for each in at_samples)
    stand, works = _whom(record, of_all=curves["all_conditions"])
    return OverAngle(
        angle,
        (lower, upper),
        (floor, roof),
        samples,
        (first, second),
        (low, high),
        top,
        (say.proof(between), stand),
        works,
    )


def _whom(record: Mapping[str, Any], *, of_all: bool) -> tuple[str, tuple[str, str]]:
    """For whom the lines stand; and what the window does, and the room between the lines."""
    pretension, everywhere = (
        say.quantity("pretension", record["best"]["pretension"]),
        "works at every angle",
    )
    lines = "all conditions" if of_all else f"the conditions that {pretension} serves"
    there, window = "works at that angle" if of_all else "works at that angle for those served", ""
    if record["serve"] < 1.0:
        kind = "conditions" if record["population"] is None else record["population"]["kind"]
        share = f"at least {say.percent(record['serve'])}"
        everywhere, window = (
            f"{everywhere} for {share}",
            f" The window serves {share} of the {kind}.",
        )
        there = f"{there} for all" if of_all else there
    elif not of_all:
        window = " The window is that of all conditions."
    return f"Each line is the worst of {lines} and both directions.{window}", (everywhere, there)
