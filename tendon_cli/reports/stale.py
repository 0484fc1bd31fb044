"""Whether the page in a run's folder is of what the folder holds now."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

from tendon_cli.files import open_file, read_file

NAME = "report.html"
LEDGER = "ledger.json"
_RECORDS = (LEDGER, "design.json", "run.json")
_MOST_BYTES = 10**9
_ORIGIN = re.compile(rb'<meta name="tendon-origin" content="([0-9a-f]+)">')


def origin(folder: Path) -> str | None:
    """A digest of the results that a folder holds, by its record; None where there is no record of tendon's.

    It is of the study's hash and of those of the tables, or of the ledger: drawing figures anew does not change it.
    """
    for name in _RECORDS:
        try:
            content = read_file(folder / name, _MOST_BYTES)
            if name != LEDGER:
                record = json.loads(content)
                files = [[entry["path"], entry["sha256"]] for entry in record["files"]]
                content = json.dumps([record["study_hash"], files]).encode()
        except FileNotFoundError:
            continue
        except (OSError, ValueError, KeyError, TypeError):
            return None
        return hashlib.sha256(content).hexdigest()
    return None


def origin_mark(folder: Path) -> str:
    """What a page says in its head of the results that it shows."""
    return f'<meta name="tendon-origin" content="{origin(folder)}">'


def stale_note(folder: Path) -> str | None:
    """What to say of a page that is of earlier results than its folder holds; None for any other."""
    try:
        with open_file(folder / NAME) as file:
            match = _ORIGIN.search(file.read(4096))
    except OSError:
        return None
    if match is None or match[1].decode() == origin(folder):
        return None
    return f"{folder / NAME} is of earlier results; `tendon report {folder}` writes it anew"
