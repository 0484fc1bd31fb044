"""Write `excursion.csv` from what other tools say of a joint: an OpenSim file of moment arms, or a MuJoCo model.

    python -m verification.excursions FILE.sto ANGLE FLEXOR EXTENSOR excursion.csv

Without arguments, compare tendon with MuJoCo on random joints whose tendons wrap a ball and a drum, which are read by
way of such a file: the moment arms that MuJoCo takes by itself, and whether tendon's tensions balance its joint.

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
    return (
        "\n".join(
            ["angle (rad),flexor (m),extensor (m)", *(",".join(map(repr, row)) for row in rows)]
        )
        + "\n"
    )


# --- Against MuJoCo --------------------------------------------------------------------------------------------------

_JOINTS, _ROWS, _SEED, _TOLERANCE = 20, 400, 7, 1e-4
_MODEL = """
<mujoco><compiler angle="radian"/><option gravity="0 0 -9.81"/>
 <worldbody><body>
  <site name="r" pos="{r[0]} 0 {r[1]}"/><site name="front" pos="0.2 0 0"/><site name="p" pos="{p[0]} 0 {p[1]}"/>
  <site name="back" pos="-0.2 0 0"/>
  <geom name="ball" type="sphere" size="{ball[0]}" pos="{ball[1]} 0 {ball[2]}" contype="0" conaffinity="0" mass="0"/>
  <geom name="drum" type="cylinder" size="{drum[0]} 0.05" pos="{drum[1]} 0 {drum[2]}" euler="1.570796326794897 0 0"
   contype="0" conaffinity="0" mass="0"/>
  <body><joint name="joint" type="hinge" axis="0 -1 0"/>
   <geom type="capsule" size="0.02" fromto="0 0 0 0 0 {length}" mass="{mass}" contype="0" conaffinity="0"/>
   <site name="q" pos="{q[0]} 0 {q[1]}"/><site name="s" pos="{s[0]} 0 {s[1]}"/></body></body></worldbody>
 <tendon>
  <spatial name="flexor"><site site="r"/><geom geom="ball" sidesite="front"/><site site="q"/></spatial>
  <spatial name="extensor"><site site="p"/><geom geom="drum" sidesite="back"/><site site="s"/></spatial>
 </tendon></mujoco>"""


def _drawn(rng: np.random.Generator) -> dict[str, Any]:
    """A joint: anchors before and behind both links, a ball and a drum beside its axis, what hangs on it."""
    near = {"r": (0.045, 0.2), "p": (-0.03, 0.18), "q": (0.03, -0.1), "s": (-0.02, -0.05)}
    sites = {name: np.array(at) * rng.uniform(0.85, 1.15, 2) for name, at in near.items()}
    wrapped = {"ball": (0.03, 0.03, 0.04), "drum": (0.028, -0.006, 0.004)}
    sizes = {name: np.array(at) * rng.uniform(0.85, 1.15, 3) for name, at in wrapped.items()}
    return {**sites, **sizes, "mass": rng.uniform(0.8, 2.5), "length": -rng.uniform(0.2, 0.4)}


def _difference(drawn: dict[str, Any]) -> tuple[float, float, int]:
    """Largest errors of moment arms and of the balance, as shares, and at how many angles the ball wraps."""
    import mujoco

    import tendon_cli as tendon

    model = mujoco.MjModel.from_xml_string(_MODEL.format(**drawn))
    angles = np.linspace(-0.4, 1.5, _ROWS)
    table = from_mujoco(model, "joint", "flexor", "extensor", angles).splitlines()[1:]
    columns = np.array([row.split(",") for row in table], dtype=np.float64).T.tolist()
    excursion = dict(zip(("angle", "flexor", "extensor"), columns, strict=True))
    excursion["angle"] = [f"{value!r} rad" for value in excursion["angle"]]
    states = tendon.sweep(
        {
            "joint": {"excursion": excursion},
            "arm": {"forearm_mass": drawn["mass"], "forearm_com": -0.5 * drawn["length"]},
            "tendon": {"pretension": "300 N"},
            "spool": {"ratio": 0.5},
            "motion": {
                "direction": "flexion",
                "elbow_angle": [f"{angle!r} rad" for angle in (-0.3, 0.0, 0.7, 1.1, 1.4)],
            },
        }
    ).states
    data, arms, left, wraps = mujoco.MjData(model), 0.0, 0.0, 0
    for state in states.itertuples():
        data.joint("joint").qpos[0] = state.elbow_angle
        mujoco.mj_forward(model, data)
        flexor, extensor = -float(data.ten_J.ravel()[0]), float(data.ten_J.ravel()[1])
        arms = max(arms, abs(state.flexor_moment_arm / flexor - 1.0))
        moments = flexor * state.flexor_tension_distal, extensor * state.extensor_tension_distal
        left = max(left, abs(moments[0] - moments[1] - float(data.qfrc_bias[0])) / max(moments))
        wraps += int(data.ten_wrapnum[0] > 2)
    return arms, left, wraps


def _compare() -> int:
    """Compare, print; the exit code."""
    try:
        import mujoco
    except (ImportError, OSError) as reason:
        sys.stdout.write(
            f"skipped, nothing was compared: MuJoCo cannot be loaded here ({reason})\n"
        )
        return 0
    rng = np.random.default_rng(_SEED)
    arms, left, wraps = np.array([_difference(_drawn(rng)) for _ in range(_JOINTS)]).T
    holds = max(arms.max(), left.max()) < _TOLERANCE
    sys.stdout.write(
        f"{_JOINTS} joints with curved wrapping (seed {_SEED}), tables of {_ROWS} rows, "
        f"against MuJoCo {mujoco.__version__}:\n"
        f"largest error of a moment arm {arms.max():.1e}, of the balance with tendon's tensions {left.max():.1e} "
        f"(tolerance {_TOLERANCE:g}); the ball wraps at {wraps.sum():.0f} of {5 * _JOINTS} angles\n"
        f"{'All hold.' if holds else 'MISSED.'}\n"
    )
    return 0 if holds else 1


if __name__ == "__main__":
    if len(sys.argv) == 1:
        sys.exit(_compare())
    source, *columns, target = sys.argv[1:]
    Path(target).write_text(
        from_opensim(Path(source).read_text(encoding="utf-8"), *columns), encoding="utf-8"
    )
