"""What a friction fit is: the numbers, where they come from, and how far they can be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from tendon_cli.display import Displayed, face
from tendon_cli.friction.budget import BEND, FrictionUncertainty
from tendon_cli.friction.reading.readings import Floats, Integers
from tendon_cli.friction.rows import FittedRows
from tendon_cli.friction.strokes import Presliding, Speed, StrokeRow


@dataclass(frozen=True)
class DirectionFit:
    """μ from the readings of one direction alone, with the gain of the cells taken as 1, as the paper does it."""

    friction: float
    standard_error: float | None
    """None if the direction has one stroke only."""
    used: int
    """Readings used."""
    plain: float
    """The plain answer: the median of |ln ratio| over the bend angle, by rows beyond the middle."""


@dataclass(frozen=True)
class SetAside:
    """Readings that are not used, for one reason."""

    reason: str
    rows: int
    lines: tuple[tuple[int, int], ...]
    """First and last line of the file of the first 20 stretches."""


@dataclass(frozen=True)
class Check:
    """One thing that may be wrong with the rig, as the readings show it."""

    name: str
    value: float | None
    """None if the readings cannot tell it."""
    standard_error: float | None
    unit: str
    found: bool | None
    """Whether the readings show it; None if they cannot tell."""
    effect: float | None
    """What it does to μ if it is left out of the fit, as a share of μ."""


@dataclass(frozen=True)
class Plain:
    """The plain answer beside the fit."""

    friction: float
    """Mean of both directions' medians, which gains cancel in."""
    set_aside: float
    """Share of μ by which leaving rows out moves it."""
    fitted: float
    """Share of μ by which effects and the weights of strokes move it further."""


@dataclass(frozen=True, eq=False)
class Parts:
    """Means over parts of strokes, by which the rig is checked."""

    way: Integers
    force: Floats
    """At the load, in the unit of the file."""
    rate: Floats | None
    """d ln F/dt, in the file's unit of time; None if it has none."""
    misfit: Floats
    """Log ratio less ±μφ and the gain, but before offsets, delay and the like."""
    effects: Floats
    """What the effects that were fitted make of it."""


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
    gain_estimated: bool
    by_direction: dict[str, DirectionFit]
    """"toward_motor" and "toward_load", as far as there are readings."""
    plain: Plain
    bend_angle_text: str
    """As given, or in degrees if it comes from a column; "not given"."""
    bend_angle_uncertainty_text: str | None
    bend_angles: tuple[float, ...]
    """The different bend angles of the readings used, rad; empty if none is given."""
    motor: str
    """"1" or "2", the cell at the motor."""
    is_log: bool
    """Whether slip was told from stick in a raw log; False for settled readings."""
    strokes: int
    """Strokes used."""
    rows: FittedRows
    stroke_table: tuple[StrokeRow, ...]
    """Every stroke, used or not."""
    speed: Speed | None
    """How μ goes with speed, if the strokes have different speeds."""
    presliding: Presliding | None
    """Stiffness and backlash of the motor's end, if a position is read."""
    files: tuple[dict[str, Any], ...]
    """μ of each file, if there are several."""
    parts: Parts
    set_aside: tuple[SetAside, ...]
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
    def record(self) -> dict[str, Any]:
        """The fit as data, as `--json` prints it."""
        recorded: dict[str, Any] = face().record_of(self)
        return recorded

    @property
    def _scale(self) -> float:
        """What makes μφ of the number that was fitted."""
        return self.bend_angle or 1.0

    @property
    def fitted(self) -> float:
        """μ, or μφ without a bend angle."""
        return self.friction_bend / self._scale

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
        """Of μφ, in which the bend angle's own uncertainty has no part."""
        return math.sqrt(max(self.uncertainty.standard_error**2 - self.uncertainty.of(BEND) ** 2, 0.0)) * self._scale

    @property
    def friction_bend_interval_95(self) -> tuple[float, float]:
        """In which μφ lies with 95 %."""
        half = self.uncertainty.coverage * self.friction_bend_standard_error
        return self.friction_bend - half, self.friction_bend + half
