"""Write anew what tendon itself says on the pages: `python docs/refresh.py [PAGE ...]`.

These are the tables of reference, and what the commands and the Python of the pages print. Parts of
an output that a page leaves out (`...`) stay left out. What cannot be found in the new output is
named, to be mended by hand.
"""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS.parent))

from docs import reference, snippets  # noqa: E402 - wherever this is called

_SECONDS = re.compile(r"\bin [\d.,]+ s\b")
_GAP = ["..."]


def refresh(page: Path) -> list[str]:
    """Write a page anew. Return what has to be mended by hand."""
    text = reference.renewed(page.read_text(encoding="utf-8"))
    try:
        with tempfile.TemporaryDirectory() as folder:
            outputs = list(snippets.outputs(text, Path(folder)))
    except Exception as error:  # noqa: BLE001 - the other pages can still be written
        return [f"{page.name}: {error!r}"]
    by_hand = []
    for output in reversed(outputs):  # from the end on: the places before stay right
        if output.is_as_expected:
            continue
        renewed = with_gaps(output.expected, output.printed)
        end = output.start + len(output.expected)
        if renewed is None:
            by_hand.append(f"{page.name}, {output.source}")
        else:
            text = text[: output.start] + renewed + text[end:]
    page.write_text(text, encoding="utf-8")
    return by_hand


def with_gaps(expected: str, printed: str) -> str | None:
    """Return what was printed, without what the expected text leaves out.

    An entry is a line with the deeper lines below it. After a gap the text goes on with the entry
    that begins with the same word. None if there is no such entry.
    """
    printed = _SECONDS.sub("in ... s", printed)
    entries = _entries(printed.strip("\n"))
    shown = _entries(expected.strip("\n"))
    if _GAP not in shown:
        return "".join(f"{line}\n" for entry in entries for line in entry)
    result: list[str] = []
    after_gap = False
    for entry in shown:
        if entry == _GAP:
            result += _GAP
        else:
            while after_gap and entries and _first_word(entries[0]) != _first_word(entry):
                entries.pop(0)
            if not entries:
                return None
            result += entries.pop(0)
        after_gap = entry == _GAP
    return "".join(f"{line}\n" for line in result)


def _entries(text: str) -> list[list[str]]:
    """Return the lines of a text, each with the deeper lines below it."""
    entries: list[list[str]] = []
    for line in text.splitlines():
        is_deeper = bool(entries) and _indent(entries[-1][0]) < _indent(line)
        if is_deeper and entries[-1] not in (_GAP, [""]):
            entries[-1].append(line)
        else:
            entries.append([line.rstrip()])
    return entries


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def _first_word(entry: list[str]) -> str:
    word = re.search(r"[^\W\d]\w*", entry[0])
    return word[0] if word else ""


if __name__ == "__main__":
    named = [Path(name) for name in sys.argv[1:]]
    left = [
        fault
        for page in named or [DOCS.parent / "README.md", *sorted(DOCS.glob("*.md"))]
        for fault in refresh(page)
    ]
    sys.stdout.write("".join(f"by hand: {fault}\n" for fault in left))
    sys.exit(bool(left))
