"""A choice of an answer as a model for MuJoCo, with a comment that says what the model lacks."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tendon_cli import say
from tendon_cli.errors import UsageError
from tendon_cli.exports.chosen import LOAD, ChosenSuit, scalar, without_friction
from tendon_cli.exports.mujoco import Keyframe, Machine, Strand, machine_xml
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design, Side
from tendon_cli.model.kinematics import Anchors, Spline
from tendon_cli.units import shorten
from tendon_cli.version import __version__

_SLENDER = 12.0
"""Moment of inertia of a slender rod about its middle: m l² / 12, with l twice the distance of its
centre of mass from the joint."""
_JUNCTION_MASS = 0.01
"""Mass of a junction, kg."""
_LONGEST = 120
"""Most characters of a name in the comment."""


def suit_xml(suit: ChosenSuit) -> str:
    """Return the model of a choice on the study's own arm, with the largest load of the conditions.

    Raises:
        UsageError: The travels of the tendons are measured, so that they have no path to lay.
    """
    load = suit.largest_load
    numbers = {} if load is None else {LOAD: np.array([load])}
    design = suit.design(numbers)
    machine = _machine(design)
    keyframes = [*_keyframes(suit, design, machine)]
    remarks = [*_remarks(suit, design)]
    return machine_xml(machine, suit.record.name, remarks, keyframes)


def _machine(design: Design) -> Machine:
    """Return the machine of a single design."""
    joint = design.arm.joint
    if not isinstance(joint, Anchors):
        raise UsageError(
            "the tendons' travels are measured (joint.excursion), so there is no path for MuJoCo",
            hint="`--to controller` and `--to parameters` do without one",
        )
    strands = [_strand(side) for side in (design.flexor, design.extensor)]
    arm = design.arm
    mass = scalar(arm.forearm_mass)
    centre = scalar(arm.forearm_com)
    about_joint = scalar(arm.inertia)
    inertia = about_joint - mass * centre**2
    if inertia <= 0.0:
        inertia = max(mass * (2.0 * centre) ** 2 / _SLENDER, 1e-6)
    stiffest = max(strand.parts[0] + strand.parts[1] for strand in strands)
    return Machine(
        a1=scalar(joint.a1),
        b1=scalar(joint.b1),
        a2=scalar(joint.a2),
        b2=scalar(joint.b2),
        elbow_radius=scalar(joint.elbow_radius),
        upper_arm_angle=scalar(arm.upper_arm_angle),
        forearm_mass=mass,
        forearm_com=centre,
        load_mass=scalar(design.load_mass),
        load_distance=scalar(arm.load_distance),
        flexor=strands[0],
        extensor=strands[1],
        flexor_radius=scalar(design.flexor_radius),
        ratio=scalar(design.ratio),
        from_initial=bool(scalar(joint.from_initial)),
        joint_stiffness=0.0 if arm.torque is not None else scalar(arm.stiffness),
        rest_angle=0.0 if arm.torque is not None else scalar(arm.rest_angle),
        forearm_inertia=inertia,
        junction_damping=2.0 * math.sqrt(stiffest * _JUNCTION_MASS),
    )


def _strand(side: Side) -> Strand:
    """Return tendon and spring of a side."""
    area = math.pi * scalar(side.diameter) ** 2 / 4.0
    compliance = 1.0 / scalar(side.spring_stiffness) + 1.0 / scalar(side.anchor_stiffness)
    return Strand(
        length=scalar(side.length),
        tendon_stiffness=area * scalar(side.youngs_modulus) / scalar(side.length),
        spring_stiffness=1.0 / compliance if compliance > 0.0 else math.inf,
        pretension=scalar(side.pretension),
    )


def _keyframes(suit: ChosenSuit, design: Design, machine: Machine) -> Iterator[Keyframe]:
    """Yield states of rest without friction at the first, the middle and the last elbow angle.

    A state with a slack side has none, since its junction may lie anywhere.
    """
    if design.arm.torque is not None or design.load_torque is not None:
        return  # the model lacks these torques, and so the states are not its own
    angles = np.unique(suit.question.angles)
    for angle in dict.fromkeys((angles[0], angles[len(angles) // 2], angles[-1])):
        state = State.of(without_friction(design), np.array([[angle]]), flexion=True)
        torque = scalar(state.motor_torque)
        flexor = scalar(state.balance.flexor)
        extensor = scalar(state.balance.extensor)
        if math.isnan(torque) or min(flexor, extensor) <= 0.0:
            continue
        flexor_spring = machine.flexor.parts[1]
        extensor_spring = machine.extensor.parts[1]
        flexor_stretch = (flexor - machine.flexor.pretension) / flexor_spring
        extensor_stretch = (extensor - machine.extensor.pretension) / extensor_spring
        yield Keyframe(
            name=f"{math.degrees(angle):g} deg",
            elbow=float(angle),
            spool=scalar(state.spool_angle),
            flexor=flexor_stretch + scalar(state.motion.flexor_travel),
            extensor=extensor_stretch - scalar(state.motion.extensor_travel),
            torque=torque,
        )


# --- The comment ----------------------------------------------------------------------------------


def _remarks(suit: ChosenSuit, design: Design) -> Iterator[str]:
    """Yield the lines of the comment: whose model it is, and what MuJoCo lacks."""
    record = suit.record
    unit = record.question.unit
    pretension = say.number(float(suit.choice.pretension or 0.0), 5)
    yield f"tendon {__version__}, study {record.study_hash[:12]}"
    yield shorten(suit.words, _LONGEST)
    yield f"set to {pretension} {unit} ({record.question.read})"
    yield f"load {say.quantity('load_mass', scalar(design.load_mass))}, the largest of the study"
    yield "SI units, rad; the elbow flexes and the spool winds the flexor in the positive sense"
    yield "motor: ctrl is its torque; keyframes are states of rest, with the torque that holds them"
    yield ""
    yield "What MuJoCo lacks, and so does this model:"
    for side_name, side in (("flexor", design.flexor), ("extensor", design.extensor)):
        yield f"- the {side_name}'s sheath: {_friction_words(side)}"
    if design.bend_follows_joint:
        yield "- a sheath that bends with the joint"
    if design.arm.torque is not None:
        yield "- the joint's own torque, which the study has as a curve"
    if design.load_torque is not None:
        yield "- the torque of the task"
    yield "- the strap's wrap beyond 140 deg"
    yield "Masses and inertias of spool and junctions are small and made up; so are the damping of"
    yield "the junctions and, unless the study states it, the inertia of the forearm."
    yield "No balance depends on them."


def _friction_words(side: Side) -> str:
    """Say the capstan friction of a side, which only tendon has."""
    friction = scalar(side.friction)
    if isinstance(side.bend_angle, Spline):
        return f"capstan friction, mu {say.number(friction)}, over a bend that follows the joint"
    bend = scalar(side.bend_angle)
    factor = say.number(math.exp(friction * bend))
    degrees = say.number(math.degrees(bend))
    return (
        f"capstan friction, mu {say.number(friction)} over {degrees} deg, which multiplies or "
        f"divides the tension by {factor}"
    )
