"""What the paper claims beyond its figures: each with the verdict of the tables next to the one on record."""

from __future__ import annotations

import numpy as np

from tendon_cli.paper.runs import DIRECTIONS, SIDES, Array, Paper, apart, falls, served, shared
from tendon_cli.paper.statements import Check, Evidence

_NONE = 1e-9  # %, what rounding leaves of a difference
_PEOPLE = 500
_SEEN, _HARDLY = 10.0, 1.0  # % of the peak: a deviation that shows in a figure, and one that does not


def _elongations(paper: Paper) -> Evidence:
    tendons, springs, without = (
        np.ravel([paper[name].apart(quantity, load_mass=load) for load in paper[name].loads])
        for name, quantity in (
            ("fig07", "tendon_stretch"), ("fig07", "spring_stretch"), ("fig07-smooth", "tendon_stretch"),
        )
    )  # fmt: skip
    return (
        [tendons.min() > _SEEN, springs.max() < _HARDLY, without.max() < _NONE],
        tendons.min(),
        tendons.max(),
        springs.max(),
        without.max(),
    )


def _friction_near_the_motor(paper: Paper) -> Evidence:
    with_, without = (
        np.ravel([paper[name].apart("tension_proximal", load_mass=load) for load in paper[name].loads])
        for name in ("fig08", "fig07-smooth")
    )
    return [with_.min() > _SEEN, without.max() < _NONE], with_.min(), with_.max(), without.max()


def _first_angles(paper: Paper) -> Evidence:
    run = paper["fig06-pretensions"]
    pretensions = run.values("pretension")
    ends = [run.crossing(pretension=value) for value in pretensions]
    starts = [float(run.gain("flexion", pretension=value)[0]) for value in pretensions]
    return [falls(ends[::-1]), falls(starts), abs(starts[0]) < 0.05 * abs(starts[2])], ends, starts, pretensions


def _springs_solve(paper: Paper) -> Evidence:
    run = paper["fig10-springs"]
    springs = run.values("spring_stiffness")
    depths = {load: [run.depth(load_mass=load, spring_stiffness=value) for value in springs] for load in (5.0, 10.0)}
    return (
        [min(depths[load]) < 0.0 and falls(depths[load]) for load in depths],
        np.maximum(depths[5.0], 0.0),
        depths[10.0],
        np.divide(springs, 1e3),
    )


def _ratio_solves(paper: Paper) -> Evidence:
    least = [
        [paper[name].least("extensor_tension_distal", spool_ratio=ratio) for ratio in (0.9, 0.8, 0.7)]
        for name in ("fig11", "fig11-10kg")
    ]
    return [line[-1] > 0.0 for line in least], *least


def _deviation_at_the_turn(paper: Paper) -> Evidence:
    run = paper["fig07"]
    of_side: dict[str, tuple[list[float], Array]] = {}
    for side in SIDES:
        off = [
            apart(np.array([run.line(f"{side}_tension_distal", way, load_mass=load) for way in DIRECTIONS]))
            for load in run.loads
        ]
        of_side[side] = [line.max() for line in off], run.degrees[[line.argmax() for line in off]]
    (flexor, at_flexor), (extensor, at_extensor) = of_side["flexor"], of_side["extensor"]
    return (
        [at == run.degrees[-1] for at in (*at_extensor, *at_flexor)],
        extensor,
        at_extensor,
        flexor,
        at_flexor,
        run.loads,
    )


def _universal(paper: Paper) -> Evidence:
    """Over loads, and over people with these loads."""
    run = paper["fig06-windows"]
    remedies = ((3e3, 1.0), (1e3, 1.0), (3e3, 0.7))
    windows = [[run.window(spring_stiffness=k, spool_ratio=eta, load_mass=load) for load in run.loads]
               for k, eta in remedies]  # fmt: skip
    common = [shared(each) for each in windows]
    shares = [100.0 * served(_PEOPLE, k, eta, run.loads) for k, eta in (*remedies, (8e3, 0.5))]
    parts = [low <= high or share >= 95.0 for (low, high), share in zip(common, shares[:-1], strict=True)]
    ends = np.array(windows[0]).T
    return parts, run.loads, *ends, *np.ravel(common), float(_PEOPLE), *shares


def _more_pretension(paper: Paper) -> Evidence:
    run = paper["fig09-10kg"]
    pretensions = run.values("pretension")
    shares = [100.0 * run.design("slack_fraction", pretension=value) for value in pretensions]
    required = run.design("required_pretension", pretension=pretensions[0])
    return [falls(shares), shares[-1] == 0.0], shares, pretensions, required


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
