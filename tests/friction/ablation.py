"""What each part of the estimator is for: fits without it, of both rigs' logs, `python -m tests.friction.ablation`."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from typing import Any
from unittest.mock import patch

import pandas as pd

from tendon_cli.friction import budget, directions, effects, estimate, models, prepare, usable_rows

from .cases import CASES, Case
from .chain import KINDS, judged, logs, shares
from .torture import Count, covers, run

NEVER = 1e9
WITHOUT: dict[str, tuple[tuple[Any, str, Any], ...]] = {
    "everything": (),
    "rows: the test for no load": ((usable_rows, "_UNLOADED", 0.0),),
    "rows: saturation": ((usable_rows, "_TOP_ROWS", NEVER),),
    "rows: those near the rail": ((usable_rows, "_NEAR_RAIL", 0.0),),
    "rows: spikes": ((usable_rows, "_SPIKE_MEDIANS", NEVER),),
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
    "line: prior of effects (ten times as wide)": (
        (effects, "PRIOR", {n: 10 * t for n, t in effects.PRIOR.items()}),
    ),
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


def verdicts_of(case: Case, count: Count) -> Iterator[dict[str, object]]:
    """The fits of a case as those of the other rig are judged."""
    refused = "rightly refused" if case.refused else "wrongly refused"
    yield from ({"outcome": refused} for _ in count.refused)
    for fit in count.fits:
        low, high = fit.uncertainty.interval_95
        alarm = "false alarm" if case.clean and fit.warnings else "right"
        quiet = (
            {} if fit.warnings else {"held": covers(fit), "half": (high - low) / 2.0 / fit.friction}
        )
        yield {"outcome": "silent" if count.is_silent(fit) else alarm, **quiet}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    of_chain = [
        (kind, *log) for kind in KINDS.values() if kind.tells for log in logs(kind, options.seeds)
    ]
    of_cases = {name: case for name, case in CASES.items() if not case.hides}
    print(
        "| without | silent, % | false alarms, % | refused, % | intervals that hold, % | half-width, % |"
    )
    print("|---" * 6 + "|")
    for name in (name for name in WITHOUT if options.only in name):
        with contextlib.ExitStack() as stack:
            for module, constant, value in WITHOUT[name]:
                stack.enter_context(patch.object(module, constant, value))
            verdicts = [judged(*log) for log in of_chain]
            for each, case in of_cases.items():
                verdicts += verdicts_of(case, run(each, options.seeds, first_seed=1))
        columns = " | ".join(f"{share:.2f}" for share in shares(pd.DataFrame(verdicts)))
        print(f"| {name} | {columns} |", flush=True)


if __name__ == "__main__":
    main()
