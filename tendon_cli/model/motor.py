"""What motor, springs and friction do as the elbow moves through a state.

The spool turns with the elbow by dα/dθ; everything else follows from that. Per radian of the elbow

    τ_m dα/dθ = τ_a + dU/dθ + dW/dθ

with U what tendons and springs store and W what friction takes. Along a sheath the tendon slides by u(s) and friction
takes dF/ds du ds: W comes from friction itself, and the balance above is used nowhere. SI units, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.statics import BOTH_SLACK, EXTENSOR_SLACK, FLEXOR_SLACK


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
    """Rates of states by their elbow stiffness k = dα/dθ R_f (J_f/c_f + η J_e/c_e), which leaves slack sides out."""
    tied, status, at = state.coupling, state.balance.status, state.situation
    limp = np.asarray(design.unilateral)
    flexor_pulls = ~(((status == FLEXOR_SLACK) | (status == BOTH_SLACK)) & limp)
    extensor_pulls = ~(((status == EXTENSOR_SLACK) | (status == BOTH_SLACK)) & limp)
    by_flexor = flexor_pulls * tied.moment_arm / tied.flexor_compliance
    by_extensor = extensor_pulls * tied.ratio * tied.extensor_arm / tied.extensor_compliance
    with np.errstate(divide="ignore", invalid="ignore"):
        winding = np.where(flexor_pulls | extensor_pulls, state.elbow_stiffness / (by_flexor + by_extensor), np.nan)
    wound = np.where(np.isnan(winding) & ~np.isnan(tied.moment_arm), 0.0, winding)
    x, y = state.balance.flexor, state.balance.extensor
    x_takes, y_takes = wound - tied.moment_arm, tied.extensor_arm - tied.ratio * wound
    if at.resting is not None:  # a bend that follows the joint stretches the tendons, too
        x_takes, y_takes = x_takes - at.flexor.compliance_rate * x, y_takes - at.extensor.compliance_rate * y
    x_rate = flexor_pulls * x_takes / tied.flexor_compliance
    y_rate = extensor_pulls * y_takes / tied.extensor_compliance
    started = (at.flexor if at.resting is None else at.resting[0]).compliance * design.flexor.pretension
    return MotorRates(
        spool_angle=state.spool_angle + started / design.flexor_radius,
        spool_speed=winding / design.flexor_radius,
        power=np.asarray(state.motor_torque * wound / design.flexor_radius),
        stored=0.5 * (at.flexor.gives * x * x + at.extensor.gives * y * y),
        storing=at.flexor.storing(x, x_rate) + at.extensor.storing(y, y_rate),
        friction=at.flexor.friction_rate(x, x_rate, tied.moment_arm)
        + at.extensor.friction_rate(y, y_rate, -np.asarray(tied.extensor_arm)),
    )
