"""The page of the reproduced paper: its ledger, and its figures."""

from __future__ import annotations

import base64
import json
from html import escape
from pathlib import Path

from tendon_cli.errors import InputError
from tendon_cli.files import read_file
from tendon_cli.reports import html
from tendon_cli.reports.data import page_data
from tendon_cli.reports.stale import LEDGER

MOST_PICTURES = 3_000_000
"""Bytes of all figures together; the others are named."""


MOST_LEDGER = 10**6
_FIELDS = ("id", "verdict", "finding", "value")


def paper_page(folder: Path) -> str:
    """The page of what `tendon paper` left in a folder; raises InputError for a damaged ledger."""
    ledger = _ledger(folder / LEDGER)
    rows = [(entry["id"], entry["verdict"], entry["finding"], entry["value"]) for entry in ledger]
    table = html.table(("id", "verdict", "what the paper says", "result"), rows)
    pictures, left_out = _pictures(folder)
    links = {"ledger": "Ledger", "figures": "Figures"}
    parts = [
        html.head("The paper, reproduced", "findings and claims, each with its number", links),
        html.section("ledger", "Findings and claims", table),
        html.section("figures", "Figures", pictures + html.warnings(left_out)),
    ]
    return html.html_page("The paper, reproduced", parts, page_data("paper"))


def _ledger(file: Path) -> list[dict[str, str]]:
    try:
        return [{name: str(entry[name]) for name in _FIELDS} for entry in json.loads(read_file(file, MOST_LEDGER))]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"is no ledger: {error}", where=str(file), hint="`tendon paper` writes it anew") from None


def _pictures(folder: Path) -> tuple[str, list[str]]:
    room, pictures, left_out = MOST_PICTURES, [], []
    for file in sorted(folder.glob("*.png")):
        if file.stat().st_size > room:
            left_out.append(f"{file.name} is not on this page, which is kept small")
            continue
        content = file.read_bytes()
        room -= len(content)
        data = base64.b64encode(content).decode("ascii")
        name = escape(file.stem)
        image = f'<img src="data:image/png;base64,{data}" alt="{name}">'
        pictures.append(f"<figure>{image}<figcaption>{name}</figcaption></figure>")
    return "".join(pictures), left_out
