"""`tendon paper` without its printing: every study, figure and finding of the paper, each judged."""

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
from tendon_cli.friction import fit_friction
from tendon_cli.paper.claims import CLAIMS
from tendon_cli.paper.figures import draw_slips, finisher
from tendon_cli.paper.findings import FINDINGS, failing_by_place
from tendon_cli.paper.page import Places, Verdicts
from tendon_cli.paper.runs import READINGS, STUDIES, VARIANTS, Paper, swept
from tendon_cli.paper.slips import SLIPS
from tendon_cli.paper.statements import judged

Progress = Callable[[int, int], None]
"""Called with the number of finished steps and of all steps."""

WRAP_ANGLE, PRINTED_ANGLE = "144 deg", "180 deg"
"""What Table A.1's coefficients imply, and the only angle that the paper prints."""
_PAGE, _DATA = "ledger.md", "ledger.json"


@dataclass(frozen=True)
class Reproduction:
    """The paper reproduced: its verdicts, and the files that stand in `out`."""

    out: Path
    verdicts: Verdicts
    files: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether every verdict is the one on record."""
        return all(entry.as_recorded for entry in self.verdicts.entries)

    def record(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "holds": self.holds, "load_distance": self.verdicts.places.span, "out": str(self.out),
            "ledger": self.verdicts.data(), "files": list(self.files),
        }  # fmt: skip

    def text(self) -> str:
        """A short summary, with every entry whose verdict is not the one on record."""
        lines = [
            *self.verdicts.counts(),
            *(f"  {entry.id} is {entry.verdict}, on record {entry.recorded}: {entry.finding}\n    {entry.value}"
              for entry in self.verdicts.entries if not entry.as_recorded),
            f"{self.out / _PAGE} has the details, with {len(self.files) - 2} figures next to it",
        ]  # fmt: skip
        return "\n".join(lines)


def reproduce(
    out: Path, *, jobs: int | None = None, progress: Progress | None = None, stop: threading.Event | None = None,
    runs: Path | None = None,
) -> Reproduction:  # fmt: skip
    """Run the paper's studies, draw its figures and write its page into `out`.

    The tables go to `runs` and stay there, by default to a temporary folder. Raises TendonError, and `part.Stopped`
    where `stop` was set.
    """
    with output_errors(out):
        out.mkdir(parents=True, exist_ok=True)
    done, total = [0], 2 * len(STUDIES) + len(VARIANTS) + 2

    def step() -> None:
        done[0] += 1
        if progress is not None:
            progress(done[0], total)

    with tempfile.TemporaryDirectory(prefix="tendon-paper-") as temporary:
        area = runs if runs is not None else Path(temporary)
        # A temporary folder is this run's alone: it needs no lock, and may lie where nothing can be locked.
        paper, verdicts = evaluate(area, jobs=jobs, stop=stop, step=step, lock=runs is not None)
        files = _draw(paper, out, step)
    write_whole(out / _PAGE, verdicts.page().encode())
    write_whole(out / _DATA, verdicts.json().encode())
    return Reproduction(out, verdicts, (*files, _PAGE, _DATA))


def evaluate(
    area: Path, *, jobs: int | None = 1, stop: threading.Event | None = None, step: Callable[[], None] = lambda: None,
    lock: bool = True,
) -> tuple[Paper, Verdicts]:  # fmt: skip
    """Sweep all studies into folders of `area`, fit Table A.1, and judge; nothing is drawn."""
    runs = {}
    for name, run in swept((*STUDIES, *VARIANTS), area, jobs=jobs, stop=stop or threading.Event(), lock=lock):
        runs[name] = run
        step()
    paper = Paper(runs, *(fit_friction(READINGS, bend_angle=angle) for angle in (WRAP_ANGLE, PRINTED_ANGLE)))
    kinds = {"finding": FINDINGS, "claim": CLAIMS, "slip": SLIPS}
    findings, claims, slips = (judged(kind, checks, paper) for kind, checks in kinds.items())
    return paper, Verdicts(findings, claims, slips, Places(failing_by_place(paper)))


def _draw(paper: Paper, out: Path, step: Callable[[], None]) -> list[str]:
    """All figures; returns the names of their files."""
    files: list[str] = []
    for name in STUDIES:
        run = paper[name]
        for figure in run.study.figure:
            files += [path.name for path in draw_declared(figure, run.folder, out, finisher(run))]
        step()
    draw_fit(paper.fit, out / "table_a1.png")
    step()
    files += ["table_a1.png", draw_slips(paper, out / "slips.png").name]
    step()
    return files
