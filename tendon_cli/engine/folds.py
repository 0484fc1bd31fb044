"""The folds over the states of a plan's designs: rows of `designs` with their windows; and over these: choices."""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.engine.plan import Block, Plan, bounds_of
from tendon_cli.model import extremes, window
from tendon_cli.model.design import Design
from tendon_cli.model.extremes import Found
from tendon_cli.model.kinematics import Flags
from tendon_cli.space.axis import PRETENSION

VALUES_AT_ONCE = 2**18
"""In an array that compiled code is given, and states of which NumPy has several arrays."""
_DESIGNS, _STATES = 2**15, 2**24
"""That are worked out at once."""
_MOST_KEPT, _MOST_BEFORE = 2**17, 2**25
"""Windows of all designs that are kept in memory, and states that are gone over before any part, if no more."""

COUNTED = ("taut", "stable", "feasible", "slack", "no_equilibrium", "unstable")
"""What the record counts: designs with each judgement, states that are slack, without equilibrium or unstable."""


@dataclass(frozen=True, eq=False)
class Folds:
    """What the designs of a plan come to."""

    plan: Plan

    @cached_property
    def _only_pretension(self) -> frozenset[int]:
        """The design axes that nothing but pretension depends on."""
        return frozenset(range(len(self.plan.shape))) - self.plan.space.axes_of(
            lambda key: key != PRETENSION
        )

    @cached_property
    def _of_the_arm(self) -> frozenset[int]:
        """The design axes that the arm's motion depends on, so that there is something to know for each elbow angle."""
        return self.plan.space.axes_of(lambda key: key.startswith(("arm.", "model.")))

    def small_blocks(self, block: Block) -> Iterator[Block]:
        """The block in pieces, so that what is worked out for each takes little memory."""
        return block.cut(self._to_cut)

    def _to_cut(self, block: Block) -> int | None:
        """Where a block has to be cut in two, if at all: best where pretension goes on along all its values."""
        plan, free, lengths, states = (
            self.plan,
            self._only_pretension,
            block.shape[:-2],
            self.plan.states_per_design,
        )
        whole = frozenset(range(len(lengths)))
        most_of = [
            (whole, 1, _DESIGNS),
            (whole, states, _STATES if kernel.kind() else 4 * plan.block_states),
        ]
        if kernel.kind():
            most_of += [
                (self._of_the_arm, len(plan.elbow_angles), VALUES_AT_ONCE),
                (whole - free, 2, VALUES_AT_ONCE),
            ]
        if (
            plan.of_forms or plan.of_motion or extremes.OVER_STATES
        ):  # NumPy has arrays of all states
            most_of += [(whole, states, VALUES_AT_ONCE)]
        for axes, each, most in most_of:
            long = [axis for axis in axes if lengths[axis] > 1]
            if long and each * math.prod(lengths[axis] for axis in long) > most:
                return max(long, key=lambda axis: (axis not in free, lengths[axis]))
        return None

    def designs(self, block: Block) -> dict[str, npt.NDArray[Any]]:
        """Results and judgements of the designs of a small block, and how many of their states are what is counted."""
        plan, design = self.plan, self.plan.design(block)
        folded = extremes.begin(block.shape[:-2])
        for stretch in self._stretches(block):
            kernel.fold_extremes(
                folded,
                plan.state(stretch, design),
                plan.elbow_angles[stretch.angles],
                stretch.shape,
            )
        results = extremes.as_read(extremes.finished(folded, plan.states_per_design), design)
        results |= (
            self._by_numpy(block, design)
            | extremes.of_design(design, folded)
            | self.windows(block, design)
        )
        return (
            results
            | extremes.judged(results, plan.study.limits)
            | {name: folded[name] for name in extremes.COUNTS}
        )

    def windows(self, block: Block, design: Design) -> Found:
        """The windows of a block, worked out once for all designs that differ in pretension alone."""
        free = self._only_pretension
        if self.known_windows is not None:
            place = tuple(
                slice(0, 1) if axis in free else part for axis, part in enumerate(block.designs)
            )
            columns = {name: values[place] for name, values in self.known_windows.items()}
        else:
            first = block.first_along(free)
            columns = self._windows(
                first, design if first.shape == block.shape else self.plan.design(first)
            )
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in columns.items()}

    @cached_property
    def known_windows(self) -> Found | None:
        """Those of the whole plan, if blocks share them and they are few."""
        plan = self.plan
        (whole,) = plan.blocks(range(plan.designs))
        every = whole.first_along(self._only_pretension)
        states, most = math.prod(every.shape), _MOST_BEFORE if kernel.kind() else _MOST_BEFORE // 16
        if every.design_count == plan.designs or every.design_count > _MOST_KEPT or states > most:
            return None
        columns = {
            name: np.empty(every.shape[:-2]) for name in ("pretension_from", "pretension_to")
        }
        for block in self.small_blocks(every):
            for name, values in self._windows(block, plan.design(block)).items():
                columns[name][block.designs] = values
        return columns

    def _windows(self, block: Block, design: Design) -> Found:
        plan, bounds = self.plan, bounds_of(self.plan.study)
        if bounds.of_motion:  # limits over several states at once
            from tendon_cli.model.motor_window import narrowed  # only these pay for its import

            motion = plan.motion(block)
            ends: window.Ends = narrowed(
                window.window(design, *motion, bounds), design, *motion, bounds
            )
        else:
            folded = window.begin(block.shape[:-2])
            for stretch in self._stretches(block):
                at, count = plan.state(stretch, design), len(plan.elbow_angles)
                kernel.fold_window(folded, at, bounds, stretch.shape, stretch.angles.start, count)
            ends = window.finished(folded, design, bounds)
        ends = window.as_read(ends, design)
        return {
            "pretension_from": ends.low,
            "pretension_to": np.where(np.isinf(ends.high), np.nan, ends.high),
        }

    def _stretches(self, block: Block) -> Iterator[Block]:
        """The block cut along its angles into what is best taken at once; the results do not depend on it."""
        most = VALUES_AT_ONCE if kernel.kind() else self.plan.block_states
        return block.cut(lambda piece: len(piece.shape) - 1 if piece.shape[-1] > most else None)

    def _by_numpy(self, block: Block, design: Design) -> Found:
        """What compiled code does not know: columns of entries and forms of states, and those that a speed adds."""
        plan, speed, columns = self.plan, self.plan.study.motion.speed, {}
        if plan.of_forms or extremes.OVER_STATES:
            state = plan.state(block, design)
            columns = extremes.of_forms(plan.of_forms, state) | extremes.over_states(
                state, block.shape
            )
        if plan.study.trajectory is not None:
            from tendon_cli.model.motor import along  # only a study of motion pays for its import

            columns |= along(design, plan.study.trajectory)
        elif speed is not None:
            from tendon_cli.model.motor import cycle

            columns |= cycle(design, *plan.motion(block), speed.single)
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in columns.items()}


# --- Choices ---------------------------------------------------------------------------------------------------------
#
# A choice is a combination of the axes that are no condition, feasible if its designs are so under all conditions at
# once; these may be spread over the whole run. So each part notes which of its designs are feasible, a bit each.


def _chosen(plan: Plan) -> list[int]:
    """The design axes that are no conditions."""
    return [at for at, key in enumerate(plan.study.axes) if key not in plan.study.conditions]


def choices(plan: Plan) -> int:
    """How many choices a study has."""
    return math.prod(plan.shape[axis] for axis in _chosen(plan))


def noted(feasible: Flags) -> str:
    """Which designs of a part are feasible, as text."""
    return base64.b64encode(zlib.compress(np.packbits(feasible).tobytes(), 6)).decode()


def flags(note: Any, count: int) -> Flags | None:
    """Which of so many designs a text says are feasible; None if it does not say it of just so many."""
    size = -(-count // 8)
    try:
        packed = zlib.decompressobj().decompress(base64.b64decode(note, validate=True), size + 1)
    except (zlib.error, binascii.Error, ValueError, TypeError):
        return None
    return (
        np.unpackbits(np.frombuffer(packed, np.uint8))[:count] > 0 if len(packed) == size else None
    )


def feasible_choices(plan: Plan, notes: Iterable[str]) -> int:
    """How many choices are feasible in a run, from what all its parts say of their designs, in their order."""
    shape, chosen = (*plan.shape, 1), [*_chosen(plan), len(plan.shape)]  # there may be no axis
    still = np.ones([shape[axis] for axis in chosen], np.bool_)
    for index, note in enumerate(notes):
        designs = plan.part(index)
        feasible = flags(note, len(designs))
        if feasible is None:
            raise ValueError(f"part {index} does not say which designs are feasible")
        failing = np.unravel_index(designs.start + np.flatnonzero(~feasible), shape)
        still[tuple(failing[axis] for axis in chosen)] = False
    return int(still.sum())
