"""What is asked of a design: its limits, the goals of its choice, and how uncertain numbers are drawn."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at every start.

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema

from tendon_cli.studies.fields import Single, fault
from tendon_cli.studies.parts import Part, Words, written
from tendon_cli.studies.values import Values
from tendon_cli.units import described

MOST_DRAWS = 2**20
MOTION_LIMITS = (
    "max_spool_travel",
    "max_backlash",
    "max_torque_band",
    "peak_motor_speed",
    "peak_motor_power",
    "max_motor_work_in",
    "max_friction_loss",
    "min_efficiency",
)
"""Limits that need `[motion] speed`."""

CHOICE_RESULTS = (
    "pretension_from",
    "pretension_to",
    "windows",
    "tolerance",
    "served",
    "pretension",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
)
"""Columns of choices.parquet that a goal may name, besides the axes of the choices."""


class Limits(Part, Mapping[str, float]):
    """Limits of a design, each named as the column that it bounds: min_ from below, max_ and peak_ from above.

    As a mapping it has the limits that are given, and min_elbow_stiffness, with their values in SI.
    """

    min_flexor_tension: Annotated[Values | None, Single("min_flexor_tension", 0.0, 1e7)] = None
    min_extensor_tension: Annotated[Values | None, Single("min_extensor_tension", 0.0, 1e7)] = None
    max_tension: Annotated[Values | None, Single("max_tension", 0.0, 1e9)] = None
    max_spring_extension: Annotated[Values | None, Single("max_spring_extension", 0.0, 100.0)] = None
    peak_motor_torque: Annotated[Values | None, Single("peak_motor_torque", 0.0, 1e7)] = None
    max_contact_pressure: Annotated[Values | None, Single("max_contact_pressure", 0.0, 1e12)] = None
    min_elbow_stiffness: Annotated[Values, Single("min_elbow_stiffness", -1e6, 1e6)] = written("0 N m/rad")
    max_pretension: Annotated[Values | None, Single("max_pretension", 0.0, 1e7)] = None
    min_spool_to_tendon: Annotated[Values | None, Single("min_spool_to_tendon", 0.0, 1e6)] = None
    max_spool_travel: Annotated[Values | None, Single("max_spool_travel", 0.0, 1e6)] = None
    max_backlash: Annotated[Values | None, Single("max_backlash", 0.0, 1e6)] = None
    max_torque_band: Annotated[Values | None, Single("max_torque_band", 0.0, 1e7)] = None
    peak_motor_speed: Annotated[Values | None, Single("peak_motor_speed", 0.0, 1e6)] = None
    peak_motor_power: Annotated[Values | None, Single("peak_motor_power", 0.0, 1e9)] = None
    max_motor_work_in: Annotated[Values | None, Single("max_motor_work_in", 0.0, 1e9)] = None
    max_friction_loss: Annotated[Values | None, Single("max_friction_loss", 0.0, 1e9)] = None
    min_efficiency: Annotated[Values | None, Single("min_efficiency", -1e6, 1.0)] = None

    def __getitem__(self, name: str) -> float:
        """The value of a limit in SI; raises KeyError for one that is not given."""
        values = getattr(self, name) if name in type(self).model_fields else None
        if values is None:
            raise KeyError(name)
        return float(values.single)

    def __iter__(self) -> Iterator[str]:  # type: ignore[override]
        return (name for name in type(self).model_fields if getattr(self, name) is not None)

    def __len__(self) -> int:
        return sum(1 for _ in self)


class Goals(Part):
    """What `tendon design` solves for, over the axes that are not its conditions."""

    conditions: Words | None = Field(
        default=None,
        description="axes that a design must survive; default load.*, arm.*, case, people and uncertain numbers",
    )
    serve: Annotated[Values | None, Single("serve", 0.0, 1.0)] = None
    minimise: Words = Field(default=(), description="columns of choices.parquet; with several goals a front")
    maximise: Words = Field(default=(), description="columns of choices.parquet; with several goals a front")
    pretension: Literal["middle", "least"] = Field(
        default="middle", description="where in its window of pretension a choice is set"
    )


def whole(value: object) -> object:
    """A whole number, or its digits, as the command line has them."""
    if isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 20:
        return int(value)
    if isinstance(value, bool) or not isinstance(value, int):
        raise fault(f"{described(value)} is not a whole number")
    return value


def _draws(value: int) -> int:
    if not 1 <= value <= MOST_DRAWS or value & (value - 1):
        near = 1 << max(0, min(value, MOST_DRAWS).bit_length() - 1)
        raise fault(
            f"{described(value)} is not possible, expected a power of two, {MOST_DRAWS:,} at most", f"such as {near}"
        )
    return value


def _seed(value: int) -> int:
    if not 0 <= value < 2**63:
        raise fault(f"{described(value)} is out of range, expected 0 to 2^63 - 1")
    return value


def _truth(value: object) -> object:
    """A truth value, or its word, as the command line has it."""
    if isinstance(value, bool) or value in ("true", "false"):
        return value is True or value == "true"
    raise fault(f"{described(value)} is not possible, expected true or false")


Seed = Annotated[
    int,
    BeforeValidator(whole),
    AfterValidator(_seed),
    WithJsonSchema({"type": "integer", "minimum": 0, "maximum": 2**63 - 1}),
]
Truth = Annotated[bool, BeforeValidator(_truth), WithJsonSchema({"type": "boolean"})]


class Uncertainty(Part):
    """How uncertain numbers are drawn: by scrambled Sobol points."""

    draws: Annotated[
        int,
        BeforeValidator(whole),
        AfterValidator(_draws),
        WithJsonSchema({"enum": [2**power for power in range(MOST_DRAWS.bit_length())]}),
    ] = Field(default=256, description="how many draws, a power of two")
    seed: Seed = Field(default=1, description="the same seed gives the same draws")
    cross: Truth = Field(
        default=False, description="with people: every draw for every person, instead of one draw for each"
    )
