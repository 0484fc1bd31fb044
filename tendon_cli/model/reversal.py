"""Turns of the spool, and the drift of a joint that is let go, neither part of the motion itself.

As the spool turns back, friction changes its direction from the motor's end on, up to a front that
walks along the sheath; beyond it the tendon sticks with the tension that it had. With Coulomb
friction both profiles are exponentials, so the front is where they meet, and the elastic stretch
between them is what the spool winds in or lets out (docs/physics.md). Until the front arrives, the
tension at the elbow is that of the turn, and the elbow stands still.

M. Kaneko, M. Wada, H. Maekawa, K. Tanie, "A new consideration on tendon-tension control system of
robot hands", IEEE International Conference on Robotics and Automation, 1991, call this lost motion
the equivalent backlash. SI units, angles in radians.

With the spool held at α the distal tensions follow from the paths (Eqs. 13 to 16 solved for the
tensions),

    x = max(0, F0 + (R_f α - H_f)/c_f),   y = max(0, F0 + (H_e - η R_f α)/c_e)

and the torque that drives the joint is J_f x - J_e y - τ_a. The spool that holds a state where the
elbow is unstable holds another one, stable, further on: in between the joint is driven there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Real
from tendon_cli.model.sheath import Sheathed, sheaths_of

_POINTS = 2001  # angles at which a drift is computed


@dataclass(frozen=True, eq=False)
class SideReversal:
    """Turn of one tendon between two motions; NaN where it is not under tension."""

    tension_before: Array
    """Tension at the motor as the motion stops, N."""
    ratio: Array
    """e^(σμφ) of the motion that stops: the tension at the motor ends at its square times
    `tension_before`."""
    stretch: Array
    """Length that the spool winds in or lets out until the far end follows, m."""
    turn: Array
    """Rotation of the spool after which the far end follows, rad."""
    loss: Array
    """Energy that friction takes until then, J."""
    sprung: Array
    """Share of the turn that a spring at the motor takes for the first change of tension; 0 without
    such a spring."""

    def tension(self, turn: Array) -> Array:
        """Return the tension at the motor, the far end at rest or just following, N.

        Args:
            turn: Rotation of the spool since the motion stopped, rad.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            done = np.minimum(turn / self.turn, 1.0)
            root = np.sqrt(np.square(self.sprung) + 4.0 * (1.0 - self.sprung) * done)
            share = np.where(done > 0.0, 2.0 * done / (self.sprung + root), 0.0)
            share = np.where(self.turn > 0.0, share, 1.0)
        return np.asarray(self.tension_before * np.square(1.0 + share * (self.ratio - 1.0)))

    @property
    def tension_after(self) -> Array:
        """Tension at the motor when the far end follows, N."""
        return np.asarray(self.tension_before * np.square(self.ratio))


@dataclass(frozen=True, eq=False)
class Reversal:
    """Turn of both tendons between two motions."""

    flexor: SideReversal
    extensor: SideReversal
    flexor_radius: Array
    """R_m^f, m."""
    ratio: Array
    """η, extensor over flexor radius of the spool."""

    def motor_torque(self, turn: Array) -> Array:
        """Return τ_m during the turn, N m; a tendon without tension does not count.

        Args:
            turn: Rotation of the spool since the motion stopped, rad.
        """
        flexor = np.nan_to_num(self.flexor.tension(turn))
        extensor = np.nan_to_num(self.extensor.tension(turn))
        return np.asarray((flexor - self.ratio * extensor) * self.flexor_radius)


def reversal(state: State, elbow_angle: Real, flexion: Flags) -> Reversal:
    """Return the turn of both tendons as the motion reverses at states.

    Args:
        state: States at which the motion stops.
        elbow_angle: Their elbow angles, rad.
        flexion: True where the motion that stops is flexion, else extension.
    """
    design = state.design
    radius = np.asarray(design.flexor_radius)
    opposite = ~np.asarray(flexion)
    flexor_after, extensor_after = sheaths_of(design.flexor, design.extensor, elbow_angle, opposite)
    return Reversal(
        flexor=side_reversal(state.flexor, flexor_after, state.balance.flexor, radius),
        extensor=side_reversal(
            state.extensor, extensor_after, state.balance.extensor, radius * design.ratio
        ),
        flexor_radius=radius,
        ratio=np.asarray(design.ratio),
    )


def side_reversal(before: Sheathed, after: Sheathed, tension: Array, radius: Array) -> SideReversal:
    """Return the turn of one tendon, by its sheath before and after it and its distal tension T.

    The stretch is T |c before - after|. As the front has come through the share q of the sheath's
    change, the tendon has let out q² T (c_Ten before - after), and the tension at the motor is
    P (1 + q (r - 1))²: so the work there is P times what the tendon lets out times
    1 + 4/3 (r - 1) + (r - 1)²/2. A spring at the motor lets out what its tension says,
    (P - P (1 + q (r - 1))²)/K: its share of the turn begins with the slope 2 P (1 - r)/K, and loses
    nothing.
    """
    pulled = np.where(tension > 0.0, tension, np.nan)
    near = pulled / before.capstan
    change = before.capstan - 1.0
    tendon_out = pulled * (before.tendon - after.tendon)
    spring_out = pulled * (before.spring - after.spring)
    let_out = tendon_out + spring_out
    first = -2.0 * change * np.where(before.at_motor, before.spring, 0.0) * pulled
    released = 0.5 * np.square(pulled) * (before.strain - after.strain)
    with np.errstate(divide="ignore", invalid="ignore"):
        sprung = np.where(let_out != 0.0, first / let_out, 0.0)
    return SideReversal(
        tension_before=near,
        ratio=before.capstan,
        stretch=np.abs(let_out),
        turn=np.abs(let_out) / radius,
        loss=released - near * tendon_out * (1.0 + 4.0 / 3.0 * change + 0.5 * np.square(change)),
        sprung=sprung,
    )


@dataclass(frozen=True)
class Drift:
    """Motion of a joint that is let go, the spool held, until it comes to rest."""

    start: float
    """Angle at which it is let go, rad."""
    end: float
    """Angle at which it is balanced again, or the end of the motion, rad."""
    torque: float
    """Largest magnitude of the torque that drives it there, N m."""
    balanced: bool
    """True if it is balanced at the end."""


def drift(design: Design, start: float, last: float) -> Drift:
    """Return the quasi-static drift of one design from an elbow angle toward another one.

    Friction is that of the motion: flexion if `last` is the larger angle.

    Args:
        design: A design of numbers, or of arrays of one value.
        start: Angle at which the joint is let go, rad.
        last: Angle at which the search ends, rad.
    """
    design = design.at_rest()
    flexion = np.array([[last > start]])
    angles = np.linspace(start, last, _POINTS)
    state = evaluate(design, angles[np.newaxis], flexion)
    driving = _driving_torque(state).ravel() * np.sign(last - start)
    balanced_points = np.flatnonzero(driving[1:] <= 0.0) + 1
    balanced = len(balanced_points) > 0
    point = int(balanced_points[0]) if balanced else _POINTS - 1
    if point == 1:  # it does not leave
        return Drift(start, start, 0.0, balanced=True)
    share = 1.0
    if balanced:
        share = driving[point - 1] / (driving[point - 1] - driving[point])
    end = float(angles[point - 1] + share * (angles[point] - angles[point - 1]))
    return Drift(start, end, float(driving[:point].max()), balanced=balanced)


def _driving_torque(state: State) -> Array:
    """Return the torque that drives the joint toward flexion at each angle, N m.

    The spool is held where it holds the first angle.
    """
    design = state.design
    motion = state.motion
    coupling = state.coupling
    held = np.asarray(design.flexor_radius) * state.spool_angle[..., :1]
    flexor_stretch = held - motion.flexor_travel
    extensor_stretch = motion.extensor_travel - design.ratio * held
    flexor = design.flexor.pretension + flexor_stretch / coupling.flexor_compliance
    extensor = design.extensor.pretension + extensor_stretch / coupling.extensor_compliance
    if coupling.resting is not None:
        resting_flexor, resting_extensor = coupling.resting
        flexor_stretch = flexor_stretch + resting_flexor * design.flexor.pretension
        extensor_stretch = extensor_stretch + resting_extensor * design.extensor.pretension
        flexor = flexor_stretch / coupling.flexor_compliance
        extensor = extensor_stretch / coupling.extensor_compliance
    flexing = coupling.moment_arm * np.maximum(flexor, 0.0)
    extending = coupling.extensor_arm * np.maximum(extensor, 0.0)
    return np.asarray(flexing - extending - coupling.elbow_torque)
