"""A rig simulated element by element, which knows nothing of the formula that is fitted.

The tendon is a chain of springs; between two springs it touches a piece of sheath that turns by a
small angle. A piece carries the normal force (mean of the tensions on both sides) x (its angle) and
holds the tendon with at most μ times that: it sticks until the difference of the two tensions
reaches the limit, then slips. The motor end is moved step by step, a weight (and, if wanted, a
spring) hangs on the other end, and after each step the pieces are let go one after the other, from
the motor on, until one holds. Nowhere does an exponential of μφ appear.

All seeds are moved at once: arrays have the shape (seeds, pieces).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .cells import RATE, Cells, Floats


@dataclass(frozen=True)
class Rig:
    """Properties that all seeds share. Forces are in kg, or in any one unit."""

    friction: float

    bend_angle: float = float(np.deg2rad(144.0))

    pieces: int = 32

    strokes: int = 12

    rows_per_stroke: int = 150

    rows_at_rest: int = 40

    friction_scatter: float = 0.015
    """Relative, from stroke to stroke (dirt, lubricant, a spot of wear)."""

    gain_scatter: float = 5e-4
    """Standard deviation of the log gain from stroke to stroke."""

    gain_mismatch: float = 0.02
    """Largest log ratio of the two cells' gains."""

    noise: float = 0.0015
    """Noise of each reading, kg."""

    resolution: float = 0.001
    """Step of the readings, kg; 0 for none."""

    load_spring: float = 0.0
    """Share by which the load grows over one stroke, from a spring at the load."""

    sticking: tuple[float, float] = (0.1, 0.4)
    """Least and largest share of a stroke that a whole reversal takes."""

    sinusoidal: bool = False
    """True if the motor swings like a crank instead of moving at a steady speed."""

    offsets: tuple[float, float] = (0.0, 0.0)
    """Readings of the unloaded cells, kg."""

    weights: tuple[float, float] = (0.8, 2.0)
    """Lightest and heaviest, kg."""

    relative_noise: float = 0.0
    """Noise of each reading over its force, beside `noise`."""

    correlation: float = 0.0
    """Correlation of the noise of two successive rows."""

    delay: float = 0.0
    """Rows by which the load's cell is late."""

    saturation: float = np.inf
    """Largest reading, as a multiple of the weight."""

    dwell: int = 0
    """Rows at rest in the middle of every stroke and at its end."""

    friction_drift: float = 0.0
    """Relative change of the friction from the first row to the last."""

    gain_drift: float = 0.0
    """Change of the log gain of the motor's cell from the first row to the last."""


@dataclass(frozen=True)
class Logs:
    """Readings of all seeds, shape (rows, seeds), and what truly happened."""

    motor_cell: Floats
    load_cell: Floats
    slipping: npt.NDArray[np.bool_]
    """True where the whole tendon slipped in this row."""
    toward: Floats
    """Direction of the motor in each row: +1 pulling, -1 letting go, 0 at rest; shape (rows,)."""


class Tendon:
    """Tensions and places of the chain of every seed."""

    def __init__(self, weight: Floats, angles: Floats, stiffness: Floats, spring: Floats) -> None:
        seeds, pieces = angles.shape
        self.weight = weight
        self.angles = angles
        self.stiffness = stiffness
        self.spring = spring
        self.tension = np.repeat(weight[:, None], pieces + 1, axis=1)
        self.motor = np.zeros(seeds)
        self.place = self.motor[:, None] - np.cumsum(self.tension, axis=1) / stiffness[:, None]
        self.start = self.place[:, -1].copy()

    def log_limits(self, friction: Floats) -> Floats:
        """Log of the largest ratio of tensions over each piece: |T1 - T2| = μ Δφ (T1 + T2)/2."""
        half = friction[:, None] * self.angles / 2.0
        return np.log((1.0 + half) / (1.0 - half))

    def move(self, step: Floats, direction: float, friction: Floats) -> npt.NDArray[np.bool_]:
        """Move the motor by `step` times `direction`. Return True where all pieces slipped."""
        seeds, pieces = self.angles.shape
        self.motor = self.motor + direction * step
        limits = self.log_limits(friction)
        log_to_piece = np.concatenate([np.zeros((seeds, 1)), np.cumsum(limits, axis=1)], axis=1)
        log_sum = direction * log_to_piece
        # With the first m pieces slipping, the tensions up to segment m are shares of the tension
        # in segment m.
        share = np.exp(log_sum) * np.cumsum(np.exp(-log_sum), axis=1)
        trial = self.stiffness[:, None] * (self.motor[:, None] - self.place[:, :-1]) / share[:, :-1]
        log_ratio = direction * np.log(np.maximum(trial, 1e-300) / self.tension[:, 1:])
        holds = log_ratio <= limits
        all_slip = ~holds.any(axis=1)
        front = np.where(all_slip, pieces, holds.argmax(axis=1))
        rows = np.arange(seeds)

        stretch = share[:, -1] / self.stiffness
        load = self.weight + self.spring * (self.motor - self.start)
        tension_at_end = load / (1.0 + self.spring * stretch)
        trial_at_front = trial[rows, np.minimum(front, pieces - 1)]
        tension_at_front = np.where(all_slip, tension_at_end, trial_at_front)
        slipped = tension_at_front[:, None] * np.exp(log_sum[rows, front][:, None] - log_sum)
        segments = np.arange(pieces + 1)
        is_moved = segments <= front[:, None]
        self.tension = np.where(is_moved, slipped, self.tension)

        # The far end of segment m is the piece that holds, so it stays; the last segment ends at
        # the load.
        place = self.motor[:, None] - np.cumsum(self.tension, axis=1) / self.stiffness[:, None]
        is_before_front = segments < front[:, None]
        moves = is_moved & (is_before_front | all_slip[:, None])
        self.place = np.where(moves, place, self.place)
        return all_slip


def motion_of(rig: Rig) -> tuple[Floats, Floats]:
    """Return the motor's direction in each row, and its speed over the mean speed of a stroke.

    The direction is +1 or -1, and 0 at rest.
    """
    along = (np.arange(rig.rows_per_stroke) + 0.5) / rig.rows_per_stroke
    swing = np.sin(np.pi * along) * np.pi / 2.0
    speed = swing if rig.sinusoidal else np.ones(len(along))
    half = len(along) // 2
    rest = np.zeros(rig.dwell)
    stroke = np.concatenate([speed[:half], rest, speed[half:], rest])
    strokes = [stroke * (1.0 if number % 2 == 0 else -1.0) for number in range(rig.strokes)]
    motion = np.concatenate([np.zeros(rig.rows_at_rest), *strokes])
    return np.sign(motion), np.abs(motion)


def simulate(rig: Rig, seeds: int, first_seed: int = 0) -> Logs:
    """Simulate the logs of as many rigs as there are seeds.

    They differ in weight, stiffness, curvature along the sheath, gains and noise.
    """
    random = np.random.default_rng([first_seed, round(rig.friction * 1e6)])
    weight = random.uniform(*rig.weights, seeds)
    angles = random.uniform(0.5, 1.5, (seeds, rig.pieces))
    angles *= rig.bend_angle / angles.sum(axis=1, keepdims=True)
    stiffness = np.full(seeds, 1000.0)
    tendon = Tendon(weight, angles, stiffness, np.zeros(seeds))
    half = np.cumsum(tendon.log_limits(np.full(seeds, rig.friction))[:, ::-1], axis=1)
    transit = (weight[:, None] * 2.0 * np.sinh(half)).sum(axis=1) / stiffness
    step = transit / random.uniform(*rig.sticking, seeds) / rig.rows_per_stroke
    tendon.spring = rig.load_spring * weight / (step * rig.rows_per_stroke)
    log_gain = random.uniform(-rig.gain_mismatch, rig.gain_mismatch, seeds)

    directions, speeds = motion_of(rig)
    rows = len(directions)
    along = np.linspace(-0.5, 0.5, rows)
    motor = np.empty((rows, seeds))
    load = np.empty((rows, seeds))
    slipping = np.zeros((rows, seeds), dtype=bool)
    scatter = np.ones(seeds)
    gain = log_gain
    previous = 0.0
    for row, direction in enumerate(directions):
        if direction not in {0.0, previous}:
            scatter = 1.0 + rig.friction_scatter * random.standard_normal(seeds)
            gain = log_gain + rig.gain_scatter * random.standard_normal(seeds)
            previous = direction
        friction = rig.friction * scatter * (1.0 + rig.friction_drift * along[row])
        if direction != 0.0:
            slipping[row] = tendon.move(step * speeds[row], direction, friction)
        motor[row] = tendon.tension[:, 0] * np.exp(gain + rig.gain_drift * along[row])
        load[row] = tendon.tension[:, -1]

    cells = Cells(
        rig.noise,
        rig.relative_noise,
        rig.correlation,
        zero=rig.offsets,
        delay=rig.delay / RATE,
        step=rig.resolution,
        most=rig.saturation * weight,
        spikes=None,
    )
    motor_cell, load_cell = cells.read(motor, load, random)
    return Logs(motor_cell, load_cell, slipping, directions)
