"""What a friction fit is: the numbers, where they come from, and how far they can be trusted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.reading.readings import Floats, Integers


@dataclass(frozen=True)
class Uncertainty:
    """Standard error of μ and the parts it is made of."""

    scatter: float
    """From how the strokes scatter."""
    resolution: float
    """The least that the resolution of the readings allows."""
    bend_angle: float
    """From the uncertainty of the bend angle; 0 where none is given."""
    standard_error: float
    """Of all parts together."""
    degrees_of_freedom: float
    """Effective number (Welch-Satterthwaite); the interval takes Student's t from it."""
    interval_95: tuple[float, float]


@dataclass(frozen=True)
class DirectionFit:
    """μ from the readings of one direction alone, with the gain of the cells taken as 1, as the paper does it."""

    friction: float
    uncertainty: Uncertainty | None
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


@dataclass(frozen=True, eq=False)
class Rows:
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
    time: Floats | None
    """As in the file, if it has a column of numbers for it."""

    @property
    def used(self) -> npt.NDArray[np.bool_]:
        """Which readings the estimate rests on."""
        return self.stroke >= 0


@dataclass(frozen=True, eq=False)
class FrictionFit:
    """A friction coefficient with its uncertainty and provenance."""

    friction: float
    """Coulomb coefficient μ between tendon and sheath."""
    uncertainty: Uncertainty
    gain_ratio: float
    """Gain of the motor's cell over that of the load's; 1 where it could not be estimated."""
    gain_estimated: bool
    offsets: tuple[float, float] | None
    """Readings of the unloaded motor's and load's cell, in the unit of the file; None where not asked for."""
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
    rows: Rows
    set_aside: tuple[SetAside, ...]
    warnings: tuple[str, ...]
    source: str
    """Name of the file."""
    sha256: str
