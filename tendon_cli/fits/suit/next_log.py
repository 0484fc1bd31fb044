"""Further measurements, and how far each would narrow the uncertainty of the window.

The window of the fitted suit, without slack and stable, moves with each number; with the covariance
of the fit this is the uncertainty of its ends. A measurement that has not been made yet adds its
information to that of the fit, to first order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.fits.suit import parameters as names
from tendon_cli.fits.suit.fitted_numbers import FittedNumber
from tendon_cli.fits.suit.log_columns import MOTOR_TORQUE, SPOOL_ANGLE
from tendon_cli.fits.suit.misfit import kernels_of, lower_factor
from tendon_cli.fits.suit.parameters import loads_of_study
from tendon_cli.fits.suit.suit_estimate import SuitEstimate, whiten
from tendon_cli.fits.suit.suit_log import Floats
from tendon_cli.fits.suit.suit_model import SuitModel
from tendon_cli.model.actuator import State
from tendon_cli.space.axis import PRETENSION

_STEP = 1e-4
_MORE_LOAD = 2.0
"""Mass by which the heaviest load is exceeded in the log that is proposed, kg."""
_CELL = "flexor_tension_proximal"
_CELL_ERROR = 0.01
"""Error of a load cell, as a share of the tension."""
_HELD_TURN = 0.3
"""Way by which the spool is turned to either side while the joint is held, rad."""
_LEAST_GAIN = 0.03
"""Share by which a measurement must narrow the uncertainty to be named."""
_GRID = 31
"""Angles at which the window of a suit is worked out."""


@dataclass(frozen=True)
class Proposal:
    """A further measurement, and what it would do."""

    name: str
    doubt: float
    """Standard deviation of the ends of the window with it, N."""
    doubt_now: float
    """The same as it is, N."""

    @property
    def record(self) -> dict[str, Any]:
        """The proposal as plain JSON values."""
        return {"name": self.name, "window_std": self.doubt, "window_std_now": self.doubt_now}

    @property
    def text(self) -> str:
        """The proposal in words."""
        now = say.number(self.doubt_now, 2)
        then = say.number(self.doubt, 2)
        return f"{self.name} would give the ends of the window to ±{then} N instead of ±{now} N"


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
        response = state.response
        least.append(response.required.max(axis=(1, 2)))
        flexor_slope, extensor_slope = state.arm_slopes
        at_required = (
            state.held_stiffness[0]
            - response.flexor_floor * flexor_slope
            + response.extensor_floor * extensor_slope
        )
        fall = response.flexor_gain * flexor_slope - response.extensor_gain * extensor_slope
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where(fall > 0.0, response.required + at_required / fall, np.inf)
        largest.append(reach.min(axis=(1, 2)))
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
        """The window as plain JSON values; null without an end."""
        return {
            "from": _finite(self.low),
            "to": _finite(self.high),
            "pretension": self.pretension,
            "margin": _finite(self.margin),
            "margin_std": _finite(self.margin_std),
            "loads": list(self.loads),
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


def _finite(value: float) -> float | None:
    """Return a number; None if it is none or infinite."""
    return value if math.isfinite(value) else None


def loads_of_logs(estimate: SuitEstimate) -> Floats:
    """Return the different loads of the logs, the study's where a log does not say, kg."""
    of_study = estimate.model.load_of_study
    return np.unique(np.where(np.isnan(estimate.parts.load), of_study, estimate.parts.load))


def loads_judged(estimate: SuitEstimate) -> Floats:
    """Return the different loads of the logs and of the study, which the window must suit, kg."""
    return np.union1d(loads_of_logs(estimate), loads_of_study(estimate.model.study))


def fitted_window(estimate: SuitEstimate, numbers: Sequence[FittedNumber]) -> FittedWindow | None:
    """Return the window of the fitted suit; None if the fit has no pretension."""
    model = estimate.model
    if PRETENSION not in model.places:
        return None
    fitted = numbers[model.places[PRETENSION]].value
    loads = loads_judged(estimate)
    sets = _stepped(estimate)
    ends = window_ends(model, sets, loads)
    low, high = (float(end) for end in ends[0])
    pretension = model.values(sets)[PRETENSION]
    above = pretension - ends[:, 0]
    below = ends[:, 1] - pretension
    is_upper = bool(below[0] < above[0])
    margin = below if is_upper else above
    to_nearer = high - fitted if is_upper else fitted - low
    slope = (margin[1:] - margin[0]) / _STEP
    std = math.nan
    if np.all(np.isfinite(slope)):
        std = math.sqrt(float(slope @ estimate.covariance @ slope))
    return FittedWindow(low, high, fitted, to_nearer, std, tuple(loads.tolist()))


def _stepped(estimate: SuitEstimate) -> Floats:
    """Return the scores of an estimate, and with a step in each, (1 + parameters, parameters)."""
    count = len(estimate.scores)
    sets = np.tile(estimate.scores, (count + 1, 1))
    sets[1:] += _STEP * np.eye(count)
    return sets


def proposals(estimate: SuitEstimate) -> list[Proposal]:
    """Return further measurements that would narrow the window, the best first."""
    model = estimate.model
    loads = loads_of_logs(estimate)
    ends = window_ends(model, _stepped(estimate), loads_judged(estimate))
    slopes = (ends[1:] - ends[0]) / _STEP  # (parameters, ends)
    slopes = slopes[:, np.all(np.isfinite(slopes), axis=0)]
    if not slopes.size:
        return []

    def doubt(information: Floats) -> float:
        """Return the standard deviation of the ends of the window, N."""
        covariance = np.linalg.inv(information)
        return math.sqrt(float(np.einsum("ie,ij,je->", slopes, covariance, slopes)))

    now = doubt(estimate.information)
    found = []
    for name, added in _measurements(estimate, loads):
        then = doubt(estimate.information + added)
        if then < (1.0 - _LEAST_GAIN) * now:
            found.append(Proposal(name, then, now))
    return sorted(found, key=lambda proposal: proposal.doubt)


def _measurements(estimate: SuitEstimate, loads: Floats) -> list[tuple[str, Floats]]:
    """Return the name of each measurement that is possible, and the information that it adds."""
    found = []
    heavier = float(loads.max()) + _MORE_LOAD
    found.append((f"a log with {heavier:.3g} kg", _of_load(estimate, heavier)))
    if loads.min() > 0.0:
        found.append(("a log with the hand empty", _of_load(estimate, 0.0)))
    if _CELL not in estimate.channels:
        found.append(("a load cell at the flexor's motor end for a minute", _of_cell(estimate)))
    if SPOOL_ANGLE in estimate.channels and MOTOR_TORQUE in estimate.channels:
        found.append(("holding the joint still while the motor pulls", _of_held(estimate)))
    weights = [key for key in estimate.model.places if key.startswith("load")]
    found.append(("the loads weighed to 0.5 %", _of_better(estimate, weights, 0.1)))
    sensor = [names.JOINT_ZERO, names.JOINT_GAIN]
    found.append(
        (
            "the joint sensor checked at two known angles to 0.3 deg",
            _of_better(estimate, sensor, 0.2),
        )
    )
    torque = [names.TORQUE_GAIN, names.TORQUE_ZERO]
    found.append(
        (
            "the torque calibrated with a weight on the spool to 0.5 %",
            _of_better(estimate, torque, 0.1),
        )
    )
    anchors = [f"arm.{name}" for name in ("a1", "b1", "a2", "b2", "elbow_radius")]
    found.append(("the anchors measured to 1 mm", _of_better(estimate, anchors, 0.2)))
    return found


def _of_better(estimate: SuitEstimate, keys: list[str], share: float) -> Floats:
    """Return the information of numbers that are measured to a share of their priors."""
    added = np.zeros_like(estimate.information)
    for key in keys:
        place = estimate.model.places.get(key)
        if place is not None:
            added[place, place] = 1.0 / share**2
    return added


def _template(estimate: SuitEstimate) -> Any:
    """Return the parts of the log with most of them, which a further log would be like."""
    logs, counts = np.unique(estimate.parts.log, return_counts=True)
    return estimate.parts.select(estimate.parts.log == logs[np.argmax(counts)])


def _of_load(estimate: SuitEstimate, load: float) -> Floats:
    """Return the information of a log with another load, weighed well."""
    template = _template(estimate)
    parts = replace(template, load=np.full(len(template), load))
    _, slopes = estimate.model.jacobian(estimate.scores, parts, estimate.channels)
    solved = whiten(estimate.misfit.factors(kernels_of(parts)), slopes)
    return np.asarray(solved.T @ solved)


def _of_cell(estimate: SuitEstimate) -> Floats:
    """Return the information of a load cell at the flexor's motor end."""
    parts = _template(estimate)
    tension, slopes = estimate.model.jacobian(estimate.scores, parts, (_CELL,))
    kernels = kernels_of(parts)
    size = _CELL_ERROR * float(np.mean(np.abs(tension)))
    covariance = size**2 * (0.1 * kernels[0] + kernels[-1])
    solved = whiten([lower_factor(covariance)], slopes)
    return np.asarray(solved.T @ solved)


def _of_held(estimate: SuitEstimate) -> Floats:
    """Return the information of the torque as the motor turns with the joint held."""
    model = estimate.model
    count = len(estimate.scores)
    sets = np.tile(estimate.scores, (count + 1, 1))
    sets[1:] += _STEP * np.eye(count)
    torque = _held_torque(model, sets, estimate).reshape(count + 1, -1)
    slopes = ((torque[1:] - torque[0]) / _STEP).T  # (rows, parameters)
    noise = sum(
        estimate.misfit.deviation(MOTOR_TORQUE, term) ** 2 for term in ("white", "stroke", "kind")
    )
    common = estimate.misfit.deviation(MOTOR_TORQUE, "common") ** 2
    covariance = noise * np.eye(len(slopes)) + common
    solved = whiten([lower_factor(covariance)], slopes)
    return np.asarray(solved.T @ solved)


def _held_torque(model: SuitModel, sets: Floats, estimate: SuitEstimate) -> Floats:
    """Return the torque that the sensor shows over turns of the spool, the joint held.

    The tensions follow from the paths, x = (R_f α - H_f + c_0 F0)/c_f and
    y = (H_e - η R_f α + c_0 F0)/c_e, as long as both tendons are taut.
    """
    parts = estimate.parts
    middle = int(np.argmin(np.abs(parts.angle - parts.angle.mean())))
    both = parts.select(np.array([middle, middle]))
    both = replace(both, flexion=np.array([True, False]))
    state = model.states(sets, both)
    values = model.values(sets)
    design = state.design
    resting = state.resting
    if resting is None:
        raise ValueError("states of a suit's model count from one natural length")
    # The spool is turned about the angle at which it stands at the estimate.
    shown = model.predict(estimate.scores[np.newaxis], both, (SPOOL_ANGLE,))[0, 0].mean()
    zeros = np.mean([values[key] for key in values if key.startswith(names.SPOOL_ZERO)], axis=0)
    turns = shown + _HELD_TURN * np.linspace(-1.0, 1.0, 7)
    angle = turns - zeros[:, np.newaxis, np.newaxis, np.newaxis]  # (sets, 1, 1, turns)
    radius = np.asarray(design.flexor_radius)[..., np.newaxis]
    ratio = np.asarray(design.ratio)[..., np.newaxis]

    def wide(column: Any) -> Floats:
        """Return a column of states with an axis of turns."""
        return np.asarray(column)[..., np.newaxis]

    flexor_rest = wide(resting[0].compliance * np.asarray(design.flexor.pretension))
    extensor_rest = wide(resting[1].compliance * np.asarray(design.extensor.pretension))
    wound = radius * angle
    flexor = (wound - wide(state.motion.flexor_travel) + flexor_rest) / wide(
        state.flexor.compliance
    )
    path = wide(state.motion.extensor_travel) - ratio * wound
    extensor = (path + extensor_rest) / wide(state.extensor.compliance)
    flexor_arm, extensor_arm = state.motor_arms
    torque = wide(flexor_arm) * flexor - wide(extensor_arm) * extensor
    gain = 1.0 + values.get(names.TORQUE_GAIN, np.zeros(len(sets)))
    zero = values.get(names.TORQUE_ZERO, np.zeros(len(sets)))
    gear = values.get(names.GEAR_FRICTION, np.zeros(len(sets)))
    sign = both.sign[:, np.newaxis]
    shape = (-1, 1, 1, 1)
    shown_torque = gain.reshape(shape) * (torque + gear.reshape(shape) * sign)
    return np.asarray(shown_torque + zero.reshape(shape))
