"""States of many designs laid out anew, and in portions that stay within the processor's cache."""

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

STATES_AT_ONCE = 2**15
"""A few arrays of them stay within the processor's cache."""
_FEWEST = 128
"""Values along the last axis below which each call of NumPy takes longer than its arithmetic."""
DIRECTIONS, ANGLES, PRETENSIONS, OTHERS = range(4)


@dataclass(frozen=True)
class StateAxes:
    """States along four axes: directions, elbow angles, pretensions, and as one all other axes of designs.

    The longest of them but the first is the last; what does not vary along an axis has one value there.
    """

    shape: tuple[int, ...]
    """Of states as they come: axes of designs, directions, elbow angles."""
    free: int | None
    """The axis of designs that nothing but pretension depends on, if any."""

    @property
    def others(self) -> list[int]:
        """All other axes of designs."""
        return [axis for axis in range(len(self.shape) - 2) if axis != self.free]

    @cached_property
    def lengths(self) -> tuple[int, ...]:
        """Directions, elbow angles, pretensions, other designs."""
        pretensions = 1 if self.free is None else self.shape[self.free]
        return *self.shape[-2:], pretensions, math.prod(self.shape[:-2]) // pretensions

    @cached_property
    def order(self) -> tuple[int, ...]:
        """Which of the four comes where."""
        last = max((OTHERS, PRETENSIONS, ANGLES), key=self.lengths.__getitem__)
        return *(axis for axis in range(4) if axis != last), last

    @property
    def designs(self) -> tuple[int, ...]:
        """The shape of designs along these axes."""
        return tuple(self.lengths[axis] if axis in (PRETENSIONS, OTHERS) else 1 for axis in self.order)

    @property
    def angles(self) -> int:
        """Which of these axes that of elbow angles is."""
        return self.order.index(ANGLES)

    def laid(self, values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        """What broadcasts to the shape of states, along these axes."""
        full, count = values.reshape((1,) * (len(self.shape) - values.ndim) + values.shape), len(self.shape)
        free = () if self.free is None else (self.free,)
        moved = full.transpose(count - 2, count - 1, *free, *self.others)
        ahead = moved.shape[: 2 + len(free)]
        if math.prod(moved.shape[2 + len(free) :]) > 1:
            moved = np.broadcast_to(moved, (*ahead, *(self.shape[axis] for axis in self.others)))
        one = moved.reshape(*ahead, *(() if free else (1,)), -1)
        return np.ascontiguousarray(one.transpose(self.order))

    def back(self, values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        """What designs come to, as they came."""
        apart = values.transpose(np.argsort(self.order)).reshape(-1, *(self.shape[axis] for axis in self.others))
        return apart[0] if self.free is None else np.moveaxis(apart, 0, self.free)

    @cached_property
    def _at_once(self) -> tuple[int, int]:
        """How many elbow angles, and pretensions, are best taken at once."""
        _, angles, pretensions, others = self.lengths
        fewest = _FEWEST if self.order[-1] == PRETENSIONS else 1
        run = min(pretensions, max(fewest, STATES_AT_ONCE // (angles * others)))
        most = max(1, STATES_AT_ONCE // (run * others))
        return -(-angles // -(-angles // most)), run

    def portions(self) -> Iterator[Place]:
        """Some elbow angles of a direction after the other, of all designs."""
        return self._cuts({DIRECTIONS: 1, ANGLES: self._at_once[0]})

    def runs(self) -> Iterator[Place]:
        """Some pretensions after the other, of all else."""
        return self._cuts({PRETENSIONS: self._at_once[1]})

    def _cuts(self, most: dict[int, int]) -> Iterator[Place]:
        def along(axis: int) -> list[slice]:
            if axis not in most:
                return [slice(None)]
            return [slice(start, start + most[axis]) for start in range(0, self.lengths[axis], most[axis])]

        return itertools.product(*map(along, self.order))


def cut(values: npt.NDArray[Kind], place: Place) -> npt.NDArray[Kind]:
    """Values in a place, where they vary along its axes."""
    lengths = zip(values.shape, place, strict=True)
    return values[tuple(slice(None) if length == 1 else part for length, part in lengths)]
