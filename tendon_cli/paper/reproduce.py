"""`tendon paper` without its printing: all studies, figures and statements of the paper, judged, as page and data."""

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
from tendon_cli.files import output_errors, write_whole
from tendon_cli.friction import fit_friction
from tendon_cli.paper.findings import CLAIMS, FINDINGS, failing_by_place
from tendon_cli.paper.runs import READINGS, STUDIES, VARIANTS, Paper, PaperTables, swept
from tendon_cli.paper.slips import SLIPS
from tendon_cli.paper.statements import FALSE, IN_PART, TRUE, Entry, content, judged
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.tables.schema import versions
from tendon_cli.version import RESULTS_VERSION

Progress = Callable[[int, int], None]
"""Called with the number of finished steps and of all steps."""

WRAP_ANGLE, PRINTED_ANGLE = "144 deg", "180 deg"
"""What Table A.1's coefficients imply, and the only angle that the paper prints."""
_PAGE, _DATA, _TABLE_A1 = "ledger.md", "ledger.json", "table_a1.png"


@dataclass(frozen=True)
class Reproduction:
    """The paper reproduced: its statements judged, and the files that stand in `out`."""

    entries: tuple[Entry, ...]
    """Findings, claims and slips."""
    failing: Mapping[float, Sequence[str]]
    """Which findings fail, by the distance from the elbow at which the load is held (m, rising)."""
    out: Path
    files: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether every verdict is the one on record."""
        return all(entry.as_recorded for entry in self.entries)

    @property
    def span(self) -> tuple[float, float] | None:
        """The nearest and the farthest place at which all findings hold, all those between them too; None for none."""
        holding = [place for place, failed in self.failing.items() if not failed]
        if not holding or any(
            self.failing[place] for place in self.failing if holding[0] < place < holding[-1]
        ):
            return None
        return holding[0], holding[-1]

    def of(self, kind: str) -> list[Entry]:
        """The findings, claims or slips."""
        return [entry for entry in self.entries if entry.kind == kind]

    def data(self) -> list[dict[str, Any]]:
        """The entries for a program."""
        return [asdict(entry) | {"holds": entry.holds} for entry in self.entries]

    def json(self) -> str:
        """The entries as a JSON list."""
        return json.dumps(self.data(), indent=2, ensure_ascii=False) + "\n"

    def counts(self) -> list[str]:
        """What came out, a line each."""
        hold, shown = (
            f"{sum(entry.holds for entry in part)} of {len(part)}"
            for part in map(self.of, ("finding", "slip"))
        )
        claims = self.of("claim")
        verdicts = [entry.verdict for entry in claims]
        count = ", ".join(
            f"{verdicts.count(verdict)} {verdict}" for verdict in (TRUE, IN_PART, FALSE)
        )
        recorded = "all" if all(entry.as_recorded for entry in claims) else "not all"
        return [
            f"{hold} findings of the paper hold.",
            f"Of its {len(claims)} claims {count}; {recorded} as on record.",
            f"{shown} slips of its letter are shown.",
            self._places(),
        ]

    def _places(self) -> str:
        """The span in words, with what fails beyond it."""
        if self.span is None:
            return "The findings hold together over no one range of load distances."
        near, far = self.span
        places = list(self.failing)
        ends = (("nearer", places.index(near) - 1), ("farther", places.index(far) + 1))
        beyond = [
            f"{way}, not {', '.join(self.failing[places[at]])}"
            for way, at in ends
            if 0 <= at < len(places)
        ]
        span = f"All findings hold together for loads held {1e3 * near:.0f} to {1e3 * far:.0f} mm from the elbow"
        return "; ".join([span, *beyond]) + "."

    def page(self) -> str:
        """All of it as a page of Markdown."""
        known, written, figures = versions(), content(), ""
        libraries = ", ".join(f"{name} {known[name]}" for name in ("python", "numpy", "pyarrow"))
        for figure in dict.fromkeys(entry.figure for entry in self.entries if entry.figure):
            caption = written["captions"][figure.partition(".")[0]]
            ids = ", ".join(entry.id for entry in self.entries if entry.figure == figure)
            figures += f"![{caption}]({figure})\n\n*{caption}* Shows {ids}.\n\n"
        return str(written["page"]).format(
            counts="\n".join(f"- {line}" for line in self.counts()),
            figures=figures,
            versions=f"tendon {known['tendon']} (results version {RESULTS_VERSION}), {libraries}",
            **{f"{kind}s": _table(self.of(kind), kind) for kind in ("finding", "claim", "slip")},
        )

    def record(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "holds": self.holds,
            "load_distance": self.span,
            "out": str(self.out),
            "ledger": self.data(),
            "files": list(self.files),
        }

    def text(self) -> str:
        """A short summary, with every entry whose verdict is not the one on record."""
        wrong = [
            f"  {entry.id} is {entry.verdict}, on record {entry.recorded}: {entry.finding}\n    {entry.value}"
            for entry in self.entries
            if not entry.as_recorded
        ]
        details = (
            f"{self.out / _PAGE} has the details, with {len(self.files) - 2} figures next to it"
        )
        return "\n".join([*self.counts(), *wrong, details])


def _table(entries: Sequence[Entry], kind: str) -> str:
    rows = [f"| id | verdict | {kind} | numbers | figure |", "|---|---|---|---|---|"]
    for entry in entries:
        mark = (
            entry.verdict if entry.as_recorded else f"✗ {entry.verdict}, on record {entry.recorded}"
        )
        texts = (
            text.replace("|", "\\|").replace("_", "\\_") for text in (entry.finding, entry.value)
        )
        name = (entry.figure or "").partition(".")[0]
        called = f"Fig. {int(name[3:])}" if name.startswith("fig") else "Table A.1"
        link = f"[{called}]({entry.figure})" if entry.figure else ""
        rows.append(f"| {' | '.join((entry.id, mark, *texts, link))} |")
    return "\n".join(rows) + "\n"


def reproduce(
    out: Path,
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
    stop: threading.Event | None = None,
    runs: Path | None = None,
) -> Reproduction:
    """Run the paper's studies, draw its figures and write its page into `out`.

    The tables go to `runs` and stay there, by default to a temporary folder. Raises TendonError, and `part.Stopped`
    where `stop` was set.
    """
    with output_errors(out):
        out.mkdir(parents=True, exist_ok=True)
    done, total = [0], 2 * len(STUDIES) + len(VARIANTS) + 1

    def step() -> None:
        done[0] += 1
        if progress is not None:
            progress(done[0], total)

    with tempfile.TemporaryDirectory(prefix="tendon-paper-") as temporary:
        area = runs if runs is not None else Path(temporary)
        # A temporary folder is this run's alone: it needs no lock, and may lie where nothing can be locked.
        paper, judgement = evaluate(area, jobs=jobs, stop=stop, step=step, lock=runs is not None)
        files = _draw(paper, out, step)
    write_whole(out / _PAGE, judgement.page().encode())
    write_whole(out / _DATA, judgement.json().encode())
    return replace(judgement, out=out, files=(*files, _PAGE, _DATA))


def evaluate(
    area: Path,
    *,
    jobs: int | None = 1,
    stop: threading.Event | None = None,
    step: Callable[[], None] = lambda: None,
    lock: bool = True,
) -> tuple[Paper, Reproduction]:
    """Sweep all studies into folders of `area`, fit Table A.1, and judge; nothing is drawn."""
    runs = {}
    for name, run in swept(
        (*STUDIES, *VARIANTS), area, jobs=jobs, stop=stop or threading.Event(), lock=lock
    ):
        runs[name] = run
        step()
    paper = Paper(
        runs, *(fit_friction(READINGS, bend_angle=angle) for angle in (WRAP_ANGLE, PRINTED_ANGLE))
    )
    return paper, Reproduction(
        judged(FINDINGS | CLAIMS | SLIPS, paper), failing_by_place(paper), area
    )


def _draw(paper: Paper, out: Path, step: Callable[[], None]) -> list[str]:
    """All figures; returns the names of their files."""
    files: list[str] = []
    for name in STUDIES:
        run = paper[name]
        for figure in run.study.figure:
            files += [path.name for path in draw_declared(figure, run.folder, out, finisher(run))]
        step()
    draw_fit(paper.fit, out / _TABLE_A1)
    step()
    return [*files, _TABLE_A1]


# --- What the figures say besides their curves, so that a finding is read off its figure -----------------------------


def finisher(run: PaperTables) -> Finish:
    """Adds that to the figure of a run."""

    def finish(figure: FigureSpec, page: Figure) -> None:
        if figure.name == "fig04":
            _mark_ratio(page.axes[0])
        if figure.name == "fig06":
            _mark_crossings(page, run)
        if len(page.axes) == 2:
            for axes, side in zip(page.axes, ("front", "back"), strict=True):
                axes.set_title(f"{side} of the arm: {axes.get_title()}")
        if len(figure.quantity) == 2 and all(
            name.endswith("elongation") for name in figure.quantity
        ):
            page.axes[0].set_ylabel("length over unloaded (mm)")
        elif all("_tension_" in name for name in figure.quantity):
            page.axes[0].set_ylabel("tension (N)")

    return finish


def _mark_ratio(axes: Axes) -> None:
    axes.set_ylabel("flexor over extensor travel, $H_f / H_e$")
    axes.axhline(1.0, color=FAINT, linewidth=0.8, linestyle="dashed")
    (line,) = [line for line in axes.lines if line.get_gid() == "curve"]
    x, y = (np.asarray(values, dtype=np.float64) for values in line.get_data())
    at_one = float(np.interp(1.0, y, x))
    points = (
        (at_one, 1.0, f"1 at {at_one:.1f}°", (4, -11), "left"),
        (x[-1], y[-1], f"{y[-1]:.3f} at 90°", (-6, 0), "right"),
    )
    for at, height, text, offset, side in points:
        axes.plot([at], [height], "o", color=INK, markersize=4.0, clip_on=False, gid="mark")
        axes.annotate(
            text, (at, height), xytext=offset, textcoords="offset points", ha=side, va="center"
        )


def _mark_crossings(page: Figure, run: PaperTables) -> None:
    """The first angles of flexion, where the motor torque is the larger one."""
    for mark, axes, angle in zip("abcd", page.axes, run.crossings(), strict=True):
        axes.set_title(f"({mark}) {axes.get_title()}")
        axes.axvspan(0.0, angle, facecolor="#efefef", linewidth=0.0, zorder=0.4, gid="first angles")
        axes.text(
            angle + 1.0,
            0.97,
            f"in flexion $\\tau_m > \\tau_a$\nonly below {angle:.1f}°",
            va="top",
            transform=axes.get_xaxis_transform(),
            size=7.0,
        )
