"""What the paper found and claims, whether it holds, and where its letter fails, as a page and as data."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tendon_cli.paper.statements import FALSE, IN_PART, TRUE, Entry
from tendon_cli.tables.schema import versions
from tendon_cli.version import RESULTS_VERSION

_PAGE = """# The paper, reproduced

Yadav, Kumar, Surana, Ramasamy, Pal, Santapuri, Kumar, Muthukrishnan, Bhasin and Roy: *Modeling and parametric
optimization of 3D tendon-sheath actuator system for upper limb soft exosuit*.

`tendon paper` wrote this page. It ran the studies of the paper's figures, read their tables back, and judged every
finding and claim by the numbers in them.

{counts}

What the paper leaves open is the same in all studies: forearm and hand of 1.54 kg with their centre 174 mm from the
elbow, the load held at 320 mm. As in the paper, negative tension counts as slack (`slack = "bilateral"`). Figs. 9 to 11
count lengths from the unloaded tendon and spring, so that slack is below zero there too.

Made with {versions}.

## Findings

{findings}
## Claims

What the paper concludes from its figures, with other loads, springs and pretensions where it generalises.

{claims}
## Figures

{figures}## Where the letter of the paper fails

Each was run as it is printed, beside the reading used; *true* means that the evidence shows it to fail.
`docs/physics.md` states the reading used.

{slips}"""

_CAPTIONS = {
    "fig04": "Fig. 4. Ratio of the spool radii for no slack against the elbow angle.",
    "fig06": "Fig. 6. Torque at the elbow and at the motor for loads of (a) 0, (b) 3, (c) 5 and (d) 10 kg.",
    "fig07": "Fig. 7. Tension at the elbow for 0, 3, 5 and 10 kg. Open markers: extension, which lies on flexion.",
    "fig08": "Fig. 8. Tension at the motor for 0, 3 and 10 kg.",
    "fig09": "Fig. 9. Elongation of tendon and spring at 200 N pretension for 0, 3 and 10 kg.",
    "fig10": "Fig. 10. Elongation of tendon and spring for three spring constants, 5 kg, 100 N.",
    "fig11": "Fig. 11. Elongation of the spring for three ratios of the spool radii, 5 kg, 100 N.",
    "table_a1": "Table A.1. Load-cell readings at a wrap of 144°; the slope is μ of both directions together.",
    "slips": "The letter of the paper beside the reading used.",
}


@dataclass(frozen=True)
class Places:
    """Which findings fail, by the distance from the elbow at which the load is held (m, rising)."""

    failing: Mapping[float, Sequence[str]]

    @property
    def span(self) -> tuple[float, float] | None:
        """The nearest and the farthest place at which all findings hold, all those between them too; None for none."""
        holding = [place for place, failed in self.failing.items() if not failed]
        if not holding or any(self.failing[place] for place in self.failing if holding[0] < place < holding[-1]):
            return None
        return holding[0], holding[-1]

    def text(self) -> str:
        """The span in words, with what fails beyond it."""
        if self.span is None:
            return "The findings hold together over no one range of load distances."
        near, far = self.span
        places = list(self.failing)
        ends = (("nearer", places.index(near) - 1), ("farther", places.index(far) + 1))
        beyond = [f"{way}, not {', '.join(self.failing[places[at]])}" for way, at in ends if 0 <= at < len(places)]
        span = f"All findings hold together for loads held {1e3 * near:.0f} to {1e3 * far:.0f} mm from the elbow"
        return "; ".join([span, *beyond]) + "."


@dataclass(frozen=True)
class Verdicts:
    """All statements, and over which load distances the findings hold."""

    findings: Sequence[Entry]
    claims: Sequence[Entry]
    slips: Sequence[Entry]
    places: Places

    @property
    def entries(self) -> tuple[Entry, ...]:
        """Findings, claims and slips."""
        return (*self.findings, *self.claims, *self.slips)

    def data(self) -> list[dict[str, Any]]:
        """The entries for a program."""
        return [asdict(entry) | {"holds": entry.holds} for entry in self.entries]

    def json(self) -> str:
        """The entries as a JSON list."""
        return json.dumps(self.data(), indent=2, ensure_ascii=False) + "\n"

    def counts(self) -> list[str]:
        """What came out, a line each."""
        hold, shown = (f"{sum(entry.holds for entry in part)} of {len(part)}" for part in (self.findings, self.slips))
        verdicts = [entry.verdict for entry in self.claims]
        count = ", ".join(f"{verdicts.count(verdict)} {verdict}" for verdict in (TRUE, IN_PART, FALSE))
        recorded = "all" if all(entry.as_recorded for entry in self.claims) else "not all"
        return [
            f"{hold} findings of the paper hold.",
            f"Of its {len(verdicts)} claims {count}; {recorded} as on record.",
            f"{shown} slips of its letter are shown.",
            self.places.text(),
        ]

    def page(self) -> str:
        """All of it as a page of Markdown."""
        known = versions()
        libraries = ", ".join(f"{name} {known[name]}" for name in ("python", "numpy", "pyarrow"))
        shown: dict[str, list[str]] = {}
        for entry in self.entries:
            if entry.figure:
                shown.setdefault(entry.figure, []).append(entry.id)
        figures = ""
        for figure, ids in shown.items():
            caption = _CAPTIONS[figure.partition(".")[0]]
            figures += f"![{caption}]({figure})\n\n*{caption}* Shows {', '.join(ids)}.\n\n"
        return _PAGE.format(
            counts="\n".join(f"- {line}" for line in self.counts()),
            versions=f"tendon {known['tendon']} (results version {RESULTS_VERSION}), {libraries}",
            findings=_table(self.findings, "finding", "numbers"), claims=_table(self.claims, "claim", "numbers"),
            figures=figures, slips=_table(self.slips, "slip", "evidence"),
        )  # fmt: skip


def _table(entries: Sequence[Entry], what: str, numbers: str) -> str:
    rows = [f"| id | verdict | {what} | {numbers} | figure |", "|---|---|---|---|---|"]
    for entry in entries:
        mark = entry.verdict if entry.as_recorded else f"✗ {entry.verdict}, on record {entry.recorded}"
        texts = (text.replace("|", "\\|").replace("_", "\\_") for text in (entry.finding, entry.value))
        name = (entry.figure or "").partition(".")[0]
        called = f"Fig. {int(name[3:])}" if name.startswith("fig") else {"table_a1": "Table A.1"}.get(name, name)
        link = f"[{called}]({entry.figure})" if entry.figure else ""
        rows.append(f"| {' | '.join((entry.id, mark, *texts, link))} |")
    return "\n".join(rows) + "\n"
