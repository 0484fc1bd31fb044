"""Result of a friction fit: the numbers, where they come from, how far they can be trusted."""

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
"""Number of the largest residuals that a record lists."""
_MOST_STRETCHES = 20
"""Largest number of stretches of readings that are listed for each reason to set them aside."""
_RECORDED = (
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
"""Fields and properties of a fit that its record has under the same names."""


@dataclass(frozen=True)
class DirectionFit:
    """Fit of one direction alone, with the gain of the cells taken as 1, as the paper does it."""

    friction: float
    """μ."""
    standard_error: float | None
    """Standard error of μ; None if the direction has only one stroke."""
    plain: float
    """Plain answer: the median of |ln ratio| over the bend angle, by rows beyond the middle."""
    used: int
    """Number of readings used."""


@dataclass(frozen=True)
class SetAside:
    """Readings that are not used, for one reason."""

    reason: str
    rows: int
    """Number of readings."""
    lines: tuple[tuple[int, int], ...]
    """First and last line of the first 20 stretches of them."""


@dataclass(frozen=True)
class Check:
    """Check of one thing that may be wrong with the rig."""

    name: str
    value: float | None
    """None if the readings cannot show it."""
    standard_error: float | None
    unit: str
    found: bool | None
    """True if the readings show it, False if they do not; None if they cannot."""
    effect_on_friction: float | None
    """Change of μ if it is left out of the fit, as a share of μ."""


@dataclass(frozen=True)
class PlainAnswer:
    """Plain answer, and the reasons why the fit differs from it."""

    friction: float
    """Mean of both directions' medians, in which gains cancel."""
    moved_by_rows: float
    """Change of μ if rows are set aside, as a share of μ."""
    moved_by_fit: float
    """Further change of μ by the effects and the weights of strokes, as a share of μ."""


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Displayed):
    """Friction coefficient with its uncertainty and provenance."""

    friction_bend: float
    """μφ; with several bend angles at their mean."""
    bend_angle: float | None
    """Mean of the bend angles used, rad; None if it was not given."""
    uncertainty: FrictionUncertainty
    """Uncertainty of μ, or of μφ without a bend angle."""
    gain_ratio: float
    """Gain of the motor's cell over that of the load's; 1 if it could not be estimated."""
    by_direction: dict[str, DirectionFit]
    """"toward_motor" and "toward_load", as far as there are readings; the gain needs both."""
    plain: PlainAnswer
    bend: BendAngle
    """Bend angle as given, or in degrees if it comes from a column; "not given"."""
    motor: str
    """"1" or "2", the cell at the motor."""
    is_log: bool
    """True if the readings are a raw log rather than settled readings."""
    rows: pd.DataFrame
    """Table with a row per reading.

    It has `line` and number of its `file`, forces `motor` and `load` (stated zeros taken off, in
    the unit of the file), `log_ratio` (NaN without one), `way` (+1 toward the motor, -1 toward the
    load, 0 if it is set aside before), `bend_angle` (rad), `run` (number of its stroke, -1 if
    none), `used`, `code` (why it is not), `residual` (NaN if not used), and, if the file has them,
    `time`, and the motor's `position` or `speed`.
    """
    stroke_table: pd.DataFrame
    """Table with a row per stroke, used or not, that `--strokes` writes."""
    speed: Speed | None
    """Dependence of μ on speed, if the strokes have different speeds."""
    presliding: Presliding | None
    """Stiffness and backlash of the motor's end, if a position is read."""
    files: tuple[dict[str, Any], ...]
    """μ of each file, if there are several."""
    points: pd.DataFrame
    """Table of means over parts of strokes, by which the rig is checked.

    It has `way`, `force` at the load, `rate` d ln F/dt if there is a time, `misfit` of the log
    ratio before effects, the part of it that the `effects` that were fitted explain, and the part
    of these that a `delay` explains.
    """
    checks: tuple[Check, ...]
    notes: tuple[str, ...]
    """Sentences on what was inferred, and on what the coefficient is sensitive to."""
    warnings: tuple[str, ...]
    """Sentences on what may make this very number wrong."""
    unit: str | None
    """Unit of the forces; None if the file does not say."""
    source: str
    """Name of the file."""
    sha256: str

    @property
    def text(self) -> str:
        """Report of the fit in words."""
        return str(face().fit_text(self))

    @property
    def strokes(self) -> int:
        """Number of strokes used."""
        return int(np.count_nonzero(self.stroke_table["used"]))

    @property
    def bend_angles(self) -> tuple[float, ...]:
        """Different bend angles of the readings used, rad; empty if none is given."""
        if self.bend_angle is None:
            return ()
        return tuple(np.unique(self.rows["bend_angle"][self.rows["used"]]).tolist())

    @property
    def set_aside(self) -> tuple[SetAside, ...]:
        """Readings not used, by reason, in the order in which the reasons first occur."""
        parts = []
        lines = self.rows["line"].to_numpy()
        codes = self.rows["code"].to_numpy()
        for code in pd.unique(codes[codes != USED]):
            rows = np.flatnonzero(codes == code)
            border = np.flatnonzero(np.diff(rows) > 1)[:_MOST_STRETCHES]
            first = rows[np.append(0, border + 1)]
            last = rows[np.append(border, -1)]
            stretches = [
                (int(lines[start]), int(lines[end])) for start, end in zip(first, last, strict=True)
            ]
            parts.append(SetAside(REASONS[code], len(rows), tuple(stretches[:_MOST_STRETCHES])))
        return tuple(parts)

    @property
    def record(self) -> dict[str, Any]:
        """Fit as plain JSON values, as `--json` prints it; angles in rad."""
        used = self.rows[self.rows["used"]]
        residuals = used["residual"].to_numpy()
        lines = used["line"].to_numpy()
        largest = np.argsort(-np.abs(residuals), kind="stable")[:_MOST_RESIDUALS]
        bend_angle: float | tuple[float, ...] | None = None
        if len(self.bend_angles) == 1:
            bend_angle = self.bend_angles[0]
        elif self.bend_angles:
            bend_angle = self.bend_angles
        record: dict[str, Any] = _data({name: getattr(self, name) for name in _RECORDED})
        return record | {
            "bend_angle": _data(bend_angle),
            "budget": _data(self.uncertainty.parts),
            "coverage_factor": self.uncertainty.coverage,
            "degrees_of_freedom": _data(self.uncertainty.degrees_of_freedom),
            "used": len(used),
            "residuals": {
                "rms": float(np.sqrt(np.mean(residuals**2))),
                "max": float(np.max(np.abs(residuals))),
                "rows": [
                    {"line": int(lines[row]), "residual": float(residuals[row])} for row in largest
                ],
            },
        }

    @property
    def fitted(self) -> float:
        """μ, or μφ without a bend angle."""
        return self.friction_bend / (self.bend_angle or 1.0)

    @property
    def from_plain(self) -> float:
        """Difference of the fit from the plain answer, as a share of that."""
        if not self.plain.friction:
            return 0.0
        return self.fitted / self.plain.friction - 1.0

    @property
    def friction(self) -> float | None:
        """Coulomb coefficient μ between tendon and sheath; None without a bend angle."""
        return None if self.bend_angle is None else self.fitted

    @property
    def standard_error(self) -> float | None:
        """Standard error of μ, all its parts together."""
        return None if self.bend_angle is None else self.uncertainty.standard_error

    @property
    def interval_95(self) -> tuple[float, float] | None:
        """95 % interval of μ."""
        return None if self.bend_angle is None else self.uncertainty.interval_95

    @property
    def friction_bend_standard_error(self) -> float:
        """Standard error of μφ, to which the uncertainty of the bend angle adds nothing."""
        variance = self.uncertainty.standard_error**2 - self.uncertainty.contribution_of(BEND) ** 2
        return math.sqrt(max(variance, 0.0)) * (self.bend_angle or 1.0)

    @property
    def friction_bend_interval_95(self) -> tuple[float, float]:
        """95 % interval of μφ."""
        half = self.uncertainty.coverage * self.friction_bend_standard_error
        return self.friction_bend - half, self.friction_bend + half


def _data(value: Any) -> Any:
    """Convert to plain JSON values; infinite numbers become null."""
    if is_dataclass(value):
        return {field.name: _data(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {name: _data(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_data(part) for part in value]
    if isinstance(value, float) and math.isinf(value):
        return None
    return value
