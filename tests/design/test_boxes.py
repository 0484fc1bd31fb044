"""Windows proved for boxes of numbers: no point of a box refutes one; what cannot be proved is said."""

from fractions import Fraction

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.answers import proofs
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.enclosure import Series
from tendon_cli.model.window import ends_of_states
from tests.model import rationals
from tests.model.designs import baseline, design

RANGES = {
    "arm.a1": (0.03, 0.05),
    "arm.b1": (0.13, 0.17),
    "arm.a2": (0.01, 0.03),
    "arm.b2": (0.13, 0.17),
    "arm.elbow_radius": (0.035, 0.05),
    "sheath.friction": (0.02, 0.15),
    "sheath.bend_angle": (2.0, 4.0),
    "spring.stiffness": (3e3, 9e3),
    "tendon.length": (1.0, 2.5),
    "tendon.diameter": (1e-3, 2e-3),
    "tendon.youngs_modulus": (5e10, 1.6e11),
    "spool.ratio": (0.4, 0.7),
    "spool.flexor_radius": (0.02, 0.04),
    "sheath.flexor.friction": (0.02, 0.15),
    "spring.extensor.stiffness": (3e3, 9e3),
}
LIMITS = [
    {},
    {"max_tension": 600.0},
    {"peak_motor_torque": 16.0},
    {"min_flexor_tension": 10.0},
    {"max_tension": 900.0},
]
COMMON = [key for key in RANGES if key.count(".") == 1]


def flat(numbers):
    """Numbers by key as `designs.baseline` has them; those of a side over those of both."""
    p = baseline()
    for key in sorted(numbers, key=lambda key: key.count(".")):
        table, *side, name = key.split(".")
        name = {"spring.stiffness": "spring_stiffness"}.get(f"{table}.{name}", name)
        for which in side or ("flexor", "extensor"):
            p[f"{which}_{name}" if f"flexor_{name}" in p else name] = numbers[key]
    return p


def study_of(numbers, load, limits, last):
    content = {
        "load": {"mass": [0.0, load]},
        "limits": limits,
        "motion": {"elbow_angle": {"from": "0 deg", "to": f"{last} deg", "num": 5}},
    }
    for key, value in numbers.items():
        *tables, name = key.split(".")
        inner = content
        for table in tables:
            inner = inner.setdefault(table, {})
        radians = name == "bend_angle"
        ends = [f"{each!r} rad" if radians else each for each in np.atleast_1d(value).tolist()]
        inner[name] = dict(zip(("from", "to"), ends, strict=True)) if len(ends) == 2 else ends[0]
    return tendon.study(content)


def random_box(rng, number):
    """Numbers of a design, one to three of them within an interval; its load, limits and last angle."""
    numbers = {key: float(rng.uniform(*RANGES[key])) for key in COMMON}
    keys = [str(key) for key in rng.choice(list(RANGES), size=1 + number % 3, replace=False)]
    keys[0] = (
        "arm.elbow_radius" if number % 4 == 0 else keys[0]
    )  # the one whose inside asks for most at times
    for key in keys:
        middle, share = rng.uniform(*RANGES[key]), 10.0 ** rng.uniform(-2.5, -0.7)
        numbers[key] = np.array([middle * (1.0 - share), middle * (1.0 + share)])
    return (
        numbers,
        float(rng.uniform(1.0, 8.0)),
        LIMITS[number % len(LIMITS)],
        float(rng.uniform(60.0, 130.0)),
    )


def tightest_points(rng, numbers, load, limits, last, count):
    """Points of a box, many at its edges, each at an angle in a direction: those that ask for most, and others."""
    shares = np.clip(rng.uniform(-1.4, 1.4, (count, len(numbers))), -1.0, 1.0)
    points = {
        key: np.interp(share, (-1.0, 1.0), np.atleast_1d(value)[[0, -1]])
        for (key, value), share in zip(numbers.items(), shares.T, strict=True)
    }
    loads = rng.choice([0.0, load, 0.4 * load], count)
    made = design(
        {
            name: np.broadcast_to(np.reshape(value, (-1, 1, 1)), (count, 1, 1))
            if np.ndim(value)
            else value
            for name, value in (flat(points) | {"load_mass": loads}).items()
        }
    )
    angles, ways = np.radians(np.linspace(0.0, last, 121)), np.array([[True], [False]])
    low, high = ends_of_states(State.of(made, angles[np.newaxis], ways), Bounds(**limits))[:2]
    asked = [np.broadcast_to(end, (count, 2, 121)).reshape(count, -1) for end in (low, -high)]
    for end, values in enumerate(asked):
        each = values.max(axis=1)
        for at in (*np.argsort(-each)[:3], rng.integers(count)):
            way, angle = divmod(int(values[at].argmax()), 121)
            point = flat({key: float(value[at]) for key, value in points.items()}) | {
                "load_mass": float(loads[at])
            }
            yield end, float(each[at]), point, float(angles[angle]), bool(ways[way, 0])


def refuted(p, angle, flexion, pretension, limits):
    """Whether some limit is surely not kept, in exact arithmetic."""
    at = rationals.state(p, angle, flexion, Fraction(pretension))
    kept = [at["x"], at["y"], at["stiffness"]]
    ends = [at["x"], at["x_proximal"], at["y"], at["y_proximal"]]
    kept += [limits["max_tension"] - end for end in ends if "max_tension" in limits]
    kept += [
        end - limits["min_flexor_tension"] for end in ends[:2] if "min_flexor_tension" in limits
    ]
    motor = limits.get("peak_motor_torque")
    kept += [] if motor is None else [motor - at["motor"], motor + at["motor"]]
    return any(each.high < 0 for each in kept)


def check_boxes(seed, count):
    """Random boxes; returns how many have a window, and how many of these are proved."""
    rng, windows, proved = np.random.default_rng(seed), 0, 0
    for number in range(count):
        numbers, load, limits, last = random_box(rng, number)
        answer = tendon.design(study_of(numbers, load, limits, last))
        known = answer.record["between_samples"]
        points = list(tightest_points(rng, numbers, load, limits, last, 300))
        if known is None:
            continue
        windows, proved = windows + 1, proved + (known["status"] == "proven")
        assert known["status"] in ("proven", "open")
        if known["status"] == "open":
            continue
        best = answer.record["best"]
        low, high = best["pretension_from"] + known["margin"], best["pretension_to"]
        for end, asked, p, angle, flexion in points:
            if end == 1 and high is None:
                continue
            at = low if end == 0 else high - known["margin"]
            assert (asked <= at) if end == 0 else (-asked >= at), (number, end, asked, at)
            assert not refuted(p, angle, flexion, at, limits), (number, end, at)
    return windows, proved


# A radius in the middle of its interval tolerates 3.4 N less than those at its ends.
INSIDE = {
    "arm.a1": 0.04669,
    "arm.b1": 0.15538,
    "arm.a2": 0.02937,
    "arm.b2": 0.16969,
    "sheath.friction": 0.08509,
    "sheath.bend_angle": 2.35594,
    "spring.stiffness": 8540.92496,
    "tendon.length": 1.37863,
    "tendon.diameter": 0.00183,
    "tendon.youngs_modulus": 93.390429942e9,
    "spool.ratio": 0.42091,
    "spool.flexor_radius": 0.0288,
}
RADIUS, LIMIT = np.array([0.028, 0.042]), {"max_tension": 600.0}


def test_an_end_within_a_box_is_found_and_proved():
    answer = tendon.design(study_of(INSIDE | {"arm.elbow_radius": RADIUS}, 6.0, LIMIT, 90.0))
    best, known = answer.record["best"], answer.record["between_samples"]
    assert known["status"] == "proven"
    assert (
        "arm.elbow_radius: the window holds for the whole interval; the worst values are"
        in answer.record["notes"][0]
    )
    assert "every radius from 28 to 42 mm" in known["scope"].replace("elbow radius", "radius")
    each = [
        tendon.design(
            study_of(INSIDE | {"arm.elbow_radius": float(radius)}, 6.0, LIMIT, 90.0)
        ).record["best"]
        for radius in np.linspace(*RADIUS, 8)
    ]
    highs = np.array([row["pretension_to"] for row in each])
    at = int(highs.argmin())
    top = highs[at] - (highs[at + 1] - highs[at - 1]) ** 2 / 8.0 / (
        highs[at - 1] - 2.0 * highs[at] + highs[at + 1]
    )
    assert min(highs[[0, -1]]) - best["pretension_to"] > 3.0
    assert best["pretension_to"] == pytest.approx(top, abs=0.1)
    assert best["pretension_from"] == pytest.approx(
        max(row["pretension_from"] for row in each), abs=1e-6
    )


def test_points_refute_a_proof_that_looks_at_the_middle_of_a_box_alone(monkeypatch):
    still = classmethod(lambda of, middle, *_: of([(middle, 0.0), None, None, None, None]))
    monkeypatch.setattr(Series, "number", still)
    monkeypatch.setattr(proofs, "_CLIMBS", 0)
    numbers = INSIDE | {"arm.elbow_radius": RADIUS * 0.95}  # so that the middle is not the worst
    best = tendon.design(study_of(numbers, 6.0, LIMIT, 90.0)).record["best"]
    points = tightest_points(np.random.default_rng(1), numbers, 6.0, LIMIT, 90.0, 300)
    assert any(
        end and refuted(p, angle, flexion, best["pretension_to"], LIMIT)
        for end, _, p, angle, flexion in points
    )


def test_what_has_no_proof_over_a_box_is_named():
    study = study_of(INSIDE | {"arm.elbow_radius": RADIUS}, 6.0, LIMIT, 90.0)
    answer = tendon.design(study.vary(**{"setting.read": "flexor at joint"}))
    assert answer.record["between_samples"]["status"] == "sampled"
    assert any(
        note.startswith("arm.elbow_radius: sampled at both ends") for note in answer.record["notes"]
    )


def test_a_box_whose_cells_do_not_suffice_is_open(monkeypatch):
    monkeypatch.setattr("tendon_cli.model.proof.MOST_CELLS", 8 * 70)
    answer = tendon.design(study_of(INSIDE | {"arm.elbow_radius": RADIUS}, 6.0, LIMIT, 90.0))
    assert answer.record["between_samples"]["status"] == "open"


def test_no_point_refutes_what_is_proved_for_a_box():
    windows, proved = check_boxes(1, 8)
    assert windows > 3
    assert proved == windows


@pytest.mark.torture
def test_no_point_refutes_what_is_proved_for_a_thousand_boxes():
    windows, proved = check_boxes(2, 1000)
    assert windows > 500
    assert proved > 0.95 * windows
