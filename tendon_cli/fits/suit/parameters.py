"""Numbers of a study and errors of sensors that a fit may change, each with its prior.

Every number that a study states has a tolerance: its own, or the usual one of a number that was
measured on a wearer or comes from a catalogue. A parameter is fitted by its normal score z, which
is N(0, 1) before the log is read: a number with a normal prior is mean + sd z, one that is uniform
between two ends is spread so that it never leaves them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tendon_cli.errors import Fault, StudyError
from tendon_cli.fits.log_rows import Floats
from tendon_cli.fits.suit.log_columns import (
    ELBOW_ANGLE,
    MOTOR_TORQUE,
    SPOOL_ANGLE,
    TENSION_CHANNELS,
)
from tendon_cli.studies.fit_section import BACKLASH
from tendon_cli.studies.space.axis import PRETENSION, split_side
from tendon_cli.studies.study import Study, is_exact, keys
from tendon_cli.studies.usual import USUAL, UsualDeviation
from tendon_cli.studies.values import Uncertain, quantile
from tendon_cli.units import SI_UNIT

LOAD = "load.mass"
INERTIA_OF_FOREARM = "motion.inertia"
INERTIA_SHARE = "share of inertia"
JOINT_ZERO = "joint sensor zero"
JOINT_GAIN = "joint sensor gain"
SPOOL_ZERO = "spool zero"
SPOOL_DELAY = "spool delay"
TORQUE_ZERO = "torque zero"
TORQUE_GAIN = "torque gain"
TORQUE_DELAY = "torque delay"
GEAR_FRICTION = "gear friction"
GEAR_EFFICIENCY = "gear efficiency"

_MASS_SHARE = 0.05
_OF_A_LOG = "as it was for a log"
TOLERANCES = USUAL | {
    LOAD: UsualDeviation(_MASS_SHARE, "share", _OF_A_LOG),
    PRETENSION: UsualDeviation(0.1, "share", _OF_A_LOG),
    "arm.upper_arm_angle": UsualDeviation(math.radians(2.0), "amount", _OF_A_LOG),
    "joint.stiffness": UsualDeviation(0.4, "amount", _OF_A_LOG),
}
"""Usual deviations of numbers, those among them that an answer does not draw; every wearer's joint
has a stiffness, though a study may state none (N m/rad)."""
_NOT_FITTED = ("setting.", "motion.", "load.scale", "tendon.breaking_force", "spring.free_length")
"""Keys of numbers that no log of a suit tells."""

_SPOOL_ZERO_DEVIATION = 1.0
"""Standard deviation of the zero of the spool's angle about the study's, rad: as good as none."""
TORQUE_ZERO_SHARE = 0.05
"""Standard deviation of the zero of the torque, as a share of the range of the torque."""
_SENSORS: tuple[tuple[str, str, float, float, str], ...] = (
    (JOINT_ZERO, ELBOW_ANGLE, 0.0, math.radians(2.0), "rad"),
    (JOINT_GAIN, ELBOW_ANGLE, 0.0, 0.02, "1"),
    (BACKLASH, SPOOL_ANGLE, 0.0, math.radians(0.5), "rad"),
    (SPOOL_DELAY, SPOOL_ANGLE, 0.0, 0.02, "s"),
    (TORQUE_GAIN, MOTOR_TORQUE, 0.0, 0.05, "1"),
    (TORQUE_ZERO, MOTOR_TORQUE, 0.0, TORQUE_ZERO_SHARE, "N m"),
    (GEAR_FRICTION, MOTOR_TORQUE, 0.0, 0.05, "N m"),
    (GEAR_EFFICIENCY, MOTOR_TORQUE, 0.9, 0.07, "1"),
    (TORQUE_DELAY, MOTOR_TORQUE, 0.0, 0.02, "s"),
    *((f"{name} zero", name, 0.0, 0.02, "N") for name in TENSION_CHANNELS),
    *((f"{name} gain", name, 0.0, 0.02, "1") for name in TENSION_CHANNELS),
)
"""Errors of sensors: name, column, mean, standard deviation and unit.

A deviation in N m or N is a share of the range of its channel. An efficiency of 0.9 ± 0.07 is 0.75
to 1; it is not cut off at 1, where a cut would hide how far the others depend on it.
"""
_INERTIA_SHARE = 0.1
GYRATION = 1.47
"""Moment of inertia of forearm and hand about the elbow over their mass times the square of the
distance of their centre of mass (Winter: radius of gyration 0.827 over 0.682 of the length)."""


@dataclass(frozen=True)
class Parameter:
    """One number that a fit may change."""

    key: str
    """Key of the study, or name of an error of a sensor."""
    law: Uncertain
    """Prior."""
    unit: str
    """SI unit; "1" for a share."""
    is_sensor: bool = False
    is_stated: bool = False
    """True if the study itself says that the number is uncertain."""
    log: int | None = None
    """Number of the log to which it belongs; None if it holds for all."""

    def at(self, score: Floats) -> Floats:
        """Return the number at normal scores, SI."""
        law = self.law
        if law.kind == "normal" and law.cut_share < 1e-6:
            return np.clip(law.middle + law.spread * score, law.low, law.high)
        from scipy.special import ndtr

        return quantile(law, ndtr(np.clip(score, -8.0, 8.0)))


def normal(middle: float, deviation: float, low: float = -math.inf) -> Uncertain:
    """Return a normal law that does not come from a study."""
    return Uncertain("normal", middle, deviation, low, math.inf, "")


def loads_of_study(study: Study) -> Floats:
    """Return the loads that a study states, (loads,), kg: those of a table if one sets them."""
    of_rows = [rows.numbers[LOAD] for rows in study.row_tables if LOAD in rows.numbers]
    if not of_rows:
        return study.numbers[LOAD].array
    loads = np.unique(np.concatenate(of_rows))
    return loads[~np.isnan(loads)]


def numbers_of(study: Study) -> list[Parameter]:
    """Return the numbers of a study that a fit may change, those stated as uncertain first.

    Raises:
        StudyError: if a number of the suit is an axis, or nothing is to be fitted.
    """
    faults = [
        Fault(key, "has several values, but a log is of one suit", f"--set '{key}=...' picks one")
        for key, number in study.numbers.items()
        if number.is_axis and split_side(key)[0] in TOLERANCES and key != LOAD
    ]
    for table in ("people", "cases"):
        if getattr(study, table):
            hint = "leave it out, or fit a study of this suit alone"
            faults.append(Fault(table, "is about several arms, but a log is of one suit", hint))
    for rows in study.row_tables:
        of_suit = [key for key in rows.numbers if split_side(key)[0] in TOLERANCES and key != LOAD]
        if of_suit and not study.cases:
            problem = f"sets {of_suit[0]} in each row, but a log is of one suit"
            hint = f"leave it out, and state {of_suit[0]} as this suit has it"
            faults.append(Fault(rows.where or rows.key, problem, hint))
    if faults:
        raise StudyError(faults)
    found = []
    for key, number in study.numbers.items():
        if number.is_axis or is_exact(study, key) or key.startswith(_NOT_FITTED):
            continue
        common = split_side(key)[0]
        law = number.uncertain or _usual_law(study, key)
        # The states of a suit depend on these numbers.
        if law is None or common not in {*TOLERANCES, "tendon.diameter"}:
            continue
        of_number = keys()[key].number
        unit = SI_UNIT[of_number.quantity.dimension]
        found.append(Parameter(key, law, unit, is_stated=number.uncertain is not None))
    if not any(parameter.is_stated for parameter in found):
        hint = 'state what you want to know with its range, such as friction = "0.05 to 0.3"'
        problem = "nothing is to be fitted: the study gives no number with +/- or a range"
        raise StudyError([Fault("", problem, hint)])
    return sorted(found, key=lambda parameter: not parameter.is_stated)


def _usual_law(study: Study, key: str) -> Uncertain | None:
    """Return the usual law of an exact number; None if it stays exact."""
    common = split_side(key)[0]
    value = study.numbers[key].single
    if common not in TOLERANCES or not math.isfinite(value):
        return None
    if common == "joint.rest_angle" and study.joint.stiffness is None:
        return None
    usual = TOLERANCES[common]
    of_number = keys()[key].number
    if usual.kind == "factor":
        return Uncertain("log-normal", value, math.log(usual.size), 0.0, math.inf, "")
    deviation = usual.of(value)
    if deviation == 0.0:
        return None
    return Uncertain("normal", value, deviation, of_number.low, of_number.high, "")


def sensors_of(
    channels: Mapping[str, Floats], logs: int, study: Study, *, has_time: bool
) -> list[Parameter]:
    """Return the errors of sensors that a fit may change.

    Args:
        channels: What was measured.
        logs: Number of logs.
        study: The study, which may take some as exact.
        has_time: True if the logs have a time.
    """
    found = []
    for name, column, middle, size, unit in _SENSORS:
        is_logged = column in (ELBOW_ANGLE, *channels) and (has_time or unit != "s")
        if not is_logged:
            continue
        is_share = unit in ("N m", "N")
        law = normal(middle, size * range_of(channels[column]) if is_share else size)
        found.append(Parameter(name, law, unit, is_sensor=True))
    if SPOOL_ANGLE in channels:
        law = normal(0.0, _SPOOL_ZERO_DEVIATION)
        for log in range(logs):
            name = SPOOL_ZERO if logs == 1 else f"{SPOOL_ZERO} {log + 1}"
            found.append(Parameter(name, law, "rad", is_sensor=True, log=log))
    return [parameter for parameter in found if not is_exact(study, parameter.key)]


def loads_of(loads: Sequence[float]) -> list[Parameter]:
    """Return the masses of the loads that a log states, each with its tolerance."""
    return [
        Parameter(
            f"load {mass:.4g} kg", normal(mass, _MASS_SHARE * mass, 0.0), "kg", is_sensor=True
        )
        for mass in loads
        if mass > 0.0
    ]


def inertia_of(study: Study) -> Parameter:
    """Return the moment of inertia of forearm and load, or the share of it that the log shows.

    A study that states `motion.inertia` says that the log is of a motion with inertia. For any
    other the log decides between none and that of a usual forearm with its load.
    """
    stated = study.motion.inertia
    if stated is not None:
        inertia = stated.single
        law = stated.uncertain or normal(inertia, _INERTIA_SHARE * inertia, 0.0)
        return Parameter(INERTIA_OF_FOREARM, law, "kg m2", is_sensor=True)
    law = Uncertain("uniform", 0.5, 0.5, 0.0, 1.0, "")
    return Parameter(INERTIA_SHARE, law, "1", is_sensor=True)


def usual_inertia(study: Study) -> float:
    """Return the moment of inertia about the elbow of a usual forearm of this mass, kg m²."""
    mass = study.numbers["arm.forearm_mass"].single
    distance = study.numbers["arm.forearm_com"].single
    return float(GYRATION * mass * distance**2)


def range_of(values: Floats) -> float:
    """Return the range of a channel without its outermost hundredths, SI."""
    return float(np.quantile(values, 0.99) - np.quantile(values, 0.01))
