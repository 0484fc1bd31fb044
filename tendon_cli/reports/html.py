"""A page from its data: text escaped, scripts allowed by their hashes alone, nothing fetched."""

from __future__ import annotations

import base64
import hashlib
import itertools
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from tendon_cli import say
from tendon_cli.say import Block

_PAGE = files("tendon_cli.reports") / "page"
_SCRIPTS = ("base", "map", "states", "table", "answers", "start")
MARK = '<meta name="generator" content="tendon">'
"""What tells a page of ours, near its beginning."""

_PLOTLY = "plotly-cartesian-4.1.1.min.js"


def html_page(
    title: str, sections: Sequence[str], data: Mapping[str, Any], joint: str = "elbow"
) -> str:
    """The whole file: `sections` are HTML, `data` is what the scripts draw, `joint` the word for the study's joint."""
    code = "\n".join((_PAGE / f"{name}.js").read_text(encoding="utf-8") for name in _SCRIPTS)
    library = (files("tendon_cli.reports") / "plotly" / _PLOTLY).read_text(encoding="utf-8")
    return (
        (_PAGE / "page.html")
        .read_text(encoding="utf-8")
        .format(
            mark=MARK,
            scripts=f"{_source(library)} {_source(code)}",
            title=escape(title),
            library=library,
            code=code,
            style=(_PAGE / "page.css").read_text(encoding="utf-8"),
            sections=say.of_joint("".join(sections), joint),
            data=say.of_joint(_embedded(data), joint),
        )
    )


Part = tuple[str, str, str]
"""A part of a page: what its link says, its heading, and HTML."""


def result_page(
    record: Mapping[str, Any],
    what: str,
    answer: tuple[str, str],
    parts: Mapping[str, Part],
    study: Mapping[str, Any],
    data: Mapping[str, Any],
) -> str:
    """The page of a run or an answer: what came out (heading and HTML), its figures, its study and record."""
    title = record["title"] or record["name"]
    numbers = escape(json.dumps(dict(study), indent=1))
    document = (
        f"<details><summary>Every number, in SI units</summary><pre>{numbers}</pre></details>"
    )
    shown = {
        **parts,
        "study": ("Study", "The study", document),
        "record": ("Record", "What was computed, by what", _record_table(record)),
    }
    links = {"answer": "Answer", **{name: link for name, (link, _, _) in shown.items()}}
    sections = [
        head(title, f"{what} by tendon, study {record['study_hash'][:12]}", links),
        section("answer", *answer, "answer"),
        *(section(name, heading, inner) for name, (_, heading, inner) in shown.items()),
    ]
    return html_page(title, sections, data, say.joint_word(study))


def _record_table(record: Mapping[str, Any]) -> str:
    rows = [("study, SHA-256", record["study_hash"])]
    rows += [(f"version of {name}", version) for name, version in record["versions"].items()]
    rows += [(name, record[name]) for name in ("designs", "states", "seconds") if name in record]
    rows += [
        (f"{entry['path']}, {entry['size']} bytes, SHA-256", entry["sha256"])
        for entry in record["files"]
    ]
    return table(("what", "value"), rows)


def _source(script: str) -> str:
    digest = hashlib.sha256(script.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _embedded(data: Mapping[str, Any]) -> str:
    """JSON that ends no script element, whatever text is in it."""
    text = json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


# --- Sections --------------------------------------------------------------------------------------------------------


def section(name: str, heading: str, inner: str, kind: str = "") -> str:
    """A part of the page that its navigation can lead to; `inner` is HTML."""
    return f'<section id="{name}-section" class="{kind}"><h2>{escape(heading)}</h2>\n{inner}</section>\n'


def head(title: str, under: str, links: Mapping[str, str]) -> str:
    """Title and navigation."""
    places = " ".join(
        f'<a href="#{name}-section">{escape(text)}</a>' for name, text in links.items()
    )
    text = f'<h1>{escape(title)}</h1><p class="says">{escape(under)}</p><nav>{places}</nav>'
    return f'<header>{text}</header>\n<p id="fault" role="alert"></p>\n'


def blocks(some: Iterable[Block]) -> str:
    """What is said at length (`say.blocks`), for a screen of any width."""
    parts = []
    for kind, group in itertools.groupby(some, key=lambda block: next(iter(block))):
        contents = [block[kind] for block in group]
        if kind == "item":
            parts.append(f"<ul>{''.join(f'<li>{escape(text)}</li>' for text in contents)}</ul>")
        else:
            parts += [_OF_BLOCKS[kind](content) for content in contents]
    return "".join(parts)


def notes(texts: Sequence[str], kind: str = "note") -> str:
    """What a reader has to know besides, or first, as a warning."""
    return "".join(f'<p class="{kind}">{escape(each)}</p>' for each in texts)


def plot(name: str, label: str) -> str:
    """Where a figure is drawn, with the table of its numbers."""
    return (
        f'<div id="{name}" class="plot" role="img" aria-label="{escape(label)}"></div>'
        f'<details id="{name}-table"><summary>{escape(label)} as a table</summary>'
        '<div class="rows scroll" tabindex="0"></div></details>'
    )


def table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A small table of text."""
    top = "".join(f'<th scope="col" class="left">{escape(each)}</th>' for each in heads)
    top = f"<thead><tr>{top}</tr></thead>" if heads else ""
    body = "".join(
        "<tr>" + "".join(f'<td class="left">{escape(str(cell))}</td>' for cell in row) + "</tr>"
        for row in rows
    )
    return f'<div class="scroll" tabindex="0"><table>{top}<tbody>{body}</tbody></table></div>'


_OF_BLOCKS: dict[str, Callable[[Any], str]] = {
    "heading": lambda text: f"<h3>{escape(text)}</h3>",
    "sentence": lambda text: f"<p>{escape(text)}</p>",
    "note": lambda text: notes([f"Note: {text}"]),
    "table": lambda rows: table(rows[0], rows[1:]),
}

_PLOTS = {
    "map": "The map",
    "states": "States over the elbow angle",
    "windows": "Window of pretension",
    "front": "Choices and their front",
    "people": "Persons served and left out",
    "between": "The window over the elbow angle",
}


def part(name: str) -> str:
    """A figure, or the table, with what steers it (`page/parts.html`)."""
    texts = re.split(r"<!-- (\w+) -->\n", (_PAGE / "parts.html").read_text(encoding="utf-8"))[1:]
    parts = dict(zip(texts[::2], texts[1::2], strict=True))
    return parts[name].replace("{plot}", plot(name, _PLOTS[name]) if name in _PLOTS else "")
