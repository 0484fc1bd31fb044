"""The arm of a study as points in its plane of motion (Fig. 2).

x points forward and y up, the elbow is at the origin, and lengths are in mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Anchors, flexor_path
from tendon_cli.studies.space.axis import CASE_AXIS
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.spaces import axis_of, row_axes, row_place, single_numbers
from tendon_cli.studies.study import Study

Points = npt.NDArray[np.float64]

_ARC_STEP = 0.02
"""Angle between points of the extensor around the virtual pulley, rad."""
_ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
_NOT_LENGTHS = ("upper_arm_angle", "ratio")


@dataclass(frozen=True)
class ArmSizes:
    """Sizes of the arm and the spool that are drawn: lengths in mm, angles in rad."""

    anchors: Anchors
    forearm_com: float
    load_distance: float
    upper_arm_angle: float
    flexor_radius: float
    ratio: float
    remarks: tuple[str, ...]
    """Sentences that say which values are drawn if the study has several."""

    @property
    def upper_arm(self) -> float:
        """Length of the upper arm as drawn, mm; the model does not know the real one."""
        return 1.3 * float(self.anchors.b1)

    @property
    def forearm(self) -> float:
        """Length of the forearm and hand as drawn, mm."""
        return max(self.load_distance, self.forearm_com, float(self.anchors.b2)) * 1.04


class ArmShape:
    """The arm at one elbow angle.

    Args:
        sizes: Sizes of the arm.
        elbow_angle: Elbow angle, rad.

    Attributes:
        up: Unit vector from the elbow along the upper arm.
        front: Unit vector out of the front of the upper arm.
        along: Unit vector from the elbow along the forearm.
        forearm_front: Unit vector out of the front of the forearm.
        anchors: Points p, q, r and s of Fig. 2, mm.
        moment_arm_foot: Foot of the perpendicular from the elbow to the flexor's line, mm.
        moment_arm: Moment arm of the flexor, mm.
        flexor_path: Distance between the flexor's anchors, mm.
    """

    def __init__(self, sizes: ArmSizes, elbow_angle: float) -> None:
        joint = sizes.anchors
        lean = sizes.upper_arm_angle
        self.sizes = sizes
        self.elbow_angle = elbow_angle
        self.up = _direction(lean + math.pi / 2.0)
        self.front = _direction(lean)
        self.along = _direction(lean + elbow_angle - math.pi / 2.0)
        self.forearm_front = _direction(lean + elbow_angle)
        p = joint.b2 * self.along
        s = joint.b1 * self.up
        q = p + joint.a2 * self.forearm_front
        r = s + joint.a1 * self.front
        self.anchors: dict[str, Points] = {"p": p, "q": q, "r": r, "s": s}
        flexor = r - q
        length_squared = float(flexor @ flexor)
        projection = float(q @ flexor)
        self.moment_arm_foot: Points = q - flexor * projection / (length_squared or 1.0)
        self.moment_arm = float(joint.motion(elbow_angle).flexor_moment_arm)
        self.flexor_path = float(flexor_path(joint, elbow_angle))

    @property
    def extensor(self) -> Points:
        """Points of the extensor tendon (points, 2), mm.

        It runs down the back of the upper arm, around the virtual pulley and along the forearm.
        If the elbow is not flexed, it turns in one corner instead.
        """
        radius = float(self.sizes.anchors.elbow_radius)
        lean = self.sizes.upper_arm_angle
        start = self.sizes.upper_arm * self.up - radius * self.front
        end = self.anchors["p"] - radius * self.forearm_front
        if self.elbow_angle <= 0.0:
            bisector = _direction(lean + self.elbow_angle / 2.0)
            corner = -radius / math.cos(self.elbow_angle / 2.0) * bisector
            return np.array([start, corner, end])
        steps = max(2, int(self.elbow_angle / _ARC_STEP))
        angles = lean + math.pi + np.linspace(0.0, self.elbow_angle, steps)
        arc = radius * np.stack((np.cos(angles), np.sin(angles)), axis=1)
        return np.vstack((start, arc, end))


def arm_sizes(study: Study, case: str | None = None) -> ArmSizes:
    """Return the sizes of the arm and spool of a study, or of one of its cases.

    If the study has several values of a size, the first is taken, and `remarks` says so.

    Raises:
        UsageError: The study does not have this case.
    """
    keys = {name: f"arm.{name}" for name in _ANCHORS}
    keys["forearm_com"] = "arm.forearm_com"
    keys["load_distance"] = "arm.load_distance"
    keys["upper_arm_angle"] = "arm.upper_arm_angle"
    keys["flexor_radius"] = "spool.flexor_radius"
    keys["ratio"] = "spool.ratio"
    axes = [axis_of(study, key) for key in study.axes if key in keys.values()]
    chosen = [axis for axis in row_axes(study) if case is not None and axis.key == CASE_AXIS]
    place = 0 if case is None else row_place(study, CASE_AXIS, case, "--case")
    space = Space((*chosen, *axes), single_numbers(study))
    first = (*[slice(place, place + 1)] * len(chosen), *[slice(0, 1)] * len(axes))
    sizes = {}
    for name, key in keys.items():
        value = np.asarray(space.number(key).within(first)).item()
        sizes[name] = value if name in _NOT_LENGTHS else 1e3 * value
    several = [axis.key for axis in axes if len(axis) > 1]
    remarks = []
    if several:
        remarks.append(f"The first of several values of {', '.join(several)} is drawn.")
    sizes_drawn = set(keys.values())
    for table in study.row_tables:
        if table.is_of_cases and case is None:
            remarks.append(
                "The cases may differ in what is drawn here: it is the study's common arm."
            )
        elif not table.is_of_cases and sizes_drawn.intersection(table.keys):
            remarks.append(f"The rows of {table.key} differ in what is drawn: it is none of them.")
    anchors = Anchors(*(sizes.pop(name) for name in _ANCHORS))
    return ArmSizes(anchors, **sizes, remarks=tuple(remarks))


def _direction(angle: float) -> Points:
    """Return the unit vector at an angle in rad from the x axis."""
    return np.array([math.cos(angle), math.sin(angle)])
