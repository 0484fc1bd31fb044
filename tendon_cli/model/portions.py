"""States of many designs with their axes in another order, and in portions that are quick to go over."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
import numpy.typing as npt

Kind = TypeVar("Kind", bound=np.generic)
Place = tuple[slice, ...]

STATES_AT_ONCE = 2**17
"""Fewer stay closer to the processor, but threads then wait for Python's lock more often than they compute."""
_FEWEST = 128
"""Values along the last axis below which each call of NumPy takes longer than its arithmetic."""


@dataclass(frozen=True)
class StateAxes:
    """Axes of states: directions, then elbow angles, pretensions, and as one all others of designs, the longest last.

    Without an axis of pretensions they stay as they are, for then each factor of the model is worked out only where it
    varies. What does not vary along an axis has one value there.
    """

    shape: tuple[int, ...]
    """Of states as they come: axes of designs, directions, elbow angles."""
    free: int | None
    """The axis of designs that nothing but pretension depends on, if any."""

    @cached_property
    def groups(self) -> list[tuple[int, ...]]:
        """The axes, each by those of `shape` that it is made of."""
        if self.free is None:
            return [(axis,) for axis in range(len(self.shape))]
        direction, angle = (len(self.shape) - 2,), (len(self.shape) - 1,)
        others = tuple(axis for axis in range(len(self.shape) - 2) if axis != self.free)
        rest = [others, (self.free,), angle]
        last = max(rest, key=lambda group: math.prod(self.shape[axis] for axis in group))
        return [direction, *(group for group in reversed(rest) if group is not last), last]

    @cached_property
    def lengths(self) -> list[int]:
        """Values along each axis."""
        return [math.prod(self.shape[axis] for axis in group) for group in self.groups]

    @property
    def directions(self) -> int:
        """Which axis that of directions is, counted from the last."""
        return self._of(len(self.shape) - 2)

    @property
    def angles(self) -> int:
        """Which axis that of elbow angles is, counted from the last."""
        return self._of(len(self.shape) - 1)

    def _of(self, axis: int) -> int:
        return self.groups.index((axis,)) - len(self.groups)

    @cached_property
    def designs(self) -> tuple[int, ...]:
        """The shape of designs along these axes."""
        return tuple(
            math.prod(self.shape[axis] for axis in group if axis < len(self.shape) - 2) for group in self.groups
        )

    def laid(self, values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        """What broadcasts to the shape of states, along these axes."""
        full = values.reshape((1,) * (len(self.shape) - values.ndim) + values.shape)
        lengths = list(full.shape)
        for group in self.groups:
            if any(lengths[axis] > 1 for axis in group):
                for axis in group:
                    lengths[axis] = self.shape[axis]
        moved = np.broadcast_to(full, lengths).transpose([axis for group in self.groups for axis in group])
        return np.ascontiguousarray(
            moved.reshape([math.prod(lengths[axis] for axis in group) for group in self.groups])
        )

    def back(self, values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        """What designs come to, in the shape of `shape` without its last two axes."""
        order = [axis for group in self.groups for axis in group]
        apart = values.reshape([1 if axis >= len(order) - 2 else self.shape[axis] for axis in order])
        return apart.transpose(np.argsort(order))[..., 0, 0]

    def portions(self) -> Iterator[Place]:
        """Some elbow angles of a direction after the other, or all states, where these are few."""
        if self.free is None or math.prod(self.shape) <= STATES_AT_ONCE:
            return self._cuts({})
        return self._cuts({self.directions: 1, self.angles: self._at_once[0]})

    def runs(self) -> Iterator[Place]:
        """Some pretensions after the other, of all else."""
        return self._cuts({} if self.free is None else {self._of(self.free): self._at_once[1]})

    @cached_property
    def _at_once(self) -> tuple[int, int]:
        """How many elbow angles, and pretensions, are best taken at once."""
        angles, pretensions = self.shape[-1], 1 if self.free is None else self.shape[self.free]
        others = math.prod(self.shape[:-2]) // pretensions
        fewest = _FEWEST if self.groups[-1] == (self.free,) else 1
        run = min(pretensions, max(fewest, STATES_AT_ONCE // (angles * others)))
        most = max(1, STATES_AT_ONCE // (run * others))
        return -(-angles // -(-angles // most)), run

    def _cuts(self, most: dict[int, int]) -> Iterator[Place]:
        def along(axis: int, length: int) -> list[slice]:
            step = most.get(axis - len(self.lengths), length)
            return [slice(start, start + step) for start in range(0, length, step)] if step < length else [slice(None)]

        return itertools.product(*itertools.starmap(along, enumerate(self.lengths)))


def cut(values: npt.NDArray[Kind], place: Place) -> npt.NDArray[Kind]:
    """Values in a place, where they vary along its axes."""
    if not values.ndim:
        return values
    lengths = zip(values.shape, place, strict=True)
    return values[tuple(slice(None) if length == 1 else part for length, part in lengths)]
