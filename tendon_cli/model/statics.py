"""Balance of the elbow and of the one motor that turns both spools (Eqs. 4, 5 and 12-20).

The unknowns are the distal tensions x (flexor) and y (extensor). With c the distal compliance of a side,

    J_f x - J_e y = τ_a                                   elbow balance, Eq. 5, whose J^e is -J_e
    η (c_f x - c_f0 F0_f) + c_e y - c_e0 F0_e = H_e - η H_f    both spools turn together, Eqs. 12-16

with c0 the compliance in the posture in which the pretension is set; only a bend that follows the joint makes it
another.

The sign of the right side and the simultaneous solution depart from the paper's text; only so do its own figures
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
    """The solution of a state at a pretension; without an equilibrium its numbers are NaN."""

    coupling: Coupling
    response: Response
    pretension: Array
    """Of both sides, or what does the same, N."""

    @cached_property
    def margin(self) -> Array:
        """By how much that is above the smallest that keeps the state taut, N."""
        return np.asarray(self.pretension - self.response.required)

    @cached_property
    def flexor(self) -> Array:
        """x, distal flexor tension, N."""
        response = self.response
        return np.asarray(response.flexor_gain * np.maximum(self.margin, response.lowest) + response.flexor_floor)

    @cached_property
    def extensor(self) -> Array:
        """y, distal extensor tension, N."""
        response = self.response
        return np.asarray(response.extensor_gain * np.maximum(self.margin, response.lowest) + response.extensor_floor)

    @cached_property
    def flexor_slack(self) -> Flags:
        """Whether the flexor is."""
        return np.asarray(self.pretension < self.response.flexor_limit)

    @cached_property
    def extensor_slack(self) -> Flags:
        """Likewise the extensor."""
        return np.asarray(self.pretension < self.response.extensor_limit)

    @cached_property
    def status(self) -> Status:
        """Index into STATUS_NAMES."""
        slack = self.flexor_slack * np.int8(FLEXOR_SLACK) + self.extensor_slack * np.int8(EXTENSOR_SLACK)
        return np.where(np.isnan(self.coupling.moment_arm), np.int8(NO_EQUILIBRIUM), slack)

    @cached_property
    def is_slack(self) -> Flags:
        """Whether either side is."""
        return np.asarray(self.pretension < self.response.limit)

    @property
    def path(self) -> Array:
        """η c_f x + c_e y - D of a slack state, m."""
        return np.asarray(-self.coupling.common_compliance * self.margin)

    @property
    def loose(self) -> Array:
        """σ >= 0, path length that no tendon takes up; 0 where taut, m."""
        taut = np.where(np.isnan(self.coupling.moment_arm), np.nan, np.zeros_like(self.margin))
        return np.where(self.is_slack & np.asarray(self.response.unilateral), self.path, taut)


def solve(
    state: Coupling, flexor_pretension: Real, extensor_pretension: Real, *, unilateral: Flag = True,
    response: Response | None = None,
) -> Balance:  # fmt: skip
    """Distal tensions and status. `unilateral` tendons cannot push; otherwise negative tension is the paper's slack.

    Without an equilibrium the tensions are not numbers. `response` is what `respond` gives, for whoever has it already.
    """
    response = respond(state, unilateral=unilateral) if response is None else response
    return Balance(state, response, state.common_pretension(flexor_pretension, extensor_pretension))
