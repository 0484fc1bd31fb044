"""Every finding of the paper, judged from the tables of its studies. Fig. n is the paper's figure."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from tendon_cli.paper.runs import DIRECTIONS, PLACES, SIDES, Paper, falls, shared
from tendon_cli.paper.statements import Check, Evidence, statements

_LAST_OF_THE_FIRST_ANGLES = 30.0  # deg, below which "a few initial values" of Fig. 6 lie
_COINCIDE, _DIFFER = 1.0, 30.0  # % of the peak tension
_PRINTED_MU, _AS_PRINTED = np.array([0.073, 0.075]), 5e-4


def failing_by_place(paper: Paper) -> dict[float, list[str]]:
    """Which findings fail, by the distance from the elbow at which the load is held (m)."""
    failing = {}
    for place in paper["fig06-places"].values("arm_load_distance"):
        moved = {study: paper[name].at(arm_load_distance=place) for name, (study, _) in PLACES.items()}
        there = replace(paper, runs={**paper.runs, **moved})
        asked = [each["id"] for each in statements("finding") if each["figure"].removesuffix(".png") in moved]
        failing[place] = [id_ for id_ in asked if not all(FINDINGS[id_](there)[0])]
    return failing


def _ratio(paper: Paper) -> Evidence:
    run = paper["fig04"]
    ratio = run.line("flexor_travel") / run.line("extensor_travel")
    at_one = np.interp(1.0, ratio, run.degrees)
    return [ratio[-1] > 1.0, falls(ratio[::-1])], ratio[-1], at_one, ratio[0]


def _elbow_over_motor(paper: Paper) -> Evidence:
    run = paper["fig06"]
    angles = [run.crossing(load_mass=load) for load in run.loads]
    holds = [
        all(0.0 < angle < _LAST_OF_THE_FIRST_ANGLES for angle in angles),
        all((np.diff(np.sign(run.gain("flexion", load_mass=load))) >= 0.0).all() for load in run.loads),
        all((run.gain("extension", load_mass=load) > 0.0).all() for load in run.loads),
    ]
    return holds, angles, run.loads


def _gain_grows(paper: Paper) -> Evidence:
    run = paper["fig06"]
    gains = [np.array([run.gain(way, load_mass=load) for way in DIRECTIONS]) for load in run.loads]
    grows = [(more > less)[:, run.degrees > 0.0].all() for less, more in itertools.pairwise(gains)]
    at_end = [gained[0, -1] for gained in gains]
    return grows, at_end, run.loads


def _unloaded_flexor(paper: Paper) -> Evidence:
    tension = paper["fig07"].line("flexor_tension_distal", load_mass=0.0)
    return [falls(tension)], tension[0], tension[-1]


def _loaded_flexor(paper: Paper) -> Evidence:
    run = paper["fig07"]
    loads = run.loads[1:]
    lines = np.array([run.line("flexor_tension_distal", load_mass=load) for load in loads])
    at_peak = run.degrees[lines.argmax(axis=1)]
    return list(lines[:, 1] > lines[:, 0]), lines[0, 0], lines.max(axis=1), at_peak, loads


def _extensor(paper: Paper) -> Evidence:
    run = paper["fig07"]
    idle, *loaded = (run.line("extensor_tension_distal", load_mass=load) for load in run.loads)
    return (
        [idle[1] > idle[0], *map(falls, loaded)],
        idle[0],
        idle.max(),
        run.degrees[idle.argmax()],
        [line[-1] for line in loaded],
        run.loads[1:],
    )


def _near_elbow(paper: Paper) -> Evidence:
    run = paper["fig07"]
    largest = max(max(run.apart("tension_distal", load_mass=load)) for load in run.loads)
    return [largest < _COINCIDE], largest


def _near_motor(paper: Paper) -> Evidence:
    run = paper["fig08"]
    smallest = min(min(run.apart("tension_proximal", load_mass=load)) for load in run.loads)
    return [smallest > _DIFFER], smallest


def _slack_at_the_motor(paper: Paper) -> Evidence:
    run = paper["fig08"]
    flexor, extensor = ([run.least(f"{side}_tension_proximal", load_mass=load) for load in run.loads] for side in SIDES)
    holds = [min(flexor) > 0.0, [tension < 0.0 for tension in extensor] == [load > 0.0 for load in run.loads]]
    return holds, flexor, extensor, run.loads


def _at_200_newtons(paper: Paper) -> Evidence:
    run = paper["fig09"]
    slack, required = (
        np.array([run.design(column, load_mass=load) for load in run.loads])
        for column in ("slack_fraction", "required_pretension")
    )
    return [list(slack > 0.0) == [load == 10.0 for load in run.loads]], 100.0 * slack, required, run.loads


def _softer_springs(paper: Paper) -> Evidence:
    run = paper["fig10"]
    springs = sorted(run.values("spring_stiffness"), reverse=True)
    depths = [run.depth(spring_stiffness=spring) for spring in springs]
    shares = [run.design("slack_fraction", spring_stiffness=spring) for spring in springs]
    longest = [1e3 * run.design("max_spring_extension", spring_stiffness=spring) for spring in springs]
    deeper = [paper["fig10-springs"].depth(load_mass=10.0, spring_stiffness=spring) for spring in (3e3, 1e3)]
    windows = [paper["fig06-windows"].window(spring_stiffness=1e3, spool_ratio=1.0, load_mass=load)
               for load in (0.0, 5.0)]  # fmt: skip
    return (
        [falls(depths), falls(shares), falls([-length for length in longest])],
        depths,
        longest,
        np.divide(springs, 1e3),
        *deeper,
        *np.ravel(windows),
    )


def _smaller_ratio(paper: Paper) -> Evidence:
    run = paper["fig11"]
    ratios = sorted(run.values("spool_ratio"), reverse=True)
    depths = [max(0.0, run.depth(spool_ratio=ratio)) for ratio in ratios]
    shares = [100.0 * run.design("slack_fraction", spool_ratio=ratio) for ratio in ratios]
    gone = shares[-1] == 0.0 and run.design("min_extensor_tension", spool_ratio=ratios[-1]) > 0.0
    left = paper["fig11-10kg"].least("extensor_tension_distal", spool_ratio=0.7)
    windows = [paper["fig06-windows"].window(spring_stiffness=3e3, spool_ratio=0.7, load_mass=load)
               for load in (0.0, 5.0, 10.0)]  # fmt: skip
    return [falls(depths), falls(shares), gone], depths, shares, ratios, left, *shared(windows[:2]), windows[2][0]


def _table_a1(paper: Paper) -> Evidence:
    both = np.array([paper.fit.by_direction[way].friction for way in ("toward_motor", "toward_load")])
    holds = np.abs(both - _PRINTED_MU) < _AS_PRINTED
    return list(holds), *both


FINDINGS: dict[str, Check] = {
    "F4": _ratio,
    "F6a": _elbow_over_motor,
    "F6b": _gain_grows,
    "F7a": _unloaded_flexor,
    "F7b": _loaded_flexor,
    "F7c": _extensor,
    "F7d": _near_elbow,
    "F8a": _near_motor,
    "F8b": _slack_at_the_motor,
    "F9": _at_200_newtons,
    "F10": _softer_springs,
    "F11": _smaller_ratio,
    "TA1": _table_a1,
}
