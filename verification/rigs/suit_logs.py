"""Logs of a suit of elastic links, with faults whose truth is known.

    log = make_log(seed=3, fault="torque constant")
    log.study      # dictionary as a study file has it: what somebody would state
    log.texts      # CSV files, as text
    log.truth      # true numbers of suit and sensors, and what a fit should do

A fault changes the suit (`suit`), its motion (`moves`) or its sensors (`reads`); each is a row of
`FAULTS`. `random_suits` draws suits whose geometry, masses and sensors differ from their study as
the tolerances of a fit say. Many logs are simulated at once: `make_logs`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from .elastic_links import History, Motion, Rig, simulate
from .gripped_cables import Array
from .plain_dictionary import BASELINE, make_rig, merged
from .random_motions import rounded, study_numbers

LOADS = (0.0, 2.0, 4.0)
"""Loads of a session, a log each, kg."""

CYCLES = 4
"""Cycles of a log."""

CYCLE = 8.0
"""Duration of a cycle, s."""

RATE = 50.0
"""Rows a second."""

ANGLE_NOISE = 1e-3
"""Standard deviation of both angles' noise, rad."""

TORQUE_NOISE = 0.02
"""Standard deviation of the motor torque's noise, N m."""

TENSION_NOISE = 0.5
"""Standard deviation of a load cell's noise, N."""

NODES = 16
"""Nodes of each sheath."""

DEGREE = np.pi / 180.0

FITTED = {
    "sheath.friction": "0.01 to 0.3",
    "tendon.pretension": "40 N to 400 N",
    "anchor.stiffness": "2 kN/m to 60 kN/m",
    "joint.stiffness": "0 N m/rad to 5 N m/rad",
}
"""Numbers that a study leaves to the fit, and the range that it states."""

PRIORS = {
    "arm.a1": 5e-3,
    "arm.b1": 5e-3,
    "arm.a2": 5e-3,
    "arm.b2": 5e-3,
    "arm.elbow_radius": 3e-3,
    "arm.upper_arm_angle": 2.0 * DEGREE,
    "joint.rest_angle": 10.0 * DEGREE,
}
"""Standard deviations of numbers that a study states as if they were exact, m or rad."""

RELATIVE_PRIORS = {
    "arm.forearm_mass": 0.05,
    "load.mass": 0.05,
    "arm.forearm_com": 0.02,
    "arm.load_distance": 0.02,
    "tendon.length": 0.02,
    "tendon.youngs_modulus": 0.1,
    "sheath.bend_angle": 0.02,
    "spring.stiffness": 0.05,
    "spool.flexor_radius": 0.005,
    "spool.ratio": 0.01,
}
"""The same of masses, lengths and parts, as shares of the number."""


@dataclass(frozen=True)
class Sensors:
    """Errors of the sensors of a suit.

    Attributes:
        spool_zero: Reading of the spool's angle at the set-up, rad.
        torque_zero: Reading of the torque at rest, N m.
        torque_gain: Reading per torque: a stated torque constant over the true one.
        coulomb: Friction of the gear, against the spool's speed, N m.
        viscous: The same per speed, N m s/rad.
        backlash: Free way of the gear, rad of spool angle.
        joint_zero: Reading of the joint's angle less the angle, at zero, rad.
        joint_gain: Reading per angle.
        spool_delay: Time by which the spool's angle is late, s.
        torque_delay: The same of the torque, s.
        joint_delay: The same of the joint's angle, s.
        torque_drift: Rise of the torque's zero over a log, N m.
    """

    spool_zero: float = 0.0
    torque_zero: float = 0.0
    torque_gain: float = 1.0
    coulomb: float = 0.0
    viscous: float = 0.0
    backlash: float = 0.0
    joint_zero: float = 0.0
    joint_gain: float = 1.0
    spool_delay: float = 0.0
    torque_delay: float = 0.0
    joint_delay: float = 0.0
    torque_drift: float = 0.0


@dataclass(frozen=True)
class Session:
    """A suit, its wearer and its sensors through a few logs.

    Attributes:
        suit: True numbers of the suit, as `make_rig` takes them, but for the load.
        stated: Numbers that the study states, in the same form.
        sensors: Sensors.
        loads: True load of each log, kg.
        stated_loads: Load of each log as stated, kg.
        angles: Joint's angle of each log at the samples (samples,), rad.
        rate: Samples a second.
        task: Torque that something else takes from the suit, of each log, N m.
        slip: Slip of the anchors, of each log, m.
        hardening: Share by which tissue is stiffer at twice the pretension.
        tensions: Names of the tensions that are logged, as columns of states.
        noise: Factor on all noise.
    """

    suit: Mapping[str, Any]
    stated: Mapping[str, Any]
    sensors: Sensors
    loads: tuple[float, ...]
    stated_loads: tuple[float, ...]
    angles: tuple[Array, ...]
    rate: float = RATE
    task: tuple[Array, ...] = ()
    slip: tuple[Array, ...] = ()
    hardening: float = 0.0
    tensions: tuple[str, ...] = ()
    noise: float = 1.0

    @property
    def time(self) -> Array:
        """Instants of a log, s."""
        return np.arange(len(self.angles[0])) / self.rate


Suits = Callable[[Session, np.random.Generator], Session]
Reads = Callable[[pd.DataFrame, np.random.Generator], pd.DataFrame]
Writes = Callable[[list[pd.DataFrame]], list[str]]


def as_they_are(frames: list[pd.DataFrame]) -> list[str]:
    """Write logs as comma-separated text."""
    return [frame.to_csv(index=False, float_format="%.6g") for frame in frames]


@dataclass(frozen=True)
class LogFault:
    """A kind of log.

    Attributes:
        expects: "right" if the fit should have the numbers, and need not warn of them; "warned"
            if it must warn; "either" if it may do one of the two; "refused" if there is nothing
            to be fitted.
        pattern: Name of the pattern in the residuals, or "".
        suit: Change of suit, wearer, motion or constant errors of sensors.
        reads: Change of the rows of a log.
        writes: Way to write the logs.
    """

    expects: str = "right"
    pattern: str = ""
    suit: Suits | None = None
    reads: Reads | None = None
    writes: Writes = as_they_are


@dataclass(frozen=True)
class SuitLog:
    """A study, its logs and the truth.

    Attributes:
        fault: Name of the kind of log.
        seed: Number that it was drawn with.
        study: Study as a file has it; its loads are those of the logs, in their order.
        texts: CSV text of each log.
        loads: Stated load of each log, kg; a log has its load in a column as well.
        truth: `numbers` {key of the study: value, SI}, `loads`, `sensors` {name: value},
            `inertia` of the arm without the load, `expects`, `pattern`.
    """

    fault: str
    seed: int
    study: dict[str, Any]
    texts: list[str]
    loads: tuple[float, ...]
    truth: dict[str, Any]


def get(suit: Mapping[str, Any], key: str) -> Any:
    """Return a number of a suit by its key, as `arm.b1`."""
    part, name = key.split(".")
    return suit[part][name]


def change(suit: Mapping[str, Any], key: str, value: Any) -> dict[str, Any]:
    """Return a suit with another number."""
    part, name = key.split(".")
    return merged(suit, {part: {name: value}})


def strokes(
    low: Array | float,
    high: Array | float,
    cycle: float = CYCLE,
    cycles: int = CYCLES,
    rate: float = RATE,
) -> Array:
    """Return a joint's angle that goes up and down by cosines, rad; limits may differ by sample."""
    time = np.arange(round(cycles * cycle * rate)) / rate
    middle = 0.5 * (np.asarray(low) + np.asarray(high))
    half = 0.5 * (np.asarray(high) - np.asarray(low))
    return middle - half * np.cos(2.0 * np.pi * time / cycle)


def draw_session(rng: np.random.Generator) -> Session:
    """Draw a suit that is as its study says, and its motions."""
    stated = merged(
        BASELINE,
        {
            "sheath": {"friction": rounded(rng.uniform(0.04, 0.14))},
            "tendon": {"pretension": rounded(rng.uniform(140.0, 230.0))},
            "spring": {"stiffness": rounded(rng.uniform(4e3, 9e3))},
            "anchor": {"stiffness": rounded(rng.uniform(6e3, 2e4))},
            "spool": {
                "ratio": rounded(rng.uniform(0.5, 0.65)),
                "flexor_radius": rounded(rng.uniform(0.025, 0.035)),
            },
            "joint": {"stiffness": rounded(rng.uniform(0.4, 2.0)), "rest_angle": 1.274},
        },
    )
    low = rng.uniform(5.0, 15.0) * DEGREE
    high = rng.uniform(90.0, 105.0) * DEGREE
    sensors = Sensors(
        spool_zero=rng.uniform(-3.0, 3.0),
        torque_zero=rng.normal(0.0, 0.02),
        coulomb=abs(rng.normal(0.0, 0.02)),
    )
    return Session(
        suit=stated,
        stated=stated,
        sensors=sensors,
        loads=LOADS,
        stated_loads=LOADS,
        angles=tuple(strokes(low, high) for _ in LOADS),
    )


def sensor(**values: float) -> Suits:
    """Make a fault of constant errors of sensors."""
    return lambda session, _: replace(session, sensors=replace(session.sensors, **values))


def true_number(key: str, shift: float = 0.0, factor: float = 1.0) -> Suits:
    """Make a fault of a number that the suit has and the study has not."""

    def apply(session: Session, _: np.random.Generator) -> Session:
        value = factor * get(session.suit, key) + shift
        return replace(session, suit=change(session.suit, key, value))

    return apply


def per_side(key: str, extensor: float) -> Suits:
    """Make a fault of an extensor's number that is a factor of the flexor's."""

    def apply(session: Session, _: np.random.Generator) -> Session:
        part, name = key.split(".")
        own = {part: {"extensor": {name: extensor * get(session.suit, key)}}}
        return replace(session, suit=merged(session.suit, own))

    return apply


def heavier_loads(session: Session, _: np.random.Generator) -> Session:
    """Make loads a tenth heavier than stated."""
    return replace(session, loads=tuple(1.1 * load for load in session.loads))


def pretension_falls(session: Session, _: np.random.Generator) -> Session:
    """Have the anchors slip until a tenth of the pretension is gone at the session's end."""
    tendon = session.suit["tendon"]
    area = np.pi * tendon["diameter"] ** 2 / 4.0
    softness = tendon["length"] / (area * tendon["youngs_modulus"])
    softness += 1.0 / session.suit["spring"]["stiffness"]
    softness += 1.0 / session.suit["anchor"]["stiffness"]
    whole = 0.1 * tendon["pretension"] * softness
    count = len(session.loads)
    share = session.time / session.time[-1]
    slip = tuple(whole * (place + share) / count for place in range(count))
    return replace(session, slip=slip)


def tissue_hardens(session: Session, _: np.random.Generator) -> Session:
    """Have tissue be half as stiff again at twice the pretension."""
    return replace(session, hardening=0.5)


def wander(time: Array, rng: np.random.Generator, size: float) -> Array:
    """Return a slow wander of some rms: sines of 0.03 to 0.2 Hz."""
    pulses = 2.0 * np.pi * rng.uniform(0.03, 0.2, 4)
    phases = rng.uniform(0.0, 2.0 * np.pi, 4)
    course = np.sin(time[:, None] * pulses + phases).sum(axis=1)
    return size * course / np.sqrt(np.mean(course**2))


def wearer_helps(session: Session, rng: np.random.Generator) -> Session:
    """Have the wearer help, or hinder, by a slow wander of 0.6 N m."""
    task = tuple(wander(session.time, rng, 0.6) for _ in session.loads)
    return replace(session, task=task)


def wearer_lifts(session: Session, _: np.random.Generator) -> Session:
    """Have the wearer help by 0.6 N m whenever the joint flexes."""
    rises = [np.gradient(angle) > 0.0 for angle in session.angles]
    return replace(session, task=tuple(np.where(up, -0.6, 0.0) for up in rises))


def upper_arm_moves(session: Session, rng: np.random.Generator) -> Session:
    """Have the upper arm sway by some 6 degrees while the study says that it hangs."""
    arm = session.suit["arm"]
    task = []
    for load, angle in zip(session.loads, session.angles, strict=True):
        sway = wander(session.time, rng, 6.0 * DEGREE)
        moment = arm["forearm_mass"] * arm["forearm_com"] + load * arm["load_distance"]
        lean = np.sin(angle + arm["upper_arm_angle"] + sway)
        task.append(9.81 * moment * (lean - np.sin(angle + arm["upper_arm_angle"])))
    return replace(session, task=tuple(task))


def goes_slack(session: Session, _: np.random.Generator) -> Session:
    """Set up a suit with equal spools and next to no pretension, so that its extensor is slack."""
    suit = change(session.suit, "tendon.pretension", 60.0)
    suit = change(suit, "spool.ratio", 0.95)
    return replace(session, suit=suit, stated=change(session.stated, "spool.ratio", 0.95))


def other_motion(make: Callable[[np.random.Generator], Array], rate: float = RATE) -> Suits:
    """Make a fault of another motion in every log."""

    def apply(session: Session, rng: np.random.Generator) -> Session:
        angles = tuple(make(rng) for _ in session.loads)
        return replace(session, angles=angles, rate=rate)

    return apply


def partial(rng: np.random.Generator) -> Array:
    """Return strokes of another range each: parts of the whole one."""
    count = round(CYCLE * RATE)
    lows = np.repeat(rng.uniform(5.0, 40.0, CYCLES) * DEGREE, count)
    highs = np.repeat(rng.uniform(60.0, 105.0, CYCLES) * DEGREE, count)
    angle = strokes(lows, highs)
    ends = np.linspace(0.0, 1.0, count)
    smooth = ends**2 * (3.0 - 2.0 * ends)
    for place in range(1, CYCLES):
        start = place * count
        step = angle[start] - angle[start - 1]
        angle[start - count // 2 : start] += step * smooth[::2][: count // 2]
    return angle


def holds(_: np.random.Generator) -> Array:
    """Return strokes that pause for two seconds at three places of each way."""
    moving = strokes(10.0 * DEGREE, 95.0 * DEGREE)
    cycle = round(CYCLE * RATE)
    pause = round(2.0 * RATE)
    parts = []
    for start in range(0, len(moving), cycle):
        for place in range(8):
            part = moving[start + place * cycle // 8 : start + (place + 1) * cycle // 8]
            parts.append(part)
            if place % 4 != 3:
                parts.append(np.full(pause, part[-1]))
    return np.concatenate(parts)


def fast(_: np.random.Generator) -> Array:
    """Return strokes of 0.8 s a cycle at 250 rows a second."""
    return strokes(15.0 * DEGREE, 90.0 * DEGREE, cycle=0.8, cycles=8, rate=250.0)


def with_inertia(session: Session, rng: np.random.Generator) -> Session:
    """Move fast, an arm that has its inertia."""
    suit = change(session.suit, "motion.inertia", 0.07)
    return other_motion(fast, rate=250.0)(replace(session, suit=suit), rng)


def only(*places: int) -> Suits:
    """Make a fault of fewer logs."""

    def apply(session: Session, _: np.random.Generator) -> Session:
        return replace(
            session,
            loads=tuple(session.loads[place] for place in places),
            stated_loads=tuple(session.stated_loads[place] for place in places),
            angles=tuple(session.angles[place] for place in places),
        )

    return apply


def one_stroke(session: Session, rng: np.random.Generator) -> Session:
    """Keep half a cycle of one log."""
    session = only(1)(session, rng)
    half = round(0.5 * CYCLE * RATE)
    return replace(session, angles=(session.angles[0][:half],))


def no_motion(session: Session, rng: np.random.Generator) -> Session:
    """Hold the joint throughout one log."""
    session = only(1)(session, rng)
    return replace(session, angles=(np.full(800, 50.0 * DEGREE),))


def logs_tensions(*names: str) -> Suits:
    """Make a log with load cells."""
    return lambda session, _: replace(session, tensions=names)


def noisier(session: Session, _: np.random.Generator) -> Session:
    """Make all noise three times as large."""
    return replace(session, noise=3.0)


def quantised(frame: pd.DataFrame, _: np.random.Generator) -> pd.DataFrame:
    """Round the torque to 0.1 N m, the spool's angle to 6 mrad, the joint's to half a degree."""
    steps = {"motor_torque (N m)": 0.1, "spool_angle (rad)": 6e-3, "elbow_angle (rad)": 8.7e-3}
    coarse = frame.copy()
    for name, width in steps.items():
        coarse[name] = np.round(frame[name] / width) * width
    return coarse


def drops_rows(frame: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Lose a tenth of all rows, and two gaps of half a second."""
    kept = rng.random(len(frame)) > 0.1
    for start in rng.integers(0, len(frame) - 30, 2):
        kept[start : start + 25] = False
    return frame[kept].reset_index(drop=True)


def has_outliers(frame: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Throw every two hundredth value of torque and angles far off."""
    spoilt = frame.copy()
    for name in ("motor_torque (N m)", "spool_angle (rad)", "elbow_angle (rad)"):
        rows = rng.random(len(frame)) < 0.005
        spoilt.loc[rows, name] += rng.normal(0.0, 1.0, rows.sum()) * 3.0 * frame[name].std()
    return spoilt


def has_missing_values(frame: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Leave out three values of every hundred."""
    spoilt = frame.copy()
    for name in ("motor_torque (N m)", "spool_angle (rad)"):
        spoilt.loc[rng.random(len(frame)) < 0.03, name] = np.nan
    return spoilt


def has_flat_torque(frame: pd.DataFrame, _: np.random.Generator) -> pd.DataFrame:
    """Log one and the same torque."""
    return frame.assign(**{"motor_torque (N m)": 1.5})


def exchanges_channels(frame: pd.DataFrame, _: np.random.Generator) -> pd.DataFrame:
    """Log the spool's angle as the joint's, and the other way about."""
    return frame.assign(
        **{
            "elbow_angle (rad)": frame["spool_angle (rad)"],
            "spool_angle (rad)": frame["elbow_angle (rad)"],
        }
    )


def says_degrees(frame: pd.DataFrame, _: np.random.Generator) -> pd.DataFrame:
    """Log degrees under a header that says radians."""
    return frame.assign(**{"elbow_angle (rad)": frame["elbow_angle (rad)"] / DEGREE})


def turns_sign(frame: pd.DataFrame, _: np.random.Generator) -> pd.DataFrame:
    """Log the spool's angle with the wrong sign."""
    return frame.assign(**{"spool_angle (rad)": -frame["spool_angle (rad)"]})


def goes_back_in_time(frame: pd.DataFrame, _: np.random.Generator) -> pd.DataFrame:
    """Put the second half of a log before the first."""
    half = len(frame) // 2
    return pd.concat([frame[half:], frame[:half]], ignore_index=True)


def in_one_file(frames: list[pd.DataFrame]) -> list[str]:
    """Write all logs into one file, one after the other in time."""
    shifted = []
    start = 0.0
    for frame in frames:
        shifted.append(frame.assign(**{"time (s)": frame["time (s)"] + start}))
        start = shifted[-1]["time (s)"].iloc[-1] + 5.0
    return as_they_are([pd.concat(shifted, ignore_index=True)])


def in_german(frames: list[pd.DataFrame]) -> list[str]:
    """Write semicolons, decimal commas and degrees, with headers of a LabVIEW export."""
    texts = []
    for frame in frames:
        renamed = pd.DataFrame(
            {
                "Zeit [s]": frame["time (s)"],
                "Ellbogenwinkel [°]": frame["elbow_angle (rad)"] / DEGREE,
                "Spulenwinkel [°]": frame["spool_angle (rad)"] / DEGREE,
                "Motormoment [Nm]": frame["motor_torque (N m)"],
                "Last [kg]": frame["load_mass (kg)"],
            }
        )
        texts.append(renamed.to_csv(index=False, sep=";", decimal=",", float_format="%.6g"))
    return texts


FAULTS: dict[str, LogFault] = {
    "none": LogFault(),
    "gear friction": LogFault(suit=sensor(coulomb=0.25)),
    "viscous gear": LogFault("either", "speed", sensor(viscous=0.15)),
    "torque zero": LogFault(suit=sensor(torque_zero=0.25)),
    "torque constant": LogFault(suit=sensor(torque_gain=1.08)),
    "late torque": LogFault("either", "lag", sensor(torque_delay=0.12)),
    "late spool angle": LogFault("either", "lag", sensor(spool_delay=0.12)),
    "late joint angle": LogFault("either", "lag", sensor(joint_delay=0.12)),
    "backlash": LogFault("either", "direction", sensor(backlash=0.02)),
    "joint sensor's zero": LogFault(suit=sensor(joint_zero=3.0 * DEGREE)),
    "joint sensor's gain": LogFault(suit=sensor(joint_gain=1.03)),
    "torque drifts": LogFault("warned", "drift", sensor(torque_drift=0.25)),
    "b1 off": LogFault(suit=true_number("arm.b1", 8e-3)),
    "a1 off": LogFault(suit=true_number("arm.a1", -6e-3)),
    "a2 and b2 off": LogFault(suit=true_number("arm.a2", 5e-3)),
    "elbow radius off": LogFault(suit=true_number("arm.elbow_radius", 4e-3)),
    "forearm heavier": LogFault(suit=true_number("arm.forearm_mass", factor=1.07)),
    "load farther": LogFault(suit=true_number("arm.load_distance", factor=1.03)),
    "load heavier": LogFault("either", "", heavier_loads),
    "rest angle off": LogFault("either", "", true_number("joint.rest_angle", 0.2)),
    "spring softer": LogFault("either", "", true_number("spring.stiffness", factor=0.95)),
    "friction differs per side": LogFault("either", "", per_side("sheath.friction", 1.3)),
    "pretension falls": LogFault("warned", "drift", pretension_falls),
    "tissue hardens": LogFault("warned", "tension", tissue_hardens),
    "slack": LogFault("either", "slack", goes_slack),
    "wearer helps": LogFault("warned", "wander", wearer_helps),
    "wearer lifts": LogFault("either", "direction", wearer_lifts),
    "upper arm moves": LogFault("warned", "wander", upper_arm_moves),
    "high friction": LogFault(suit=true_number("sheath.friction", factor=2.0)),
    "noisy": LogFault(suit=noisier),
    "quantised": LogFault(reads=quantised),
    "dropped rows": LogFault(reads=drops_rows),
    "outliers": LogFault("either", "", reads=has_outliers),
    "missing values": LogFault(reads=has_missing_values),
    "fast": LogFault("either", "speed", with_inertia),
    "partial strokes": LogFault(suit=other_motion(partial)),
    "holds": LogFault(suit=other_motion(holds)),
    "inertia": LogFault(suit=true_number("motion.inertia", 0.05)),
    "one load": LogFault("either", "", only(1)),
    "two loads": LogFault(suit=only(0, 2)),
    "one stroke": LogFault("either", "", one_stroke),
    "tension at the motor": LogFault(suit=logs_tensions("flexor_tension_proximal")),
    "tension at the joint": LogFault(suit=logs_tensions("flexor_tension_distal")),
    "both tensions": LogFault(
        suit=logs_tensions("flexor_tension_distal", "extensor_tension_distal")
    ),
    "one file": LogFault(writes=in_one_file),
    "German": LogFault(writes=in_german),
    "no motion": LogFault("refused", "", no_motion),
    "flat torque": LogFault("refused", "", reads=has_flat_torque),
    "exchanged channels": LogFault("refused", "", reads=exchanges_channels),
    "degrees for radians": LogFault("refused", "", reads=says_degrees),
    "wrong sign": LogFault("refused", "", reads=turns_sign),
    "time goes back": LogFault("refused", "", reads=goes_back_in_time),
}
"""Kinds of logs by name."""


def session_of(seed: int, fault: str) -> Session:
    """Draw a suit and apply a fault to it."""
    rng = np.random.default_rng([21, seed])
    session = draw_session(rng)
    apply = FAULTS[fault].suit
    return apply(session, rng) if apply else session


def random_session(seed: int) -> Session:
    """Draw a suit whose geometry, masses and sensors differ from what its study states.

    They differ by the standard deviations that a fit takes for numbers stated without any: anchors
    5 mm, elbow radius 3 mm, masses 5 %, lengths and bends 2 %, springs 5 %, the tendon's modulus
    10 %, spools 0.5 and 1 %, postures 2°, the rest angle 10°, joint sensor 2° and 2 %, torque
    constant 5 %. Gear friction is up to 0.25 N m, the zero of torque within 0.1 N m (standard
    deviation).
    """
    rng = np.random.default_rng([391, seed])
    session = draw_session(rng)
    suit = session.suit
    for key, deviation in PRIORS.items():
        suit = change(suit, key, get(suit, key) + rng.normal(0.0, deviation))
    for key, deviation in RELATIVE_PRIORS.items():
        suit = change(suit, key, get(suit, key) * (1.0 + rng.normal(0.0, deviation)))
    loads = tuple(load * (1.0 + rng.normal(0.0, 0.05)) for load in session.loads)
    sensors = replace(
        session.sensors,
        torque_zero=rng.normal(0.0, 0.1),
        torque_gain=1.0 + rng.normal(0.0, 0.05),
        coulomb=rng.uniform(0.0, 0.25),
        joint_zero=rng.normal(0.0, 2.0 * DEGREE),
        joint_gain=1.0 + rng.normal(0.0, 0.02),
    )
    return replace(session, suit=suit, loads=loads, sensors=sensors)


def rig_of(session: Session, load: float) -> Rig:
    """Make the rig of one log."""
    rig = make_rig(change(session.suit, "load.mass", load))
    if not session.hardening:
        return rig
    return replace(
        rig,
        flexor=replace(rig.flexor, hardening=session.hardening),
        extensor=replace(rig.extensor, hardening=session.hardening),
    )


def motion_of(session: Session, log: int) -> Motion:
    """Return the motion of one log, with derivatives by differences."""
    angle = session.angles[log]
    return Motion(
        time=session.time,
        angle=angle,
        acceleration=np.gradient(np.gradient(angle, session.time), session.time),
        task=session.task[log] if session.task else np.zeros(0),
        slip=session.slip[log] if session.slip else np.zeros(0),
    )


def late(time: Array, values: Array, delay: float) -> Array:
    """Return a channel that is late by some time."""
    return np.interp(time - delay, time, values) if delay else values


def with_backlash(angle: Array, way: float) -> Array:
    """Return a motor's angle in front of a gear with free way that follows the spool's."""
    motor = angle.copy()
    offset = 0.5 * way
    for place in range(1, len(angle)):
        step = angle[place] - angle[place - 1]
        offset = np.clip(offset + np.sign(step) * way, -0.5 * way, 0.5 * way)
        motor[place] = angle[place] + offset
    return motor


def frame_of(
    session: Session, log: int, history: History, rng: np.random.Generator
) -> pd.DataFrame:
    """Return the rows that the sensors write of one log."""
    sensors = session.sensors
    time = history.time
    noise = session.noise
    speed = np.gradient(history.spool_angle, time)
    gear = sensors.coulomb * np.tanh(speed / 0.02) + sensors.viscous * speed
    torque = sensors.torque_gain * (history.motor_torque + gear) + sensors.torque_zero
    torque = torque + sensors.torque_drift * (log + time / time[-1]) / len(session.loads)
    spool = with_backlash(history.spool_angle, sensors.backlash) + sensors.spool_zero
    joint = sensors.joint_gain * history.angle + sensors.joint_zero
    columns = {
        "time (s)": time,
        "elbow_angle (rad)": late(time, joint, sensors.joint_delay),
        "spool_angle (rad)": late(time, spool, sensors.spool_delay),
        "motor_torque (N m)": late(time, torque, sensors.torque_delay),
    }
    sizes = {
        "elbow_angle (rad)": ANGLE_NOISE,
        "spool_angle (rad)": ANGLE_NOISE,
        "motor_torque (N m)": TORQUE_NOISE,
    }
    tensions = {
        "flexor_tension_proximal": history.flexor_motor,
        "flexor_tension_distal": history.flexor_elbow,
        "extensor_tension_proximal": history.extensor_motor,
        "extensor_tension_distal": history.extensor_elbow,
    }
    for name in session.tensions:
        columns[f"{name} (N)"] = tensions[name]
        sizes[f"{name} (N)"] = TENSION_NOISE
    for name, size in sizes.items():
        columns[name] = columns[name] + rng.normal(0.0, noise * size, len(time))
    frame = pd.DataFrame(columns)
    return frame.assign(**{"load_mass (kg)": session.stated_loads[log]})


def study_of(session: Session, name: str) -> dict[str, Any]:
    """Return the study of a session: what is stated, and ranges for what is to be fitted."""
    parts = ("arm", "sheath", "tendon", "spring", "anchor", "spool", "joint")
    study = study_numbers({part: session.stated[part] for part in parts})
    for key, text in FITTED.items():
        study = change(study, key, text)
    study["name"] = name
    return study


def truth_of(session: Session, fault: LogFault) -> dict[str, Any]:
    """Return true numbers of suit and sensors, and what a fit should do."""
    keys = [*FITTED, *PRIORS, *RELATIVE_PRIORS]
    numbers = {key: get(session.suit, key) for key in keys if key != "load.mass"}
    return {
        "numbers": numbers,
        "loads": session.loads,
        "sensors": vars(session.sensors).copy(),
        "inertia": session.suit["motion"]["inertia"],
        "expects": fault.expects,
        "pattern": fault.pattern,
    }


@dataclass
class _Batch:
    """Rigs and motions of several sessions, by the number of their samples."""

    rigs: list[Rig] = field(default_factory=list)
    motions: list[Motion] = field(default_factory=list)
    places: list[tuple[int, int]] = field(default_factory=list)


def drive_sessions(sessions: Sequence[Session], nodes: int = NODES) -> list[list[History]]:
    """Simulate all logs of all sessions; logs of one length are simulated together."""
    batches: dict[int, _Batch] = {}
    for place, session in enumerate(sessions):
        for log, load in enumerate(session.loads):
            batch = batches.setdefault(len(session.angles[log]), _Batch())
            batch.rigs.append(rig_of(session, load))
            batch.motions.append(motion_of(session, log))
            batch.places.append((place, log))
    found: dict[tuple[int, int], History] = {}
    for batch in batches.values():
        histories = simulate(batch.rigs, batch.motions, nodes)
        found.update(zip(batch.places, histories, strict=True))
    return [
        [found[place, log] for log in range(len(session.loads))]
        for place, session in enumerate(sessions)
    ]


def write_log(
    session: Session, histories: Sequence[History], seed: int, name: str, fault: LogFault
) -> SuitLog:
    """Write a session as a study with its logs."""
    rng = np.random.default_rng([210, seed])
    frames = []
    for log, history in enumerate(histories):
        frame = frame_of(session, log, history, rng)
        frames.append(fault.reads(frame, rng) if fault.reads else frame)
    plain = "".join(letter if letter.isalnum() else "-" for letter in name)
    return SuitLog(
        fault=name,
        seed=seed,
        study=study_of(session, f"{plain}-{seed}"),
        texts=fault.writes(frames),
        loads=session.stated_loads,
        truth=truth_of(session, fault),
    )


def make_logs(asked: Sequence[tuple[int, str]], nodes: int = NODES) -> list[SuitLog]:
    """Make logs of several seeds and faults, all simulated at once."""
    sessions = [session_of(seed, fault) for seed, fault in asked]
    driven = drive_sessions(sessions, nodes)
    return [
        write_log(session, histories, seed, fault, FAULTS[fault])
        for session, histories, (seed, fault) in zip(sessions, driven, asked, strict=True)
    ]


def make_log(seed: int, fault: str = "none", nodes: int = NODES) -> SuitLog:
    """Make the logs of one suit with one fault of `FAULTS`."""
    return make_logs([(seed, fault)], nodes)[0]


def random_suits(count: int, seed: int = 0, nodes: int = NODES) -> list[SuitLog]:
    """Make logs of suits that differ from their studies as the tolerances of a fit say."""
    seeds = [1000 * seed + place for place in range(count)]
    sessions = [random_session(one) for one in seeds]
    driven = drive_sessions(sessions, nodes)
    return [
        write_log(session, histories, one, "random", LogFault())
        for session, histories, one in zip(sessions, driven, seeds, strict=True)
    ]
