"""From a folder to its page, whichever kind of run it holds."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from tendon_cli.engine.results import AnyResult, Run, folder_of, verified_record
from tendon_cli.errors import UsageError
from tendon_cli.files import open_file, output_errors, result_path, write_whole
from tendon_cli.reports.design_page import design_page
from tendon_cli.reports.html import MARK
from tendon_cli.reports.paper_page import paper_page
from tendon_cli.reports.stale import LEDGER, NAME, origin_mark
from tendon_cli.reports.sweep_page import sweep_page


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
    page = _page_of(folder).replace(MARK, f"{MARK}\n{origin_mark(folder)}", 1)
    write_whole(target, page.encode())
    return target


def _page_of(folder: Path) -> str:
    if (folder / LEDGER).exists():
        return paper_page(folder)
    record = verified_record(folder)
    return design_page(folder, record) if record["verb"] == "design" else sweep_page(folder, Run(record, folder))


def _is_ours(target: Path) -> bool:
    """Whether a name is free, or bears a page that was written here before."""
    with output_errors(target):
        if not target.exists():
            return True
        with open_file(target) as file:
            return MARK.encode() in file.read(4096)
