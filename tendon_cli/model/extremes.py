"""What designs come to over all their states: smallest, largest, counted. A fold of the rows of states.

A fold starts from `begin`, takes states in any order and in any portions by `fold`, and ends in `finished`, whose
results are the columns of a table of designs. Nothing is rounded on the way but what the rows are, so that the columns
are the extremes of the rows to the last bit.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from tendon_cli.model import statics
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import contact_pressure, spool_to_tendon

Found = dict[str, Array]
"""Over designs, by name."""

_SMALLEST = (
    "min_flexor_tension", "min_extensor_tension", "min_elbow_stiffness", "first_slack_angle", "margin",
    "lowest_elbow_torque", "lowest_motor_torque",
)  # fmt: skip
_LARGEST = (
    "max_tension", "max_extensor_distal", "max_spring_extension", "max_slack", "required_pretension",
    "highest_elbow_torque", "highest_motor_torque",
)  # fmt: skip
COUNTS = ("slack", "no_equilibrium", "unstable")


def begin(shape: tuple[int, ...]) -> Found:
    """Nothing found yet, for designs of a shape; other axes or angles of the same designs may be folded in turn."""
    starts = dict.fromkeys(_SMALLEST, np.inf) | dict.fromkeys(_LARGEST, -np.inf) | dict.fromkeys(COUNTS, 0.0)
    return {name: np.full(shape, start) for name, start in starts.items()}


def fold(found: Found, state: State, elbow_angle: Array) -> None:
    """Take in states, whose last two axes are directions and elbow angles (rad); the others are those of `found`."""
    at, balance, status = state.situation, state.balance, state.status
    slack = (status > statics.TAUT) & (status < statics.NO_EQUILIBRIUM)
    flexor, extensor = balance.flexor, balance.extensor
    smaller = np.minimum(at.design.flexor.pretension, at.design.extensor.pretension)
    values = {
        "min_flexor_tension": (flexor, state.flexor_tension_proximal),
        "min_extensor_tension": (extensor, state.extensor_tension_proximal),
        "max_tension": (flexor, extensor, state.flexor_tension_proximal, state.extensor_tension_proximal),
        "max_extensor_distal": (extensor,),
        "max_spring_extension": (flexor * at.flexor.spring, extensor * at.extensor.spring),
        "max_slack": (state.flexor_slack, state.extensor_slack),
        "lowest_elbow_torque": (state.elbow_torque,),
        "highest_elbow_torque": (state.elbow_torque,),
        "lowest_motor_torque": (state.motor_torque,),
        "highest_motor_torque": (state.motor_torque,),
        "min_elbow_stiffness": (state.elbow_stiffness,),
        "first_slack_angle": (np.where(slack, elbow_angle, np.nan),),
        "required_pretension": (balance.shortfall,),
        "margin": (balance.surplus, smaller),
        "slack": (slack,),
        "no_equilibrium": (status == statics.NO_EQUILIBRIUM,),
        "unstable": (state.elbow_stiffness < 0.0,),
    }
    for name, result in found.items():
        for value in values[name]:
            _take(name, result, np.asarray(value), status.shape[-2:])


def _take(name: str, found: Array, value: npt.NDArray[np.generic], states: tuple[int, ...]) -> None:
    """Fold one value of each state into what was found."""
    whole = np.broadcast_to(value, (*found.shape, *states))
    if name in COUNTS:
        found += np.add.reduce(whole, axis=(-2, -1), dtype=np.float64)
        return
    ufunc = np.fmin if name in _SMALLEST else np.fmax
    ufunc(found, ufunc.reduce(whole, axis=(-2, -1)), out=found)


def finished(found: Found, states: int) -> Found:
    """The result columns of designs, from the extremes over all `states` of each; NaN where no state has a result."""
    unanswerable, failing = found["no_equilibrium"] > 0, found["slack"] + found["no_equilibrium"]
    known = {name: np.where(np.isinf(found[name]), np.nan, found[name]) for name in (*_SMALLEST, *_LARGEST)}
    columns = {name: values for name, values in known.items() if not name.endswith(("_torque", "_distal"))} | {
        "peak_elbow_torque": _with_sign(known["lowest_elbow_torque"], known["highest_elbow_torque"]),
        "peak_motor_torque": _with_sign(known["lowest_motor_torque"], known["highest_motor_torque"]),
        "slack_fraction": failing / states,
        "unstable_fraction": found["unstable"] / states,
        "required_pretension": np.where(unanswerable, np.nan, np.maximum(0.0, known["required_pretension"])),
        "margin": np.where(unanswerable, np.nan, known["margin"]),
    }
    # Minus zero becomes zero: which of the two is the smallest depends on the order in which states are taken.
    return {name: values + 0.0 for name, values in columns.items()}


def judged(columns: Found, limits: Mapping[str, float]) -> dict[str, npt.NDArray[np.bool_]]:
    """Which designs are taut in every state, stable in each, and within every limit on a column as well, SI.

    A limit bounds the column of its name: from below (min_), above (max_) or in magnitude (peak_), with the tolerance
    of slack. Limits on what `columns` have not are left out, and what is no number keeps them.
    """
    taut, stable = columns["slack_fraction"] == 0.0, ~(columns["min_elbow_stiffness"] < limits["min_elbow_stiffness"])
    feasible = taut & stable
    for name, limit in limits.items():
        if name in columns and name != "min_elbow_stiffness":
            beyond = limit - columns[name] if name.startswith("min_") else np.abs(columns[name]) - limit
            feasible = feasible & ~(beyond > statics.SLACK_TOLERANCE * abs(limit))
    return {"taut": taut, "stable": stable, "feasible": feasible}


def of_design(design: Design, found: Found) -> Found:
    """What limits bound of designs that no state has: the pretension, contact pressure (Pa), and spool over tendon."""
    values = {
        "max_pretension": np.maximum(design.flexor.pretension, design.extensor.pretension),
        "max_contact_pressure": contact_pressure(design, found["max_extensor_distal"][..., np.newaxis, np.newaxis]),
        "min_spool_to_tendon": spool_to_tendon(design),
    }
    shape = found["slack"].shape
    return {name: np.broadcast_to(value, (*shape, 1, 1))[..., 0, 0] for name, value in values.items()}


def _with_sign(lowest: Array, highest: Array) -> Array:
    """Of two values the one of larger magnitude, with its sign."""
    return np.where(-lowest > highest, lowest, highest)
