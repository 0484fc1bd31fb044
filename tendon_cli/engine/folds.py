"""Folds over the states of a plan's designs: rows of `designs`, their windows, feasible choices."""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from tendon_cli import kernel
from tendon_cli.engine.plan import Block, Plan, bounds_of
from tendon_cli.engine.window_fold import fold_ends, named_ends
from tendon_cli.model import extremes, window
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.extremes import Extremes
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import EXTENSOR_SLACK, FLEXOR_SLACK, LIMITS
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.model.window import Window, drop_state_axes
from tendon_cli.studies.space.axis import PRETENSION, limit_of

if TYPE_CHECKING:
    from tendon_cli.model.moving import Moving

VALUES_AT_ONCE = 2**18
"""Most values in an array for compiled code, and most states where NumPy has arrays of all."""
_DESIGNS_AT_ONCE = 2**15
"""Most designs in a small block."""
_STATES_AT_ONCE = 2**24
"""Most states in a small block if compiled code folds them."""
_MOST_WINDOWS_KEPT = 2**17
"""Most windows that are kept in memory for all designs of a plan."""
_MOST_STATES_BEFOREHAND = 2**25
"""Most states that are folded to windows before any part is begun."""

_REQUIRED = "required_pretension"
COUNTED = ("taut", "stable", "feasible", "slack", "no_equilibrium", "unstable")
"""Counts in the record: designs by judgement; slack, unbalanced and unstable states."""


@dataclass(frozen=True, eq=False)
class Folds:
    """Results of the designs of a plan, each folded from all states of the design."""

    plan: Plan

    @cached_property
    def _pretension_axes(self) -> frozenset[int]:
        """Design axes along which nothing but pretension varies."""
        others = self.plan.space.axes_of(lambda key: key != PRETENSION)
        return frozenset(range(len(self.plan.shape))) - others

    @cached_property
    def _limit_axes(self) -> frozenset[int]:
        """Design axes along which nothing but limits varies."""
        others = self.plan.space.axes_of(lambda key: limit_of(key) is None)
        return frozenset(range(len(self.plan.shape))) - others

    @cached_property
    def _bounds(self) -> Bounds:
        """Limits of the plan's designs."""
        return bounds_of(self.plan.study, self.plan.space)

    @cached_property
    def _arm_axes(self) -> frozenset[int]:
        """Design axes along which moment arms and travels at an elbow angle vary."""
        return self.plan.space.axes_of(lambda key: key.startswith(("arm.", "model.")))

    def small_blocks(self, block: Block) -> Iterator[Block]:
        """Yield the block in pieces, small enough that the arrays of each take little memory."""
        return block.cut(self._axis_to_cut)

    def _axis_to_cut(self, block: Block) -> int | None:
        """Return the axis along which to halve a block; None if the block is small enough.

        The longest axis is halved, but one along which only pretension varies comes last: designs
        that differ in pretension alone share their windows.
        """
        plan = self.plan
        is_compiled = kernel.native() is not None
        states = plan.states_per_design
        lengths = block.shape[:-2]
        all_axes = frozenset(range(len(lengths)))

        # Axes over which values are counted, values at each point of these, and the most values.
        most_states = _STATES_AT_ONCE if is_compiled else 4 * plan.block_states
        rules = [(all_axes, 1, _DESIGNS_AT_ONCE), (all_axes, states, most_states)]
        if is_compiled:
            # The arrays that compiled code is given: of arms at angles, of designs in directions.
            rules.append((self._arm_axes, len(plan.elbow_angles), VALUES_AT_ONCE))
            rules.append((all_axes - self._pretension_axes, 2, VALUES_AT_ONCE))
        if plan.study.trajectory is not None:
            # NumPy works out both directions, and many arrays of each.
            rules.append((all_axes, states, plan.block_states))
        elif plan.of_forms or plan.of_motion or extremes.OVER_STATES:
            # NumPy works out columns from arrays of all states.
            rules.append((all_axes, states, VALUES_AT_ONCE))

        def priority(axis: int) -> tuple[bool, int]:
            return axis not in self._pretension_axes, lengths[axis]

        for axes, values_at_each, most in rules:
            varying = [axis for axis in axes if lengths[axis] > 1]
            values = values_at_each * math.prod(lengths[axis] for axis in varying)
            if varying and values > most:
                return max(varying, key=priority)
        return None

    def designs(self, block: Block) -> dict[str, npt.NDArray[Any]]:
        """Return the columns of `designs` for a small block, and its counts of states.

        Returns:
            Arrays in the shape of the block's design axes, SI: results, windows, judgements as
            truths, and the counts of `extremes.COUNTS`.
        """
        shape = block.shape[:-2]
        design = self.plan.design(block)
        windows = {**self.windows(block, design)}
        required = windows.pop(_REQUIRED, None)
        first = block.first_along(self._limit_axes)
        of_first = design if first.shape == block.shape else self.plan.design(first)
        if required is not None:
            required = required[tuple(slice(length) for length in first.shape[:-2])]
        of_states = self._over_states(first, of_first, required)
        results = {name: np.broadcast_to(values, shape) for name, values in of_states.items()}
        results |= windows
        bounds = self._bounds.of(design)
        of_designs = {name: drop_state_axes(np.asarray(bound)) for name, bound in bounds.items()}
        return results | extremes.judge(results, of_designs)

    def _over_states(self, block: Block, design: Design, required: Array | None) -> Extremes:
        """Return results and counts of designs that follow from their states without any limit.

        Args:
            block: The designs.
            design: The same designs, as the model takes them.
            required: Along a trajectory the least pretension without slack, N; else None.
        """
        plan = self.plan
        folded = extremes.begin(block.shape[:-2])
        trajectory = plan.study.trajectory
        if trajectory is None:
            for stretch in self._stretches(block):
                state = plan.state(stretch, design)
                angles = plan.elbow_angles[stretch.angles]
                kernel.fold_extremes(folded, state, angles, stretch.shape)
            finished = extremes.finish(folded, plan.states_per_design)
            added = self._by_numpy(block, design)
        else:
            moving = plan.moving(block, design)
            kernel.fold_motion(folded, moving)
            counted = trajectory.counted
            finished = extremes.finish(folded, counted.stop - counted.start)
            added = self._of_motion(block, moving)
        if required is not None:  # `fold` has that of the states at the design's own pretension
            change = finished[_REQUIRED] - required
            finished["margin"] = finished["margin"] + change
            finished[_REQUIRED] = required
        results = extremes.as_read(finished, design)
        results |= added
        results |= extremes.of_design(design, folded)
        return results | {name: folded[name] for name in extremes.COUNTS}

    def windows(self, block: Block, design: Design) -> Extremes:
        """Return the windows of a block; designs that differ only in pretension share one.

        Args:
            block: The designs.
            design: The same designs, as the model takes them.

        Returns:
            `pretension_from` and `pretension_to` (N) in the shape of the block's design axes; along
            a trajectory also `required_pretension`, as F0.
        """
        shape = block.shape[:-2]
        if self.known_windows is not None:
            place = tuple(
                slice(0, 1) if axis in self._pretension_axes else part
                for axis, part in enumerate(block.designs)
            )
            columns = {name: values[place] for name, values in self.known_windows.items()}
        else:
            first = block.first_along(self._pretension_axes)
            if first.shape != block.shape:
                design = self.plan.design(first)
            columns = self._windows(first, design)
        return {name: np.broadcast_to(values, shape) for name, values in columns.items()}

    @cached_property
    def known_windows(self) -> Extremes | None:
        """Windows of the whole plan, N; None if no designs share a window or there are too many."""
        plan = self.plan
        (whole,) = plan.blocks(range(plan.designs))
        different = whole.first_along(self._pretension_axes)
        most_states = _MOST_STATES_BEFOREHAND
        if kernel.native() is None:
            most_states //= 16
        if different.design_count == plan.designs:
            return None
        if different.design_count > _MOST_WINDOWS_KEPT:
            return None
        if math.prod(different.shape) > most_states:
            return None
        shape = different.shape[:-2]
        names = ["pretension_from", "pretension_to"]
        if plan.study.trajectory is not None:
            names.append(_REQUIRED)
        columns = {name: np.empty(shape) for name in names}
        for block in self.small_blocks(different):
            for name, values in self._windows(block, plan.design(block)).items():
                columns[name][block.designs] = values
        return columns

    def _windows(self, block: Block, design: Design) -> Extremes:
        """Work out the windows of a block, N; an end that nothing bounds is NaN."""
        bounds = self._bounds
        motion = self.plan.motion(block)
        ends = fold_ends(design, block.shape[:-2], *motion, bounds)
        columns: Extremes = {}
        trajectory = self.plan.study.trajectory
        if trajectory is not None:
            columns[_REQUIRED] = _required_along(cast("Window", ends), design, trajectory)
        elif bounds.asks_power:
            ends = named_ends(ends, design, *motion, bounds)
        high = window.reading_of(ends.high, design)
        columns["pretension_from"] = window.reading_of(ends.low, design)
        columns["pretension_to"] = extremes.nan_where(np.isinf(high), high)
        return columns

    def _stretches(self, block: Block) -> Iterator[Block]:
        """Yield the block cut along its elbow angles; the results do not depend on the cuts."""
        most = VALUES_AT_ONCE if kernel.native() else self.plan.block_states

        def angle_axis(piece: Block) -> int | None:
            return len(piece.shape) - 1 if piece.shape[-1] > most else None

        return block.cut(angle_axis)

    def _by_numpy(self, block: Block, design: Design) -> Extremes:
        """Work out the columns that compiled code does not know.

        These are the extremes of forms, those of `extremes.OVER_STATES`, and those of motion.
        """
        plan = self.plan
        speed = plan.study.motion.speed
        columns: Extremes = {}
        if plan.of_forms or extremes.OVER_STATES:
            state = plan.state(block, design)
            columns |= extremes.of_forms(plan.of_forms, state)
            columns |= extremes.over_states(state, block.shape)
        if speed is not None:
            from tendon_cli.model.motor import (
                cycle_columns,  # only a study of motion pays for its import
            )

            columns |= cycle_columns(design, *plan.motion(block), speed.single)
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in columns.items()}

    def _of_motion(self, block: Block, moving: Moving) -> Extremes:
        """Work out the columns that compiled code does not know, along a trajectory."""
        from tendon_cli.model.moving import motion_columns

        columns: Extremes = motion_columns(moving)
        for state in moving.counted_states:
            for name, values in extremes.of_forms(self.plan.of_forms, state).items():
                worse = np.fmin if LIMITS[name].from_below else np.fmax
                columns[name] = worse(columns[name], values) if name in columns else values
        if extremes.OVER_STATES:
            counted = moving.trajectory.counted
            shape = (*block.shape[:-1], counted.stop - counted.start)
            columns |= extremes.over_states(moving.counted_states[0], shape)
        return {name: np.broadcast_to(values, block.shape[:-2]) for name, values in columns.items()}


def _required_along(along: Window, design: Design, trajectory: Trajectory) -> Array:
    """Return the least F0 that leaves no slack along a trajectory, N.

    Which states count depends on the pretension, so that it is an end of a window, too.

    Args:
        along: Windows of the designs.
        design: The designs.
        trajectory: The motion.
    """
    is_slack = (along.low_by == FLEXOR_SLACK) | (along.low_by == EXTENSOR_SLACK)
    if np.all(is_slack & along.is_open):
        return along.low
    from tendon_cli.model.motion_window import window_along  # only these pay for its import

    slack_alone = Bounds(min_elbow_stiffness=-np.inf)
    return window_along(replace(design, limits={}), trajectory, slack_alone).low


# --- Choices --------------------------------------------------------------------------------------
#
# A choice is a combination of the axes that are not conditions. It is feasible if its designs are
# feasible under all conditions at once, and these may be spread over the whole run. So each part
# notes which of its designs are feasible, one bit for each.


def _choice_axes(plan: Plan) -> list[int]:
    """Return the design axes that are not conditions."""
    return [axis for axis, key in enumerate(plan.study.axes) if key not in plan.study.conditions]


def count_choices(plan: Plan) -> int:
    """Return the number of choices of a study."""
    return math.prod(plan.shape[axis] for axis in _choice_axes(plan))


def encode_feasible(feasible: Flags) -> str:
    """Encode which designs of a part are feasible as the text of its note."""
    return base64.b64encode(zlib.compress(np.packbits(feasible).tobytes(), 6)).decode()


def decode_feasible(note: Any, count: int) -> Flags | None:
    """Decode the note of feasible designs; None if it was not written for `count` designs."""
    size = -(-count // 8)
    try:
        compressed = base64.b64decode(note, validate=True)
        packed = zlib.decompressobj().decompress(compressed, size + 1)
    except (zlib.error, binascii.Error, ValueError, TypeError):
        return None
    if len(packed) != size:
        return None
    return np.unpackbits(np.frombuffer(packed, np.uint8))[:count] > 0


def count_feasible_choices(plan: Plan, notes: Iterable[str]) -> int:
    """Return the number of feasible choices of a run.

    Args:
        plan: The plan of the run.
        notes: Texts by `encode_feasible`, of all parts in their order.

    Raises:
        ValueError: A text was not written for the designs of its part.
    """
    choice_axes = _choice_axes(plan)
    conditions = tuple(set(range(len(plan.shape))) - set(choice_axes))
    is_feasible = np.ones([plan.shape[axis] for axis in choice_axes], np.bool_)
    for index, note in enumerate(notes):
        designs = plan.part(index)
        feasible = decode_feasible(note, len(designs))
        if feasible is None:
            raise ValueError(f"part {index} does not say which designs are feasible")
        for block in plan.blocks(designs):
            start = block.first_design - designs.start
            of_block = feasible[start : start + block.design_count].reshape(block.shape[:-2])
            place = tuple(block.designs[axis] for axis in choice_axes)
            is_feasible[place] &= of_block.all(axis=conditions)
    return int(is_feasible.sum())
