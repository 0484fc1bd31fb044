"""From a folder to its page, whichever kind of run it holds."""

from __future__ import annotations

import base64
import json
from html import escape
from os import PathLike
from pathlib import Path

from tendon_cli.engine.results import AnyResult, Run, folder_of, verified_record
from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import open_file, output_errors, read_file, result_path, write_whole
from tendon_cli.reports import html
from tendon_cli.reports.data import page_data
from tendon_cli.reports.design_page import design_page
from tendon_cli.reports.html import MARK
from tendon_cli.reports.sweep_page import sweep_page

NAME, LEDGER = "report.html", "ledger.json"
_MOST_PICTURES, _MOST_DATA = 3_000_000, 10**6
"""Bytes of all figures of the paper together, those beyond are named; and of what it found."""
_FIELDS = ("id", "verdict", "finding", "value")


def write_report(result: AnyResult, out: str | PathLike[str] | None = None) -> Path:
    """Write one HTML page of a run, an answer or the reproduced paper, with everything in it; returns its path.

    By default it is `report.html` in the folder of the result. Raises InputError for any other folder, UsageError if
    something else stands under that name, OutputError.

    >>> import tendon_cli as tendon
    >>> tendon.report(tendon.sweep({}, "results/mine"), "page.html")
    PosixPath('page.html')
    """
    folder = folder_of(result)
    target = folder / NAME if out is None else result_path(out)
    if not _is_ours(target):
        raise UsageError("is no page of tendon, and is left as it is", where=str(target), hint="another --out")
    page = _page_of(folder)
    write_whole(target, page.encode())
    return target


def _page_of(folder: Path) -> str:
    if (folder / LEDGER).exists():
        return _paper_page(folder)
    record = verified_record(folder)
    return design_page(folder, record) if record["verb"] == "design" else sweep_page(folder, Run(record, folder))


def _is_ours(target: Path) -> bool:
    """Whether a name is free, or bears a page that was written here before."""
    with output_errors(target):
        if not target.exists():
            return True
        with open_file(target) as file:
            return MARK.encode() in file.read(4096)


def _paper_page(folder: Path) -> str:
    """The page of what `tendon paper` left in a folder; raises InputError for a damaged ledger."""
    try:
        entries = json.loads(read_file(folder / LEDGER, _MOST_DATA))
        rows = [tuple(str(entry[name]) for name in _FIELDS) for entry in entries]
    except (OSError, ValueError, KeyError, TypeError) as error:
        hint = "`tendon paper` writes it anew"
        raise InputError(f"is no ledger: {error}", where=str(folder / LEDGER), hint=hint) from None
    pictures, left_out = _pictures(folder)
    table = html.table(("id", "verdict", "what the paper says", "result"), rows)
    parts = [
        html.head("The paper, reproduced", "findings and claims, each with its number",
                  {"ledger": "Findings", "figures": "Figures"}),
        html.section("ledger", "Findings and claims", table),
        html.section("figures", "Figures", pictures + html.notes(left_out, "warning")),
    ]  # fmt: skip
    return html.html_page("The paper, reproduced", parts, page_data())


def _pictures(folder: Path) -> tuple[str, list[str]]:
    room, pictures, left_out = _MOST_PICTURES, [], []
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
