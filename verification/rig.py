"""States of rest in MuJoCo, found with its inverse dynamics.

Nothing here knows the equations of tendon. The engine finds path lengths, moment arms and the
forces that hold its joints; the root search moves the junctions and the spool until junctions and
elbow need none. Tendons and springs pull only beyond their natural length, so that a slack side is
slack of itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from verification.cases import Case
from verification.mjcf import ELBOW, EXTENSOR, FLEXOR, SPOOL, Chain, mjcf

Array = npt.NDArray[np.float64]

_FURTHEST_WINDING = 6.0
"""Length of tendon that the root search may wind, m; the junctions may go twice as far."""
_SLACK_BELOW = 1e-6  # N
_ELBOW_STEP = 1e-4  # rad, for the stiffness


@dataclass(frozen=True)
class Answer:
    """Answer of the engine to a case, SI units."""

    flexor_path: float
    flexor_moment_arm: float
    extensor_travel: float
    extensor_moment_arm: float
    flexor_tension: float
    extensor_tension: float
    flexor_slack: float
    extensor_slack: float
    loose: float
    """Path that no tendon takes up: η times the flexor's slack plus the extensor's, m."""
    spool_angle: float
    motor_torque: float
    elbow_torque: float
    elbow_stiffness: float
    flexor_is_slack: bool
    extensor_is_slack: bool


class Rig:
    """One case in the engine."""

    def __init__(self, case: Case) -> None:
        self._case = case
        self._model = mujoco.MjModel.from_xml_string(mjcf(case))
        self._data = mujoco.MjData(self._model)

    def answer(self) -> Answer:
        """Return kinematics and the state of rest at the case's elbow angle."""
        elbow = self._case.elbow_angle
        spool = self._resting_spool(elbow, 0.0)
        self._settle(elbow, spool)
        both_slack = max(self._tension(FLEXOR), self._tension(EXTENSOR)) < _SLACK_BELOW
        if both_slack:  # the spool rests anywhere between two ends
            spool = (self._resting_spool(elbow, 1e-3) + self._resting_spool(elbow, -1e-3)) / 2.0
        ahead = self._settle(elbow + _ELBOW_STEP, spool)[ELBOW]
        behind = self._settle(elbow - _ELBOW_STEP, spool)[ELBOW]
        holding = self._settle(elbow, spool)
        length = self._data.ten_length.copy()
        flexor_slack = self._slack(FLEXOR)
        extensor_slack = self._slack(EXTENSOR)
        flexor = self._tension(FLEXOR)
        extensor = self._tension(EXTENSOR)
        return Answer(
            flexor_path=length[FLEXOR.path],
            flexor_moment_arm=-self._moment_arm(FLEXOR.path),
            extensor_travel=length[EXTENSOR.path] - self._model.tendon_length0[EXTENSOR.path],
            extensor_moment_arm=self._moment_arm(EXTENSOR.path),
            flexor_tension=flexor,
            extensor_tension=extensor,
            flexor_slack=flexor_slack,
            extensor_slack=extensor_slack,
            loose=self._case.ratio * flexor_slack + extensor_slack,
            spool_angle=spool,
            motor_torque=holding[SPOOL],
            elbow_torque=self._gravity_torque(),
            elbow_stiffness=(ahead - behind) / (2.0 * _ELBOW_STEP),
            flexor_is_slack=flexor < _SLACK_BELOW,
            extensor_is_slack=extensor < _SLACK_BELOW,
        )

    def _holding(self, *position: float) -> Array:
        """Return the torques and forces that hold the four joints at a displacement.

        By the engine's inverse dynamics, N m and N.
        """
        self._data.qpos[:] = self._model.qpos0 + position
        self._data.qvel[:] = 0.0
        self._data.qacc[:] = 0.0
        mujoco.mj_inverse(self._model, self._data)
        holding: Array = self._data.qfrc_inverse.copy()
        return holding

    def _settle(self, elbow: float, spool: float) -> Array:
        """Let both junctions come to rest, elbow and spool held; return what holds the joints."""
        reach = 2.0 * _FURTHEST_WINDING
        flexor = _root(lambda end: self._holding(elbow, spool, end, 0.0)[FLEXOR.junction], reach)
        extensor = _root(
            lambda end: self._holding(elbow, spool, 0.0, end)[EXTENSOR.junction], reach
        )
        return self._holding(elbow, spool, flexor, extensor)

    def _resting_spool(self, elbow: float, pull: float) -> float:
        """Return the spool angle at which the elbow stays where it is, `pull` (N m) against it."""
        reach = _FURTHEST_WINDING / self._case.flexor_radius
        return _root(lambda spool: self._settle(elbow, spool)[ELBOW] - pull, reach)

    def _tension(self, chain: Chain) -> float:
        """Return the distal tension of a side, N: it holds the junction once the tendon is cut."""
        return float(self._with_cut([chain.tendon])[chain.junction])

    def _gravity_torque(self) -> float:
        """Return the torque that holds the elbow against gravity alone, with everything cut."""
        all_tendons = list(range(self._model.ntendon))
        return float(self._with_cut(all_tendons)[ELBOW])

    def _with_cut(self, tendons: list[int]) -> Array:
        """Return what holds the joints at the present position without some of the tendons."""
        stiffness = self._model.tendon_stiffness.copy()
        self._model.tendon_stiffness[tendons] = 0.0
        holding = self._holding(*(self._data.qpos - self._model.qpos0))
        self._model.tendon_stiffness[:] = stiffness
        return holding

    def _slack(self, chain: Chain) -> float:
        """Return the length by which a side is shorter than natural, spring and tendon, m."""
        pair = [chain.spring, chain.tendon]
        missing = self._model.tendon_lengthspring[pair, 1] - self._data.ten_length[pair]
        return max(0.0, float(np.sum(missing)))

    def _moment_arm(self, tendon: int) -> float:
        """Return d(length)/d(elbow angle) from the engine's Jacobian of tendon lengths, m/rad."""
        first = self._model.ten_J_rowadr[tendon]
        entries = slice(first, first + self._model.ten_J_rownnz[tendon])
        is_of_elbow = self._model.ten_J_colind[entries] == ELBOW
        return float(self._data.ten_J[entries][is_of_elbow].sum())


def _root(function: Callable[[float], float], reach: float) -> float:
    """Return the root of a function between -reach and reach."""
    return float(brentq(function, -reach, reach, xtol=1e-16, rtol=1e-15, maxiter=200))
