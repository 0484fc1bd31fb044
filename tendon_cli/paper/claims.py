"""What the paper claims beyond its figures: each with the verdict of the tables beside the one on record."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tendon_cli.paper.entry import FALSE, IN_PART, TRUE, Entry, Verdict, judge
from tendon_cli.paper.findings import Runs
from tendon_cli.paper.measures import (
    DIRECTIONS,
    SIDES,
    apart,
    crossing,
    depth,
    falls,
    gain,
    least,
    served,
    shared,
    window,
)
from tendon_cli.paper.runs import Array

_NONE = 1e-9  # %, what rounding leaves of a difference
_PEOPLE = 500
_SEEN, _HARDLY = 10.0, 1.0  # % of the peak: a deviation that shows in a figure, and one that does not


def claims(runs: Runs) -> list[Entry]:
    """All claims, in the order of the paper's conclusions and then of its abstract."""
    return [
        check(runs).entry(id_, text, f"{figure}.png" if figure else None, recorded)
        for id_, figure, recorded, text, check in _CHECKS
    ]


def _elongations(runs: Runs) -> Verdict:
    run, smooth = runs["fig07"], runs["fig07-smooth"]
    tendons, springs, without = (
        np.ravel([apart(of, quantity, load_mass=load) for load in of.values("load_mass")])
        for of, quantity in ((run, "tendon_stretch"), (run, "spring_stretch"), (smooth, "tendon_stretch"))
    )
    return judge(
        [tendons.min() > _SEEN, springs.max() < _HARDLY, without.max() < _NONE],
        "between the directions tendons differ by {:1} to {:1} % of their largest, springs by up to {:2} %; without "
        "friction by {:1} %",
        tendons.min(), tendons.max(), springs.max(), without.max(),
    )  # fmt: skip


def _friction_near_the_motor(runs: Runs) -> Verdict:
    with_, without = (
        [value for load in runs[name].values("load_mass") for value in apart(runs[name], "tension_proximal",
                                                                            load_mass=load)]
        for name in ("fig08", "fig07-smooth")
    )  # fmt: skip
    return judge(
        [min(with_) > _SEEN, max(without) < _NONE],
        "the directions differ by {:1} to {:1} % of the peak at μ = 0.07, by {:1} % at μ = 0",
        min(with_), max(with_), max(without),
    )  # fmt: skip


def _first_angles(runs: Runs) -> Verdict:
    run = runs["fig06-pretensions"]
    pretensions = run.values("pretension")
    ends = [crossing(run, pretension=value) for value in pretensions]
    starts = [float(gain(run, "flexion", pretension=value)[0]) for value in pretensions]
    return judge(
        [falls(ends[::-1]), falls(starts), abs(starts[0]) < 0.05 * abs(starts[2])],
        "they end at {:1}° and begin with τ_a − τ_m = {:2} N m at pretensions of {:0} N (0 kg)",
        ends, starts, pretensions,
    )  # fmt: skip


def _springs_solve(runs: Runs) -> Verdict:
    run = runs["fig10-springs"]
    springs = run.values("spring_stiffness")
    depths = {load: [depth(run, load_mass=load, spring_stiffness=value) for value in springs] for load in (5.0, 10.0)}
    return judge(
        [min(depths[load]) < 0.0 and falls(depths[load]) for load in depths],
        "at 5 kg gone at 0.9 kN/m, not at 1: {:1} mm deep; at 10 kg it deepens: {:1} mm (K = {:1} kN/m)",
        np.maximum(depths[5.0], 0.0), depths[10.0], np.divide(springs, 1e3),
    )  # fmt: skip


def _ratio_solves(runs: Runs) -> Verdict:
    least_tensions = [
        [least(runs[name], "extensor_tension_distal", spool_ratio=ratio) for ratio in (0.9, 0.8, 0.7)]
        for name in ("fig11", "fig11-10kg")
    ]
    return judge(
        [line[-1] > 0.0 for line in least_tensions],
        "least extensor tension at 5 kg {:1} N, at 10 kg {:1} N (η = 0.9, 0.8, 0.7)",
        *least_tensions,
    )


def _deviation_at_the_turn(runs: Runs) -> Verdict:
    run = runs["fig07"]
    loads = run.values("load_mass")
    off: dict[str, list[Array]] = {}
    for side in SIDES:
        both = [[run.line(f"{side}_tension_distal", way, load_mass=load) for way in DIRECTIONS] for load in loads]
        off[side] = [100.0 * np.abs(there - back) / np.abs([there, back]).max() for there, back in both]
    extensor, flexor = ([line.max() for line in off[side]] for side in ("extensor", "flexor"))
    at_extensor, at_flexor = ([run.degrees[line.argmax()] for line in off[side]] for side in ("extensor", "flexor"))
    return judge(
        [at == run.degrees[-1] for at in (*at_extensor, *at_flexor)],
        "largest deviation of the extensor {:2} % of its peak at {:0}°, of the flexor {:2} % at {:0}° ({:0} kg)",
        extensor, at_extensor, flexor, at_flexor, loads,
    )  # fmt: skip


def _universal(runs: Runs) -> Verdict:
    """Over loads, and over people with these loads."""
    run = runs["fig06-windows"]
    loads = run.values("load_mass")
    remedies = ((3e3, 1.0), (1e3, 1.0), (3e3, 0.7))
    windows = [[window(run, spring_stiffness=k, spool_ratio=eta, load_mass=load) for load in loads]
               for k, eta in remedies]  # fmt: skip
    common = [shared(each) for each in windows]
    text = (
        "{:0} kg are taut from {:1} N on and stable up to {:1} N: all at once need at least {:1} N and bear at most "
        "{:1} N. With springs of 1 kN/m they need {:1} N and bear {:1} N, with η = 0.7 {:1} and {:1} N. Of {:0} men "
        "and women drawn from ANSUR II one pretension serves {:1} % for all of these loads, with 1 kN/m {:1} %, with "
        "η = 0.7 {:1} %; with springs of 8 kN/m and η = 0.5, which the paper does not try, {:1} %"
    )
    ends = np.array(windows[0]).T
    shares = [100.0 * served(_PEOPLE, k, eta, loads) for k, eta in (*remedies, (8e3, 0.5))]
    parts = [low <= high or share >= 95.0 for (low, high), share in zip(common, shares[:-1], strict=True)]
    return judge(parts, text, loads, *ends, *np.ravel(common), float(_PEOPLE), *shares)


def _more_pretension(runs: Runs) -> Verdict:
    run = runs["fig09-10kg"]
    pretensions = run.values("pretension")
    shares = [100.0 * run.design("slack_fraction", pretension=value) for value in pretensions]
    required = run.design("required_pretension", pretension=pretensions[0])
    return judge(
        [falls(shares), shares[-1] == 0.0],
        "at 10 kg {:0} % of the states are slack at {:0} N; {:1} N is the least that leaves none",
        shares, pretensions, required,
    )  # fmt: skip


_CHECKS: tuple[tuple[str, str | None, str, str, Callable[[Runs], Verdict]], ...] = (
    ("C1", None, TRUE, "Conclusion 3: tendons and springs extend alike in both directions, but for friction",
     _elongations),
    ("C2", "fig08", TRUE, "Fig. 8: the asymmetry near the motor is friction changing its direction",
     _friction_near_the_motor),
    ("C3", "fig06", TRUE, "Fig. 6: the first angles, where the motor torque is the larger, come from the pretension",
     _first_angles),
    ("C4", "fig10", IN_PART, "Conclusion 5: the spring constant solves the slack", _springs_solve),
    ("C5", "fig11", IN_PART, "Fig. 11: two spools of different radii eliminate the slack", _ratio_solves),
    ("C6", "fig07", IN_PART, "Conclusion 2: the directions deviate at the turn from flexion to extension",
     _deviation_at_the_turn),
    ("C7", None, FALSE, "Abstract: a series spring makes the design universally applicable", _universal),
    ("C8", "fig09", TRUE, "Fig. 9: more pretension mitigates the slack at 10 kg", _more_pretension),
)  # fmt: skip
