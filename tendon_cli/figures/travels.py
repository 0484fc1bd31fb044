"""A joint by its measured travels: how far each tendon moves over the angle, and the moment arms that follow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.labels import number
from tendon_cli.figures.engine import Line2D, Patch
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, house_style
from tendon_cli.space.axis import SIDES
from tendon_cli.studies.curves import curves_of
from tendon_cli.studies.study import Study

_POINTS = 361
_MOST_MARKS = 200
"""Measured values that are drawn one by one."""


def travels_page(study: Study, angles: Sequence[float] = ()) -> Page:
    """The travel of each tendon over the angle with what was measured, and its slope; `angles` (rad) are marked.

    Both travels are counted from the setting's angle, as the model counts them.
    """
    table: Any = study.joint.excursion
    curves, measured, origin = curves_of(study), table.angles, study.setting.angle.single
    span = np.linspace(measured[0], measured[-1], _POINTS)
    motion = np.degrees([study.motion.elbow_angle.array.min(), study.motion.elbow_angle.array.max()])
    joint = say.joint_word(study)
    noise = study.joint.smoothing.single if study.joint.smoothing is not None else 0.0
    smoothed = f", smoothed for a noise of {number(1e3 * noise)} mm" if noise else ", the curves go through them"
    notes = [f"{len(measured)} measured angles{smoothed}. Travels count from {number(np.degrees(origin))} deg."]
    key: list[Any] = [Line2D([], [], color=colour, label=side) for side, colour in zip(SIDES, OKABE_ITO, strict=False)]
    key += [Line2D([], [], color=INK, marker="o", markersize=2.5, linestyle="", label="measured")]
    key += [Patch(facecolor="#eceff2", label="motion of the study")]
    with house_style():
        page = framed(study.title or study.name, 76.0, key, notes, study=f"tendon study {study.name} {study.hash}")
        travel, arm = page.figure.subplots(1, 2)
        for side, colour in zip(SIDES, OKABE_ITO, strict=False):
            curve = curves[f"joint.{side}_excursion"]
            zero = float(curve(np.asarray(origin)))
            travel.plot(np.degrees(span), 1e3 * (curve(span) - zero), color=colour, gid="travel")
            if len(measured) <= _MOST_MARKS:
                values = 1e3 * (np.array(table.columns[side]) - zero)
                travel.plot(np.degrees(measured), values, "o", color=colour, markersize=2.5, gid="measured")
            arm.plot(np.degrees(span), 1e3 * curve(span, 1), color=colour, gid="moment arm")
        for axes, label in ((travel, "travel H (mm)"), (arm, "moment arm J = dH/dθ (mm)")):
            axes.axvspan(*motion, color="#eceff2", linewidth=0.0, zorder=0.3)
            axes.axhline(0.0, color=INK, linewidth=0.5)
            for angle in np.degrees(angles):
                axes.axvline(angle, color=FAINT, linewidth=0.6, linestyle=(0, (3, 2)))
            axes.set(xlabel=f"{joint} angle θ (deg)", ylabel=label, xlim=np.degrees(span[[0, -1]]))
            axes.yaxis.set_major_formatter(plain_numbers())
    return page
