"""Prediction of a suit's log by the model's sliding states, for many sets of parameters at once.

The states are those of section 4 with one natural length for both directions: F0 is the tension of
both tendons before friction acts, so that the spool's angle counts from one unstretched tendon,

    η (c_f x - c_0 F0) + c_e y - c_0 F0 = H_e - η H_f,   α = (H_f + c_f x - c_0 F0) / R_f

with c_0 = L/(AE) + 1/K + 1/K_t. Sensors then show

    θ_shown = (1 + g_θ) θ + θ_0,   α_shown(t) = α(t - δ_α) + α_0 + sign(θ̇) b/2,
    τ_shown(t) = (1 + g_τ)(τ_m ε^-s + sign(θ̇) τ_g)(t - δ_τ) + τ_0

where ε is the efficiency of a gear, and s is 1 where the motor drives the spool, -1 where the spool
drives the motor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from tendon_cli.fits.log_rows import Floats, Mask
from tendon_cli.fits.suit import parameters as names
from tendon_cli.fits.suit.log_columns import MOTOR_TORQUE, SPOOL_ANGLE
from tendon_cli.fits.suit.parameters import Parameter
from tendon_cli.fits.suit.stroke_parts import Parts
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.reversal import reversal
from tendon_cli.model.sheath import sheaths_of
from tendon_cli.studies.fit_section import BACKLASH
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.spaces import single_numbers
from tendon_cli.studies.study import Study

_LEAST_RATE = 0.1
"""Way of the spool per way of the joint, over its median, under which the spool hardly turns."""
_NONE = np.zeros((1, 1))
"""Value of an error of a sensor that is not fitted."""
_STEP = 1e-5
"""Step of normal scores by which derivatives are taken."""


def stepped(scores: Floats, step: float) -> Floats:
    """Return scores, and for each of them the set in which it is a step larger."""
    sets = np.tile(scores, (len(scores) + 1, 1))
    sets[1:] += step * np.eye(len(scores))
    return sets


class SuitModel:
    """A study and its parameters, which predict what sensors show."""

    def __init__(self, study: Study, parameters: Sequence[Parameter]) -> None:
        """Make the model of a study.

        Args:
            study: A study of one suit.
            parameters: What may change.
        """
        self.study = study
        self.parameters = tuple(parameters)
        self._single = {
            key: value for key, value in single_numbers(study).items() if key != "motion.trajectory"
        }

    @cached_property
    def places(self) -> dict[str, int]:
        """Place of each parameter, by its key."""
        return {parameter.key: place for place, parameter in enumerate(self.parameters)}

    def values(self, scores: Floats) -> dict[str, Floats]:
        """Return the parameters at normal scores, SI.

        Args:
            scores: Normal scores, (sets, parameters).

        Returns:
            Values, (sets, 1) each, by key.
        """
        return {
            parameter.key: parameter.at(scores[:, place, np.newaxis])
            for place, parameter in enumerate(self.parameters)
        }

    def design(self, values: dict[str, Floats]) -> Design:
        """Return the designs of sets of parameters, each number (sets, 1, 1)."""
        numbers = {
            parameter.key: values[parameter.key][:, 0]
            for parameter in self.parameters
            if not parameter.is_sensor
        }
        sets = len(next(iter(values.values())))
        space = Space((Axis.of_points(numbers, sets),), self._single)
        return space.design()

    def states(self, scores: Floats, parts: Parts, angle: Floats | None = None) -> State:
        """Return the states of parts of strokes.

        Args:
            scores: Normal scores, (sets, parameters).
            parts: Parts of strokes.
            angle: What the joint's sensor shows, rad, (parts,); else the mean of each part.

        Returns:
            States, (sets, 1, parts).
        """
        values = self.values(scores)
        design = self.design(values)
        loads = self._loads(values, parts)[..., np.newaxis, :]  # (sets or none, 1, parts)
        design = replace(design, load_mass=loads)
        shown = parts.angle if angle is None else angle
        zero = values.get(names.JOINT_ZERO, _NONE)
        gain = values.get(names.JOINT_GAIN, _NONE)
        true_angle = ((shown - zero) / (1.0 + gain))[:, np.newaxis]  # (sets or 1, 1, parts)
        flexion = parts.flexion[np.newaxis, np.newaxis]
        state = State.of(design, true_angle, flexion)
        smooth_flexor = replace(design.flexor, friction=0.0)
        smooth_extensor = replace(design.extensor, friction=0.0)
        resting = sheaths_of(smooth_flexor, smooth_extensor, design.setting.angle, flexion)
        torque = np.asarray(state.other_torque)
        of_load = loads * np.square(design.arm.load_distance)
        if names.INERTIA_SHARE in values:
            inertia = names.usual_inertia(self.study) + of_load
            share = values[names.INERTIA_SHARE][:, np.newaxis]
            torque = torque + share * inertia * parts.acceleration
        elif names.INERTIA_OF_FOREARM in values:
            inertia = values[names.INERTIA_OF_FOREARM][:, np.newaxis] + of_load
            torque = torque + inertia * parts.acceleration
        return replace(state, resting=resting, other_torque=torque)

    def _loads(self, values: dict[str, Floats], parts: Parts) -> Floats:
        """Return the masses of the loads, (sets, parts), or (parts,) if none is fitted."""
        of_study = values.get(names.LOAD, self.load_of_study)
        loads = np.where(np.isnan(parts.load), of_study, parts.load)
        for mass in np.unique(parts.load[~np.isnan(parts.load)]):
            key = f"load {mass:.4g} kg"
            if key in values:
                loads = np.where(parts.load == mass, values[key], loads)
        return loads

    @property
    def load_of_study(self) -> float:
        """Mass of the study's load, kg, for a log that does not say its own."""
        return float(names.loads_of_study(self.study)[0])

    def predict(self, scores: Floats, parts: Parts, channels: Sequence[str]) -> Floats:
        """Return what sensors show as means over parts of strokes.

        The mean over a part is that of two states a standard deviation of its angles to either
        side, which is right to the third order in the angle.

        Args:
            scores: Normal scores, (sets, parameters).
            parts: Parts of strokes.
            channels: Names of the channels.

        Returns:
            Predictions, (sets, channels, parts), SI.
        """
        both = parts.select(np.tile(np.arange(len(parts)), 2))
        angle = both.angle + np.repeat([-1.0, 1.0], len(parts)) * both.spread
        state = self.states(scores, both, angle)
        values = self.values(scores)
        shown = [self._shown(values, parts, name, state) for name in channels]
        return np.nan_to_num(np.stack(shown, axis=1), nan=0.0)

    def _shown(self, values: dict[str, Floats], parts: Parts, channel: str, state: State) -> Floats:
        """Return what the sensor of one channel shows, (sets, parts)."""
        below, above = np.split(_column(state, channel)[:, 0], 2, axis=1)
        mean = 0.5 * (below + above)
        rate = (above - below) / (2.0 * parts.spread) * parts.speed
        if channel == SPOOL_ANGLE:
            delay = values.get(names.SPOOL_DELAY, _NONE)
            play = 0.5 * values.get(BACKLASH, _NONE) * parts.sign
            zeros = _NONE
            for parameter in self.parameters:
                if parameter.log is not None:
                    zeros = zeros + values[parameter.key] * (parts.log == parameter.log)
            return mean - delay * rate + zeros + play
        if channel == MOTOR_TORQUE:
            delay = values.get(names.TORQUE_DELAY, _NONE)
            friction = values.get(names.GEAR_FRICTION, _NONE) * parts.sign
            gain = 1.0 + values.get(names.TORQUE_GAIN, _NONE)
            torque = mean - delay * rate
            if names.GEAR_EFFICIENCY in values:
                # A gear asks for more where the motor drives, and holds back where it is driven.
                efficiency = values[names.GEAR_EFFICIENCY]
                torque = torque * efficiency ** -np.sign(mean * parts.sign)
            return gain * (torque + friction) + values.get(names.TORQUE_ZERO, _NONE)
        gain = 1.0 + values.get(f"{channel} gain", _NONE)
        return gain * mean + values.get(f"{channel} zero", _NONE)

    def jacobian(
        self, scores: Floats, parts: Parts, channels: Sequence[str]
    ) -> tuple[Floats, Floats]:
        """Return predictions at one set of parameters, and their derivatives.

        Args:
            scores: Normal scores, (parameters,).
            parts: Parts of strokes.
            channels: Names of the channels.

        Returns:
            Predictions, (channels * parts,), and derivatives by the scores, (channels * parts,
            parameters).
        """
        sets = stepped(scores, _STEP)
        shown = self.predict(sets, parts, channels).reshape(len(sets), -1)
        slopes = (shown[1:] - shown[0]) / _STEP
        return shown[0], slopes.T

    def set_aside(self, scores: Floats, parts: Parts) -> tuple[Mask, Mask]:
        """Return the parts that the model itself does not vouch for.

        Args:
            scores: Normal scores, (parameters,).
            parts: Parts of strokes.

        Returns:
            True where a tendon is slack or there is no equilibrium, (parts,), and where the spool
            hardly turns or turns against the joint, (parts,).
        """
        state = self.states(scores[np.newaxis], parts)
        tension = np.minimum(state.balance.flexor, state.balance.extensor)
        is_taut = ~state.balance.is_slack & np.isfinite(tension)
        coupling = state.coupling
        design = state.design
        per_turn = design.flexor_radius * (
            coupling.moment_arm / coupling.flexor_compliance
            + design.ratio * coupling.extensor_arm / coupling.extensor_compliance
        )
        rate = np.asarray(state.elbow_stiffness / per_turn)[0, 0]  # dα/dθ
        is_back = rate < _LEAST_RATE * np.nanmedian(rate)
        return ~is_taut[0, 0], np.asarray(is_back)

    def turn(self, scores: Floats, parts: Parts) -> float:
        """Return the largest way of the spool until both sheaths have turned, rad."""
        state = self.states(scores[np.newaxis], parts)
        turn = reversal(state, state.elbow_angle, parts.flexion)
        ways = np.fmax(turn.flexor.turn, turn.extensor.turn)
        found = ways[np.isfinite(ways)]
        return np.quantile(found, 0.95) if len(found) else 0.0


def _column(state: State, channel: str) -> Floats:
    """Return a channel of states."""
    if channel == "flexor_tension_distal":
        return np.asarray(state.balance.flexor)
    if channel == "extensor_tension_distal":
        return np.asarray(state.balance.extensor)
    return np.asarray(getattr(state, channel))
