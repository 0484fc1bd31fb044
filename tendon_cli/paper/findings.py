"""Every finding of the paper, judged from the tables of its studies. Fig. n is the paper's figure."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping

import numpy as np

from tendon_cli.friction.result import Fit
from tendon_cli.paper.entry import TRUE, Entry, Verdict, judge
from tendon_cli.paper.measures import DIRECTIONS, SIDES, apart, crossing, depth, falls, gain, least, shared, window
from tendon_cli.paper.runs import PLACES, PaperTables

Runs = Mapping[str, PaperTables]

_LAST_OF_THE_FIRST_ANGLES = 30.0  # deg, below which "a few initial values" of Fig. 6 lie
_COINCIDE, _DIFFER = 1.0, 30.0  # % of the peak tension
_PRINTED_MU, _AS_PRINTED = np.array([0.073, 0.075]), 5e-4


def findings(runs: Runs, fit: Fit) -> list[Entry]:
    """All findings, in the order of the paper; `fit` is that of Table A.1."""
    entries = [check(runs).entry(id_, text, f"{figure}.png") for id_, figure, text, check in _CHECKS]
    text = "Table A.1: the friction coefficient is 0.073 with the weight rising and 0.075 with it falling"
    return [*entries, _table_a1(fit).entry("TA1", text, "table_a1.png")]


def failing_by_place(runs: Runs) -> dict[float, list[str]]:
    """Which findings fail, by the distance from the elbow at which the load is held (m)."""
    failing = {}
    for place in runs["fig06-places"].values("arm_load_distance"):
        moved = {study: runs[name].at(arm_load_distance=place) for name, (study, _) in PLACES.items()}
        checked = {id_: check({**runs, **moved}) for id_, study, _, check in _CHECKS if study in moved}
        failing[place] = [id_ for id_, verdict in checked.items() if verdict.verdict != TRUE]
    return failing


def _ratio(runs: Runs) -> Verdict:
    run = runs["fig04"]
    ratio = run.line("flexor_travel") / run.line("extensor_travel")
    holds = [ratio[-1] > 1.0, falls(ratio[::-1])]
    at_one = np.interp(1.0, ratio, run.degrees)
    return judge(holds, "{:3} at 90°, 1 at {:1}°, {:3} at 1°", ratio[-1], at_one, ratio[0])


def _elbow_over_motor(runs: Runs) -> Verdict:
    run = runs["fig06"]
    loads = run.values("load_mass")
    angles = [crossing(run, load_mass=load) for load in loads]
    holds = [
        all(0.0 < angle < _LAST_OF_THE_FIRST_ANGLES for angle in angles),
        all((np.diff(np.sign(gain(run, "flexion", load_mass=load))) >= 0.0).all() for load in loads),
        all((gain(run, "extension", load_mass=load) > 0.0).all() for load in loads),
    ]
    return judge(holds, "τ_m is the larger one only in flexion below {:1}° ({:0} kg)", angles, loads)


def _gain_grows(runs: Runs) -> Verdict:
    run = runs["fig06"]
    loads = run.values("load_mass")
    gains = [np.array([gain(run, way, load_mass=load) for way in DIRECTIONS]) for load in loads]
    grows = [(more > less)[:, run.degrees > 0.0].all() for less, more in itertools.pairwise(gains)]
    at_end = [gained[0, -1] for gained in gains]
    return judge(grows, "τ_a − τ_m = {:1} N m at 90° in flexion ({:0} kg)", at_end, loads)


def _unloaded_flexor(runs: Runs) -> Verdict:
    tension = runs["fig07"].line("flexor_tension_distal", load_mass=0.0)
    return judge([falls(tension)], "from {:1} N at 0° to {:1} N at 90°", tension[0], tension[-1])


def _loaded_flexor(runs: Runs) -> Verdict:
    run = runs["fig07"]
    loads = run.values("load_mass")[1:]
    lines = np.array([run.line("flexor_tension_distal", load_mass=load) for load in loads])
    at_peak = run.degrees[lines.argmax(axis=1)]
    return judge(list(lines[:, 1] > lines[:, 0]), "from {:1} N to peaks of {:1} N at {:0}° ({:0} kg)",
                 lines[0, 0], lines.max(axis=1), at_peak, loads)  # fmt: skip


def _extensor(runs: Runs) -> Verdict:
    run = runs["fig07"]
    loads = run.values("load_mass")
    idle, *loaded = (run.line("extensor_tension_distal", load_mass=load) for load in loads)
    return judge(
        [idle[1] > idle[0], *map(falls, loaded)],
        "0 kg from {:1} to {:1} N at {:0}°; loaded down to {:1} N at 90° ({:0} kg)",
        idle[0], idle.max(), run.degrees[idle.argmax()], [line[-1] for line in loaded], loads[1:],
    )  # fmt: skip


def _near_elbow(runs: Runs) -> Verdict:
    run = runs["fig07"]
    largest = max(max(apart(run, "tension_distal", load_mass=load)) for load in run.values("load_mass"))
    return judge([largest < _COINCIDE], "at most {:2} % of the peak apart", largest)


def _near_motor(runs: Runs) -> Verdict:
    run = runs["fig08"]
    smallest = min(min(apart(run, "tension_proximal", load_mass=load)) for load in run.values("load_mass"))
    return judge([smallest > _DIFFER], "at least {:1} % of the peak apart", smallest)


def _slack_at_the_motor(runs: Runs) -> Verdict:
    run = runs["fig08"]
    loads = run.values("load_mass")
    flexor, extensor = ([least(run, f"{side}_tension_proximal", load_mass=load) for load in loads] for side in SIDES)
    holds = [min(flexor) > 0.0, [tension < 0.0 for tension in extensor] == [load > 0.0 for load in loads]]
    return judge(holds, "least tension at the motor: flexor {:1} N, extensor {:1} N ({:0} kg)", flexor, extensor, loads)


def _at_200_newtons(runs: Runs) -> Verdict:
    run = runs["fig09"]
    loads = run.values("load_mass")
    slack, required = (
        np.array([run.design(column, load_mass=load) for load in loads])
        for column in ("slack_fraction", "required_pretension")
    )
    return judge([list(slack > 0.0) == [load == 10.0 for load in loads]],
                 "{:0} % of the states slack; {:1} N would be required ({:0} kg)",
                 100.0 * slack, required, loads)  # fmt: skip


def _softer_springs(runs: Runs) -> Verdict:
    run = runs["fig10"]
    springs = sorted(run.values("spring_stiffness"), reverse=True)
    depths = [depth(run, spring_stiffness=spring) for spring in springs]
    shares = [run.design("slack_fraction", spring_stiffness=spring) for spring in springs]
    longest = [1e3 * run.design("max_spring_extension", spring_stiffness=spring) for spring in springs]
    deeper = [depth(runs["fig10-springs"], load_mass=10.0, spring_stiffness=spring) for spring in (3e3, 1e3)]
    windows = [window(runs["fig06-windows"], spring_stiffness=1e3, spool_ratio=1.0, load_mass=load)
               for load in (0.0, 5.0)]  # fmt: skip
    return judge(
        [falls(depths), falls(shares), falls([-length for length in longest])],
        "slack {:1} mm deep, springs extended to {:0} mm (K = {:0} kN/m). Not general: at 10 kg it deepens from {:1} "
        "to {:1} mm (3, 1 kN/m); at 1 kN/m 0 kg takes {:1} to {:1} N of pretension, 5 kg {:1} to {:1} N: none suits "
        "both",
        depths, longest, np.divide(springs, 1e3), *deeper, *np.ravel(windows),
    )  # fmt: skip


def _smaller_ratio(runs: Runs) -> Verdict:
    run = runs["fig11"]
    ratios = sorted(run.values("spool_ratio"), reverse=True)
    depths = [max(0.0, depth(run, spool_ratio=ratio)) for ratio in ratios]
    shares = [100.0 * run.design("slack_fraction", spool_ratio=ratio) for ratio in ratios]
    gone = shares[-1] == 0.0 and run.design("min_extensor_tension", spool_ratio=ratios[-1]) > 0.0
    left = least(runs["fig11-10kg"], "extensor_tension_distal", spool_ratio=0.7)
    windows = [window(runs["fig06-windows"], spring_stiffness=3e3, spool_ratio=0.7, load_mass=load)
               for load in (0.0, 5.0, 10.0)]  # fmt: skip
    return judge(
        [falls(depths), falls(shares), gone],
        "slack {:1} mm deep, in {:0} % of the states (η = {:1}). Not general: at 10 kg η = 0.7 leaves {:1} N; 0 "
        "and 5 kg together take {:1} to {:1} N of pretension, 10 kg at least {:1} N",
        depths, shares, ratios, left, *shared(windows[:2]), windows[2][0],
    )  # fmt: skip


def _table_a1(fit: Fit) -> Verdict:
    found = np.array([fit.by_direction[way].friction for way in ("toward_motor", "toward_load")])
    holds = np.abs(found - _PRINTED_MU) < _AS_PRINTED
    return judge(list(holds), f"μ = {{:4}} rising, {{:4}} falling, at {fit.bend_angle_text}", *found)


_CHECKS: tuple[tuple[str, str, str, Callable[[Runs], Verdict]], ...] = (
    ("F4", "fig04", "The ratio of the radii for no slack, H_f/H_e, exceeds 1 at 90° and falls with the angle", _ratio),
    ("F6a", "fig06", "The elbow torque exceeds the motor torque, but for the first angles of flexion",
     _elbow_over_motor),
    ("F6b", "fig06", "The difference of the torques grows with the load, at every angle above 0°", _gain_grows),
    ("F7a", "fig07", "Without load the flexor tension at the elbow falls throughout flexion", _unloaded_flexor),
    ("F7b", "fig07", "With load the flexor tension at the elbow first rises", _loaded_flexor),
    ("F7c", "fig07", "With load the extensor tension at the elbow falls throughout; without it first rises", _extensor),
    ("F7d", "fig07", "At the elbow the tensions of flexion and extension nearly coincide", _near_elbow),
    ("F8a", "fig08", "At the motor they do not: friction changes its direction", _near_motor),
    ("F8b", "fig08", "The flexor stays in tension at every load; the extensor goes slack at 3 and 10 kg",
     _slack_at_the_motor),
    ("F9", "fig09", "At 200 N pretension there is no slack at 0 and 3 kg, but at 10 kg", _at_200_newtons),
    ("F10", "fig10", "At 5 kg the slack shrinks as the springs soften, and they extend further", _softer_springs),
    ("F11", "fig11", "At 5 kg the slack shrinks with the ratio of the spools, and is gone at 0.7", _smaller_ratio),
)  # fmt: skip
