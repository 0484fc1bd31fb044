"""A case as a machine in MuJoCo's modelling language, by the builder of `tendon export`."""

from __future__ import annotations

from tendon_cli.exports.mujoco import (
    ELBOW,
    EXTENSOR,
    FLEXOR,
    SPOOL,
    Chain,
    Machine,
    Strand,
    machine_xml,
)
from verification.cases import Case, Line

__all__ = ["ELBOW", "EXTENSOR", "FLEXOR", "SPOOL", "Chain", "mjcf"]

_LEAD = 20.0
"""Straight lead of a junction, m: for whatever travel the root search tries."""


def mjcf(case: Case) -> str:
    """Return the model of a case."""
    machine = Machine(
        a1=case.a1,
        b1=case.b1,
        a2=case.a2,
        b2=case.b2,
        elbow_radius=case.elbow_radius,
        upper_arm_angle=case.upper_arm_angle,
        forearm_mass=case.forearm_mass,
        forearm_com=case.forearm_com,
        load_mass=case.load_mass,
        load_distance=case.load_distance,
        flexor=_strand(case.flexor),
        extensor=_strand(case.extensor),
        flexor_radius=case.flexor_radius,
        ratio=case.ratio,
        from_initial=case.from_initial,
        lead=_LEAD,
    )
    return machine_xml(machine)


def _strand(line: Line) -> Strand:
    """Return tendon and spring of a side."""
    return Strand(
        length=line.length,
        tendon_stiffness=line.tendon_stiffness,
        spring_stiffness=line.spring_stiffness,
        pretension=line.pretension,
    )
