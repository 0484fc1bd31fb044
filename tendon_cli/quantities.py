"""Quantities: name, symbol, unit and meaning, each written down once.

Study fields, table columns, axis labels and the printed page of `tendon state` all take them from
here. Symbols and equation numbers are those of Yadav et al., "Modeling and parametric optimization
of 3D tendon-sheath actuator system for upper limb soft exosuit".
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

from tendon_cli.units import SI_UNIT

SIDES = ("flexor", "extensor")
"""Sides of the arm, each with a sheath, a tendon and a spring."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """Meaning, symbol and units of a number."""

    name: str
    """Name of the column or the last part of the key."""
    symbol: str
    """Symbol in the equations."""
    dimension: str
    """Dimension, such as "length"."""
    unit: str
    """SI unit in which it is computed and stored."""
    shown_in: str
    """Unit in which people read it."""
    long_name: str
    """Meaning in words."""
    null: str = "no equilibrium"
    """Cases in which a result of a state or a design may be null.

    "never", "no equilibrium", "slack" (also without equilibrium), or "often".
    """
    value: Callable[[Any], Any] | None = None
    """For a column that follows from states alone: its values in a `model.actuator.State`."""
    over: Callable[[Any], Any] | None = None
    """For a column of designs: reduces these values, a design's states along their last axis."""

    @property
    def has_own_unit(self) -> bool:
        """True for a number in a unit that is not converted, such as a price in EUR."""
        return self.dimension == "number" and self.unit != "1"


_SHOWN_IN = {
    "length": "mm",
    "stiffness": "kN/m",
    "pressure": "GPa",
    "angle": "deg",
    "angular speed": "deg/s",
}
"""Units in which people read dimensions, if they are not those of SI."""


def _quantity(
    name: str,
    symbol: str,
    dimension: str,
    long_name: str,
    null: str = "no equilibrium",
    shown_in: str | None = None,
) -> Quantity:
    """Return a quantity in the SI unit of its dimension."""
    unit = SI_UNIT[dimension]
    shown = shown_in or _SHOWN_IN.get(dimension, unit)
    return Quantity(name, symbol, dimension, unit, shown, long_name, null)


def _result(
    *meaning: str,
    value: Callable[[Any], Any] | None = None,
    over: Callable[[Any], Any] | None = None,
) -> Quantity:
    """Return a column of states, or of designs if it is reduced `over` their states.

    Its value is by default the property of `State` of the same name.
    """
    return replace(_quantity(*meaning), value=value or attrgetter(meaning[0]), over=over)


_OF_STUDIES = (
    # The arm (Figs. 1 and 2).
    _quantity("a1", "a₁", "length", "distance of the proximal flexor anchor r in front of the upper arm's line"),
    _quantity("b1", "b₁", "length", "distance of the proximal flexor anchor r from the elbow, along the upper arm"),
    _quantity("a2", "a₂", "length", "distance of the distal flexor anchor q in front of the forearm's line"),
    _quantity("b2", "b₂", "length", "distance of the distal flexor anchor q from the elbow, along the forearm"),
    _quantity("elbow_radius", "R_elb", "length", "radius of the virtual pulley that the extensor tendon wraps"),
    _quantity("forearm_mass", "m_f", "mass", "mass of forearm and hand"),
    _quantity("forearm_com", "d_com", "length", "distance of the centre of mass of forearm and hand from the elbow"),
    _quantity("load_distance", "d_load", "length", "distance of the load from the elbow"),
    _quantity("upper_arm_angle", "ψ", "angle", "inclination of the upper arm, forward positive, 0 = hanging"),
    _quantity("contact_width", "w", "length", "width of the extensor's strap around the elbow"),
    _quantity("contact_from", "θ_s", "angle", "angle from which on the extensor's strap presses the joint"),
    _quantity("contact_radius", "R_s", "length", "radius of curvature of the extensor's strap on the joint"),
    _quantity("excursion_noise", "σ_H", "length", "standard deviation of the noise of measured excursions"),
    _quantity("load_scale", "s", "number", "factor on the torque of a task"),
    _quantity("joint_stiffness", "k_j", "rotational stiffness", "stiffness of the joint itself"),
    _quantity("rest_angle", "θ_r", "angle", "angle at which the joint's own stiffness gives no torque"),
    # Sheath, tendon, spring, spool, load.
    _quantity("friction", "μ", "number", "Coulomb friction coefficient between tendon and sheath"),
    _quantity("bend_angle", "φ", "angle", "total curvature of the sheath, ∫κ ds"),
    _quantity("path_smoothing", "σ_path", "length", "standard deviation of the digitisation noise of a route"),
    _quantity("tendon_length", "L", "length", "length of the tendon inside the sheath", shown_in="m"),
    _quantity("tendon_diameter", "d", "length", "diameter of the tendon"),
    _quantity("breaking_force", "F_b", "force", "tension at which the rope of the tendons breaks"),
    _quantity("youngs_modulus", "E", "pressure", "Young's modulus of the tendon"),
    _quantity("pretension", "F₀", "force", "distal tension of both tendons before motion"),
    _quantity("spring_stiffness", "K", "stiffness", "stiffness of the series spring"),
    _quantity("spring_free_length", "L_free", "length", "length of the flexor's spring without load"),
    _quantity("anchor_stiffness", "K_t", "stiffness", "stiffness of a tendon's tissue and cuffs, in series"),
    _quantity("setting_angle", "θ_0", "angle", "angle of the joint at which the pretension is set"),
    _quantity("reading_error", "ε_r", "force", "error of the gauge by which the pretension is read"),
    _quantity("model_pretension", "F₀", "force", "pretension of the model for what is read"),
    _quantity("flexor_radius", "R_f", "length", "radius of the flexor part of the spool"),
    _quantity("spool_ratio", "η", "number", "extensor over flexor radius of the spool, R_e / R_f"),
    _quantity("load_mass", "m", "mass", "mass of the load in the hand"),
    _quantity("elbow_angle", "θ", "angle", "elbow flexion, 0 = straight arm"),
    # Who wears it.
    _quantity("women", "p_w", "number", "share of women among people"),
    _quantity("stature", "h", "length", "body height"),
    _quantity("weight", "m_b", "mass", "body mass"),
    _quantity("acromion_radiale_length", "l_ar", "length", "shoulder to elbow"),
    _quantity("radiale_stylion_length", "l_rs", "length", "elbow to wrist"),
    _quantity("forearm_grip_length", "l_fg", "length", "elbow to the centre of a held rod"),
    _quantity("biceps_circumference", "C_bi", "length", "circumference of the flexed upper arm"),
    _quantity("forearm_circumference", "C_fo", "length", "circumference of the flexed forearm"),
    _quantity("wrist_circumference", "C_wr", "length", "circumference of the wrist"),
    # Motion.
    _quantity("speed", "θ̇", "angular speed", "speed of the elbow, the same throughout"),
    _quantity("cutoff", "f_c", "frequency", "cutoff of the low-pass over a measured trajectory"),
    _quantity("inertia", "I", "inertia", "moment of inertia of forearm and hand about the elbow"),
    _quantity("time", "t", "time", "time along the trajectory"),
    # Logs of a suit.
    _quantity("torque_constant", "k_t", "torque constant", "torque at the spool per current of the motor"),
    _quantity("counts_per_turn", "counts", "number", "counts of an encoder in a turn"),
    _quantity("elbow_speed", "θ̇", "angular speed", "speed of the elbow along the trajectory"),
    # Limits of a design that have no column yet, and what is asked of one.
    _quantity("max_pretension", "max F₀", "force", "largest pretension"),
    _quantity("serve", "share", "number", "share of persons or draws that is enough; a condition is always kept"),
)  # fmt: skip

_OF_STATES = (  # columns in their order
    _result("flexor_tension_proximal", "F_I^f", "force", "flexor tension at the motor"),
    _result("flexor_tension_distal", "F_o^f", "force", "flexor tension at the elbow",
            value=lambda at: at.balance.flexor),
    _result("extensor_tension_proximal", "F_I^e", "force", "extensor tension at the motor"),
    _result("extensor_tension_distal", "F_o^e", "force", "extensor tension at the elbow",
            value=lambda at: at.balance.extensor),
    _result("flexor_tendon_stretch", "ΔL_Ten^f", "length", "flexor tendon stretch from the pretensioned state",
            value=lambda at: at.stretch("flexor", "tendon")),
    _result("extensor_tendon_stretch", "ΔL_Ten^e", "length", "extensor tendon stretch from the pretensioned state",
            value=lambda at: at.stretch("extensor", "tendon")),
    _result("flexor_spring_stretch", "ΔL_SE^f", "length", "flexor spring stretch from the pretensioned state",
            value=lambda at: at.stretch("flexor", "spring")),
    _result("extensor_spring_stretch", "ΔL_SE^e", "length", "extensor spring stretch from the pretensioned state",
            value=lambda at: at.stretch("extensor", "spring")),
    _result("flexor_slack", "s_f", "length", "slack length of the flexor tendon", "often"),
    _result("extensor_slack", "s_e", "length", "slack length of the extensor tendon", "often"),
    _result("elbow_torque", "τ_a", "torque", "torque that the task needs at the elbow"),
    _result("motor_torque", "τ_m", "torque", "torque of the motor"),
    _result("spool_angle", "α", "angle", "rotation of the spool from the pretensioned state, each direction with its own zero", "slack"),
    _result("elbow_stiffness", "k", "rotational stiffness", "stiffness of the elbow with the motor held"),
    _result("flexor_moment_arm", "J", "length", "moment arm of the flexor tendon about the elbow",
            value=lambda at: at.motion.flexor_moment_arm),
    _result("flexor_travel", "H_f", "length", "shortening of the flexor tendon's path", "never",
            value=lambda at: at.motion.flexor_travel),
    _result("extensor_travel", "H_e", "length", "lengthening of the extensor tendon's path", "never",
            value=lambda at: at.motion.extensor_travel),
)  # fmt: skip

_OF_MOTION_STATES = (  # further columns along a motion in time
    _result("friction_direction", "s", "number", "direction in which the tendons slide: 1 as in flexion, −1 as in extension", "never",
            value=lambda at: 2.0 * at.sliding.flexion - 1.0),
    _result("turning", "turning", "number", "the tendons turn, or slack passes from one to the other: torque lies between those of both directions", "never",
            value=lambda at: at.sliding.turning),
    _result("motor_torque_other", "τ_m other", "torque", "torque of the motor in the other direction of friction, while the tendons turn", "often",
            value=lambda at: at.sliding.torque_while_turning),
)  # fmt: skip

_OF_DESIGNS = (  # over all states of a design
    _quantity("min_flexor_tension", "min F^f", "force", "smallest flexor tension, of both ends, over all states"),
    _quantity("min_extensor_tension", "min F^e", "force", "smallest extensor tension, of both ends, over all states"),
    _quantity("max_tension", "max F", "force", "largest tension of either tendon, of both ends, over all states"),
    _quantity("max_spring_extension", "max x_SE", "length", "largest extension of a spring from its free length"),
    _quantity("peak_elbow_torque", "peak τ_a", "torque", "elbow torque of largest magnitude, with its sign"),
    _quantity("peak_motor_torque", "peak τ_m", "torque", "motor torque of largest magnitude, with its sign"),
    _quantity("min_elbow_stiffness", "min k", "rotational stiffness", "smallest elbow stiffness over all states"),
    _quantity("max_slack", "max s", "length", "longest slack length of either tendon", "often"),
    _quantity("slack_fraction", "slack share", "number", "share of states that are slack or without equilibrium", "never"),
    _quantity("unstable_fraction", "unstable share", "number", "share of states with negative elbow stiffness", "never"),
    _quantity("first_slack_angle", "θ_slack", "angle", "smallest elbow angle with a slack tendon", "often"),
    _quantity("required_pretension", "F₀*", "force", "least pretension of both tendons that prevents slack"),
    _quantity("margin", "F₀ − F₀*", "force", "margin: how far the pretension is above the least that prevents slack"),
    _quantity("max_contact_pressure", "max p", "pressure", "largest pressure of the extensor's strap", "often", "kPa"),
    _quantity("min_spool_to_tendon", "min D/d", "number", "smaller spool's diameter over that of the tendon", "never"),
    _quantity("pretension_from", "F₀ from", "force", "smallest pretension of both tendons that keeps every limit", "often"),
    _quantity("pretension_to", "F₀ to", "force", "largest pretension of both tendons that keeps every limit", "often"),
)  # fmt: skip

_OF_LIMITS = (  # over all states of a design, if the study states what the limit needs
    _quantity("min_spring_room", "min room", "length", "smallest room left between the anchors for the flexor's spring; null if no spring is there", "often"),
)  # fmt: skip

_OF_WINDOWS = (
    _quantity("tolerance", "±F₀", "number", "share by which the pretension may be wrong, about the middle of the window"),
    _quantity("served", "served", "number", "largest share of persons or draws that one pretension serves; null without both"),
    _quantity("set_flexor_tension", "set F_o^f", "force", "tension to set in the flexor at the joint"),
    _quantity("set_extensor_tension", "set F_o^e", "force", "tension to set in the extensor at the joint"),
    _quantity("set_flexor_tension_motor", "set F_I^f", "force", "tension to set in the flexor at the motor"),
    _quantity("set_extensor_tension_motor", "set F_I^e", "force", "tension to set in the extensor at the motor"),
    _quantity("set_flexor_tension_from", "from F_o^f", "force", "tension in the flexor at the joint at the lower end of the window"),
    _quantity("set_flexor_tension_to", "to F_o^f", "force", "tension in the flexor at the joint at the upper end of the window"),
    _quantity("tolerance_length", "±l", "length", "half the width of the window, as a length by which both tendons are shortened"),
    _quantity("served_verified", "served*", "number", "share of a fresh sample that the pretension serves"),
    _quantity("served_verified_low", "served* low", "number", "lower end of the 95 % interval of served_verified"),
    _quantity("served_verified_high", "served* high", "number", "upper end of the 95 % interval of served_verified"),
    _quantity("verified_from", "from*", "force", "smallest pretension that serves enough of the fresh sample"),
    _quantity("verified_to", "to*", "force", "largest pretension that serves enough of the fresh sample"),
    _quantity("served_at", "served at", "number", "share of persons or draws that the pretension serves; null without both"),
)  # fmt: skip

_OF_CYCLES = (  # both strokes of a design at a speed of the elbow
    _quantity("peak_motor_speed", "peak α̇", "angular speed", "motor speed of largest magnitude"),
    _quantity("peak_motor_power", "peak P_m", "power", "largest power of the motor"),
    _quantity("peak_braking_power", "peak P_b", "power", "largest power that the motor absorbs"),
    _quantity("motor_work_in", "W_m", "energy", "work that the motor does over both strokes while it drives"),
    _quantity("friction_loss", "W_μ", "energy", "energy lost to friction in the sheaths over both strokes"),
    _quantity("efficiency", "ε", "number", "1 − friction's loss over the motor's work"),
    _quantity("spool_travel", "Δα", "angle", "rotation of the spool over the motion"),
    _quantity("max_backlash", "max δα", "angle", "largest difference of spool angle between the directions"),
    _quantity("max_torque_band", "max δτ_m", "torque", "largest difference of motor torque between the directions"),
)  # fmt: skip

_OF_TRAJECTORIES = (  # along a motion in time
    _quantity("rms_motor_torque", "rms τ_m", "torque", "root mean square of the motor torque over time"),
    _quantity("braking_work", "W_b", "energy", "work that the motor absorbs while it brakes"),
    _quantity("turning_fraction", "turning share", "number", "share of samples at which the tendons turn"),
    _quantity("opposite_fraction", "opposite share", "number", "share of samples at which the spool turns against the joint"),
)  # fmt: skip

_LENGTHS_OF_A_SIDE = (  # name, symbol, meaning
    ("length_change", "ΔL", "tendon and spring, change of length from the pretensioned state"),
    ("elongation", "δ", "tendon and spring elongation from the unloaded state, negative where slack"),
    ("spring_elongation", "δ_SE", "spring elongation from its free length, negative where slack"),
)  # fmt: skip


def _of_figures() -> list[Quantity]:
    """Return the quantities that no table has, but that a figure may show."""
    quantities = [
        _quantity("radius_ratio", "H_f / H_e", "number", "flexor over extensor travel, Eq. 3")
    ]
    for side in SIDES:
        for name, symbol, meaning in _LENGTHS_OF_A_SIDE:
            side_symbol = f"{symbol}^{side[0]}"
            quantities.append(
                _quantity(f"{side}_{name}", side_symbol, "length", f"{side} {meaning}")
            )
    return quantities


_SIGNS = {"min": "≥", "max": "≤", "peak": "≤"}
"""Sign of a bound, by the first word of the name of what it bounds."""
_WITH_SIGN = ", with its sign"


def bound_name(name: str) -> str:
    """Return the name of the bound on a quantity, which is the name of its column, too."""
    return f"limit_{name}"


def _bound_on(quantity: Quantity) -> Quantity:
    """Return the bound that a study sets on a quantity, one for each design."""
    sign = _SIGNS[quantity.name.partition("_")[0]]
    meaning = quantity.long_name.removesuffix(_WITH_SIGN)
    return replace(
        quantity,
        name=bound_name(quantity.name),
        symbol=f"{quantity.symbol} {sign}",
        long_name=f"limit of the design itself on the {meaning}",
        null="often",
        value=None,
        over=None,
    )


_MEASURED = (
    *_OF_STUDIES,
    *_OF_STATES,
    *_OF_MOTION_STATES,
    *_OF_DESIGNS,
    *_OF_LIMITS,
    *_OF_WINDOWS,
    *_OF_CYCLES,
    *_OF_TRAJECTORIES,
)
_BOUNDS = tuple(
    _bound_on(quantity) for quantity in _MEASURED if quantity.name.partition("_")[0] in _SIGNS
)
QUANTITIES: dict[str, Quantity] = {quantity.name: quantity for quantity in (*_MEASURED, *_BOUNDS)}
OF_FIGURES: dict[str, Quantity] = {quantity.name: quantity for quantity in _of_figures()}
OF_STATES = tuple(quantity.name for quantity in _OF_STATES)
"""Results that each state has."""
OF_MOTION_STATES = tuple(quantity.name for quantity in _OF_MOTION_STATES)
"""Further results of each state if the study has a trajectory."""
OF_DESIGNS = tuple(quantity.name for quantity in _OF_DESIGNS)
"""Results that each design has, over all its states."""
OF_CYCLES = tuple(quantity.name for quantity in _OF_CYCLES)
"""Further results of each design if the study has a speed."""
OF_TRAJECTORIES = tuple(quantity.name for quantity in _OF_TRAJECTORIES)
"""Further results of each design if the study has a trajectory."""

_HALF_TURN = math.pi
"""Largest plausible angle of a joint, rad."""

PLAUSIBLE: dict[str, tuple[float, float]] = {
    # Anchors and weights, from a finger to a leg about the hip.
    "a1": (0.0, 0.3), "a2": (0.0, 0.3), "b1": (0.01, 0.6), "b2": (0.01, 0.6), "elbow_radius": (0.002, 0.2),
    "forearm_mass": (0.0, 30.0), "forearm_com": (0.0, 0.6), "load_distance": (0.0, 1.0), "contact_width": (0.002, 0.3),
    "contact_radius": (0.002, 0.2), "load_mass": (0.0, 150.0), "inertia": (0.0, 10.0), "joint_stiffness": (0.0, 1000.0),
    "upper_arm_angle": (-_HALF_TURN, _HALF_TURN), "setting_angle": (-_HALF_TURN, _HALF_TURN),
    "contact_from": (-_HALF_TURN, _HALF_TURN), "elbow_angle": (-_HALF_TURN, _HALF_TURN), "rest_angle": (-_HALF_TURN, _HALF_TURN), "elbow_torque": (-500.0, 500.0),
    "flexor_travel": (-0.5, 0.5), "excursion_noise": (0.0, 0.02),
    # Tendons, sheaths, springs, spools.
    "friction": (0.0, 1.0), "bend_angle": (0.0, 25.0), "path_smoothing": (0.0, 0.02), "tendon_length": (0.05, 10.0),
    "tendon_diameter": (0.0001, 0.01), "breaking_force": (10.0, 1e5), "youngs_modulus": (1e8, 1e+12), "pretension": (0.0, 2000.0),
    "spring_stiffness": (10.0, 1e7), "anchor_stiffness": (100.0, 1e7), "spring_free_length": (0.005, 1.0),
    "min_spring_room": (-0.1, 0.5), "flexor_radius": (0.002, 0.2), "spool_ratio": (0.1, 10.0),
    # Motion: slow rehabilitation to a throw; the time between two samples of a trajectory.
    "speed": (0.01, 50.0), "cutoff": (0.5, 50.0), "time": (1e-4, 1.0),
    # Limits.
    "min_flexor_tension": (0.0, 500.0), "min_extensor_tension": (0.0, 500.0), "max_tension": (1.0, 10000.0),
    "max_pretension": (1.0, 10000.0), "max_spring_extension": (0.001, 1.0), "peak_motor_torque": (0.01, 1000.0),
    "max_contact_pressure": (100.0, 1e6), "min_elbow_stiffness": (-1000.0, 1000.0), "min_spool_to_tendon": (1.0, 200.0),
    "peak_motor_speed": (0.01, 1000.0), "peak_motor_power": (0.01, 10000.0),
    "torque_constant": (1e-4, 1e3), "counts_per_turn": (2.0, 1e8),
    # Bodies.
    "stature": (0.8, 2.5), "weight": (15.0, 350.0), "acromion_radiale_length": (0.12, 0.60),
    "radiale_stylion_length": (0.10, 0.50), "forearm_grip_length": (0.12, 0.65), "biceps_circumference": (0.10, 0.80),
    "forearm_circumference": (0.10, 0.60), "wrist_circumference": (0.07, 0.35),
}  # fmt: skip
"""Range of each quantity on any limb, from a finger to a leg, in SI units.

The ranges are wide, so that a value outside of one is most likely a slip.
"""

AS_READ = ("pretension", "pretension_from", "pretension_to", "required_pretension", "margin")
"""Columns of pretensions, or of what the study sets instead (`setting.read`)."""
_OF_READINGS = {"motor torque": "peak_motor_torque"}
"""Quantity of a reading that is no tension."""


def dimension_of_reading(read: str) -> str:
    """Return the dimension of what is read: "force" or "torque"."""
    return QUANTITIES[_OF_READINGS.get(read, "pretension")].dimension


def unit_of_reading(read: str) -> str:
    """Return the SI unit of what is read: "N" or "N m"."""
    return SI_UNIT[dimension_of_reading(read)]


def in_unit_of_reading(quantity: Quantity, read: str) -> Quantity:
    """Return a quantity of a pretension in the dimension of what is read; any other as it is."""
    if quantity.dimension != "force" or quantity.name not in (*AS_READ, *_READ_LIMITS):
        return quantity
    unit = unit_of_reading(read)
    return replace(quantity, dimension=dimension_of_reading(read), unit=unit, shown_in=unit)


_READ_LIMITS = ("max_pretension", bound_name("max_pretension"), "reading_error")
"""Further numbers in the unit of the reading, without a column of their own."""
