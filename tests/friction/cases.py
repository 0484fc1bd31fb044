"""What rigs really give, case by case: simulated logs and tables with the truth beside them.

Forces are in N. The clean rig has five cycles, readings of 0.01 N and 0.1 N of noise; each case changes one thing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from tendon_cli.friction import fit_friction
from tendon_cli.friction.fit_result import Fit

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


@dataclass(frozen=True)
class Case:
    """One kind of rig, and what is expected of its fits."""

    rig: Rig
    names: str = ""  # a word of the cause that a warning must name if the number is wrong
    hides: bool = False  # nothing in the readings can tell what is wrong: only a note says how much it could be
    refused: bool = False  # the only right answer is a refusal
    clean: bool = False  # any warning is a false alarm
    make: Callable[[Rig, Logs, int], pd.DataFrame] | None = (
        None  # readings of a seed, if not the log as it stands
    )


def readings(motor: Floats, load: Floats, **columns: Any) -> pd.DataFrame:
    """Readings as people have them in Python, with time unless it is given as None."""
    rows = {"motor (N)": motor, "load (N)": load, "time": ROW * np.arange(len(motor)), **columns}
    return pd.DataFrame({name: values for name, values in rows.items() if values is not None})


def log_of(rig: Rig, logs: Logs, seed: int, **columns: Any) -> pd.DataFrame:
    """The log of one seed, with time."""
    return readings(logs.motor_cell[:, seed], logs.load_cell[:, seed], **columns)


def fits_of(rig: Rig, seeds: int, first_seed: int = 0) -> list[Fit]:
    """Fits of the logs of so many seeds, with the bend angle taken as exact."""
    logs = simulate(rig, seeds, first_seed)
    return [fit_friction(log_of(rig, logs, seed), rig.bend_angle) for seed in range(seeds)]


def with_directions(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """With a column of directions, which follows the motor and not the slip."""
    return log_of(
        rig,
        logs,
        seed,
        direction=np.select([logs.toward > 0, logs.toward < 0], ["up", "down"], "rest"),
    )


def with_strokes(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """With a column that counts the strokes."""
    return log_of(
        rig, logs, seed, stroke=np.cumsum(np.diff(logs.toward, prepend=0.0) != 0.0).astype(str)
    )


def untimed(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """Two columns of forces and nothing else."""
    return log_of(rig, logs, seed, time=None)


def settled(rows: int, directions: bool = True) -> Callable[[Rig, Logs, int], pd.DataFrame]:
    """A table of `rows` settled readings of every stroke, taken from its end."""

    def make(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
        taken = (
            np.arange(rig.rows_at_rest, len(logs.toward))
            .reshape(rig.strokes, -1)[:, -rows:]
            .ravel()
        )
        names = np.where(logs.toward[taken] > 0, "up", "down") if directions else None
        return readings(
            logs.motor_cell[taken, seed], logs.load_cell[taken, seed], time=None, direction=names
        )

    return make


def levels(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """Pulled up with a heavy weight and let down with a light one, which are exchanged between the strokes."""
    light = simulate(replace(rig, weights=(25.0, 25.0)), 1, first_seed=seed)
    down = logs.toward < 0.0
    cells = (
        np.where(down, light.motor_cell[:, 0], logs.motor_cell[:, seed]),
        np.where(down, light.load_cell[:, 0], logs.load_cell[:, seed]),
    )
    return readings(*cells)


def with_zeros(rig: Rig, logs: Logs, seed: int) -> pd.DataFrame:
    """Rows of no force before, after and in between, as when the weight is hooked on and off."""
    empty = np.zeros(30)
    middle = len(logs.toward) // 2
    cells = [
        np.concatenate([empty, cell[:middle, seed], empty, cell[middle:, seed], empty - 0.3])
        for cell in (logs.motor_cell, logs.load_cell)
    ]
    return readings(*cells)


def _pair(name: str, **changes: Any) -> Iterator[tuple[str, Case]]:
    """A rig with a weight, and one whose force varies within a stroke."""
    of_case = {key: changes.pop(key) for key in ("names", "clean") if key in changes}
    yield name, Case(replace(CLEAN, **changes), **of_case)
    yield f"{name}, varying", Case(replace(VARYING, **changes), **of_case)


def _cases() -> Iterator[tuple[str, Case]]:
    yield "clean", Case(CLEAN, clean=True)
    yield "clean, force varying", Case(VARYING, clean=True)
    yield "clean, crank", Case(replace(VARYING, sinusoidal=True), clean=True)
    yield "clean, no time", Case(CLEAN, clean=True, make=untimed)
    yield "direction column", Case(CLEAN, clean=True, make=with_directions)
    yield "stroke column", Case(CLEAN, clean=True, make=with_strokes)
    yield "zero rows", Case(CLEAN, clean=True, make=with_zeros)
    for noise in (0.005, 0.02, 0.05):
        yield from _pair(f"noise {noise:.1%}", noise=0.0, relative_noise=noise)
    yield from _pair("noise 1 N", noise=1.0)
    yield from _pair("noise 0.5 N, correlated", noise=0.5, correlation=0.9)
    yield "gain 3 %", Case(replace(CLEAN, gain_mismatch=0.03))
    for zero in [(n, 0.0) for n in (1.0, -1.0, 3.0, -3.0)] + [
        (0.0, n) for n in (1.0, -1.0, 3.0, -3.0)
    ]:
        name = f"offset {'motor' if zero[0] else 'load'} {sum(zero):+.0f} N"
        yield f"{name}, varying", Case(replace(VARYING, offsets=zero), names="offset")
        yield f"{name}, constant", Case(replace(CLEAN, offsets=zero), names="offset", hides=True)
        high = replace(CLEAN, weights=(85.0, 95.0), offsets=zero)
        yield f"{name}, levels differ", Case(high, names="zero error", make=levels)
    for rows, name in ((1, "20 ms"), (5, "100 ms")):
        yield f"delay {name}, varying", Case(replace(VARYING, delay=rows), names="delay")
        yield (
            f"delay {name}, crank",
            Case(replace(VARYING, delay=rows, sinusoidal=True), names="delay"),
        )
        yield f"delay {name}, constant", Case(replace(CLEAN, delay=rows), names="delay")
    yield from _pair("steps of 1 N", resolution=1.0)
    yield "saturated", Case(replace(VARYING, saturation=1.9))
    yield "saturated, constant", Case(replace(CLEAN, saturation=1.2), names="saturat")
    yield from _pair("dwell", dwell=60, clean=True)
    yield "dwell while sticking", Case(replace(CLEAN, dwell=60, sticking=(0.55, 0.8)))
    short = replace(CLEAN, rows_per_stroke=28, strokes=2, rows_at_rest=3, sticking=(0.15, 0.5))
    yield "59 rows, one reversal", Case(short)
    yield "56 rows, no time", Case(replace(short, rows_at_rest=0), make=untimed)
    for rows in (7, 10):
        few = replace(CLEAN, rows_per_stroke=rows, rows_at_rest=0)
        for name, make in (
            ("", None),
            (", directions", with_directions),
            (", strokes", with_strokes),
        ):
            yield f"{rows} rows a stroke{name}", Case(few, clean=True, make=make)
    stuck = replace(CLEAN, sticking=(1.3, 2.0))
    yield "never slipping", Case(stuck, refused=True)
    yield "never slipping, crank", Case(replace(stuck, sinusoidal=True), refused=True)
    yield "never slipping, strokes", Case(stuck, refused=True, make=with_strokes)
    few = replace(stuck, rows_per_stroke=10, rows_at_rest=0)
    yield "never slipping, 10 rows", Case(few, refused=True, make=with_directions)
    yield from _tables()
    yield "gain drifts 3 %", Case(replace(CLEAN, gain_drift=0.03), names="drift")
    yield from _pair("friction drifts 10 %", friction_drift=0.1, names="drift")


def _tables() -> Iterator[tuple[str, Case]]:
    """Settled readings."""
    table = replace(CLEAN, rows_per_stroke=60, rows_at_rest=0)
    for strokes in (1, 5):
        for rows in (1, 3, 10, 25):
            rig, refused = replace(table, strokes=2 * strokes), strokes == rows == 1
            yield (
                f"settled, {strokes} x {rows} rows",
                Case(rig, refused=refused, make=settled(rows)),
            )
    noisy = replace(table, relative_noise=0.02)
    for rows in (1, 2, 5):
        yield f"settled, 5 x {rows} rows, noise 2 %", Case(noisy, make=settled(rows))
    yield "settled, 5 x 1 rows, noise 2 %, no names", Case(noisy, make=settled(1, directions=False))
    yield "settled, 5 x 10 rows, no names", Case(table, make=settled(10, directions=False))


CASES = dict(_cases())
