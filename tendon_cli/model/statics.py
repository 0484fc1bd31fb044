"""Balance of the elbow and of the one motor that turns both spools (Eqs. 4, 5 and 12-20).

The unknowns are the distal tensions x (flexor) and y (extensor). With c the distal compliance of a side,

    J_f x - J_e y = τ_a                                   elbow balance, Eq. 5, whose J^e is -J_e
    η (c_f x - c_f0 F0_f) + c_e y - c_e0 F0_e = H_e - η H_f    both spools turn together, Eqs. 12-16

with c0 the compliance in the posture in which the pretension is set; only a bend that follows the joint makes it
another.

The sign of the right side and the simultaneous solution depart from the letter of the paper; only so do its own figures
come out (see docs/physics.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array, Flag, Flags, Real
from tendon_cli.model.response import Coupling, Response, respond

TAUT, FLEXOR_SLACK, EXTENSOR_SLACK, BOTH_SLACK, NO_EQUILIBRIUM = range(5)
STATUS_NAMES = ("taut", "flexor slack", "extensor slack", "both slack", "no equilibrium")
Status = npt.NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Balance:
    """The solution of a state."""

    coupling: Coupling
    response: Response
    flexor: Array
    """x, distal flexor tension, N."""
    extensor: Array
    """y, distal extensor tension, N."""
    pretension: Array
    """Of both sides, or what does the same, N."""
    margin: Array
    """By how much that is above the smallest that keeps the state taut, N."""

    @cached_property
    def flexor_slack(self) -> Flags:
        """Whether the flexor is; where none is, one flag for all."""
        return _if_any(self.pretension < self.response.flexor_limit)

    @cached_property
    def extensor_slack(self) -> Flags:
        """Likewise the extensor."""
        return _if_any(self.pretension < self.response.extensor_limit)

    @cached_property
    def status(self) -> Status:
        """Index into STATUS_NAMES."""
        slack = self.flexor_slack * np.int8(FLEXOR_SLACK) + self.extensor_slack * np.int8(EXTENSOR_SLACK)
        return np.where(np.isnan(self.coupling.moment_arm), np.int8(NO_EQUILIBRIUM), slack)

    @cached_property
    def is_slack(self) -> Flags:
        """Whether either side is; where none is, one flag for all."""
        return _if_any(self.pretension < self.response.limit)

    @property
    def path(self) -> Array:
        """η c_f x + c_e y - D of a slack state, m."""
        return loose_path(self.coupling, self.margin)

    @property
    def loose(self) -> Array:
        """σ >= 0, path length that no tendon takes up; 0 where taut, m."""
        taut = np.where(np.isnan(self.coupling.moment_arm), np.nan, np.zeros_like(self.margin))
        return np.where(self.is_slack & np.asarray(self.response.unilateral), self.path, taut)


def loose_path(state: Coupling, margin: Array) -> Array:
    """Path that no tendon takes up in a slack state, by its margin of pretension (N), m."""
    return np.asarray(-state.common_compliance * margin)


def solve(
    state: Coupling, flexor_pretension: Real, extensor_pretension: Real, *, unilateral: Flag = True,
    response: Response | None = None,
) -> Balance:  # fmt: skip
    """Distal tensions and status. `unilateral` tendons cannot push; otherwise negative tension is the paper's slack.

    Without an equilibrium the tensions are not numbers. `response` is what `respond` gives, for whoever has it already.
    """
    response = respond(state, unilateral=unilateral) if response is None else response
    pretension = state.common_pretension(flexor_pretension, extensor_pretension)
    margin = np.asarray(pretension - response.required)
    taking = np.maximum(margin, response.lowest)
    # In place, for this is where the time of many states goes; the floors vary along no axis that `taking` has not.
    flexor, extensor = response.flexor_gain * taking, response.extensor_gain * taking
    flexor += response.flexor_floor
    extensor += response.extensor_floor
    return Balance(
        coupling=state,
        response=response,
        flexor=np.asarray(flexor),
        extensor=np.asarray(extensor),
        pretension=pretension,
        margin=margin,
    )


def _if_any(flags: Flags) -> Flags:
    """Flags; where none is set, one for all, so that what is made of them costs nothing."""
    return flags if flags.any() else np.zeros((1,) * np.ndim(flags), np.bool_)


def springs(state: Coupling) -> tuple[Array, Array]:
    """J_f²/c_f and J_e²/c_e, what either tendon adds to the elbow's stiffness with the motor held, N m/rad."""
    flexor = np.square(state.moment_arm) * (1.0 / state.flexor_compliance)
    return flexor, np.asarray(np.square(state.extensor_arm) / state.extensor_compliance)


def held_stiffness(
    state: Coupling, response: Response, elbow_torque_slope: Array, *, unilateral: Flag = True
) -> tuple[Array, Array]:
    """J_f²/c_f + J_e²/c_e + dτ_a/dθ of a taut and of a slack state, N m/rad; a slack tendon adds nothing."""
    flexor, extensor = springs(state)
    left = np.where(response.idle, 0.0, np.where(state.elbow_torque < 0.0, extensor, flexor))
    taut = flexor + extensor
    return taut + elbow_torque_slope, np.where(unilateral, left, taut) + elbow_torque_slope


def elbow_stiffness(held: tuple[Array, Array], balance: Balance, arm_slopes: tuple[Array, Real]) -> Array:
    """k = J_f²/c_f + J_e²/c_e + dτ_a/dθ - (J_f' - J_f c_f'/c_f) x + (J_e' - J_e c_e'/c_e) y, the motor held.

    In N m/rad; `held` is what `held_stiffness` gives, `arm_slopes` the two brackets. Negative where the arm is
    unstable: there the spool must turn back while the elbow goes on, and the direction of friction that the state
    assumes is wrong.
    """
    taut, slack = held
    standing = np.where(balance.is_slack, slack, taut) if balance.is_slack.any() else taut
    of_flexor, of_extensor = arm_slopes
    stiffness = standing - balance.flexor * of_flexor
    return np.asarray(stiffness + balance.extensor * of_extensor if np.any(of_extensor) else stiffness)
