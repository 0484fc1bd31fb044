"""Friction coefficients fitted to the engine's rope over a drum, against those of its contacts."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import tendon_cli as tendon
from verification import capstan

FRICTIONS = (0.05, 0.1, 0.3)
TOLERANCE = 0.01


@dataclass(frozen=True)
class RopeFit:
    """A coefficient given to the engine's contacts, and the fit of tendon to the readings."""

    given: float
    fitted: float
    interval_95: tuple[float, float]
    zero_rows: int
    """Number of readings in which a cell reads no force; they are left in."""
    rows: int
    found: tuple[str, ...]
    """Effects of the rig that the fit reports; this rig has none."""

    @property
    def error(self) -> float:
        """Error as a share of the given coefficient."""
        return self.fitted / self.given - 1.0

    @property
    def holds(self) -> bool:
        """True if within the tolerance; a value that is not a number never is."""
        return bool(abs(self.error) <= TOLERANCE)


def fits() -> list[RopeFit]:
    """Fit each coefficient to a log, which is written as a file and read by tendon."""
    with tempfile.TemporaryDirectory() as folder:
        return [_fit(friction, Path(folder) / "cells.csv") for friction in FRICTIONS]


def _fit(friction: float, file: Path) -> RopeFit:
    """Drag the rope with a coefficient, and fit it to the readings."""
    time, motor, load = capstan.readings(friction)
    np.savetxt(
        file,
        np.column_stack([time, motor, load]),
        "%.3f",
        ",",
        header="time_s,force_motor_N,force_load_N",
        comments="",
    )
    # The engine's forces have no zero error.
    fit = tendon.fit_friction(file, bend_angle=float(capstan.TURN), cell_uncertainty="0 N")
    reads_zero = (motor.round(3) <= 0.0) | (load.round(3) <= 0.0)
    return RopeFit(
        given=friction,
        fitted=fit.friction,
        interval_95=fit.uncertainty.interval_95,
        zero_rows=int(np.sum(reads_zero)),
        rows=len(time),
        found=tuple(check.name for check in fit.checks if check.found),
    )


def table(rows: list[RopeFit]) -> str:
    """Return the fits as a Markdown table."""
    heads = (
        "μ of the contacts",
        "μ fitted",
        "error",
        "95 % interval",
        "rows of zero force",
        "effects found",
        "verdict",
    )
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for row in rows:
        low, high = row.interval_95
        cells = (
            f"{row.given:g}",
            f"{row.fitted:.5f}",
            f"{100.0 * row.error:+.2f} %",
            f"{low:.5f} to {high:.5f}",
            f"{row.zero_rows} of {row.rows}",
            ", ".join(row.found).replace("_", " ") or "none",
            "holds" if row.holds else "MISSED",
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
