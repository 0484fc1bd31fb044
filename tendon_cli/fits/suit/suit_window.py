"""Window of the fitted suit, and which number leaves most of the doubt in it.

The window without slack and instability moves with each number; with the covariance of the fit this
is the uncertainty of its nearer end. What a number leaves of it is what would go if it were known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.fits.log_rows import Floats
from tendon_cli.fits.suit import parameters as names
from tendon_cli.fits.suit.fitted_numbers import FittedNumber
from tendon_cli.fits.suit.parameters import loads_of_study
from tendon_cli.fits.suit.suit_estimate import SuitEstimate
from tendon_cli.fits.suit.suit_model import SuitModel, stepped
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.window import ends_of_states
from tendon_cli.studies.space.axis import PRETENSION

_STEP = 1e-4
_GRID = 31
"""Angles at which the window of a suit is worked out."""
_LEAST_SHARE = 0.05
"""Least share of the doubt in the window for a number to be named."""
_MOST_NAMED = 3
_RESTS = 0.2
"""Share of the doubt in a number, from which it rests on another number that the logs do not tell:
three deviations of that one then take it two thirds of the way out of its interval."""
_TELLS = (
    ("arm.upper_arm_angle", "hang the upper arm at a known angle"),
    ("arm.forearm", "weigh the forearm by a scale under the wrist, the elbow free"),
    ("arm.", "measure the anchors on the wearer to 1 mm"),
    (names.JOINT_ZERO, "check the joint sensor at two known angles"),
    (names.JOINT_GAIN, "check the joint sensor at two known angles"),
    ("load ", "weigh the loads"),
    ("load.", "weigh the load, or log another one"),
    ("torque", "calibrate the torque with a weight on the spool"),
    ("gear", "log the torque with the tendons off, and with a weight on the spool"),
    ("joint.", "log with the tendons off, or with another load"),
    ("spring.", "weigh the spring out: its stretch under a known weight"),
    ("spool", "measure the spool with its rope on"),
    ("sheath.bend", "measure the bend of the sheath as worn"),
    ("", "log with a load cell at the flexor's motor end, or with another load"),
)
"""Advice on what tells a number, by the beginning of its key."""


@dataclass(frozen=True)
class Doubt:
    """Number that leaves doubt in the window, and what would tell it."""

    key: str
    share: float
    """Share of the variance of the nearer end of the window that would go if it were known."""
    advice: str


def window_ends(model: SuitModel, scores: Floats, loads: Floats) -> Floats:
    """Return both ends of the window without slack and instability of suits, F0 in N.

    Args:
        model: The study with its parameters.
        scores: Normal scores, (sets, parameters).
        loads: Masses of the loads that one pretension must suit, kg.

    Returns:
        Ends, (sets, 2); NaN where no pretension can do.
    """
    design = model.design(model.values(scores))
    motion = model.study.motion.elbow_angle
    low, high = motion.extremes
    angles = np.linspace(low, high, _GRID)[np.newaxis, np.newaxis]
    flexion = np.array([True, False])[np.newaxis, :, np.newaxis]
    least = []
    largest = []
    for load in loads:
        state = State.of(replace(design, load_mass=load), angles, flexion)
        ends = ends_of_states(state, Bounds())
        least.append(ends.low.max(axis=(1, 2)))
        largest.append(ends.high.min(axis=(1, 2)))
    return np.stack([np.max(least, axis=0), np.min(largest, axis=0)], axis=-1)


@dataclass(frozen=True)
class FittedWindow:
    """Window without slack and instability of the fitted suit, and its pretension in it."""

    low: float
    """Lower end, F0 in N; NaN without a window."""
    high: float
    """Upper end, F0 in N; infinite without one."""
    pretension: float
    """Fitted F0, N."""
    margin: float
    """Distance of the pretension from the nearer end, N; below 0 outside of the window."""
    margin_std: float
    """Standard deviation of this distance, N."""
    loads: tuple[float, ...]
    """Loads in the hand, kg."""

    @property
    def record(self) -> dict[str, Any]:
        """The window by the names of JSON."""
        return {
            "from": self.low,
            "to": self.high,
            "pretension": self.pretension,
            "margin": self.margin,
            "margin_std": self.margin_std,
            "loads": self.loads,
        }

    @property
    def text(self) -> str:
        """The window and the pretension in words."""
        loads = f"{say.number(self.loads[0], 3)} kg"
        if len(self.loads) > 1:
            loads = f"{say.number(self.loads[0], 3)} to {say.number(self.loads[-1], 3)} kg"
        keeps = f"keeps both tendons taut and the elbow stable with {loads} in the hand"
        only = ""
        if min(self.loads) > 0.0:
            only = f"; only for {loads}: an empty hand was not judged; add 0 kg to load.mass"
        if not self.low <= self.high:
            return f"no pretension {keeps}{only}"
        span = f"{say.number(self.low, 3)} N to {say.number(self.high, 3)} N"
        if math.isinf(self.high):
            span = f"{say.number(self.low, 3)} N or more"
        away = f"{say.number(abs(self.margin), 2)} N ± {say.number(self.margin_std, 2)} N"
        value = say.number(self.pretension, 3)
        where = f"the fitted {value} N lies inside, {away} from the nearer end"
        if self.margin < 0.0:
            way = "low" if self.pretension < self.low else "high"
            where = f"the fitted {value} N is {away} too {way}"
        return f"a pretension of {span} {keeps}; {where}{only}"


def loads_judged(estimate: SuitEstimate) -> Floats:
    """Return the different loads of the logs and of the study, which the window must suit, kg."""
    of_logs = estimate.parts.load
    return np.union1d(of_logs[~np.isnan(of_logs)], loads_of_study(estimate.model.study))


def fitted_window(
    estimate: SuitEstimate, numbers: Sequence[FittedNumber]
) -> tuple[FittedWindow | None, tuple[Doubt, ...]]:
    """Return the window of the fitted suit, and the numbers that leave most of its doubt.

    There is none if the fit has no pretension.
    """
    model = estimate.model
    if PRETENSION not in model.places:
        return None, ()
    fitted = numbers[model.places[PRETENSION]].value
    loads = loads_judged(estimate)
    sets = stepped(estimate.scores, _STEP)
    ends = window_ends(model, sets, loads)
    low, high = (float(end) for end in ends[0])
    pretension = model.values(sets)[PRETENSION][:, 0]
    above = pretension - ends[:, 0]
    below = ends[:, 1] - pretension
    is_upper = bool(below[0] < above[0])
    margin = below if is_upper else above
    to_nearer = high - fitted if is_upper else fitted - low
    slope = (margin[1:] - margin[0]) / _STEP
    std = math.nan
    doubts: tuple[Doubt, ...] = ()
    if np.all(np.isfinite(slope)):
        std = math.sqrt(float(slope @ estimate.covariance @ slope))
        doubts = tuple(doubts_in(estimate, slope, numbers)[:_MOST_NAMED])
    return FittedWindow(low, high, fitted, to_nearer, std, tuple(loads.tolist())), doubts


def rests_of(estimate: SuitEstimate, numbers: Sequence[FittedNumber]) -> dict[str, list[str]]:
    """Return which numbers of the study rest on one as stated, that the logs do not tell, by it."""
    untold = {number.key for number in numbers if not number.is_stated and not number.is_told}
    found: dict[str, list[str]] = {}
    for place, number in enumerate(numbers):
        if not number.is_stated:
            continue
        slope = np.zeros(len(numbers))
        slope[place] = 1.0
        for doubt in doubts_in(estimate, slope, numbers):
            if doubt.key in untold and doubt.share >= _RESTS:
                found.setdefault(doubt.key, []).append(number.key)
    return found


def advice_on(key: str) -> str:
    """Return what tells a number."""
    return next(text for start, text in _TELLS if key.startswith(start))


def doubts_in(
    estimate: SuitEstimate, slope: Floats, numbers: Sequence[FittedNumber]
) -> list[Doubt]:
    """Return the numbers that leave most of the doubt in what has these slopes by the scores.

    With the covariance C and the slopes g, a number i that became known would take (C g)_i² / C_ii
    away from the variance g'C g.
    """
    along = estimate.covariance @ slope
    shares = along**2 / np.diag(estimate.covariance) / float(slope @ along)
    found = []
    for place in np.argsort(-shares).tolist():
        key = numbers[place].key
        is_asked = key != PRETENSION and numbers[place].log is None
        if is_asked and shares[place] >= _LEAST_SHARE:
            found.append(Doubt(key, float(shares[place]), advice_on(key)))
    return found
