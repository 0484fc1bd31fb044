"""Balance of the elbow and of the one motor that turns both spools (Eqs. 4, 5 and 12-20).

The unknowns are the distal tensions x (flexor) and y (extensor). With c the distal compliance of a side,

    J x - R_elb y = τ_a                                   elbow balance, Eq. 5
    η c_f (x - F0_f) + c_e (y - F0_e) = H_e - η H_f       both spools turn together, Eqs. 12-16

The sign of the right side and the simultaneous solution depart from the letter of the paper; only so do its own figures
come out (see docs/physics.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array, Real

TAUT, FLEXOR_SLACK, EXTENSOR_SLACK, BOTH_SLACK, NO_EQUILIBRIUM = range(5)
STATUS_NAMES = ("taut", "flexor slack", "extensor slack", "both slack", "no equilibrium")
Status = npt.NDArray[np.int8]
Flag = bool | npt.NDArray[np.bool_]

# A tension counts as negative below this share of the largest of |x_b|, |y_b| and F0. At exactly the required
# pretension a third of random designs would otherwise be slack by rounding.
SLACK_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Coupling:
    """What ties the two tensions together in a state; arrays that broadcast against each other."""

    moment_arm: Array
    """J where the flexor can flex the elbow, not a number where J <= 0, m."""
    elbow_radius: Real
    """R_elb, m."""
    ratio: Real
    """η, extensor over flexor radius of the spool."""
    flexor_compliance: Array
    """c_f, elongation of tendon and spring per distal newton, m/N."""
    extensor_compliance: Array
    """c_e, m/N."""
    mismatch: Array
    """h = H_e - η H_f, what the springs must give, m."""
    elbow_torque: Array
    """τ_a, N m."""

    @property
    def common_compliance(self) -> Array:
        """η c_f + c_e, by how much h grows per newton of pretension on both sides, m/N."""
        return np.asarray(self.ratio * self.flexor_compliance + self.extensor_compliance)


@dataclass(frozen=True)
class Balance:
    """The solution of a state."""

    flexor: Array
    """x, distal flexor tension, N."""
    extensor: Array
    """y, distal extensor tension, N."""
    status: Status
    """Index into STATUS_NAMES."""
    loose: Array
    """σ = η c_f x + c_e y - D >= 0, path length that no tendon takes up; 0 where taut, m."""


def coupling(
    *, moment_arm: Array, elbow_radius: Real, ratio: Real, flexor_compliance: Array, extensor_compliance: Array,
    flexor_travel: Array, extensor_travel: Array, elbow_torque: Array,
) -> Coupling:  # fmt: skip
    """Gather a state's coefficients; without a positive moment arm the flexor cannot balance anything."""
    return Coupling(
        moment_arm=np.where(moment_arm > 0.0, moment_arm, np.nan),
        elbow_radius=elbow_radius,
        ratio=ratio,
        flexor_compliance=flexor_compliance,
        extensor_compliance=extensor_compliance,
        mismatch=extensor_travel - ratio * flexor_travel,
        elbow_torque=elbow_torque,
    )


def solve(state: Coupling, flexor_pretension: Real, extensor_pretension: Real, *, unilateral: Flag = True) -> Balance:
    """Distal tensions and status. `unilateral` tendons cannot push; otherwise negative tension is the paper's slack.

    The unilateral problem is a complementarity problem with one solution for J > 0: y is raised to what keeps both
    tensions non-negative, and the elbow balance gives x. Where J <= 0 the tensions are not numbers.
    """
    c_f, c_e, radius = state.flexor_compliance, state.extensor_compliance, state.elbow_radius
    slack_free = state.mismatch + (state.ratio * c_f * flexor_pretension + c_e * extensor_pretension)  # D
    determinant = state.ratio * c_f * radius + state.moment_arm * c_e
    # Written as sums of products, so that each factor stays as small as the axes it depends on (see `sweep.evaluate`).
    y_both = (state.moment_arm / determinant) * slack_free - (state.ratio * c_f / determinant) * state.elbow_torque
    lowest = np.where(unilateral, np.maximum(0.0, -state.elbow_torque / radius), -np.inf)
    y = np.maximum(y_both, lowest)
    x_both = (state.elbow_torque + radius * y_both) / state.moment_arm
    x = (state.elbow_torque + radius * y) / state.moment_arm
    largest = np.maximum(np.maximum(np.abs(x_both), np.abs(y_both)), np.maximum(flexor_pretension, extensor_pretension))
    status = _status(x_both, y_both, x, y, SLACK_TOLERANCE * largest, unilateral)
    is_slack = (status != TAUT) & np.asarray(unilateral)
    loose = np.where(is_slack, np.maximum(0.0, state.ratio * c_f * x + c_e * y - slack_free), 0.0)
    return Balance(flexor=x, extensor=y, status=status, loose=np.where(np.isnan(x), np.nan, loose))


def _status(x_both: Array, y_both: Array, x: Array, y: Array, tolerance: Array, unilateral: Flag) -> Status:
    """Which side is slack. In the bilateral model the signs decide, in the unilateral one which tension is left."""
    flexor_negative, extensor_negative = x_both < -tolerance, y_both < -tolerance
    slack = flexor_negative | extensor_negative
    flexor = np.where(unilateral, slack & (x <= tolerance), flexor_negative)
    extensor = np.where(unilateral, slack & (y <= tolerance), extensor_negative)
    status = flexor * FLEXOR_SLACK + extensor * EXTENSOR_SLACK
    return np.asarray(np.where(np.isnan(x), NO_EQUILIBRIUM, status), dtype=np.int8)


def elbow_stiffness(
    state: Coupling, balance: Balance, moment_arm_slope: Array, elbow_torque_slope: Array, *, unilateral: Flag = True
) -> Array:
    """k = J²/c_f + R_elb²/c_e + dτ_a/dθ - x dJ/dθ with the motor held, N m/rad; a slack tendon adds nothing.

    Negative where the arm is unstable: there the spool must turn back while the elbow goes on, and the direction of
    friction that the state assumes is wrong.
    """
    both = balance.status == BOTH_SLACK
    flexor_pulls = ~(((balance.status == FLEXOR_SLACK) | both) & np.asarray(unilateral))
    extensor_pulls = ~(((balance.status == EXTENSOR_SLACK) | both) & np.asarray(unilateral))
    flexor = np.square(state.moment_arm) / state.flexor_compliance
    extensor = np.square(state.elbow_radius) / state.extensor_compliance
    geometry = elbow_torque_slope - balance.flexor * moment_arm_slope
    return np.asarray(flexor_pulls * flexor + extensor_pulls * extensor + geometry)


def pretension_shortfall(state: Coupling) -> Array:
    """Smallest pretension of both sides that keeps a state taut, N; negative where any would do, NaN where J <= 0.

    Exact: max(η c_f τ_a / J, -c_e τ_a / R_elb) - h over η c_f + c_e. The largest over a design's states, and 0, is the
    required pretension F0*.
    """
    flexor_side = state.ratio * state.flexor_compliance * state.elbow_torque / state.moment_arm
    extensor_side = -state.extensor_compliance * state.elbow_torque / state.elbow_radius
    return np.asarray((np.maximum(flexor_side, extensor_side) - state.mismatch) / state.common_compliance)


def pretension_in_hand(state: Coupling, flexor_pretension: Real, extensor_pretension: Real, shortfall: Array) -> Array:
    """By how much both pretensions could be lowered before a state goes slack, N; negative where it is slack.

    For equal pretensions F0 - max(0, shortfall); where the sides differ, pretension counts by each side's compliance.
    """
    flexor_share = state.ratio * state.flexor_compliance / state.common_compliance
    mean = flexor_share * flexor_pretension + (1.0 - flexor_share) * extensor_pretension
    return np.asarray(np.minimum(mean - shortfall, np.minimum(flexor_pretension, extensor_pretension)))
