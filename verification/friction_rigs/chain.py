"""A second rig for the friction fit: a tendon as a chain of elastic links with friction.

It does to the tendon what labs do to it. The chain is massless and elastic. Link i turns by φ_i in
its sheath, and ln T may differ across it by m_i = μ φ_i at most: what lies between is elastic
history. The motor's end is moved; the load's end hangs from a weight, a spring, a band or a person.
Nothing here knows how readings are fitted. `python -m verification.friction_rigs.chain` fits every
kind of log.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

import tendon_cli as tendon
from tendon_cli.errors import TendonError

from .cells import RATE, Cells, Floats

LINKS = 12
CELLS = Cells()


@dataclass(frozen=True)
class Rig:
    """The bench, before anyone reads a cell."""

    friction: float = 0.1
    bend: float = 2.5
    load: str = "weight"  # or "spring", "band", "person"
    force: float = 60.0  # the weight, the spring's preload, or the person's mean pull, N
    stiffness: float = 400.0  # of the spring at the load, N/m
    tendon: float = 4e4  # stiffness of the whole tendon, N/m
    drive: str = "triangle"  # or "sine", "rests", "steps", "hand"
    travel: float = 0.08
    strokes: int = 12
    seconds: float = 4.0  # of a stroke
    law: str = "coulomb"  # or "dahl", "stribeck", "ageing"
    entry: float = 0.0  # friction outside of the bend, as a share of μφ at a bend of 2.4 rad
    bends: tuple[float, ...] = ()  # of the several runs of one log; empty: one bend

    @property
    def has_elastic_load(self) -> bool:
        """True if the load's end follows a spring or a band, not a weight or a person."""
        return self.load in ("spring", "band")


@dataclass(frozen=True)
class Kind:
    """A rig, its cells, the columns of its log, and whether any reading of it can tell μ."""

    name: str
    rig: Rig
    cells: Cells = CELLS
    columns: tuple[str, ...] = ("time",)
    tells: bool = True
    expects: str = ""
    """A word of the warning that a user needs; empty where none is due."""


def drive(rig: Rig, random: np.random.Generator) -> Floats:
    """Return the position of the motor's end at each reading, m."""
    rows = int(rig.seconds * RATE)
    ramp = np.linspace(0.0, 1.0, rows, endpoint=False)
    strokes: list[Floats] = []
    for number in range(rig.strokes):
        is_up = number % 2 == 0
        stroke = ramp if is_up else 1.0 - ramp
        if rig.drive == "sine":
            stroke = 0.5 - 0.5 * np.cos(np.pi * stroke)
        elif rig.drive == "rests":
            rest = np.full(int(rows * random.uniform(0.1, 0.5)), stroke[-1])
            stroke = np.concatenate([stroke, rest])
        elif rig.drive == "steps":
            stroke = np.round(stroke * 8) / 8
        elif rig.drive == "hand":
            knots = np.sort(random.uniform(0.0, 1.0, 4))
            times = np.linspace(0, 1, rows)
            progress = np.interp(times, np.linspace(0, 1, 6), [0.0, *knots, 1.0])
            stroke = progress if is_up else 1.0 - progress
        strokes.append(stroke)
    return rig.travel * np.concatenate(strokes)


def pulled(rig: Rig, count: int, random: np.random.Generator) -> Floats:
    """Return the pull on the load's end, if it does not depend on where this is, N."""
    time = np.arange(count) / RATE
    if rig.load != "person":
        return np.full(count, rig.force)
    phases = random.uniform(0, 6, 3)
    waves = zip((0.05, 0.11, 0.23), phases, strict=True)
    slow = sum(np.sin(2 * np.pi * time * frequency + phase) for frequency, phase in waves)
    tremor = 0.01 * np.sin(2 * np.pi * 8.0 * time)
    return rig.force * (1.0 + 0.2 * np.asarray(slow) / 3 + tremor)


def limits_of(rig: Rig, speed: Floats, rest: Floats) -> Floats:
    """Return Σ m over the sheath at each reading, by the law of friction, without the entry."""
    whole = np.full(len(speed), rig.friction * rig.bend)
    if rig.law == "stribeck":
        whole *= 1.0 + 0.15 * np.exp(-np.abs(speed) / 0.004)
    elif rig.law == "ageing":
        whole *= 1.0 + 0.03 * np.log1p(rest / 0.5)
    return whole


def tensions(rigs: list[Rig], randoms: list[np.random.Generator]) -> tuple[Floats, Floats, Floats]:
    """Return tension at the motor and at the load, N, and the position of the motor's end, m.

    All have the shape (rigs of one kind, readings).
    """
    drives = [drive(rig, random) for rig, random in zip(rigs, randoms, strict=True)]
    count = min(map(len, drives))
    position = np.array([driven[:count] for driven in drives])
    speed = np.gradient(position, axis=1) * RATE
    rest = np.array([_resting(speed_of_rig) for speed_of_rig in speed])
    pull = np.array([pulled(rig, count, random) for rig, random in zip(rigs, randoms, strict=True)])
    whole = np.array([limits_of(*of_rig) for of_rig in zip(rigs, speed, rest, strict=True)])
    shares = np.array([random.uniform(0.5, 1.5, LINKS) for random in randoms])
    shares /= shares.sum(axis=1, keepdims=True)
    shares[:, 0] += np.array([rig.entry * 2.4 / rig.bend for rig in rigs])  # the same at every bend
    chain = Chain.of(rigs)
    motor = np.empty_like(position)
    load = np.empty_like(position)
    for row in range(count):
        chain.move(whole[:, row, np.newaxis] * shares, position[:, row], pull[:, row])
        motor[:, row] = np.exp(chain.log[0])
        load[:, row] = np.exp(chain.log[-1])
    return motor, load, position


def _resting(speed: Floats) -> Floats:
    """Return how long the motor's end has been at rest, s; the memory fades once it moves."""
    rest = 0.0
    rests = np.empty(len(speed))
    for row, value in enumerate(speed):
        rests[row] = rest
        is_at_rest = abs(value) < 1e-6
        rest = rest + 1 / RATE if is_at_rest else rest * 0.8
    return rests


@dataclass
class Chain:
    """Chains of one kind: ln T at each of their nodes, (nodes, chains), and their load's ends."""

    kind: Rig
    force: Floats
    log: Floats
    end: Floats

    @classmethod
    def of(cls, rigs: list[Rig]) -> Chain:
        """Return chains at rest, with one tension everywhere and the motor's end at 0."""
        force = np.array([rig.force for rig in rigs])
        chain = cls(rigs[0], force, np.tile(np.log(force), (LINKS + 1, 1)), np.zeros(len(rigs)))
        if not chain.kind.has_elastic_load:
            chain.end = -chain.stretch(chain.log)
        return chain

    def stretch(self, log: Floats) -> Floats:
        """Return how much longer the tendon is than without tension, m."""
        return np.asarray(np.exp(log).mean(axis=0) / self.kind.tendon)

    def played(self, first: Floats, m: Floats) -> Floats:
        """Return ln T along the chain for one at the motor: each link plays within its limit."""
        log = np.empty_like(self.log)
        log[0] = first
        for i in range(1, len(log)):
            limit = m[:, i - 1]
            if self.kind.law == "dahl":
                change = log[i - 1] - self.log[i - 1]
                goal = -np.sign(change) * limit
                difference = self.log[i] - self.log[i - 1]
                fade = np.exp(-3.0 * np.abs(change) / limit)
                log[i] = log[i - 1] + goal + (difference - goal) * fade
            else:
                log[i] = _within(self.log[i], log[i - 1], limit)
        return log

    def end_at(self, log: Floats) -> Floats:
        """Return the position of the load's end at these tensions, m.

        The end of a weight or a person stays where it was.
        """
        tension = np.exp(log[-1])
        if self.kind.load == "spring":
            return np.asarray((tension - self.force) / self.kind.stiffness)
        if self.kind.load == "band":
            return np.asarray(0.05 * np.log(tension / self.force))
        return self.end

    def move(self, m: Floats, x: Floats, pull: Floats) -> None:
        """Move the motor's end to x; a weight or a person pulls the load's end with `pull`."""
        low = self.log[0] - 0.8
        high = self.log[0] + 0.8
        for _ in range(30):
            middle = 0.5 * (low + high)
            log = self.played(middle, m)
            is_short = self.end_at(log) + self.stretch(log) < x
            low = np.where(is_short, middle, low)
            high = np.where(is_short, high, middle)
        middle = 0.5 * (low + high)
        log = self.played(middle, m)
        if self.kind.has_elastic_load:
            self.end = self.end_at(log)
        else:
            # The load's end moves until its tension is the pull.
            log[-1] = np.log(pull)
            for i in range(LINKS - 1, -1, -1):
                log[i] = _within(log[i], log[i + 1], m[:, i])
            has_slipped = np.abs(log[0] - middle) > 1e-7
            self.end = np.where(has_slipped, x - self.stretch(log), self.end)
        self.log = log


def _within(log: Floats, neighbour: Floats, limit: Floats) -> Floats:
    """Return ln T, moved as little as brings it within a limit of the next node's."""
    return np.minimum(np.maximum(log, neighbour - limit), neighbour + limit)


def logs(kind: Kind, seeds: int, first: int = 0) -> list[tuple[dict[str, Floats], float]]:
    """Return the columns of each log of a kind, and the μ that made it."""
    randoms = [
        np.random.default_rng([seed, *kind.name.encode()]) for seed in range(first, first + seeds)
    ]
    rigs = [_varied(kind.rig, random) for random in randoms]
    bends = kind.rig.bends or (kind.rig.bend,)
    runs = [tensions([replace(rig, bend=bend) for rig in rigs], randoms) for bend in bends]
    motor, load, position = (np.concatenate(parts, axis=1) for parts in zip(*runs, strict=True))
    rows_of_runs = [run[0].shape[1] for run in runs]
    bend_angle = np.repeat(bends, rows_of_runs)
    result = []
    for number, (rig, random) in enumerate(zip(rigs, randoms, strict=True)):
        motor_cell, load_cell = kind.cells.read(motor[number], load[number], random)
        moved = position[number]
        columns = {
            "time": np.arange(len(moved)) / RATE,
            "position": moved + 2e-5 * random.normal(size=len(moved)),
            "bend_angle_rad": bend_angle,
            "direction": np.sign(np.gradient(moved)),
            "motor": motor_cell,
            "load": load_cell,
        }
        names = (*kind.columns, "motor", "load")
        result.append(({name: columns[name] for name in names}, rig.friction))
    return result


def _varied(rig: Rig, random: np.random.Generator) -> Rig:
    """Return a rig with friction and force of its own."""
    friction = rig.friction * random.uniform(0.6, 1.6)
    force = rig.force * random.uniform(0.7, 1.4)
    return replace(rig, friction=friction, force=force)


SOFT = 8e3
PULLEY = Rig(tendon=SOFT, travel=0.05)
SPRING = replace(PULLEY, load="spring", force=30.0, stiffness=900.0)
SPRING_BY_SINE = replace(SPRING, drive="sine")
BAND = replace(PULLEY, load="band", force=30.0)
PERSON = replace(PULLEY, load="person", drive="hand")
WITH_POSITION = ("time", "position")
WITH_BEND = ("time", "bend_angle_rad")
WITH_DIRECTION = ("time", "direction")
BENDS = (1.2, 2.4, 3.6)
ZERO = (0.8, -0.5)
GAINS = (1.04, 0.99)


def _driven() -> Iterator[Kind]:
    """Yield every load with every drive."""
    rigs = {"weight": PULLEY, "spring": SPRING, "band": BAND, "person": PERSON}
    for name, rig in rigs.items():
        for name_of_drive in ("triangle", "sine", "rests", "hand", "steps"):
            yield Kind(f"{name}, {name_of_drive}", replace(rig, drive=name_of_drive))


def _mechanics() -> Iterator[Kind]:
    """Yield other columns, lengths, stiffnesses and laws of friction."""
    weight_with_rests = replace(PULLEY, drive="rests")
    spring_with_rests = replace(SPRING, drive="rests")
    yield Kind("weight, with position", weight_with_rests, columns=WITH_POSITION)
    yield Kind("spring, with position", spring_with_rests, columns=WITH_POSITION)
    yield Kind("spring, with direction", SPRING_BY_SINE, columns=WITH_DIRECTION)
    yield Kind("two strokes", replace(SPRING, strokes=2), expects="stroke")
    yield Kind("four strokes", replace(PULLEY, strokes=4))
    yield Kind("forty strokes", replace(PULLEY, strokes=40, seconds=1.5))
    yield Kind("little friction", replace(SPRING, friction=0.03))
    yield Kind("much friction", replace(SPRING, friction=0.3))
    yield Kind("stiff tendon", replace(SPRING, tendon=1e5))
    yield Kind("very soft tendon", replace(SPRING, tendon=2e3, travel=0.12))
    yield Kind("dahl", replace(SPRING, law="dahl"))
    yield Kind("dahl, weight", replace(PULLEY, law="dahl"))
    yield Kind("stribeck", replace(SPRING, law="stribeck", drive="triangle"))
    yield Kind("ageing", replace(PULLEY, law="ageing", drive="rests"))
    yield Kind("entry, one bend", replace(SPRING, entry=0.15), tells=False)
    several_bends = replace(SPRING, entry=0.15, bends=BENDS, strokes=6)
    yield Kind("entry, three bends", several_bends, columns=WITH_BEND, expects="bend")


def _sensors() -> Iterator[Kind]:
    """Yield faults of the cells and of the logger."""
    yield Kind("noise", SPRING, Cells(noise=0.6))
    yield Kind("correlated noise", SPRING, Cells(slow_noise=0.4))
    yield Kind("hum", SPRING, Cells(hum=0.4))
    yield Kind("gains", SPRING, Cells(gain=GAINS))
    yield Kind("gain far off", SPRING, Cells(gain=(1.4, 1.0)), expects="calibrat")
    yield Kind("zero errors, spring", SPRING, Cells(zero=ZERO))
    yield Kind("zero errors, band", BAND, Cells(zero=ZERO))
    yield Kind("zero errors, weight", PULLEY, Cells(zero=ZERO), tells=False)
    yield Kind("gains and zero errors", SPRING_BY_SINE, Cells(gain=GAINS, zero=ZERO))
    yield Kind("late cell, 20 ms", SPRING_BY_SINE, Cells(delay=0.02))
    yield Kind("late cell, 150 ms", SPRING_BY_SINE, Cells(delay=0.15), expects="delay")
    yield Kind("filtered", SPRING_BY_SINE, Cells(filter=0.05))
    yield Kind("coarse converter", SPRING, Cells(step=0.5))
    very_coarse = Cells(step=2.0, noise=0.01)
    yield Kind("very coarse converter", replace(PULLEY, force=20.0), very_coarse, tells=False)
    yield Kind("saturated", BAND, Cells(most=150.0), expects="satur")
    yield Kind("spikes", SPRING, Cells(spikes=0.01))
    yield Kind("many spikes", SPRING, Cells(spikes=0.15), expects="spike")
    yield Kind("missing readings", SPRING, Cells(missing=0.05))
    many_strokes = replace(SPRING, strokes=20)
    yield Kind("drifting gain", many_strokes, Cells(gain_drift=0.1), expects="drift")
    yield Kind("a dead load cell", SPRING, Cells(dead=True), tells=False)
    yield Kind("never slips", replace(PULLEY, travel=2e-4, tendon=5e3), tells=False)
    yield Kind("a short travel", replace(SPRING, travel=4e-3, stiffness=4e4))


KINDS = {kind.name: kind for kind in (*_driven(), *_mechanics(), *_sensors())}


COLUMNS = {"time": "time_s", "position": "position_mm", "motor": "motor_N", "load": "load_N"}


def judged(kind: Kind, columns: dict[str, Floats], truth: float) -> dict[str, object]:
    """Judge a log's fit as its user would: the outcome in words, and how far off it is.

    Fits without warnings also have `held`, True if the truth is in the interval, and `half`, half
    of the interval over the truth.
    """
    frame = {}
    for name, values in columns.items():
        factor = 1e3 if name == "position" else 1.0
        frame[COLUMNS.get(name, name)] = np.round(values * factor, 4)
    bend_angle = None if "bend_angle_rad" in columns else kind.rig.bend
    try:
        fit = tendon.fit_friction(frame, bend_angle)
    except TendonError:
        return {"outcome": "wrongly refused" if kind.tells else "rightly refused"}
    low, high = fit.interval_95
    holds_truth = low <= truth <= high
    error = abs(fit.friction / truth - 1.0)
    is_right = holds_truth or error <= 0.01
    is_expected = kind.expects in " ".join(fit.warnings).lower()
    if fit.warnings and kind.expects and is_expected:
        outcome = "warned"
    elif fit.warnings:
        outcome = "false alarm" if is_right and not kind.expects else "warned of something else"
    elif is_right:
        outcome = "wide" if high - low > 0.2 * truth else "right"
    else:
        outcome = "silent"
    if not kind.tells:
        return {"outcome": f"untold {outcome}", "error": error}
    verdict = {"outcome": outcome, "error": error}
    if not fit.warnings:
        verdict["held"] = holds_truth
        verdict["half"] = 0.5 * (high - low) / truth
    return verdict


def shares(verdicts: pd.DataFrame) -> tuple[float, ...]:
    """Return shares of the logs that can show μ, %.

    They are silent errors, false alarms, wrong refusals and intervals that hold; the last number is
    the median of half an interval.
    """
    cannot_tell = verdicts.outcome.str.startswith(("untold", "rightly"))
    counted = verdicts[~cannot_tell]
    outcomes = [
        100.0 * (counted.outcome == outcome).mean()
        for outcome in ("silent", "false alarm", "wrongly refused")
    ]
    return (*outcomes, 100.0 * counted.held.astype(float).mean(), 100.0 * counted.half.median())


def main() -> int:
    """Fit so many logs of each kind and print a table; the exit code is 1 if errors are silent.

    Up to 2 % of silent errors are allowed.
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    tables = []
    for name, kind in KINDS.items():
        if options.only not in name:
            continue
        logs_of_kind = logs(kind, options.seeds, options.first)
        verdicts = pd.DataFrame([judged(kind, *log) for log in logs_of_kind])
        outcomes = verdicts.outcome.value_counts().to_dict()
        errors = verdicts.get("error", pd.Series(dtype=float))
        print(f"{name:26} {outcomes} median error {100 * errors.median():.2f} %", flush=True)
        tables.append(verdicts)
    silent, alarms, refused, held, half = shares(pd.concat(tables))
    print(
        f"silent {silent:.1f} %; false alarms {alarms:.1f} %; wrongly refused {refused:.1f} %; "
        f"intervals hold in {held:.1f} %; median half-width {half:.2f} %"
    )
    return int(silent > 2.0)


if __name__ == "__main__":
    sys.exit(main())
