"""Suits on drawn arms by Monte Carlo, in plain NumPy from the physics alone.

Nothing of the model, the windows or the draws of tendon is used: bodies come from the survey's
means, deviations and correlations, and each is tried at one reading of a gauge.
"""

import tomllib
from dataclasses import dataclass
from importlib import resources

import numpy as np

CONTACT_FROM = np.radians(10.0)
"""Elbow angle from which the strap presses, rad."""

GRAVITY = 9.81
DIRECTIONS = (-1.0, 1.0)  # sign of friction in the flexor: flexion, extension


def survey():
    """Return the survey by sex."""
    text = resources.files("tendon_cli.studies.people").joinpath("ansur2_arm.toml").read_text()
    return tomllib.loads(text)


def bodies(count, random):
    """Return bodies by dimension (SI), (count,) each, the mean man, and True for women."""
    statistics = survey()
    names = statistics["dimensions"]
    units = np.array([1.0 if name == "weight" else 1e-3 for name in names])
    men = statistics["male"]["persons"]
    women = statistics["female"]["persons"]
    is_woman = random.random(count) < women / (men + women)
    values = np.empty((count, len(names)))
    for sex, members in (("male", ~is_woman), ("female", is_woman)):
        mean = np.array(statistics[sex]["mean"])
        deviation = np.array(statistics[sex]["standard_deviation"])
        correlation = np.array(statistics[sex]["correlation"])
        covariance = correlation * np.outer(deviation, deviation)
        drawn = random.multivariate_normal(mean, covariance, members.sum())
        values[members] = np.maximum(drawn, mean - 3.0 * deviation)
    mean_man = np.array(statistics["male"]["mean"]) * units
    columns = (values * units).T
    return dict(zip(names, columns, strict=True)), dict(zip(names, mean_man, strict=True)), is_woman


def arm_volume(body):
    """Return l_ar C_bi² + l_rs C_fo²."""
    return (
        body["acromion_radiale_length"] * body["biceps_circumference"] ** 2
        + body["radiale_stylion_length"] * body["forearm_circumference"] ** 2
    )


@dataclass
class Arms:
    """Arms with a suit, (arms, 1) each, SI; scalars broadcast."""

    a1: np.ndarray
    b1: np.ndarray
    a2: np.ndarray
    b2: np.ndarray
    radius: np.ndarray
    forearm_mass: np.ndarray
    forearm_com: np.ndarray
    load_distance: np.ndarray
    joint_stiffness: np.ndarray
    rest_angle: np.ndarray
    flexor_tissue: np.ndarray
    extensor_tissue: np.ndarray
    stiffness: float = 7e3
    ratio: float = 0.6
    spool: float = 0.03
    friction: float = 0.07
    bend: float = np.pi
    length: float = 2.0
    diameter: float = 1.5e-3
    modulus: float = 145e9

    @classmethod
    def of(cls, body, mean_man, **numbers):
        """Return arms of bodies: the paper's anchors scaled, weights from the body."""

        def scaled(value, dimension):
            return (value * body[dimension] / mean_man[dimension])[:, np.newaxis]

        arm = {
            "a1": scaled(0.04, "biceps_circumference"),
            "b1": scaled(0.15, "acromion_radiale_length"),
            "a2": scaled(0.02, "forearm_circumference"),
            "b2": scaled(0.15, "radiale_stylion_length"),
            "radius": scaled(0.045, "forearm_circumference"),
            "forearm_mass": 0.022 * body["weight"][:, np.newaxis],
            "forearm_com": 0.682 * body["radiale_stylion_length"][:, np.newaxis],
            "load_distance": body["forearm_grip_length"][:, np.newaxis],
        }
        for name, value in numbers.items():
            shape = np.ndim(value)
            column = np.asarray(value)[:, np.newaxis] if shape == 1 else value
            arm[name] = arm[name] * column if name in arm else column
        return cls(**arm)

    def torque(self, angle, tilt, load):
        """Return the torque that the tendons must give, and its slope."""
        weight = GRAVITY * (self.forearm_mass * self.forearm_com + load * self.load_distance)
        torque = weight * np.sin(angle + tilt) + self.joint_stiffness * (angle - self.rest_angle)
        return torque, weight * np.cos(angle + tilt) + self.joint_stiffness

    def lines(self, angle, tilt, load, sign):
        """Return both distal tensions and the stiffness as lines (value at F0 = 0, slope)."""
        proximal = np.hypot(self.a1, self.b1)
        distal = np.hypot(self.a2, self.b2)
        opening = np.pi - angle - np.arctan2(self.a1, self.b1) - np.arctan2(self.a2, self.b2)
        path = np.sqrt(proximal**2 + distal**2 - 2.0 * proximal * distal * np.cos(opening))
        moment_arm = proximal * distal * np.sin(opening) / path
        step = 1e-5
        wider = opening + step
        narrower = opening - step

        def arm_at(place):
            length = np.sqrt(proximal**2 + distal**2 - 2.0 * proximal * distal * np.cos(place))
            return proximal * distal * np.sin(place) / length

        slope_of_arm = (arm_at(narrower) - arm_at(wider)) / (2.0 * step)
        flexor_travel = self.b1 + self.b2 - path
        extensor_travel = self.radius * angle
        flexor = self.compliance(sign, self.flexor_tissue)
        extensor = self.compliance(-sign, self.extensor_tissue)
        torque, slope = self.torque(angle, tilt, load)
        both = self.ratio * flexor + extensor
        mismatch = extensor_travel - self.ratio * flexor_travel
        matrix = moment_arm * extensor + self.radius * self.ratio * flexor
        x = ((torque * extensor + self.radius * mismatch) / matrix, self.radius * both / matrix)
        y = (
            (moment_arm * mismatch - self.ratio * flexor * torque) / matrix,
            moment_arm * both / matrix,
        )
        stiffness = moment_arm**2 / flexor + self.radius**2 / extensor + slope
        return x, y, (stiffness - slope_of_arm * x[0], -slope_of_arm * x[1])

    def compliance(self, sign, tissue):
        """Return length per distal tension of a side: rope in its sheath, spring and tissue."""
        exponent = sign * self.friction * self.bend
        area = np.pi / 4.0 * self.diameter**2
        rope = self.length / (self.modulus * area) * -np.expm1(-exponent) / exponent
        return rope + 1.0 / self.stiffness + 1.0 / tissue

    def capstan(self, sign):
        """Return distal over proximal tension."""
        return np.exp(sign * self.friction * self.bend)

    def pretension(self, reading, read):
        """Return F0 of a reading after extension, arm hanging, hand empty."""
        sign = DIRECTIONS[1]
        x, y, _ = self.lines(0.0, 0.0, 0.0, sign)
        flexor = [part / self.capstan(sign) for part in x]
        extensor = [part / self.capstan(-sign) for part in y]
        value, slope = {
            "pretension": (0.0, 1.0),
            "flexor at joint": x,
            "extensor at joint": y,
            "motor torque": [
                self.spool * (of_flexor - self.ratio * of_extensor)
                for of_flexor, of_extensor in zip(flexor, extensor, strict=True)
            ],
        }[read]
        return (reading - value) / slope

    def keeps(self, pretension, angles, tilts, loads, width, pressure, presses_from=CONTACT_FROM):
        """Return True for arms that keep taut, stable and below a pressure in all states."""
        kept = pretension[:, 0] >= 0.0
        for tilt in tilts:
            for load in loads:
                for sign in DIRECTIONS:
                    x, y, k = (
                        value + slope * pretension
                        for value, slope in self.lines(angles, tilt, load, sign)
                    )
                    pressed = np.where(angles >= presses_from, y / (self.radius * width), 0.0)
                    good = (x >= 0.0) & (y >= 0.0) & (k >= 0.0) & (pressed <= pressure)
                    kept &= good.all(axis=1)
        return kept


def robust(
    count,
    seed,
    *,
    scatter=True,
    log_tissue=False,
    residual=0.0,
    presses_from=CONTACT_FROM,
    **change,
):
    """Return which of `count` persons a suit serves, and who is a woman.

    The suit has springs of 7 kN/m, a spool ratio of 0.6 and a strap of 100 mm, 116 N in the flexor.

    Args:
        count: Number of persons.
        seed: Seed of the draws.
        scatter: True to draw the joint, the tissue and the reading of each person.
        log_tissue: True to draw tissue with a uniform logarithm.
        residual: Standard deviation of the stiffness of the joint about that by volume, a share.
        presses_from: Elbow angle from which the strap presses, rad.
        **change: `tilts` (rad), `loads` (kg), `reading` (N), `top` (rad), `gauge` (N).
    """
    random = np.random.default_rng(seed)
    body, mean_man, is_woman = bodies(count, random)

    def around(share):
        return random.uniform(1.0 - share, 1.0 + share, count)

    fit = {"a1": 0.15, "a2": 0.15, "b1": 0.1, "b2": 0.1, "radius": 0.1}
    numbers = {name: around(share) for name, share in fit.items()}
    numbers |= {
        "joint_stiffness": 1.1,
        "rest_angle": np.radians(73.0),
        "flexor_tissue": 10e3,
        "extensor_tissue": 10e3,
    }
    error = 0.0
    if scatter:
        volume = arm_volume(body) / arm_volume(mean_man)
        numbers["joint_stiffness"] = 1.1 * volume * (1.0 + residual * random.standard_normal(count))
        numbers["rest_angle"] = np.radians(random.normal(73.0, 10.0, count))
        for side in ("flexor_tissue", "extensor_tissue"):
            if log_tissue:
                numbers[side] = np.exp(random.uniform(np.log(5e3), np.log(20e3), count))
            else:
                numbers[side] = random.uniform(5e3, 20e3, count)
        error = random.normal(0.0, change.get("gauge", 5.0), count)[:, np.newaxis]
    arms = Arms.of(body, mean_man, **numbers)
    pretension = arms.pretension(change.get("reading", 116.0) - error, "flexor at joint")
    served = arms.keeps(
        pretension,
        np.linspace(0.0, change.get("top", np.pi / 2.0), 91),
        change.get("tilts", np.radians([-15.0, 0.0, 15.0])),
        change.get("loads", (0.0, 5.0)),
        0.1,
        52.9e3,
        presses_from,
    )
    return served, is_woman


def papers_arm(stiffness):
    """Return the paper's arm with springs of a stiffness and a spool ratio of 0.6."""
    return Arms(
        a1=0.04,
        b1=0.15,
        a2=0.02,
        b2=0.15,
        radius=0.045,
        forearm_mass=1.54,
        forearm_com=0.174,
        load_distance=0.32,
        joint_stiffness=0.0,
        rest_angle=0.0,
        flexor_tissue=np.inf,
        extensor_tissue=np.inf,
        stiffness=stiffness,
    )
