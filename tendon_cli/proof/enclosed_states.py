"""States of designs over cells of the angle and of a box of numbers, as series.

The tensions follow from the general balance,

    x = (τ c_e + J_e D)/det,   y = (J_f D - η c_f τ)/det,   det = J_f c_e + η J_e c_f
    D = H_e - η H_f + (η c_f + c_e)_0 F

which encloses joints and bends that follow measured curves, too. SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, map_arrays
from tendon_cli.model.kinematics import AnyJoint, Array, Excursion, Flags, Spline
from tendon_cli.model.sheath import sheaths_of
from tendon_cli.proof.series import COMPUTED, Series

_FAR = 1e12
"""Bound that nothing reaches, SI, for cells without a limit that others have."""


def box_design(design: Design, ends: Sequence[Design], middle: Array, half: Array | None) -> Design:
    """Return designs in which the numbers of a box are series, linear in their shares.

    Args:
        design: Designs in the middle of the box, (cells,).
        ends: For each number of the box the designs at its upper end.
        middle: Middle of each cell as shares of the way to the end, (cells, numbers).
        half: Half-width of each cell likewise; None for the middles alone, without derivatives.
    """

    def moving(number: Any, *at_ends: Any) -> Any:
        if number.dtype != np.float64:
            return number
        for place, end in enumerate(at_ends):
            distance = np.where((number == end) | np.isnan(number), 0.0, end - number)
            if np.any(distance):
                value = number + distance * middle[:, place]
                if half is None:
                    return Series.point(value, distance)
                radius = np.abs(distance) * half[:, place]
                return Series.number(value, radius, distance, place)
        return number

    boxed: Design = map_arrays(design, moving, *ends)
    return boxed


def limit_values(state: Any, bounds: Bounds) -> Iterator[Series]:
    """Yield series that must not be negative: moment arms, tensions and distances to limits."""
    yield from state.arms
    yield state.x
    yield state.y
    bounds = bounds.of(state.design)
    for limit in bounds.asked:
        if limit.forms is None:
            continue
        for form in limit.forms(state, bounds.speed):
            value = Series.of(form.constant, COMPUTED)
            for share, part in (
                (form.flexor, state.x),
                (form.extensor, state.y),
                (form.stiffness, state.stiffness),
            ):
                value = value + Series.of(share, COMPUTED) * part
            least, most = limit.range_of(np.clip(bounds[limit.name], -_FAR, _FAR))
            if least is not None:
                yield value - least
            if most is not None:
                yield most - value


def enclose_states(
    design: Design, middle: Array, half: Array, flexion: Flags, pretension: Array, order: int
) -> SimpleNamespace:
    """Return states over cells as series, under the names that forms of limits ask a `State` for.

    Args:
        design: Designs, (cells,), whose numbers may be series.
        middle: Middle of each cell of the angle, rad.
        half: Half-width of each cell, rad.
        flexion: True in flexion, else extension.
        pretension: Pretension in each cell, N.
        order: Highest power of the series.
    """
    angle: Any = Series.variable(middle, half, order)
    path, flexor_travel, extensor_travel = _travels(design.arm.joint, angle)
    arm = flexor_travel.slope()
    extensor_arm = extensor_travel.slope()
    ratio = design.ratio

    sides = _in_series(design.flexor), _in_series(design.extensor)
    flexor, extensor = sheaths_of(*sides, angle, flexion)
    c_f = Series.of(flexor.compliance, COMPUTED)
    c_e = Series.of(extensor.compliance, COMPUTED)
    resting_c_f = c_f
    resting_c_e = c_e
    if design.bend_follows_joint:
        resting_angle: Any = Series.of(design.setting.angle)
        resting_sheaths = sheaths_of(*sides, resting_angle, flexion)
        resting_c_f, resting_c_e = (
            Series.of(sheath.compliance, COMPUTED) for sheath in resting_sheaths
        )

    torque = _torque(design, angle)
    common = ratio * resting_c_f + resting_c_e
    stretch = extensor_travel - ratio * flexor_travel + common * pretension  # D
    det = arm * c_e + extensor_arm * (ratio * c_f)
    x = (torque * c_e + extensor_arm * stretch) / det
    y = (arm * stretch - ratio * c_f * torque) / det
    flexor_slope = arm.slope() - arm * c_f.slope() / c_f
    extensor_slope = extensor_arm.slope() - extensor_arm * c_e.slope() / c_e
    stiffness = (
        arm * arm / c_f
        + extensor_arm * extensor_arm / c_e
        + torque.slope()
        - flexor_slope * x
        + extensor_slope * y
    )
    return SimpleNamespace(
        arms=(arm, extensor_arm),
        is_pressed=design.arm.is_pressed(middle, half),
        x=x,
        y=y,
        stiffness=stiffness,
        flexor=flexor,
        extensor=extensor,
        design=design,
        motion=SimpleNamespace(flexor_path=path),
        rates=None,
        coupling=SimpleNamespace(
            ratio=ratio,
            extensor_arm=extensor_arm,
            moment_arm=arm,
            flexor_compliance=c_f,
            extensor_compliance=c_e,
        ),
        motor_arms=(
            design.flexor_radius / flexor.capstan,
            ratio * design.flexor_radius / extensor.capstan,
        ),
    )


def _travels(joint: AnyJoint, angle: Any) -> tuple[Any, Any, Any]:
    """Return the flexor's path, None if the joint does not define it, and both travels, m."""
    if isinstance(joint, Excursion):
        origin: Any = Series.of(joint.origin)
        flexor_travel = (joint.flexor(angle) - joint.flexor(origin)) * joint.scale
        extensor_travel = (joint.extensor(angle) - joint.extensor(origin)) * joint.scale
        return None, flexor_travel, extensor_travel
    a1, b1, a2, b2 = (Series.of(offset) for offset in (joint.a1, joint.b1, joint.a2, joint.b2))
    squares = a1 * a1 + b1 * b1 + a2 * a2 + b2 * b2
    along = 2.0 * (b1 * b2 - a1 * a2)
    across = 2.0 * (a1 * b2 + a2 * b1)
    path = np.sqrt(squares + along * np.cos(angle) - across * np.sin(angle))
    initial_path = np.sqrt(squares + along)
    reference = np.where(joint.from_initial, initial_path, b1 + b2)
    return path, reference - path, angle * joint.elbow_radius


def _torque(design: Design, angle: Any) -> Any:
    """Return the torque that weights, joint and task need, N m."""
    weights: Any = Series.of(design.gravity_moment, COMPUTED)
    return weights * np.sin(angle + design.arm.upper_arm_angle) + design.other_torque(angle)


def _in_series(side: Any) -> Any:
    """Return a side with series for all of its numbers, so that nothing is rounded unnoticed.

    A side of plain numbers that does not bend with the joint stays as it is.
    """
    numbers = {name: value for name, value in vars(side).items() if name != "spring_at_motor"}
    if not any(isinstance(value, Series | Spline) for value in numbers.values()):
        return side
    series = {
        name: value if isinstance(value, Spline) else Series.of(value)
        for name, value in numbers.items()
    }
    return replace(side, **series)
