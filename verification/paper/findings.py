"""Findings and claims of the paper, judged from the tables of its studies. Fig. n is the paper's.

Each check returns its evidence: the truth of each part of the statement, then its numbers in the
order of the text in statements.toml.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tendon_cli.quantities import SIDES
from verification.paper.runs import (
    PLACES,
    Paper,
    is_falling,
    relative_difference,
    shares_of_people,
)
from verification.paper.statements import Check, Evidence, content

_FIRST_ANGLES = 30.0
"""Elbow angle below which the "few initial values" of Fig. 6 lie, deg."""
_COINCIDING = 1.0
"""Difference below which two curves of Fig. 7 coincide, % of the peak tension."""
_DIFFERING = 30.0
"""Difference above which two curves of Fig. 8 differ, % of the peak tension."""
_VISIBLE = 10.0
"""Deviation that shows in a figure, % of the peak."""
_HARDLY_VISIBLE = 1.0
"""Deviation that does not show in a figure, % of the peak."""
_ROUNDING = 1e-9
"""Difference that rounding leaves, % of the peak."""
_SMALL_SHARE = 0.05
"""Share below which a difference of torques is small beside another."""
_PRINTED_FRICTION = np.array([0.073, 0.075])
"""Friction coefficients that Table A.1 prints, toward the motor and toward the load."""
_PRINTED_DIGITS = 5e-4
"""Half a unit of their last digit."""
_PEOPLE = 500
"""Number of people drawn."""
_MOST_PEOPLE = 95.0
"""Share of people that counts as all of them, %."""


def failing_by_place(paper: Paper) -> dict[float, list[str]]:
    """Return the findings that fail, by the distance from the elbow to the load, m."""
    failing = {}
    for place in paper["fig06-places"].values("arm_load_distance").tolist():
        moved = {
            study: paper[name].select(arm_load_distance=place)
            for name, (study, _) in PLACES.items()
        }
        paper_of_place = replace(paper, runs={**paper.runs, **moved})
        judged = [
            finding["id"]
            for finding in content()["finding"]
            if finding["figure"].removesuffix(".png") in moved
        ]
        failing[place] = [id_ for id_ in judged if not all(FINDINGS[id_](paper_of_place)[0])]
    return failing


# --- Findings ------------------------------------------------------------------------------------


def _ratio(paper: Paper) -> Evidence:
    """Judge F4: the ratio for no slack, H_f / H_e, exceeds 1 at 90° and falls with the angle."""
    run = paper["fig04"]
    ratio = run.travel_ratio()
    holds = [ratio[-1] > 1.0, is_falling(ratio[::-1])]
    angle_of_one = np.interp(1.0, ratio, run.degrees)
    return holds, ratio[-1], angle_of_one, ratio[0]


def _elbow_over_motor(paper: Paper) -> Evidence:
    """Judge F6a: the elbow torque exceeds the motor torque, but for the first angles of flexion."""
    run = paper["fig06"]
    angles = run.crossings()
    gain = run.gain()
    is_first = all(0.0 < angle < _FIRST_ANGLES for angle in angles)
    stays_positive = (np.diff(np.sign(gain[:, 0])) >= 0.0).all()
    is_positive_in_extension = (gain[:, 1] > 0.0).all()
    return [is_first, stays_positive, is_positive_in_extension], angles, run.loads


def _gain_grows(paper: Paper) -> Evidence:
    """Judge F6b: the difference of the torques grows with the load, at every angle above 0°."""
    run = paper["fig06"]
    gain = run.gain()
    grows = np.diff(gain, axis=0) > 0.0  # (steps of the load, directions, angles)
    holds = grows[..., run.degrees > 0.0].all(axis=(1, 2))
    return holds.tolist(), gain[:, 0, -1], run.loads


def _unloaded_flexor(paper: Paper) -> Evidence:
    """Judge F7a: without load the flexor tension at the elbow falls throughout flexion."""
    tension = paper["fig07"].line("flexor_tension_distal", load_mass=0.0)
    return [is_falling(tension)], tension[0], tension[-1]


def _loaded_flexor(paper: Paper) -> Evidence:
    """Judge F7b: with load the flexor tension at the elbow first rises."""
    run = paper["fig07"]
    tensions = run.curves("flexor_tension_distal")[1:, 0]  # (loads, angles), N
    holds = list(tensions[:, 1] > tensions[:, 0])
    at_peak = run.degrees[tensions.argmax(axis=1)]
    return holds, tensions[0, 0], tensions.max(axis=1), at_peak, run.loads[1:]


def _extensor(paper: Paper) -> Evidence:
    """Judge F7c: with load the extensor tension at the elbow falls; without it first rises."""
    run = paper["fig07"]
    unloaded, *loaded = run.curves("extensor_tension_distal")[:, 0]
    holds = [unloaded[1] > unloaded[0], *map(is_falling, loaded)]
    at_peak = run.degrees[unloaded.argmax()]
    ends = [tension[-1] for tension in loaded]
    return holds, unloaded[0], unloaded.max(), at_peak, ends, run.loads[1:]


def _near_elbow(paper: Paper) -> Evidence:
    """Judge F7d: at the elbow the tensions of flexion and extension nearly coincide."""
    largest = paper["fig07"].difference("tension_distal").max()
    return [largest < _COINCIDING], largest


def _near_motor(paper: Paper) -> Evidence:
    """Judge F8a: at the motor the tensions of flexion and extension differ."""
    smallest = paper["fig08"].difference("tension_proximal").min()
    return [smallest > _DIFFERING], smallest


def _slack_at_the_motor(paper: Paper) -> Evidence:
    """Judge F8b: the flexor stays in tension at every load; the extensor goes slack with load."""
    run = paper["fig08"]
    flexor = run.smallest("flexor_tension_proximal")
    extensor = run.smallest("extensor_tension_proximal")
    is_as_found = ((extensor < 0.0) == (run.loads > 0.0)).all()
    return [flexor.min() > 0.0, is_as_found], flexor, extensor, run.loads


def _at_200_newtons(paper: Paper) -> Evidence:
    """Judge F9: at 200 N of pretension there is slack at 10 kg only."""
    run = paper["fig09"]
    slack = run.design("slack_fraction")
    required = run.design("required_pretension")
    is_as_found = ((slack > 0.0) == (run.loads == 10.0)).all()
    return [is_as_found], 100.0 * slack, required, run.loads


def _softer_springs(paper: Paper) -> Evidence:
    """Judge F10: at 5 kg the slack shrinks as the springs soften, and they extend further."""
    run = paper["fig10"]
    depths = run.slack_depth()
    longest = 1e3 * run.design("max_spring_extension")
    stiffness = run.values("spring_stiffness") / 1e3
    holds = [is_falling(depths), is_falling(run.design("slack_fraction")), is_falling(-longest)]
    heavy = paper["fig10-springs"]
    heavy_depths = [
        heavy.slack_depth(spring_stiffness=spring, load_mass=10.0) for spring in (3e3, 1e3)
    ]
    soft = {"spring_stiffness": 1e3, "spool_ratio": 1.0}
    windows = [paper["fig06-windows"].windows(load_mass=load, **soft) for load in (0.0, 5.0)]
    return holds, depths, longest, stiffness, *heavy_depths, *np.ravel(windows)


def _smaller_ratio(paper: Paper) -> Evidence:
    """Judge F11: at 5 kg the slack shrinks with the ratio of the spools, and is gone at 0.7."""
    run = paper["fig11"]
    depths = np.maximum(0.0, run.slack_depth())
    shares = 100.0 * run.design("slack_fraction")
    is_gone = shares[-1] == 0.0 and run.design("min_extensor_tension")[-1] > 0.0
    holds = [is_falling(depths), is_falling(shares), is_gone]
    with_10_kg = paper["fig11-10kg"].smallest("extensor_tension_distal", spool_ratio=0.7)
    choice = {"spring_stiffness": 3e3, "spool_ratio": 0.7}
    unloaded, loaded, heavy = (
        paper["fig06-windows"].windows(load_mass=load, **choice) for load in (0.0, 5.0, 10.0)
    )
    shared_low = max(unloaded[0], loaded[0])
    shared_high = min(unloaded[1], loaded[1])
    ratios = run.values("spool_ratio")
    return holds, depths, shares, ratios, with_10_kg, shared_low, shared_high, heavy[0]


def _table_a1(paper: Paper) -> Evidence:
    """Judge TA1: the friction coefficients of Table A.1 follow from its readings."""
    directions = paper.fit.by_direction
    friction = np.array([directions[name].friction for name in ("toward_motor", "toward_load")])
    return list(np.abs(friction - _PRINTED_FRICTION) < _PRINTED_DIGITS), *friction


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
"""Checks of the findings, which the paper's figures show."""


# --- Claims --------------------------------------------------------------------------------------


def _elongations(paper: Paper) -> Evidence:
    """Judge C1: tendons and springs extend alike in both directions, but for friction."""
    run = paper["fig07"]
    tendons = run.difference("tendon_stretch")
    springs = run.difference("spring_stretch")
    without = paper["fig07-smooth"].difference("tendon_stretch").max()
    holds = [tendons.min() > _VISIBLE, springs.max() < _HARDLY_VISIBLE, without < _ROUNDING]
    return holds, tendons.min(), tendons.max(), springs.max(), without


def _friction_near_the_motor(paper: Paper) -> Evidence:
    """Judge C2: the asymmetry near the motor is friction that changes its direction."""
    rough = paper["fig08"].difference("tension_proximal")
    smooth = paper["fig07-smooth"].difference("tension_proximal")
    holds = [rough.min() > _VISIBLE, smooth.max() < _ROUNDING]
    return holds, rough.min(), rough.max(), smooth.max()


def _first_angles(paper: Paper) -> Evidence:
    """Judge C3: the first angles, with the larger motor torque, come from the pretension."""
    run = paper["fig06-pretensions"]
    ends = run.crossings()
    starts = run.gain()[:, 0, 0]
    is_small_without = abs(starts[0]) < _SMALL_SHARE * abs(starts[2])
    holds = [is_falling(ends[::-1]), is_falling(starts), is_small_without]
    return holds, ends, starts, run.values("pretension")


def _springs_solve(paper: Paper) -> Evidence:
    """Judge C4: the spring constant solves the slack."""
    run = paper["fig10-springs"]
    light = run.slack_depth(load_mass=5.0)
    heavy = run.slack_depth(load_mass=10.0)
    holds = [depths.min() < 0.0 and is_falling(depths) for depths in (light, heavy)]
    return holds, np.maximum(light, 0.0), heavy, run.values("spring_stiffness") / 1e3


def _ratio_solves(paper: Paper) -> Evidence:
    """Judge C5: two spools of different radii eliminate the slack."""
    tensions = [paper[name].smallest("extensor_tension_distal") for name in ("fig11", "fig11-10kg")]
    return [tension[-1] > 0.0 for tension in tensions], *tensions


def _deviation_at_the_turn(paper: Paper) -> Evidence:
    """Judge C6: the directions deviate at the turn from flexion to extension."""
    run = paper["fig07"]
    flexor, extensor = (relative_difference(run.curves(f"{side}_tension_distal")) for side in SIDES)
    at_flexor = run.degrees[flexor.argmax(axis=1)]
    at_extensor = run.degrees[extensor.argmax(axis=1)]
    holds = [angle == run.degrees[-1] for angle in (*at_extensor, *at_flexor)]
    return holds, extensor.max(axis=1), at_extensor, flexor.max(axis=1), at_flexor, run.loads


def _universal(paper: Paper) -> Evidence:
    """Judge C7: a series spring suits all loads, with a pretension for each or one for all."""
    run = paper["fig06-windows"]
    remedies = ((3e3, 1.0), (1e3, 1.0), (3e3, 0.7))  # stiffness of the springs, N/m, and ratio
    windows = [run.windows(spring_stiffness=k, spool_ratio=eta) for k, eta in remedies]
    common = [(low.max(), high.min()) for low, high in windows]
    shares = [
        100.0 * shares_of_people(_PEOPLE, k, eta, run.loads)[0]
        for k, eta in (*remedies, (8e3, 0.5))
    ]
    shares_by_load = [
        100.0 * shares_of_people(_PEOPLE, *remedies[0], load)[1] for load in run.loads
    ]
    low, high = windows[0]
    set_for_each = (low <= high).tolist()
    one_for_all = [
        low <= high or share >= _MOST_PEOPLE
        for (low, high), share in zip(common, shares[:-1], strict=True)
    ]
    holds = [*set_for_each, *one_for_all]
    people = float(_PEOPLE)
    return holds, run.loads, low, high, people, shares_by_load, *np.ravel(common), *shares


def _more_pretension(paper: Paper) -> Evidence:
    """Judge C8: more pretension mitigates the slack at 10 kg."""
    run = paper["fig09-10kg"]
    shares = 100.0 * run.design("slack_fraction")
    required = run.design("required_pretension")[0]
    holds = [is_falling(shares), shares[-1] == 0.0]
    return holds, shares, run.values("pretension"), required


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
"""Checks of the claims, which go beyond the paper's figures."""
