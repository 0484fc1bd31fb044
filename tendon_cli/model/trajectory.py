"""A motion in time: speed, acceleration and direction of the joint along its samples.

The tendons are in balance at each sample: only the joint moves in time, by the inertia of limb and
load.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from tendon_cli.model.kinematics import Array, Flags, Real


class Trajectory:
    """Samples of a motion in time, (K,).

    A sample is found by its angle, so equal angles are made to differ in the last bits.
    """

    def __init__(self, time: Array, angle: Array, derivatives: Array, reversal: float) -> None:
        """Sort the samples by their angles and find the direction of each.

        Args:
            time: Times (K,), s.
            angle: Angles (K,), rad.
            derivatives: First three derivatives of the angle by time (3, K), rad/s, rad/s², rad/s³.
            reversal: Angle by which friction's direction lags behind a turn, as in
                `friction_directions`, rad.
        """
        self.time = time
        self.derivatives = derivatives
        self.reversal = reversal
        self.flexion = friction_directions(angle, reversal)
        self._order = np.argsort(angle, kind="stable")
        ascending = angle[self._order]
        for place in range(1, len(angle)):
            next_number = np.nextafter(ascending[place - 1], np.inf)
            ascending[place] = max(ascending[place], next_number)
        self._ascending = ascending
        self.angle = np.empty(len(angle))
        self.angle[self._order] = ascending

    @property
    def speed(self) -> Array:
        """Speed at each sample (K,), rad/s."""
        return np.asarray(self.derivatives[0])

    @property
    def acceleration(self) -> Array:
        """Acceleration at each sample (K,), rad/s²."""
        return np.asarray(self.derivatives[1])

    @property
    def weights(self) -> Array:
        """Weight of each sample in an integral over time by trapezoids (K,), s."""
        steps = np.diff(self.time)
        return np.asarray(0.5 * (np.append(steps, 0.0) + np.insert(steps, 0, 0.0)))

    def derivatives_at(self, angle: Real) -> Array:
        """Return the derivatives at angles of samples.

        Args:
            angle: Angles of any shape, rad.

        Returns:
            Three derivatives (3, ...), rad/s, rad/s², rad/s³. All are 0 at an angle that no sample
            has, where the joint rests.
        """
        wanted = np.asarray(np.real(angle))
        place = np.minimum(np.searchsorted(self._ascending, wanted), len(self._order) - 1)
        sample = self._order[place]
        is_sampled = self._ascending[place] == wanted
        return np.where(is_sampled, self.derivatives[:, sample], 0.0)

    @property
    def with_shifted_turns(self) -> tuple[Trajectory, Trajectory]:
        """The motion with friction that turns one sample earlier, and with friction one later.

        Together they cover every turn that is possible with peaks between the samples.
        """
        # A parabola rises above its samples by up to an eighth of their second difference.
        peak = np.abs(np.diff(self.angle, 2)).max() / 8.0
        early_flexion = friction_directions(self.angle, max(0.0, self.reversal - peak))
        late_flexion = friction_directions(self.angle, self.reversal + peak)
        early = copy(self)
        early.flexion = np.append(early_flexion[1:], self.flexion[-1])
        late = copy(self)
        late.flexion = np.insert(late_flexion[:-1], 0, self.flexion[0])
        return early, late


def friction_directions(angle: Array, reversal: float) -> Flags:
    """Return True for samples at which friction has the direction of flexion.

    Its direction turns once the angle has come back by `reversal`. At rest it is that of the last
    motion; before the first motion it is that of the next.

    Args:
        angle: Angles in the order of time (K,), rad.
        reversal: Angle by which friction's direction lags behind a turn, rad.

    Returns:
        True in flexion, False in extension (K,).
    """
    flexion = np.empty(len(angle), np.bool_)
    first = angle[0]
    furthest = angle[0]
    direction = 0  # 1 in flexion, -1 in extension, 0 before the first motion
    for place, value in enumerate(angle):
        if direction == 0:
            if abs(value - first) > reversal:
                direction = int(np.sign(value - first))
            furthest = value
            flexion[: place + 1] = direction > 0
        elif direction * (furthest - value) > reversal:
            direction = -direction
            furthest = value
        else:
            furthest = max(direction * furthest, direction * value) * direction
        flexion[place] = direction > 0
    if direction == 0:
        flexion[:] = angle[-1] >= angle[0]
    return flexion
