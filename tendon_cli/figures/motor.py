"""The figure of a motor: its torque against its speed over the cycle, the loop that friction opens, and a turn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.figures.engine import Axes, Line2D
from tendon_cli.figures.frame import Frame
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, PAGE_WIDTH, check_format, house_style, save

Array = npt.NDArray[np.float64]

_WAYS: dict[str, tuple[str, Any]] = {
    "flexion": (OKABE_ITO[0], "solid"),
    "extension": (OKABE_ITO[1], (0, (3.2, 1.4))),
}
_HEIGHT = 74.0


@dataclass(frozen=True, eq=False)
class Stroke:
    """One direction of a cycle, along the way: arrays of one length, in SI."""

    elbow_angle: Array
    spool_angle: Array
    motor_speed: Array
    motor_torque: Array


@dataclass(frozen=True, eq=False)
class Turn:
    """The motor's torque while the motion turns, and where the far ends of taut tendons follow (rad)."""

    title: str
    spool_turn: Array
    motor_torque: Array
    follows: Mapping[str, tuple[float, float]]
    """By side: the spool's turn and the torque there."""


@dataclass(frozen=True, eq=False)
class MotorFigure:
    """What is drawn."""

    title: str
    strokes: Mapping[str, Stroke]
    """By direction; none where the study has no speed."""
    limits: Mapping[str, float]
    """Limits of the study by name, SI."""
    loss: float
    """J over the strokes; NaN where it is not known."""
    turn: Turn | None


def draw(given: MotorFigure, path: Path) -> Path:
    """Write the figure as PNG, SVG or PDF, by the file's ending; raises UsageError and OutputError."""
    check_format(path.suffix[1:].lower())
    panels = [_torque_and_speed, _loop] if given.strokes else []
    key = [Line2D([], [], color=colour, linestyle=dash, label=way) for way, (colour, dash) in _WAYS.items()
           if way in given.strokes]  # fmt: skip
    with house_style():
        figure = Frame(PAGE_WIDTH, given.title, key, _notes(given)).figure(_HEIGHT)
        places = figure.subplots(1, len(panels) + (given.turn is not None), squeeze=False)[0]
        for axes, panel in zip(places, panels, strict=False):
            panel(axes, given)
        if given.turn is not None:
            _turn(places[-1], given.turn)
        for axes in places:
            axes.yaxis.set_major_formatter(plain_numbers())
            axes.set_ylabel("motor torque $\\tau_m$ (N m)")
    return save(figure, path)


def _notes(given: MotorFigure) -> list[str]:
    turning = ["Dots: where the far end of each tendon follows the spool."] if given.turn is not None else []
    if not given.strokes:
        return turning
    units = {"torque": "N m", "speed": "rad/s", "power": "W"}
    limits = [f"{given.limits[f'peak_motor_{name}']:.4g} {unit}" for name, unit in units.items()
              if f"peak_motor_{name}" in given.limits]  # fmt: skip
    notes = [f"Dotted: the limits, {', '.join(limits)}."] if limits else []
    if np.isfinite(given.loss) and len(given.strokes) == 2:
        notes.append(f"The shaded area is what friction takes over both strokes, {given.loss:.3g} J.")
    return notes + turning


def _torque_and_speed(axes: Axes, given: MotorFigure) -> None:
    for way, stroke in given.strokes.items():
        colour, dash = _WAYS[way]
        axes.plot(stroke.motor_speed, stroke.motor_torque, color=colour, linestyle=dash, gid="curve")
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    axes.axvline(0.0, color=FAINT, linewidth=0.5)
    axes.margins(0.08)
    _limits(axes, given.limits)
    axes.set_title("Torque against speed")
    axes.set_xlabel("motor speed (rad/s)")


def _limits(axes: Axes, limits: Mapping[str, float]) -> None:
    """The motor's limits, as far as they are given; they widen the view, so that one sees what is left of them."""
    style: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": (0, (1.0, 1.2)), "gid": "limit"}
    torque, speed, power = (limits.get(f"peak_motor_{name}") for name in ("torque", "speed", "power"))
    for sign in (-1.0, 1.0):
        if torque is not None:
            axes.axhline(sign * torque, **style)
        if speed is not None:
            axes.axvline(sign * speed, **style)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    if speed is not None:
        left, right = min(left, -1.12 * speed), max(right, 1.12 * speed)
    if torque is not None:
        low, high = min(low, -1.12 * torque), max(high, 1.12 * torque)
    if power is not None:
        for start, stop, sign in ((power / high, right, 1.0), (left, -power / high, -1.0)):
            turning = np.linspace(start, stop, 200)
            axes.plot(turning, power / np.abs(turning) * sign, **style)
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)


def _loop(axes: Axes, given: MotorFigure) -> None:
    """The loop against the spool's angle, so that its area is work; the elbow's angle stands above."""
    for way, stroke in given.strokes.items():
        colour, dash = _WAYS[way]
        axes.plot(np.degrees(stroke.spool_angle), stroke.motor_torque, color=colour, linestyle=dash, gid="curve")
    if len(given.strokes) == 2:
        x, y = (np.concatenate([getattr(stroke, name) for stroke in given.strokes.values()])
                for name in ("spool_angle", "motor_torque"))  # fmt: skip
        known = np.isfinite(x) & np.isfinite(y)
        axes.fill(np.degrees(x[known]), y[known], color="#eceff2", linewidth=0.0, zorder=0.5, gid="loss")
    stroke = next(iter(given.strokes.values()))
    _elbow_above(axes, np.degrees(stroke.spool_angle), np.degrees(stroke.elbow_angle))
    axes.set_title("Hysteresis")
    axes.set_xlabel("spool angle α (deg)")


def _elbow_above(axes: Axes, spool: Array, elbow: Array) -> None:
    """Ticks of the elbow's angle on the upper edge, where the spool turns with it all the way."""
    order = np.argsort(elbow)
    turned, bent = spool[order], elbow[order]
    if len(bent) < 2 or not (np.diff(turned) > 0.0).all():
        return
    ticks = np.linspace(bent[0], bent[-1], 4)
    above = axes.secondary_xaxis("top")
    above.set_xticks(np.interp(ticks, bent, turned), [f"{tick:.3g}°" for tick in ticks])
    above.tick_params(length=2.0, labelsize=6.5)
    above.set_xlabel("elbow angle θ", size=6.5, labelpad=2.0)


def _turn(axes: Axes, turn: Turn) -> None:
    axes.plot(np.degrees(turn.spool_turn), turn.motor_torque, color=INK, gid="curve")
    for place, (side, (at, torque)) in enumerate(sorted(turn.follows.items(), key=lambda each: each[1])):
        axes.plot([np.degrees(at)], [torque], "o", color=INK, markersize=4.0, gid="mark")
        offset, align = ((4, 4), "bottom") if place == 0 else ((4, -4), "top")
        axes.annotate(f"{side}, {np.degrees(at):.2f}°", (np.degrees(at), torque), xytext=offset,
                      textcoords="offset points", va=align, size=6.5)  # fmt: skip
    axes.margins(0.08, 0.12)
    axes.set_xlim(right=1.5 * float(np.degrees(turn.spool_turn[-1])))
    axes.set_title(turn.title)
    axes.set_xlabel("spool turned back (deg)")
