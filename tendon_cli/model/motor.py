"""What motor, springs and friction do as the elbow moves through a state.

The spool turns with the elbow by dα/dθ; everything else follows from that. Per radian of the elbow

    τ_m dα/dθ = τ_a + dU/dθ + dW/dθ

with U what tendons and springs store and W what friction takes. Along a sheath the tendon slides by u(s) and friction
takes dF/ds du ds: W comes from friction itself, and the balance above is used nowhere. SI units, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.model import sheath
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.statics import BOTH_SLACK, EXTENSOR_SLACK, FLEXOR_SLACK
from tendon_cli.model.transmission import Transmission


@dataclass(frozen=True, eq=False)
class MotorRates:
    """What goes on in states per radian of the elbow (θ, whichever way it moves); shapes as those of `State`.

    Where both tendons are slack the spool is free: its angle and speed are NaN, and nothing is driven, stored or lost.
    """

    spool_angle: Array
    """α + c_f F0/R_f, counted from one unstretched flexor for both directions, rad."""
    spool_speed: Array
    """dα/dθ."""
    power: Array
    """τ_m dα/dθ, N m."""
    stored: Array
    """U, elastic energy of both tendons and springs, J."""
    storing: Array
    """dU/dθ, N m."""
    friction: Array
    """dW/dθ by the work of friction along both sheaths, N m: below 0 in extension, where θ falls."""


def motor_rates(design: Design, state: State) -> MotorRates:
    """Rates of states by their elbow stiffness k = dα/dθ R_f (J/c_f + η R_elb/c_e), which leaves slack sides out."""
    tied, status = state.coupling, state.balance.status
    limp = np.asarray(design.unilateral)
    flexor_pulls = ~(((status == FLEXOR_SLACK) | (status == BOTH_SLACK)) & limp)
    extensor_pulls = ~(((status == EXTENSOR_SLACK) | (status == BOTH_SLACK)) & limp)
    by_flexor = flexor_pulls * tied.moment_arm / tied.flexor_compliance
    by_extensor = extensor_pulls * tied.ratio * tied.elbow_radius / tied.extensor_compliance
    with np.errstate(divide="ignore", invalid="ignore"):
        winding = np.where(flexor_pulls | extensor_pulls, state.elbow_stiffness / (by_flexor + by_extensor), np.nan)
    wound = np.where(np.isnan(winding) & ~np.isnan(tied.moment_arm), 0.0, winding)
    x, y = state.balance.flexor, state.balance.extensor
    x_rate = flexor_pulls * (wound - tied.moment_arm) / tied.flexor_compliance
    y_rate = extensor_pulls * (tied.elbow_radius - tied.ratio * wound) / tied.extensor_compliance
    flexor_gives = state.flexor.spring + strain_compliance(state.flexor)
    extensor_gives = state.extensor.spring + strain_compliance(state.extensor)
    flexor_slides = tied.moment_arm + state.flexor.spring * x_rate
    extensor_slides = state.extensor.spring * y_rate - tied.elbow_radius
    return MotorRates(
        spool_angle=state.spool_angle + tied.flexor_compliance * design.flexor.pretension / design.flexor_radius,
        spool_speed=winding / design.flexor_radius,
        power=np.asarray(state.motor_torque * wound / design.flexor_radius),
        stored=0.5 * (flexor_gives * x * x + extensor_gives * y * y),
        storing=flexor_gives * x * x_rate + extensor_gives * y * y_rate,
        friction=friction_rate(state.flexor, x, x_rate, flexor_slides)
        + friction_rate(state.extensor, y, y_rate, extensor_slides),
    )  # fmt: skip


def strain_compliance(side: Transmission) -> Array:
    """∫ (F/T)² ds / AE, twice the strain energy of a sheathed tendon over the square of its distal tension T, m/N.

    With F = T e^(as/L) from the elbow on it is L/(AE) (e^(2a) - 1)/(2a), where c_Ten has a once.
    """
    exponent = -np.log(side.capstan)
    return np.asarray(side.tendon * sheath.relative_elongation(2.0 * exponent) / sheath.relative_elongation(exponent))


def friction_rate(side: Transmission, tension: Array, tension_rate: Array, slides: Array) -> Array:
    """∫ dF/ds du/dθ ds over a sheath: what friction takes, N m, by the distal tension T and its rate (N, N/rad).

    `slides` is how fast the tendon moves toward the motor at the elbow's end (m/rad). Further along it moves faster by
    dT/dθ w(s), w the elongation from the elbow to s per newton, so that the integral is (e^a - 1) T slides +
    T dT/dθ ∫ (dF/ds)/T w ds; by parts the last one is e^a c_Ten less `strain_compliance`.
    """
    near = 1.0 / side.capstan
    along = near * side.tendon - strain_compliance(side)
    return np.asarray(tension * ((near - 1.0) * slides + tension_rate * along))
