"""Logs of rigs drawn at random, from the physics of a tendon in a bent sheath.

The tendon is an elastic line over the bend. When the motor turns back, a front of slip runs from
the motor's end along the sheath: behind it ln T falls by μ per radian against the motion, before
it every tension is as it was. Once the front is at the load's end the whole tendon slides. The
load is a weight or a spring. A load cell at each end reads with an error of zero and of gain, a
lag, noise that is white and noise that lasts, drift and steps. Nothing here knows how readings are
fitted, and nothing is shared with the other rigs of these tests.

`python -m verification.friction_rigs.random_rigs` fits 100 logs and counts.
"""

from __future__ import annotations

import argparse
import math
import warnings as python_warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

import tendon_cli as tendon
from tendon_cli.errors import TendonError

Floats = npt.NDArray[np.float64]
NODES = 60


@dataclass(frozen=True)
class RandomRig:
    """A bench with its motion and its cells; forces in N, times in s, travels in m."""

    seed: int
    friction: float = 0.1
    bend: float = 2.5
    weight: float = 50.0
    spring: float = 0.0  # growth of the load over a whole stroke, over the weight
    stick: float = 0.2  # share of a whole stroke in which the tendon sticks after a turn
    strokes: int = 10
    seconds: float = 3.0  # of a whole stroke
    rate: float = 50.0  # readings a second
    is_sine: bool = False
    holds: float = 0.0  # longest hold at a turn, over a stroke
    middle_holds: float = 0.0  # share of the strokes with a hold on the way
    partial: float = 0.0  # share of the strokes that turn early
    scatter: float = 0.005  # of the friction from stroke to stroke
    zero: tuple[float, float] = (0.0, 0.0)
    gain: tuple[float, float] = (1.0, 1.0)
    drift: float = 0.0  # of the motor's cell, over the log
    lag: float = 0.0  # of the load's cell, s
    noise: float = 0.001  # of a reading, over the weight
    slow_noise: float = 0.0  # of noise that lasts, over the weight
    lasts: float = 0.3  # time in which its correlation falls to 1/e, s
    step: float = 0.0  # of the converters
    columns: tuple[str, ...] = ("time",)


def motion_of(rig: RandomRig, random: np.random.Generator) -> tuple[Floats, list[float], Floats]:
    """Return the motor's travel over a whole stroke's at each reading, and the friction there."""
    rows = max(int(rig.seconds * rig.rate), 12)
    parts = []
    frictions = []
    places = []
    place = 0.0
    for number in range(rig.strokes):
        goal = 1.0 - number % 2
        if random.random() < rig.partial and 0 < number < rig.strokes - 1:
            goal = abs(1.0 - goal - random.uniform(0.3, 0.9))
        count = max(int(rows * abs(goal - place)), 2)
        share = np.arange(1, count + 1) / count
        if rig.is_sine:
            share = 0.5 - 0.5 * np.cos(np.pi * share)
        stroke = place + (goal - place) * share
        if random.random() < rig.middle_holds:
            at = int(count * random.uniform(0.1, 0.9))
            hold = np.full(int(rows * random.uniform(0.1, 0.5)), stroke[at])
            stroke = np.concatenate([stroke[:at], hold, stroke[at:]])
        hold = np.full(int(rows * random.uniform(0.0, rig.holds)), goal)
        stroke = np.concatenate([stroke, hold])
        parts.append(stroke)
        friction = rig.friction * (1.0 + rig.scatter * random.standard_normal())
        frictions.append(np.full(len(stroke), friction))
        places.append(goal)
        place = goal
    return np.concatenate(parts), places, np.concatenate(frictions)


def forces_of(rig: RandomRig, travel: Floats, friction: Floats) -> tuple[Floats, Floats]:
    """Return the tensions at the motor and at the load, row by row.

    The unit of compliance is such that a whole turn from limit to limit takes `stick` of a stroke:
    by the square of (1 - e^(-μφ)) e^(μφ)/μ.
    """
    angle = np.linspace(0.0, rig.bend, NODES + 1)
    mu = rig.friction
    turn = math.exp(mu * rig.bend) * (1.0 - math.exp(-mu * rig.bend)) ** 2 / mu
    compliance = rig.stick / (turn * rig.weight)  # travel a rad and N
    stiffness = rig.spring * rig.weight  # of the load, N a stroke
    log_tension = np.full(NODES + 1, math.log(rig.weight))
    place = -compliance * rig.weight * rig.bend  # of the load's end
    last = 0.0
    motor = np.empty(len(travel))
    load = np.empty(len(travel))
    for row, position in enumerate(travel):
        way = math.copysign(1.0, position - last) if position != last else 0.0
        if way:
            log_tension, place = _moved(
                log_tension, place, position, way, friction[row], angle, compliance, rig, stiffness
            )
        last = position
        motor[row] = math.exp(log_tension[0])
        load[row] = math.exp(log_tension[-1])
    return motor, load


def _moved(
    log_tension: Floats,
    place: float,
    position: float,
    way: float,
    mu: float,
    angle: Floats,
    compliance: float,
    rig: RandomRig,
    stiffness: float,
) -> tuple[Floats, float]:
    """Return the tensions and the load's place after the motor's end came to a position."""
    tension = np.exp(log_tension)
    steps = np.diff(angle)
    pieces = np.diff(tension) / np.maximum(np.abs(np.diff(log_tension)), 1e-12)
    pieces = np.where(np.abs(np.diff(log_tension)) < 1e-9, tension[1:], np.abs(pieces)) * steps
    beyond = np.append(np.cumsum(pieces[::-1])[::-1], 0.0)
    behind = tension * (np.exp(way * mu * angle) - 1.0) / (way * mu)
    stretch = compliance * (behind + beyond)  # with the front at each node
    wanted = position - place
    order = way * stretch
    if way * wanted <= order[0]:
        return log_tension, place  # the front has not begun
    if way * wanted < order[-1]:
        order = np.maximum.accumulate(order)
        front = float(np.interp(way * wanted, order, angle))
        at_front = float(np.interp(front, angle, log_tension))
        moved = np.where(angle < front, at_front + way * mu * (front - angle), log_tension)
        return moved, place
    shape = compliance * (math.exp(way * mu * rig.bend) - 1.0) / (way * mu)
    start = -compliance * rig.weight * rig.bend
    # position - y = shape (W + k (y - start))
    y = (position - shape * (rig.weight - stiffness * start)) / (1.0 + shape * stiffness)
    y = max(y, place) if way > 0 else min(y, place)
    force = rig.weight + stiffness * (y - start)
    return math.log(force) + way * mu * (rig.bend - angle), y


def readings_of(rig: RandomRig) -> pd.DataFrame:
    """Return the log that the cells of a rig write."""
    random = np.random.default_rng([rig.seed, 35])
    travel, _, friction = motion_of(rig, random)
    motor, load = forces_of(rig, travel, friction)
    rows = len(travel)
    time = np.arange(rows) / rig.rate
    if rig.lag:
        load = np.interp(time - rig.lag, time, load)
    along = np.linspace(0.0, 1.0, rows)
    cells = []
    for number, force in enumerate((motor * (1.0 + rig.drift * along), load)):
        reading = force * rig.gain[number] + rig.zero[number]
        reading = reading + rig.noise * rig.weight * random.standard_normal(rows)
        if rig.slow_noise:
            reading = reading + rig.slow_noise * rig.weight * _lasting(rig, rows, random)
        if rig.step:
            reading = np.round(reading / rig.step) * rig.step
        cells.append(reading)
    table = {"motor (N)": cells[0], "load (N)": cells[1]}
    if "time" in rig.columns:
        table["time (s)"] = time
    if "direction" in rig.columns:
        change = np.sign(np.diff(travel, prepend=0.0))
        names = np.array(["release", "rest", "pull"])
        table["direction"] = names[(change + 1).astype(int)]
    if "position" in rig.columns:
        table["position (mm)"] = np.round(80.0 * travel, 2)
    return pd.DataFrame(table)


def _lasting(rig: RandomRig, rows: int, random: np.random.Generator) -> Floats:
    """Return noise of variance 1 whose correlation falls off within `lasts` (AR(1))."""
    keeps = math.exp(-1.0 / (rig.rate * rig.lasts))
    noise = np.empty(rows)
    last = random.standard_normal()
    shocks = math.sqrt(1.0 - keeps**2) * random.standard_normal(rows)
    for row, shock in enumerate(shocks):
        last = keeps * last + shock
        noise[row] = last
    return noise


def drawn_rig(seed: int) -> RandomRig:
    """Draw a rig, such as a lab may have: most have one or two faults, some have none."""
    random = np.random.default_rng([seed, 3500])

    def has(share: float) -> bool:
        return bool(random.random() < share)

    weight = float(random.choice([10.0, 25.0, 50.0, 100.0]))
    changes: dict[str, Any] = {
        "friction": float(random.uniform(0.04, 0.25)),
        "bend": float(random.uniform(1.2, 4.5)),
        "weight": weight,
        "spring": float(random.uniform(0.1, 2.0)) if has(0.5) else 0.0,
        "stick": float(random.uniform(0.05, 0.5)),
        "strokes": int(random.choice([3, 4, 6, 8, 10, 16, 24])),
        "seconds": float(random.uniform(1.0, 8.0)),
        "rate": float(random.choice([10.0, 20.0, 50.0, 100.0, 200.0])),
        "is_sine": has(0.3),
        "holds": float(random.uniform(0.1, 0.8)) if has(0.4) else 0.0,
        "middle_holds": float(random.uniform(0.2, 1.0)) if has(0.2) else 0.0,
        "partial": float(random.uniform(0.1, 0.6)) if has(0.3) else 0.0,
        "scatter": float(random.uniform(0.0, 0.015)),
        "gain": tuple(float(gain) for gain in random.normal(1.0, 0.01, 2)),
        "noise": float(10.0 ** random.uniform(-4.0, -1.5)),
        "columns": (("time",), ("time", "direction"), ("time", "position"), ())[
            int(random.choice(4, p=[0.5, 0.15, 0.2, 0.15]))
        ],
    }
    if has(0.4):
        zeros = weight * random.normal(0.0, 0.03, 2)
        which = int(random.choice(3))
        changes["zero"] = (
            float(zeros[0]) if which != 1 else 0.0,
            float(zeros[1]) if which != 0 else 0.0,
        )
    if has(0.3):
        changes["slow_noise"] = float(10.0 ** random.uniform(-3.0, -1.7))
        changes["lasts"] = float(10.0 ** random.uniform(-1.5, 0.5))
    if has(0.15):
        changes["drift"] = float(random.normal(0.0, 0.02))
    if has(0.15):
        changes["lag"] = float(random.uniform(0.0, 0.15))
    if has(0.5):
        changes["step"] = float(weight * 10.0 ** random.uniform(-4.0, -2.0))
    return RandomRig(seed, **changes)


@dataclass(frozen=True)
class Outcome:
    """A fit beside the truth."""

    rig: RandomRig
    refused: str
    error: float
    """Error of μ, as a share of the truth."""
    half: float
    """Half-width of its interval, as a share of the truth."""
    warnings: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def ratio(self) -> float:
        """Error over the half-width."""
        return abs(self.error) / self.half

    @property
    def is_silent(self) -> bool:
        """True if the truth is outside of the interval and nothing warns."""
        return not self.refused and not self.warnings and self.ratio > 1.0

    @property
    def hides(self) -> bool:
        """True if a note puts a number to a zero error that no reading can show."""
        has_note = any("a zero error of" in note for note in self.notes)
        return has_note and any(self.rig.zero)


def outcome_of(rig: RandomRig) -> Outcome:
    """Fit the log of a rig."""
    readings = readings_of(rig)
    try:
        with python_warnings.catch_warnings():
            python_warnings.simplefilter("error")
            fit = tendon.fit_friction(readings, rig.bend)
    except TendonError as error:
        return Outcome(rig, error.message, 0.0, 1.0, (), ())
    low, high = fit.interval_95
    return Outcome(
        rig,
        "",
        fit.friction / rig.friction - 1.0,
        (high - low) / 2.0 / rig.friction,
        fit.warnings,
        fit.notes,
    )


def outcomes(seeds: Iterable[int]) -> list[Outcome]:
    """Fit the logs of rigs drawn with these seeds."""
    return [outcome_of(drawn_rig(seed)) for seed in seeds]


def main() -> None:
    parser = argparse.ArgumentParser(description="fit logs of rigs drawn at random and count")
    parser.add_argument("--logs", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    ends = outcomes(range(options.first, options.first + options.logs))
    fits = [end for end in ends if not end.refused]
    quiet = [end for end in fits if not end.warnings]
    silent = sorted((end for end in fits if end.is_silent), key=lambda end: -end.ratio)
    for end in silent:
        noted = ", noted" if end.hides else ""
        print(f"seed {end.rig.seed}: {end.ratio:.1f} half-widths off{noted}; {end.rig}")
    refused = len(ends) - len(fits)
    print(f"{len(ends)} logs, {refused} refused, {len(fits) - len(quiet)} warned")
    told = [end for end in silent if not end.hides]
    print(f"silently wrong: {len(silent)}, of them {len(silent) - len(told)} with a note on zeros")
    print(f"by over two half-widths without the note: {sum(end.ratio > 2.0 for end in told)}")
    print(f"median half-width: {100.0 * np.median([end.half for end in quiet]):.2f} % of μ")


if __name__ == "__main__":
    main()
