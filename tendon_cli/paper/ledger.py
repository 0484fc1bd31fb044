"""The ledger: what the paper found, whether it holds, and where its letter fails, as a page and as data."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict

from tendon_cli.paper.entry import Entry
from tendon_cli.sweep.columns import versions
from tendon_cli.version import RESULTS_VERSION

_INTRO = """# The paper, reproduced

Yadav, Kumar, Surana, Ramasamy, Pal, Santapuri, Kumar, Muthukrishnan, Bhasin and Roy: *Modeling and parametric
optimization of 3D tendon-sheath actuator system for upper limb soft exosuit*.

`tendon paper` wrote this page. It ran the studies of the paper's figures, read their tables back, and judged every
finding by the numbers in them. {count}

What the paper leaves open is the same in all studies: forearm and hand of 1.54 kg with their centre 174 mm from the
elbow, the load held at 320 mm. As in the paper, negative tension counts as slack (`slack = "bilateral"`). Figs. 9 to 11
count lengths from the unloaded tendon and spring, so that slack is below zero there too.

Made with {versions}.

"""

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


def ledger_json(entries: Sequence[Entry]) -> str:
    """The entries as a JSON list."""
    return json.dumps([asdict(entry) for entry in entries], indent=2, ensure_ascii=False) + "\n"


def ledger_page(findings: Sequence[Entry], slips: Sequence[Entry]) -> str:
    """The ledger as a page of Markdown."""
    held = sum(entry.holds for entry in findings)
    count = f"{held} of {len(findings)} findings hold."
    parts = [_INTRO.format(count=f"**{count}**", versions=_versions()), "## Findings\n\n"]
    parts += [_table(findings, "finding", "numbers"), "\n## Figures\n\n", _figures([*findings, *slips])]
    parts += ["## Where the letter of the paper fails\n\n", _SLIPS, _table(slips, "slip", "evidence")]
    return "".join(parts)


_SLIPS = """Each was run as it is printed, beside the reading used. ✓ means: the evidence shows that the letter fails.
`docs/physics.md` states the reading used.

"""


def _versions() -> str:
    found = versions()
    libraries = ", ".join(f"{name} {found[name]}" for name in ("python", "numpy", "pyarrow"))
    return f"tendon {found['tendon']} (results version {RESULTS_VERSION}), {libraries}"


def _table(entries: Sequence[Entry], what: str, numbers: str) -> str:
    rows = [f"| id | | {what} | {numbers} | figure |", "|---|---|---|---|---|"]
    for entry in entries:
        mark = "✓" if entry.holds else "✗"
        link = f"[{_stem(entry)}]({entry.figure})" if entry.figure else ""
        cells = (entry.id, mark, _cell(entry.finding), _cell(entry.value), link)
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


def _cell(text: str) -> str:
    """Text as it stands in a table of Markdown."""
    return text.replace("|", "\\|").replace("_", "\\_")


def _figures(entries: Sequence[Entry]) -> str:
    shown: dict[str, list[str]] = {}
    for entry in entries:
        if entry.figure:
            shown.setdefault(entry.figure, []).append(entry.id)
    blocks = []
    for figure, ids in shown.items():
        caption = _CAPTIONS[figure.partition(".")[0]]
        blocks.append(f"![{caption}]({figure})\n\n*{caption}* Shows {', '.join(ids)}.\n\n")
    return "".join(blocks)


def _stem(entry: Entry) -> str:
    """What a link to the figure says."""
    name = (entry.figure or "").partition(".")[0]
    return f"Fig. {int(name[3:])}" if name.startswith("fig") else {"table_a1": "Table A.1", "slips": "slips"}[name]
