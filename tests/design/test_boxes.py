"""Windows proved for boxes of numbers.

No point of a box refutes its window, and an answer says what it cannot prove.
"""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.window import ends_of_states
from tendon_cli.proof import tightening
from tendon_cli.proof.series import Series
from tests.answers import answered, solved
from tests.model import rationals
from tests.model.designs import baseline, design
from tests.sampled import quick_and_torture

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
SAMPLES = 121  # angles at which points are sought


@dataclass(frozen=True)
class Box:
    """A design whose numbers may be intervals, arrays of two ends, under 0 kg and a load."""

    numbers: dict
    load: float  # kg
    limits: dict
    last: float  # largest elbow angle, deg

    def content(self):
        """Return the study of this box."""
        content = {
            "load": {"mass": [0.0, self.load]},
            "limits": self.limits,
            "motion": {"elbow_angle": {"from": "0 deg", "to": f"{self.last} deg", "num": 5}},
        }
        for key, value in self.numbers.items():
            *tables, name = key.split(".")
            inner = content
            for table in tables:
                inner = inner.setdefault(table, {})
            inner[name] = as_written(name, value)
        return content


def as_written(name, value):
    """Return a number or an interval as a study has it."""
    values = np.atleast_1d(value).tolist()
    if name == "bend_angle":
        values = [f"{angle!r} rad" for angle in values]
    if len(values) == 2:
        low, high = values
        return {"from": low, "to": high}
    return values[0]


@dataclass(frozen=True)
class Point:
    """A point of a box at an angle in a direction, and an end of its window there."""

    is_upper: bool
    end: float  # N
    numbers: dict  # as `designs.baseline` has them
    angle: float  # rad
    flexion: bool


def flat(numbers):
    """Return numbers by key as `designs.baseline` has them; a side's replace those of both."""
    result = baseline()
    for key in sorted(numbers, key=lambda key: key.count(".")):
        table, *side, name = key.split(".")
        if (table, name) == ("spring", "stiffness"):
            name = "spring_stiffness"
        if f"flexor_{name}" not in result:
            result[name] = numbers[key]
            continue
        for selected in side or ("flexor", "extensor"):
            result[f"{selected}_{name}"] = numbers[key]
    return result


def random_box(rng, number):
    """Return a random design with one to three of its numbers within an interval."""
    numbers = {key: float(rng.uniform(*RANGES[key])) for key in COMMON}
    keys = [str(key) for key in rng.choice(list(RANGES), size=1 + number % 3, replace=False)]
    if number % 4 == 0:
        keys[0] = "arm.elbow_radius"  # the number that at times asks for most inside its interval
    for key in keys:
        middle = rng.uniform(*RANGES[key])
        share = 10.0 ** rng.uniform(-2.5, -0.7)
        numbers[key] = np.array([middle * (1.0 - share), middle * (1.0 + share)])
    load = float(rng.uniform(1.0, 8.0))
    last = float(rng.uniform(60.0, 130.0))
    return Box(numbers, load, LIMITS[number % len(LIMITS)], last)


def tightest_points(rng, box, count):
    """Yield points of a box, some of those that ask for most and others.

    They are selected from `count` random points, many of them at its edges.
    """
    shares = np.clip(rng.uniform(-1.4, 1.4, (count, len(box.numbers))), -1.0, 1.0)
    points = {}
    for (key, value), share in zip(box.numbers.items(), shares.T, strict=True):
        ends = np.atleast_1d(value)[[0, -1]]
        points[key] = np.interp(share, (-1.0, 1.0), ends)
    loads = rng.choice([0.0, box.load, 0.4 * box.load], count)
    columns = flat(points) | {"load_mass": loads}
    for name, value in columns.items():
        if np.ndim(value):
            columns[name] = np.broadcast_to(np.reshape(value, (-1, 1, 1)), (count, 1, 1))
    angles = np.radians(np.linspace(0.0, box.last, SAMPLES))
    directions = np.array([[True], [False]])
    states = State.of(design(columns), angles[np.newaxis], directions)
    low, high, *_ = ends_of_states(states, Bounds(**box.limits))
    for is_upper, ends in ((False, low), (True, -high)):
        # (points, directions * angles), the more the tighter
        pretensions = np.broadcast_to(ends, (count, 2, SAMPLES)).reshape(count, -1)
        most = pretensions.max(axis=1)
        for row in (*np.argsort(-most)[:3], rng.integers(count)):
            direction, angle = divmod(int(pretensions[row].argmax()), SAMPLES)
            numbers = flat({key: float(values[row]) for key, values in points.items()})
            yield Point(
                is_upper=is_upper,
                end=float(-most[row] if is_upper else most[row]),
                numbers=numbers | {"load_mass": float(loads[row])},
                angle=float(angles[angle]),
                flexion=bool(directions[direction, 0]),
            )


def refuted(point, pretension, limits):
    """Return true if a limit is surely not kept at a point, in exact arithmetic."""
    state = rationals.state(point.numbers, point.angle, point.flexion, Fraction(pretension))
    margins = [state["x"], state["y"], state["stiffness"]]
    if "max_tension" in limits:
        ends = ("x", "x_proximal", "y", "y_proximal")
        margins += [limits["max_tension"] - state[name] for name in ends]
    if "min_flexor_tension" in limits:
        ends = ("x", "x_proximal")
        margins += [state[name] - limits["min_flexor_tension"] for name in ends]
    if "peak_motor_torque" in limits:
        margins.append(limits["peak_motor_torque"] - state["motor"])
        margins.append(limits["peak_motor_torque"] + state["motor"])
    return any(margin.high < 0 for margin in margins)


def check_boxes(seed, count):
    """Check random boxes; return how many have a window, and how many of these are proved."""
    rng = np.random.default_rng(seed)
    windows = 0
    proved = 0
    for number in range(count):
        box = random_box(rng, number)
        answer = tendon.design(box.content())
        known = answer.record["between_samples"]
        points = list(tightest_points(rng, box, 300))
        if known is None:
            continue
        windows += 1
        assert known["status"] in ("proven", "open")
        if known["status"] == "open":
            continue
        proved += 1
        best = answer.record["best"]
        low = best["pretension_from"] + known["margin"]
        for point in points:
            if not point.is_upper:
                assert point.end <= low, (number, point, low)
                assert not refuted(point, low, box.limits), (number, point, low)
            elif best["pretension_to"] is not None:
                high = best["pretension_to"] - known["margin"]
                assert point.end >= high, (number, point, high)
                assert not refuted(point, high, box.limits), (number, point, high)
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
RADII = np.array([0.028, 0.042])
LIMIT = {"max_tension": 600.0}


def box_of_radii(radii):
    """Return the box whose elbow radius is a number or within an interval, m."""
    return Box(INSIDE | {"arm.elbow_radius": radii}, load=6.0, limits=LIMIT, last=90.0)


def test_an_end_within_a_box_is_found_and_proved():
    answer = answered(box_of_radii(RADII).content())
    best = answer.record["best"]
    known = answer.record["between_samples"]
    assert known["status"] == "proven"
    assert (
        "arm.elbow_radius: the window holds for the whole interval; the worst values are"
        in answer.record["notes"][0]
    )
    assert "every radius from 28 to 42 mm" in known["scope"].replace("elbow radius", "radius")
    lows = np.empty(8)
    highs = np.empty(8)
    for place, radius in enumerate(np.linspace(*RADII, 8)):
        single = solved(box_of_radii(float(radius)).content())
        lows[place] = single.pretension_from[0]
        highs[place] = single.pretension_to[0]
    tightest = int(highs.argmin())
    before, middle, after = highs[tightest - 1 : tightest + 2]
    top = middle - (after - before) ** 2 / 8.0 / (before - 2.0 * middle + after)
    assert min(highs[[0, -1]]) - best["pretension_to"] > 3.0
    assert best["pretension_to"] == pytest.approx(top, abs=0.1)
    assert best["pretension_from"] == pytest.approx(lows.max(), abs=1e-6)


def test_points_refute_a_proof_that_looks_at_the_middle_of_a_box_alone(monkeypatch):
    def middle_alone(series, middle, *_):
        return series([(middle, 0.0), None, None, None, None])

    monkeypatch.setattr(Series, "number", classmethod(middle_alone))
    monkeypatch.setattr(tightening, "_CLIMBS", 0)
    box = box_of_radii(RADII * 0.95)  # so that the middle is not the worst
    best = tendon.design(box.content()).record["best"]
    points = tightest_points(np.random.default_rng(1), box, 300)
    assert any(point.is_upper and refuted(point, best["pretension_to"], LIMIT) for point in points)


def test_a_number_without_a_proof_over_its_interval_is_named():
    content = box_of_radii(RADII).content()
    answer = tendon.design(content | {"setting": {"read": "flexor at joint"}})
    assert answer.record["between_samples"]["status"] == "sampled"
    assert any(
        note.startswith("arm.elbow_radius: sampled at both ends") for note in answer.record["notes"]
    )


@pytest.mark.parametrize("most", quick_and_torture([250], [350, 450]))
def test_an_open_window_is_off_by_no_more_than_its_bound(monkeypatch, most):
    content = box_of_radii(RADII).content()
    proved = answered(content).record["best"]
    monkeypatch.setattr("tendon_cli.proof.subdivision.MOST_CELLS", 8 * most)
    record = tendon.design(content).record
    known = record["between_samples"]
    assert known["status"] == "open"
    assert known["cells"] <= most
    best = record["best"]
    assert abs(best["pretension_to"] - proved["pretension_to"]) <= known["estimate"]
    assert abs(best["pretension_from"] - proved["pretension_from"]) <= known["estimate"]


def test_the_bound_of_an_open_window_covers_an_end_that_is_not_tightened(monkeypatch):
    """No sampled end lies farther inside of the window than its bound says."""
    monkeypatch.setattr("tendon_cli.proof.certify._ROUNDS", 0)
    box = box_of_radii(RADII)
    answer = tendon.design(box.content())
    known = answer.record["between_samples"]
    best = answer.record["best"]
    assert known["status"] == "open"
    assert f"an end is off by at most {known['estimate']:.2g} N" in " ".join(answer.text.split())
    points = list(tightest_points(np.random.default_rng(1), box, 3000))
    above = best["pretension_to"] - min(point.end for point in points if point.is_upper)
    below = max(point.end for point in points if not point.is_upper) - best["pretension_from"]
    assert above > 3.0  # the radius in the middle asks for so much
    assert max(above, below) <= known["estimate"] < 3.0 * above


LEANING = {
    "spring": {"stiffness": 8e3},
    "spool": {"ratio": 0.5},
    "arm": {
        "a1": 0.04,
        "upper_arm_angle": {"from": "-20 deg", "to": "40 deg"},
        "elbow_radius": {"from": 0.04, "to": 0.05},
    },
    "sheath": {"friction": {"from": 0.06, "to": 0.1}},
    "joint": {"stiffness": {"from": 0.0, "to": 1.0}, "rest_angle": "73 deg"},
    "load": {"mass": [0.0, 2.0]},
    "limits": {"max_tension": 600.0, "peak_motor_torque": 16.0},
}
"""Two numbers, a posture and a stiffness within intervals."""


def test_postures_within_an_interval_take_few_cells_more():
    """An arc of postures is judged at one point: it is not one more number of the box."""
    known = answered(LEANING).record["between_samples"]
    single = LEANING | {"arm": LEANING["arm"] | {"upper_arm_angle": "40 deg"}}
    of_posture = tendon.design(single).record["between_samples"]
    assert known["status"] == of_posture["status"] == "proven"
    assert known["cells"] < 8 * of_posture["cells"]


def test_no_posture_within_an_interval_refutes_the_window():
    best = answered(LEANING).record["best"]
    rng = np.random.default_rng(3)
    for _ in range(3):
        content = {key: dict(table) for key, table in LEANING.items()}
        for table, name, low, high in (
            ("arm", "upper_arm_angle", np.radians(-20.0), np.radians(40.0)),
            ("arm", "elbow_radius", 0.04, 0.05),
            ("sheath", "friction", 0.06, 0.1),
            ("joint", "stiffness", 0.0, 1.0),
        ):
            value = float(
                np.clip(rng.uniform(1.5 * low - 0.5 * high, 1.5 * high - 0.5 * low), low, high)
            )
            content[table][name] = f"{value!r} rad" if name == "upper_arm_angle" else value
        point = tendon.design(content).record["best"]
        assert point["pretension_from"] <= best["pretension_from"] + 1e-6
        assert point["pretension_to"] >= best["pretension_to"] - 1e-6


def test_all_rounds_of_a_proof_share_its_cells(monkeypatch):
    monkeypatch.setattr("tendon_cli.proof.subdivision.MOST_CELLS", 8 * 600)
    known = tendon.design(LEANING).record["between_samples"]
    assert known["status"] == "open"
    assert known["cells"] <= 600


IN_LITTLE_MEMORY = """
import json, resource, sys, time
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
import tendon_cli as tendon
started = time.process_time()
answer = tendon.design(tendon.study(json.loads(sys.argv[1])))
choices = answer.record["between_samples"]["choices"]
print(json.dumps([time.process_time() - started, choices]))
"""


@pytest.mark.torture
def test_a_proof_of_many_intervals_takes_little_memory_and_time():
    content = LEANING | {"spring": {"stiffness": [7e3, 8e3, 9e3]}}
    ran = subprocess.run(
        [sys.executable, "-c", IN_LITTLE_MEMORY, json.dumps(content)],
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    seconds, choices = json.loads(ran.stdout)
    assert seconds < 30.0
    for choice in choices:
        assert choice["status"] == "proven" or choice["estimate"] is not None
        assert choice["cells"] <= 2**17


def test_no_point_refutes_the_window_proved_for_a_box():
    windows, proved = check_boxes(1, 2)
    assert windows == proved == 2


@pytest.mark.torture
def test_no_point_refutes_the_windows_proved_for_a_thousand_boxes():
    windows, proved = check_boxes(2, 1000)
    assert windows > 500
    assert proved > 0.95 * windows
