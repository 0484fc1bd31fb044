"""The joint of a study: its arm drawn to scale (Fig. 2), or its measured travels over the angle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.axes import evenly
from tendon_cli.cube.labels import number
from tendon_cli.figures.arm_shape import ArmShape, ArmSizes, Points, arm_sizes
from tendon_cli.figures.backend import Arc, Axes, Circle, FancyArrowPatch, Line2D, Patch
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, house_style
from tendon_cli.space.axis import SIDES
from tendon_cli.studies.angle_curves import curves_of
from tendon_cli.studies.study import Study

FLEXOR, EXTENSOR = OKABE_ITO[:2]
_MOST_ANGLES = 5
_NO_BALANCE = "#b00020"
_MEANING = "To scale. J is the moment arm of the flexor, $L_c$ the distance of its anchors q and r (Eq. 1)."
_ZERO = np.zeros(2)
_PAPER: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}
_PULLEY: dict[str, Any] = {"color": EXTENSOR, "linewidth": 0.6, "linestyle": (0, (2, 1.5))}
_WHITE: dict[str, Any] = {
    "color": "white",
    "markeredgecolor": INK,
    "markeredgewidth": 0.7,
    "linestyle": "none",
}
_LOAD: dict[str, Any] = {"marker": "s", "markersize": 5.5, "color": INK, "linestyle": "none"}


def arm_page(study: Study, elbow_angles: Sequence[float] = (), case: str | None = None) -> Page:
    """The arm with its dimensions at the middle one of the angles (rad), the spools, and the arm at each angle.

    Without angles at some of the study's. A joint by its measured travels has no anchors to draw: its two curves are.
    Raises UsageError for an unknown case.
    """
    if study.joint.excursion is not None:
        return _travels_page(study, elbow_angles)
    sizes = arm_sizes(study, case)
    of_study = study.motion.elbow_angle.array
    angles = list(elbow_angles) or [float(of_study[at]) for at in evenly(len(of_study), 4)]
    remarks = list(sizes.remarks)
    if len(angles) > _MOST_ANGLES:
        remarks.append(f"{_MOST_ANGLES} of {len(angles)} elbow angles drawn, evenly chosen.")
        angles = [angles[at] for at in evenly(len(angles), _MOST_ANGLES)]
    title = ", ".join(filter(None, (study.title or study.name, case)))
    key = [
        Line2D([], [], color=FLEXOR, linewidth=1.6, label="flexor tendon (dashed: in its sheath)"),
        Line2D([], [], color=EXTENSOR, linewidth=1.6, label="extensor tendon"),
        Line2D([], [], label="virtual pulley", **_PULLEY),
        Line2D([], [], marker="P", markersize=5.0, label="centre of mass", **_WHITE),
        Line2D([], [], label="load", **_LOAD),
    ]
    with house_style():
        page = framed(
            title, 165.0, key, (_MEANING, *remarks), study=f"tendon study {study.name} {study.hash}"
        )
        grid = page.figure.add_gridspec(2, 1, height_ratios=(1.75, 1.0))
        top, row = (
            grid[0].subgridspec(1, 2, width_ratios=(2.4, 1.0)),
            grid[1].subgridspec(1, len(angles)),
        )
        measured = min(angles, key=lambda angle: abs(angle - math.radians(70.0)))
        _draw_measured(page.figure.add_subplot(top[0]), ArmShape(sizes, measured))
        _draw_spools(page.figure.add_subplot(top[1]), sizes)
        shapes = [ArmShape(sizes, angle) for angle in angles]
        for at, shape in enumerate(shapes):
            axes = page.figure.add_subplot(row[at])
            _draw_small(axes, shape)
            _settle(
                axes, *shapes, margin=1.3 * float(sizes.anchors.elbow_radius)
            )  # all to one scale
    return page


def _travels_page(study: Study, angles: Sequence[float]) -> Page:
    """The travel of each tendon over the angle with what was measured, and its slope; `angles` (rad) are marked.

    Both travels are counted from the setting's angle, as the model counts them.
    """
    table: Any = study.joint.excursion
    curves, measured, origin = curves_of(study), table.angles, study.setting.angle.single
    span = np.linspace(measured[0], measured[-1], 361)
    smoothed = (
        ", smoothed" if study.joint.smoothing is not None and study.joint.smoothing.single else ""
    )
    notes = [f"{len(measured)} measured angles{smoothed}. Travels count from {_degrees(origin)}."]
    key: list[Any] = [
        Line2D([], [], color=colour, label=side)
        for side, colour in zip(SIDES, OKABE_ITO, strict=False)
    ]
    key += [Line2D([], [], color=INK, marker="o", markersize=2.5, linestyle="", label="measured")]
    key += [Patch(facecolor="#eceff2", label="motion of the study")]
    with house_style():
        page = framed(
            study.title or study.name,
            76.0,
            key,
            notes,
            study=f"tendon study {study.name} {study.hash}",
        )
        travel, arm = page.figure.subplots(1, 2)
        for side, colour in zip(SIDES, OKABE_ITO, strict=False):
            curve = curves[f"joint.{side}_excursion"]
            zero, values = float(curve(np.asarray(origin))), np.array(table.columns[side])
            travel.plot(np.degrees(span), 1e3 * (curve(span) - zero), color=colour, gid="travel")
            travel.plot(
                np.degrees(measured),
                1e3 * (values - zero),
                "o",
                color=colour,
                markersize=2.5,
                gid="measured",
            )
            arm.plot(np.degrees(span), 1e3 * curve(span, 1), color=colour, gid="moment arm")
        motion = study.motion.elbow_angle.array
        for axes, label in ((travel, "travel H (mm)"), (arm, "moment arm J = dH/dθ (mm)")):
            axes.axvspan(
                *np.degrees([motion.min(), motion.max()]),
                color="#eceff2",
                linewidth=0.0,
                zorder=0.3,
            )
            axes.axhline(0.0, color=INK, linewidth=0.5)
            for angle in np.degrees(angles):
                axes.axvline(angle, color=FAINT, linewidth=0.6, linestyle=(0, (3, 2)))
            axes.set(
                xlabel=f"{say.joint_word(study)} angle θ (deg)",
                ylabel=label,
                xlim=np.degrees(span[[0, -1]]),
            )
            axes.yaxis.set_major_formatter(plain_numbers())
    return page


def _line(axes: Axes, *points: Points, **style: Any) -> None:
    axes.plot(*np.array(points).T, **style)


def _draw_limbs(axes: Axes, shape: ArmShape, width: float) -> None:
    """Bones, virtual pulley, tendons and anchors; `width` is that of the tendons in pt."""
    sizes, points = shape.sizes, shape.anchors
    bones = (sizes.upper_arm * shape.up, _ZERO, sizes.forearm * shape.along)
    _line(
        axes,
        *bones,
        color="#eadfd3",
        linewidth=9.0 * width,
        solid_joinstyle="round",
        zorder=0.5,
        gid="limb",
    )
    _line(axes, *bones, color="#8c7b6b", linewidth=0.8, zorder=1, gid="bones")
    axes.add_patch(
        Circle(
            (0.0, 0.0),
            float(sizes.anchors.elbow_radius),
            fill=False,
            zorder=1.5,
            gid="pulley",
            **_PULLEY,
        )
    )
    _line(axes, *shape.extensor, color=EXTENSOR, linewidth=width, zorder=2, gid="extensor")
    _line(axes, points["r"], points["q"], color=FLEXOR, linewidth=width, zorder=2, gid="flexor")
    sheath = (points["r"], points["r"] + (sizes.upper_arm - sizes.anchors.b1) * shape.up)
    _line(axes, *sheath, color=FLEXOR, linewidth=width, linestyle=(0, (2.0, 1.0)), zorder=2)
    for one, other in ("rs", "pq"):
        _line(axes, points[one], points[other], color=INK, linewidth=0.7, zorder=2.5)
    _line(
        axes,
        *points.values(),
        color=INK,
        marker="o",
        markersize=2.2 * width**0.5,
        linestyle="none",
        zorder=3,
        gid="anchors",
    )
    axes.plot(0.0, 0.0, marker="o", markersize=4.0, zorder=3, **_WHITE)
    axes.plot(*sizes.forearm_com * shape.along, marker="P", markersize=5.0, zorder=3, **_WHITE)
    axes.plot(*sizes.load_distance * shape.along, zorder=3, gid="load", **_LOAD)


def _draw_measured(axes: Axes, shape: ArmShape) -> None:
    sizes, joint, points, foot = (
        shape.sizes,
        shape.sizes.anchors,
        shape.anchors,
        shape.moment_arm_foot,
    )
    radius = float(joint.elbow_radius)
    _draw_limbs(axes, shape, 1.6)
    _line(axes, _ZERO, foot, color=FLEXOR, linewidth=0.7, linestyle=(0, (1.5, 1.2)), zorder=2)
    axes.annotate(
        "J", tuple(foot / 2.0), xytext=(2, 2), textcoords="offset points", color=FLEXOR, size=7.5
    )
    step = 0.055 * (sizes.upper_arm + sizes.forearm)
    back, under, first = -shape.front, -shape.forearm_front, radius + step
    _dimension(axes, points["s"], f"b₁ = {number(float(joint.b1))} mm", first * back)
    lengths = {
        "b₂": float(joint.b2),
        "$d_{com}$": sizes.forearm_com,
        "$d_{load}$": sizes.load_distance,
    }
    for level, (name, length) in enumerate(lengths.items()):
        _dimension(
            axes,
            length * shape.along,
            f"{name} = {number(length)} mm",
            (first + level * step) * under,
        )
    _name(axes, points["r"], f"r   a₁ = {number(float(joint.a1))} mm", shape.front)
    _name(
        axes,
        points["q"],
        f"q   a₂ = {number(float(joint.a2))} mm",
        (2.0 * shape.along - under) / 5**0.5,
    )
    _name(axes, points["s"], "s", back)
    _name(axes, points["p"], "p", under)
    corner = back + under
    tip = radius * corner / (np.linalg.norm(corner) or 1.0)
    _arrow(axes, _ZERO, tip, color=EXTENSOR)
    axes.annotate(
        f"$R_{{elb}}$ = {number(radius)} mm",
        tuple(tip),
        xytext=tuple(16.0 * tip / radius),
        textcoords="offset points",
        color=EXTENSOR,
        ha="right" if tip[0] < 0.0 else "left",
        va="top",
        size=6.5,
    )
    straight = 0.42 * float(joint.b2)
    _line(axes, _ZERO, -1.25 * straight * shape.up, color=FAINT, linewidth=0.6, linestyle="dashed")
    _draw_angle(
        axes,
        "θ",
        straight,
        0.84 * straight,
        math.degrees(sizes.upper_arm_angle) - 90.0,
        shape.elbow_angle,
    )
    inclined = ""
    if sizes.upper_arm_angle:
        inclined = f", ψ = {_degrees(sizes.upper_arm_angle)}"
        _line(
            axes,
            _ZERO,
            np.array([0.0, 0.7 * joint.b1]),
            color=FAINT,
            linewidth=0.6,
            linestyle="dashed",
        )
        _draw_angle(
            axes, "ψ", 0.6 * float(joint.b1), 0.68 * float(joint.b1), 90.0, sizes.upper_arm_angle
        )
    _settle(axes, shape, margin=first + 3.2 * step)
    axes.set_title(f"dimensions, drawn at θ = {_degrees(shape.elbow_angle)}{inclined}")


def _draw_angle(
    axes: Axes, text: str, radius: float, place: float, start: float, angle: float
) -> None:
    """An angle in rad as an arc from `start` in degrees, named at a distance from the elbow."""
    ends = sorted((start, start + math.degrees(angle)))
    axes.add_patch(
        Arc(
            (0.0, 0.0),
            2 * radius,
            2 * radius,
            theta1=ends[0],
            theta2=ends[1],
            color=FAINT,
            linewidth=0.6,
        )
    )
    middle = math.radians(start) + angle / 2.0
    axes.text(
        place * math.cos(middle),
        place * math.sin(middle),
        text,
        ha="center",
        va="center",
        bbox=_PAPER,
        zorder=4,
    )


def _draw_small(axes: Axes, shape: ArmShape) -> None:
    _draw_limbs(axes, shape, 0.8)
    balanced = shape.moment_arm > 0.0
    text = f"J = {number(round(shape.moment_arm, 1))} mm" if balanced else "J ≤ 0: no equilibrium"
    axes.set_title(f"θ = {_degrees(shape.elbow_angle)}", pad=18.0)
    axes.text(
        0.5,
        1.0,
        f"{text}\n$L_c$ = {number(round(shape.flexor_path, 1))} mm",
        transform=axes.transAxes,
        ha="center",
        va="bottom",
        size=6.2,
        color=INK if balanced else _NO_BALANCE,
    )


def _draw_spools(axes: Axes, sizes: ArmSizes) -> None:
    """Both parts of the spool side by side, with the tendons that leave them on opposite sides."""
    radii = sizes.flexor_radius, sizes.ratio * sizes.flexor_radius
    largest = max(radii)
    for at, (radius, colour, name) in enumerate(
        zip(radii, (FLEXOR, EXTENSOR), ("flexor", "extensor"), strict=True)
    ):
        centre, side = np.array([0.0, -2.9 * largest * at]), 1.0 - 2.0 * at
        axes.add_patch(
            Circle(
                tuple(centre),
                radius,
                facecolor="#f4f4f4",
                edgecolor=colour,
                linewidth=1.6,
                gid="spool",
            )
        )
        leaves = centre + np.array([0.0, side * radius])
        end = leaves + np.array([2.2 * largest, 0.0])
        _line(axes, leaves, end, color=colour, linewidth=1.6)
        axes.plot(*centre, marker="o", markersize=3.0, color=INK)
        _arrow(axes, centre, centre + radius * np.array([math.cos(2.5), math.sin(2.5)]))
        text = f"$R_{{{name[0]}}}$ = {number(radius)} mm"
        axes.annotate(
            text,
            (0.0, centre[1] - side * radius),
            xytext=(0, -side * 3),
            textcoords="offset points",
            ha="center",
            va="top" if side > 0 else "bottom",
            size=7.0,
        )
        axes.text(
            end[0],
            end[1],
            name,
            color=colour,
            size=7.0,
            ha="right",
            va="bottom" if side > 0 else "top",
        )
    axes.set(
        xlim=(-1.3 * largest, 2.5 * largest), ylim=(-4.4 * largest, 1.6 * largest), aspect="equal"
    )
    axes.set_axis_off()
    axes.set_title(f"spools, η = $R_e$ / $R_f$ = {number(sizes.ratio)}")


def _settle(axes: Axes, *shapes: ArmShape, margin: float) -> None:
    """Equal scales, limits around all shapes, no axes."""
    ends = [
        [shape.sizes.upper_arm * shape.up, shape.sizes.forearm * shape.along, _ZERO]
        for shape in shapes
    ]
    corners = np.vstack([*ends, *(list(shape.anchors.values()) for shape in shapes)])
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + 0.45 * margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()


def _name(axes: Axes, at: Points, text: str, toward: Points) -> None:
    """Name a point on the side that `toward` points to."""
    align = "left" if toward[0] > 0.3 else "right" if toward[0] < -0.3 else "center"
    upright = "bottom" if toward[1] > 0.3 else "top" if toward[1] < -0.3 else "center"
    axes.annotate(
        text,
        tuple(at),
        xytext=tuple(5.0 * toward),
        textcoords="offset points",
        ha=align,
        va=upright,
        size=7.0,
        bbox=_PAPER,
        zorder=2.2,
    )


def _degrees(angle: float) -> str:
    return f"{number(round(math.degrees(angle), 3))} deg"


def _dimension(axes: Axes, end: Points, text: str, shift: Points) -> None:
    """Measure from the elbow to `end`, the line moved by `shift`, with thin lines that lead to it."""
    for point in (_ZERO, end):
        _line(axes, point, point + shift * 1.04, color="#9a9a9a", linewidth=0.35, zorder=1.1)
    _arrow(axes, shift, end + shift, style="<|-|>")
    angle = math.degrees(math.atan2(end[1], end[0]))
    upright = -((90.0 - angle) % 180.0 - 90.0)  # text along the line is not upside down
    x, y = end / 2.0 + shift
    axes.text(
        x, y, text, rotation=upright, ha="center", va="center", size=6.5, bbox=_PAPER, zorder=6
    )


def _arrow(axes: Axes, start: Points, end: Points, *, style: str = "-|>", color: str = INK) -> None:
    axes.add_patch(
        FancyArrowPatch(
            tuple(start),
            tuple(end),
            arrowstyle=style,
            mutation_scale=4.5,
            linewidth=0.5,
            color=color,
            shrinkA=0.0,
            shrinkB=0.0,
            zorder=5,
        )
    )
