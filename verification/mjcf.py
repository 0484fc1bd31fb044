"""A case in MuJoCo's modelling language: the actuator built of the engine's own parts.

The upper arm is fixed at its inclination; forearm and load hang on a hinge under gravity. Each side
is a chain: spool - tendon in its sheath - free junction - spring - arm. The flexor's spring runs
straight from r to q, the extensor's wraps a cylinder at the elbow. A spool turns its angle times
its radius into tendon length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from verification.cases import Case


@dataclass(frozen=True)
class Chain:
    """Indices of the parts of one side among the model's tendons and joints."""

    path: int
    """Tendon without stiffness from anchor to anchor, for lengths and moment arms."""
    spring: int
    """Tendon from the junction over the anchors."""
    tendon: int
    """Tendon from the spool to the junction."""
    junction: int
    """Joint along which the end of the tendon, where the spring begins, slides."""


# Joints, each of one degree of freedom
ELBOW = 0
SPOOL = 1
FLEXOR = Chain(path=0, spring=2, tendon=4, junction=2)
EXTENSOR = Chain(path=1, spring=3, tendon=5, junction=3)

# x forward, z up the upper arm, so that flexion turns about -y. The junctions slide along y, out of
# the plane and 20 m away: a straight lead for whatever travel the root search tries, level at every
# inclination.
_MJCF = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 -9.81"><flag contact="disable"/></option>
  <default><joint damping="0" armature="0" frictionloss="0" limited="false"/></default>
  <worldbody>
    <body name="upper arm" axisangle="0 -1 0 {upper_arm_angle!r}">
      <site name="r" pos="{a1!r} 0 {b1!r}"/>
      <site name="extensor start" pos="{behind!r} 0 0.3"/>
      <geom name="pulley" type="cylinder" size="{elbow_radius!r} 0.01" zaxis="0 -1 0" mass="0"/>
      <site name="behind the elbow" pos="{side_x!r} 0 {side_z!r}"/>
      <body name="forearm">
        <joint name="elbow" type="hinge" axis="0 -1 0"/>
        <inertial pos="0 0 {com_z!r}" mass="{forearm_mass!r}" diaginertia="0.01 0.01 0.01"/>
        <site name="q" pos="{a2!r} 0 {minus_b2!r}"/>
        <site name="extensor end" pos="{behind!r} 0 -0.3"/>
        {load}
      </body>
      <body name="spool">
        <joint name="spool" type="hinge" axis="0 -1 0"/>
        <inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>
      </body>
      <body name="flexor junction" pos="{a1!r} 20 {b1!r}">
        <joint name="flexor junction" type="slide" axis="0 1 0"/>
        <inertial pos="0 0 0" mass="0.01" diaginertia="1e-6 1e-6 1e-6"/>
        <site name="flexor junction"/>
      </body>
      <body name="extensor junction" pos="{behind!r} 20 0.3">
        <joint name="extensor junction" type="slide" axis="0 1 0"/>
        <inertial pos="0 0 0" mass="0.01" diaginertia="1e-6 1e-6 1e-6"/>
        <site name="extensor junction"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <spatial name="flexor path"><site site="r"/><site site="q"/></spatial>
    <spatial name="extensor path">
      <site site="extensor start"/><geom geom="pulley" sidesite="behind the elbow"/>
      <site site="extensor end"/>
    </spatial>
    <spatial name="flexor spring" stiffness="{flexor_spring!r}">
      <site site="flexor junction"/><site site="r"/><site site="q"/>
    </spatial>
    <spatial name="extensor spring" stiffness="{extensor_spring!r}">
      <site site="extensor junction"/><site site="extensor start"/>
      <geom geom="pulley" sidesite="behind the elbow"/><site site="extensor end"/>
    </spatial>
    <fixed name="flexor tendon" stiffness="{flexor_tendon!r}">
      <joint joint="spool" coef="{flexor_radius!r}"/><joint joint="flexor junction" coef="-1"/>
    </fixed>
    <fixed name="extensor tendon" stiffness="{extensor_tendon!r}">
      <joint joint="spool" coef="{minus_extensor_radius!r}"/>
      <joint joint="extensor junction" coef="-1"/>
    </fixed>
  </tendon>
</mujoco>
"""
_LOAD = (
    '<body name="load" pos="0 0 {0!r}">'
    '<inertial pos="0 0 0" mass="{1!r}" diaginertia="1e-3 1e-3 1e-3"/></body>'
)
_MIDDLE_OF_WRAP = np.radians(70.0)
"""Direction of the side site, from straight behind towards the forearm: keeps the wrap on one side
from 0 to 140°."""


def mjcf(case: Case) -> str:
    """Return the model; every number is written so that it reads back exactly."""
    side = np.array([-np.cos(_MIDDLE_OF_WRAP), -np.sin(_MIDDLE_OF_WRAP)]) * 2.0 * case.elbow_radius
    numbers = {
        "a1": case.a1,
        "b1": case.b1,
        "a2": case.a2,
        "minus_b2": -case.b2,
        "elbow_radius": case.elbow_radius,
        "upper_arm_angle": case.upper_arm_angle,
        "forearm_mass": case.forearm_mass,
        "com_z": -case.forearm_com,
        # Closer than the pulley's rim, so that the tendon always wraps it
        "behind": -case.elbow_radius / 2.0,
        "side_x": side[0],
        "side_z": side[1],
        "flexor_radius": case.flexor_radius,
        "minus_extensor_radius": -case.ratio * case.flexor_radius,
        "flexor_spring": case.flexor.spring_stiffness,
        "extensor_spring": case.extensor.spring_stiffness,
        "flexor_tendon": case.flexor.tendon_stiffness,
        "extensor_tendon": case.extensor.tendon_stiffness,
    }
    load = ""
    if case.load_mass > 0.0:
        load = _LOAD.format(-float(case.load_distance), float(case.load_mass))
    # A float of Python, not of NumPy, is written as a plain number.
    plain = {name: float(value) for name, value in numbers.items()}
    return _MJCF.format(**plain, load=load)
