"""Write `excursion.csv` from a joint of another tool: OpenSim's moment arms, or a MuJoCo model.

    python -m verification.excursions FILE.sto ANGLE FLEXOR EXTENSOR excursion.csv

Without arguments, compare tendon with MuJoCo on random joints whose tendons wrap a ball and a drum,
and which tendon reads from such a file: the moment arms must be those that MuJoCo finds by itself,
and tendon's tensions must balance its joint.

Moment arms are integrated over the angle (a cubic spline's antiderivative). OpenSim counts them
positive if the muscle turns the coordinate in its positive direction, so an extensor's are negative
there; its path lengthens with flexion.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

Array = npt.NDArray[np.float64]

_LARGEST_ARM = 0.15
"""Largest moment arm of a muscle or a tendon that is taken for one, m: those at a hip reach 0.1."""


def from_opensim(text: str, angle: str, flexor: str, extensor: str) -> str:
    """Return the CSV of an OpenSim storage file (.sto, .mot) of moment arms (m) over an angle.

    Args:
        text: Content of the file.
        angle: Column of the angle.
        flexor: Column of the flexor's moment arm.
        extensor: Column of the extensor's moment arm.

    Raises:
        ValueError: A column is missing, or does not hold the moment arms of its muscle.
    """
    head, _, table = text.partition("endheader")
    lines = [line.split() for line in table.splitlines() if line.strip()]
    if len(lines) < 3:
        raise ValueError("no table of two rows or more after a line `endheader`")
    names, *rows = lines
    if any(len(row) != len(names) for row in rows):
        raise ValueError(f"a row has not one number for each of {len(names)} columns")
    columns = dict(zip(names, np.array(rows, dtype=np.float64).T, strict=True))
    missing = [name for name in (angle, flexor, extensor) if name not in columns]
    if missing:
        raise ValueError(f"no column {missing[0]}, the file has: {', '.join(names)}")
    order = np.argsort(columns[angle])
    angles = columns[angle][order]
    is_in_degrees = "indegrees=yes" in head.lower().replace(" ", "")
    if is_in_degrees:
        angles = np.radians(angles)
    flexor_arm = columns[flexor][order]
    extensor_arm = columns[extensor][order]
    _check_moment_arms(flexor, flexor_arm)
    _check_moment_arms(extensor, extensor_arm)
    if not flexor_arm.mean() > 0.0 > extensor_arm.mean():
        raise ValueError(
            f"a flexor's moment arms are positive and an extensor's negative, on average; "
            f"those of {flexor} are {flexor_arm.mean():.3g} m and those of {extensor} "
            f"{extensor_arm.mean():.3g} m: name the flexor first, or turn the angle's sign"
        )
    shortens = CubicSpline(angles, flexor_arm).antiderivative()(angles)
    lengthens = CubicSpline(angles, -extensor_arm).antiderivative()(angles)
    return as_csv(angles, shortens, lengthens)


def _check_moment_arms(column: str, values: Array) -> None:
    """Raise ValueError if the values of a column, m, are no moment arms, such as lengths."""
    largest = float(np.abs(values).max())
    if not largest <= _LARGEST_ARM:
        raise ValueError(
            f"{column} reaches {largest:.3g} m, which no moment arm does (at most "
            f"{_LARGEST_ARM:g} m): is this the file of lengths? OpenSim's MuscleAnalysis writes "
            f"moment arms to a file of their own, *_MomentArm_*.sto, in metres"
        )


def from_mujoco(model: Any, joint: str, flexor: str, extensor: str, angles: Array) -> str:
    """Return the CSV of two spatial tendons of a MuJoCo model, by their lengths as a joint turns.

    Args:
        model: The `MjModel`.
        joint: Name of the joint.
        flexor: Name of the flexor.
        extensor: Name of the extensor.
        angles: Angles of the joint, rad.
    """
    import mujoco  # type: ignore[import-not-found,unused-ignore]

    data = mujoco.MjData(model)
    lengths = []
    for angle in angles:
        data.joint(joint).qpos[0] = angle
        mujoco.mj_forward(model, data)
        lengths.append([float(data.tendon(name).length[0]) for name in (flexor, extensor)])
    flexor_length, extensor_length = np.array(lengths).T
    shortens = flexor_length[0] - flexor_length
    lengthens = extensor_length - extensor_length[0]
    return as_csv(angles, shortens, lengthens)


def as_csv(angles: Array, shortens: Array, lengthens: Array) -> str:
    """Return the content of a file for `[joint] excursion`.

    Args:
        angles: Angles of the joint, rad.
        shortens: Length by which the flexor's path has become shorter, m.
        lengthens: Length by which the extensor's path has become longer, m.
    """
    head = "angle (rad),flexor (m),extensor (m)"
    rows = zip(angles.tolist(), shortens.tolist(), lengthens.tolist(), strict=True)
    lines = [",".join(map(repr, row)) for row in rows]
    return "\n".join([head, *lines]) + "\n"


# --- Against MuJoCo -------------------------------------------------------------------------------

_JOINTS = 20
_ROWS = 400
"""Rows of the file of a joint."""
_SEED = 7
_TOLERANCE = 1e-4
_MODEL = """
<mujoco><compiler angle="radian"/><option gravity="0 0 -9.81"/>
 <worldbody><body>
  <site name="r" pos="{r[0]} 0 {r[1]}"/><site name="front" pos="0.2 0 0"/>
  <site name="p" pos="{p[0]} 0 {p[1]}"/><site name="back" pos="-0.2 0 0"/>
  <geom name="ball" type="sphere" size="{ball[0]}" pos="{ball[1]} 0 {ball[2]}"
   contype="0" conaffinity="0" mass="0"/>
  <geom name="drum" type="cylinder" size="{drum[0]} 0.05" pos="{drum[1]} 0 {drum[2]}"
   euler="1.570796326794897 0 0" contype="0" conaffinity="0" mass="0"/>
  <body><joint name="joint" type="hinge" axis="0 -1 0"/>
   <geom type="capsule" size="0.02" fromto="0 0 0 0 0 {length}" mass="{mass}"
    contype="0" conaffinity="0"/>
   <site name="q" pos="{q[0]} 0 {q[1]}"/><site name="s" pos="{s[0]} 0 {s[1]}"/>
  </body></body></worldbody>
 <tendon>
  <spatial name="flexor"><site site="r"/><geom geom="ball" sidesite="front"/><site site="q"/>
  </spatial>
  <spatial name="extensor"><site site="p"/><geom geom="drum" sidesite="back"/><site site="s"/>
  </spatial>
 </tendon></mujoco>"""


# Positions (m) near which the sites are drawn, and radius and position of the bodies wrapped
_SITES = {"r": (0.045, 0.2), "p": (-0.03, 0.18), "q": (0.03, -0.1), "s": (-0.02, -0.05)}
_WRAPPED = {"ball": (0.03, 0.03, 0.04), "drum": (0.028, -0.006, 0.004)}


def _draw_joint(rng: np.random.Generator) -> dict[str, Any]:
    """Draw anchors before and behind both links, a ball and a drum at the axis, and a weight."""
    sites = {name: np.array(place) * rng.uniform(0.85, 1.15, 2) for name, place in _SITES.items()}
    sizes = {name: np.array(size) * rng.uniform(0.85, 1.15, 3) for name, size in _WRAPPED.items()}
    return {**sites, **sizes, "mass": rng.uniform(0.8, 2.5), "length": -rng.uniform(0.2, 0.4)}


def _errors(joint: dict[str, Any]) -> tuple[float, float, int]:
    """Compare tendon with MuJoCo on a joint.

    Returns:
        Largest errors of the moment arms and of the balance, as shares, and the number of angles
        at which the ball wraps.
    """
    import mujoco

    import tendon_cli as tendon

    model = mujoco.MjModel.from_xml_string(_MODEL.format(**joint))
    angles = np.linspace(-0.4, 1.5, _ROWS)
    table = from_mujoco(model, "joint", "flexor", "extensor", angles).splitlines()[1:]
    columns = np.array([row.split(",") for row in table], dtype=np.float64).T.tolist()
    excursion = dict(zip(("angle", "flexor", "extensor"), columns, strict=True))
    excursion["angle"] = [f"{value!r} rad" for value in excursion["angle"]]
    study = {
        "joint": {"excursion": excursion},
        "arm": {"forearm_mass": joint["mass"], "forearm_com": -0.5 * joint["length"]},
        "tendon": {"pretension": "300 N"},
        "spool": {"ratio": 0.5},
        "motion": {
            "direction": "flexion",
            "elbow_angle": [f"{angle!r} rad" for angle in (-0.3, 0.0, 0.7, 1.1, 1.4)],
        },
    }
    data = mujoco.MjData(model)
    arm_error = 0.0
    balance_error = 0.0
    wraps = 0
    for state in tendon.sweep(study).states.itertuples():
        data.joint("joint").qpos[0] = state.elbow_angle
        mujoco.mj_forward(model, data)
        jacobian = data.ten_J.ravel()
        flexor_arm = -float(jacobian[0])
        extensor_arm = float(jacobian[1])
        arm_error = max(arm_error, abs(state.flexor_moment_arm / flexor_arm - 1.0))
        flexion = flexor_arm * state.flexor_tension_distal
        extension = extensor_arm * state.extensor_tension_distal
        left_over = abs(flexion - extension - float(data.qfrc_bias[0]))
        balance_error = max(balance_error, left_over / max(flexion, extension))
        wraps += int(data.ten_wrapnum[0] > 2)
    return arm_error, balance_error, wraps


def _compare() -> int:
    """Compare random joints and print; return the exit code."""
    try:
        import mujoco
    except (ImportError, OSError) as reason:
        sys.stdout.write(
            f"skipped, nothing was compared: MuJoCo cannot be loaded here ({reason})\n"
        )
        return 0
    rng = np.random.default_rng(_SEED)
    errors = np.array([_errors(_draw_joint(rng)) for _ in range(_JOINTS)])
    arm_errors, balance_errors, wraps = errors.T
    holds = max(arm_errors.max(), balance_errors.max()) < _TOLERANCE
    sys.stdout.write(
        f"{_JOINTS} joints with curved wrapping (seed {_SEED}), tables of {_ROWS} rows, "
        f"against MuJoCo {mujoco.__version__}:\n"
        f"largest error of a moment arm {arm_errors.max():.1e}, "
        f"of the balance with tendon's tensions {balance_errors.max():.1e} "
        f"(tolerance {_TOLERANCE:g}); the ball wraps at {wraps.sum():.0f} "
        f"of {5 * _JOINTS} angles\n"
        f"{'All hold.' if holds else 'MISSED.'}\n"
    )
    return 0 if holds else 1


def main(words: list[str]) -> int:
    """Write a file of excursions, or compare with MuJoCo; return the exit code."""
    if not words:
        return _compare()
    if len(words) != 5:
        return _refused("give FILE.sto, columns ANGLE FLEXOR EXTENSOR, and a file to write")
    source, *columns, target = words
    try:
        content = from_opensim(Path(source).read_text(encoding="utf-8"), *columns)
        Path(target).write_text(content, encoding="utf-8")
    except (OSError, ValueError) as error:
        return _refused(str(error))
    return 0


def _refused(problem: str) -> int:
    """Say what is wrong with the arguments or the file; return the exit code."""
    sys.stderr.write(f"error: {problem}\n")
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
