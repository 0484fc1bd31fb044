"""`tendon paper` without its printing: every study, figure and finding of the paper, and its ledger."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tendon_cli.figures.draw import draw_declared
from tendon_cli.figures.friction import draw as draw_fit
from tendon_cli.files import output_errors, write_whole
from tendon_cli.friction import fit_file
from tendon_cli.friction.result import Fit
from tendon_cli.paper.claims import claims
from tendon_cli.paper.figures import draw_slips, finisher
from tendon_cli.paper.findings import failing_by_place, findings
from tendon_cli.paper.ledger import Ledger, Places, ledger_json, ledger_page
from tendon_cli.paper.runs import READINGS, STUDIES, VARIANTS, PaperTables, swept
from tendon_cli.paper.slips import FIGURE, Evidence, evidence, slips

Progress = Callable[[int, int], None]
"""Called with the number of finished steps and of all steps."""

WRAP_ANGLE, PRINTED_ANGLE = "144 deg", "180 deg"
"""What Table A.1's coefficients imply, and the only angle that the paper prints."""


@dataclass(frozen=True)
class Evaluation:
    """The paper's studies and fits, and what follows from them."""

    runs: dict[str, PaperTables]
    fit: Fit
    printed: Evidence
    ledger: Ledger


@dataclass(frozen=True)
class Reproduction:
    """The paper reproduced: its ledger, and the files that stand in `out`."""

    out: Path
    ledger: Ledger
    files: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether every verdict is the one on record."""
        return all(entry.as_recorded for entry in self.ledger.entries)

    def record(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "holds": self.holds,
            "load_distance": self.ledger.places.span,
            "out": str(self.out),
            "ledger": self.ledger.data(),
            "files": list(self.files),
        }

    def text(self) -> str:
        """A short summary, with every entry whose verdict is not the one on record."""
        lines = [
            *self.ledger.counts(),
            *(f"  {entry.id} is {entry.verdict}, on record {entry.recorded}: {entry.finding}\n    {entry.value}"
              for entry in self.ledger.entries if not entry.as_recorded),
            f"{self.out / 'ledger.md'} tells, with {len(self.files) - 2} figures beside it",
        ]  # fmt: skip
        return "\n".join(lines)


def reproduce(
    out: Path, *, jobs: int | None = None, progress: Progress | None = None, stop: threading.Event | None = None,
    runs: Path | None = None,
) -> Reproduction:  # fmt: skip
    """Run the paper's studies, draw its figures and write the ledger into `out`.

    The tables go to `runs` and stay there, by default to a temporary folder. Raises TendonError, and `part.Stopped`
    where `stop` was set.
    """
    with output_errors(out):
        out.mkdir(parents=True, exist_ok=True)
    total = 2 * len(STUDIES) + len(VARIANTS) + 2
    steps = _Steps(progress, total)
    with tempfile.TemporaryDirectory(prefix="tendon-paper-") as temporary:
        area = runs if runs is not None else Path(temporary)
        # A temporary folder is this run's alone: it needs no lock, and may lie where nothing can be locked.
        found = evaluate(area, jobs=jobs, stop=stop, step=steps.take, lock=runs is not None)
        files = _draw(found, out, steps.take)
    write_whole(out / "ledger.md", ledger_page(found.ledger).encode())
    write_whole(out / "ledger.json", ledger_json(found.ledger).encode())
    return Reproduction(out, found.ledger, (*files, "ledger.md", "ledger.json"))


def evaluate(
    area: Path, *, jobs: int | None = 1, stop: threading.Event | None = None, step: Callable[[], None] = lambda: None,
    lock: bool = True,
) -> Evaluation:  # fmt: skip
    """Sweep all studies into folders of `area`, fit Table A.1, and judge; nothing is drawn."""
    runs: dict[str, PaperTables] = {}
    for name, run in swept((*STUDIES, *VARIANTS), area, jobs=jobs, stop=stop or threading.Event(), lock=lock):
        runs[name] = run
        step()
    fit, at_pi = (fit_file(READINGS, bend_angle=angle) for angle in (WRAP_ANGLE, PRINTED_ANGLE))
    printed = evidence(runs["fig07"])
    places = Places(failing_by_place(runs))
    ledger = Ledger(findings(runs, fit), claims(runs), slips(runs, printed, at_pi, fit), places)
    return Evaluation(runs, fit, printed, ledger)


def _draw(found: Evaluation, out: Path, step: Callable[[], None]) -> list[str]:
    """All figures; returns the names of their files."""
    files: list[str] = []
    for name in STUDIES:
        run = found.runs[name]
        for figure in run.study.figure:
            files += [path.name for path in draw_declared(figure, run.folder, out, finisher(run))]
        step()
    draw_fit(found.fit, out / "table_a1.png")
    step()
    files += ["table_a1.png", draw_slips(found.runs, found.printed, out / FIGURE).name]
    step()
    return files


class _Steps:
    """Counts the steps that are done."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self._progress, self._total, self._done = progress, total, 0

    def take(self) -> None:
        self._done += 1
        if self._progress is not None:
            self._progress(self._done, self._total)
