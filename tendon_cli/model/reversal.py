"""What happens where the motion turns: how far the spool turns back before each tendon's far end follows.

As the spool turns, friction changes its direction from the motor's end on, up to a front that walks along the sheath;
beyond it the tendon sticks with the tension that it had. With Coulomb friction both profiles are exponentials, so the
front is where they meet, and the elastic stretch between them is what the spool winds in or lets out
(docs/physics.md). Until the front arrives, the tension at the elbow is that of the turn, and the elbow stands still.

M. Kaneko, M. Wada, H. Maekawa, K. Tanie, "A new consideration on tendon-tension control system of robot hands", IEEE
International Conference on Robotics and Automation, 1991, call what is lost so the equivalent backlash. SI units,
angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.motor import strain_compliance
from tendon_cli.model.transmission import Transmission, transmissions


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

    def tension(self, turn: Array) -> Array:
        """Tension at the motor once the spool has turned so far (N), the far end at rest or just following."""
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(self.turn > 0.0, np.sqrt(np.minimum(turn / self.turn, 1.0)), 1.0)
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
        flexor, extensor = (np.nan_to_num(side.tension(turn)) for side in (self.flexor, self.extensor))
        return np.asarray((flexor - self.ratio * extensor) * self.flexor_radius)


def reversal(design: Design, state: State, flexion: Flags) -> Reversal:
    """The turn of the motion at states."""
    radius = np.asarray(design.flexor_radius)
    after = transmissions(design, ~np.asarray(flexion))
    return Reversal(
        _side(state.flexor, after[0], state.balance.flexor, radius),
        _side(state.extensor, after[1], state.balance.extensor, radius * design.ratio),
        radius,
        np.asarray(design.ratio),
    )


def _side(before: Transmission, after: Transmission, tension: Array, radius: Array) -> SideReversal:
    """One tendon, by its transmission before and after the turn and its distal tension T.

    The stretch is T |c_Ten before - after|, and over the turn the tension at the motor is P (1 + q (r - 1))², q² the
    share of the turn that is done: so its work is P times the stretch times 1 + 4/3 (r - 1) + (r - 1)²/2.
    """
    pulled = np.where(tension > 0.0, tension, np.nan)
    near, change = pulled / before.capstan, before.capstan - 1.0
    let_out = pulled * (before.tendon - after.tendon)
    released = 0.5 * np.square(pulled) * (strain_compliance(before) - strain_compliance(after))
    return SideReversal(
        tension_before=near,
        ratio=before.capstan,
        stretch=np.abs(let_out),
        turn=np.abs(let_out) / radius,
        loss=released - near * let_out * (1.0 + 4.0 / 3.0 * change + 0.5 * np.square(change)),
    )
