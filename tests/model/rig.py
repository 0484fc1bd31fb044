"""A second engine for the same actuator that shares no code and no closed form with the first.

The tension is integrated along the sheath, the geometry comes from rotated vectors, and the spool is turned until the
elbow balances: for a given spool angle each tendon's stretch follows from its own length, its tension from the stretch,
and Brent's method finds the angle at which the moments of both tendons carry the load.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Parameters = Mapping[str, np.ndarray]
SIDES = ("flexor", "extensor")


# --- Sheath ---------------------------------------------------------------------------------------


def even(station):
    """Share of the curvature per share of the sheath, as a function of the share walked from the elbow."""
    return np.ones_like(station)


def walk_along_sheath(friction, bend_angle, toward_elbow, *, profile: Callable = even):
    """Walk from the elbow to the motor with 1 N in hand: tension on arrival, and mean tension on the way.

    `toward_elbow` is true where the tendon is dragged toward the elbow; its tension then rises toward the elbow.
    `profile` spreads the bend over the sheath and integrates to 1.
    """
    toward = np.where(toward_elbow, 1.0, -1.0)
    friction, bend_angle, toward = np.broadcast_arrays(friction, bend_angle, toward)
    rate = (-toward * friction * bend_angle).ravel().astype(float)

    def slope(station, state):
        tension = state[: len(rate)]
        return np.concatenate([rate * profile(station) * tension, tension])

    start = np.concatenate([np.ones_like(rate), np.zeros_like(rate)])
    walk = solve_ivp(
        slope,
        (0.0, 1.0),
        start,
        method="DOP853",
        rtol=1e-13,
        atol=1e-15,
        max_step=0.02,
        t_eval=[1.0],
    )
    tension, mean = walk.y[: len(rate), -1], walk.y[len(rate) :, -1]
    return tension.reshape(friction.shape), mean.reshape(friction.shape)


def compliances(p: Parameters, flexion, *, profile: Callable = even):
    """Per side: proximal over distal tension, and elongation of tendon and of spring per newton at the elbow.

    What gives behind the anchor counts with the spring, which may sit at the motor.
    """
    result = {}
    for side in SIDES:
        toward_elbow = ~np.asarray(flexion) if side == "flexor" else np.asarray(flexion)
        gain, mean = walk_along_sheath(
            p[f"{side}_friction"], p[f"{side}_bend_angle"], toward_elbow, profile=profile
        )
        section = np.pi * (p[f"{side}_diameter"] / 2) ** 2
        tendon = mean * p[f"{side}_length"] / (section * p[f"{side}_youngs_modulus"])
        at_end = np.where(p.get(f"{side}_spring_at_motor", False), gain, 1.0)
        spring = at_end / p[f"{side}_spring_stiffness"] + 1 / p.get(
            f"{side}_anchor_stiffness", np.inf
        )
        result[side] = gain, tendon, spring + 0.0 * tendon
    return result


# --- Geometry -------------------------------------------------------------------------------------


def turned(vector, angle):
    """A vector (forward, up) turned by an angle from down to forward."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


def line_of_action(p, angle):
    """Distance between the flexor's anchors and its moment about the elbow per newton."""
    proximal = np.array([p["a1"], p["b1"]])
    distal = turned((p["a2"], -p["b2"]), angle)
    pull = proximal - distal
    distance = np.hypot(*pull)
    return distance, (distal[0] * pull[1] - distal[1] * pull[0]) / distance


def travels(p, angle):
    """By how much the flexor's path is shorter than its reference and the extensor's longer than at 0."""
    reference = line_of_action(p, 0.0)[0] if p["from_initial"] else p["b1"] + p["b2"]
    return reference - line_of_action(p, angle)[0], p["elbow_radius"] * angle


def weight_moment(p, angle):
    """Moment about the elbow that the weights of forearm and load, and the joint itself, must be held with."""
    total = p.get("joint_stiffness", 0.0) * (angle - p.get("rest_angle", 0.0))
    for mass, distance in (
        (p["forearm_mass"], p["forearm_com"]),
        (p["load_mass"], p["load_distance"]),
    ):
        total += mass * 9.81 * turned((0.0, -distance), angle + p["upper_arm_angle"])[0]
    return total


# --- One state ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Outcome:
    """What the rig shows: None where there is nothing to read."""

    status: str
    flexor: float | None = None
    extensor: float | None = None
    spool_angle: float | None = None
    flexor_slack: float | None = None
    extensor_slack: float | None = None
    loose: float | None = None
    stiffness: float | None = None


@dataclass(frozen=True)
class Bench:
    """One actuator in one direction of motion. `p` holds plain numbers; compliances are per newton at the elbow."""

    p: Mapping[str, float]
    flexor_compliance: float
    extensor_compliance: float

    def stretches(self, spool_angle: float, elbow_angle: float) -> tuple[float, float]:
        """How far both tendons are longer than unstretched, negative where they hang loose."""
        p = self.p
        shorter, longer = travels(p, elbow_angle)
        wound = p["flexor_radius"] * spool_angle
        flexor = self.flexor_compliance * p["flexor_pretension"] + wound - shorter
        extensor = self.extensor_compliance * p["extensor_pretension"] + longer - p["ratio"] * wound
        return flexor, extensor

    def tensions(self, spool_angle: float, elbow_angle: float) -> tuple[float, float]:
        flexor, extensor = self.stretches(spool_angle, elbow_angle)
        if self.p["unilateral"]:
            flexor, extensor = max(flexor, 0.0), max(extensor, 0.0)
        return flexor / self.flexor_compliance, extensor / self.extensor_compliance

    def surplus(self, spool_angle: float, elbow_angle: float) -> float:
        """Moment of both tendons beyond what the weights need; grows with the spool angle."""
        flexor, extensor = self.tensions(spool_angle, elbow_angle)
        moment_arm = line_of_action(self.p, elbow_angle)[1]
        return (
            moment_arm * flexor
            - self.p["elbow_radius"] * extensor
            - weight_moment(self.p, elbow_angle)
        )

    def stiffness(
        self, spool_angle: float, elbow_angle: float, pulling: tuple[bool, bool]
    ) -> float:
        """Moment per radian that the elbow resists with while the motor holds still, by differences of sixth order."""

        def needed(angle):
            flexor, extensor = self.stretches(spool_angle, angle)
            flexor_moment = (
                pulling[0] * line_of_action(self.p, angle)[1] * flexor / self.flexor_compliance
            )
            extensor_moment = (
                pulling[1] * self.p["elbow_radius"] * extensor / self.extensor_compliance
            )
            return weight_moment(self.p, angle) - flexor_moment + extensor_moment

        return derivative(needed, elbow_angle)

    def settle(self, elbow_angle: float) -> Outcome:
        """Turn the spool until the elbow balances."""
        p = self.p
        if not line_of_action(p, elbow_angle)[1] > 0:
            return Outcome("no equilibrium")
        at_rest = self.stretches(0.0, elbow_angle)
        flexor_tightens = -at_rest[0] / p["flexor_radius"]
        extensor_loosens = at_rest[1] / (p["ratio"] * p["flexor_radius"])
        if (
            p["unilateral"]
            and weight_moment(p, elbow_angle) == 0
            and extensor_loosens < flexor_tightens
        ):
            anywhere = (flexor_tightens + extensor_loosens) / 2
            flexor, extensor = self.stretches(anywhere, elbow_angle)
            resistance = self.stiffness(anywhere, elbow_angle, (False, False))
            return Outcome(
                "both slack", 0.0, 0.0, loose=-p["ratio"] * flexor - extensor, stiffness=resistance
            )
        step = 1.0
        low, high = min(flexor_tightens, extensor_loosens), max(flexor_tightens, extensor_loosens)
        while (
            self.surplus(low - step, elbow_angle) > 0 or self.surplus(high + step, elbow_angle) < 0
        ):
            step *= 2
        angle = brentq(
            self.surplus,
            low - step,
            high + step,
            (elbow_angle,),
            xtol=1e-300,
            rtol=1e-15,
            maxiter=500,
        )
        return self._read(angle, elbow_angle)

    def _read(self, angle: float, elbow_angle: float) -> Outcome:
        flexor, extensor = self.stretches(angle, elbow_angle)
        status = {
            (False, False): "taut",
            (True, False): "flexor slack",
            (False, True): "extensor slack",
        }.get((flexor < 0, extensor < 0), "both slack")
        pulling = (flexor >= 0, extensor >= 0) if self.p["unilateral"] else (True, True)
        slack = (max(0.0, -flexor), max(0.0, -extensor)) if self.p["unilateral"] else (None, None)
        loose = self.p["ratio"] * slack[0] + slack[1] if self.p["unilateral"] else None
        resistance = self.stiffness(angle, elbow_angle, pulling)
        return Outcome(status, *self.tensions(angle, elbow_angle), angle, *slack, loose, resistance)


def derivative(function: Callable, at, step: float = 3e-4):
    """Central difference of sixth order."""
    weights = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
    return sum(w * (function(at + n * step) - function(at - n * step)) for n, w in weights) / step


def row(p: Parameters, index: int) -> dict[str, float]:
    """One parameter set of many, as plain numbers."""
    return {name: np.asarray(values)[index].item() for name, values in p.items()}


def run(p: Parameters, elbow_angle, flexion, *, profile: Callable = even) -> list[Outcome]:
    """Settle every parameter set at its own elbow angle; all arrays have one length."""
    sheaths = compliances(p, flexion, profile=profile)
    stiff = {side: tendon + spring for side, (_, tendon, spring) in sheaths.items()}
    return [
        Bench(row(p, i), float(stiff["flexor"][i]), float(stiff["extensor"][i])).settle(
            float(angle)
        )
        for i, angle in enumerate(elbow_angle)
    ]
