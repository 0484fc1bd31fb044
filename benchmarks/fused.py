"""Compile `fused.c` with the system's C compiler, and call it from threads.

It computes the designs of `studies.designs_study`, or the windows of a study without an axis of
pretension. Its tables by angle and by friction are made here with NumPy; the call lets go of the
interpreter's lock.
"""

from __future__ import annotations

import ctypes
import subprocess
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from benchmarks.expert import ELBOW, GRAVITY, LOAD_AT, SPOOL, WEIGHT, WEIGHT_AT, geometry, sheath
from benchmarks.measure import Took, in_threads

if TYPE_CHECKING:
    from tendon_cli.engine.plan import Plan

OPTIONS = ("-O3", "-march=native", "-ffast-math")
RESULTS = (
    "min_flexor_tension",
    "min_extensor_tension",
    "max_tension",
    "max_spring_extension",
    "peak_elbow_torque",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_slack",
    "slack_fraction",
    "unstable_fraction",
    "first_slack_angle",
    "required_pretension",
    "margin",
    "taut",
)
LEFT_OUT = ("max_contact_pressure", "min_spool_to_tendon", "pretension_from", "pretension_to")
"""Columns of the designs table that the loop does not compute; tendon does, in the same time."""

WINDOWS = ("pretension_from", "pretension_to")

AXES = ("tendon.pretension", "spring.stiffness", "spool.ratio", "sheath.friction", "load.mass")
MOST_ANGLES = 1016  # as in fused.c

Array = npt.NDArray[np.float64]
_LENGTHS = ("pretensions", "springs", "ratios", "frictions", "loads", "angles", "without")
_TABLES = (
    "pretension",
    "spring",
    "ratio",
    "load_moment",
    "angle",
    "arm",
    "arm_slope",
    "flexor_travel",
    "extensor_travel",
    "sine",
    "cosine",
    "capstan",
    "tendon",
    "out",
)


class _Study(ctypes.Structure):
    """`Study` of `fused.c`."""

    _fields_ = (
        *((name, ctypes.c_long) for name in _LENGTHS),
        ("elbow_radius", ctypes.c_double),
        ("flexor_radius", ctypes.c_double),
        *((name, ctypes.c_void_p) for name in _TABLES),
    )


class Fused:
    """Loop over the designs of a plan, or over their windows if pretension is no axis.

    Args:
        plan: Plan whose axes are `AXES`, with or without the first; all else is the default.
        folder: Folder for the compiled loop.
    """

    def __init__(self, plan: Plan, folder: Path) -> None:
        keys = tuple(axis.key for axis in plan.axes)
        if keys not in (AXES, AXES[1:]):
            raise ValueError(f"the loop is written for the axes {', '.join(AXES)}")
        values = [np.array(axis.values, dtype=np.float64) for axis in plan.axes]
        if keys == AXES:
            self.results = RESULTS
            self._function = _compiled(folder, "sweep")
        else:
            self.results = WINDOWS
            self._function = _compiled(folder, "windows")
            values = [np.zeros(1), *values]
        self._combinations = plan.designs // len(values[0])
        self.out = np.zeros((len(self.results), plan.designs))
        self._tables = _tables(values, plan.elbow_angles) | {"out": self.out}
        angles = len(self._tables["angle"])
        if angles > MOST_ANGLES:
            raise ValueError(f"the loop has room for {MOST_ANGLES} angles")
        counts = (*map(len, values), angles, plan.states_per_design - 2 * angles)
        pointers = {name: array.ctypes.data for name, array in self._tables.items()}
        self._study = _Study(
            **dict(zip(_LENGTHS, counts, strict=True)),
            elbow_radius=ELBOW,
            flexor_radius=SPOOL,
            **pointers,
        )

    def run(self, threads: int) -> Took:
        """Compute all designs in some threads."""
        ends = [self._combinations * thread // threads for thread in range(threads + 1)]
        study = ctypes.byref(self._study)
        return in_threads(
            partial(self._function, study, start, stop) for start, stop in pairwise(ends)
        )

    def columns(self) -> dict[str, Array]:
        """Return the columns of results, `RESULTS` or `WINDOWS`, by name."""
        return dict(zip(self.results, self.out, strict=True))


def _compiled(folder: Path, name: str) -> ctypes._NamedFuncPointer:
    """Compile the loop, and return one of its functions."""
    source = Path(__file__).with_name("fused.c")
    loop = folder / "fused.o"
    library = folder / "fused.so"
    subprocess.run(["cc", *OPTIONS, "-fPIC", "-c", "-o", loop, source], check=True)
    # Linked without these options, or loading it would have the whole process take the smallest
    # numbers for nought.
    subprocess.run(["cc", "-shared", "-o", library, loop, "-lm"], check=True)
    function = getattr(ctypes.CDLL(str(library)), name)
    function.argtypes = (ctypes.POINTER(_Study), ctypes.c_long, ctypes.c_long)
    function.restype = None
    return function


def _tables(values: list[Array], angle: Array) -> dict[str, Array]:
    """Return the axes, and the numbers that the loop looks up by angle and by friction.

    Only angles with a positive moment arm are kept. By friction the flexor comes before the
    extensor, as they are in flexion.
    """
    pretension, spring, ratio, friction, load = values
    flexor_travel, extensor_travel, arm, slope = geometry(angle)
    has_arm = arm > 0
    by_angle = {
        "angle": angle,
        "arm": arm,
        "arm_slope": slope,
        "flexor_travel": flexor_travel,
        "extensor_travel": extensor_travel,
        "sine": np.sin(angle),
        "cosine": np.cos(angle),
    }
    capstan, tendon = sheath(np.array([-1.0, 1.0]), friction[:, np.newaxis])
    return {
        "pretension": pretension,
        "spring": spring,
        "ratio": ratio,
        "load_moment": GRAVITY * (WEIGHT * WEIGHT_AT + load * LOAD_AT),
        "capstan": np.ascontiguousarray(capstan),
        "tendon": np.ascontiguousarray(tendon),
        **{name: np.ascontiguousarray(column[has_arm]) for name, column in by_angle.items()},
    }
