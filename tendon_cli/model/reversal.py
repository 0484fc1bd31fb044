"""Apart from the motion: how far the spool turns back where it turns, and how far a joint drifts that is let go.

As the spool turns, friction changes its direction from the motor's end on, up to a front that walks along the sheath;
beyond it the tendon sticks with the tension that it had. With Coulomb friction both profiles are exponentials, so the
front is where they meet, and the elastic stretch between them is what the spool winds in or lets out
(docs/physics.md). Until the front arrives, the tension at the elbow is that of the turn, and the elbow stands still.

M. Kaneko, M. Wada, H. Maekawa, K. Tanie, "A new consideration on tendon-tension control system of robot hands", IEEE
International Conference on Robotics and Automation, 1991, call what is lost so the equivalent backlash. SI units,
angles in radians.

With the spool held at α the distal tensions are those that the paths leave (Eqs. 13 to 16 solved for the tensions),

    x = max(0, F0 + (R_f α - H_f)/c_f),   y = max(0, F0 + (H_e - η R_f α)/c_e)

and what drives the joint is J_f x - J_e y - τ_a. The spool that holds a state where the elbow is unstable holds another
one, stable, further on: in between the joint is driven there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Real
from tendon_cli.model.sheath import Sheathed, sheaths_of

_POINTS = 2001


@dataclass(frozen=True, eq=False)
class SideReversal:
    """One tendon through a turn; NaN where it is not under tension."""

    tension_before: Array
    """At the motor as the motion stops, N."""
    ratio: Array
    """e^(σμφ) of the motion that stops: the tension at the motor ends at its square times `tension_before`."""
    stretch: Array
    """What the spool winds in or lets out until the far end follows, m."""
    turn: Array
    """Rotation of the spool after which the far end follows, rad."""
    loss: Array
    """What friction takes until then, J."""
    sprung: Array
    """The share of the turn that a spring at the motor takes for the first of the change of tension; 0 without."""

    def tension(self, turn: Array) -> Array:
        """Tension at the motor once the spool has turned so far (N), the far end at rest or just following."""
        with np.errstate(divide="ignore", invalid="ignore"):
            done = np.minimum(turn / self.turn, 1.0)
            root = np.sqrt(np.square(self.sprung) + 4.0 * (1.0 - self.sprung) * done)
            share = np.where(
                self.turn > 0.0, np.where(done > 0.0, 2.0 * done / (self.sprung + root), 0.0), 1.0
            )
        return np.asarray(self.tension_before * np.square(1.0 + share * (self.ratio - 1.0)))

    @property
    def tension_after(self) -> Array:
        """At the motor when the far end follows, N."""
        return np.asarray(self.tension_before * np.square(self.ratio))


@dataclass(frozen=True, eq=False)
class Reversal:
    """Both tendons through a turn."""

    flexor: SideReversal
    extensor: SideReversal
    flexor_radius: Array
    ratio: Array

    def motor_torque(self, turn: Array) -> Array:
        """τ_m once the spool has turned back so far (rad), N m; of a tendon without tension nothing is counted."""
        flexor, extensor = (
            np.nan_to_num(side.tension(turn)) for side in (self.flexor, self.extensor)
        )
        return np.asarray((flexor - self.ratio * extensor) * self.flexor_radius)


def reversal(state: State, elbow_angle: Real, flexion: Flags) -> Reversal:
    """The turn of the motion at states, which are at elbow angles (rad)."""
    design = state.design
    radius = np.asarray(design.flexor_radius)
    after = sheaths_of(design.flexor, design.extensor, elbow_angle, ~np.asarray(flexion))
    return Reversal(
        _side(state.flexor, after[0], state.balance.flexor, radius),
        _side(state.extensor, after[1], state.balance.extensor, radius * design.ratio),
        radius,
        np.asarray(design.ratio),
    )


def _side(before: Sheathed, after: Sheathed, tension: Array, radius: Array) -> SideReversal:
    """One tendon, by its sheath before and after the turn and its distal tension T.

    The stretch is T |c before - after|. As the front has come through the share q of the sheath's change, the tendon
    has let out q² T (c_Ten before - after), and the tension at the motor is P (1 + q (r - 1))²: so the work there is P
    times what the tendon lets out times 1 + 4/3 (r - 1) + (r - 1)²/2. A spring at the motor lets out what its tension
    says, (P - P (1 + q (r - 1))²)/K: its share of the turn begins with the slope 2 P (1 - r)/K, and loses nothing.
    """
    pulled = np.where(tension > 0.0, tension, np.nan)
    near, change = pulled / before.capstan, before.capstan - 1.0
    of_tendon, of_spring = (
        pulled * (before.tendon - after.tendon),
        pulled * (before.spring - after.spring),
    )
    let_out, first = (
        of_tendon + of_spring,
        -2.0 * change * np.where(before.at_motor, before.spring, 0.0) * pulled,
    )
    released = 0.5 * np.square(pulled) * (before.strain - after.strain)
    with np.errstate(divide="ignore", invalid="ignore"):
        sprung = np.where(let_out != 0.0, first / let_out, 0.0)
    return SideReversal(
        tension_before=near,
        ratio=before.capstan,
        stretch=np.abs(let_out),
        turn=np.abs(let_out) / radius,
        loss=released - near * of_tendon * (1.0 + 4.0 / 3.0 * change + 0.5 * np.square(change)),
        sprung=sprung,
    )


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
    extensor = (
        design.extensor.pretension
        + (motion.extensor_travel - design.ratio * held) / tied.extensor_compliance
    )
    pulls = tied.moment_arm * np.maximum(flexor, 0.0) - tied.extensor_arm * np.maximum(
        extensor, 0.0
    )
    return np.asarray(pulls - tied.elbow_torque)
