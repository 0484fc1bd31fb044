"""Simulated logs and tables of what real rigs give, case by case, with the truth beside them.

Forces are in N. The clean rig has five cycles, readings of 0.01 N and 0.1 N of noise; each case
changes one thing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from tendon_cli.fits.friction import fit_friction
from tendon_cli.fits.friction.fit_result import Fit

from .rig import Floats, Logs, Rig, simulate

FRICTION = 0.1
ROW = 0.02
"""Seconds from row to row."""
CLEAN = Rig(
    FRICTION,
    strokes=10,
    weights=(20.0, 60.0),
    noise=0.1,
    resolution=0.01,
    friction_scatter=0.01,
    load_spring=0.0,
)
VARYING = replace(CLEAN, load_spring=1.0)

Maker = Callable[[Rig, Logs, int], pd.DataFrame]
"""Makes the readings of one seed from the logs of a rig."""


@dataclass(frozen=True)
class Case:
    """A kind of rig, and the fits that are expected of it."""

    rig: Rig

    names: str = ""
    """Word of the cause that a warning must name if the number is wrong."""

    hides: bool = False
    """True if nothing in the readings can tell what is wrong: only a note says how much."""

    refused: bool = False
    """True if the only right answer is a refusal."""

    clean: bool = False
    """True if any warning is a false alarm."""

    make: Maker | None = None
    """Readings of a seed, if not the log as it stands."""


def mentions(texts: Iterable[str], words: str) -> bool:
    """Return True if any of the texts contains the words."""
    return any(words in text for text in texts)


def readings(motor: Floats, load: Floats, **columns: Any) -> pd.DataFrame:
    """Return readings as people have them in Python, with time unless it is given as None."""
    rows = {"motor (N)": motor, "load (N)": load, "time": ROW * np.arange(len(motor)), **columns}
    return pd.DataFrame({name: values for name, values in rows.items() if values is not None})


def log_of(rig: Rig, logs: Logs, seed: int, **columns: Any) -> pd.DataFrame:
    """Return the log of one seed, with time."""
    return readings(logs.motor_cell[:, seed], logs.load_cell[:, seed], **columns)


def fits_of(rig: Rig, seeds: int, first_seed: int = 0) -> list[Fit]:
    """Fit the logs of this many seeds, with the bend angle taken as exact."""
    logs = simulate(rig, seeds, first_seed)
    return [fit_friction(log_of(rig, logs, seed), rig.bend_angle) for seed in range(seeds)]


def with_directions(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """Add a column of directions, which follows the motor and not the slip."""
    direction = np.select([logs.toward > 0, logs.toward < 0], ["up", "down"], "rest")
    return log_of(rig, logs, seed, direction=direction)


def with_strokes(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """Add a column that counts the strokes."""
    is_turn = np.diff(logs.toward, prepend=0.0) != 0.0
    return log_of(rig, logs, seed, stroke=np.cumsum(is_turn).astype(str))


def untimed(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """Return two columns of forces and nothing else."""
    return log_of(rig, logs, seed, time=None)


def settled(rows: int, directions: bool = True) -> Maker:
    """Return the maker of a table of `rows` settled readings from the end of every stroke."""

    def make(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
        moving = np.arange(rig.rows_at_rest, len(logs.toward))
        at_ends = moving.reshape(rig.strokes, -1)[:, -rows:].ravel()
        motor = logs.motor_cell[at_ends, seed]
        load = logs.load_cell[at_ends, seed]
        names = np.where(logs.toward[at_ends] > 0, "up", "down") if directions else None
        return readings(motor, load, time=None, direction=names)

    return make


def levels(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """Pull a heavy weight up and let a light one down; they are exchanged between the strokes."""
    light = simulate(replace(rig, weights=(25.0, 25.0)), 1, first_seed=seed)
    down = logs.toward < 0.0
    motor = np.where(down, light.motor_cell[:, 0], logs.motor_cell[:, seed])
    load = np.where(down, light.load_cell[:, 0], logs.load_cell[:, seed])
    return readings(motor, load)


def with_zeros(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """Add rows of no force before, after and between, as if the weight is hooked on and off."""
    empty = np.zeros(30)
    middle = len(logs.toward) // 2
    cells = []
    for cell in (logs.motor_cell, logs.load_cell):
        first_half = cell[:middle, seed]
        second_half = cell[middle:, seed]
        cells.append(np.concatenate([empty, first_half, empty, second_half, empty - 0.3]))
    return readings(*cells)


def _pair(name: str, **changes: Any) -> Iterator[tuple[str, Case]]:
    """Yield a rig with a weight, and one whose force varies within a stroke."""
    of_case = {key: changes.pop(key) for key in ("names", "clean") if key in changes}
    yield name, Case(replace(CLEAN, **changes), **of_case)
    yield f"{name}, varying", Case(replace(VARYING, **changes), **of_case)


def _cases() -> Iterator[tuple[str, Case]]:
    """Yield every case with its name."""
    yield from _clean()
    for noise in (0.005, 0.02, 0.05):
        yield from _pair(f"noise {noise:.1%}", noise=0.0, relative_noise=noise)
    yield from _pair("noise 1 N", noise=1.0)
    yield from _pair("noise 0.5 N, correlated", noise=0.5, correlation=0.9)
    yield "gain 3 %", Case(replace(CLEAN, gain_mismatch=0.03))
    yield from _offsets()
    yield from _delays()
    yield from _pair("steps of 1 N", resolution=1.0)
    yield "saturated", Case(replace(VARYING, saturation=1.9))
    yield "saturated, constant", Case(replace(CLEAN, saturation=1.2), names="saturat")
    yield from _pair("dwell", dwell=60, clean=True)
    yield "dwell while sticking", Case(replace(CLEAN, dwell=60, sticking=(0.55, 0.8)))
    yield from _short()
    yield from _stuck()
    yield from _tables()
    yield "gain drifts 3 %", Case(replace(CLEAN, gain_drift=0.03), names="drift")
    yield from _pair("friction drifts 10 %", friction_drift=0.1, names="drift")


def _clean() -> Iterator[tuple[str, Case]]:
    """Yield logs with nothing wrong."""
    yield "clean", Case(CLEAN, clean=True)
    yield "clean, force varying", Case(VARYING, clean=True)
    yield "clean, crank", Case(replace(VARYING, sinusoidal=True), clean=True)
    yield "clean, no time", Case(CLEAN, clean=True, make=untimed)
    yield "direction column", Case(CLEAN, clean=True, make=with_directions)
    yield "stroke column", Case(CLEAN, clean=True, make=with_strokes)
    yield "zero rows", Case(CLEAN, clean=True, make=with_zeros)


def _offsets() -> Iterator[tuple[str, Case]]:
    """Yield zero errors of either cell."""
    errors = (1.0, -1.0, 3.0, -3.0)
    of_motor = [(error, 0.0) for error in errors]
    of_load = [(0.0, error) for error in errors]
    for offsets in of_motor + of_load:
        cell = "motor" if offsets[0] else "load"
        name = f"offset {cell} {sum(offsets):+.0f} N"
        yield f"{name}, varying", Case(replace(VARYING, offsets=offsets), names="offset")
        constant = replace(CLEAN, offsets=offsets)
        yield f"{name}, constant", Case(constant, names="offset", hides=True)
        high = replace(CLEAN, weights=(85.0, 95.0), offsets=offsets)
        yield f"{name}, levels differ", Case(high, names="zero error", make=levels)


def _delays() -> Iterator[tuple[str, Case]]:
    """Yield load cells that are late."""
    for rows, time in ((1, "20 ms"), (5, "100 ms")):
        late = replace(VARYING, delay=rows)
        yield f"delay {time}, varying", Case(late, names="delay")
        yield f"delay {time}, crank", Case(replace(late, sinusoidal=True), names="delay")
        yield f"delay {time}, constant", Case(replace(CLEAN, delay=rows), names="delay")


def _short() -> Iterator[tuple[str, Case]]:
    """Yield logs of few rows."""
    short = replace(CLEAN, rows_per_stroke=28, strokes=2, rows_at_rest=3, sticking=(0.15, 0.5))
    yield "59 rows, one reversal", Case(short)
    yield "56 rows, no time", Case(replace(short, rows_at_rest=0), make=untimed)
    for rows in (7, 10):
        few = replace(CLEAN, rows_per_stroke=rows, rows_at_rest=0)
        yield f"{rows} rows a stroke", Case(few, clean=True)
        yield f"{rows} rows a stroke, directions", Case(few, clean=True, make=with_directions)
        yield f"{rows} rows a stroke, strokes", Case(few, clean=True, make=with_strokes)


def _stuck() -> Iterator[tuple[str, Case]]:
    """Yield logs in which the tendon never slips."""
    stuck = replace(CLEAN, sticking=(1.3, 2.0))
    yield "never slipping", Case(stuck, refused=True)
    yield "never slipping, crank", Case(replace(stuck, sinusoidal=True), refused=True)
    yield "never slipping, strokes", Case(stuck, refused=True, make=with_strokes)
    few = replace(stuck, rows_per_stroke=10, rows_at_rest=0)
    yield "never slipping, 10 rows", Case(few, refused=True, make=with_directions)


def _tables() -> Iterator[tuple[str, Case]]:
    """Yield settled readings."""
    table = replace(CLEAN, rows_per_stroke=60, rows_at_rest=0)
    for cycles in (1, 5):
        for rows in (1, 3, 10, 25):
            rig = replace(table, strokes=2 * cycles)
            is_too_little = cycles == 1 and rows == 1
            case = Case(rig, refused=is_too_little, make=settled(rows))
            yield f"settled, {cycles} x {rows} rows", case
    noisy = replace(table, relative_noise=0.02)
    for rows in (1, 2, 5):
        yield f"settled, 5 x {rows} rows, noise 2 %", Case(noisy, make=settled(rows))
    yield "settled, 5 x 1 rows, noise 2 %, no names", Case(noisy, make=settled(1, directions=False))
    yield "settled, 5 x 10 rows, no names", Case(table, make=settled(10, directions=False))


CASES = dict(_cases())
