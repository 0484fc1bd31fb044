"""Compare tendon with MuJoCo: `python -m verification.against_mujoco [--write docs/verification.md]`.

Prints a table of differences and ends with 1 where a tolerance is missed. Where MuJoCo is not installed, one line says
why nothing was compared, and it ends with 0.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tendon_cli import __version__
from verification.cases import SEED, draw_cases

CASES = 100
COMMAND = "python -m verification.against_mujoco --write docs/verification.md"
BEGIN, END = f"<!-- written by `{COMMAND}` -->", "<!-- end of what is written -->"


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, print, write; the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m verification.against_mujoco", description="tendon against MuJoCo"
    )
    parser.add_argument(
        "--write", type=Path, metavar="PAGE", help="also put the table into this page"
    )
    options = parser.parse_args(arguments)
    try:
        import mujoco
    except (ImportError, OSError) as reason:
        sys.stdout.write(
            f"skipped, nothing was compared: MuJoCo cannot be loaded here ({reason})\n"
        )
        return 0
    report, holds = _compare(mujoco.__version__)
    sys.stdout.write(f"{report}\n")
    if options.write is not None:
        _put(options.write, report)
    return 0 if holds else 1


def _compare(engine_version: str) -> tuple[str, bool]:
    """The report in Markdown, and whether all of it holds."""
    from verification import compare, friction, tool
    from verification.rig import Rig

    cases = draw_cases(CASES)
    engine, ours = [Rig(case).answer() for case in cases], tool.answers(cases)
    rows, differing = compare.differences(engine, ours), compare.disagreements(engine, ours)
    missed = sum(not row.holds for row in rows)
    fitted = friction.fits()
    off = sum(not row.holds for row in fitted)
    verdict = (
        "All hold."
        if not missed and not differing
        else f"MISSED: {missed} quantities, {differing} states of slack."
    )
    report = (
        f"tendon {__version__} against MuJoCo {engine_version}, {CASES} random arms and designs (seed {SEED}):"
        f"\n{compare.counts(ours)}.\n"
        f"States in which the two differ on which side is slack: {differing}.\n\n{compare.table(rows)}\n\n{verdict}\n\n"
        f"Friction coefficients fitted to a rope dragged over a drum (tolerance {friction.TOLERANCE:.0%}):\n\n"
        f"{friction.table(fitted)}\n\n{f'MISSED: {off} coefficients.' if off else 'All hold.'}"
    )
    return report, not missed and not differing and not off


def _put(page: Path, report: str) -> None:
    """Replace what stands between the marks of the page."""
    before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise SystemExit(
            f"{page}: expected the lines {BEGIN} and {END}, and the table goes between them"
        )
    page.write_text(f"{before}{begin}\n\n{report}\n\n{end}{after}", encoding="utf-8")


if __name__ == "__main__":
    raise SystemExit(main())
