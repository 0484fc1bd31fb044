"""Fits of every case, counted: `python -m tests.friction.torture [--seeds 200] [--write docs/friction.md]`."""

from __future__ import annotations

import argparse
import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.friction import fit_friction
from tendon_cli.friction.fit_result import Fit

from .cases import CASES, FRICTION, Case, log_of
from .rig import simulate

BEGIN, END = "<!-- written by `make friction` -->", "<!-- end of what is written -->"


@dataclass
class Count:
    """What the fits of one case say together; shares of all its seeds."""

    fits: list[Fit]
    refused: list[str]
    case: Case

    @property
    def seeds(self) -> int:
        return len(self.fits) + len(self.refused)

    @property
    def quiet(self) -> list[Fit]:
        """Fits without a warning."""
        return [fit for fit in self.fits if not fit.warnings]

    def bias(self) -> float:
        return _mean([fit.friction / FRICTION - 1.0 for fit in self.fits])

    def half_width(self) -> float:
        return _mean([np.ptp(fit.uncertainty.interval_95) / 2.0 / FRICTION for fit in self.fits])

    def is_silent(self, fit: Fit) -> bool:
        """More than 1.5 % off, outside its interval, without a warning that names the cause."""
        cause, wrong = (
            self.case.names,
            not covers(fit) and abs(fit.friction / FRICTION - 1.0) > 0.015,
        )
        return self.case.refused or (
            wrong and not (cause and any(cause in text for text in fit.warnings))
        )

    def silent(self) -> int:
        return sum(map(self.is_silent, self.fits))


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else np.nan


def covers(fit: Fit) -> bool:
    low, high = fit.uncertainty.interval_95
    # The chain of the simulated sheath is itself good to 1e-4.
    return low * 0.9999 <= FRICTION <= high * 1.0001


_logs = functools.lru_cache(maxsize=None)(simulate)


def run(name: str, seeds: int, first_seed: int = 0) -> Count:
    case = CASES[name]
    logs = _logs(case.rig, seeds, first_seed)
    fits, refused = [], []
    for seed in range(seeds):
        try:
            fits.append(
                fit_friction((case.make or log_of)(case.rig, logs, seed), case.rig.bend_angle)
            )
        except InputError as error:
            refused.append(error.message)
    return Count(fits, refused, case)


def silent_share(counts: list[Count], *, hidden: bool) -> float:
    """Silently wrong fits over all seeds of all cases; with or without those that nothing in the readings can tell."""
    chosen = [count for count in counts if hidden or not count.case.hides]
    return sum(count.silent() for count in chosen) / sum(count.seeds for count in chosen)


def row_of(name: str, count: Count) -> str:
    """A row of the table in Markdown."""
    coverage, warned = (
        _mean([covers(fit) for fit in count.quiet]),
        _mean([bool(fit.warnings) for fit in count.fits]),
    )
    shares = ((count.bias(), 2), (count.half_width(), 1), (coverage, 0), (warned, 0))
    numbers = ["" if np.isnan(share) else f"{100.0 * share:.{digits}f}" for share, digits in shares]
    silent = f"{100.0 * count.silent() / count.seeds:.1f}" + (
        " (noted)" if count.case.hides and count.silent() else ""
    )
    return f"| {name} | {' | '.join(numbers)} | {silent} | {100.0 * len(count.refused) / count.seeds:.0f} |"


def table(counts: dict[str, Count]) -> str:
    """The table, and what it comes to."""
    seeds = max(count.seeds for count in counts.values())
    head = "| case | bias | half-width | truth in interval (fits without warning) | warned | silently wrong | refused |"
    alarms = [
        bool(fit.warnings) for count in counts.values() if count.case.clean for fit in count.fits
    ]
    told, every = (
        100.0 * silent_share(list(counts.values()), hidden=hidden) for hidden in (False, True)
    )
    words = (
        f"In %, {seeds} seeds a case. Silently wrong of all: {told:.2f} %, and {every:.1f} % with those of a constant"
        " force and an offset, which nothing in the readings can tell and a note puts a number to."
        f" Warnings on clean logs: {100.0 * np.mean(alarms or [False]):.1f} %."
    )
    return "\n".join(
        [
            head,
            "|---" * 7 + "|",
            *(row_of(name, count) for name, count in counts.items()),
            "",
            words,
        ]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="fit every case of simulated rigs and count")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--case", default="", help="only cases whose name has this in it")
    parser.add_argument(
        "--write", type=Path, metavar="PAGE", help="put the table between the marks of this page"
    )
    options = parser.parse_args()
    counts = {}
    for name in (name for name in CASES if options.case in name):
        counts[name] = run(name, options.seeds)
        print(row_of(name, counts[name]), flush=True)
    text = table(counts)
    print(text.rpartition("\n")[2])
    if options.write:
        before, begin, rest = options.write.read_text(encoding="utf-8").partition(BEGIN)
        _, end, after = rest.partition(END)
        if not begin or not end:
            raise SystemExit(f"{options.write}: expected the lines {BEGIN} and {END}")
        options.write.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
