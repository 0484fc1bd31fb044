"""Section of a study on fitting its numbers to logs of the suit."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

from typing import Annotated

from pydantic import StringConstraints

from tendon_cli.studies.fields import SingleField
from tendon_cli.studies.parts import Part, field_default
from tendon_cli.studies.values import StudyNumber

Header = Annotated[str, StringConstraints(strict=True, min_length=1, max_length=200)]
"""Header of a column of a log, with its unit."""


BACKLASH = "backlash"
"""Name of the play between spool and joint, an error of a fit's sensors."""


class LogColumns(Part):
    """Headers of a log's columns, for those that are not understood by themselves."""

    elbow_angle: Header | None = field_default(None, description="header of the joint's angle")
    spool_angle: Header | None = field_default(
        None, description="header of the spool's angle, which winds the flexor"
    )
    motor_torque: Header | None = field_default(
        None, description="header of the motor's torque, or of the current with fit.torque_constant"
    )
    flexor_tension_proximal: Header | None = field_default(
        None, description="header of the flexor's tension at the motor"
    )
    flexor_tension_distal: Header | None = field_default(
        None, description="header of the flexor's tension at the joint"
    )
    extensor_tension_proximal: Header | None = field_default(
        None, description="header of the extensor's tension at the motor"
    )
    extensor_tension_distal: Header | None = field_default(
        None, description="header of the extensor's tension at the joint"
    )
    time: Header | None = field_default(None, description="header of the time")
    load_mass: Header | None = field_default(None, description="header of the load in the hand")

    @property
    def named(self) -> dict[str, str]:
        """Headers that are given, by column."""
        given = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: header for name, header in given.items() if header is not None}


class Fitting(Part):
    """Fit of a suit to its logs: `tendon fit-suit`."""

    columns: LogColumns = LogColumns()
    torque_constant: Annotated[StudyNumber | None, SingleField("torque_constant", 1e-6, 1e6)] = (
        field_default(
            None,
            description="torque at the spool, behind the gear, per current of the motor: the "
            "motor's N m/A times the gear ratio",
        )
    )
    counts_per_turn: Annotated[StudyNumber | None, SingleField("counts_per_turn", 1.0, 1e9)] = (
        field_default(
            None,
            description="counts of the encoder in a turn of the spool, behind the gear: those of a "
            "motor turn times the gear ratio",
        )
    )
