"""A second rig for the friction fit: a tendon as a chain of elastic links with friction, and what labs do to it.

The chain is massless and elastic. Link i turns by φ_i in its sheath, and ln T may differ across it by m_i = μ φ_i at
most: what lies between is elastic history. The motor's end is moved; the load's end hangs from a weight, a spring, a
band or a person. Nothing here knows how readings are fitted. `python -m tests.friction.chain` fits every kind of log.
"""

from __future__ import annotations

import argparse
import sys
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
    """What stands on the bench, before anyone reads a cell."""

    friction: float = 0.1
    bend: float = 2.5
    load: str = "weight"  # or "spring", "band", "person"
    force: float = 60.0  # the weight, the spring's preload, or what the person pulls on average, N
    stiffness: float = 400.0  # of the spring at the load, N/m
    tendon: float = 4e4  # stiffness of the whole tendon, N/m
    drive: str = "triangle"  # or "sine", "rests", "steps", "hand"
    travel: float = 0.08
    strokes: int = 12
    seconds: float = 4.0  # of a stroke
    law: str = "coulomb"  # or "dahl", "stribeck", "ageing"
    entry: float = 0.0  # friction outside of the bend, as a share of μφ at a bend of 2.4 rad
    bends: tuple[float, ...] = ()  # of the several runs of one log; empty: one bend


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
    """Where the motor's end is at each reading, m."""
    each, strokes = int(rig.seconds * RATE), rig.strokes
    ramp = np.linspace(0.0, 1.0, each, endpoint=False)
    parts: list[Floats] = []
    for stroke in range(strokes):
        up = ramp if stroke % 2 == 0 else 1.0 - ramp
        if rig.drive == "sine":
            up = 0.5 - 0.5 * np.cos(np.pi * up)
        elif rig.drive == "rests":
            rest = np.full(int(each * random.uniform(0.1, 0.5)), up[-1])
            up = np.concatenate([up, rest])
        elif rig.drive == "steps":
            up = np.round(up * 8) / 8
        elif rig.drive == "hand":
            knots = np.sort(random.uniform(0.0, 1.0, 4))
            progress = np.interp(np.linspace(0, 1, each), np.linspace(0, 1, 6), [0.0, *knots, 1.0])
            up = progress if stroke % 2 == 0 else 1.0 - progress
        parts.append(up)
    return rig.travel * np.concatenate(parts)


def pulled(rig: Rig, count: int, random: np.random.Generator) -> Floats:
    """What the load's end pulls with, if it does not depend on where it is, N."""
    time = np.arange(count) / RATE
    if rig.load != "person":
        return np.full(count, rig.force)
    slow = sum(
        np.sin(2 * np.pi * time * f + p)
        for f, p in zip((0.05, 0.11, 0.23), random.uniform(0, 6, 3), strict=True)
    )
    return rig.force * (1.0 + 0.2 * np.asarray(slow) / 3 + 0.01 * np.sin(2 * np.pi * 8.0 * time))


def limits_of(rig: Rig, speed: Floats, rest: Floats) -> Floats:
    """Σ m over the sheath at each reading, by the law of friction, without the entry's part."""
    whole = np.full(len(speed), rig.friction * rig.bend)
    if rig.law == "stribeck":
        whole *= 1.0 + 0.15 * np.exp(-np.abs(speed) / 0.004)
    elif rig.law == "ageing":
        whole *= 1.0 + 0.03 * np.log1p(rest / 0.5)
    return whole


def tensions(rigs: list[Rig], randoms: list[np.random.Generator]) -> tuple[Floats, Floats, Floats]:
    """Tension at the motor and at the load, N, and where the motor's end is, m: (rigs of one kind, readings)."""
    drives = [drive(rig, random) for rig, random in zip(rigs, randoms, strict=True)]
    count = min(map(len, drives))
    at = np.array([each[:count] for each in drives])
    speed = np.gradient(at, axis=1) * RATE
    rest = np.array([_resting(each) for each in speed])
    pull = np.array([pulled(rig, count, random) for rig, random in zip(rigs, randoms, strict=True)])
    whole = np.array([limits_of(rig, v, r) for rig, v, r in zip(rigs, speed, rest, strict=True)])
    shares = np.array([random.uniform(0.5, 1.5, LINKS) for random in randoms])
    shares /= shares.sum(axis=1, keepdims=True)
    shares[:, 0] += np.array([rig.entry * 2.4 / rig.bend for rig in rigs])  # the same at every bend
    chain = Chain.of(rigs)
    motor, load = np.empty_like(at), np.empty_like(at)
    for row in range(count):
        chain.move(whole[:, row, np.newaxis] * shares, at[:, row], pull[:, row])
        motor[:, row], load[:, row] = np.exp(chain.log[0]), np.exp(chain.log[-1])
    return motor, load, at


def _resting(speed: Floats) -> Floats:
    """For how long the motor's end has been at rest, s."""
    rest, found = 0.0, np.empty(len(speed))
    for row, v in enumerate(speed):
        found[row] = rest
        rest = rest + 1 / RATE if abs(v) < 1e-6 else rest * 0.8
    return found


@dataclass
class Chain:
    """Chains of one kind: ln T at each of their nodes, (nodes, chains), and where their load's ends are."""

    kind: Rig
    force: Floats
    log: Floats
    end: Floats

    @classmethod
    def of(cls, rigs: list[Rig]) -> Chain:
        """At rest, the same tension everywhere, the motor's end at 0."""
        force = np.array([rig.force for rig in rigs])
        chain = cls(rigs[0], force, np.tile(np.log(force), (LINKS + 1, 1)), np.zeros(len(rigs)))
        if rigs[0].load in ("weight", "person"):
            chain.end = -chain.stretch(chain.log)
        return chain

    def stretch(self, log: Floats) -> Floats:
        """How much longer the tendon is than without tension, m."""
        return np.asarray(np.exp(log).mean(axis=0) / self.kind.tendon)

    def played(self, first: Floats, m: Floats) -> Floats:
        """ln T along the chain if the motor's end has this one: each link plays within its limit."""
        log = np.empty_like(self.log)
        log[0] = first
        for i in range(1, len(log)):
            if self.kind.law == "dahl":
                change = log[i - 1] - self.log[i - 1]
                goal = -np.sign(change) * m[:, i - 1]
                apart = self.log[i] - self.log[i - 1]
                log[i] = (
                    log[i - 1] + goal + (apart - goal) * np.exp(-3.0 * np.abs(change) / m[:, i - 1])
                )
            else:
                log[i] = np.minimum(
                    np.maximum(self.log[i], log[i - 1] - m[:, i - 1]), log[i - 1] + m[:, i - 1]
                )
        return log

    def end_at(self, log: Floats) -> Floats:
        """Where the load's end is at these tensions, m; of a weight and a person, where it was."""
        tension = np.exp(log[-1])
        if self.kind.load == "spring":
            return np.asarray((tension - self.force) / self.kind.stiffness)
        if self.kind.load == "band":
            return np.asarray(0.05 * np.log(tension / self.force))
        return self.end

    def move(self, m: Floats, x: Floats, pull: Floats) -> None:
        """Move the motor's end to x, the load's end pulled with `pull` if it is a weight's or a person's."""
        low, high = self.log[0] - 0.8, self.log[0] + 0.8
        for _ in range(30):
            middle = 0.5 * (low + high)
            log = self.played(middle, m)
            short = self.end_at(log) + self.stretch(log) < x
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        log = self.played(0.5 * (low + high), m)
        if self.kind.load in (
            "weight",
            "person",
        ):  # the load's end moves until its tension is what it is pulled with
            log[-1] = np.log(pull)
            for i in range(LINKS - 1, -1, -1):
                log[i] = np.minimum(np.maximum(log[i], log[i + 1] - m[:, i]), log[i + 1] + m[:, i])
            slipped = np.abs(log[0] - 0.5 * (low + high)) > 1e-7
            self.end = np.where(slipped, x - self.stretch(log), self.end)
        else:
            self.end = self.end_at(log)
        self.log = log


def logs(kind: Kind, seeds: int, first: int = 0) -> list[tuple[dict[str, Floats], float]]:
    """The columns of each log of a kind, and the μ that made it."""
    randoms = [
        np.random.default_rng([seed, *kind.name.encode()]) for seed in range(first, first + seeds)
    ]
    rigs = [
        replace(
            kind.rig,
            friction=kind.rig.friction * r.uniform(0.6, 1.6),
            force=kind.rig.force * r.uniform(0.7, 1.4),
        )
        for r in randoms
    ]
    runs = [
        tensions([replace(rig, bend=bend) for rig in rigs], randoms)
        for bend in kind.rig.bends or (kind.rig.bend,)
    ]
    bends = np.concatenate(
        [
            np.full(run[0].shape[1], b)
            for run, b in zip(runs, kind.rig.bends or (kind.rig.bend,), strict=True)
        ]
    )
    found = []
    for of, (rig, random) in enumerate(zip(rigs, randoms, strict=True)):
        motor, load, at = (np.concatenate([run[column][of] for run in runs]) for column in range(3))
        readings = kind.cells.read(motor, load, random)
        every = {
            "time": np.arange(len(at)) / RATE,
            "position": at + 2e-5 * random.normal(size=len(at)),
            "bend_angle_rad": bends,
            "direction": np.sign(np.gradient(at)),
            "motor": readings[0],
            "load": readings[1],
        }
        found.append(
            ({name: every[name] for name in (*kind.columns, "motor", "load")}, rig.friction)
        )
    return found


SOFT = 8e3
PULLEY = Rig(tendon=SOFT, travel=0.05)
SPRING = replace(PULLEY, load="spring", force=30.0, stiffness=900.0)
BAND = replace(PULLEY, load="band", force=30.0)
PERSON = replace(PULLEY, load="person", drive="hand")
AT = ("time", "position")
BENT = ("time", "bend_angle_rad")
BENDS = (1.2, 2.4, 3.6)
WAY = ("time", "direction")


def _kinds() -> dict[str, Kind]:
    """Every kind of log by its name."""
    zero, gains = (0.8, -0.5), (1.04, 0.99)
    kinds = [
        *(
            Kind(f"{name}, {d}", replace(rig, drive=d))
            for name, rig in (
                ("weight", PULLEY),
                ("spring", SPRING),
                ("band", BAND),
                ("person", PERSON),
            )
            for d in ("triangle", "sine", "rests", "hand", "steps")
        ),
        Kind("weight, with position", replace(PULLEY, drive="rests"), columns=AT),
        Kind("spring, with position", replace(SPRING, drive="rests"), columns=AT),
        Kind("spring, with direction", replace(SPRING, drive="sine"), columns=WAY),
        Kind("two strokes", replace(SPRING, strokes=2), expects="stroke"),
        Kind("four strokes", replace(PULLEY, strokes=4)),
        Kind("forty strokes", replace(PULLEY, strokes=40, seconds=1.5)),
        Kind("little friction", replace(SPRING, friction=0.03)),
        Kind("much friction", replace(SPRING, friction=0.3)),
        Kind("stiff tendon", replace(SPRING, tendon=1e5)),
        Kind("very soft tendon", replace(SPRING, tendon=2e3, travel=0.12)),
        Kind("dahl", replace(SPRING, law="dahl")),
        Kind("dahl, weight", replace(PULLEY, law="dahl")),
        Kind("stribeck", replace(SPRING, law="stribeck", drive="triangle")),
        Kind("ageing", replace(PULLEY, law="ageing", drive="rests")),
        Kind("entry, one bend", replace(SPRING, entry=0.15), tells=False),
        Kind(
            "entry, three bends",
            replace(SPRING, entry=0.15, bends=BENDS, strokes=6),
            columns=BENT,
            expects="bend",
        ),
        Kind("noise", SPRING, Cells(noise=0.6)),
        Kind("correlated noise", SPRING, Cells(slow_noise=0.4)),
        Kind("hum", SPRING, Cells(hum=0.4)),
        Kind("gains", SPRING, Cells(gain=gains)),
        Kind("gain far off", SPRING, Cells(gain=(1.4, 1.0)), expects="calibrat"),
        Kind("zero errors, spring", SPRING, Cells(zero=zero)),
        Kind("zero errors, band", BAND, Cells(zero=zero)),
        Kind("zero errors, weight", PULLEY, Cells(zero=zero), tells=False),
        Kind("gains and zero errors", replace(SPRING, drive="sine"), Cells(gain=gains, zero=zero)),
        Kind("late cell, 20 ms", replace(SPRING, drive="sine"), Cells(delay=0.02)),
        Kind(
            "late cell, 150 ms", replace(SPRING, drive="sine"), Cells(delay=0.15), expects="delay"
        ),
        Kind("filtered", replace(SPRING, drive="sine"), Cells(filter=0.05)),
        Kind("coarse converter", SPRING, Cells(step=0.5)),
        Kind(
            "very coarse converter",
            replace(PULLEY, force=20.0),
            Cells(step=2.0, noise=0.01),
            tells=False,
        ),
        Kind("saturated", BAND, Cells(most=150.0), expects="satur"),
        Kind("spikes", SPRING, Cells(spikes=0.01)),
        Kind("many spikes", SPRING, Cells(spikes=0.15), expects="spike"),
        Kind("missing readings", SPRING, Cells(missing=0.05)),
        Kind("drifting gain", replace(SPRING, strokes=20), Cells(gain_drift=0.1), expects="drift"),
        Kind("a dead load cell", SPRING, Cells(dead=True), tells=False),
        Kind("never slips", replace(PULLEY, travel=2e-4, tendon=5e3), tells=False),
        Kind("a short travel", replace(SPRING, travel=4e-3, stiffness=4e4)),
    ]
    return {kind.name: kind for kind in kinds}


KINDS = _kinds()


COLUMNS = {"time": "time_s", "position": "position_mm", "motor": "motor_N", "load": "load_N"}


def judged(kind: Kind, columns: dict[str, Floats], truth: float) -> dict[str, object]:
    """A log's fit as its user would judge it: the outcome in words, and how far off it is.

    `held`, whether the truth is in the interval, and `half` of that over the truth are of fits without warnings.
    """
    frame = {
        COLUMNS.get(name, name): np.round(values * (1e3 if name == "position" else 1.0), 4)
        for name, values in columns.items()
    }
    try:
        fit = tendon.fit_friction(frame, None if "bend_angle_rad" in columns else kind.rig.bend)
    except TendonError:
        return {"outcome": "wrongly refused" if kind.tells else "rightly refused"}
    low, high = fit.interval_95
    held, error = low <= truth <= high, abs(fit.friction / truth - 1.0)
    named, right = kind.expects in " ".join(fit.warnings).lower(), held or error <= 0.01
    if fit.warnings and kind.expects and named:
        outcome = "warned"
    elif fit.warnings:
        outcome = "false alarm" if right and not kind.expects else "warned of something else"
    elif right:
        outcome = "wide" if high - low > 0.2 * truth else "right"
    else:
        outcome = "silent"
    if not kind.tells:
        return {"outcome": f"untold {outcome}", "error": error}
    quiet = {} if fit.warnings else {"held": held, "half": 0.5 * (high - low) / truth}
    return {"outcome": outcome, "error": error, **quiet}


def shares(verdicts: pd.DataFrame) -> tuple[float, ...]:
    """Silent, false alarms, wrongly refused, intervals that hold, median half-width: % of the logs that can show μ."""
    told = verdicts[~verdicts.outcome.str.startswith(("untold", "rightly"))]
    counted = (
        100.0 * (told.outcome == outcome).mean()
        for outcome in ("silent", "false alarm", "wrongly refused")
    )
    return (*counted, 100.0 * told.held.astype(float).mean(), 100.0 * told.half.median())


def main() -> int:
    """Fit so many logs of each kind and print a table; the exit code says whether silent errors are few."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    every = []
    for kind in (kind for name, kind in KINDS.items() if options.only in name):
        every.append(
            pd.DataFrame([judged(kind, *log) for log in logs(kind, options.seeds, options.first)])
        )
        outcomes, errors = (
            every[-1].outcome.value_counts().to_dict(),
            every[-1].get("error", pd.Series(dtype=float)),
        )
        print(f"{kind.name:26} {outcomes} median error {100 * errors.median():.2f} %", flush=True)
    silent, alarms, refused, held, half = shares(pd.concat(every))
    print(
        f"silent {silent:.1f} %; false alarms {alarms:.1f} %; wrongly refused {refused:.1f} %; ",
        end="",
    )
    print(f"intervals hold in {held:.1f} %; median half-width {half:.2f} %")
    return int(silent > 2.0)


if __name__ == "__main__":
    sys.exit(main())
