"""Every finding of the paper, judged from the tables of its studies. Fig. n is the paper's figure."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping

import numpy as np

from tendon_cli.friction.result import FrictionFit
from tendon_cli.paper.entry import Entry, Verdict, listed, number
from tendon_cli.paper.runs import Array, Run

_DIRECTIONS = ("flexion", "extension")
_LAST_OF_THE_FIRST_ANGLES = 30.0  # deg, below which "a few initial values" of Fig. 6 lie
_COINCIDE, _DIFFER = 0.01, 0.30  # shares of the peak tension
_PRINTED_MU, _AS_PRINTED = (0.073, 0.075), 5e-4


def findings(runs: Mapping[str, Run], fit: FrictionFit) -> list[Entry]:
    """All findings, in the order of the paper; `fit` is that of Table A.1."""
    entries = []
    for name, figure, text, check in _CHECKS:
        verdict = check(runs[figure])
        entries.append(Entry(name, text, verdict.holds, verdict.value, f"{figure}.png"))
    verdict = _table_a1(fit)
    text = "Table A.1: the friction coefficient is 0.073 with the weight rising and 0.075 with it falling"
    return [*entries, Entry("TA1", text, verdict.holds, verdict.value, "table_a1.png")]


def crossing(run: Run, load: float) -> float:
    """The elbow angle of flexion at which the elbow torque comes to exceed the motor torque, deg; NaN for none."""
    gain = _gain(run, "flexion", load)
    below = np.flatnonzero(gain <= 0.0)
    if not len(below) or below[-1] + 1 == len(gain):
        return float("nan")
    last = int(below[-1])
    return float(np.interp(0.0, gain[last : last + 2], run.degrees[last : last + 2]))


def depth(run: Run, **fixed: float) -> float:
    """How deep the extensor's slack is: -(least distal tension) / K, mm; negative where it stays in tension."""
    least = min(run.line("extensor_tension_distal", way, **fixed).min() for way in _DIRECTIONS)
    return float(-1e3 * least / run.design("spring_stiffness", **fixed))


def apart(run: Run, end: str, load: float) -> float:
    """Largest difference between flexion and extension over the peak tension, of the two tendons the larger share."""
    return max(_shares(run, end, load))


def _shares(run: Run, end: str, load: float) -> list[float]:
    shares = []
    for side in ("flexor", "extensor"):
        flexion, extension = (run.line(f"{side}_tension_{end}", way, load_mass=load) for way in _DIRECTIONS)
        peak = max(np.abs(flexion).max(), np.abs(extension).max())
        shares.append(float(np.abs(flexion - extension).max() / peak))
    return shares


def _gain(run: Run, direction: str, load: float) -> Array:
    return run.line("elbow_torque", direction, load_mass=load) - run.line("motor_torque", direction, load_mass=load)


def _falls(values: Array | list[float]) -> bool:
    return bool((np.diff(values) < 0.0).all())


def _loads(run: Run) -> str:
    return f"{listed(run.values('load_mass'), 0)} kg"


def _ratio(run: Run) -> Verdict:
    ratio = run.line("flexor_travel") / run.line("extensor_travel")
    at_one = float(np.interp(1.0, ratio, run.degrees))
    ends = f"{number(ratio[-1], 3)} at 90°, 1 at {number(at_one)}°, {number(ratio[0], 3)} at 1°"
    return Verdict(bool(ratio[-1] > 1.0) and _falls(ratio[::-1]), ends)


def _elbow_over_motor(run: Run) -> Verdict:
    loads = run.values("load_mass")
    angles = [crossing(run, load) for load in loads]
    once = all((np.diff(np.sign(_gain(run, "flexion", load))) >= 0.0).all() for load in loads)
    first = all(0.0 < angle < _LAST_OF_THE_FIRST_ANGLES for angle in angles)
    back = min(_gain(run, "extension", load).min() for load in loads)
    value = f"τ_m is the larger one only in flexion below {listed(angles)}° ({_loads(run)})"
    return Verdict(bool(once and first and back > 0.0), value)


def _gain_grows(run: Run) -> Verdict:
    loads = run.values("load_mass")
    gains = {way: [_gain(run, way, load)[run.degrees > 0.0] for load in loads] for way in _DIRECTIONS}
    grows = all((more > less).all() for way in _DIRECTIONS for less, more in itertools.pairwise(gains[way]))
    at_end = listed([gain[-1] for gain in gains["flexion"]])
    return Verdict(bool(grows), f"τ_a − τ_m = {at_end} N m at 90° in flexion ({_loads(run)})")


def _unloaded_flexor(run: Run) -> Verdict:
    tension = run.line("flexor_tension_distal", load_mass=0.0)
    return Verdict(_falls(tension), f"from {number(tension[0])} N at 0° to {number(tension[-1])} N at 90°")


def _loaded_flexor(run: Run) -> Verdict:
    loads = [load for load in run.values("load_mass") if load > 0.0]
    lines = [run.line("flexor_tension_distal", load_mass=load) for load in loads]
    peaks = [f"{number(line.max())} N at {number(run.degrees[line.argmax()], 0)}°" for line in lines]
    value = f"from {number(lines[0][0])} N to peaks of {', '.join(peaks)} ({listed(loads, 0)} kg)"
    return Verdict(all(line[1] > line[0] for line in lines), value)


def _extensor(run: Run) -> Verdict:
    loads = [load for load in run.values("load_mass") if load > 0.0]
    idle = run.line("extensor_tension_distal", load_mass=0.0)
    lines = [run.line("extensor_tension_distal", load_mass=load) for load in loads]
    rise = f"0 kg from {number(idle[0])} to {number(idle.max())} N at {number(run.degrees[idle.argmax()], 0)}°"
    fall = f"{listed([line[-1] for line in lines])} N at 90° ({listed(loads, 0)} kg)"
    return Verdict(all(map(_falls, lines)) and bool(idle[1] > idle[0]), f"{rise}; loaded down to {fall}")


def _near_elbow(run: Run) -> Verdict:
    largest = max(apart(run, "distal", load) for load in run.values("load_mass"))
    return Verdict(largest < _COINCIDE, f"at most {number(100.0 * largest, 2)} % of the peak apart")


def _near_motor(run: Run) -> Verdict:
    least = min(min(_shares(run, "proximal", load)) for load in run.values("load_mass"))
    return Verdict(least > _DIFFER, f"at least {number(100.0 * least)} % of the peak apart")


def _slack_at_the_motor(run: Run) -> Verdict:
    least = {
        side: [
            min(run.line(f"{side}_tension_proximal", way, load_mass=load).min() for way in _DIRECTIONS)
            for load in run.values("load_mass")
        ]
        for side in ("flexor", "extensor")
    }
    as_found = [tension < 0.0 for tension in least["extensor"]] == [load > 0.0 for load in run.values("load_mass")]
    value = (
        f"least tension at the motor: flexor {listed(least['flexor'])} N, extensor {listed(least['extensor'])} N "
        f"({_loads(run)})"
    )
    return Verdict(min(least["flexor"]) > 0.0 and as_found, value)


def _at_200_newtons(run: Run) -> Verdict:
    loads = run.values("load_mass")
    slack = [run.design("slack_fraction", load_mass=load) for load in loads]
    required = [run.design("required_pretension", load_mass=load) for load in loads]
    holds = [share > 0.0 for share in slack] == [load == 10.0 for load in loads]
    value = f"{listed([100.0 * share for share in slack], 0)} % of the states slack; "
    return Verdict(holds, f"{value}{listed(required)} N would be required ({_loads(run)})")


def _softer_springs(run: Run) -> Verdict:
    springs = sorted(run.values("spring_stiffness"), reverse=True)
    depths = [depth(run, spring_stiffness=value) for value in springs]
    shares = [run.design("slack_fraction", spring_stiffness=value) for value in springs]
    longest = [1e3 * run.design("max_spring_extension", spring_stiffness=value) for value in springs]
    holds = _falls(depths) and _falls(shares) and _falls([-length for length in longest])
    value = f"slack {listed(depths)} mm deep, springs extended to {listed(longest, 0)} mm"
    return Verdict(holds, f"{value} (K = {listed([spring / 1e3 for spring in springs], 0)} kN/m)")


def _smaller_ratio(run: Run) -> Verdict:
    ratios = sorted(run.values("spool_ratio"), reverse=True)
    depths = [max(0.0, depth(run, spool_ratio=value)) for value in ratios]
    shares = [100.0 * run.design("slack_fraction", spool_ratio=value) for value in ratios]
    gone = shares[-1] == 0.0 and run.design("min_extensor_tension", spool_ratio=ratios[-1]) > 0.0
    value = f"slack {listed(depths)} mm deep, in {listed(shares, 0)} % of the states (η = {listed(ratios)})"
    return Verdict(_falls(depths) and _falls(shares) and gone, value)


def _table_a1(fit: FrictionFit) -> Verdict:
    found = [fit.by_direction[way].friction for way in ("toward_motor", "toward_load")]
    holds = all(abs(mu - printed) < _AS_PRINTED for mu, printed in zip(found, _PRINTED_MU, strict=True))
    return Verdict(holds, f"μ = {number(found[0], 4)} rising, {number(found[1], 4)} falling, at {fit.bend_angle_text}")


_CHECKS: tuple[tuple[str, str, str, Callable[[Run], Verdict]], ...] = (
    ("F4", "fig04", "The ratio of the radii for no slack, H_f/H_e, exceeds 1 at 90° and falls with the angle", _ratio),
    (
        "F6a",
        "fig06",
        "The elbow torque exceeds the motor torque, but for the first angles of flexion",
        _elbow_over_motor,
    ),
    ("F6b", "fig06", "The difference of the torques grows with the load, at every angle above 0°", _gain_grows),
    ("F7a", "fig07", "Without load the flexor tension at the elbow falls throughout flexion", _unloaded_flexor),
    ("F7b", "fig07", "With load the flexor tension at the elbow first rises", _loaded_flexor),
    ("F7c", "fig07", "With load the extensor tension at the elbow falls throughout; without it first rises", _extensor),
    ("F7d", "fig07", "At the elbow the tensions of flexion and extension nearly coincide", _near_elbow),
    ("F8a", "fig08", "At the motor they do not: friction changes its direction", _near_motor),
    (
        "F8b",
        "fig08",
        "The flexor stays in tension at every load; the extensor goes slack at 3 and 10 kg",
        _slack_at_the_motor,
    ),
    ("F9", "fig09", "At 200 N pretension there is no slack at 0 and 3 kg, but at 10 kg", _at_200_newtons),
    ("F10", "fig10", "At 5 kg the slack shrinks as the springs soften, and they extend further", _softer_springs),
    ("F11", "fig11", "At 5 kg the slack shrinks with the ratio of the spools, and is gone at 0.7", _smaller_ratio),
)
