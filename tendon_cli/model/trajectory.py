"""A motion in time: speed, acceleration and direction of the joint along its samples.

The tendons are in balance at each of them: what moves in time is the joint alone, by the inertia of limb and load.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from tendon_cli.model.kinematics import Array, Flags, Real


class Trajectory:
    """Samples of a motion in time, (K,), of which each is known by its angle; no two have the same to the last bit."""

    def __init__(self, time: Array, angle: Array, derivatives: Array, reversal: float) -> None:
        """Times (s), angles (rad), three derivatives (3, K), by how much (rad) friction's direction lags (`ways`)."""
        self.time, self.derivatives, self.reversal = time, derivatives, reversal
        self.flexion = ways(angle, reversal)
        self._order = np.argsort(angle, kind="stable")
        self._ascending = angle[self._order]
        for at in range(1, len(angle)):
            self._ascending[at] = max(
                self._ascending[at], np.nextafter(self._ascending[at - 1], np.inf)
            )
        self.angle = np.empty(len(angle))
        self.angle[self._order] = self._ascending

    @property
    def speed(self) -> Array:
        """rad/s."""
        return np.asarray(self.derivatives[0])

    @property
    def acceleration(self) -> Array:
        """rad/s²."""
        return np.asarray(self.derivatives[1])

    @property
    def weights(self) -> Array:
        """Of each sample in an integral over time, s (trapezoids)."""
        steps = np.diff(self.time)
        return np.asarray(0.5 * (np.append(steps, 0.0) + np.insert(steps, 0, 0.0)))

    def at(self, angle: Real) -> Array:
        """The derivatives at angles of samples, (3, ...); all are 0 at any other, where the joint rests."""
        wanted = np.asarray(np.real(angle))
        near = np.minimum(np.searchsorted(self._ascending, wanted), len(self._order) - 1)
        sample, is_one = self._order[near], self._ascending[near] == wanted
        return np.where(is_one, self.derivatives[:, sample], 0.0)

    @property
    def turning(self) -> tuple[Trajectory, Trajectory]:
        """The same where friction turns a sample earlier, and a sample later, whatever peaks lie between samples."""
        room = np.abs(np.diff(self.angle, 2)).max() / 8.0
        early, late = copy(self), copy(self)
        early.flexion = np.append(
            ways(self.angle, max(0.0, self.reversal - room))[1:], self.flexion[-1]
        )
        late.flexion = np.insert(ways(self.angle, self.reversal + room)[:-1], 0, self.flexion[0])
        return early, late


def ways(angle: Array, reversal: float) -> Flags:
    """Whether friction is that of flexion: it turns once the angle has come back by `reversal` (rad).

    At rest it is that of the last motion, at first that of the next.
    """
    flexion, way, furthest, first = np.empty(len(angle), np.bool_), 0, angle[0], angle[0]
    for at, value in enumerate(angle):
        if way == 0:
            way = 0 if abs(value - first) <= reversal else int(np.sign(value - first))
            furthest = value
            flexion[: at + 1] = way > 0
        elif way * (furthest - value) > reversal:
            way, furthest = -way, value
        else:
            furthest = max(way * furthest, way * value) * way
        flexion[at] = way > 0
    if way == 0:
        flexion[:] = angle[-1] >= angle[0]
    return flexion
