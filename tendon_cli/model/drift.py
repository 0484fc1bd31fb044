"""How far the joint drifts beyond its stable pretension, the spool held: where the tendons balance it again.

With the spool at α the distal tensions are those that the paths leave (Eqs. 13 to 16 solved for the tensions),

    x = max(0, F0 + (R_f α - H_f)/c_f),   y = max(0, F0 + (H_e - η R_f α)/c_e)

and what drives the joint is J_f x - J_e y - τ_a. The spool that holds a state where the elbow is unstable holds another
one, stable, further on: in between the joint is driven there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array

_POINTS = 2001


@dataclass(frozen=True)
class Drift:
    """Where a joint that is let go comes to rest, the spool held."""

    start: float
    """Angle at which it is let go, rad."""
    end: float
    """Where it is balanced again, or the end of the motion, rad."""
    torque: float
    """The largest magnitude that drives it there, N m."""
    balanced: bool
    """Whether it is balanced at the end."""


def drift(design: Design, start: float, last: float) -> Drift:
    """The drift of one design (numbers, or arrays of one value) from an elbow angle toward another one, rad.

    Friction is that of the motion: flexion if `last` is the larger angle. Quasi-static.
    """
    design, flexion = replace(design, trajectory=None), np.array([[last > start]])
    angles = np.linspace(start, last, _POINTS)[np.newaxis]
    net = _driving_torque(evaluate(design, angles, flexion)).ravel() * np.sign(last - start)
    against = np.flatnonzero(net[1:] <= 0.0)
    at = int(against[0]) + 1 if len(against) else _POINTS - 1
    if at == 1:  # it does not leave
        return Drift(start, start, 0.0, balanced=True)
    share = 1.0 if not len(against) else net[at - 1] / (net[at - 1] - net[at])
    end = float(angles[0, at - 1] + share * (angles[0, at] - angles[0, at - 1]))
    return Drift(start, end, float(net[:at].max()), balanced=bool(len(against)))


def _driving_torque(state: State) -> Array:
    """What drives the joint toward flexion at each angle, the spool held where it holds the first one, N m."""
    design, motion, tied = state.design, state.motion, state.coupling
    held = np.asarray(design.flexor_radius) * state.spool_angle[..., :1]
    flexor = design.flexor.pretension + (held - motion.flexor_travel) / tied.flexor_compliance
    extensor = design.extensor.pretension + (motion.extensor_travel - design.ratio * held) / tied.extensor_compliance
    pulls = tied.moment_arm * np.maximum(flexor, 0.0) - tied.extensor_arm * np.maximum(extensor, 0.0)
    return np.asarray(pulls - tied.elbow_torque)
