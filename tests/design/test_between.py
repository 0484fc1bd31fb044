"""The window of an answer is that of the whole motion, whichever angles a study lists."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import tendon_cli as tendon
from tendon_cli.engine.windows import solver as solver_module
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.sampling_error import estimate_error
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.motion_window import window_along
from tendon_cli.model.moving import Moving, motion_columns
from tendon_cli.model.power_window import Motor, within_power
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.model.window import Window, ends_of_states
from tendon_cli.proof import subdivision


@dataclass(frozen=True)
class Suit:
    """A suit and its window under 0 kg and a load, in both directions.

    The window was found with 40 digits, by root search on g(F, G, θ) in mpmath.
    """

    content: dict
    load: float  # kg
    last: int  # largest elbow angle, deg
    limits: dict
    low: float  # N
    high: float  # N
    binding: dict  # elbow angle at which an end binds, if it is inside the motion, deg

    def motion(self, angles):
        """Return the motion at so many angles, as a study has it."""
        return {"elbow_angle": {"from": "0 deg", "to": f"{self.last} deg", "num": angles}}


SUITS = {
    "K 5": Suit(
        content={"spring": {"stiffness": 5e3}, "spool": {"ratio": 0.6}},
        load=10.0,
        last=90,
        limits={},
        low=122.121369120,
        high=173.934155491,
        binding={},
    ),
    "K 2": Suit(
        content={"spring": {"stiffness": 2e3}, "spool": {"ratio": 0.45}},
        load=10.0,
        last=90,
        limits={},
        low=69.195919756,
        high=85.288504590,
        binding={"from": 62.384430},
    ),
    "tension": Suit(
        content={
            "spring": {"stiffness": 5e3},
            "spool": {"ratio": 0.55},
            "arm": {"b1": 0.17, "b2": 0.13},
        },
        load=8.0,
        last=120,
        limits={"max_tension": 380.0},
        low=101.015290544,
        high=152.233691844,
        binding={"to": 47.212074},
    ),
    "torque": Suit(
        content={"spring": {"stiffness": 8e3}, "spool": {"ratio": 0.5}},
        load=10.0,
        last=140,
        limits={"peak_motor_torque": 12.5},
        low=132.579566906,
        high=238.107470235,
        binding={"to": 39.032457},
    ),
    "a2": Suit(
        content={
            "spring": {"stiffness": 5e3},
            "spool": {"ratio": 0.45},
            "arm": {"elbow_radius": 0.04, "a2": 0.01},
        },
        load=10.0,
        last=130,
        limits={},
        low=79.114699387,
        high=127.965755530,
        binding={},
    ),
}


def answered(content, **changes):
    """Return the first choice of the answer to a study with some tables replaced."""
    return tendon.design(tendon.study({**content, **changes})).choices.iloc[0]


@pytest.mark.parametrize("name", SUITS)
def test_the_angles_of_a_study_do_not_change_five_known_windows(name):
    suit = SUITS[name]
    for angles in (5, 20):
        choice = answered(
            suit.content,
            load={"mass": [0.0, suit.load]},
            motion=suit.motion(angles),
            limits=suit.limits,
        )
        assert choice.pretension_from == pytest.approx(suit.low, abs=1e-6), angles
        assert choice.pretension_to == pytest.approx(suit.high, abs=1e-6), angles
        for end, angle in suit.binding.items():
            bound_at = np.degrees(choice[f"{end}_elbow_angle"])
            assert bound_at == pytest.approx(angle, abs=2e-3), angles


def test_the_choices_that_an_answer_names_are_proved_and_it_says_so():
    suit = SUITS["tension"]
    study = tendon.study(
        {
            **suit.content,
            "load": {"mass": [0.0, 3.0, suit.load]},
            "motion": suit.motion(7),
            "limits": suit.limits,
        }
    )
    answer = tendon.design(study.vary(**{"spool.ratio": [0.5, 0.55]}))
    known = answer.record["between_samples"]
    assert known["status"] == "proven"
    assert known["scope"] == "every angle from 0 to 120 deg and every load from 0 to 8 kg"
    assert 0.0 < known["margin"] <= 1e-6
    assert f"the window is proved for {known['scope']}" in " ".join(answer.text.split())
    named = {row["choice"] for row in known["choices"]}
    is_proven = answer.choices.between_samples == "proven"
    assert is_proven.tolist() == [choice in named for choice in range(2)]


@pytest.mark.parametrize("load", ["5 kg", ["0 kg", "5 kg"]])
def test_a_window_of_one_angle_is_proved_for_this_angle(load):
    content = {
        "spring": {"stiffness": "5 kN/m"},
        "spool": {"ratio": 0.6},
        "motion": {"elbow_angle": "60 deg"},
        "load": {"mass": load},
    }
    answer = tendon.design(content)
    scope = answer.record["between_samples"]["scope"]
    assert scope.startswith("the angle of 60 deg")
    assert ("every load from 0 to 5 kg" in scope) == isinstance(load, list)
    for text in (answer.text, answer.short):
        assert "60 to 60" not in text
        assert "for the angle of 60 deg" in " ".join(text.split())


def test_a_window_for_which_the_cells_do_not_suffice_is_open(monkeypatch):
    monkeypatch.setattr(subdivision, "MOST_CELLS", 33)
    answer = tendon.design(tendon.study({"spring": {"stiffness": 5e3}, "spool": {"ratio": 0.6}}))
    assert answer.record["best"]["between_samples"] == "open"
    text = " ".join(answer.text.split())
    assert "not proved for every angle from 0 to 90 deg" in text


def test_the_proof_catches_an_end_that_the_grid_misses(monkeypatch):
    """The grid misses it because no peak between two of its angles is climbed."""
    monkeypatch.setattr(solver_module.Solver, "seek", lambda *_: None)
    suit = SUITS["tension"]
    choice = answered(
        suit.content, load={"mass": [0.0, suit.load]}, limits=suit.limits, motion=suit.motion(5)
    )
    assert choice.between_samples == "proven"
    ends = (choice.pretension_from, choice.pretension_to)
    assert ends == pytest.approx((suit.low, suit.high), abs=1e-6)


def test_the_rows_asked_for_are_proved_and_a_row_that_does_not_exist_is_refused():
    study = tendon.study({"spring": {"stiffness": [3e3, 5e3, 8e3]}, "spool": {"ratio": [0.5, 0.6]}})
    answer = tendon.design(study.vary(**{"design.prove": ["1", "5"]}))
    assert [row["choice"] for row in answer.record["proved"]] == [1, 5]
    assert (answer.choices.between_samples[[1, 5]] == "proven").all()
    for name in ("6", "-1", "9" * 50, "ratio = 0.6"):
        with pytest.raises(tendon.UsageError, match="is not a row of choices"):
            tendon.design(study.vary(**{"design.prove": [name]}))


def test_the_worst_values_of_the_best_choice_are_those_of_all_angles():
    rng = np.random.default_rng(1)
    compared = 0
    for number in range(6):
        content = random_study(rng, number)
        content["arm"] |= {"contact_width": 0.06, "contact_from": "-30 deg"}
        question = question_of(tendon.study(content))
        if not solve(Solver(question), question.all_points()).feasible[0]:
            continue
        best = tendon.design(content).best
        compared += 1
        state = evaluate_all(tendon.study(content), best["pretension"])
        flexor = state.balance.flexor
        extensor = state.balance.extensor
        torque = state.motor_torque.ravel()
        tension = np.maximum(
            higher_end(flexor, state.flexor.capstan), higher_end(extensor, state.extensor.capstan)
        )
        extension = np.maximum(flexor * state.flexor.spring, extensor * state.extensor.spring)
        expected = {
            "max_tension": tension.max(),
            "peak_motor_torque": torque[np.abs(torque).argmax()],
            "max_spring_extension": extension.max(),
            "min_elbow_stiffness": state.elbow_stiffness.min(),
            "max_contact_pressure": extensor.max() / 0.045 / 0.06,
        }
        for name, value in expected.items():
            assert best[name] == pytest.approx(value, rel=1e-8), name
    assert compared == 3


def test_the_curves_of_the_limits_are_the_windows_at_each_angle():
    content = {
        "spring": {"stiffness": "5 kN/m"},
        "spool": {"ratio": 0.6},
        "load": {"mass": ["0 kg", "5 kg"]},
        "limits": {"max_tension": "400 N"},
    }
    curves = tendon.design(content).record["between_samples"]["curves"]
    binding = set()
    for place in (0, 30, 60, 90):
        angle = curves["elbow_angle"][place]
        at_angle = tendon.design(content | {"motion": {"elbow_angle": [f"{angle!r} rad"]}})
        window = at_angle.choices.iloc[0]
        least = {name: values[place] for name, values in curves["lower"].items()}
        largest = {name: values[place] for name, values in curves["upper"].items()}
        below = max(least, key=least.get)
        above = min(largest, key=largest.get)
        assert window["pretension_from"] == pytest.approx(max(0.0, least[below]), rel=1e-9)
        assert window["pretension_to"] == pytest.approx(largest[above], rel=1e-9)
        assert window["to_by"] == above
        if least[below] > 0.0:
            assert window["from_by"] == below
        binding |= {below, above}
    assert binding == {"extensor slack", "max_tension", "min_elbow_stiffness"}


def higher_end(tension, capstan):
    """Return the higher of the tensions at the two ends of a sheath, N."""
    return np.maximum(tension, tension / capstan)


def under_both(question, **numbers):
    """Return the designs of a question under its two conditions."""
    points = question.all_points().with_numbers(numbers)
    return question.paired_designs(points, np.zeros(2, dtype=np.int64), np.arange(2))


def ends_of(question):
    """Return the ends of the windows of all choices."""
    return Solver(question).ends(question.all_points())


def windows_of(question):
    """Return the windows of all choices with the limits that bind."""
    return Solver(question).windows(question.all_points())


def evaluate_all(study, pretension):
    """Return the states at very many angles under both conditions, at a pretension."""
    question = question_of(study)
    angles = np.linspace(question.angles.min(), question.angles.max(), 20001)
    designs = under_both(question, **{"tendon.pretension": np.array([pretension])})
    return State.of(designs, angles[np.newaxis], question.flexion)


# --- Two nearly equal peaks -----------------------------------------------------------------------


@pytest.mark.parametrize("apart", [-0.004, 0.002])
def test_of_two_nearly_equal_peaks_the_higher_one_ends_the_window(apart):
    """The grid is wrong about which peak is higher.

    The tension's peak lies 0.013 N above the grid's, the torque's 0.005 N.
    """
    suit = SUITS["tension"]
    common = {**suit.content, "load": {"mass": suit.load}, "motion": suit.motion(5)}

    def beyond(torque):
        question = question_of(tendon.study({**common, "limits": {"peak_motor_torque": torque}}))
        _, high = searched(question)
        return high - suit.high - apart

    torque = brentq(beyond, 9.2, 10.0, xtol=1e-11)
    choice = answered(common, limits={**suit.limits, "peak_motor_torque": torque})
    assert choice.between_samples == "proven"
    assert choice.pretension_to == pytest.approx(suit.high + min(apart, 0.0), abs=1e-7)
    assert choice.to_by == ("max_tension" if apart > 0.0 else "peak_motor_torque")


def test_of_two_nearly_equal_peaks_the_higher_one_is_the_worst():
    """The grid is wrong about which of two cases, with peaks at different angles, is higher.

    Other cases lead elsewhere.
    """
    suit = SUITS["tension"]
    soft = {"load": {"mass": 4.0}, "spool": {"flexor_radius": 0.06}, "spring": {"stiffness": 3e3}}
    more_cases = ({"name": "c"}, {"name": "d", **soft})

    def study_of(mass, *more):
        tilted = {"name": "b", "load": {"mass": mass}, "arm": {"upper_arm_angle": "15 deg"}}
        return tendon.study(
            {
                **suit.content,
                "motion": suit.motion(5),
                "cases": [{"name": "a", "load": {"mass": suit.load}}, tilted, *more],
                "design": {"pretension": "130 N"},
            }
        )

    def peaks(mass):
        state = evaluate_all(study_of(mass), 130.0)
        flexor = higher_end(state.balance.flexor, state.flexor.capstan)
        extensor = higher_end(state.balance.extensor, state.extensor.capstan)
        return np.maximum(flexor.max(axis=(1, 2)), extensor.max(axis=(1, 2)))

    def difference(mass):
        first, second = peaks(mass)
        return first - second + 1e-4

    mass = brentq(difference, 4.0, 8.0, xtol=1e-9)
    _, expected = peaks(mass)
    answer = tendon.design(study_of(mass, *more_cases))
    assert answer.choices.max_tension[0] == pytest.approx(expected, rel=1e-9)


# --- Intervals ------------------------------------------------------------------------------------


# Spring stiffness (N/m), spool ratio, load (kg), least and largest upper arm angle (deg)
INTERVALS = {
    "worst at an end": (8e3, 0.5, 10.0, -20, 20),
    "worst where the forearm is level": (12e3, 0.4, 2.0, -30, 120),
}


@pytest.mark.parametrize("worst", INTERVALS)
def test_the_window_of_an_interval_of_postures_is_proved_and_that_of_very_many(worst):
    stiffness, ratio, load, low, high = INTERVALS[worst]
    content = {
        "spring": {"stiffness": stiffness},
        "spool": {"ratio": ratio},
        "load": {"mass": [0.0, load]},
    }
    interval = {"from": f"{low} deg", "to": f"{high} deg"}
    answer = tendon.design({**content, "arm": {"upper_arm_angle": interval}})
    known = answer.record["between_samples"]
    assert known["status"] == "proven"
    assert f"every upper arm angle from {low} to {high} deg" in known["scope"]
    postures = [f"{angle} deg" for angle in np.linspace(low, high, 301)]
    many = ends_of(question_of(tendon.study({**content, "arm": {"upper_arm_angle": postures}})))
    assert answer.choices.pretension_from[0] == pytest.approx(many.low.max(), abs=2e-6)
    assert answer.choices.pretension_to[0] == pytest.approx(many.high.min(), abs=2e-6)


# --- A limit on power, and motions in time --------------------------------------------------------


def test_the_worst_power_at_a_load_between_two_is_found():
    """Power is a parabola in the load.

    Here 0 and 12.7 kg keep the limit at pretensions at which 6 kg does not.
    """
    content = {
        "spring": {"stiffness": 4633.0},
        "spool": {"ratio": 0.22},
        "sheath": {"friction": 0.083},
        "arm": {"upper_arm_angle": "20.7 deg", "load_distance": 0.283},
        "motion": {"speed": "60 deg/s", "elbow_angle": {"from": "0 deg", "to": "86 deg", "num": 9}},
        "limits": {"min_elbow_stiffness": -50.0, "peak_motor_power": 43.0},
    }
    few = answered(content, load={"mass": [0.0, 12.7]})
    loads = np.linspace(0.0, 12.7, 21).tolist()
    many = ends_of(question_of(tendon.study({**content, "load": {"mass": loads}})))
    assert few.between_samples == "sampled"
    assert few.pretension_to == pytest.approx(many.high.min(), rel=1e-4)
    heaviest = question_of(tendon.study({**content, "load": {"mass": 12.7}}))
    assert few.pretension_to < ends_of(heaviest).high[0, 0] - 1.0


def limited(rng, question, low, high):
    """Return the question with a limit on power that is reached at a pretension in the window."""
    designs = under_both(question)
    pretension = np.full(2, low + rng.uniform(0.2, 0.8) * (high - low))
    trajectory = question.study.trajectory
    if trajectory is not None:
        along = replace(designs, trajectory=trajectory)
        moving = Moving.of(along, trajectory).at_pretension(pretension[:, np.newaxis, np.newaxis])
        power = motion_columns(moving)["peak_motor_power"]
    else:
        speed = question.bounds.speed
        motor = Motor(designs, question.angles, question.flexion, (2,), speed)
        power = motor.peak_power(pretension)
    bounds = question.bounds.changed("peak_motor_power", float(power.max()))
    return replace(question, bounds=bounds)


def check_estimates(cases):
    """Check the estimates of cases by denser samples; return how many windows these narrow.

    A case is a question, its window, and a function that returns the window of denser samples.
    """
    narrower = 0
    for question, (low, high), dense_window in cases:
        if not low <= high:
            continue
        solver = Solver(question)
        points = question.all_points()
        folded = solver.fold(points)
        solver.seek(folded, points)
        estimate = estimate_error(solver, solve(solver, points), folded)
        if estimate is None:
            continue
        dense_low, dense_high = dense_window()
        assert np.max([0.0, dense_low - low, high - dense_high]) <= estimate
        narrower += max(dense_low - low, high - dense_high) > 0.0
    return narrower


def within_power_of_the_motor(seed, count):
    """Yield random questions with a limit on power, as `check_estimates` has them."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        content = random_study(rng, number)
        content["limits"] = {"peak_motor_power": 1e6}
        content["allow_implausible"] = True
        content["motion"]["speed"] = "60 deg/s"
        question = question_of(tendon.study(content))
        of_states = windows_of(replace(question, bounds=Bounds()))
        highest = min(of_states.high.min(), 1e3)
        question = limited(rng, question, of_states.low.max(), highest)
        windows = windows_of(question)
        ends = (windows.low.max(), windows.high.min())
        yield question, ends, partial(ends_at_many_angles, question, of_states)


def ends_at_many_angles(question, of_states):
    """Narrow the windows of the states by the limit on power at eight thousand angles."""
    angles = np.linspace(question.angles.min(), question.angles.max(), 8001)
    windows = within_power(
        Window(**{name: values[0] for name, values in vars(of_states).items()}),
        under_both(question),
        angles[np.newaxis],
        question.flexion,
        question.bounds,
        question.loads,
    )
    return windows.low.max(), windows.high.min()


def test_sampling_does_not_miss_more_than_is_estimated():
    assert check_estimates(within_power_of_the_motor(4, 12)) > 1


def test_an_estimate_is_in_the_reading_of_the_pretension():
    content = {
        "spring": {"stiffness": 5e3},
        "spool": {"ratio": 0.6},
        "motion": {"speed": "60 deg/s"},
        "limits": {"peak_motor_power": "20 W"},
        "load": {"mass": 5.0},
    }

    def width_and_estimate(reading):
        record = tendon.design(tendon.study({**content, "setting": {"read": reading}})).record
        width = record["best"]["pretension_to"] - record["best"]["pretension_from"]
        return width, record["between_samples"]["estimate"]

    plain_width, plain_estimate = width_and_estimate("pretension")
    read_width, read_estimate = width_and_estimate("extensor at motor")
    slope = read_width / plain_width
    assert read_estimate == pytest.approx(slope * plain_estimate, rel=1e-2)


@pytest.mark.torture
def test_ten_thousand_estimates_are_not_too_small():
    assert check_estimates(within_power_of_the_motor(5, 10_000)) > 100


def random_motion(rng):
    """Return angles over time as a file would have them.

    They are swings of several frequencies, some after a rest, some with noise.
    """
    rate = rng.choice([25.0, 50.0, 100.0])
    cutoff = rng.uniform(2.0, 8.0)
    seconds = 6.1 / cutoff + rng.uniform(0.0, 3.0)
    seconds = max(seconds, 6.01 / cutoff + 1.0 / rate)  # the last sample may lie a step before
    time = np.round(np.arange(0.0, seconds, 1.0 / rate), 6)
    sizes = rng.dirichlet(np.ones(3))
    turns = 2.0 * np.pi * rng.uniform(0.2, 1.5, 3)
    swing = sum(
        size * np.cos(turn * time + rng.uniform(0.0, 6.0))
        for size, turn in zip(sizes, turns, strict=True)
    )
    if rng.random() < 0.3:
        rest = 0.4 * seconds
        swing = np.where(time < rest, swing[0], np.interp(time - rest, time, swing))
    noise = rng.normal(0.0, rng.choice([0.0, 0.3]), len(time))
    angle = rng.uniform(45.0, 70.0) + rng.uniform(20.0, 40.0) * swing + noise
    return {
        "trajectory": {
            "time": time.tolist(),
            "angle": [f"{value!r} deg" for value in angle.tolist()],
        },
        "cutoff": f"{cutoff} Hz",
        "inertia": float(rng.choice([0.0, 0.08])),
    }


def refined_motion(trajectory, times):
    """Return a trajectory of so many times the samples, by splines through the given ones."""
    samples = times * (len(trajectory.time) - 1) + 1
    time = np.linspace(trajectory.time[0], trajectory.time[-1], samples)
    angle = CubicSpline(trajectory.time, trajectory.angle)(time)
    derivatives = [CubicSpline(trajectory.time, values)(time) for values in trajectory.derivatives]
    return Trajectory(time, angle, np.array(derivatives), margin=trajectory.margin)


def ends_along(question, trajectory):
    """Return the ends of the window along a trajectory."""
    designs = replace(under_both(question), trajectory=trajectory)
    windows = window_along(designs, trajectory, question.bounds)
    return windows.low.max(), min(windows.high.min(), 1e3)


def ends_along_refined(question, trajectory):
    """Return the ends of the window along a trajectory of twenty times the samples."""
    return ends_along(question, refined_motion(trajectory, 20))


def along_trajectories(seed, numbers):
    """Yield random questions along trajectories, as `check_estimates` has them.

    Every second one has a limit on power, the others have other limits.
    """
    for number in numbers:
        rng = np.random.default_rng([seed, number])
        content = random_study(rng, number // 2)
        content["motion"] = random_motion(rng)
        limits = content["limits"]
        has_power = number % 2 == 1
        if has_power:
            limits = {"peak_motor_power": 1e5}
        content["limits"] = {"min_elbow_stiffness": -200.0} | limits
        content["allow_implausible"] = True
        question = question_of(tendon.study(content))
        trajectory = question.study.trajectory
        ends = ends_along(question, trajectory)
        if has_power:
            question = limited(rng, question, *ends)
            ends = ends_along(question, trajectory)
        yield question, ends, partial(ends_along_refined, question, trajectory)


def test_the_samples_of_a_trajectory_do_not_miss_more_than_is_estimated():
    assert check_estimates(along_trajectories(6, [0, 4])) > 1


def test_an_estimate_covers_an_end_that_jumps_with_the_density_of_samples():
    """In this motion a tendon turns for a moment, which some densities see and others do not."""
    assert check_estimates(along_trajectories(7, [1122])) == 1


@pytest.mark.torture
def test_two_thousand_estimates_along_trajectories_are_not_too_small():
    assert check_estimates(along_trajectories(7, range(2000))) > 300


# --- Random designs -------------------------------------------------------------------------------


LIMITS_OF_STATES = (
    {},
    {"max_tension": 500.0},
    {"peak_motor_torque": 14.0},
    {"max_spring_extension": 0.09, "min_flexor_tension": 20.0},
    {"min_extensor_tension": 15.0},
)


def random_study(rng, number):
    """Return a random design under 0 kg and a random load; the number selects its limits."""
    return {
        "arm": {
            "b1": rng.uniform(0.13, 0.17),
            "a1": rng.uniform(0.03, 0.05),
            "upper_arm_angle": f"{rng.uniform(-20, 40)} deg",
        },
        "sheath": {"friction": rng.uniform(0.0, 0.15)},
        "spring": {"stiffness": rng.uniform(2e3, 8e3)},
        "spool": {"ratio": rng.uniform(0.4, 0.9)},
        "load": {"mass": [0.0, rng.uniform(2.0, 10.0)]},
        "limits": LIMITS_OF_STATES[number % len(LIMITS_OF_STATES)],
        "motion": {
            "elbow_angle": {"from": "0 deg", "to": f"{rng.uniform(60.0, 140.0)} deg", "num": 4}
        },
    }


def searched(question):
    """Return the window over all angles, by a search over very many and then closer ones."""
    angles = np.linspace(question.angles.min(), question.angles.max(), 4001)
    low = top_of(question, 0, angles)
    high = -top_of(question, 1, angles)
    return max(low, 0.0), high


def top_of(question, end, angles, *, closer=True):
    """Return the highest lower end that limits ask for at the angles and between them, N.

    Between angles it is the top of the parabola through three neighbours. The upper end (`end`
    1) is sought with its sign changed. With `closer`, the highest top is searched once more.
    """
    states = State.of(question.designs(question.all_points()), angles[np.newaxis], question.flexion)
    values = ends_of_states(states, question.bounds)[end]
    if end == 1:
        values = -values
    before = values[..., :-2]
    middle = values[..., 1:-1]
    after = values[..., 2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        top = middle - (after - before) ** 2 / 8.0 / (before - 2.0 * middle + after)
    is_peak = (middle >= before) & (middle >= after)
    peaks = np.where(is_peak, top, middle)
    if closer and np.isfinite(peaks).any():
        index = np.unravel_index(np.nanargmax(peaks), peaks.shape)[-1]
        closer_angles = np.linspace(angles[index], angles[index + 2], 101)
        inside = top_of(question, end, closer_angles, closer=False)
        return max(inside, np.nanmax(values))
    return max(np.nanmax(peaks), np.max(values[..., [0, -1]]))


def check_random_windows(seed, count):
    """Check that the windows of random designs are proved and agree with the search."""
    rng = np.random.default_rng(seed)
    proved = 0
    for number in range(count):
        study = tendon.study(random_study(rng, number))
        question = question_of(study)
        low, high = searched(question)
        solution = solve(Solver(question), question.all_points())
        lower = solution.pretension_from[0]
        upper = solution.pretension_to[0]
        if solution.feasible[0]:
            choice = tendon.design(study).choices.iloc[0]
            assert choice.between_samples == "proven"
            lower = choice.pretension_from
            upper = np.inf if np.isnan(choice.pretension_to) else choice.pretension_to
            proved += 1
        elif np.isnan(lower) or np.isnan(low):
            assert np.isnan(low)
            continue
        elif max(abs(low), abs(high)) > 1e4:
            # Beside an angle at which no pretension changes a limit, the ends are huge.
            assert low > high
            continue
        assert lower == pytest.approx(low, abs=1e-7)
        assert upper == pytest.approx(high, abs=1e-7)
    assert proved > count / 3


def test_random_windows_are_proved_and_those_of_a_search():
    check_random_windows(8, 6)


@pytest.mark.torture
def test_two_thousand_windows_are_proved_and_those_of_a_search():
    check_random_windows(9, 2000)
