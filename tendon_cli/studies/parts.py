"""Tables of a study file, from arm to output.

Defaults are the paper's baseline, unilateral and without load.
"""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints

from tendon_cli.quantities import OF_STATES
from tendon_cli.studies.angle_curves import EXCURSION, TORQUE, TRAJECTORY, BendNumber, CurveTable
from tendon_cli.studies.fields import OneOf, Single, fault, nearest, one_or_many
from tendon_cli.studies.number import Number
from tendon_cli.studies.values import RIGID, Values
from tendon_cli.units import shorten

Direction = Literal["flexion", "extension"]
Name = Annotated[
    str, StringConstraints(pattern=r"^\.*[A-Za-z0-9_-][A-Za-z0-9._-]*$", max_length=64, strict=True)
]
"""Name of a folder or a file."""
FileName = Annotated[str, StringConstraints(min_length=1, max_length=4096, strict=True)]
"""Path of a file, from the folder of the study."""

# Wide enough for any actuator that could be built, narrow enough that no formula overflows.
LENGTH = {"low": 0.0, "high": 100.0}
POSITIVE_LENGTH = {"low": 1e-6, "high": 100.0}
FULL_TURNS = {"low": -6.283185307179587, "high": 6.283185307179587}

Friction = Annotated[Values, Number("friction", 0.0, 10.0)]
BendAngle = Annotated[Values | CurveTable, BendNumber("bend_angle", 0.0, 100.0)]
TendonLength = Annotated[Values, Number("tendon_length", **POSITIVE_LENGTH)]
TendonDiameter = Annotated[Values, Number("tendon_diameter", 1e-6, 1.0)]
YoungsModulus = Annotated[Values, Number("youngs_modulus", 1e3, 1e15)]
Pretension = Annotated[Values, Number("pretension", 0.0, 1e7)]
Stiffness = Annotated[Values, Number("spring_stiffness", 1e-3, 1e12, word=RIGID)]
AnchorStiffness = Annotated[Values, Number("anchor_stiffness", 1e-3, 1e12, word=RIGID)]
BodyDimension = Literal[
    "stature",
    "weight",
    "acromion_radiale_length",
    "radiale_stylion_length",
    "forearm_grip_length",
    "biceps_circumference",
    "forearm_circumference",
    "wrist_circumference",
]
SpringPlace = Annotated[str | tuple[str, ...] | None, OneOf(("joint", "motor"))]

usual: Any = Field
"""Field whose default is as a study file would say it; the field's validator reads it."""


def _check_state_columns(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return names of results of the states; refuse any other.

    Columns that say which state a row is are always kept, and refused, too.
    """
    for name in names:
        if name in ("design", "direction", "elbow_angle"):
            raise fault(f'"{name}" says which state a row is, and is always kept', "leave it out")
        if name != "status" and name not in OF_STATES:
            hint = nearest(name, ("status", *OF_STATES))
            raise fault(f'"{shorten(name)}" is not a result of the states', hint)
    return names


Words = Annotated[
    tuple[Annotated[str, StringConstraints(strict=True, min_length=1, max_length=100)], ...],
    *one_or_many({"type": "string", "minLength": 1, "maxLength": 100}, least=0, each_once=True),
]
"""One word or a list of them, such as columns; the study checks which words are possible."""
Directions = Annotated[tuple[Direction, ...], OneOf(("flexion", "extension"), is_list=True)]
Tables = Annotated[
    tuple[Literal["designs", "states"], ...], OneOf(("designs", "states"), is_list=True)
]
StateColumns = Annotated[
    tuple[str, ...],
    *one_or_many({"enum": ["status", *OF_STATES]}, each_once=True),
    Field(min_length=1),
    AfterValidator(_check_state_columns),
]


class Part(BaseModel):
    """Table of a study file: unknown keys are refused, and nothing changes after it is read."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, validate_default=True, arbitrary_types_allowed=True
    )


class Arm(Part):
    """Arm (Fig. 2) and its weight."""

    a1: Annotated[Values, Number("a1", **LENGTH)] = usual("40 mm")
    b1: Annotated[Values, Number("b1", **POSITIVE_LENGTH)] = usual("150 mm")
    a2: Annotated[Values, Number("a2", **LENGTH)] = usual("20 mm")
    b2: Annotated[Values, Number("b2", **POSITIVE_LENGTH)] = usual("150 mm")
    elbow_radius: Annotated[Values, Number("elbow_radius", **POSITIVE_LENGTH)] = usual("45 mm")
    forearm_mass: Annotated[Values, Number("forearm_mass", 0.0, 1e4)] = usual("1.54 kg")
    forearm_com: Annotated[Values, Number("forearm_com", **LENGTH)] = usual("174 mm")
    load_distance: Annotated[Values, Number("load_distance", **LENGTH)] = usual("320 mm")
    upper_arm_angle: Annotated[Values, Number("upper_arm_angle", **FULL_TURNS)] = usual("0 deg")
    contact_width: Annotated[Values | None, Number("contact_width", **POSITIVE_LENGTH)] = None
    contact_radius: Annotated[Values | None, Number("contact_radius", **POSITIVE_LENGTH)] = None


class SheathSide(Part):
    """Sheath on one side of the arm; a key left out is as for both."""

    friction: Friction | None = None
    friction_from: FileName | None = usual(
        None, description="a file written by `tendon fit-friction --out`"
    )
    bend_angle: BendAngle | None = None
    path: FileName | None = usual(
        None, description="a CSV of way-points x, y, z of the routed sheath, in m"
    )
    path_smoothing: Annotated[Values | None, Single("path_smoothing", 0.0, 1.0)] = None


class Sheath(SheathSide):
    """Sheaths of both tendons."""

    friction: Friction | None = usual(0.07)
    bend_angle: BendAngle | None = usual("180 deg")
    flexor: SheathSide | None = None
    extensor: SheathSide | None = None


class TendonSide(Part):
    """Tendon on one side of the arm; a key left out is as for both."""

    length: TendonLength | None = None
    diameter: TendonDiameter | None = None
    youngs_modulus: YoungsModulus | None = None
    pretension: Pretension | None = None


class Tendon(TendonSide):
    """Tendons of both sides, of round cross-section."""

    length: TendonLength | None = usual("2 m")
    diameter: TendonDiameter | None = usual("1.5 mm")
    youngs_modulus: YoungsModulus | None = usual("145 GPa")
    pretension: Pretension | None = usual("100 N")
    flexor: TendonSide | None = None
    extensor: TendonSide | None = None


class SpringSide(Part):
    """Spring on one side of the arm; a key left out is as for both."""

    stiffness: Stiffness | None = None
    free_length: Annotated[Values | None, Number("spring_free_length", **LENGTH)] = None
    at: SpringPlace = usual(None, description="the end of the tendon that the spring sits at")


class Spring(SpringSide):
    """Series springs of both tendons, by default at their elbow ends."""

    stiffness: Stiffness | None = usual("3 kN/m")
    at: SpringPlace = usual("joint", description="the end of the tendon that the spring sits at")
    flexor: SpringSide | None = None
    extensor: SpringSide | None = None


class AnchorSide(Part):
    """Anchor on one side of the arm; a key left out is as for both."""

    stiffness: AnchorStiffness | None = None


class Anchor(AnchorSide):
    """Tissue and cuff behind the anchors of both tendons."""

    stiffness: AnchorStiffness | None = usual(RIGID)
    flexor: AnchorSide | None = None
    extensor: AnchorSide | None = None


class Joint(Part):
    """Joint that the suit moves: its name, the travels of its tendons, and its own torque."""

    name: Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z -]{0,30}$", strict=True)] = (
        usual("elbow", description="the joint's name in texts and figures")
    )
    excursion: Annotated[str | CurveTable | None, EXCURSION] = usual(
        None,
        description="a CSV of angle, flexor, extensor: how far their paths shorten and lengthen",
    )
    smoothing: Annotated[Values | None, Single("excursion_noise", 0.0, 0.1)] = None
    scale_with: BodyDimension | None = usual(
        None, description="with people: the dimension of the body that travels are in proportion to"
    )
    torque: Annotated[str | CurveTable | None, TORQUE] = usual(
        None,
        description="a CSV of angle, torque: what the joint itself asks for to be flexed further",
    )
    stiffness: Annotated[Values | None, Number("joint_stiffness", 0.0, 1e6)] = None
    rest_angle: Annotated[Values | None, Number("rest_angle", **FULL_TURNS)] = None


class Spool(Part):
    """Spool of the motor."""

    flexor_radius: Annotated[Values, Number("flexor_radius", **POSITIVE_LENGTH)] = usual("30 mm")
    ratio: Annotated[Values, Number("spool_ratio", 1e-3, 1e3)] = usual(1.0)


class Setting(Part):
    """Posture in which the pretension is set, and how it is read."""

    angle: Annotated[Values, Number("setting_angle", **FULL_TURNS)] = usual("0 deg")
    upper_arm_angle: Annotated[Values, Number("upper_arm_angle", **FULL_TURNS)] = usual("0 deg")
    load: Annotated[Values, Number("load_mass", 0.0, 1e4)] = usual("0 kg")
    after: Direction = usual(
        "extension", description="the direction of the last motion before it is read"
    )
    read: Literal[
        "pretension", "flexor at joint", "extensor at joint", "flexor at motor", "extensor at motor"
    ] = usual(
        "pretension",
        description="what a pretension of the study is: F0 of the model, or a gauge's reading",
    )


class Load(Part):
    """Load in the hand, and the torque of a task."""

    mass: Annotated[Values, Number("load_mass", 0.0, 1e4)] = usual("0 kg")
    torque: Annotated[str | CurveTable | None, TORQUE] = usual(
        None, description="a CSV of angle, torque: what a task asks for besides"
    )
    scale: Annotated[Values, Number("load_scale", -1e3, 1e3)] = usual(1.0)


class Motion(Part):
    """States that each design goes through."""

    direction: Directions = usual(
        ("flexion", "extension"), description="flexion, extension or both, in the order of the rows"
    )
    elbow_angle: Annotated[Values, Number("elbow_angle", **FULL_TURNS, uncertain=False)] = usual(
        {"from": "0 deg", "to": "90 deg", "num": 91}
    )
    speed: Annotated[Values | None, Single("speed", 1e-6, 1e3)] = None
    trajectory: Annotated[str | CurveTable | None, TRAJECTORY] = usual(
        None,
        description="a CSV of time, angle: a motion in time, instead of angles, directions and a "
        "speed",
    )
    cutoff: Annotated[Values | None, Single("cutoff", 1e-3, 1e4)] = None
    reversal: Annotated[Values | None, Single("reversal", 0.0, 3.2)] = None
    inertia: Annotated[Values | None, Single("inertia", 0.0, 1e3)] = None


class Model(Part):
    """Choices between two readings of the model."""

    slack: Literal["unilateral", "bilateral"] = usual(
        "unilateral",
        description="unilateral: a tendon cannot push; bilateral: negative tension, as in the "
        "paper",
    )
    reference: Literal["published", "initial"] = usual(
        "published",
        description="flexor travel from b1 + b2, as published, or from the path length at 0 "
        "degrees",
    )


class Output(Part):
    """Tables and columns that are written."""

    tables: Tables = usual(("designs", "states"), description="which tables to write")
    states: StateColumns | None = usual(
        None, description="results of the states to keep, such as status; default all of them"
    )
