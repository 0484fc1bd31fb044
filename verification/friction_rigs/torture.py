"""Fits of every case, counted.

Run `python -m verification.friction_rigs.torture [--seeds 200] [--write FILE]`.
"""

from __future__ import annotations

import argparse
import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.fits.friction import fit_friction
from tendon_cli.fits.friction.fit_result import Fit

from .cases import CASES, FRICTION, Case, log_of, mentions
from .rig import simulate

BEGIN = "<!-- written by `make friction` -->"
END = "<!-- end of what is written -->"
HEAD = (
    "| case | bias | half-width | truth in interval (fits without warning) | warned "
    "| silently wrong | refused |"
)


@dataclass
class Count:
    """The fits of one case; shares are of all its seeds."""

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
        """Return True for a wrong fit without a warning that names the cause.

        A fit is wrong if it is more than 1.5 % off and outside its interval, or if it should have
        been refused.
        """
        if self.case.refused:
            return True
        is_off = abs(fit.friction / FRICTION - 1.0) > 0.015
        if covers(fit) or not is_off:
            return False
        cause = self.case.names
        return not cause or not mentions(fit.warnings, cause)

    def silent(self) -> int:
        return sum(map(self.is_silent, self.fits))


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else np.nan


def covers(fit: Fit) -> bool:
    """Return True if the interval of a fit holds the truth."""
    low, high = fit.uncertainty.interval_95
    # The chain of the simulated sheath is itself good to 1e-4.
    return low * 0.9999 <= FRICTION <= high * 1.0001


_logs = functools.lru_cache(maxsize=None)(simulate)


def run(name: str, seeds: int, first_seed: int = 0) -> Count:
    """Fit all seeds of a case."""
    case = CASES[name]
    make = case.make or log_of
    # A cell without a zero error was tared, and says so.
    stated = None if any(case.rig.offsets) else "0 N"
    logs = _logs(case.rig, seeds, first_seed)
    fits = []
    refused = []
    for seed in range(seeds):
        log = make(case.rig, logs, seed)
        try:
            fits.append(fit_friction(log, case.rig.bend_angle, cell_uncertainty=stated))
        except InputError as error:
            refused.append(error.message)
    return Count(fits, refused, case)


def silent_share(counts: list[Count], *, hidden: bool) -> float:
    """Return silently wrong fits over all seeds of all cases.

    Cases in which nothing in the readings can tell what is wrong count only if `hidden`.
    """
    chosen = [count for count in counts if hidden or not count.case.hides]
    return sum(count.silent() for count in chosen) / sum(count.seeds for count in chosen)


def row_of(name: str, count: Count) -> str:
    """Return a row of the table in Markdown."""
    coverage = _mean([covers(fit) for fit in count.quiet])
    warned = _mean([bool(fit.warnings) for fit in count.fits])
    shares = ((count.bias(), 2), (count.half_width(), 1), (coverage, 0), (warned, 0))
    cells = ["" if np.isnan(share) else f"{100.0 * share:.{digits}f}" for share, digits in shares]
    silent = f"{100.0 * count.silent() / count.seeds:.1f}"
    if count.case.hides and count.silent():
        silent += " (noted)"
    refused = f"{100.0 * len(count.refused) / count.seeds:.0f}"
    return f"| {' | '.join([name, *cells, silent, refused])} |"


def table(counts: dict[str, Count]) -> str:
    """Return the table of all cases, and a sentence that sums it up."""
    seeds = max(count.seeds for count in counts.values())
    alarms = []
    for count in counts.values():
        if count.case.clean:
            alarms += [bool(fit.warnings) for fit in count.fits]
    detectable = 100.0 * silent_share(list(counts.values()), hidden=False)
    overall = 100.0 * silent_share(list(counts.values()), hidden=True)
    summary = (
        f"In %, {seeds} seeds a case. Silently wrong of all: {detectable:.2f} %, and"
        f" {overall:.1f} % with those of a constant force and an offset, which no"
        " reading can show and a note quantifies."
        f" Warnings on clean logs: {100.0 * np.mean(alarms or [False]):.1f} %."
    )
    rows = [row_of(name, count) for name, count in counts.items()]
    return "\n".join([HEAD, "|---" * 7 + "|", *rows, "", summary])


def main() -> None:
    parser = argparse.ArgumentParser(description="fit every case of simulated rigs and count")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--case", default="", help="only cases whose name has this in it")
    parser.add_argument(
        "--write", type=Path, metavar="PAGE", help="put the table between the marks of this page"
    )
    options = parser.parse_args()
    counts = {}
    for name in CASES:
        if options.case in name:
            counts[name] = run(name, options.seeds)
            print(row_of(name, counts[name]), flush=True)
    text = table(counts)
    print(text.rpartition("\n")[2])
    if options.write:
        write_between_marks(options.write, text)


def write_between_marks(page: Path, text: str) -> None:
    """Put the text between the marks of a page."""
    before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise SystemExit(f"{page}: expected the lines {BEGIN} and {END}")
    page.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
