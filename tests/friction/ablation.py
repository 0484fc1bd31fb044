"""What each part of the estimator is for: fits of some cases without it, `python -m tests.friction.ablation`."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator
from typing import Any
from unittest.mock import patch

import numpy as np

from tendon_cli.friction import effects, estimate, limits, models, prepare, rows

from .torture import covers, run

CASES = (
    "clean", "clean, force varying", "clean, crank", "noise 2.0%", "noise 5.0%", "noise 1 N, varying",
    "noise 0.5 N, correlated", "offset motor +3 N, varying", "offset load -3 N, varying", "delay 100 ms, crank",
    "delay 20 ms, varying", "steps of 1 N", "saturated", "dwell, varying", "dwell while sticking", "10 rows a stroke",
    "never slipping", "never slipping, crank", "friction drifts 10 %",
)  # fmt: skip

WITHOUT: dict[str, tuple[tuple[Any, str, Any], ...]] = {
    "everything": (),
    "blocks (each row by itself)": ((limits, "_BLOCKS", 1e9), (limits, "_COARSE", 1e9)),
    "start at the 85th percentile (at the median)": ((limits, "_STARTS", (0.5,)),),
    "the outermost of the width (4 deviations in place of 2.2)": ((limits, "_WIDE", 4.0),),
    "the test of density": ((limits, "_DENSE", 0.0), (limits, "_WIDEST", 9.0)),
    "the test for partial strokes": ((limits, "_INSIDE", 9.0),),
    "the ramp's count": ((limits, "_TAIL", 9.0),),
    "the common width": ((limits, "_usual_width", lambda width, *_: np.zeros(len(width))),),
    "saturation": ((rows, "_TOP_ROWS", 10**9),),
    "offsets": ((effects, "_VARIES", 9.0),),
    "delay's own strictness": ((models, "_STRICT", dict.fromkeys(("offsets", "delay", "force", "entry"), 0.0)),),
    "rounds (one)": ((estimate, "_ROUNDS", 1),),
    "the shift of a late cell": ((estimate, "_LATE", 0.0),),
    "correlation of points": ((models, "_ALIKE", 0.0),),
    "the two limits' test": ((prepare, "_TWO_LIMITS", 0.0),),
}


@contextlib.contextmanager
def without(changes: tuple[tuple[Any, str, Any], ...]) -> Iterator[None]:
    """The estimator with some of its constants changed."""
    with contextlib.ExitStack() as stack:
        for module, name, value in changes:
            stack.enter_context(patch.object(module, name, value))
        yield


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    options = parser.parse_args()
    sys.stdout.write("| without | silently wrong, % | intervals that hold, % | median half-width, % | refused, % |\n")
    sys.stdout.write("|---|---|---|---|---|\n")
    for name, changes in WITHOUT.items():
        with without(changes):
            counts = [run(case, options.seeds, first_seed=1) for case in CASES]
        seeds = sum(count.seeds for count in counts)
        fits = [fit for count in counts for fit in count.fits]
        quiet = [covers(fit) for fit in fits if not fit.warnings]
        width = float(np.median([np.ptp(fit.uncertainty.interval_95) / 2.0 / fit.friction for fit in fits]))
        sys.stdout.write(
            f"| {name} | {100.0 * sum(count.silent() for count in counts) / seeds:.1f} | {100.0 * np.mean(quiet):.0f}"
            f" | {100.0 * width:.2f} | {100.0 * sum(len(count.refused) for count in counts) / seeds:.1f} |\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main()
