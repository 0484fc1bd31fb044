"""Columns of a suit's log: the channel that each header names, and its unit.

A header is understood by its words, English or German, or because `[fit.columns]` of the study
names it.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, replace

from tendon_cli.errors import InputError, UsageError
from tendon_cli.friction.reading.header import Heading, force_factor, named_column
from tendon_cli.units import UNITS, shorten

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

_UNITS = {
    **{symbol.casefold(): symbol for symbol in UNITS if symbol not in ("1", "t", "mN", "MPa")},
    "mnm": "mN m",
    "mn m": "mN m",
    "n.m": "N m",
    "n-m": "N m",
    "ncm": "N cm",
    "n cm": "N cm",
    "newton meter": "N m",
    "newtonmeter": "N m",
    "degree": "deg",
    "degrees": "deg",
    "grad": "deg",
    "radian": "rad",
    "radians": "rad",
    "umdrehungen": "rev",
    "turns": "rev",
    "sec": "s",
    "seconds": "s",
    "sekunden": "s",
    "newton": "N",
    "a": "A",
    "ma": "mA",
    "ampere": "A",
    "counts": COUNTS,
    "count": COUNTS,
    "ticks": COUNTS,
    "inkremente": COUNTS,
    "cts": COUNTS,
    "us": "us",
    "µs": "us",
}
"""Units as headers write them, without case."""
_FACTORS = {"mN m": 1e-3, "N cm": 1e-2, "us": 1e-6}
"""Units that headers have and studies have not, in SI."""
_AMPERES = {"A": 1.0, "mA": 1e-3}
_DIMENSIONS = {"mN m": "torque", "N cm": "torque", "us": "time", "A": CURRENT, "mA": CURRENT}
_DIMENSIONS[COUNTS] = COUNTS

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


@dataclass(frozen=True)
class Scaling:
    """Factors that a study gives for columns that are no quantity of the model by themselves."""

    torque_constant: float | None = None
    """Torque of the spool per current, N m/A."""
    counts_per_turn: float | None = None
    """Counts of the encoders in a turn."""


def unit_and_text(header: str) -> tuple[str | None, str]:
    """Split the unit, in brackets or at the end, from a header.

    Returns:
        Symbol of the unit, None if the header has none that is known, and the rest of the header.
    """
    text = unicodedata.normalize("NFKC", header).strip()
    for match in re.finditer(r"[(\[{]([^()\[\]{}]*)[)\]}]", text):
        unit = _symbol(match.group(1))
        if unit is not None:
            return unit, f"{text[: match.start()]} {text[match.end() :]}".strip()
    words = re.split(r"[\s_,/]+", text)
    for count in (2, 1):
        unit = _symbol(" ".join(words[-count:])) if len(words) > count else None
        if unit is not None:
            return unit, " ".join(words[:-count])
    return None, text


def _symbol(text: str) -> str | None:
    """Return the unit that a text stands for; None if it is none."""
    return _UNITS.get(" ".join(text.replace("*", "·").split()).casefold())


def dimension_of(unit: str | None) -> str | None:
    """Return the dimension of a unit of a header; None for no unit."""
    if unit is None:
        return None
    return _DIMENSIONS.get(unit) or UNITS[unit].dimension


def suit_columns(headers: list[str], named: Mapping[str, str]) -> list[Heading]:
    """Return the columns of a log with their roles and units.

    Args:
        headers: Headers of all columns.
        named: Headers that the study names, by column.
    """
    found = [_heading(place, header) for place, header in enumerate(headers)]
    for role, wanted in named.items():
        unit, _ = unit_and_text(wanted)
        match = named_column(found, wanted) or _without_unit(found, wanted)
        if match is None:
            continue
        found = [replace(one, role="") if one.role == role else one for one in found]
        found[match.index] = replace(match, role=role, unit=match.unit or unit)
    return found


def _without_unit(columns: list[Heading], wanted: str) -> Heading | None:
    """Return the column whose header is a wanted one but for the unit that the study adds."""
    _, text = unit_and_text(wanted)
    return named_column(columns, text)


def _heading(place: int, header: str) -> Heading:
    """Find role and unit of a column by the words of its header."""
    unit, text = unit_and_text(header)
    plain = re.sub(r"[_\-.]+", " ", text.casefold())
    words = set(re.findall(r"[^\W\d_]+", plain))
    role = "" if _WISHED.search(plain) else _role(plain, words, dimension_of(unit))
    return Heading(place, header, role, unit)


def _role(text: str, words: set[str], dimension: str | None) -> str:
    """Return the column that words and a dimension mean; empty if they mean none."""

    def has(*stems: str) -> bool:
        """Return True if a short stem is a word, or a longer one is part of one."""
        return any(stem in words if len(stem) < 4 else stem in text for stem in stems)

    if has(*_DERIVED):
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
        return _bare_angle(has(*_SPOOL), has(*_JOINT_ALONE))
    if has(*_ANGLE_WORDS) and (is_angle or dimension is None):
        if has(*_SPOOL) and not has("elbow", "ellbogen", "joint", "gelenk"):
            return SPOOL_ANGLE
        return ELBOW_ANGLE if has(*_JOINT) else ""
    if dimension == "mass" and has(*_LOAD_WORDS):
        return LOAD_MASS
    return ""


def _bare_angle(is_spool: bool, is_joint: bool) -> str:
    """Return the angle that a header names by its place alone; empty if the words leave it open."""
    if is_spool == is_joint:
        return ""
    return SPOOL_ANGLE if is_spool else ELBOW_ANGLE


def _tension(is_flexor: bool, is_extensor: bool, is_proximal: bool, is_distal: bool) -> str:
    """Return the channel of a cell by its side and end; empty if the words leave it open."""
    if is_flexor == is_extensor or is_proximal == is_distal:
        return ""
    side = "flexor" if is_flexor else "extensor"
    return f"{side}_tension_{'proximal' if is_proximal else 'distal'}"


def si_factor(column: Heading, scaling: Scaling, place: str) -> float:
    """Return the factor from the numbers of a column to SI.

    Args:
        column: Column with a role.
        scaling: Torque constant and counts per turn of the study.
        place: Place of the header, for messages.

    Raises:
        InputError: if the header gives no unit, or one of another quantity.
        UsageError: if the study lacks what current or counts need.
    """
    unit = column.unit
    role = column.role
    example = f'such as "{_EXAMPLES[role]}", or name it under [fit.columns] with its unit'
    if unit is None:
        if role == TIME:
            return 1.0
        raise InputError(f"{column.shown} has no unit", where=place, hint=example)
    dimension = dimension_of(unit)
    if dimension not in _WANTED_DIMENSIONS[role]:
        quantity = role.replace("_", " ")
        problem = f'{column.shown} is in "{unit}", which is not a unit of a {quantity}'
        raise InputError(problem, where=place, hint=example)
    if dimension == CURRENT:
        if scaling.torque_constant is None:
            problem = f"{column.shown} is a current, so the fit needs the torque constant"
            hint = 'such as [fit] torque_constant = "0.12 N m/A", of the spool with its gear'
            raise UsageError(problem, where="fit.torque_constant", hint=hint)
        return _AMPERES[unit] * scaling.torque_constant
    if dimension == COUNTS:
        if scaling.counts_per_turn is None:
            problem = f"{column.shown} is in counts, so the fit needs how many a turn has"
            hint = "such as [fit] counts_per_turn = 4096"
            raise UsageError(problem, where="fit.counts_per_turn", hint=hint)
        return 6.283185307179586 / scaling.counts_per_turn
    if dimension in ("force", "mass") and role in TENSION_CHANNELS:
        return force_factor(unit) or 1.0
    return _FACTORS.get(unit) or float(UNITS[unit].factor)


def wished_columns(columns: list[Heading]) -> list[str]:
    """Return the headers of columns that hold what was asked of the motor."""
    return [
        shorten(column.header, 40)
        for column in columns
        if _WISHED.search(re.sub(r"[_\-.]+", " ", column.header.casefold()))
    ]
