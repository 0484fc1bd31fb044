"""The arm of a study as points in the plane of motion (Fig. 2): x forward, y up, the elbow at the origin, in mm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.model.kinematics import Anchors, flexor_path
from tendon_cli.space.space import Space
from tendon_cli.studies.axes import case_axis, number_axis, single_numbers
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.study import Study
from tendon_cli.units import shorten

Points = npt.NDArray[np.float64]

_ARC_STEP = 0.02  # rad


@dataclass(frozen=True)
class ArmSizes:
    """What the drawing needs of a study: lengths in mm, angles in rad, masses in kg."""

    a1: float
    b1: float
    a2: float
    b2: float
    elbow_radius: float
    forearm_com: float
    load_distance: float
    upper_arm_angle: float
    flexor_radius: float
    ratio: float
    remarks: tuple[str, ...]
    """Which of several values of the study is drawn."""

    @property
    def extensor_radius(self) -> float:
        """R_e = η R_f."""
        return self.ratio * self.flexor_radius

    @property
    def anchors(self) -> Anchors:
        """What the model takes, still in mm."""
        return Anchors(self.a1, self.b1, self.a2, self.b2, self.elbow_radius)

    @property
    def upper_arm(self) -> float:
        """How much of the upper arm is drawn; the model does not know its length."""
        return 1.3 * self.b1

    @property
    def forearm(self) -> float:
        """How much of the forearm and hand is drawn."""
        return max(self.load_distance, self.forearm_com, self.b2) * 1.04


@dataclass(frozen=True)
class ArmShape:
    """The arm at one elbow angle."""

    sizes: ArmSizes
    elbow_angle: float

    @property
    def up(self) -> Points:
        """Along the upper arm, from the elbow to the shoulder."""
        return _direction(self.sizes.upper_arm_angle + math.pi / 2.0)

    @property
    def front(self) -> Points:
        """At a right angle to the upper arm, forward."""
        return _direction(self.sizes.upper_arm_angle)

    @property
    def along(self) -> Points:
        """Along the forearm, from the elbow to the hand."""
        return _direction(self._forearm_angle - math.pi / 2.0)

    @property
    def forearm_front(self) -> Points:
        """At a right angle to the forearm, on the flexor's side."""
        return _direction(self._forearm_angle)

    @property
    def anchors(self) -> dict[str, Points]:
        """The points p, q, r and s of Fig. 2."""
        p, s = self.sizes.b2 * self.along, self.sizes.b1 * self.up
        return {"p": p, "q": p + self.sizes.a2 * self.forearm_front, "r": s + self.sizes.a1 * self.front, "s": s}

    @property
    def extensor(self) -> Points:
        """The extensor tendon: down the back of the upper arm, around the virtual pulley, along the forearm."""
        radius = self.sizes.elbow_radius
        start = self.sizes.upper_arm * self.up - radius * self.front
        end = self.sizes.b2 * self.along - radius * self.forearm_front
        if self.elbow_angle <= 0.0:
            bisector = _direction(self.sizes.upper_arm_angle + self.elbow_angle / 2.0)
            return np.array([start, -radius / math.cos(self.elbow_angle / 2.0) * bisector, end])
        steps = max(2, int(self.elbow_angle / _ARC_STEP))
        angles = self.sizes.upper_arm_angle + math.pi + np.linspace(0.0, self.elbow_angle, steps)
        arc = radius * np.stack((np.cos(angles), np.sin(angles)), axis=1)
        return np.vstack((start, arc, end))

    @property
    def moment_arm(self) -> float:
        """J at this angle, mm; the distance of the flexor's line from the elbow where it is in front of it."""
        return float(self.sizes.anchors.motion(self.elbow_angle).flexor_moment_arm)

    @property
    def flexor_path(self) -> float:
        """L_c at this angle, mm."""
        return float(flexor_path(self.sizes.anchors, self.elbow_angle))

    @property
    def moment_arm_foot(self) -> Points:
        """Where the perpendicular from the elbow meets the flexor's line."""
        q, r = self.anchors["q"], self.anchors["r"]
        line = r - q
        length = float(line @ line)
        return q if length == 0.0 else q - line * float(q @ line) / length

    @property
    def _forearm_angle(self) -> float:
        return self.sizes.upper_arm_angle + self.elbow_angle


def arm_sizes(study: Study, case: str | None = None) -> ArmSizes:
    """The sizes of a study's arm and spool, or of one of its cases; of an axis the first value, as `remarks` says.

    Raises UsageError for a case that the study does not have.
    """
    if study.joint.excursion is not None:
        hint = "tendon plot RUN -y flexor_travel draws its curves"
        raise UsageError("the study has its joint's travels, so there are no anchors to draw", where="--arm", hint=hint)
    keys = {name: f"arm.{name}" for name in ("a1", "b1", "a2", "b2", "elbow_radius", "forearm_com", "load_distance")}
    keys |= {"upper_arm_angle": "arm.upper_arm_angle", "flexor_radius": "spool.flexor_radius", "ratio": "spool.ratio"}
    chosen = chosen_case(study, case)
    axes = [number_axis(study, key) for key in study.axes if key in keys.values()]
    cases = [case_axis(study)] if chosen is not None else []
    space = Space((*cases, *axes), single_numbers(study))
    at = study.cases.index(chosen) if chosen is not None else 0
    first = tuple(slice(at, at + 1) if axis in cases else slice(0, 1) for axis in space.axes)
    sizes, remarks = {}, []
    for name, key in keys.items():
        values = space.number(key)
        sizes[name] = np.asarray(values.within(first)).item() * (1.0 if name in ("upper_arm_angle", "ratio") else 1e3)
        remarks += [
            f"{key} has {space.shape[axis]} values, the first is drawn."
            for axis in values.axes if space.axes[axis] in axes and space.shape[axis] > 1
        ]  # fmt: skip
    if study.cases and chosen is None:
        remarks.append("The cases may differ in what is drawn here: it is the study's common arm.")
    return ArmSizes(**sizes, remarks=tuple(remarks))


def chosen_case(study: Study, case: str | None) -> Any:
    """The case of this name, or none; raises UsageError where the study has no such case."""
    if case is None:
        return None
    names = [getattr(each, "name", "") for each in study.cases]
    if case not in names:
        listed = f"cases: {', '.join(names[:20])}" if names else "the study has no [[cases]]"
        hint = nearest(case, names) or listed
        raise UsageError(f'there is no case "{shorten(case)}"', where="--case", hint=hint)
    return study.cases[names.index(case)]


def _direction(angle: float) -> Points:
    return np.array([math.cos(angle), math.sin(angle)])
