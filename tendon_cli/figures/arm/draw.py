"""The arm of a study drawn to scale (Fig. 2), the quickest way to see that a study says what one meant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import evenly
from tendon_cli.cube.labels import number
from tendon_cli.figures.arm.shape import ArmShape, ArmSizes, arm_sizes
from tendon_cli.figures.engine import Arc, Axes, Circle, FancyArrowPatch, Line2D
from tendon_cli.figures.frame import Frame, Page
from tendon_cli.figures.style import FAINT, INK, PAGE_WIDTH, house_style
from tendon_cli.studies.study import Study

FLEXOR, EXTENSOR, LIMB = "#0072b2", "#d55e00", "#eadfd3"
_MOST_ANGLES = 5
_NO_BALANCE = "#b00020"
_MEANING = "To scale. J is the moment arm of the flexor, $L_c$ the distance of its anchors q and r (Eq. 1)."


def arm_page(study: Study, elbow_angles: Sequence[float] = (), case: str | None = None) -> Page:
    """The arm with its dimensions at the middle one of the angles (rad), the spools, and the arm at each angle.

    Without angles at some of the study's. Raises UsageError for an unknown case.
    """
    sizes = arm_sizes(study, case)
    of_study = study.motion.elbow_angle.array
    angles = list(elbow_angles) or [float(of_study[at]) for at in evenly(len(of_study), 4)]
    remarks = list(sizes.remarks)
    if len(angles) > _MOST_ANGLES:
        remarks.append(f"{_MOST_ANGLES} of {len(angles)} elbow angles drawn, evenly chosen.")
        angles = [angles[at] for at in evenly(len(angles), _MOST_ANGLES)]
    title = ", ".join(filter(None, (study.title or study.name, case)))
    with house_style():
        frame = Frame(PAGE_WIDTH, title, _key(), (_MEANING, *remarks), study=f"tendon study {study.name} {study.hash}")
        page = frame.page(165.0)
        grid = page.figure.add_gridspec(2, 1, height_ratios=(1.75, 1.0))
        top = grid[0].subgridspec(1, 2, width_ratios=(2.4, 1.0))
        measured = min(angles, key=lambda angle: abs(angle - math.radians(70.0)))
        _draw_measured(page.figure.add_subplot(top[0]), ArmShape(sizes, measured))
        _draw_spools(page.figure.add_subplot(top[1]), sizes)
        shapes = [ArmShape(sizes, angle) for angle in angles]
        row = grid[1].subgridspec(1, len(shapes))
        _draw_row([page.figure.add_subplot(row[at]) for at in range(len(shapes))], shapes)
    return page


def _draw_limbs(axes: Axes, shape: ArmShape, width: float) -> None:
    """Bones, virtual pulley, tendons and anchors; `width` is that of the tendons in pt."""
    sizes, points = shape.sizes, shape.anchors
    shoulder, hand = sizes.upper_arm * shape.up, sizes.forearm * shape.along
    bones = np.array([shoulder, np.zeros(2), hand])
    axes.plot(*bones.T, color=LIMB, linewidth=9.0 * width, solid_joinstyle="round", zorder=0.5, gid="limb")
    axes.plot(*bones.T, color="#8c7b6b", linewidth=0.8, zorder=1, gid="bones")
    axes.add_patch(Circle((0.0, 0.0), sizes.elbow_radius, fill=False, edgecolor=EXTENSOR, linewidth=0.6,
                          linestyle=(0, (2, 1.5)), zorder=1.5, gid="pulley"))  # fmt: skip
    axes.plot(*shape.extensor.T, color=EXTENSOR, linewidth=width, zorder=2, gid="extensor")
    axes.plot(*np.array([points["r"], points["q"]]).T, color=FLEXOR, linewidth=width, zorder=2, gid="flexor")
    sheath = np.array([points["r"], points["r"] + (sizes.upper_arm - sizes.b1) * shape.up])
    axes.plot(*sheath.T, color=FLEXOR, linewidth=width, linestyle=(0, (2.0, 1.0)), zorder=2)
    for pair in ("rs", "pq"):
        axes.plot(*np.array([points[name] for name in pair]).T, color=INK, linewidth=0.7, zorder=2.5)
    axes.plot(*np.array(list(points.values())).T, color=INK, marker="o", markersize=2.2 * width**0.5, linestyle="none",
              zorder=3, gid="anchors")  # fmt: skip
    axes.plot(0.0, 0.0, marker="o", markersize=4.0, color="white", markeredgecolor=INK, markeredgewidth=0.7, zorder=3)
    com, load = sizes.forearm_com * shape.along, sizes.load_distance * shape.along
    axes.plot(*com, marker="P", markersize=5.0, color="white", markeredgecolor=INK, markeredgewidth=0.7, zorder=3)
    axes.plot(*load, marker="s", markersize=5.5, color=INK, zorder=3, gid="load")


def _draw_measured(axes: Axes, shape: ArmShape) -> None:
    sizes, points = shape.sizes, shape.anchors
    _draw_limbs(axes, shape, 1.6)
    foot = shape.moment_arm_foot
    axes.plot(*np.array([np.zeros(2), foot]).T, color=FLEXOR, linewidth=0.7, linestyle=(0, (1.5, 1.2)), zorder=2)
    axes.annotate("J", tuple(foot / 2.0), xytext=(2, 2), textcoords="offset points", color=FLEXOR, size=7.5)
    step = 0.055 * (sizes.upper_arm + sizes.forearm)
    back, under = -shape.front, -shape.forearm_front
    first = sizes.elbow_radius + step
    zero = np.zeros(2)
    dimension(axes, zero, points["s"], f"b₁ = {number(sizes.b1)} mm", offset=first * back)
    for level, (length, name) in enumerate(
        ((sizes.b2, "b₂"), (sizes.forearm_com, "$d_{com}$"), (sizes.load_distance, "$d_{load}$"))
    ):
        text = f"{name} = {number(length)} mm"
        dimension(axes, zero, length * shape.along, text, offset=(first + level * step) * under)
    _name(axes, points["r"], f"r   a₁ = {number(sizes.a1)} mm", shape.front)
    _name(axes, points["q"], f"q   a₂ = {number(sizes.a2)} mm", (2.0 * shape.along + shape.forearm_front) / 5**0.5)
    _name(axes, points["s"], "s", back)
    _name(axes, points["p"], "p", under)
    corner = -(shape.front + shape.forearm_front)
    tip = sizes.elbow_radius * corner / (np.linalg.norm(corner) or 1.0)
    arrow(axes, zero, tip, color=EXTENSOR)
    text = f"$R_{{elb}}$ = {number(sizes.elbow_radius)} mm"
    axes.annotate(text, tuple(tip), xytext=tuple(16.0 * tip / sizes.elbow_radius), textcoords="offset points",
                  color=EXTENSOR, ha="right" if tip[0] < 0.0 else "left", va="top", size=6.5)  # fmt: skip
    _draw_angle(axes, shape)
    _settle(axes, shape, margin=first + 3.2 * step)
    inclined = f", ψ = {_degrees(sizes.upper_arm_angle)}" if sizes.upper_arm_angle else ""
    axes.set_title(f"dimensions, drawn at θ = {_degrees(shape.elbow_angle)}{inclined}")


def _draw_angle(axes: Axes, shape: ArmShape) -> None:
    """The elbow angle from the straight arm, and the inclination of the upper arm where there is one."""
    sizes = shape.sizes
    radius = 0.42 * sizes.b2
    straight = -shape.up
    axes.plot(*np.array([np.zeros(2), 1.25 * radius * straight]).T, color=FAINT, linewidth=0.6, linestyle="dashed")
    start = math.degrees(sizes.upper_arm_angle) - 90.0
    ends = sorted((start, start + math.degrees(shape.elbow_angle)))
    axes.add_patch(Arc((0.0, 0.0), 2 * radius, 2 * radius, theta1=ends[0], theta2=ends[1], color=FAINT, linewidth=0.6))
    middle = math.radians(sum(ends) / 2.0)
    axes.text(
        0.84 * radius * math.cos(middle), 0.84 * radius * math.sin(middle), "θ", ha="center", va="center", color=INK
    )
    if sizes.upper_arm_angle:
        axes.plot([0.0, 0.0], [0.0, 0.7 * sizes.b1], color=FAINT, linewidth=0.6, linestyle="dashed")
        leaning = math.degrees(sizes.upper_arm_angle)
        ends = sorted((90.0, 90.0 + leaning))
        axes.add_patch(Arc((0.0, 0.0), 1.2 * sizes.b1, 1.2 * sizes.b1, theta1=ends[0], theta2=ends[1], color=FAINT))
        middle = math.radians(90.0 + leaning / 2.0)
        x, y = 0.68 * sizes.b1 * math.cos(middle), 0.68 * sizes.b1 * math.sin(middle)
        axes.text(x, y, "ψ", ha="center", va="center", bbox=PAPER, zorder=4)


def _draw_row(panels: Sequence[Axes], shapes: Sequence[ArmShape]) -> None:
    """The arm at each angle, all to one scale."""
    reach = shapes[0].sizes
    for axes, shape in zip(panels, shapes, strict=True):
        _draw_limbs(axes, shape, 0.8)
        balanced = shape.moment_arm > 0.0
        text = f"J = {number(round(shape.moment_arm, 1))} mm" if balanced else "J ≤ 0: no equilibrium"
        axes.set_title(f"θ = {_degrees(shape.elbow_angle)}", pad=18.0)
        axes.text(0.5, 1.0, f"{text}\n$L_c$ = {number(round(shape.flexor_path, 1))} mm", transform=axes.transAxes,
                  ha="center", va="bottom", size=6.2, color=INK if balanced else _NO_BALANCE)  # fmt: skip
        _settle(axes, *shapes, margin=1.3 * reach.elbow_radius)


def _draw_spools(axes: Axes, sizes: ArmSizes) -> None:
    """Both parts of the spool side by side, with the tendons that leave them on opposite sides."""
    largest = max(sizes.flexor_radius, sizes.extensor_radius)
    for at, (radius, colour, name, side) in enumerate(
        ((sizes.flexor_radius, FLEXOR, "R_{f}", 1.0), (sizes.extensor_radius, EXTENSOR, "R_{e}", -1.0))
    ):
        centre = np.array([0.0, -2.9 * largest * at])
        axes.add_patch(Circle(tuple(centre), radius, facecolor="#f4f4f4", edgecolor=colour, linewidth=1.6, gid="spool"))
        edge = centre + np.array([0.0, side * radius])
        axes.plot([edge[0], edge[0] + 2.2 * largest], [edge[1], edge[1]], color=colour, linewidth=1.6)
        axes.plot(*centre, marker="o", markersize=3.0, color=INK)
        tip = centre + radius * np.array([math.cos(2.5), math.sin(2.5)])
        arrow(axes, centre, tip)
        text = f"${name}$ = {number(radius)} mm"
        axes.annotate(text, (0.0, centre[1] - side * radius), xytext=(0, -side * 3), textcoords="offset points",
                      ha="center", va="top" if side > 0 else "bottom", size=7.0)  # fmt: skip
        axes.text(edge[0] + 2.2 * largest, edge[1], "flexor" if at == 0 else "extensor", color=colour, size=7.0,
                  ha="right", va="bottom" if side > 0 else "top")  # fmt: skip
    bar = round_length(1.6 * largest)
    scale_bar(axes, np.array([bar - largest, -4.6 * largest]), bar)
    axes.set(xlim=(-1.3 * largest, 2.5 * largest), ylim=(-5.1 * largest, 1.6 * largest), aspect="equal")
    axes.set_axis_off()
    axes.set_title(f"spools, η = $R_e$ / $R_f$ = {number(sizes.ratio)}")


def _settle(axes: Axes, *shapes: ArmShape, margin: float) -> None:
    """Equal scales, limits around all shapes, no axes but a bar of known length."""
    ends = [[shape.sizes.upper_arm * shape.up, shape.sizes.forearm * shape.along, np.zeros(2)] for shape in shapes]
    corners = np.vstack([*ends, *(list(shape.anchors.values()) for shape in shapes)])
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + 0.45 * margin
    bar = round_length(0.3 * float(np.ptp(corners)))
    scale_bar(axes, np.array([high[0] - 0.1 * margin, low[1] + 0.28 * margin]), bar)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()


def _name(axes: Axes, at: np.ndarray, text: str, toward: np.ndarray) -> None:
    """Name a point on the side that `toward` points to."""
    align = "left" if toward[0] > 0.3 else "right" if toward[0] < -0.3 else "center"
    upright = "bottom" if toward[1] > 0.3 else "top" if toward[1] < -0.3 else "center"
    axes.annotate(text, tuple(at), xytext=tuple(5.0 * toward), textcoords="offset points", ha=align, va=upright,
                  size=7.0, bbox=PAPER, zorder=2.2)  # fmt: skip


def _degrees(angle: float) -> str:
    return f"{number(round(math.degrees(angle), 3))} deg"


def _key() -> list[Line2D]:
    white: dict[str, Any] = {"color": "white", "markeredgecolor": INK, "markeredgewidth": 0.7, "linestyle": "none"}
    return [
        Line2D([], [], color=FLEXOR, linewidth=1.6, label="flexor tendon (dashed: in its sheath)"),
        Line2D([], [], color=EXTENSOR, linewidth=1.6, label="extensor tendon"),
        Line2D([], [], color=EXTENSOR, linewidth=0.6, linestyle=(0, (2, 1.5)), label="virtual pulley"),
        Line2D([], [], marker="P", markersize=5.0, label="centre of mass", **white),
        Line2D([], [], marker="s", markersize=5.5, color=INK, linestyle="none", label="load"),
    ]


Points = npt.NDArray[np.float64]

PAPER: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}


def dimension(axes: Axes, start: Points, end: Points, text: str, *, offset: Points | None = None) -> None:
    """Measure from `start` to `end`, the line moved by `offset`, with thin lines that lead to it."""
    shift = np.zeros(2) if offset is None else offset
    for point in (start, end) if offset is not None else ():
        axes.plot(*np.array([point, point + shift * 1.04]).T, color="#9a9a9a", linewidth=0.35, zorder=1.1)
    arrow(axes, start + shift, end + shift, style="<|-|>")
    middle = (start + end) / 2.0 + shift
    x, y = middle
    axes.text(x, y, text, rotation=_readable(end - start), ha="center", va="center", size=6.5, bbox=PAPER, zorder=6)


def arrow(axes: Axes, start: Points, end: Points, *, style: str = "-|>", color: str = INK) -> None:
    """A thin arrow."""
    patch = FancyArrowPatch(tuple(start), tuple(end), arrowstyle=style, mutation_scale=4.5, linewidth=0.5, color=color,
                            shrinkA=0.0, shrinkB=0.0, zorder=5)  # fmt: skip
    axes.add_patch(patch)


def scale_bar(axes: Axes, at: Points, length: float) -> None:
    """How long `length` mm are in the drawing, the bar ending at `at`."""
    axes.plot([at[0] - length, at[0]], [at[1], at[1]], color=INK, linewidth=1.4, solid_capstyle="butt", gid="scale")
    axes.annotate(f"{length:g} mm", (at[0] - length / 2.0, at[1]), xytext=(0, -2), textcoords="offset points",
                  ha="center", va="top", size=6.5)  # fmt: skip


def round_length(length: float) -> float:
    """The next round length below: 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))


def _readable(direction: Points) -> float:
    """The angle of a line in degrees, turned so that text along it is not upside down."""
    angle = math.degrees(math.atan2(direction[1], direction[0]))
    return -((90.0 - angle) % 180.0 - 90.0)
