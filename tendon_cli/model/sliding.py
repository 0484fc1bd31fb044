"""The way in which tendons slide along a motion in time, and where they turn.

Friction goes with the sliding, not with the joint: where inertia or a task over time wins over the
stiffness of the elbow, the spool turns against the joint. Both tendons slide as the spool turns,
which is the sign of the mean of the spool angles that both directions of friction would need. A
turn of the spool is one if it has come back by half its play, and counts from the extreme.

While the tendons turn, part of each sheath still holds the tension of the way before: torque and
tensions then lie between those of both directions, and no more is known. Arrays here are (designs,
samples) in the order of time; SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.statics import BOTH_SLACK, EXTENSOR_SLACK, FLEXOR_SLACK, Status
from tendon_cli.model.trajectory import lasting_signs

BOTH_DIRECTIONS = np.array([[True], [False]])
"""Directions in which tendons may slide: as in flexion, then as in extension."""
_TURNS_AFTER = 0.5
"""Share of the play by which the spool comes back in a turn."""
_FOLLOWS_AFTER = 1.5
"""Multiple of the play from where the spool stood in the old direction, after which both tendons
surely slide in the new one. With 1.25 one motion in 480 was off by over 2 % of its peak torque."""
_PAST = 0.5
"""Share of the play by which the spool must be past where it was before a way back."""
_BEHIND = 1e-4
"""Share of the play by which a spool is behind where it was: the change of the torque grows with
its root, so that this is 1 % of what a whole turn changes."""
_AT_REST = 1e-6
"""Share of a tendon's largest speed below which its end rests: the tail of a low-pass rings on."""


@dataclass(frozen=True, eq=False)
class Sliding:
    """Way in which the tendons of designs slide at the samples of a motion, (..., 1, K) each."""

    flexion: Flags
    """True where they slide as in flexion: the flexor toward the motor."""
    turning: Flags
    """True where they turn, or slack passes from one side to the other."""
    passing: Flags
    """True where slack passes from one side to the other: the spool has no speed there."""
    other_torque: Array
    """Torque of the motor if the tendons slid the other way, N m."""
    turn_loss: Array
    """Energy that friction takes in the turn that begins at a sample, J; 0 at most samples."""

    @property
    def torque_while_turning(self) -> Array:
        """Torque of the motor in the other direction where the tendons turn, else NaN, N m."""
        return np.where(self.turning, self.other_torque, np.nan)

    def within(self, samples: slice) -> Sliding:
        """Return the same at some samples alone."""
        return Sliding(**{name: values[..., samples] for name, values in vars(self).items()})


class Turns(NamedTuple):
    """Turns of the spool of designs, (turns,) each."""

    design: Rows
    """Design that turns."""
    sample: Rows
    """Sample at which it stands furthest in the old direction."""
    to_flexion: Flags
    """True if it turns to flexion."""
    play: Array
    """Rotation that the later tendon needs to follow, rad."""


def spool_turns(spool_angle: Array, play: Callable[[Rows, Rows], Array]) -> tuple[Flags, Turns]:
    """Return the direction in which the spool turns, and its turns.

    A turn is one if the spool has come back by half the play, and counts from the extreme. Before
    the first turn the direction is that of the first motion.

    Args:
        spool_angle: Mean of the spool angles of both directions, (N, K), rad; NaN where the spool
            is free, and stays.
        play: Returns the play at designs and samples of any shape, rad.

    Returns:
        True where the spool turns as in flexion, (N, K); and the turns.
    """
    angle = _held(spool_angle)
    steps = lasting_signs(np.diff(angle, axis=1))  # (N, K - 1)
    first = steps[:, 0] > 0
    designs, samples = np.nonzero(steps[:, 1:] != steps[:, :-1])
    samples += 1
    turns = _confirmed(angle, first, designs, samples, play)
    starts = np.zeros(angle.shape, dtype=np.bool_)
    starts[turns.design, turns.sample] = True
    direction = np.logical_xor.accumulate(starts, axis=1) ^ first[:, np.newaxis]
    return direction, turns


def _held(angle: Array) -> Array:
    """Return angles, (N, K), with the last one before it in place of each NaN."""
    is_free = np.isnan(angle)
    if not is_free.any():
        return angle
    places = np.where(is_free, 0, np.arange(angle.shape[1]))
    last = np.maximum.accumulate(places, axis=1)
    held = np.take_along_axis(angle, last, axis=1)
    return np.nan_to_num(held)


def _confirmed(
    angle: Array,
    first: Flags,
    designs: Rows,
    samples: Rows,
    play: Callable[[Rows, Rows], Array],
) -> Turns:
    """Return the turns among all extremes of the spool angle.

    Args:
        angle: Spool angles, (N, K), rad.
        first: True where the first motion is as in flexion, (N,).
        designs: Designs of all extremes, ascending, (extremes,).
        samples: Samples of all extremes, ascending for each design, (extremes,).
        play: Returns the play at designs and samples, rad.
    """
    count = angle.shape[0]
    last = angle.shape[1] - 1
    rows = np.arange(count)
    number = np.bincount(designs, minlength=count)
    rank = np.arange(len(designs)) - np.repeat(np.cumsum(number) - number, number)
    # Extremes of each design in turn, then the last sample: (1 + most extremes, N).
    place = np.full((1 + int(number.max(initial=0)), count), last)
    place[rank, designs] = samples
    values = np.take_along_axis(angle.T, place, axis=0)
    widths = play(np.broadcast_to(rows, place.shape), place)
    direction = np.where(first, 1.0, -1.0)
    sample = np.zeros(count, dtype=np.int64)  # of the furthest angle so far
    furthest = angle[:, 0]
    width = play(rows, sample)
    found = []
    for extreme, value, of_extreme in zip(place, values, widths, strict=True):
        back = direction * (furthest - value)
        turns = back > _TURNS_AFTER * width
        found.append((rows[turns], sample[turns], direction[turns] < 0.0, width[turns]))
        direction = np.where(turns, -direction, direction)
        moves = turns | (back <= 0.0)
        furthest = np.where(moves, value, furthest)
        sample = np.where(moves, extreme, sample)
        width = np.where(moves, of_extreme, width)
    return Turns(*(np.concatenate(values) for values in zip(*found, strict=True)))


def in_play(spool_angle: Array, flexion: Flags, turns: Turns, start: Array) -> Flags:
    """Return where the spool has not turned far enough after a turn for all to slide, (N, K).

    Args:
        spool_angle: Spool angle of the direction that holds, (N, K), rad.
        flexion: That direction, True for flexion, (N, K).
        turns: The turns.
        start: Angle at which the spool stood in the old direction, (turns,), rad.
    """
    if not len(turns.design):
        return np.zeros(flexion.shape, dtype=np.bool_)
    samples = np.arange(flexion.shape[1])
    forward = np.where(turns.to_flexion, 1.0, -1.0)
    latest = _latest(turns, flexion.shape)
    aim = np.full(flexion.shape, -np.inf)
    aim[turns.design, turns.sample] = forward * start + _FOLLOWS_AFTER * turns.play
    turned = np.where(flexion, spool_angle, -spool_angle)
    follows = turned >= np.take_along_axis(aim, latest, axis=1)
    last = np.maximum.accumulate(np.where(follows, samples, -1), axis=1)
    return np.asarray(last < latest)


def not_past(
    spool_angle: Array, flexion: Flags, turns: Turns, goes_back: Flags, play: Array
) -> Flags:
    """Return where the spool is not past where it was before a way back, by half a play, (N, K).

    After a way back that is too short for a turn, and at rest there, part of the sheath still holds
    the tension of that way.

    Args:
        spool_angle: Spool angle of the direction that holds, (N, K), rad.
        flexion: That direction, True for flexion, (N, K).
        turns: The turns.
        goes_back: True where an end of a tendon slides against the direction, (N, K).
        play: Play of each spool, (N,), rad.
    """
    samples = np.arange(flexion.shape[1])
    turned = np.where(flexion, spool_angle, -spool_angle)
    # Each stretch of one direction is lifted above those before.
    known = np.where(np.isnan(turned), np.nanmin(turned), turned)
    lift = 2.0 * np.ptp(known, axis=1, keepdims=True) + 1.0
    stretch = np.cumsum(_latest(turns, flexion.shape) == samples, axis=1)
    raised = known + lift * stretch
    furthest = np.maximum.accumulate(raised, axis=1)
    is_behind = furthest - raised > _BEHIND * play[:, np.newaxis]
    event = np.maximum.accumulate(np.where(is_behind | goes_back, samples, -1), axis=1)
    before = np.take_along_axis(furthest, np.maximum(event, 0), axis=1)
    is_short = furthest < before + _PAST * play[:, np.newaxis]
    return np.asarray(is_behind | (is_short & (event >= 0)))


def _latest(turns: Turns, shape: tuple[int, ...]) -> Rows:
    """Return the sample of the latest turn at each sample, (N, K); 0 before the first."""
    latest = np.zeros(shape, dtype=np.int64)
    latest[turns.design, turns.sample] = turns.sample
    return np.asarray(np.maximum.accumulate(latest, axis=1, out=latest))


def against(speeds: list[tuple[Array, Flags]], flexion: Flags) -> Flags:
    """Return where an end of a tendon slides against the direction, one sample either side, (N, K).

    Args:
        speeds: Speed of each end as in flexion, (N, K), m/s, and True where the tendon pulls.
        flexion: Direction that holds, True for flexion, (N, K).
    """
    is_against = np.zeros(flexion.shape, dtype=np.bool_)
    for speed, pulls in speeds:
        with np.errstate(invalid="ignore"):
            fastest = np.fmax.reduce(np.abs(speed), axis=1, keepdims=True)
            forward = np.where(flexion, speed, -speed)
            is_against |= (forward < -_AT_REST * fastest) & pulls
    return with_neighbours(is_against)


def with_neighbours(flags: Flags) -> Flags:
    """Return flags with those of the samples before and after each, (..., K)."""
    widened = flags.copy()
    widened[..., 1:] |= flags[..., :-1]
    widened[..., :-1] |= flags[..., 1:]
    return widened


def slack_passes(status: Status) -> Flags:
    """Return samples between which slack passes from one side to the other, (N, K).

    Args:
        status: Status of the states, (N, K).
    """
    passes = np.zeros(status.shape, dtype=np.bool_)
    flexor = (status == FLEXOR_SLACK) | (status == BOTH_SLACK)
    extensor = (status == EXTENSOR_SLACK) | (status == BOTH_SLACK)
    if not (flexor.any() and extensor.any()):
        return passes
    between = (flexor[:, 1:] & extensor[:, :-1]) | (extensor[:, 1:] & flexor[:, :-1])
    passes[:, 1:] |= between
    passes[:, :-1] |= between
    return np.asarray(passes | (status == BOTH_SLACK))
