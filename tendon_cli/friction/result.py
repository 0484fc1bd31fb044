"""What a friction fit is: the numbers, where they come from, and how far they can be trusted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.display import Displayed, face
from tendon_cli.friction.reading.readings import Floats, Integers


@dataclass(frozen=True)
class FrictionUncertainty:
    """Standard error of μ and the parts it is made of."""

    scatter: float
    """From how the strokes scatter."""
    resolution: float
    """The least that the resolution of the readings allows."""
    bend_angle: float
    """From the uncertainty of the bend angle; 0 where none is given."""
    doubt: float
    """From offsets or a delay that the scatter may hide."""
    standard_error: float
    """Of all parts together."""
    degrees_of_freedom: float
    """Effective number (Welch-Satterthwaite); the interval takes Student's t from it."""
    interval_95: tuple[float, float]


@dataclass(frozen=True)
class DirectionFit:
    """μ from the readings of one direction alone, with the gain of the cells taken as 1, as the paper does it."""

    friction: float
    uncertainty: FrictionUncertainty | None
    """None where the direction has one stroke or reading only."""
    used: int
    """Readings used."""


@dataclass(frozen=True)
class SetAside:
    """Readings that are not used, for one reason."""

    reason: str
    rows: int
    lines: tuple[tuple[int, int], ...]
    """First and last line of the file of each stretch."""


@dataclass(frozen=True)
class Check:
    """One thing that may be wrong with the rig, as the readings tell it."""

    name: str
    value: float | None
    """None where the readings cannot tell it."""
    standard_error: float | None
    unit: str
    found: bool | None
    """Whether the readings show it; None where they cannot tell."""
    effect: float | None
    """What it does to μ where it is left out of the fit, as a share of μ."""


@dataclass(frozen=True, eq=False)
class FittedRows:
    """The readings one by one, as the figure shows them."""

    line: Integers
    """Line in the file."""
    log_ratio: Floats
    """ln(force at motor / force at load); NaN where there is no such reading."""
    way: Integers
    """+1 pulled toward the motor, -1 toward the load, 0 set aside."""
    bend_angle: Floats
    """rad."""
    stroke: Integers
    """Number of the stroke, -1 for a reading that is set aside."""
    residual: Floats
    """log_ratio minus the fitted line; NaN for a reading that is set aside."""
    force: Floats
    """Geometric mean of both cells, in the unit of the file; NaN where there is no such reading."""
    time: Floats | None
    """As in the file, if it has a column of numbers for it."""

    @property
    def used(self) -> npt.NDArray[np.bool_]:
        """Which readings the estimate rests on."""
        return self.stroke >= 0


@dataclass(frozen=True, eq=False)
class Parts:
    """Means over parts of strokes, by which the rig is checked."""

    way: Integers
    force: Floats
    """At the load, in the unit of the file."""
    rate: Floats | None
    """d ln F/dt, in the file's unit of time; None where it has none."""
    misfit: Floats
    """Log ratio less ±μφ and the gain, but before offsets, delay and the like."""
    effects: Floats
    """What the effects that were fitted make of it."""


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Displayed):
    """A friction coefficient with its uncertainty and provenance."""

    friction: float
    """Coulomb coefficient μ between tendon and sheath."""
    uncertainty: FrictionUncertainty
    gain_ratio: float
    """Gain of the motor's cell over that of the load's; 1 where it could not be estimated."""
    gain_estimated: bool
    by_direction: dict[str, DirectionFit]
    """"toward_motor" and "toward_load", as far as there are readings."""
    bend_angle_text: str
    """As given, or in degrees where it comes from a column."""
    bend_angle_uncertainty_text: str | None
    bend_angles: tuple[float, ...]
    """The different bend angles of the readings used, rad."""
    motor: str
    """"1" or "2", the cell at the motor."""
    is_log: bool
    """Whether slip was told from stick in a raw log; False for settled readings."""
    robust: bool
    strokes: int
    """Strokes used; settled readings count one each unless a column `stroke` says otherwise."""
    rows: FittedRows
    parts: Parts
    set_aside: tuple[SetAside, ...]
    checks: tuple[Check, ...]
    notes: tuple[str, ...]
    """What was inferred, and what the coefficient is sensitive to."""
    warnings: tuple[str, ...]
    """What may make this very number wrong."""
    unit: str | None
    """Of the forces; None where the file does not say."""
    source: str
    """Name of the file."""
    sha256: str

    @property
    def record(self) -> dict[str, Any]:
        """The fit as data, as `--json` prints it."""
        recorded: dict[str, Any] = face().record_of(self)
        return recorded

    @property
    def standard_error(self) -> float:
        """Of μ, all its parts together."""
        return self.uncertainty.standard_error

    @property
    def interval_95(self) -> tuple[float, float]:
        """In which μ lies with 95 %."""
        return self.uncertainty.interval_95
