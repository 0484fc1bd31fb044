"""A second engine for the same actuator that shares no code and no closed form with the first.

The tension is integrated along the sheath, the geometry comes from rotated vectors, and the spool
is turned until the elbow balances: for a given spool angle each tendon's stretch follows from its
own length, its tension from the stretch, and Brent's method finds the angle at which the moments of
both tendons carry the load.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

Parameters = Mapping[str, np.ndarray]
SIDES = ("flexor", "extensor")

STATUS = {
    (False, False): "taut",
    (True, False): "flexor slack",
    (False, True): "extensor slack",
    (True, True): "both slack",
}
"""Status by whether flexor and extensor are shorter than unstretched."""

CENTRAL_WEIGHTS = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
"""Number of steps and weight of a central difference of sixth order."""


# --- Sheath ---------------------------------------------------------------------------------------


def even(station):
    """Return the share of the curvature per share of the sheath, walked from the elbow."""
    return np.ones_like(station)


def walk_along_sheath(friction, bend_angle, toward_elbow, *, profile: Callable = even):
    """Walk from the elbow to the motor with 1 N in hand.

    Args:
        friction: Coefficient of friction.
        bend_angle: Total bend, rad.
        toward_elbow: True where the tendon is dragged toward the elbow; its tension then rises
            toward the elbow.
        profile: Spreads the bend over the sheath and integrates to 1.

    Returns:
        Tension on arrival, and mean tension on the way, N.
    """
    toward = np.where(toward_elbow, 1.0, -1.0)
    friction, bend_angle, toward = np.broadcast_arrays(friction, bend_angle, toward)
    rate = (-toward * friction * bend_angle).ravel().astype(float)
    count = len(rate)

    def slope(station, state):
        tension = state[:count]
        return np.concatenate([rate * profile(station) * tension, tension])

    start = np.concatenate([np.ones_like(rate), np.zeros_like(rate)])
    accuracy = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "max_step": 0.02}
    walk = solve_ivp(slope, (0.0, 1.0), start, t_eval=[1.0], **accuracy)
    arrival = walk.y[:, -1]
    tension = arrival[:count]
    mean = arrival[count:]
    return tension.reshape(friction.shape), mean.reshape(friction.shape)


def compliances(p: Parameters, flexion, *, profile: Callable = even):
    """Return proximal over distal tension, compliance of tendon and of spring, for each side.

    Compliances are elongations per newton at the elbow. The anchor's counts with the spring, which
    may sit at the motor.
    """
    flexion = np.asarray(flexion)
    toward_elbow = {"flexor": ~flexion, "extensor": flexion}
    result = {}
    for side in SIDES:
        friction = p[f"{side}_friction"]
        bend_angle = p[f"{side}_bend_angle"]
        gain, mean = walk_along_sheath(friction, bend_angle, toward_elbow[side], profile=profile)
        section = np.pi * (p[f"{side}_diameter"] / 2) ** 2
        tendon = mean * p[f"{side}_length"] / (section * p[f"{side}_youngs_modulus"])
        at_end = np.where(p.get(f"{side}_spring_at_motor", False), gain, 1.0)
        anchor = 1 / p.get(f"{side}_anchor_stiffness", np.inf)
        spring = at_end / p[f"{side}_spring_stiffness"] + anchor
        result[side] = gain, tendon, spring + 0.0 * tendon
    return result


# --- Geometry -------------------------------------------------------------------------------------


def turned(vector, angle):
    """Turn a vector (forward, up) by an angle from down to forward."""
    forward, up = vector
    cosine = np.cos(angle)
    sine = np.sin(angle)
    return np.array([cosine * forward - sine * up, sine * forward + cosine * up])


def line_of_action(p, angle):
    """Return the distance between the flexor's anchors and the flexor's moment arm."""
    proximal = np.array([p["a1"], p["b1"]])
    distal = turned((p["a2"], -p["b2"]), angle)
    pull = proximal - distal
    distance = np.hypot(*pull)
    return distance, (distal[0] * pull[1] - distal[1] * pull[0]) / distance


def travels(p, angle):
    """Return the shortening of the flexor's path and the lengthening of the extensor's.

    The flexor's counts from its reference, the extensor's from the straight arm.
    """
    reference = line_of_action(p, 0.0)[0] if p["from_initial"] else p["b1"] + p["b2"]
    return reference - line_of_action(p, angle)[0], p["elbow_radius"] * angle


def weight_moment(p, angle):
    """Return the moment that holds the elbow against forearm, load, and the joint itself."""
    total = p.get("joint_stiffness", 0.0) * (angle - p.get("rest_angle", 0.0))
    for mass, distance in (("forearm_mass", "forearm_com"), ("load_mass", "load_distance")):
        forward = turned((0.0, -p[distance]), angle + p["upper_arm_angle"])[0]
        total += p[mass] * 9.81 * forward
    return total


# --- One state ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Outcome:
    """A state as read off the rig; None if there is nothing to read."""

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
    """One actuator in one direction of motion.

    `p` holds plain numbers; compliances are per newton at the elbow.
    """

    p: Mapping[str, float]
    flexor_compliance: float
    extensor_compliance: float

    def stretches(self, spool_angle: float, elbow_angle: float) -> tuple[float, float]:
        """Return the elongation of both tendons, negative where they hang loose."""
        p = self.p
        shorter, longer = travels(p, elbow_angle)
        wound = p["flexor_radius"] * spool_angle
        flexor = self.flexor_compliance * p["flexor_pretension"] + wound - shorter
        extensor = self.extensor_compliance * p["extensor_pretension"] + longer - p["ratio"] * wound
        return flexor, extensor

    def tensions(self, spool_angle: float, elbow_angle: float) -> tuple[float, float]:
        """Return the tensions of flexor and extensor at the elbow."""
        flexor, extensor = self.stretches(spool_angle, elbow_angle)
        if self.p["unilateral"]:
            flexor = max(flexor, 0.0)
            extensor = max(extensor, 0.0)
        return flexor / self.flexor_compliance, extensor / self.extensor_compliance

    def surplus(self, spool_angle: float, elbow_angle: float) -> float:
        """Return the moment of both tendons beyond what the weights need.

        It grows with the spool angle.
        """
        flexor, extensor = self.tensions(spool_angle, elbow_angle)
        flexor_moment = line_of_action(self.p, elbow_angle)[1] * flexor
        extensor_moment = self.p["elbow_radius"] * extensor
        return flexor_moment - extensor_moment - weight_moment(self.p, elbow_angle)

    def stiffness(
        self, spool_angle: float, elbow_angle: float, pulling: tuple[bool, bool]
    ) -> float:
        """Return the elbow's stiffness with the motor held, by differences of sixth order."""
        flexor_pulls, extensor_pulls = pulling

        def needed(angle):
            flexor, extensor = self.stretches(spool_angle, angle)
            flexor_arm = flexor_pulls * line_of_action(self.p, angle)[1]
            extensor_arm = extensor_pulls * self.p["elbow_radius"]
            flexor_moment = flexor_arm * flexor / self.flexor_compliance
            extensor_moment = extensor_arm * extensor / self.extensor_compliance
            return weight_moment(self.p, angle) - flexor_moment + extensor_moment

        return derivative(needed, elbow_angle)

    def settle(self, elbow_angle: float) -> Outcome:
        """Turn the spool until the elbow balances."""
        p = self.p
        if not line_of_action(p, elbow_angle)[1] > 0:
            return Outcome("no equilibrium")
        flexor_at_rest, extensor_at_rest = self.stretches(0.0, elbow_angle)
        flexor_tightens = -flexor_at_rest / p["flexor_radius"]
        extensor_loosens = extensor_at_rest / (p["ratio"] * p["flexor_radius"])
        weightless = weight_moment(p, elbow_angle) == 0
        if p["unilateral"] and weightless and extensor_loosens < flexor_tightens:
            anywhere = (flexor_tightens + extensor_loosens) / 2
            return self._read_loose(anywhere, elbow_angle)
        low = min(flexor_tightens, extensor_loosens)
        high = max(flexor_tightens, extensor_loosens)

        def surplus(spool_angle):
            return self.surplus(spool_angle, elbow_angle)

        step = 1.0
        while surplus(low - step) > 0 or surplus(high + step) < 0:
            step *= 2
        angle = find_root(surplus, low - step, high + step)
        return self._read(angle, elbow_angle)

    def _read_loose(self, angle: float, elbow_angle: float) -> Outcome:
        """Return the outcome of an arm whose tendons both hang loose."""
        flexor, extensor = self.stretches(angle, elbow_angle)
        loose = -self.p["ratio"] * flexor - extensor
        resistance = self.stiffness(angle, elbow_angle, (False, False))
        return Outcome("both slack", 0.0, 0.0, loose=loose, stiffness=resistance)

    def _read(self, angle: float, elbow_angle: float) -> Outcome:
        """Return the outcome at the spool angle that balances the elbow."""
        flexor, extensor = self.stretches(angle, elbow_angle)
        status = STATUS[flexor < 0, extensor < 0]
        tensions = self.tensions(angle, elbow_angle)
        if not self.p["unilateral"]:
            resistance = self.stiffness(angle, elbow_angle, (True, True))
            return Outcome(status, *tensions, angle, stiffness=resistance)
        flexor_slack = max(0.0, -flexor)
        extensor_slack = max(0.0, -extensor)
        loose = self.p["ratio"] * flexor_slack + extensor_slack
        resistance = self.stiffness(angle, elbow_angle, (flexor >= 0, extensor >= 0))
        return Outcome(status, *tensions, angle, flexor_slack, extensor_slack, loose, resistance)


def find_root(function: Callable, low: float, high: float) -> float:
    """Return the root of a function between two points, to the last digits."""
    return brentq(function, low, high, xtol=1e-300, rtol=1e-15, maxiter=500)


def derivative(function: Callable, at, step: float = 3e-4):
    """Return the derivative of a function by a central difference of sixth order."""
    differences = (
        weight * (function(at + n * step) - function(at - n * step))
        for n, weight in CENTRAL_WEIGHTS
    )
    return sum(differences) / step


def row(p: Parameters, index: int) -> dict[str, float]:
    """Return one parameter set of many, as plain numbers."""
    return {name: np.asarray(values)[index].item() for name, values in p.items()}


def total_compliances(p: Parameters, flexion, *, profile: Callable = even):
    """Return the compliance of tendon and spring together, for each side."""
    sheaths = compliances(p, flexion, profile=profile)
    return {side: tendon + spring for side, (_, tendon, spring) in sheaths.items()}


def run(p: Parameters, elbow_angle, flexion, *, profile: Callable = even) -> list[Outcome]:
    """Settle every parameter set at its own elbow angle; all arrays have one length."""
    compliance = total_compliances(p, flexion, profile=profile)
    outcomes = []
    for i, angle in enumerate(elbow_angle):
        flexor = float(compliance["flexor"][i])
        extensor = float(compliance["extensor"][i])
        bench = Bench(row(p, i), flexor, extensor)
        outcomes.append(bench.settle(float(angle)))
    return outcomes
