"""How fast the force changes while the tendon slips: d ln F/dt, which tells a late cell.

Differences of noisy readings are mostly noise, and a column of the fit that is mostly noise comes out too small (the
errors-in-variables bias). A force changes smoothly within a stroke, so its rate is the derivative of a curve through
the stroke, of the lowest degree that the readings allow.
"""

from __future__ import annotations

import numpy as np

from tendon_cli.friction.reading.readings import Floats, Integers

_LOWEST, _HIGHEST = 2, 5


def rates_of(time: Floats, log_force: Floats, stroke: Integers) -> Floats | None:
    """d ln F/dt of each point, per unit of time; strokes are consecutive points. None where time does not advance."""
    if np.any((np.diff(time) <= 0.0) & (np.diff(stroke) == 0)):
        return None
    strokes = np.split(np.arange(len(time)), np.flatnonzero(np.diff(stroke)) + 1)
    degree = _degree([(time[rows], log_force[rows]) for rows in strokes if len(rows) > _HIGHEST + 1])
    rate = np.zeros(len(time))
    for rows in strokes:
        if degree < min(_HIGHEST, len(rows) - 1):
            curve = np.polynomial.Polynomial.fit(time[rows], log_force[rows], degree)
            rate[rows] = curve.deriv()(time[rows])
        elif len(rows) > 1:
            rate[rows] = np.gradient(log_force[rows], time[rows], edge_order=2 if len(rows) > 2 else 1)
    return rate


def _degree(strokes: list[tuple[Floats, Floats]]) -> int:
    """Degree of the curves by Akaike's criterion, all strokes together; the highest where no curve is good enough."""
    left = np.zeros(_HIGHEST + 1)
    size = 0
    for time, log_force in strokes:
        basis, _ = np.linalg.qr(np.polynomial.legendre.legvander(2.0 * (time - time[0]) / np.ptp(time) - 1.0, _HIGHEST))
        left += np.sum((log_force - np.mean(log_force)) ** 2) - np.cumsum(
            (basis.T @ log_force) ** 2 * (np.arange(_HIGHEST + 1) > 0)
        )
        size += len(time)
    if not size:
        return _HIGHEST
    degrees = np.arange(_LOWEST, _HIGHEST + 1)
    scatter = np.maximum(left[_LOWEST:], 1e-24 * size)
    unknown = len(strokes) * (degrees + 1.0)
    # With the correction for samples that are small against the unknowns.
    penalty = 2.0 * unknown * size / np.maximum(size - unknown - 1.0, 1e-9)
    return int(degrees[np.argmin(size * np.log(scatter) + penalty)])
