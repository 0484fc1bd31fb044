"""Further findings of a log: strokes, dependence on speed, files, and motion before sliding."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from tendon_cli.fits.friction.budget import LEAST_SCATTER
from tendon_cli.fits.friction.usable_rows import REASONS

_SPEEDS = 0.2
"""Largest speed over the least, less 1, from which strokes show what the speed does."""
_FEWEST = 6
"""Least number of strokes for a slope over them: one odd stroke then does not make it."""
_BY_CHANCE = 0.003
"""Probability below which files are said to differ; by chance alone three of a thousand sets do."""
_MATTERS = 0.02
"""Difference of files, as a share of μ, from which it matters."""
_STICK = (0.05, 0.35)
"""Range, as shares of the way from limit to limit, in which the motor's force is still nearly
proportional to its travel."""


@dataclass(frozen=True)
class Speed:
    """Dependence of μ on the motor's speed."""

    power: float
    """Exponent p of μ ∝ speed^p."""
    standard_error: float
    slowest: float
    """Speed of the slowest stroke, in the unit of the file."""
    fastest: float


@dataclass(frozen=True)
class Presliding:
    """Motion of the motor before the tendon slides: medians over the reversals."""

    stiffness: float
    """Force of the motor per unit of its position."""
    backlash: float
    """Travel of the motor after a reversal before the force follows."""
    reversals: int


def strokes_of(
    rows: pd.DataFrame, friction: float, has_bend: bool, files: tuple[str, ...]
) -> pd.DataFrame:
    """Tabulate every stroke of a log, used or not.

    Forces are in the unit of the file; the friction of each stroke is its own μ, after gain and
    effects are removed.

    Args:
        rows: Rows of the fit, as `Fit.rows` has them.
        friction: μ of the whole log.
        has_bend: True if the bend angle is known.
        files: Names of the files.
    """
    rows = rows.assign(speed=_speeds(rows), inward=rows["way"] * rows["residual"])
    runs = rows[rows["run"] >= 0].groupby("run")
    used = rows[rows["used"]].groupby("run")
    first = runs.first()
    count = runs["used"].sum()
    columns = ["motor", "load", "log_ratio", "speed"]
    mean = used[columns].mean().reindex(first.index).fillna(runs[columns].mean())
    bend = first["bend_angle"]
    residual = used["inward"].mean().reindex(first.index)
    reason = runs["code"].agg(lambda codes: REASONS[codes.mode()[0]])
    return pd.DataFrame(
        {
            "stroke": first.index + 1,
            "file": [files[number] for number in first["file"]],
            "direction": np.where(first["way"] > 0, "toward motor", "toward load"),
            "first_line": first["line"],
            "last_line": runs["line"].last(),
            "bend_angle": bend if has_bend else math.nan,
            "rows": runs.size(),
            "used": count,
            "force_motor": mean["motor"],
            "force_load": mean["load"],
            "log_ratio": mean["log_ratio"],
            "friction": friction + residual / bend.where(bend > 0.0),
            "speed": mean["speed"],
            "why_not": reason.where(count == 0, ""),
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
    """Fit μ ∝ speed^p to the strokes. Return None unless they have different speeds."""
    is_known = (strokes["friction"] > 0.0) & (strokes["speed"] > 0.0)
    logs = np.log(strokes.loc[is_known, ["speed", "friction"]].to_numpy())
    speed = logs[:, 0]
    friction = logs[:, 1]
    if len(logs) < _FEWEST or np.ptp(speed) < math.log1p(_SPEEDS):
        return None
    line, covariance = np.polyfit(speed, friction, 1, cov=True)
    slowest, fastest = np.exp([speed.min(), speed.max()])
    return Speed(
        power=float(line[0]),
        standard_error=float(np.sqrt(covariance[0, 0])),
        slowest=float(slowest),
        fastest=float(fastest),
    )


def presliding_of(rows: pd.DataFrame) -> Presliding | None:
    """Find stiffness and backlash after the reversals.

    Both are read from the straight part of the motor's force over its position. Return None without
    a position, or if no reversal has such a part.
    """
    if "position" not in rows:
        return None
    forces = rows["motor"].to_numpy()
    positions = rows["position"].to_numpy()
    ways = rows["way"].to_numpy()
    used = np.flatnonzero(rows["used"])
    slopes = []
    backlashes = []
    for turn in np.flatnonzero(np.diff(ways[used]) != 0):
        reversal = slice(used[turn], used[turn + 1] + 1)
        force = forces[reversal]
        position = positions[reversal]
        share = (force - force[0]) / (force[-1] - force[0] or math.inf)
        straight = (share > _STICK[0]) & (share < _STICK[1])
        if np.count_nonzero(straight) < 3 or np.ptp(position[straight]) == 0.0:
            continue
        slope, intercept = np.polyfit(position[straight], force[straight], 1)
        furthest = position[np.argmax(np.abs(position - position[-1]))]
        slopes.append(float(slope))
        backlashes.append(abs(float((force[0] - intercept) / slope - furthest)))
    if not slopes:
        return None
    return Presliding(abs(float(np.median(slopes))), float(np.median(backlashes)), len(slopes))


def by_file(strokes: pd.DataFrame, files: tuple[str, ...]) -> tuple[dict[str, Any], ...]:
    """Return μ of each file with its standard error; empty if there is only one file.

    μ is the mean of both directions, in which the gain of a file cancels.
    """
    if len(files) == 1:
        return ()
    results = []
    for name in files:
        selected = strokes[(strokes["file"] == name) & strokes["friction"].notna()]
        directions = selected.groupby("direction")["friction"]
        count = directions.size()
        error = math.sqrt(float((directions.var() / count).sum())) / max(len(directions), 1)
        has_error = len(directions) > 0 and count.min() > 1
        results.append(
            {
                "file": name,
                "friction": float(directions.mean().mean()) if len(directions) else None,
                "standard_error": error if has_error else None,
                "strokes": int(count.sum()),
            }
        )
    return tuple(results)


def disagreement(files: tuple[dict[str, Any], ...]) -> list[str]:
    """Return a warning if the files do not agree, by chi-square of their scatter; else none."""
    from scipy.special import chdtrc

    known = [
        (file["friction"], file["standard_error"])
        for file in files
        if file["standard_error"] is not None
    ]
    if len(known) < 2:
        return []
    values, errors = np.array(known).T
    weight = 1.0 / np.maximum(errors, LEAST_SCATTER * np.abs(values)) ** 2
    mean = float(weight @ values / weight.sum())
    chance = float(chdtrc(len(values) - 1, weight @ (values - mean) ** 2))
    if chance >= _BY_CHANCE or np.ptp(values) <= _MATTERS * abs(mean):
        return []
    shown = ", ".join(f"{value:.4g}" for value in values[:6])
    warning = (
        f"the files do not agree, they give {shown}: no single number holds for all;"
        " fit them one by one"
    )
    return [warning]
