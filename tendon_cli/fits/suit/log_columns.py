"""Columns of a suit's log: the channel that each header names, and its unit.

A header is understood by its words, English or German, or because `[fit.columns]` of the study
names it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tendon_cli.errors import UsageError
from tendon_cli.readers.heading import Heading, column_called
from tendon_cli.readers.table import Table
from tendon_cli.studies.fit_section import Fitting
from tendon_cli.units import SENSOR_UNITS, factor_of, force_factor

ELBOW_ANGLE = "elbow_angle"
SPOOL_ANGLE = "spool_angle"
MOTOR_TORQUE = "motor_torque"
LOAD_MASS = "load_mass"
TIME = "time"
TENSION_CHANNELS = (
    "flexor_tension_proximal",
    "flexor_tension_distal",
    "extensor_tension_proximal",
    "extensor_tension_distal",
)
"""Tensions that cells at either end of either tendon may give."""
CHANNELS = (SPOOL_ANGLE, MOTOR_TORQUE, *TENSION_CHANNELS)
"""Quantities that the model predicts over the angle of the joint."""
COLUMNS = (ELBOW_ANGLE, *CHANNELS, TIME, LOAD_MASS)
"""Columns that `[fit.columns]` may name."""
CURRENT = "current"
COUNTS = "counts"

_WISHED = re.compile(
    r"command|cmd\b|desired|target|set[ _-]?point|nominal|reference|\bref\b|soll|wunsch|demand"
)
"""Words of headers of what was asked of a motor, and not measured."""
_JOINT = ("elbow", "joint", "ellbogen", "ellenbogen", "gelenk", "theta", "knee", "knie", "forearm")
_JOINT_ALONE = ("elbow", "joint", "ellbogen", "ellenbogen", "gelenk", "knee", "knie")
"""Words of a joint that are its angle's, if no word says more than the unit."""
_SPOOL = ("spool", "motor", "spule", "antrieb", "alpha", "drum", "pulley", "actuator")
_ANGLE_WORDS = ("angle", "winkel", "position", "pos", "encoder", "enc", "theta", "alpha", "theta")
_DERIVED = ("speed", "velocity", "geschwindigkeit", "drehzahl", "acceleration", "rate", "error")
_TORQUE_WORDS = ("torque", "moment", "tau")
_CURRENT_WORDS = ("current", "strom")
_TENSION_WORDS = ("tension", "force", "kraft", "zugkraft", "cell")
_FLEXOR = ("flexor", "flex", "beuger", "beuge")
_EXTENSOR = ("extensor", "ext", "strecker", "streck")
_PROXIMAL = ("proximal", "prox", "motor", "spool", "antrieb", "motorseite")
_DISTAL = ("distal", "dist", "elbow", "joint", "ellbogen", "gelenk", "arm")
_LOAD_WORDS = ("load", "mass", "last", "masse", "gewicht", "weight", "payload", "zusatzmasse")
_TIME_WORDS = ("time", "zeit", "timestamp", "t", "elapsed", "clock", "zeitstempel")

_WANTED_DIMENSIONS = {
    ELBOW_ANGLE: ("angle", COUNTS),
    SPOOL_ANGLE: ("angle", COUNTS),
    MOTOR_TORQUE: ("torque", CURRENT),
    LOAD_MASS: ("mass",),
    TIME: ("time",),
    **dict.fromkeys(TENSION_CHANNELS, ("force", "mass")),
}
_EXAMPLES = {
    ELBOW_ANGLE: "elbow_angle (deg)",
    SPOOL_ANGLE: "spool_angle (rad)",
    MOTOR_TORQUE: "motor_torque (N m)",
    LOAD_MASS: "load_mass (kg)",
    TIME: "time (s)",
    **{name: f"{name} (N)" for name in TENSION_CHANNELS},
}


def columns_by_role(
    columns: Sequence[Heading], named: Mapping[str, str]
) -> dict[str, list[Heading]]:
    """Return the columns of a log by what they give.

    Args:
        columns: All columns.
        named: Headers that the study names, by column.
    """
    by_role: dict[str, list[Heading]] = {}
    for column in columns:
        by_role.setdefault(_role(column), []).append(column)
    for role, wanted in named.items():
        stated = Heading.of(0, wanted)  # the study may add the unit
        called = column_called(columns, wanted) or column_called(columns, stated.name)
        if called is not None:
            by_role = {
                other: [one for one in found if one.index != called.index]
                for other, found in by_role.items()
            }
            by_role[role] = [replace(called, unit=called.unit or stated.unit)]
    return by_role


def _role(column: Heading) -> str:
    """Return what a column gives by the words of its header and by its unit; empty if nothing."""
    text = _plain(column.text)
    words = set(re.findall(r"[^\W\d_]+", text))
    dimension = "time" if column.clock else column.dimension or None

    def has(*stems: str) -> bool:
        """Return True if a short stem is a word, or a longer one is part of one."""
        return any(stem in words if len(stem) < 4 else stem in text for stem in stems)

    if _WISHED.search(text) or has(*_DERIVED):
        return ""
    if dimension == "time" or (dimension is None and words & set(_TIME_WORDS)):
        return TIME
    if dimension == CURRENT or (dimension is None and has(*_CURRENT_WORDS)):
        return MOTOR_TORQUE
    if dimension == "torque" or (dimension is None and has(*_TORQUE_WORDS)):
        return "" if has(*_JOINT) else MOTOR_TORQUE
    if has(*_TENSION_WORDS) and dimension in ("force", "mass", None):
        return _tension(has(*_FLEXOR), has(*_EXTENSOR), has(*_PROXIMAL), has(*_DISTAL))
    is_angle = dimension in ("angle", COUNTS)
    if is_angle and not has(*_ANGLE_WORDS):
        # The unit says that it is an angle: "motor (counts)", "elbow (deg)".
        if has(*_SPOOL) == has(*_JOINT_ALONE):
            return ""
        return SPOOL_ANGLE if has(*_SPOOL) else ELBOW_ANGLE
    if has(*_ANGLE_WORDS) and (is_angle or dimension is None):
        if has(*_SPOOL) and not has("elbow", "ellbogen", "joint", "gelenk"):
            return SPOOL_ANGLE
        return ELBOW_ANGLE if has(*_JOINT) else ""
    if dimension == "mass" and has(*_LOAD_WORDS):
        return LOAD_MASS
    return ""


def _plain(text: str) -> str:
    """Return a header in small letters, with blanks between its words."""
    return re.sub(r"[_\-.]+", " ", text.casefold())


def _tension(is_flexor: bool, is_extensor: bool, is_proximal: bool, is_distal: bool) -> str:
    """Return the channel of a cell by its side and end; empty if the words leave it open."""
    if is_flexor == is_extensor or is_proximal == is_distal:
        return ""
    side = "flexor" if is_flexor else "extensor"
    return f"{side}_tension_{'proximal' if is_proximal else 'distal'}"


def si_factor(table: Table, column: Heading, role: str, section: Fitting) -> float:
    """Return the factor from the numbers of a column to SI; a wrong unit is a fault of the table.

    Args:
        table: The log.
        column: The column.
        role: What it gives.
        section: Section of the study, which has torque constant and counts per turn.

    Raises:
        UsageError: if the study lacks what current or counts need.
    """
    wanted = _WANTED_DIMENSIONS[role]
    if not column.unit:
        hint = f'such as "{_EXAMPLES[role]}", or name it under [fit.columns] with its unit'
        table.refuse(f"{column.shown} has no unit", hint, column=column)
        return np.nan
    dimension = column.dimension
    if dimension == CURRENT in wanted:
        if section.torque_constant is None:
            raise UsageError(
                f"{column.shown} is a current, so the fit needs the torque constant",
                where="fit.torque_constant",
                hint='such as [fit] torque_constant = "0.12 N m/A", of the spool with its gear',
            )
        return float(SENSOR_UNITS[column.unit].factor) * section.torque_constant.single
    if dimension == COUNTS in wanted:
        if section.counts_per_turn is None:
            raise UsageError(
                f"{column.shown} is in counts, so the fit needs how many a turn has",
                where="fit.counts_per_turn",
                hint="such as [fit] counts_per_turn = 4096",
            )
        return 2.0 * math.pi / section.counts_per_turn.single
    if role in TENSION_CHANNELS and dimension == "mass":
        return force_factor(column.unit) or np.nan
    symbol = table.unit_of(column, wanted[0])
    return factor_of(symbol) if symbol else np.nan


def is_wished(column: Heading) -> bool:
    """Return True if a column holds what was asked of the motor."""
    return bool(_WISHED.search(_plain(column.header)))
