"""A page from its data: text escaped, scripts allowed by their hashes alone, nothing fetched."""

from __future__ import annotations

import base64
import hashlib
import itertools
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from tendon_cli import say
from tendon_cli.say import Block

_SCRIPTS = ("base", "map", "states", "table", "answers", "start")
MARK = '<meta name="generator" content="tendon">'
"""What tells a page of ours, near its beginning."""

_PLOTLY = "plotly-cartesian-4.1.1.min.js"


def html_page(title: str, sections: Sequence[str], data: Mapping[str, Any], joint: str = "elbow") -> str:
    """The whole file: `sections` are HTML, `data` is what the scripts draw, `joint` the word for the study's joint."""
    page = files("tendon_cli.reports") / "page"
    code = "\n".join((page / f"{name}.js").read_text(encoding="utf-8") for name in _SCRIPTS)
    library = (files("tendon_cli.reports") / "plotly" / _PLOTLY).read_text(encoding="utf-8")
    policy = f"default-src 'none'; script-src {_source(library)} {_source(code)}; "
    policy += "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
{MARK}
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>{(page / "page.css").read_text(encoding="utf-8")}</style>
</head>
<body>
<main>
{say.of_joint("".join(sections), joint)}
</main>
<script type="application/json" id="data">{say.of_joint(_embedded(data), joint)}</script>
<script>{library}</script>
<script>{code}</script>
</body>
</html>
"""


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
    places = "".join(f'<a href="#{name}-section">{escape(text)}</a>' for name, text in links.items())
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


def notes(texts: Sequence[str]) -> str:
    """What a reader has to know besides."""
    return "".join(f'<p class="note">{escape(each)}</p>' for each in texts)


def folded(summary: str, text: str) -> str:
    """Long text, shown when it is asked for."""
    return f"<details><summary>{escape(summary)}</summary><pre>{escape(text)}</pre></details>"


def warnings(texts: Sequence[str]) -> str:
    """What a reader has to know first."""
    return "".join(f'<p class="warning">Warning: {escape(each)}</p>' for each in texts)


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
        "<tr>" + "".join(f'<td class="left">{escape(str(cell))}</td>' for cell in row) + "</tr>" for row in rows
    )
    return f'<div class="scroll" tabindex="0"><table>{top}<tbody>{body}</tbody></table></div>'


_OF_BLOCKS: dict[str, Callable[[Any], str]] = {
    "heading": lambda text: f"<h3>{escape(text)}</h3>",
    "sentence": lambda text: f"<p>{escape(text)}</p>",
    "note": lambda text: notes([f"Note: {text}"]),
    "table": lambda rows: table(rows[0], rows[1:]),
}

MAP = (
    '<div id="choosers" class="controls"></div><div id="sliders" class="controls"></div>'
    '<div id="map-frame" tabindex="0" role="application" aria-describedby="map-help" '
    'aria-label="Map with a cell cursor">'
    f'{plot("map", "The map")}</div><p id="map-key"></p>'
    '<p id="map-help" class="says">Hover for values; a click, or the arrow keys and Enter, show the states of a '
    "design.</p>"
    '<p id="map-says" class="says" aria-live="polite"></p>'
)

STATES = (
    '<p id="design-says" aria-live="polite"></p><div class="two"><div><div id="groups" class="controls"></div>'
    f"{plot('states', 'States over the elbow angle')}</div><div>"
    '<label class="slider">Elbow angle <input type="range" id="angle" min="0" value="0">'
    '<output id="angle-says"></output></label>'
    '<div id="arm"></div><ul id="arm-values"></ul></div></div>'
)

_MARKED = '<label><input type="checkbox" id="brushed-only"> marked on the front only</label>'
TABLE = (
    '<div class="controls"><label>Filter <input id="filter" placeholder="margin &gt; 5 N; load mass = 3 kg"></label>'
    f"{_MARKED}</div>"
    '<p id="filter-fault" role="alert"></p><p id="list-says" class="says" aria-live="polite"></p>'
    '<div id="list" class="scroll" tabindex="0"></div><button type="button" id="more">Show more</button>'
)

WINDOWS = plot("windows", "Window of pretension")

TABLE_WITHOUT_FRONT = TABLE.replace(_MARKED, "")

FRONT = (
    '<div id="front-axes" class="controls"></div>'
    + plot("front", "Choices and their front")
    + '<div class="controls">Mark choices'
    + "".join(
        f'<label>{axis} from <input class="bound" type="number" step="any" id="brush-{axis}-low"></label>'
        f'<label>to <input class="bound" type="number" step="any" id="brush-{axis}-high"></label>'
        for axis in ("x", "y")
    )
    + '</div><p id="brush-says" class="says" aria-live="polite">Nothing is marked.</p>'
)

PEOPLE = plot("people", "Persons served and left out")

BETWEEN = '<p id="between-says" class="says"></p>' + plot("between", "The window over the elbow angle")
