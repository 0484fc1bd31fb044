"""What a friction fit is: the numbers, where they come from, and how far they can be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np
import pandas as pd

from tendon_cli.display import Displayed, face
from tendon_cli.friction.budget import BEND, FrictionUncertainty
from tendon_cli.friction.rig import BendAngle
from tendon_cli.friction.strokes import Presliding, Speed
from tendon_cli.friction.usable_rows import REASONS, USED

_MOST_RESIDUALS = 20
_MOST_STRETCHES = 20


@dataclass(frozen=True)
class DirectionFit:
    """μ from the readings of one direction alone, with the gain of the cells taken as 1, as the paper does it.

    The standard error is None if the direction has one stroke only; `plain` is the plain answer, the median of
    |ln ratio| over the bend angle by rows beyond the middle; `used` counts the readings.
    """

    friction: float
    standard_error: float | None
    plain: float
    used: int


@dataclass(frozen=True)
class SetAside:
    """Readings that are not used, for one reason, with the first and last line of the first 20 stretches of them."""

    reason: str
    rows: int
    lines: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Check:
    """One thing that may be wrong with the rig, and whether the readings show it; None if they cannot.

    `effect_on_friction` is what it does to μ if it is left out of the fit, as a share of μ.
    """

    name: str
    value: float | None
    standard_error: float | None
    unit: str
    found: bool | None
    effect_on_friction: float | None


@dataclass(frozen=True)
class Plain:
    """The plain answer: the mean of both directions' medians, in which gains cancel.

    Leaving rows out moves it, and effects and the weights of strokes move it further, each by a share of μ.
    """

    friction: float
    moved_by_rows: float
    moved_by_fit: float


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Displayed):
    """A friction coefficient with its uncertainty and provenance."""

    friction_bend: float
    """μφ; with several bend angles at their mean."""
    bend_angle: float | None
    """Mean of the bend angles used, rad; None if it was not given."""
    uncertainty: FrictionUncertainty
    """Of μ, or of μφ without a bend angle."""
    gain_ratio: float
    """Gain of the motor's cell over that of the load's; 1 if it could not be estimated."""
    by_direction: dict[str, DirectionFit]
    """"toward_motor" and "toward_load", as far as there are readings; gains need both."""
    plain: Plain
    bend: BendAngle
    """As given, or in degrees if it comes from a column; "not given"."""
    motor: str
    """"1" or "2", the cell at the motor."""
    is_log: bool
    """Whether the readings are a raw log, and not settled readings."""
    rows: pd.DataFrame
    """A row per reading: `line` and number of its `file`, forces `motor` and `load` (stated zeros taken off, in the
    unit of the file), `log_ratio` (NaN without one), `way` (+1 toward the motor, -1 toward the load, 0 if it is set
    aside before), `bend_angle` (rad), `run` (number of its stroke, -1 if none), `used`, `code` (why it is not),
    `residual` (NaN if not used), and, if the file has them, `time`, and the motor's `position` or `speed`."""
    stroke_table: pd.DataFrame
    """A row per stroke, used or not: what `--strokes` writes."""
    speed: Speed | None
    """How μ goes with speed, if the strokes have different speeds."""
    presliding: Presliding | None
    """Stiffness and backlash of the motor's end, if a position is read."""
    files: tuple[dict[str, Any], ...]
    """μ of each file, if there are several."""
    points: pd.DataFrame
    """Means over parts of strokes, by which the rig is checked: `way`, `force` at the load, `rate` d ln F/dt if there
    is a time, `misfit` of the log ratio before effects, and what the `effects` that were fitted make of it."""
    checks: tuple[Check, ...]
    notes: tuple[str, ...]
    """What was inferred, and what the coefficient is sensitive to."""
    warnings: tuple[str, ...]
    """What may make this very number wrong."""
    unit: str | None
    """Of the forces; None if the file does not say."""
    source: str
    """Name of the file."""
    sha256: str

    @property
    def text(self) -> str:
        """The fit in words."""
        return str(face().fit_text(self))

    @property
    def strokes(self) -> int:
        """How many are used."""
        return int(np.count_nonzero(self.stroke_table["used"]))

    @property
    def bend_angles(self) -> tuple[float, ...]:
        """The different bend angles of the readings used, rad; empty if none is given."""
        return (
            ()
            if self.bend_angle is None
            else tuple(np.unique(self.rows["bend_angle"][self.rows["used"]]).tolist())
        )

    @property
    def set_aside(self) -> tuple[SetAside, ...]:
        """The readings not used, by reason, in the order in which the reasons first come."""
        parts, lines, codes = [], self.rows["line"].to_numpy(), self.rows["code"].to_numpy()
        for code in pd.unique(codes[codes != USED]):
            mine = np.flatnonzero(codes == code)
            border = np.flatnonzero(np.diff(mine) > 1)[:_MOST_STRETCHES]
            ends = zip(mine[np.append(0, border + 1)], mine[np.append(border, -1)], strict=True)
            stretches = [(int(lines[first]), int(lines[last])) for first, last in ends]
            parts.append(SetAside(REASONS[code], len(mine), tuple(stretches[:_MOST_STRETCHES])))
        return tuple(parts)

    @property
    def record(self) -> dict[str, Any]:
        """The fit as plain JSON values, as `--json` prints it; angles in rad."""
        used = self.rows[self.rows["used"]]
        left = used["residual"].to_numpy()
        largest = np.argsort(-np.abs(left), kind="stable")[:_MOST_RESIDUALS]
        lines, angles = used["line"].to_numpy(), self.bend_angles
        names = (
            "friction",
            "standard_error",
            "interval_95",
            "friction_bend",
            "friction_bend_standard_error",
            "friction_bend_interval_95",
            "gain_ratio",
            "by_direction",
            "plain",
            "strokes",
            "speed",
            "presliding",
            "files",
            "set_aside",
            "warnings",
            "notes",
            "checks",
            "unit",
            "source",
            "sha256",
        )
        record: dict[str, Any] = _data({name: getattr(self, name) for name in names})
        return record | {
            "bend_angle": _data(angles if len(angles) > 1 else angles[0] if angles else None),
            "budget": _data(self.uncertainty.parts),
            "coverage_factor": self.uncertainty.coverage,
            "degrees_of_freedom": _data(self.uncertainty.degrees_of_freedom),
            "used": len(used),
            "residuals": {
                "rms": float(np.sqrt(np.mean(left**2))),
                "max": float(np.max(np.abs(left))),
                "rows": [{"line": int(lines[at]), "residual": float(left[at])} for at in largest],
            },
        }

    @property
    def fitted(self) -> float:
        """μ, or μφ without a bend angle."""
        return self.friction_bend / (self.bend_angle or 1.0)

    @property
    def from_plain(self) -> float:
        """How far the fit is from the plain answer, as a share of that."""
        return self.fitted / self.plain.friction - 1.0 if self.plain.friction else 0.0

    @property
    def friction(self) -> float | None:
        """Coulomb coefficient μ between tendon and sheath; None without a bend angle."""
        return None if self.bend_angle is None else self.fitted

    @property
    def standard_error(self) -> float | None:
        """Of μ, all its parts together."""
        return None if self.bend_angle is None else self.uncertainty.standard_error

    @property
    def interval_95(self) -> tuple[float, float] | None:
        """In which μ lies with 95 %."""
        return None if self.bend_angle is None else self.uncertainty.interval_95

    @property
    def friction_bend_standard_error(self) -> float:
        """Of μφ, in which the uncertainty of the bend angle has no part."""
        variance = self.uncertainty.standard_error**2 - self.uncertainty.of(BEND) ** 2
        return math.sqrt(max(variance, 0.0)) * (self.bend_angle or 1.0)

    @property
    def friction_bend_interval_95(self) -> tuple[float, float]:
        """In which μφ lies with 95 %."""
        half = self.uncertainty.coverage * self.friction_bend_standard_error
        return self.friction_bend - half, self.friction_bend + half


def _data(value: Any) -> Any:
    """Plain JSON values; what is infinite is null."""
    if is_dataclass(value):
        return {each.name: _data(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, dict):
        return {name: _data(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_data(part) for part in value]
    return None if isinstance(value, float) and math.isinf(value) else value
