"""Balance of the elbow and of the one motor that turns both spools (Eqs. 4, 5 and 12-20).

The unknowns are the distal tensions x (flexor) and y (extensor). With c the distal compliance of a
side,

    J_f x - J_e y = τ_a                                   elbow balance, Eq. 5, whose J^e is -J_e
    η (c_f x - c_f0 F0_f) + c_e y - c_e0 F0_e = H_e - η H_f    both spools turn together, Eqs. 12-16

with c0 the compliance in the posture in which the pretension is set; it differs from c only if a
bend follows the joint.

The sign of the right side and the simultaneous solution depart from the paper's text; its own
figures come out only with both (see docs/physics.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array, Flag, Flags, Real

TAUT, FLEXOR_SLACK, EXTENSOR_SLACK, BOTH_SLACK, NO_EQUILIBRIUM = range(5)
STATUS_NAMES = ("taut", "flexor slack", "extensor slack", "both slack", "no equilibrium")
Status = npt.NDArray[np.int8]
SLACK_TOLERANCE = 1e-9
"""Rounding of a tension, as a share of the largest force of its state: a tension counts as negative
only if it is further below zero. At exactly the required pretension a third of random designs would
otherwise be slack by rounding."""


@dataclass(frozen=True, eq=False)
class Coupling:
    """Equations that tie the two tensions of a state together; all fields broadcast."""

    moment_arm: Array
    """J_f where both tendons can turn the joint, NaN where J_f <= 0 or J_e <= 0, m."""
    extensor_arm: Real
    """J_e, m."""
    ratio: Real
    """η, extensor over flexor radius of the spool."""
    flexor_compliance: Array
    """Distal compliance of the flexor c_f, m/N."""
    extensor_compliance: Array
    """Distal compliance of the extensor c_e, m/N."""
    mismatch: Array
    """h = H_e - η H_f, length that the springs must take up, m."""
    elbow_torque: Array
    """Torque that the tendons must balance at the elbow τ_a, N m."""
    resting: tuple[Array, Array] | None = None
    """c_f and c_e in the posture in which the pretension is set, m/N; None if they are the same."""

    @cached_property
    def compliance(self) -> Array:
        """Compliance of both sides together, η c_f + c_e, m/N."""
        return np.asarray(self.ratio * self.flexor_compliance + self.extensor_compliance)

    @cached_property
    def flexor_share(self) -> Array:
        """Share of η c_f in η c_f + c_e."""
        return np.asarray(self.ratio * self.flexor_compliance * (1.0 / self.compliance))

    @cached_property
    def common_compliance(self) -> Array:
        """η c_f + c_e where the pretension is set, m/N: growth of D per newton on both sides."""
        if self.resting is None:
            return self.compliance
        flexor, extensor = self.resting
        return np.asarray(self.ratio * flexor + extensor)

    def common_pretension(self, flexor: Real, extensor: Real) -> Array:
        """Return the pretension of both sides that is equivalent to two different ones, N.

        Each side's pretension is weighted by its compliance.

        Args:
            flexor: Pretension of the flexor, N.
            extensor: Pretension of the extensor, N.
        """
        share = self.flexor_share
        if self.resting is not None:
            share = np.asarray(self.ratio * self.resting[0] * (1.0 / self.common_compliance))
        return np.asarray(extensor + share * np.subtract(flexor, extensor))


@dataclass(frozen=True, eq=False)
class Response:
    """Tensions of a state as functions of its pretension F: straight lines with one kink.

    With v = max(F - F*, lowest) and F* the required pretension

        x = flexor_floor + flexor_gain v,   y = extensor_floor + extensor_gain v

    Above F* both tendons are taut; below, unilateral tendons keep the tensions that balance the
    load, and the rest of the path is loose. Nothing here depends on F, so a sweep over pretension
    needs it once.
    """

    required: Array
    """F*, the smallest pretension of both sides that keeps the state taut, N; NaN without an
    equilibrium.

    It is (max(η c_f τ_a / J_f, -c_e τ_a / J_e) - h) / (η c_f + c_e), negative where any pretension
    would do. The largest over a design's states, and 0, is the required pretension F0*.
    """
    unilateral: Flag
    """True where tendons cannot push; else the paper's bilateral model."""
    flexor_limit: Array
    """Pretension below which the flexor counts as slack, N: the required one but for rounding, or
    minus infinity."""
    extensor_limit: Array
    """Pretension below which the extensor counts as slack, N."""
    flexor_floor: Array
    """x at F*, N."""
    flexor_gain: Array
    """dx/dF where taut."""
    extensor_floor: Array
    """y at F*, N."""
    extensor_gain: Array
    """dy/dF where taut."""
    idle: Flags
    """True where there is next to no load, so that unilateral tendons both go slack at once."""

    @cached_property
    def lowest(self) -> Array:
        """Least v, N: 0 for unilateral tendons, minus infinity for bilateral ones."""
        return np.where(self.unilateral, np.zeros_like(self.required), -np.inf)

    @cached_property
    def limit(self) -> Array:
        """Pretension below which either side counts as slack, N."""
        return np.fmax(self.flexor_limit, self.extensor_limit)


def respond(state: Coupling, *, unilateral: Flag = True) -> Response:
    """Return the tensions of a state as functions of its pretension.

    The two equations give x_b and y_b, both rising with F; each side's tension vanishes at its own
    pretension. With τ_a >= 0 the extensor is the first to go slack as F falls, else the flexor; the
    other tension then balances the load alone. Unilateral tendons, which cannot push, stay there: a
    complementarity problem with this one solution for J > 0. Bilateral ones follow the same lines
    below zero.
    """
    extensor_arm = np.asarray(state.extensor_arm)
    arm = state.moment_arm
    per_compliance = 1.0 / state.compliance
    per_extensor_arm = 1.0 / extensor_arm
    per_arm = 1.0 / arm
    flexor_share = state.flexor_share
    extensor_share = state.extensor_compliance * per_compliance

    floor_x = np.maximum(state.elbow_torque * per_arm, 0.0)
    floor_y = np.maximum(-state.elbow_torque * per_extensor_arm, 0.0)
    spread = flexor_share * extensor_arm + extensor_share * arm
    required = flexor_share * floor_x + extensor_share * floor_y - state.mismatch * per_compliance
    if state.resting is not None:
        grown = state.common_compliance / state.compliance
        spread = spread / grown
        required = required / grown
    flexor_gain = extensor_arm / spread
    extensor_gain = flexor_gain * (arm * per_extensor_arm)

    # Without a torque to balance, unilateral tendons both go slack at once; otherwise only the one
    # that the torque does not load.
    load = np.maximum(floor_x, floor_y)
    backward = state.elbow_torque < 0.0
    idle = load <= SLACK_TOLERANCE * np.abs(required)
    per_loaded_arm = np.where(backward, per_extensor_arm, per_arm)
    limit = required - _tolerance(load, required) * spread * per_loaded_arm
    flexor_limit = np.where(idle | backward, limit, -np.inf)
    extensor_limit = np.where(idle | ~backward, limit, -np.inf)
    if not np.all(unilateral):
        flexor_bilateral, extensor_bilateral = _bilateral_limits(state, flexor_gain, extensor_gain)
        flexor_limit = np.where(unilateral, flexor_limit, flexor_bilateral)
        extensor_limit = np.where(unilateral, extensor_limit, extensor_bilateral)
    return Response(
        required=required,
        unilateral=unilateral,
        flexor_limit=flexor_limit,
        extensor_limit=extensor_limit,
        flexor_floor=floor_x,
        flexor_gain=flexor_gain,
        extensor_floor=floor_y,
        extensor_gain=extensor_gain,
        idle=idle,
    )


def _bilateral_limits(
    state: Coupling, flexor_gain: Array, extensor_gain: Array
) -> tuple[Array, Array]:
    """Return the pretensions below which each tension is negative in the bilateral model, N."""
    common = state.common_compliance
    at_flexor = state.elbow_torque / state.moment_arm
    at_extensor = -state.elbow_torque / state.extensor_arm
    for_extensor = (state.ratio * state.flexor_compliance * at_flexor - state.mismatch) / common
    for_flexor = (state.extensor_compliance * at_extensor - state.mismatch) / common
    return (
        for_flexor - _tolerance(at_extensor, for_flexor) / flexor_gain,
        for_extensor - _tolerance(at_flexor, for_extensor) / extensor_gain,
    )


def _tolerance(tension: Array, pretension: Array) -> Array:
    """Return the rounding of a tension, N: a share of the largest force of the state."""
    return np.asarray(SLACK_TOLERANCE * np.maximum(np.abs(tension), np.abs(pretension)))


@dataclass(frozen=True, eq=False)
class Balance:
    """Solution of a state at a pretension; its numbers are NaN without an equilibrium."""

    coupling: Coupling
    response: Response
    pretension: Array
    """Pretension of both sides, or the one equivalent to two different ones, N."""

    @cached_property
    def margin(self) -> Array:
        """Pretension above the smallest that keeps the state taut, N."""
        return np.asarray(self.pretension - self.response.required)

    @cached_property
    def _taut_margin(self) -> Array:
        """v of `Response`, N."""
        return np.asarray(np.maximum(self.margin, self.response.lowest))

    @cached_property
    def flexor(self) -> Array:
        """x, distal flexor tension, N."""
        tension = np.asarray(self.response.flexor_gain * self._taut_margin)
        tension += self.response.flexor_floor  # in place: states are many
        return tension

    @cached_property
    def extensor(self) -> Array:
        """y, distal extensor tension, N."""
        tension = np.asarray(self.response.extensor_gain * self._taut_margin)
        tension += self.response.extensor_floor
        return tension

    @cached_property
    def flexor_slack(self) -> Flags:
        """True where the flexor is slack."""
        return np.asarray(self.pretension < self.response.flexor_limit)

    @cached_property
    def extensor_slack(self) -> Flags:
        """True where the extensor is slack."""
        return np.asarray(self.pretension < self.response.extensor_limit)

    @cached_property
    def status(self) -> Status:
        """Index into STATUS_NAMES."""
        flexor = self.flexor_slack * np.int8(FLEXOR_SLACK)
        extensor = self.extensor_slack * np.int8(EXTENSOR_SLACK)
        has_no_equilibrium = np.isnan(self.coupling.moment_arm)
        return np.where(has_no_equilibrium, np.int8(NO_EQUILIBRIUM), flexor + extensor)

    @cached_property
    def is_slack(self) -> Flags:
        """True where either side is slack."""
        return np.asarray(self.pretension < self.response.limit)

    @property
    def path(self) -> Array:
        """Path length that no tendon takes up in a slack state, η c_f x + c_e y - D, m."""
        return np.asarray(-self.coupling.common_compliance * self.margin)

    @property
    def loose(self) -> Array:
        """Path length that no tendon takes up, σ >= 0; 0 where taut, m."""
        taut = np.where(np.isnan(self.coupling.moment_arm), np.nan, np.zeros_like(self.margin))
        return np.where(self.is_slack & np.asarray(self.response.unilateral), self.path, taut)
