"""A motion in time: angles of the joint, their derivatives, and a task's torque at its samples.

The tendons are in balance at each sample: only the joint moves in time, by the inertia of limb and
load. Which way the tendons slide is not part of the motion, but follows from each design
(`sliding`).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array, Flags, Real

_SAME_TIME = 1e-9
"""Distance within which two times are the same but for rounding, as a share of a step."""


def lasting_signs(rates: Array) -> npt.NDArray[np.int8]:
    """Return the signs of rates, (N, K); at rest that of the last motion.

    Before the first motion it is that of the first, and 1 without any.
    """
    signs = np.sign(rates).astype(np.int8)
    moves = signs != 0
    if moves.all():
        return signs
    places = np.where(moves, np.arange(rates.shape[1]), -1)
    last = np.maximum.accumulate(places, axis=1)
    first = moves.argmax(axis=1)[:, np.newaxis]
    lasting = np.take_along_axis(signs, np.where(last < 0, first, last), axis=1)
    return np.where(lasting == 0, np.int8(1), lasting)


class Trajectory:
    """Samples of a motion in time, (K,).

    A sample is found by its angle, so equal angles are made to differ in the last bits.
    """

    def __init__(
        self,
        time: Array,
        angle: Array,
        derivatives: Array,
        *,
        task: Array | None = None,
        margin: float = 0.0,
    ) -> None:
        """Sort the samples by their angles.

        Args:
            time: Times (K,), s.
            angle: Angles (K,), rad.
            derivatives: First three derivatives of the angle by time (3, K), rad/s, rad/s², rad/s³.
            task: Torque of a task over time and its rate (2, K), N m and N m/s, positive if the
                flexor must give it; None without one.
            margin: Time at either end of the record in which smoothing spoils derivatives, s: the
                samples there count in no peak, mean, work or limit.
        """
        self.time = time
        self.derivatives = derivatives
        self.task = task
        self.margin = margin
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
    def is_flexing(self) -> Flags:
        """True at samples at which the joint flexes (K,); at rest as in its last motion."""
        return np.asarray(lasting_signs(self.speed[np.newaxis])[0] > 0)

    @property
    def counted(self) -> slice:
        """Samples that count in peaks, means, works and limits: all but those at the ends."""
        slack = _SAME_TIME * float(self.time[1] - self.time[0])
        first = np.searchsorted(self.time, self.time[0] + self.margin - slack)
        stop = np.searchsorted(self.time, self.time[-1] - self.margin + slack, side="right")
        return slice(int(first), int(stop))

    @property
    def is_at_end(self) -> Flags:
        """True at samples at the ends of the record, which do not count (K,)."""
        at_end = np.ones(len(self.time), dtype=np.bool_)
        at_end[self.counted] = False
        return at_end

    @property
    def weights(self) -> Array:
        """Weight of each sample in an integral over time by trapezoids (K,), s; 0 at the ends."""
        weights = np.zeros(len(self.time))
        steps = np.diff(self.time[self.counted])
        weights[self.counted] = 0.5 * (np.append(steps, 0.0) + np.insert(steps, 0, 0.0))
        return weights

    def derivatives_at(self, angle: Real) -> Array:
        """Return the derivatives at angles of samples.

        Args:
            angle: Angles of any shape, rad.

        Returns:
            Three derivatives (3, ...), rad/s, rad/s², rad/s³. All are 0 at an angle that no sample
            has, where the joint rests.
        """
        return self._at(angle, self.derivatives)

    def task_at(self, angle: Real) -> Array:
        """Return the torque of the task and its rate at angles of samples, (2, ...), N m and N m/s.

        Both are 0 without a task over time, and at an angle that no sample has.

        Args:
            angle: Angles of any shape, rad.
        """
        if self.task is None:
            return np.zeros((2, *np.shape(angle)))
        return self._at(angle, self.task)

    def _at(self, angle: Real, values: Array) -> Array:
        """Return values of samples (..., K) at angles; 0 at an angle that no sample has."""
        wanted = np.asarray(np.real(angle))
        place = np.minimum(np.searchsorted(self._ascending, wanted), len(self._order) - 1)
        sample = self._order[place]
        is_sampled = self._ascending[place] == wanted
        return np.where(is_sampled, values[:, sample], 0.0)
