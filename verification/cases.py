"""Random arms and designs, one state each, without friction.

Cases hold numbers only, so that tendon and the engine read the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SEED = 20260101


@dataclass(frozen=True)
class Line:
    """A tendon with its spring, SI units."""

    length: float
    diameter: float
    youngs_modulus: float
    spring_stiffness: float
    pretension: float
    bend_angle: float
    """Bend of the sheath, rad; without friction nothing depends on it, and the engine gets none."""

    @property
    def tendon_stiffness(self) -> float:
        """Stiffness of a round tendon, A E / L, N/m."""
        return float(np.pi * self.diameter**2 / 4.0 * self.youngs_modulus / self.length)


@dataclass(frozen=True)
class Case:
    """An arm, a design and one elbow angle: SI units, rad, names as in `tendon_cli.model`."""

    a1: float
    b1: float
    a2: float
    b2: float
    elbow_radius: float
    elbow_angle: float
    upper_arm_angle: float
    forearm_mass: float
    forearm_com: float
    load_mass: float
    load_distance: float
    flexor: Line
    extensor: Line
    flexor_radius: float
    ratio: float
    from_initial: bool
    flexion: bool


def draw_cases(number: int) -> list[Case]:
    """Draw cases, the same on every machine.

    One in ten has its forearm along the vertical, where nothing weighs.
    """
    rng = np.random.default_rng(SEED)
    return [_draw_case(rng, weightless=index % 10 == 0) for index in range(number)]


def _draw_case(rng: np.random.Generator, *, weightless: bool) -> Case:
    """Draw a case between a child's arm and a tall man's.

    The upper arm lies between far back and overhead, where extensors lift. Weightless cases are
    bent far, where both tendons go slack unless pretension is high.
    """
    if weightless:
        elbow_angle = np.radians(rng.uniform(60.0, 130.0))
        pretension = rng.choice([20.0, 400.0])
    else:
        elbow_angle = np.radians(rng.uniform(0.0, 130.0))
        pretension = 250.0
    return Case(
        a1=rng.uniform(0.02, 0.08),
        b1=rng.uniform(0.10, 0.26),
        a2=rng.uniform(0.01, 0.05),
        b2=rng.uniform(0.08, 0.24),
        elbow_radius=rng.uniform(0.025, 0.06),
        elbow_angle=elbow_angle,
        upper_arm_angle=-elbow_angle if weightless else np.radians(rng.uniform(-100.0, 180.0)),
        forearm_mass=rng.uniform(0.7, 2.2),
        forearm_com=rng.uniform(0.12, 0.20),
        load_mass=rng.choice([0.0, rng.uniform(0.0, 10.0)]),
        load_distance=rng.uniform(0.20, 0.38),
        flexor=_draw_line(rng, pretension),
        extensor=_draw_line(rng, pretension),
        flexor_radius=rng.uniform(0.01, 0.05),
        ratio=rng.uniform(0.5, 1.5),
        from_initial=bool(rng.integers(2)),
        flexion=bool(rng.integers(2)),
    )


def _draw_line(rng: np.random.Generator, pretension: float) -> Line:
    """Draw a line: steel or fibre, half a metre to three, springs from soft to nearly rigid."""
    return Line(
        length=rng.uniform(0.5, 3.0),
        diameter=rng.uniform(0.8e-3, 2.0e-3),
        youngs_modulus=rng.uniform(60e9, 200e9),
        spring_stiffness=10.0 ** rng.uniform(3.0, 4.5),
        pretension=rng.uniform(0.0, pretension),
        bend_angle=rng.uniform(0.0, 2.0 * np.pi),
    )
