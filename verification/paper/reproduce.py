"""Reproduce the paper: run its studies, draw its figures, judge its statements, write its page."""

from __future__ import annotations

import json
import tempfile
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.figures.backend import Axes, Figure
from tendon_cli.figures.draw import Finish, draw_declared
from tendon_cli.figures.friction import draw as draw_fit
from tendon_cli.figures.style import FAINT, INK
from tendon_cli.files import output_errors
from tendon_cli.fits.friction import fit_friction
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.tables.schema import versions
from tendon_cli.version import RESULTS_VERSION
from verification.paper.findings import CLAIMS, FINDINGS, failing_by_place
from verification.paper.runs import (
    READINGS,
    STUDIES,
    VARIANTS,
    Paper,
    PaperTables,
    sweep_studies,
)
from verification.paper.slips import SLIPS
from verification.paper.statements import FALSE, IN_PART, TRUE, Entry, content, judge_all

Progress = Callable[[int, int], None]
"""Called with the number of finished steps and of all steps."""

WRAP_ANGLE = "144 deg"
"""Wrap angle that Table A.1's coefficients imply."""
PRINTED_ANGLE = "180 deg"
"""The only angle that the paper prints."""
_PAGE = "ledger.md"
_DATA = "ledger.json"
_TABLE_A1 = "table_a1.png"


@dataclass(frozen=True)
class Reproduction:
    """The paper reproduced: its statements judged, and the files that were written."""

    entries: tuple[Entry, ...]
    """Findings, claims, slips and gaps."""
    failing: Mapping[float, Sequence[str]]
    """Findings that fail, by the rising distance from the elbow at which the load is held, m."""
    out: Path
    """Folder of the files."""
    files: tuple[str, ...] = ()
    """Names of the files: figures, page and data."""

    @property
    def holds(self) -> bool:
        """True if every verdict is the one on record."""
        return all(entry.as_recorded for entry in self.entries)

    @property
    def span(self) -> tuple[float, float] | None:
        """Smallest and largest load distance between which all findings hold, m.

        None if they hold at no place, or fail at a place between others at which they hold.
        """
        holding = [place for place, failed in self.failing.items() if not failed]
        if not holding:
            return None
        near = holding[0]
        far = holding[-1]
        between = [place for place in self.failing if near < place < far]
        if any(self.failing[place] for place in between):
            return None
        return near, far

    def entries_of(self, kind: str) -> list[Entry]:
        """Select the entries of one kind."""
        return [entry for entry in self.entries if entry.kind == kind]

    def data(self) -> list[dict[str, Any]]:
        """Return the entries as dictionaries."""
        return [asdict(entry) | {"holds": entry.holds} for entry in self.entries]

    def json(self) -> str:
        """Return the entries as a JSON list."""
        return json.dumps(self.data(), indent=2, ensure_ascii=False) + "\n"

    def counts(self) -> list[str]:
        """Return a summary of the verdicts, a sentence each."""
        findings = self.entries_of("finding")
        claims = self.entries_of("claim")
        slips = self.entries_of("slip")
        gaps = self.entries_of("gap")
        verdicts = [entry.verdict for entry in claims]
        count = ", ".join(
            f"{verdicts.count(verdict)} {verdict}" for verdict in (TRUE, IN_PART, FALSE)
        )
        recorded = "all" if all(entry.as_recorded for entry in claims) else "not all"
        return [
            f"{_number_that_hold(findings)} findings of the paper hold.",
            f"Its {len(claims)} claims: {count}; {recorded} as on record.",
            f"{_number_that_hold(slips)} slips of print are shown, {_number_that_hold(gaps)} gaps.",
            self._places(),
        ]

    def _places(self) -> str:
        """Return the span in words, with the findings that fail just beyond it."""
        if self.span is None:
            return "There is no single range of load distances over which all findings hold."
        near, far = self.span
        places = list(self.failing)
        text = "All findings hold together for loads held "
        text += f"{1e3 * near:.0f} to {1e3 * far:.0f} mm from the elbow"
        if places[0] < near:
            nearer = places[places.index(near) - 1]
            text += f"; nearer, without {', '.join(self.failing[nearer])}"
        if places[-1] > far:
            farther = places[places.index(far) + 1]
            text += f"; farther, without {', '.join(self.failing[farther])}"
        return f"{text}."

    def page(self) -> str:
        """Return all of it as a page of Markdown."""
        installed = versions()
        written = content()
        libraries = ", ".join(
            f"{name} {installed[name]}" for name in ("python", "numpy", "pyarrow")
        )
        tendon = f"tendon {installed['tendon']} (results version {RESULTS_VERSION})"
        figures = ""
        for figure in dict.fromkeys(entry.figure for entry in self.entries if entry.figure):
            caption = written["captions"][figure.partition(".")[0]]
            ids = ", ".join(entry.id for entry in self.entries if entry.figure == figure)
            figures += f"![{caption}]({figure})\n\n*{caption}* Shows {ids}.\n\n"
        return str(written["page"]).format(
            counts="\n".join(f"- {line}" for line in self.counts()),
            figures=figures,
            versions=f"{tendon}, {libraries}",
            findings=_table(self.entries_of("finding"), "finding"),
            claims=_table(self.entries_of("claim"), "claim"),
            slips=_table(self.entries_of("slip"), "slip"),
            gaps=_table(self.entries_of("gap"), "gap"),
        )

    def text(self) -> str:
        """Return a short summary, with every entry whose verdict is not the one on record."""
        lines = self.counts()
        for entry in self.entries:
            if not entry.as_recorded:
                verdict = f"{entry.id} is {entry.verdict}, on record {entry.recorded}"
                lines.append(f"  {verdict}: {entry.finding}")
                lines.append(f"    {entry.value}")
        number = len(self.files) - 2
        lines.append(f"{self.out / _PAGE} has the details, with {number} figures next to it")
        return "\n".join(lines)


def _number_that_hold(entries: Sequence[Entry]) -> str:
    """Return the number of entries that hold, such as "3 of 4"."""
    return f"{sum(entry.holds for entry in entries)} of {len(entries)}"


def _table(entries: Sequence[Entry], kind: str) -> str:
    """Return entries of one kind as a table of Markdown."""
    rows = [f"| id | verdict | {kind} | numbers | figure |", "|---|---|---|---|---|"]
    for entry in entries:
        verdict = entry.verdict
        if not entry.as_recorded:
            verdict = f"✗ {entry.verdict}, on record {entry.recorded}"
        link = f"[{_figure_label(entry.figure)}]({entry.figure})" if entry.figure else ""
        cells = (entry.id, verdict, _escaped(entry.finding), _escaped(entry.value), link)
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


def _escaped(text: str) -> str:
    """Return a text for a cell of a table of Markdown."""
    return text.replace("|", "\\|").replace("_", "\\_")


def _figure_label(file: str) -> str:
    """Return the paper's label of a figure, from the name of its file."""
    name = file.partition(".")[0]
    return f"Fig. {int(name[3:])}" if name.startswith("fig") else "Table A.1"


def reproduce(
    out: Path,
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
    runs: Path | None = None,
) -> Reproduction:
    """Run the paper's studies, draw its figures and write its page.

    Args:
        out: Folder of the page and the figures.
        jobs: Parts of a study made at once; None for one for each core.
        progress: Called after each step.
        stop: Event that ends the work.
        runs: Folder in which the tables stay; None for a temporary one.

    Raises:
        TendonError: A study cannot be run, or a file cannot be written.
        Stopped: `stop` was set.
    """
    with output_errors(out):
        out.mkdir(parents=True, exist_ok=True)
    done = 0
    total = 2 * len(STUDIES) + len(VARIANTS) + 1

    def step() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, total)

    with tempfile.TemporaryDirectory(prefix="tendon-paper-") as temporary:
        area = runs if runs is not None else Path(temporary)
        paper, judgement = evaluate(area, jobs=jobs, stop=stop, step=step)
        files = _draw(paper, out, step)
    with output_errors(out):
        (out / _PAGE).write_text(judgement.page(), encoding="utf-8")
        (out / _DATA).write_text(judgement.json(), encoding="utf-8")
    return replace(judgement, out=out, files=(*files, _PAGE, _DATA))


def evaluate(
    area: Path,
    *,
    jobs: int | None = 1,
    stop: threading.Event | None = None,
    step: Callable[[], None] = lambda: None,
) -> tuple[Paper, Reproduction]:
    """Sweep all studies, fit Table A.1, and judge all statements; nothing is drawn.

    Args:
        area: Folder in which each study has a folder of its own.
        jobs: Parts of a study made at once; None for one for each core.
        stop: Event that ends the work.
        step: Called after each study.
    """
    runs = {}
    stop = stop or threading.Event()
    for name, run in sweep_studies((*STUDIES, *VARIANTS), area, jobs=jobs, stop=stop):
        runs[name] = run
        step()
    fit = fit_friction(READINGS, bend_angle=WRAP_ANGLE)
    fit_at_pi = fit_friction(READINGS, bend_angle=PRINTED_ANGLE)
    paper = Paper(runs, fit, fit_at_pi)
    entries = judge_all(FINDINGS | CLAIMS | SLIPS, paper)
    return paper, Reproduction(entries, failing_by_place(paper), area)


def _draw(paper: Paper, out: Path, step: Callable[[], None]) -> list[str]:
    """Draw all figures and return the names of their files."""
    files: list[str] = []
    for name in STUDIES:
        run = paper[name]
        for figure in run.study.figure:
            drawn = draw_declared(figure, run.folder, out, finisher(run))
            files += [path.name for path in drawn]
        step()
    draw_fit(paper.fit, out / _TABLE_A1)
    step()
    return [*files, _TABLE_A1]


# --- Marks and labels that let a finding be read off a figure ------------------------------------


def finisher(run: PaperTables) -> Finish:
    """Return the function that adds marks and labels to a figure of a run."""

    def finish(figure: FigureSpec, page: Figure) -> None:
        if figure.name == "fig04":
            _mark_ratio(page.axes[0])
        if figure.name == "fig06":
            _mark_crossings(page, run)
        if len(page.axes) == 2:
            for axes, side in zip(page.axes, ("front", "back"), strict=True):
                axes.set_title(f"{side} of the arm: {axes.get_title()}")
        shows_elongations = all(name.endswith("elongation") for name in figure.quantity)
        shows_tensions = all("_tension_" in name for name in figure.quantity)
        if len(figure.quantity) == 2 and shows_elongations:
            page.axes[0].set_ylabel("length over unloaded (mm)")
        elif shows_tensions:
            page.axes[0].set_ylabel("tension (N)")

    return finish


def _mark_ratio(axes: Axes) -> None:
    """Mark the angle at which the ratio is 1, and the ratio at the last angle."""
    axes.set_ylabel("flexor over extensor travel, $H_f / H_e$")
    axes.axhline(1.0, color=FAINT, linewidth=0.8, linestyle="dashed")
    (line,) = [line for line in axes.lines if line.get_gid() == "curve"]
    angles, ratios = (np.asarray(values, dtype=np.float64) for values in line.get_data())
    at_one = float(np.interp(1.0, ratios, angles))
    marks = (
        (at_one, 1.0, f"1 at {at_one:.1f}°", (4, -11), "left"),
        (angles[-1], ratios[-1], f"{ratios[-1]:.3f} at 90°", (-6, 0), "right"),
    )
    for x, y, text, offset, side in marks:
        axes.plot([x], [y], "o", color=INK, markersize=4.0, clip_on=False, gid="mark")
        axes.annotate(text, (x, y), xytext=offset, textcoords="offset points", ha=side, va="center")


def _mark_crossings(page: Figure, run: PaperTables) -> None:
    """Mark the first angles of flexion, at which the motor torque is the larger one."""
    for letter, axes, angle in zip("abcd", page.axes, run.crossings(), strict=True):
        axes.set_title(f"({letter}) {axes.get_title()}")
        axes.axvspan(0.0, angle, facecolor="#efefef", linewidth=0.0, zorder=0.4, gid="first angles")
        axes.text(
            angle + 1.0,
            0.97,
            f"in flexion $\\tau_m > \\tau_a$\nonly below {angle:.1f}°",
            va="top",
            transform=axes.get_xaxis_transform(),
            size=7.0,
        )
