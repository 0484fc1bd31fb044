"""What else a log shows: stroke by stroke, against speed, by file, and before it slides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from tendon_cli.friction.usable_rows import REASONS

_SPEEDS = 0.2
"""Largest speed over the least, less 1, from which strokes say anything about it."""
_FEWEST = 6
"""Strokes from which a slope over them is more than one odd stroke."""
_EXACT = 0.002
"""Of μ: no rig's strokes agree more closely."""
_BY_CHANCE, _MATTERS = 0.003, 0.02
"""Files differ if chance would make it so in three of a thousand sets, and by more than 2 %."""
_STICK = (0.05, 0.35)
"""Part of the way from limit to limit in which the motor's force over its position is still nearly straight."""


@dataclass(frozen=True)
class Speed:
    """The power of the motor's speed that μ goes with."""

    power: float
    standard_error: float
    slowest: float
    fastest: float


@dataclass(frozen=True)
class Presliding:
    """What the motor does before the tendon slides: medians over the reversals.

    `stiffness` is its force per unit of its position, `backlash` its travel after a reversal before the force follows.
    """

    stiffness: float
    backlash: float
    reversals: int


def strokes_of(
    rows: pd.DataFrame, friction: float, given: bool, files: tuple[str, ...]
) -> pd.DataFrame:
    """Every stroke of a log, used or not: forces in the unit of the file, μ of each with gain and effects taken off.

    `rows` are those of `Fit.rows`, `given` says whether the bend angle is known.
    """
    rows = rows.assign(speed=_speeds(rows), inward=rows["way"] * rows["residual"])
    runs, used = (part.groupby("run") for part in (rows[rows["run"] >= 0], rows[rows["used"]]))
    first, count, means = runs.first(), runs["used"].sum(), ["motor", "load", "log_ratio", "speed"]
    mean = used[means].mean().reindex(first.index).fillna(runs[means].mean())
    bend = first["bend_angle"]
    why = runs["code"].agg(lambda codes: REASONS[codes.mode()[0]])
    return pd.DataFrame(
        {
            "stroke": first.index + 1,
            "file": [files[number] for number in first["file"]],
            "direction": np.where(first["way"] > 0, "toward motor", "toward load"),
            "first_line": first["line"],
            "last_line": runs["line"].last(),
            "bend_angle": bend if given else math.nan,
            "rows": runs.size(),
            "used": count,
            "force_motor": mean["motor"],
            "force_load": mean["load"],
            "log_ratio": mean["log_ratio"],
            "friction": friction
            + used["inward"].mean().reindex(first.index) / bend.where(bend > 0.0),
            "speed": mean["speed"],
            "why_not": why.where(count == 0, ""),
        }
    )


def _speeds(rows: pd.DataFrame) -> Any:
    """Speed of the motor in each row, per row if there is no time; NaN without a position."""
    if "speed" in rows:
        return rows["speed"].abs()
    if "position" not in rows:
        return math.nan
    passed = np.gradient(rows["time"].to_numpy()) if "time" in rows else np.ones(len(rows))
    moved = np.gradient(rows["position"].to_numpy())
    return np.abs(np.divide(moved, passed, out=np.zeros(len(moved)), where=passed > 0.0))


def speed_of(strokes: pd.DataFrame) -> Speed | None:
    """μ against speed, if the strokes have different speeds."""
    used = np.log(
        strokes.loc[
            (strokes["friction"] > 0.0) & (strokes["speed"] > 0.0), ["speed", "friction"]
        ].to_numpy()
    )
    if len(used) < _FEWEST or np.ptp(used[:, 0]) < math.log1p(_SPEEDS):
        return None
    line, covariance = np.polyfit(used[:, 0], used[:, 1], 1, cov=True)
    slowest, fastest = np.exp([used[:, 0].min(), used[:, 0].max()])
    return Speed(float(line[0]), float(np.sqrt(covariance[0, 0])), float(slowest), float(fastest))


def presliding_of(rows: pd.DataFrame) -> Presliding | None:
    """Stiffness and backlash after the reversals, by the straight part of the motor's force over its position."""
    if "position" not in rows:
        return None
    forces, places, ways = (rows[name].to_numpy() for name in ("motor", "position", "way"))
    kept, slopes, lost = np.flatnonzero(rows["used"]), [], []
    for at in np.flatnonzero(np.diff(ways[kept]) != 0):
        turn = slice(kept[at], kept[at + 1] + 1)
        force, x = forces[turn], places[turn]
        share = (force - force[0]) / (force[-1] - force[0] or math.inf)
        straight = (share > _STICK[0]) & (share < _STICK[1])
        if np.count_nonzero(straight) < 3 or np.ptp(x[straight]) == 0.0:
            continue
        slope, height = np.polyfit(x[straight], force[straight], 1)
        slopes.append(float(slope))
        lost.append(abs(float((force[0] - height) / slope - x[np.argmax(np.abs(x - x[-1]))])))
    if not slopes:
        return None
    return Presliding(abs(float(np.median(slopes))), float(np.median(lost)), len(slopes))


def by_file(strokes: pd.DataFrame, files: tuple[str, ...]) -> tuple[dict[str, Any], ...]:
    """μ of each of several files with its error: the mean of both directions, in which a file's gain cancels."""
    each = []
    for name in files if len(files) > 1 else ():
        ways = strokes[(strokes["file"] == name) & strokes["friction"].notna()].groupby(
            "direction"
        )["friction"]
        error = math.sqrt(float((ways.var() / ways.size()).sum())) / max(len(ways), 1)
        sure = len(ways) > 0 and ways.size().min() > 1
        mean = float(ways.mean().mean()) if len(ways) else None
        number = int(ways.size().sum())
        each.append(
            {
                "file": name,
                "friction": mean,
                "standard_error": error if sure else None,
                "strokes": number,
            }
        )
    return tuple(each)


def disagreement(files: tuple[dict[str, Any], ...]) -> list[str]:
    """What to say if the files do not agree: their scatter about the mean against their errors (chi-square)."""
    from scipy.special import chdtrc

    known = [
        (each["friction"], each["standard_error"])
        for each in files
        if each["standard_error"] is not None
    ]
    if len(known) < 2:
        return []
    value, error = np.array(known).T
    weight = 1.0 / np.maximum(error, _EXACT * np.abs(value)) ** 2
    mean = float(weight @ value / weight.sum())
    chance = float(chdtrc(len(value) - 1, weight @ (value - mean) ** 2))
    if chance >= _BY_CHANCE or np.ptp(value) <= _MATTERS * abs(mean):
        return []
    shown = ", ".join(f"{each:.4g}" for each in value[:6])
    return [
        f"the files do not agree, they give {shown}: one number does not hold for all; fit them one by one"
    ]
