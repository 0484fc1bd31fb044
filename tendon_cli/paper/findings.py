"""Every finding and claim of the paper, judged from the tables of its studies. Fig. n is the paper's figure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tendon_cli.paper.runs import PLACES, SIDES, Paper, apart, falls, served
from tendon_cli.paper.statements import Check, Evidence, content

_LAST_OF_THE_FIRST_ANGLES = 30.0  # deg, below which "a few initial values" of Fig. 6 lie
_COINCIDE, _DIFFER = 1.0, 30.0  # % of the peak tension
_PRINTED_MU, _AS_PRINTED = np.array([0.073, 0.075]), 5e-4
_NONE = 1e-9  # %, what rounding leaves of a difference
_PEOPLE = 500
_SEEN, _HARDLY = (
    10.0,
    1.0,
)  # % of the peak: a deviation that shows in a figure, and one that does not


def failing_by_place(paper: Paper) -> dict[float, list[str]]:
    """Which findings fail, by the distance from the elbow at which the load is held (m)."""
    failing = {}
    for place in paper["fig06-places"].values("arm_load_distance").tolist():
        moved = {
            study: paper[name].at(arm_load_distance=place) for name, (study, _) in PLACES.items()
        }
        there = replace(paper, runs={**paper.runs, **moved})
        asked = [
            each["id"]
            for each in content()["finding"]
            if each["figure"].removesuffix(".png") in moved
        ]
        failing[place] = [id_ for id_ in asked if not all(FINDINGS[id_](there)[0])]
    return failing


# --- Findings --------------------------------------------------------------------------------------------------------


def _ratio(paper: Paper) -> Evidence:
    run = paper["fig04"]
    ratio = run.travel_ratio()
    return (
        [ratio[-1] > 1.0, falls(ratio[::-1])],
        ratio[-1],
        np.interp(1.0, ratio, run.degrees),
        ratio[0],
    )


def _elbow_over_motor(paper: Paper) -> Evidence:
    run = paper["fig06"]
    angles, gain = run.crossings(), run.gain()
    is_first = all(0.0 < angle < _LAST_OF_THE_FIRST_ANGLES for angle in angles)
    return (
        [is_first, (np.diff(np.sign(gain[:, 0])) >= 0.0).all(), (gain[:, 1] > 0.0).all()],
        angles,
        run.loads,
    )


def _gain_grows(paper: Paper) -> Evidence:
    run = paper["fig06"]
    gain = run.gain()
    grows = (np.diff(gain, axis=0) > 0.0)[..., run.degrees > 0.0].all(axis=(1, 2))
    return grows.tolist(), gain[:, 0, -1], run.loads


def _unloaded_flexor(paper: Paper) -> Evidence:
    tension = paper["fig07"].line("flexor_tension_distal", load_mass=0.0)
    return [falls(tension)], tension[0], tension[-1]


def _loaded_flexor(paper: Paper) -> Evidence:
    run = paper["fig07"]
    lines = run.curves("flexor_tension_distal")[1:, 0]
    at_peak = run.degrees[lines.argmax(axis=1)]
    return list(lines[:, 1] > lines[:, 0]), lines[0, 0], lines.max(axis=1), at_peak, run.loads[1:]


def _extensor(paper: Paper) -> Evidence:
    run = paper["fig07"]
    idle, *loaded = run.curves("extensor_tension_distal")[:, 0]
    ends, at_peak = [line[-1] for line in loaded], run.degrees[idle.argmax()]
    return (
        [idle[1] > idle[0], *map(falls, loaded)],
        idle[0],
        idle.max(),
        at_peak,
        ends,
        run.loads[1:],
    )


def _near_elbow(paper: Paper) -> Evidence:
    largest = paper["fig07"].apart("tension_distal").max()
    return [largest < _COINCIDE], largest


def _near_motor(paper: Paper) -> Evidence:
    smallest = paper["fig08"].apart("tension_proximal").min()
    return [smallest > _DIFFER], smallest


def _slack_at_the_motor(paper: Paper) -> Evidence:
    run = paper["fig08"]
    flexor, extensor = (run.least(f"{side}_tension_proximal") for side in SIDES)
    return (
        [flexor.min() > 0.0, ((extensor < 0.0) == (run.loads > 0.0)).all()],
        flexor,
        extensor,
        run.loads,
    )


def _at_200_newtons(paper: Paper) -> Evidence:
    run = paper["fig09"]
    slack, required = run.design("slack_fraction"), run.design("required_pretension")
    return [((slack > 0.0) == (run.loads == 10.0)).all()], 100.0 * slack, required, run.loads


def _softer_springs(paper: Paper) -> Evidence:
    run, heavy, soft = (
        paper["fig10"],
        {"load_mass": 10.0},
        {"spring_stiffness": 1e3, "spool_ratio": 1.0},
    )
    depths, longest = run.depth(), 1e3 * run.design("max_spring_extension")
    deeper = [
        paper["fig10-springs"].depth(spring_stiffness=spring, **heavy) for spring in (3e3, 1e3)
    ]
    windows = [paper["fig06-windows"].windows(load_mass=load, **soft) for load in (0.0, 5.0)]
    holds = [falls(depths), falls(run.design("slack_fraction")), falls(-longest)]
    return holds, depths, longest, run.values("spring_stiffness") / 1e3, *deeper, *np.ravel(windows)


def _smaller_ratio(paper: Paper) -> Evidence:
    run = paper["fig11"]
    depths, shares = np.maximum(0.0, run.depth()), 100.0 * run.design("slack_fraction")
    gone = shares[-1] == 0.0 and run.design("min_extensor_tension")[-1] > 0.0
    left = paper["fig11-10kg"].least("extensor_tension_distal", spool_ratio=0.7)
    choice = {"spring_stiffness": 3e3, "spool_ratio": 0.7}
    (idle, loaded, heavy) = (
        paper["fig06-windows"].windows(load_mass=load, **choice) for load in (0.0, 5.0, 10.0)
    )
    shared = max(idle[0], loaded[0]), min(idle[1], loaded[1])
    return (
        [falls(depths), falls(shares), gone],
        depths,
        shares,
        run.values("spool_ratio"),
        left,
        *shared,
        heavy[0],
    )


def _table_a1(paper: Paper) -> Evidence:
    both = np.array(
        [paper.fit.by_direction[way].friction for way in ("toward_motor", "toward_load")]
    )
    return list(np.abs(both - _PRINTED_MU) < _AS_PRINTED), *both


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

# --- Claims: what the paper says beyond its figures ------------------------------------------------------------------


def _elongations(paper: Paper) -> Evidence:
    tendons, springs = (paper["fig07"].apart(f"{part}_stretch") for part in ("tendon", "spring"))
    without = paper["fig07-smooth"].apart("tendon_stretch").max()
    numbers = tendons.min(), tendons.max(), springs.max(), without
    return [tendons.min() > _SEEN, springs.max() < _HARDLY, without < _NONE], *numbers


def _friction_near_the_motor(paper: Paper) -> Evidence:
    with_, without = (paper[name].apart("tension_proximal") for name in ("fig08", "fig07-smooth"))
    return [with_.min() > _SEEN, without.max() < _NONE], with_.min(), with_.max(), without.max()


def _first_angles(paper: Paper) -> Evidence:
    run = paper["fig06-pretensions"]
    ends, starts = run.crossings(), run.gain()[:, 0, 0]
    holds = [falls(ends[::-1]), falls(starts), abs(starts[0]) < 0.05 * abs(starts[2])]
    return holds, ends, starts, run.values("pretension")


def _springs_solve(paper: Paper) -> Evidence:
    run = paper["fig10-springs"]
    light, heavy = (run.depth(load_mass=load) for load in (5.0, 10.0))
    holds = [depths.min() < 0.0 and falls(depths) for depths in (light, heavy)]
    return holds, np.maximum(light, 0.0), heavy, run.values("spring_stiffness") / 1e3


def _ratio_solves(paper: Paper) -> Evidence:
    least = [paper[name].least("extensor_tension_distal") for name in ("fig11", "fig11-10kg")]
    return [line[-1] > 0.0 for line in least], *least


def _deviation_at_the_turn(paper: Paper) -> Evidence:
    run = paper["fig07"]
    flexor, extensor = (apart(run.curves(f"{side}_tension_distal")) for side in SIDES)
    at_flexor, at_extensor = (run.degrees[off.argmax(axis=1)] for off in (flexor, extensor))
    holds = [at == run.degrees[-1] for at in (*at_extensor, *at_flexor)]
    return holds, extensor.max(axis=1), at_extensor, flexor.max(axis=1), at_flexor, run.loads


def _universal(paper: Paper) -> Evidence:
    """Over loads, and over people with these loads."""
    run = paper["fig06-windows"]
    remedies = ((3e3, 1.0), (1e3, 1.0), (3e3, 0.7))
    windows = [run.windows(spring_stiffness=k, spool_ratio=eta) for k, eta in remedies]
    common = [(low.max(), high.min()) for low, high in windows]
    shares = [100.0 * served(_PEOPLE, k, eta, run.loads) for k, eta in (*remedies, (8e3, 0.5))]
    parts = [
        low <= high or share >= 95.0 for (low, high), share in zip(common, shares[:-1], strict=True)
    ]
    return parts, run.loads, *windows[0], *np.ravel(common), float(_PEOPLE), *shares


def _more_pretension(paper: Paper) -> Evidence:
    run = paper["fig09-10kg"]
    shares, required = 100.0 * run.design("slack_fraction"), run.design("required_pretension")[0]
    return [falls(shares), shares[-1] == 0.0], shares, run.values("pretension"), required


CLAIMS: dict[str, Check] = {
    "C1": _elongations,
    "C2": _friction_near_the_motor,
    "C3": _first_angles,
    "C4": _springs_solve,
    "C5": _ratio_solves,
    "C6": _deviation_at_the_turn,
    "C7": _universal,
    "C8": _more_pretension,
}
