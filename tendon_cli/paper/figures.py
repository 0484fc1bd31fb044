"""What the paper's figures say besides their curves, and the figure of its slips."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.figures.curves import shade_slack
from tendon_cli.figures.draw import Finish
from tendon_cli.figures.engine import Axes, Figure, Line2D
from tendon_cli.figures.frame import framed
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, house_style
from tendon_cli.paper.entry import number
from tendon_cli.paper.measures import crossing
from tendon_cli.paper.runs import Array, PaperTables
from tendon_cli.paper.slips import Evidence
from tendon_cli.studies.figures import FigureSpec

_USED, _LETTER, _OPTION = OKABE_ITO[:3]
_DASHED = (0, (3.2, 1.4))
_LETTERS = "abcdefgh"


def finisher(run: PaperTables) -> Finish:
    """Adds what a figure of the paper needs so that its finding is read off it."""

    def finish(figure: FigureSpec, page: Figure) -> None:
        if figure.name == "fig04":
            _mark_ratio(page.axes[0])
        if figure.name == "fig06":
            _mark_crossings(page, run)
        if len(page.axes) == 2:
            for axes, side in zip(page.axes, ("front", "back"), strict=True):
                axes.set_title(f"{side} of the arm: {axes.get_title()}")
        if len(figure.quantity) == 2 and all(name.endswith("elongation") for name in figure.quantity):
            page.axes[0].set_ylabel("length over unloaded (mm)")
        elif all("_tension_" in name for name in figure.quantity):
            page.axes[0].set_ylabel("tension (N)")

    return finish


def _mark_ratio(axes: Axes) -> None:
    axes.set_ylabel("flexor over extensor travel, $H_f / H_e$")
    axes.axhline(1.0, color=FAINT, linewidth=0.8, linestyle=_DASHED)
    (line,) = [line for line in axes.lines if line.get_gid() == "curve"]
    x, y = (np.asarray(values, dtype=np.float64) for values in line.get_data())
    at_one = float(np.interp(1.0, y, x))
    points = (
        (at_one, 1.0, f"1 at {at_one:.1f}°", (4, -11), "left"),
        (x[-1], y[-1], f"{y[-1]:.3f} at 90°", (-6, 0), "right"),
    )
    for at, height, text, offset, side in points:
        axes.plot([at], [height], "o", color=INK, markersize=4.0, clip_on=False, gid="mark")
        axes.annotate(text, (at, height), xytext=offset, textcoords="offset points", ha=side, va="center")


def _mark_crossings(page: Figure, run: PaperTables) -> None:
    """The first angles of flexion, where the motor torque is the larger one."""
    for mark, axes, load in zip(_LETTERS, page.axes, run.values("load_mass"), strict=False):
        angle = crossing(run, load_mass=load)
        axes.set_title(f"({mark}) {axes.get_title()}")
        if np.isfinite(angle):
            axes.axvspan(0.0, angle, facecolor="#efefef", linewidth=0.0, zorder=0.4, gid="first angles")
            axes.text(angle + 1.0, 0.97, f"in flexion $\\tau_m > \\tau_a$\nonly below {angle:.1f}°", va="top",
                      transform=axes.get_xaxis_transform(), size=7.0)  # fmt: skip


def draw_slips(runs: Mapping[str, PaperTables], found: Evidence, path: Path) -> Path:
    """The letter of the paper beside the reading used, a panel per slip that has curves."""
    key = [
        Line2D([], [], color=_USED, label="reading used"),
        Line2D([], [], color=_LETTER, label="letter of the paper"),
        Line2D([], [], color=INK, label="flexion"),
        Line2D([], [], color=INK, linestyle=_DASHED, label="extension"),
    ]
    with house_style():
        page = framed("Where the letter of the paper fails", 122.0, key)
        grid = page.figure.subplots(2, 2)
        _eq_12(grid[0, 0], runs["fig07"], found)
        _eq_11(grid[0, 1], runs["fig07"], found)
        _reference(grid[1, 0], runs)
        _stiffness(grid[1, 1], runs)
        for axes in grid.flat:
            axes.set_xlabel("elbow angle θ (deg)")
            axes.set_xlim(0.0, 90.0)
            axes.set_xticks(range(0, 91, 15))
            axes.yaxis.set_major_formatter(plain_numbers())
    return page.save(path)


def _eq_12(axes: Axes, run: PaperTables, found: Evidence) -> None:
    at = run.values("load_mass").index(5.0)
    for side, above_used, place in (("flexor", True, 0.3), ("extensor", False, 0.88)):
        printed: Array = getattr(found.eq_12, side)[at][0]
        used = run.line(f"{side}_tension_distal", load_mass=5.0)
        axes.plot(run.degrees, used, color=_USED)
        axes.plot(run.degrees, printed, color=_LETTER)
        _say(axes, run.degrees, printed, side, _LETTER, at=place, above=True)
        _say(axes, run.degrees, used, side, _USED, at=0.72, above=above_used)
    _finish(axes, "S1: Eq. 12 with its printed sign, 5 kg, flexion")


def _eq_11(axes: Axes, run: PaperTables, found: Evidence) -> None:
    at = run.values("load_mass").index(0.0)
    for way, (direction, dash) in enumerate((("flexion", "solid"), ("extension", _DASHED))):
        style: dict[str, Any] = {"linestyle": dash}
        axes.plot(run.degrees, run.line("flexor_tension_distal", direction, load_mass=0.0), color=_USED, **style)
        axes.plot(run.degrees, found.eq_11.flexor[at, way], color=_LETTER, **style)
    last = run.degrees.size // 2
    both = run.line("flexor_tension_distal", load_mass=0.0)
    axes.annotate("flexion and extension", (run.degrees[last], both[last]), xytext=(-4, -6), textcoords="offset points",
                  ha="right", va="top", color=_USED)  # fmt: skip
    _finish(axes, "S2: Eq. 11 first, flexor at the elbow, no load")


def _reference(axes: Axes, runs: Mapping[str, PaperTables]) -> None:
    printed, initial = (
        runs[name].line("flexor_travel") / runs[name].line("extensor_travel") for name in ("fig04", "fig04-initial")
    )
    degrees = runs["fig04"].degrees
    axes.plot(degrees, printed, color=_LETTER)
    axes.plot(degrees, initial, color=_OPTION)
    axes.axhline(0.0, color=INK, linewidth=0.5)
    low = f"as published, from $b_1 + b_2$: {number(printed[0], 3)} at 1°"
    axes.annotate(low, (degrees[0], printed[0]), xytext=(10, 0), textcoords="offset points", va="center", color=_LETTER)
    text = f'reference = "initial", from $L_c(0)$: {number(initial[0], 3)} at 1°'
    axes.text(0.98, 0.4, text, transform=axes.transAxes, ha="right", color=_OPTION)
    axes.set_ylabel("$H_f / H_e$")
    axes.set_title("S4: where the flexor's travel counts from")


def _stiffness(axes: Axes, runs: Mapping[str, PaperTables]) -> None:
    for name, colour, text in (("fig06", _USED, "3 kN/m"), ("fig06-30kN", _LETTER, "30 kN/m")):
        run = runs[name]
        line = run.line("extensor_tension_distal", load_mass=5.0)
        axes.plot(run.degrees, line, color=colour)
        _say(axes, run.degrees, line, text, colour, at=0.72, above=name == "fig06")
    _finish(axes, "S5: springs of 30 kN/m, extensor, 5 kg, flexion")


def _say(axes: Axes, x: Array, y: Array, text: str, colour: str, *, at: float, above: bool) -> None:
    """Name a line above it, or below and to the left of it."""
    place = int(at * (len(x) - 1))
    offset, side = ((-3, 4), "bottom") if above else ((-3, -4), "top")
    axes.annotate(text, (x[place], y[place]), xytext=offset, textcoords="offset points", ha="right", va=side,
                  color=colour)  # fmt: skip


def _finish(axes: Axes, title: str) -> None:
    axes.set_title(title)
    axes.set_ylabel("tension at the elbow (N)")
    shade_slack(axes)
