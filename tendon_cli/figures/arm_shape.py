"""The arm of a study as points in the plane of motion (Fig. 2): x forward, y up, the elbow at the origin, in mm."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Anchors, flexor_path
from tendon_cli.space.space import Space
from tendon_cli.studies.spaces import axis_of, case_axis, case_place, single_numbers
from tendon_cli.studies.study import Study

Points = npt.NDArray[np.float64]

_ARC_STEP = 0.02  # rad
_ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")


@dataclass(frozen=True)
class ArmSizes:
    """What the drawing needs of a study: lengths in mm, angles in rad."""

    anchors: Anchors
    forearm_com: float
    load_distance: float
    upper_arm_angle: float
    flexor_radius: float
    ratio: float
    remarks: tuple[str, ...]
    """Which of several values of the study is drawn."""

    @property
    def upper_arm(self) -> float:
        """How much of the upper arm is drawn; the model does not know its length."""
        return 1.3 * float(self.anchors.b1)

    @property
    def forearm(self) -> float:
        """How much of the forearm and hand is drawn."""
        return max(self.load_distance, self.forearm_com, float(self.anchors.b2)) * 1.04


class ArmShape:
    """The arm at one elbow angle (rad): directions and points."""

    def __init__(self, sizes: ArmSizes, elbow_angle: float) -> None:
        self.sizes, self.elbow_angle, joint = sizes, elbow_angle, sizes.anchors
        lean = sizes.upper_arm_angle
        self.up, self.front = _direction(lean + math.pi / 2.0), _direction(lean)
        self.along, self.forearm_front = (
            _direction(lean + elbow_angle - math.pi / 2.0),
            _direction(lean + elbow_angle),
        )
        p, s = joint.b2 * self.along, joint.b1 * self.up
        q, r = p + joint.a2 * self.forearm_front, s + joint.a1 * self.front
        self.anchors: dict[str, Points] = {"p": p, "q": q, "r": r, "s": s}
        """The points of Fig. 2."""
        length = float((r - q) @ (r - q))
        self.moment_arm_foot: Points = q - (r - q) * float(q @ (r - q)) / (length or 1.0)
        """Where the perpendicular from the elbow meets the flexor's line."""
        self.moment_arm = float(joint.motion(elbow_angle).flexor_moment_arm)
        self.flexor_path = float(flexor_path(joint, elbow_angle))

    @property
    def extensor(self) -> Points:
        """The extensor tendon: down the back of the upper arm, around the virtual pulley, along the forearm."""
        radius, lean = float(self.sizes.anchors.elbow_radius), self.sizes.upper_arm_angle
        start, end = (
            line - radius * front
            for line, front in (
                (self.sizes.upper_arm * self.up, self.front),
                (self.anchors["p"], self.forearm_front),
            )
        )
        if self.elbow_angle <= 0.0:
            bisector = _direction(lean + self.elbow_angle / 2.0)
            return np.array([start, -radius / math.cos(self.elbow_angle / 2.0) * bisector, end])
        angles = (
            lean
            + math.pi
            + np.linspace(0.0, self.elbow_angle, max(2, int(self.elbow_angle / _ARC_STEP)))
        )
        return np.vstack((start, radius * np.stack((np.cos(angles), np.sin(angles)), axis=1), end))


def arm_sizes(study: Study, case: str | None = None) -> ArmSizes:
    """The sizes of a study's arm and spool, or of one of its cases; of an axis the first value, as `remarks` says.

    Raises UsageError for a case that the study does not have.
    """
    keys = {
        name: f"arm.{name}"
        for name in (*_ANCHORS, "forearm_com", "load_distance", "upper_arm_angle")
    }
    keys |= {"flexor_radius": "spool.flexor_radius", "ratio": "spool.ratio"}
    at = None if case is None else case_place(study, case)
    axes = [axis_of(study, key) for key in study.axes if key in keys.values()]
    cases = [case_axis(study)] if at is not None else []
    space = Space((*cases, *axes), single_numbers(study))
    first = tuple(
        slice(at, at + 1) if at is not None and axis in cases else slice(0, 1)
        for axis in space.axes
    )
    sizes = {name: np.asarray(space.number(key).within(first)).item() for name, key in keys.items()}
    sizes |= {
        name: 1e3 * value
        for name, value in sizes.items()
        if name not in ("upper_arm_angle", "ratio")
    }
    several = [axis.key for axis in axes if len(axis) > 1]
    remarks = [f"The first of several values of {', '.join(several)} is drawn."] if several else []
    if study.cases and at is None:
        remarks.append("The cases may differ in what is drawn here: it is the study's common arm.")
    anchors = Anchors(*(sizes.pop(name) for name in _ANCHORS))
    return ArmSizes(anchors, **sizes, remarks=tuple(remarks))


def _direction(angle: float) -> Points:
    return np.array([math.cos(angle), math.sin(angle)])
