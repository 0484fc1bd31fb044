"""Write `excursion.csv` from what other tools say of a joint: an OpenSim file of moment arms, or a MuJoCo model.

    python -m verification.excursions FILE.sto ANGLE FLEXOR EXTENSOR excursion.csv

Moment arms are integrated over the angle (a cubic spline's antiderivative). OpenSim counts them positive if the muscle
turns the coordinate in its positive direction, so an extensor's are negative there; its path lengthens with flexion.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

Array = npt.NDArray[np.float64]


def from_opensim(text: str, angle: str, flexor: str, extensor: str) -> str:
    """The CSV of a storage file (.sto, .mot) that has moment arms (m) in the columns of two muscles over an angle."""
    head, _, table = text.partition("endheader")
    names, *rows = [line.split() for line in table.splitlines() if line.strip()]
    columns = dict(zip(names, np.array(rows, dtype=np.float64).T, strict=True))
    missing = [name for name in (angle, flexor, extensor) if name not in columns]
    if missing:
        raise ValueError(f"no column {missing[0]}, the file has: {', '.join(names)}")
    turned = columns[angle]
    order = np.argsort(turned)
    radians = np.radians(turned) if "indegrees=yes" in head.lower().replace(" ", "") else turned
    at = radians[order]
    shortens = CubicSpline(at, columns[flexor][order]).antiderivative()(at)
    lengthens = CubicSpline(at, -columns[extensor][order]).antiderivative()(at)
    return as_csv(at, shortens, lengthens)


def from_mujoco(model: Any, joint: str, flexor: str, extensor: str, angles: Array) -> str:
    """The CSV of two spatial tendons of a MuJoCo model, by their lengths as one joint turns; needs mujoco."""
    import mujoco  # type: ignore[import-not-found,unused-ignore]

    data, lengths = mujoco.MjData(model), []
    for angle in angles:
        data.joint(joint).qpos[0] = angle
        mujoco.mj_forward(model, data)
        lengths.append([float(data.tendon(name).length[0]) for name in (flexor, extensor)])
    short, long = np.array(lengths).T
    return as_csv(angles, short[0] - short, long - long[0])


def as_csv(angles: Array, shortens: Array, lengthens: Array) -> str:
    """The file that `[joint] excursion` takes."""
    rows = zip(angles.tolist(), shortens.tolist(), lengthens.tolist(), strict=True)
    return "\n".join(["angle (rad),flexor (m),extensor (m)", *(",".join(map(repr, row)) for row in rows)]) + "\n"


if __name__ == "__main__":
    source, *columns, target = sys.argv[1:]
    Path(target).write_text(from_opensim(Path(source).read_text(encoding="utf-8"), *columns), encoding="utf-8")
