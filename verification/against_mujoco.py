"""Compare tendon with MuJoCo: `python -m verification.against_mujoco [--write PAGE]`.

Prints a table of differences and ends with 1 if a tolerance is missed. If MuJoCo is not installed,
one line says why nothing was compared, and it ends with 0.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tendon_cli import __version__
from verification.cases import SEED, draw_cases

CASES = 100
COMMAND = "python -m verification.against_mujoco --write verification/mujoco.md"
BEGIN = f"<!-- written by `{COMMAND}` -->"
END = "<!-- end of what is written -->"


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, print and write; return the exit code."""
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
        _write(options.write, report)
    return 0 if holds else 1


def _compare(engine_version: str) -> tuple[str, bool]:
    """Return the report in Markdown, and True if all of it holds."""
    from verification import compare, friction, tool
    from verification.rig import Rig

    cases = draw_cases(CASES)
    engine = [Rig(case).answer() for case in cases]
    ours = tool.answers(cases)
    rows = compare.differences(engine, ours)
    differing = compare.disagreements(engine, ours)
    missed = sum(not row.holds for row in rows)
    states_hold = not missed and not differing
    states_verdict = "All hold."
    if not states_hold:
        states_verdict = f"MISSED: {missed} quantities, {differing} states of slack."

    fitted = friction.fits()
    off = sum(not row.holds for row in fitted)
    friction_verdict = f"MISSED: {off} coefficients." if off else "All hold."
    tolerance = f"{friction.TOLERANCE:.0%}"
    report = (
        f"tendon {__version__} against MuJoCo {engine_version}, "
        f"{CASES} random arms and designs (seed {SEED}):"
        f"\n{compare.counts(ours)}.\n"
        f"States in which the two differ on which side is slack: {differing}.\n\n"
        f"{compare.table(rows)}\n\n{states_verdict}\n\n"
        f"Friction coefficients fitted to a rope dragged over a drum (tolerance {tolerance}):\n\n"
        f"{friction.table(fitted)}\n\n{friction_verdict}"
    )
    return report, states_hold and not off


def _write(page: Path, report: str) -> None:
    """Replace the text between the marks of the page."""
    before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise SystemExit(
            f"{page}: expected the lines {BEGIN} and {END}, and the table goes between them"
        )
    page.write_text(f"{before}{begin}\n\n{report}\n\n{end}{after}", encoding="utf-8")


if __name__ == "__main__":
    raise SystemExit(main())
