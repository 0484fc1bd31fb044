"""Tables of a study file, from arm to output.

Defaults are the paper's baseline, unilateral and without load.
"""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints

from tendon_cli.quantities import OF_MOTION_STATES, OF_STATES, SIDES
from tendon_cli.studies.accuracy import Accuracy, AccuracyField
from tendon_cli.studies.angle_curves import (
    EXCURSION,
    SIGN_OF_TASK,
    TASK_OVER_ANGLE,
    TASK_OVER_TIME,
    TORQUE,
    TRAJECTORY,
    BendField,
    CurveField,
    CurveTable,
)
from tendon_cli.studies.fields import SingleField, WordField, fault, hint_at_nearest, one_or_many
from tendon_cli.studies.number import ErrorField, NumberField
from tendon_cli.studies.values import RIGID, StudyNumber
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

Friction = Annotated[StudyNumber, NumberField("friction", 0.0, 10.0)]
BendAngle = Annotated[StudyNumber | CurveTable, BendField("bend_angle", 0.0, 100.0)]
TendonLength = Annotated[StudyNumber, NumberField("tendon_length", **POSITIVE_LENGTH)]
TendonDiameter = Annotated[StudyNumber, NumberField("tendon_diameter", 1e-6, 1.0)]
YoungsModulus = Annotated[StudyNumber, NumberField("youngs_modulus", 1e3, 1e15)]
Pretension = Annotated[StudyNumber, NumberField("pretension", 0.0, 1e7, is_reading=True)]
Stiffness = Annotated[StudyNumber, NumberField("spring_stiffness", 1e-3, 1e12, word=RIGID)]
AnchorStiffness = Annotated[StudyNumber, NumberField("anchor_stiffness", 1e-3, 1e12, word=RIGID)]
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
SpringPlace = Annotated[str | tuple[str, ...] | None, WordField(("joint", "motor"))]

field_default: Any = Field
"""Field whose default is as a study file would say it; the field's validator reads it."""


_RESULTS_OF_STATES = ("status", *OF_STATES, *OF_MOTION_STATES)
"""Results of states that a study may keep; the last ones are there along a trajectory."""


def _check_state_columns(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names if all are results of the states; refuse any other.

    Columns that identify the state of a row are refused, too: they are always written.
    """
    for name in names:
        if name in ("design", "direction", "elbow_angle"):
            raise fault(
                f'"{name}" identifies the state of a row, so it is always written', "leave it out"
            )
        if name not in _RESULTS_OF_STATES:
            hint = hint_at_nearest(name, _RESULTS_OF_STATES)
            raise fault(f'"{shorten(name)}" is not a result of the states', hint)
    return names


Words = Annotated[
    tuple[Annotated[str, StringConstraints(strict=True, min_length=1, max_length=100)], ...],
    *one_or_many({"type": "string", "minLength": 1, "maxLength": 100}, least=0, each_once=True),
]
"""One word or a list of them, such as columns; the study checks which words are possible."""
Directions = Annotated[tuple[Direction, ...], WordField(("flexion", "extension"), is_list=True)]
Tables = Annotated[
    tuple[Literal["designs", "states"], ...], WordField(("designs", "states"), is_list=True)
]
StateColumns = Annotated[
    tuple[str, ...],
    *one_or_many({"enum": list(_RESULTS_OF_STATES)}, each_once=True),
    Field(min_length=1),
    AfterValidator(_check_state_columns),
]


class Part(BaseModel):
    """Table of a study file: it refuses unknown keys, and does not change once it is read."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, validate_default=True, arbitrary_types_allowed=True
    )

    def changed(self, **values: Any) -> Self:
        """Return the same table with other values; what was computed of the old is not kept."""
        kept = {name: getattr(self, name) for name in type(self).model_fields}
        return self.model_construct(self.model_fields_set | values.keys(), **(kept | values))


def with_sides(part: Any, key: str) -> dict[str, Any]:
    """Return a table, and those of its sides as far as it has them, by dotted key.

    Args:
        part: The table of both sides.
        key: Its dotted key.
    """
    sides = {f"{key}.{side}": getattr(part, side) for side in SIDES}
    return {key: part, **{path: inner for path, inner in sides.items() if inner is not None}}


class Arm(Part):
    """Arm (Fig. 2) and its weight."""

    a1: Annotated[StudyNumber, NumberField("a1", **LENGTH)] = field_default("40 mm")
    b1: Annotated[StudyNumber, NumberField("b1", **POSITIVE_LENGTH)] = field_default("150 mm")
    a2: Annotated[StudyNumber, NumberField("a2", **LENGTH)] = field_default("20 mm")
    b2: Annotated[StudyNumber, NumberField("b2", **POSITIVE_LENGTH)] = field_default("150 mm")
    elbow_radius: Annotated[StudyNumber, NumberField("elbow_radius", **POSITIVE_LENGTH)] = (
        field_default("45 mm")
    )
    forearm_mass: Annotated[StudyNumber, NumberField("forearm_mass", 0.0, 1e4)] = field_default(
        "1.54 kg"
    )
    forearm_com: Annotated[StudyNumber, NumberField("forearm_com", **LENGTH)] = field_default(
        "174 mm"
    )
    load_distance: Annotated[StudyNumber, NumberField("load_distance", **LENGTH)] = field_default(
        "320 mm"
    )
    upper_arm_angle: Annotated[StudyNumber, NumberField("upper_arm_angle", **FULL_TURNS)] = (
        field_default("0 deg")
    )
    contact_width: Annotated[
        StudyNumber | None, NumberField("contact_width", **POSITIVE_LENGTH)
    ] = None
    contact_radius: Annotated[
        StudyNumber | None, NumberField("contact_radius", **POSITIVE_LENGTH)
    ] = None
    contact_from: Annotated[StudyNumber | None, NumberField("contact_from", **FULL_TURNS)] = None
    anchors: Literal["measured", "mean man"] | None = field_default(
        None,
        description="whose the stated anchors and elbow radius are: measured on the one person of "
        "a file, where they hold as stated, or the survey's mean man's, scaled to each person",
    )


class SheathSide(Part):
    """Sheath on one side of the arm; a key left out has the value for both sides."""

    friction: Friction | None = None
    friction_from: FileName | None = field_default(
        None, description="a file written by `tendon fit-friction --out`"
    )
    bend_angle: BendAngle | None = None
    path: FileName | None = field_default(
        None, description="a CSV of way-points x, y, z of the routed sheath, in m"
    )
    path_smoothing: Annotated[StudyNumber | None, SingleField("path_smoothing", 0.0, 1.0)] = None


FILES_OF_SHEATH = {"friction": "friction_from", "bend_angle": "path"}
"""Keys of a sheath that name files, by the number that each gives."""


class Sheath(SheathSide):
    """Sheaths of both tendons."""

    friction: Friction | None = field_default(0.07)
    bend_angle: BendAngle | None = field_default("180 deg")
    flexor: SheathSide | None = None
    extensor: SheathSide | None = None


class TendonSide(Part):
    """Tendon on one side of the arm; a key left out has the value for both sides."""

    length: TendonLength | None = None
    diameter: TendonDiameter | None = None
    youngs_modulus: YoungsModulus | None = None
    pretension: Pretension | None = None


class Tendon(TendonSide):
    """Tendons of both sides, of round cross-section."""

    length: TendonLength | None = field_default("2 m")
    diameter: TendonDiameter | None = field_default("1.5 mm")
    youngs_modulus: YoungsModulus | None = field_default("145 GPa")
    pretension: Pretension | None = field_default("100 N")
    breaking_force: Annotated[StudyNumber | None, NumberField("breaking_force", 1e-3, 1e9)] = None
    rope: Literal["7x7", "7x19"] | None = field_default(
        None,
        description="construction of the rope of both tendons, which says how many rope diameters "
        "wide a spool should be: 28 for 7x7, 18 for 7x19",
    )
    flexor: TendonSide | None = None
    extensor: TendonSide | None = None


class SpringSide(Part):
    """Spring on one side of the arm; a key left out has the value for both sides."""

    stiffness: Stiffness | None = None
    free_length: Annotated[StudyNumber | None, NumberField("spring_free_length", **LENGTH)] = None
    at: SpringPlace = field_default(None, description="end of the tendon at which the spring sits")


class Spring(SpringSide):
    """Series springs of both tendons, by default at their elbow ends."""

    stiffness: Stiffness | None = field_default("3 kN/m")
    at: SpringPlace = field_default(
        "joint", description="end of the tendon at which the spring sits"
    )
    flexor: SpringSide | None = None
    extensor: SpringSide | None = None


class AnchorSide(Part):
    """Anchor on one side of the arm; a key left out has the value for both sides."""

    stiffness: AnchorStiffness | None = None


class Anchor(AnchorSide):
    """Tissue and cuff behind the anchors of both tendons."""

    stiffness: AnchorStiffness | None = field_default(RIGID)
    flexor: AnchorSide | None = None
    extensor: AnchorSide | None = None


class Joint(Part):
    """Joint that the suit moves: its name, the travels of its tendons, and its own torque."""

    name: Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z -]{0,30}$", strict=True)] = (
        field_default("elbow", description="the joint's name in texts and figures")
    )
    excursion: Annotated[str | CurveTable | None, CurveField((EXCURSION,))] = field_default(
        None,
        description="a CSV of angle, flexor, extensor: how far the flexor's path shortens and the "
        "extensor's lengthens",
    )
    smoothing: Annotated[StudyNumber | None, SingleField("excursion_noise", 0.0, 0.1)] = None
    scale_with: BodyDimension | None = field_default(
        None, description="with people: the dimension of the body to which travels are proportional"
    )
    torque: Annotated[str | CurveTable | None, CurveField((TORQUE,))] = field_default(
        None,
        description="a CSV of angle, torque: the joint's own resistance to flexion",
    )
    stiffness: Annotated[StudyNumber | None, NumberField("joint_stiffness", 0.0, 1e6)] = None
    rest_angle: Annotated[StudyNumber | None, NumberField("rest_angle", **FULL_TURNS)] = None
    stiffness_with: Literal["arm_volume"] | None = field_default(
        None,
        description="with people: the joint's stiffness, stated for the mean man, in proportion to "
        "the volume of the arm",
    )


class Spool(Part):
    """Spool of the motor."""

    flexor_radius: Annotated[StudyNumber, NumberField("flexor_radius", **POSITIVE_LENGTH)] = (
        field_default("30 mm")
    )
    ratio: Annotated[StudyNumber, NumberField("spool_ratio", 1e-3, 1e3)] = field_default(1.0)


class Setting(Part):
    """Posture in which the pretension is set, and how it is read."""

    angle: Annotated[StudyNumber, NumberField("setting_angle", **FULL_TURNS)] = field_default(
        "0 deg"
    )
    upper_arm_angle: Annotated[StudyNumber, NumberField("upper_arm_angle", **FULL_TURNS)] = (
        field_default("0 deg")
    )
    load: Annotated[StudyNumber, NumberField("load_mass", 0.0, 1e4)] = field_default("0 kg")
    after: Direction = field_default(
        "extension", description="direction of the last motion before the pretension is read"
    )
    read: Literal[
        "pretension",
        "flexor at joint",
        "extensor at joint",
        "flexor at motor",
        "extensor at motor",
        "motor torque",
    ] = field_default(
        "pretension",
        description="meaning of the study's pretension: F0 of the model, or the reading of a gauge",
    )
    reading_error: Annotated[
        StudyNumber | None, ErrorField("reading_error", 0.0, 1e5, is_reading=True)
    ] = None
    accuracy: Annotated[Accuracy, AccuracyField()] = field_default(
        "2 mm",
        description="how well the pretension can be set: a length of both tendons, or a tension of "
        "the kind that is read",
    )


class Load(Part):
    """Load in the hand, and the torque of a task."""

    mass: Annotated[StudyNumber, NumberField("load_mass", 0.0, 1e4)] = field_default("0 kg")
    torque: Annotated[str | CurveTable | None, CurveField((TASK_OVER_ANGLE, TASK_OVER_TIME))] = (
        field_default(
            None,
            description="a CSV of angle, torque: torque of a task, besides that of the mass; with "
            f"a trajectory also of time, torque, on the same clock; {SIGN_OF_TASK}",
        )
    )
    scale: Annotated[StudyNumber, NumberField("load_scale", -1e3, 1e3)] = field_default(1.0)


class Motion(Part):
    """States that each design goes through."""

    direction: Directions = field_default(
        ("flexion", "extension"), description="flexion, extension or both, in the order of the rows"
    )
    elbow_angle: Annotated[
        StudyNumber, NumberField("elbow_angle", **FULL_TURNS, uncertain=False)
    ] = field_default({"from": "0 deg", "to": "90 deg", "num": 91})
    speed: Annotated[StudyNumber | None, SingleField("speed", 1e-6, 1e3)] = None
    trajectory: Annotated[str | CurveTable | None, CurveField((TRAJECTORY,))] = field_default(
        None,
        description="a CSV of time, angle: a motion in time, instead of angles, directions and a "
        f"speed; a third column, torque, is that of a task: {SIGN_OF_TASK}",
    )
    cutoff: Annotated[StudyNumber | None, SingleField("cutoff", 1e-3, 1e4)] = None
    inertia: Annotated[StudyNumber | None, SingleField("inertia", 0.0, 1e3)] = None


class Model(Part):
    """Options of the model: slack, and the reference of the flexor's travel."""

    slack: Literal["unilateral", "bilateral"] = field_default(
        "unilateral",
        description="unilateral: a tendon cannot push; bilateral: negative tension, as in the "
        "paper",
    )
    reference: Literal["published", "initial"] = field_default(
        "published",
        description="flexor travel from b1 + b2, as published, or from the path length at 0 "
        "degrees",
    )


class Output(Part):
    """Tables and columns that are written."""

    tables: Tables = field_default(("designs", "states"), description="which tables to write")
    states: StateColumns | None = field_default(
        None, description="results of the states to keep, such as status; default all of them"
    )
