"""The joint of a study: its arm drawn to scale (Fig. 2), or its measured travels over the angle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.labels import number
from tendon_cli.figures.arm_shape import ArmShape, ArmSizes, Points, arm_sizes
from tendon_cli.figures.backend import Arc, Axes, Circle, FancyArrowPatch, Patch
from tendon_cli.figures.frame import Page, framed, source_of_study
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, house_style, key_line
from tendon_cli.quantities import SIDES
from tendon_cli.studies.space.axis import evenly_spaced
from tendon_cli.studies.study import Study
from tendon_cli.studies.study_curves import curves_of

FLEXOR, EXTENSOR = OKABE_ITO[:2]
_MOST_ANGLES = 5
"""Largest number of elbow angles at which the arm is drawn."""
_DIMENSIONS_ANGLE = math.radians(70.0)
"""Dimensions are drawn at the elbow angle nearest to this one, rad."""
_STRAIGHT = math.cos(math.radians(20.0))
"""Cosine of the angle between both limbs up to which an arm counts as straight."""
_MOTION = "#eceff2"
_NO_BALANCE = "#b00020"
_MEANING = (
    "To scale. J is the moment arm of the flexor, "
    "$L_c$ the distance of its anchors q and r (Eq. 1)."
)
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
    """Draw the arm of a study with its dimensions, its spools, and the arm at each angle.

    A joint that is given by its measured travels has no anchors to draw. Its two curves over the
    angle are drawn instead.

    Args:
        study: The study.
        elbow_angles: Elbow angles to draw, rad; by default some of the study's.
        case: Name of one of the study's cases; by default the arm common to all.

    Raises:
        UsageError: The study does not have this case.
    """
    if study.joint.excursion is not None:
        return _travels_page(study, elbow_angles)
    sizes = arm_sizes(study, case)
    study_angles = study.motion.elbow_angle.array
    angles = list(elbow_angles)
    if not angles:
        angles = [float(study_angles[place]) for place in evenly_spaced(len(study_angles), 4)]
    remarks = list(sizes.remarks)
    if len(angles) > _MOST_ANGLES:
        shown = f"{_MOST_ANGLES} of {len(angles)} elbow angles"
        remarks.append(f"Shown: {shown}, evenly spaced.")
        angles = [angles[place] for place in evenly_spaced(len(angles), _MOST_ANGLES)]
    names = (study.title or study.name, case)
    title = ", ".join(name for name in names if name)
    key = [
        key_line(color=FLEXOR, linewidth=1.6, label="flexor tendon (dashed: in its sheath)"),
        key_line(color=EXTENSOR, linewidth=1.6, label="extensor tendon"),
        key_line(label="virtual pulley", **_PULLEY),
        key_line(marker="P", markersize=5.0, label="centre of mass", **_WHITE),
        key_line(label="load", **_LOAD),
    ]
    with house_style():
        page = framed(title, 165.0, key, (_MEANING, *remarks), study=source_of_study(study))
        grid = page.figure.add_gridspec(2, 1, height_ratios=(1.75, 1.0))
        upper = grid[0].subgridspec(1, 2, width_ratios=(2.4, 1.0))
        lower = grid[1].subgridspec(1, len(angles))
        measured = min(angles, key=lambda angle: abs(angle - _DIMENSIONS_ANGLE))
        _draw_dimensions(page.figure.add_subplot(upper[0]), ArmShape(sizes, measured))
        _draw_spools(page.figure.add_subplot(upper[1]), sizes)
        shapes = [ArmShape(sizes, angle) for angle in angles]
        for place, shape in enumerate(shapes):
            axes = page.figure.add_subplot(lower[place])
            _draw_posture(axes, shape)
            # All postures are drawn to one scale.
            _set_limits(axes, *shapes, margin=1.3 * float(sizes.anchors.elbow_radius))
    return page


def _travels_page(study: Study, angles: Sequence[float]) -> Page:
    """Draw the travel of each tendon over the angle with its measured points, and its moment arm.

    Both travels are counted from the angle of the setting, as in the model. `angles` (rad) are
    marked.
    """
    table: Any = study.joint.excursion
    curves = curves_of(study)
    measured = table.angles
    origin = study.setting.angle.single
    span = np.linspace(measured[0], measured[-1], 361)
    is_smoothed = study.joint.smoothing is not None and study.joint.smoothing.single
    smoothed = ", smoothed" if is_smoothed else ""
    notes = [f"{len(measured)} measured angles{smoothed}. Travels count from {_degrees(origin)}."]
    colours = dict(zip(SIDES, OKABE_ITO, strict=False))
    key: list[Any] = [
        *(key_line(color=colour, label=side) for side, colour in colours.items()),
        key_line(color=INK, marker="o", markersize=2.5, linestyle="", label="measured"),
        Patch(facecolor=_MOTION, label="motion of the study"),
    ]
    with house_style():
        page = framed(study.title or study.name, 76.0, key, notes, study=source_of_study(study))
        travel, arm = page.figure.subplots(1, 2)
        degrees = np.degrees(span)
        for side, colour in colours.items():
            curve = curves[f"joint.{side}_excursion"]
            zero = float(curve(np.asarray(origin)))
            points = 1e3 * (np.array(table.columns[side]) - zero)
            travel.plot(degrees, 1e3 * (curve(span) - zero), color=colour, gid="travel")
            travel.plot(
                np.degrees(measured), points, "o", color=colour, markersize=2.5, gid="measured"
            )
            arm.plot(degrees, 1e3 * curve(span, 1), color=colour, gid="moment arm")
        motion = study.motion.elbow_angle.array
        for axes, label in ((travel, "travel H (mm)"), (arm, "moment arm J = dH/dθ (mm)")):
            first, last = np.degrees([motion.min(), motion.max()])
            axes.axvspan(first, last, color=_MOTION, linewidth=0.0, zorder=0.3)
            axes.axhline(0.0, color=INK, linewidth=0.5)
            for angle in np.degrees(angles):
                axes.axvline(angle, color=FAINT, linewidth=0.6, linestyle=(0, (3, 2)))
            axes.set_xlabel(f"{say.joint_name(study)} angle θ (deg)")
            axes.set_ylabel(label)
            axes.set_xlim(degrees[0], degrees[-1])
    return page


def _line(axes: Axes, *points: Points, **style: Any) -> None:
    """Plot a line through points."""
    axes.plot(*np.array(points).T, **style)


def _draw_limbs(axes: Axes, shape: ArmShape, width: float) -> None:
    """Draw bones, virtual pulley, tendons and anchors; the tendons are `width` pt wide."""
    sizes = shape.sizes
    points = shape.anchors
    bones = (sizes.upper_arm * shape.up, _ZERO, sizes.forearm * shape.along)
    _line(
        axes,
        *bones,
        linewidth=9.0 * width,
        zorder=0.5,
        gid="limb",
        color="#eadfd3",
        solid_joinstyle="round",
    )
    _line(axes, *bones, color="#8c7b6b", linewidth=0.8, zorder=1, gid="bones")
    radius = float(sizes.anchors.elbow_radius)
    axes.add_patch(Circle((0.0, 0.0), radius, fill=False, zorder=1.5, gid="pulley", **_PULLEY))
    _line(axes, *shape.extensor, color=EXTENSOR, linewidth=width, zorder=2, gid="extensor")
    _line(axes, points["r"], points["q"], color=FLEXOR, linewidth=width, zorder=2, gid="flexor")
    sheath = (points["r"], points["r"] + (sizes.upper_arm - sizes.anchors.b1) * shape.up)
    _line(axes, *sheath, color=FLEXOR, linewidth=width, linestyle=(0, (2.0, 1.0)), zorder=2)
    _line(axes, points["r"], points["s"], color=INK, linewidth=0.7, zorder=2.5)
    _line(axes, points["p"], points["q"], color=INK, linewidth=0.7, zorder=2.5)
    _line(
        axes,
        *points.values(),
        color=INK,
        zorder=3,
        gid="anchors",
        marker="o",
        markersize=2.2 * width**0.5,
        linestyle="none",
    )
    axes.plot(0.0, 0.0, marker="o", markersize=4.0, zorder=3, **_WHITE)
    axes.plot(*sizes.forearm_com * shape.along, marker="P", markersize=5.0, zorder=3, **_WHITE)
    axes.plot(*sizes.load_distance * shape.along, zorder=3, gid="load", **_LOAD)


def _draw_dimensions(axes: Axes, shape: ArmShape) -> None:
    """Draw the arm with its dimensions."""
    sizes = shape.sizes
    joint = sizes.anchors
    points = shape.anchors
    foot = shape.moment_arm_foot
    radius = float(joint.elbow_radius)
    _draw_limbs(axes, shape, 1.6)
    _line(axes, _ZERO, foot, color=FLEXOR, linewidth=0.7, linestyle=(0, (1.5, 1.2)), zorder=2)
    _name_point(axes, foot / 2.0, "J", 0.5 * shape.forearm_front, FLEXOR)
    step = 0.055 * (sizes.upper_arm + sizes.forearm)
    back = -shape.front
    under = -shape.forearm_front
    first = radius + step
    _draw_dimension(axes, points["s"], f"b₁ = {number(float(joint.b1))} mm", first * back)
    lengths = {
        "b₂": float(joint.b2),
        "$d_{com}$": sizes.forearm_com,
        "$d_{load}$": sizes.load_distance,
    }
    # On a straight arm the lengths of both limbs would stand in one line.
    is_straight = float(shape.up @ -shape.along) > _STRAIGHT
    levels = len(lengths) + is_straight
    for level, (name, length) in enumerate(lengths.items(), start=int(is_straight)):
        text = f"{name} = {number(length)} mm"
        _draw_dimension(axes, length * shape.along, text, (first + level * step) * under)
    outward = (2.0 * shape.along - under) / 5**0.5
    _name_point(axes, points["r"], f"r   a₁ = {number(float(joint.a1))} mm", shape.front)
    _name_point(axes, points["q"], f"q   a₂ = {number(float(joint.a2))} mm", outward)
    _name_point(axes, points["s"], "s", back)
    _name_point(axes, points["p"], "p", under)
    corner = shape.front if is_straight else (back + under) / np.linalg.norm(back + under)
    _draw_arrow(axes, _ZERO, radius * corner, color=EXTENSOR)
    name = f"$R_{{elb}}$ = {number(radius)} mm"
    _name_point(axes, radius * corner, name, 2.0 * corner, EXTENSOR)
    straight = 0.42 * float(joint.b2)
    thin: dict[str, Any] = {"color": FAINT, "linewidth": 0.6, "linestyle": "dashed"}
    _line(axes, _ZERO, -1.25 * straight * shape.up, **thin)
    lean = math.degrees(sizes.upper_arm_angle)
    _draw_angle(axes, "θ", straight, 0.84 * straight, lean - 90.0, shape.elbow_angle)
    title = f"dimensions, drawn at θ = {_degrees(shape.elbow_angle)}"
    if sizes.upper_arm_angle:
        title = f"{title}, ψ = {_degrees(sizes.upper_arm_angle)}"
        b1 = float(joint.b1)
        _line(axes, _ZERO, np.array([0.0, 0.7 * joint.b1]), **thin)
        _draw_angle(axes, "ψ", 0.6 * b1, 0.68 * b1, 90.0, sizes.upper_arm_angle)
    _set_limits(axes, shape, margin=first + (levels + 0.2) * step)
    axes.set_title(title)


def _draw_angle(
    axes: Axes, text: str, radius: float, distance: float, start: float, angle: float
) -> None:
    """Draw an angle as an arc around the elbow, and name it.

    Args:
        axes: The panel.
        text: Name of the angle.
        radius: Radius of the arc, mm.
        distance: Distance of the name from the elbow, mm.
        start: Direction in which the angle begins, deg.
        angle: The angle, rad.
    """
    low, high = sorted((start, start + math.degrees(angle)))
    size = 2 * radius
    axes.add_patch(Arc((0.0, 0.0), size, size, theta1=low, theta2=high, color=FAINT, linewidth=0.6))
    middle = math.radians(start) + angle / 2.0
    x = distance * math.cos(middle)
    y = distance * math.sin(middle)
    axes.text(x, y, text, ha="center", va="center", bbox=_PAPER, zorder=4)


def _draw_posture(axes: Axes, shape: ArmShape) -> None:
    """Draw the arm at one angle, and write the flexor's moment arm and path length above it."""
    _draw_limbs(axes, shape, 0.8)
    if shape.moment_arm > 0.0:
        text = f"J = {number(round(shape.moment_arm, 1))} mm"
        colour = INK
    else:
        text = "J ≤ 0: no equilibrium"
        colour = _NO_BALANCE
    axes.set_title(f"θ = {_degrees(shape.elbow_angle)}", pad=18.0)
    axes.text(
        0.5,
        1.0,
        f"{text}\n$L_c$ = {number(round(shape.flexor_path, 1))} mm",
        transform=axes.transAxes,
        ha="center",
        va="bottom",
        size=6.2,
        color=colour,
    )


def _draw_spools(axes: Axes, sizes: ArmSizes) -> None:
    """Draw both parts of the spool, one above the other, with the tendons that leave them.

    The tendons leave on opposite sides.
    """
    extensor_radius = sizes.ratio * sizes.flexor_radius
    largest = max(sizes.flexor_radius, extensor_radius)
    below = np.array([0.0, -2.9 * largest])
    _draw_spool(axes, _ZERO, sizes.flexor_radius, "flexor", FLEXOR, side=1.0, largest=largest)
    _draw_spool(axes, below, extensor_radius, "extensor", EXTENSOR, side=-1.0, largest=largest)
    axes.set_xlim(-1.3 * largest, 2.5 * largest)
    axes.set_ylim(-4.4 * largest, 1.6 * largest)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"spools, η = $R_e$ / $R_f$ = {number(sizes.ratio)}")


def _draw_spool(
    axes: Axes,
    centre: Points,
    radius: float,
    name: str,
    colour: str,
    *,
    side: float,
    largest: float,
) -> None:
    """Draw one part of the spool; its tendon leaves it on top if `side` is 1, below if it is -1."""
    axes.add_patch(
        Circle(
            tuple(centre), radius, gid="spool", facecolor="#f4f4f4", edgecolor=colour, linewidth=1.6
        )
    )
    tangent = centre + np.array([0.0, side * radius])
    end = tangent + np.array([2.2 * largest, 0.0])
    _line(axes, tangent, end, color=colour, linewidth=1.6)
    axes.plot(*centre, marker="o", markersize=3.0, color=INK)
    _draw_arrow(axes, centre, centre + radius * np.array([math.cos(2.5), math.sin(2.5)]))
    label = f"$R_{{{name[0]}}}$ = {number(radius)} mm"
    _name_point(axes, centre - np.array([0.0, side * radius]), label, np.array([0.0, -side]))
    vertical = "bottom" if side > 0 else "top"
    axes.text(end[0], end[1], name, color=colour, size=7.0, ha="right", va=vertical)


def _set_limits(axes: Axes, *shapes: ArmShape, margin: float) -> None:
    """Set equal scales and limits around all shapes, and hide the axes."""
    corners = []
    for shape in shapes:
        corners += [shape.sizes.upper_arm * shape.up, shape.sizes.forearm * shape.along, _ZERO]
        corners += shape.anchors.values()
    points = np.vstack(corners)
    low = points.min(axis=0) - margin
    high = points.max(axis=0) + 0.45 * margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()


def _name_point(axes: Axes, point: Points, text: str, toward: Points, color: str = INK) -> None:
    """Write a text next to a point, on the side to which the vector `toward` points."""
    across, up = (int(part > 0.3) - int(part < -0.3) for part in toward)
    axes.annotate(
        text,
        tuple(point),
        xytext=tuple(5.0 * toward),
        textcoords="offset points",
        color=color,
        ha=("center", "left", "right")[across],
        va=("center", "bottom", "top")[up],
        size=7.0,
        bbox=_PAPER,
        zorder=2.2,
    )


def _degrees(angle: float) -> str:
    """Write an angle, given in rad, in degrees."""
    return f"{number(round(math.degrees(angle), 3))} deg"


def _draw_dimension(axes: Axes, end: Points, text: str, shift: Points) -> None:
    """Draw a dimension line from the elbow to `end`, moved by `shift`, with extension lines, mm."""
    for point in (_ZERO, end):
        _line(axes, point, point + shift * 1.04, color="#9a9a9a", linewidth=0.35, zorder=1.1)
    _draw_arrow(axes, shift, end + shift, style="<|-|>")
    angle = math.degrees(math.atan2(end[1], end[0]))
    rotation = -((90.0 - angle) % 180.0 - 90.0)  # deg, so that no text is upside down
    x, y = end / 2.0 + shift
    axes.text(
        x, y, text, rotation=rotation, size=6.5, zorder=6, ha="center", va="center", bbox=_PAPER
    )


def _draw_arrow(
    axes: Axes, start: Points, end: Points, *, style: str = "-|>", color: str = INK
) -> None:
    """Draw an arrow from `start` to `end`, mm."""
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
