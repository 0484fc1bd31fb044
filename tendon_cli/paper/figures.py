"""What the paper's figures say besides their curves, and the figure of its slips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.figures.curves import shade_slack
from tendon_cli.figures.draw import Finish
from tendon_cli.figures.engine import Axes, Figure, Line2D
from tendon_cli.figures.frame import framed
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, house_style
from tendon_cli.paper.runs import Array, Paper, PaperTables
from tendon_cli.paper.slips import eq_11_first, eq_12_as_printed, travel_ratio
from tendon_cli.paper.statements import decimals
from tendon_cli.studies.figures import FigureSpec

_USED, _PRINTED, _OPTION = OKABE_ITO[:3]
_DASHED = (0, (3.2, 1.4))


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
    for mark, axes, angle in zip("abcdefgh", page.axes, run.crossings(), strict=False):
        axes.set_title(f"({mark}) {axes.get_title()}")
        if np.isfinite(angle):
            axes.axvspan(0.0, angle, facecolor="#efefef", linewidth=0.0, zorder=0.4, gid="first angles")
            axes.text(angle + 1.0, 0.97, f"in flexion $\\tau_m > \\tau_a$\nonly below {angle:.1f}°", va="top",
                      transform=axes.get_xaxis_transform(), size=7.0)  # fmt: skip


@dataclass(frozen=True)
class _Line:
    """A line of a panel, and its name at a share of the way along it."""

    y: Array
    colour: str
    name: str = ""
    at: float = 0.72
    above: bool = True
    side: str = "right"
    is_back: bool = False


def _panels(paper: Paper) -> dict[str, tuple[str, Sequence[_Line]]]:
    """What is shown of each slip that has curves, by the title of its panel: the label of y, and its lines."""
    fig07, tension = paper["fig07"], "tension at the elbow (N)"
    heavy, idle = (np.flatnonzero(fig07.places(load_mass=load)).item() for load in (5.0, 0.0))
    sides = dict(zip(("flexor", "extensor"), eq_12_as_printed(*fig07.inputs()), strict=True))
    eq_12 = [
        _Line(values, colour, side, at, above)
        for side, place, is_above in (("flexor", 0.3, True), ("extensor", 0.88, False))
        for values, colour, at, above in (
            (fig07.line(f"{side}_tension_distal", load_mass=5.0), _USED, 0.72, is_above),
            (sides[side][heavy, 0], _PRINTED, place, True),
        )
    ]  # fmt: skip
    first, eq_11 = eq_11_first(*fig07.inputs())[0][idle], []
    for way, direction in enumerate(("flexion", "extension")):
        used = fig07.line("flexor_tension_distal", direction, load_mass=0.0)
        eq_11 += [
            _Line(used, _USED, "" if way else "flexion and extension", 0.5, above=False, is_back=way > 0),
            _Line(first[way], _PRINTED, is_back=way > 0),
        ]
    printed, initial = (travel_ratio(paper[name]) for name in ("fig04", "fig04-initial"))
    of_printed, of_initial = (
        f"as published, from $b_1 + b_2$: {decimals(printed[0], 3)} at 1°",
        f'reference = "initial", from $L_c(0)$: {decimals(initial[0], 3)} at 1°',
    )
    travel = [
        _Line(printed, _PRINTED, of_printed, 0.05, above=False, side="left"),
        _Line(initial, _OPTION, of_initial, 0.86),
    ]
    springs = [
        _Line(paper[name].line("extensor_tension_distal", load_mass=5.0), colour, text, above=name == "fig06")
        for name, colour, text in (("fig06", _USED, "3 kN/m"), ("fig06-30kN", _PRINTED, "30 kN/m"))
    ]
    return {
        "S1: Eq. 12 with its printed sign, 5 kg, flexion": (tension, eq_12),
        "S2: Eq. 11 first, flexor at the elbow, no load": (tension, eq_11),
        "S4: where the flexor's travel counts from": ("$H_f / H_e$", travel),
        "S5: springs of 30 kN/m, extensor, 5 kg, flexion": (tension, springs),
    }


def draw_slips(paper: Paper, path: Path) -> Path:
    """The letter of the paper and the reading used, a panel per slip that has curves."""
    key = [
        Line2D([], [], color=_USED, label="reading used"),
        Line2D([], [], color=_PRINTED, label="letter of the paper"),
        Line2D([], [], color=INK, label="flexion"),
        Line2D([], [], color=INK, linestyle=_DASHED, label="extension"),
    ]
    degrees = {len(paper[name].degrees): paper[name].degrees for name in ("fig04", "fig07")}
    with house_style():
        page = framed("Where the letter of the paper fails", 122.0, key)
        grid = page.figure.subplots(2, 2)
        for axes, (title, (label, lines)) in zip(grid.flat, _panels(paper).items(), strict=True):
            for line in lines:
                style: dict[str, Any] = {"linestyle": _DASHED if line.is_back else "solid", "color": line.colour}
                x = degrees[len(line.y)]
                axes.plot(x, line.y, **style)
                place, up = int(line.at * (len(x) - 1)), 1 if line.above else -1
                axes.annotate(line.name, (x[place], line.y[place]), xytext=(-3 if line.side == "right" else 6, 4 * up),
                              textcoords="offset points", ha=line.side, va="bottom" if line.above else "top",
                              color=line.colour)  # fmt: skip
            axes.set(title=title, ylabel=label, xlabel="elbow angle θ (deg)", xlim=(0.0, 90.0))
            axes.set_xticks(range(0, 91, 15))
            axes.yaxis.set_major_formatter(plain_numbers())
            if label.startswith("tension"):
                shade_slack(axes)
    return page.save(path)
