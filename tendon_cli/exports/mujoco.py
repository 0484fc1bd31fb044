"""A suit in MuJoCo's modelling language, built of the engine's own parts.

The upper arm is fixed at its inclination; forearm and load hang on a hinge under gravity. Each side
is a chain: spool - tendon in its sheath - free junction - spring - arm. The flexor's spring runs
straight from r to q, the extensor's wraps a cylinder at the elbow. A spool turns its angle times
its radius into tendon length.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

MARK = "<!-- written by tendon"
"""Beginning of a file that tendon wrote."""


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


# Joints, each of one degree of freedom.
ELBOW = 0
SPOOL = 1
FLEXOR = Chain(path=0, spring=2, tendon=4, junction=2)
EXTENSOR = Chain(path=1, spring=3, tendon=5, junction=3)


@dataclass(frozen=True)
class Strand:
    """Tendon and spring of one side, SI units."""

    length: float
    """Length of the tendon in its sheath, m."""
    tendon_stiffness: float
    """Stiffness of the tendon, A E / L, N/m."""
    spring_stiffness: float
    """Stiffness of spring and tissue in series, N/m; infinite if both are rigid."""
    pretension: float
    """Tension F0 at zero spool angle with the path at its reference length, N."""

    @property
    def parts(self) -> tuple[float, float]:
        """Stiffnesses of the tendon before the junction and of what follows it, N/m.

        A junction needs two elastic parts: half a tendon is twice as stiff.
        """
        if math.isinf(self.spring_stiffness):
            return 2.0 * self.tendon_stiffness, 2.0 * self.tendon_stiffness
        return self.tendon_stiffness, self.spring_stiffness


@dataclass(frozen=True)
class Machine:
    """Arm, tendons, springs and spool as MuJoCo has them; SI units, names as in the model."""

    a1: float
    b1: float
    a2: float
    b2: float
    elbow_radius: float
    upper_arm_angle: float
    forearm_mass: float
    forearm_com: float
    load_mass: float
    load_distance: float
    flexor: Strand
    extensor: Strand
    flexor_radius: float
    ratio: float
    from_initial: bool
    """True if the flexor's path has its reference length L_c(0) at 0 deg; else b1 + b2."""
    joint_stiffness: float = 0.0
    """Stiffness of the joint itself, N m/rad."""
    rest_angle: float = 0.0
    """Angle at which that stiffness exerts no torque, rad."""
    forearm_inertia: float = 0.01
    """Moment of inertia of forearm and hand about their centre of mass, kg m²."""
    junction_damping: float = 0.0
    """Damping of the junctions, N s/m, which only steadies a simulation."""
    lead: float = 1.0
    """Straight length between junction and arm at the start, m: the junction may travel as far."""

    @property
    def flexor_reference(self) -> float:
        """Length of the flexor's path at which its tension is F0 at zero spool angle, m."""
        if self.from_initial:
            return math.hypot(self.a2 - self.a1, self.b1 + self.b2)
        return self.b1 + self.b2

    @property
    def extensor_reference(self) -> float:
        """Length of the extensor's path at 0 deg, m: two tangents and the arc between them."""
        across = 0.5 * self.elbow_radius
        reach = math.hypot(across, _EXTENSOR_END)
        tangent = math.sqrt(reach**2 - self.elbow_radius**2)
        half_arc = math.atan2(_EXTENSOR_END, across) - math.acos(self.elbow_radius / reach)
        return 2.0 * (tangent + self.elbow_radius * half_arc)


@dataclass(frozen=True)
class Keyframe:
    """A state of rest without friction."""

    name: str
    elbow: float
    """Elbow angle, rad."""
    spool: float
    """Spool angle, rad."""
    flexor: float
    """Displacement of the flexor's junction, m."""
    extensor: float
    """Displacement of the extensor's junction, m."""
    torque: float
    """Motor torque, N m."""


_EXTENSOR_END = 0.3
"""Distance of the ends of the extensor's path from the elbow along the arm, m."""
_MIDDLE_OF_WRAP = math.radians(70.0)
"""Direction of the side site, from straight behind towards the forearm: keeps the wrap on one side
from 0 to 140 deg."""

# x forward, z up the upper arm, so that flexion turns about -y. The junctions slide along y, out of
# the plane: a straight lead, level at every inclination. A junction's position starts at minus the
# length of its tendon, so that the length of a fixed tendon is that of the real one.
_MJCF = """\
<mujoco model={name}>
  <compiler angle="radian"/>
  <option gravity="0 0 -9.81" timestep="0.0001" integrator="implicitfast">
    <flag contact="disable"/>
  </option>
  <default><joint damping="0" armature="0" frictionloss="0" limited="false"/></default>
  <worldbody>
    <body name="upper arm" axisangle="0 -1 0 {upper_arm_angle!r}">
      <site name="r" pos="{a1!r} 0 {b1!r}"/>
      <site name="extensor start" pos="{behind!r} 0 {extensor_end!r}"/>
      <geom name="pulley" type="cylinder" size="{elbow_radius!r} 0.01" zaxis="0 -1 0" mass="0"/>
      <site name="behind the elbow" pos="{side_x!r} 0 {side_z!r}"/>
      <body name="forearm">
        <joint name="elbow" type="hinge" axis="0 -1 0" stiffness="{joint_stiffness!r}"
          springref="{rest_angle!r}"/>
        <inertial pos="0 0 {com_z!r}" mass="{forearm_mass!r}"
          diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>
        <site name="q" pos="{a2!r} 0 {minus_b2!r}"/>
        <site name="extensor end" pos="{behind!r} 0 {minus_extensor_end!r}"/>
{load}      </body>
      <body name="spool">
        <joint name="spool" type="hinge" axis="0 -1 0"/>
        <inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>
      </body>
      <body name="flexor junction" pos="{a1!r} {flexor_lead!r} {b1!r}">
        <joint name="flexor junction" type="slide" axis="0 1 0" ref="{minus_flexor_length!r}"
          damping="{damping!r}"/>
        <inertial pos="0 0 0" mass="0.01" diaginertia="1e-6 1e-6 1e-6"/>
        <site name="flexor junction"/>
      </body>
      <body name="extensor junction" pos="{behind!r} {extensor_lead!r} {extensor_end!r}">
        <joint name="extensor junction" type="slide" axis="0 1 0" ref="{minus_extensor_length!r}"
          damping="{damping!r}"/>
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
    <spatial name="flexor spring" stiffness="{flexor_spring!r}"
      springlength="0 {flexor_spring_natural!r}">
      <site site="flexor junction"/><site site="r"/><site site="q"/>
    </spatial>
    <spatial name="extensor spring" stiffness="{extensor_spring!r}"
      springlength="0 {extensor_spring_natural!r}">
      <site site="extensor junction"/><site site="extensor start"/>
      <geom geom="pulley" sidesite="behind the elbow"/><site site="extensor end"/>
    </spatial>
    <fixed name="flexor tendon" stiffness="{flexor_tendon!r}"
      springlength="0 {flexor_tendon_natural!r}">
      <joint joint="spool" coef="{flexor_radius!r}"/><joint joint="flexor junction" coef="-1"/>
    </fixed>
    <fixed name="extensor tendon" stiffness="{extensor_tendon!r}"
      springlength="0 {extensor_tendon_natural!r}">
      <joint joint="spool" coef="{minus_extensor_radius!r}"/>
      <joint joint="extensor junction" coef="-1"/>
    </fixed>
  </tendon>
  <actuator><motor name="motor" joint="spool" gear="1"/></actuator>
{keys}</mujoco>
"""
_LOAD = """\
        <body name="load" pos="0 0 {0!r}">
          <inertial pos="0 0 0" mass="{1!r}" diaginertia="1e-3 1e-3 1e-3"/>
        </body>
"""


def machine_xml(
    machine: Machine,
    name: str = "suit",
    remarks: Sequence[str] = (),
    keyframes: Sequence[Keyframe] = (),
) -> str:
    """Return the model; every number is written so that it reads back exactly.

    Args:
        machine: Arm, tendons, springs and spool.
        name: Name of the model.
        remarks: Lines of the comment at the beginning.
        keyframes: States of rest without friction.
    """
    numbers: dict[str, float] = {
        "a1": machine.a1,
        "b1": machine.b1,
        "a2": machine.a2,
        "minus_b2": -machine.b2,
        "elbow_radius": machine.elbow_radius,
        "upper_arm_angle": machine.upper_arm_angle,
        "forearm_mass": machine.forearm_mass,
        "com_z": -machine.forearm_com,
        "inertia": machine.forearm_inertia,
        "joint_stiffness": machine.joint_stiffness,
        "rest_angle": machine.rest_angle,
        "damping": machine.junction_damping,
        # Closer than the pulley's rim, so that the tendon always wraps it.
        "behind": -0.5 * machine.elbow_radius,
        "side_x": -2.0 * machine.elbow_radius * math.cos(_MIDDLE_OF_WRAP),
        "side_z": -2.0 * machine.elbow_radius * math.sin(_MIDDLE_OF_WRAP),
        "extensor_end": _EXTENSOR_END,
        "minus_extensor_end": -_EXTENSOR_END,
        "flexor_radius": machine.flexor_radius,
        "minus_extensor_radius": -machine.ratio * machine.flexor_radius,
    }
    references = (machine.flexor_reference, machine.extensor_reference)
    strands = (machine.flexor, machine.extensor)
    for side, strand, reference in zip(("flexor", "extensor"), strands, references, strict=True):
        tendon, spring = strand.parts
        lead = machine.lead + strand.pretension / spring
        numbers |= {
            f"{side}_lead": lead,
            f"minus_{side}_length": -strand.length,
            f"{side}_tendon": tendon,
            f"{side}_spring": spring,
            f"{side}_tendon_natural": strand.length - strand.pretension / tendon,
            f"{side}_spring_natural": lead + reference - strand.pretension / spring,
        }
    load = ""
    if machine.load_mass > 0.0:
        load = _LOAD.format(-float(machine.load_distance), float(machine.load_mass))
    # A float of Python, not of NumPy, is written as a plain number.
    plain = {key: float(value) for key, value in numbers.items()}
    keys = _keys(machine, keyframes)
    model = _MJCF.format(**plain, load=load, keys=keys, name=quoteattr(name))
    return _comment(remarks) + model


def _comment(remarks: Sequence[str]) -> str:
    """Return the comment at the beginning; two hyphens in a row would end it."""
    lines = [MARK, *(re.sub("-(?=-)", "- ", f"  {remark}") for remark in remarks), "-->"]
    return "\n".join(lines) + "\n"


def _keys(machine: Machine, keyframes: Sequence[Keyframe]) -> str:
    """Return states of rest as keyframes; empty without any."""
    if not keyframes:
        return ""
    lines = []
    for key in keyframes:
        flexor = key.flexor - machine.flexor.length
        extensor = key.extensor - machine.extensor.length
        position = " ".join(repr(float(x)) for x in (key.elbow, key.spool, flexor, extensor))
        torque = repr(float(key.torque))
        lines.append(f'    <key name={quoteattr(key.name)} qpos="{position}" ctrl="{torque}"/>\n')
    return f"  <keyframe>\n{''.join(lines)}  </keyframe>\n"
