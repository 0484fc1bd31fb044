"""The purpose of each part of the estimator: fits without it, of both rigs' logs.

Run `python -m verification.friction_rigs.ablation`.
"""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from typing import Any
from unittest.mock import patch

import pandas as pd

from tendon_cli.fits import log_rows as rows
from tendon_cli.fits.friction import (
    budget,
    directions,
    effects,
    estimate,
    models,
    prepare,
    usable_rows,
)

from .cases import CASES, Case
from .chain import KINDS, judged, logs, shares
from .torture import Count, covers, run

NEVER = 1e9
WIDE_PRIOR = {name: 10 * width for name, width in effects.PRIOR.items()}
WITHOUT: dict[str, tuple[tuple[Any, str, Any], ...]] = {
    "everything": (),
    "rows: the test for no load": ((usable_rows, "_UNLOADED", 0.0),),
    "rows: saturation": ((usable_rows, "_TOP_ROWS", NEVER),),
    "rows: those near the rail": ((usable_rows, "_NEAR_RAIL", 0.0),),
    "rows: spikes": ((rows, "_SPIKE_MEDIANS", NEVER),),
    "strokes: the trigger (turns at the middle)": ((directions, "_TRIGGER", 0.0),),
    "strokes: the two limits' test": ((prepare, "_TWO_LIMITS", 0.0),),
    "strokes: refusal of a load's cell that does not follow": ((prepare, "_FOLLOWS", 0.0),),
    "limit: blocks (each row by itself)": (
        (estimate, "_BLOCKS", NEVER),
        (estimate, "_COARSE", NEVER),
    ),
    "limit: start at the 85th percentile (at the median)": ((estimate, "_START", 0.5),),
    "limit: a width from what lies beyond (half as wide)": ((estimate, "_WIDE", 1.1),),
    "limit: the same (twice as wide)": ((estimate, "_WIDE", 4.4),),
    "limit: least width of 0.4 %": ((estimate, "_FLAT", 1e-6),),
    "limit: the test of density": ((estimate, "_DENSE", 0.0), (estimate, "_WIDEST", 9.0)),
    "limit: the test for limits inside the others'": (
        (estimate, "_INSIDE", 9.0),
        (estimate, "_FURTHEST", 9.0),
    ),
    "limit: the test for short strokes": ((estimate, "_SHORT", 0.0),),
    "limit: the ramp's count": ((estimate, "_TAIL", 9.0),),
    "line: offsets": ((effects, "_VARIES", 9.0),),
    "line: prior of effects (ten times as wide)": ((effects, "PRIOR", WIDE_PRIOR),),
    "line: strictness with delay, force and entry": ((models, "STRICT", {}),),
    "line: refusal of effects that need another gain": ((models, "_GAIN_MOVES", NEVER),),
    "line: refusal of effects that leave 20 % open": ((models, "_UNKNOWN", NEVER),),
    "line: no scatter below 0.1 %": ((models, "_EXACT", 1e-6),),
    "line: correlation of points": ((models, "_ALIKE", 0.0),),
    "loop: rounds (one)": ((estimate, "_ROUNDS", 1),),
    "loop: the shift of a late cell": ((estimate, "_LATE", 0.0),),
    "budget: 3 % for few strokes": ((budget, "FEW_SHARE", 0.0),),
    "budget: resolution": ((budget, "_resolution", lambda *_: 0.0),),
}
"""Changes of a module's constant or function, by the part that they take out."""

HEAD = (
    "without",
    "silent, %",
    "false alarms, %",
    "refused, %",
    "intervals that hold, %",
    "half-width, %",
)


def verdicts_of(case: Case, count: Count) -> Iterator[dict[str, object]]:
    """Judge the fits of a case as those of the other rig are judged."""
    refused = "rightly refused" if case.refused else "wrongly refused"
    for _ in count.refused:
        yield {"outcome": refused}
    for fit in count.fits:
        if count.is_silent(fit):
            outcome = "silent"
        elif case.clean and fit.warnings:
            outcome = "false alarm"
        else:
            outcome = "right"
        verdict = {"outcome": outcome}
        if not fit.warnings:
            low, high = fit.uncertainty.interval_95
            verdict["held"] = covers(fit)
            verdict["half"] = (high - low) / 2.0 / fit.friction
        yield verdict


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    logs_of_chain = []
    for kind in KINDS.values():
        if kind.tells:
            logs_of_chain += [(kind, *log) for log in logs(kind, options.seeds)]
    cases = {name: case for name, case in CASES.items() if not case.hides}
    print(f"| {' | '.join(HEAD)} |")
    print("|---" * len(HEAD) + "|")
    for part, changes in WITHOUT.items():
        if options.only not in part:
            continue
        with contextlib.ExitStack() as stack:
            for module, constant, value in changes:
                stack.enter_context(patch.object(module, constant, value))
            verdicts = [judged(*log) for log in logs_of_chain]
            for name, case in cases.items():
                verdicts += verdicts_of(case, run(name, options.seeds, first_seed=1))
        columns = " | ".join(f"{share:.2f}" for share in shares(pd.DataFrame(verdicts)))
        print(f"| {part} | {columns} |", flush=True)


if __name__ == "__main__":
    main()
