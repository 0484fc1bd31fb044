"""Build a page from its data: text escaped, scripts allowed by hash, nothing fetched."""

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
"""Element near the beginning of every page that tendon writes."""

_LONGEST_LIST = 100
"""Most items of a list of the study that the page prints."""
_PLOTLY = "plotly-cartesian-4.1.1.min.js"


def html_page(
    title: str, sections: Sequence[str], data: Mapping[str, Any], joint: str = "elbow"
) -> str:
    """Return a page as the text of one file.

    Args:
        title: Title, not yet escaped.
        sections: Contents, HTML.
        data: What the scripts draw, as `page_data` returns it.
        joint: Word for the study's joint.
    """
    code = "\n".join(_page_file(f"{name}.js") for name in _SCRIPTS)
    library = (files("tendon_cli.reports") / "plotly" / _PLOTLY).read_text(encoding="utf-8")
    return _page_file("page.html").format(
        mark=MARK,
        scripts=f"{_hash_source(library)} {_hash_source(code)}",
        title=escape(title),
        library=library,
        code=code,
        style=_page_file("page.css"),
        sections=say.name_joint("".join(sections), joint),
        data=say.name_joint(_embedded(data), joint),
    )


def _page_file(name: str) -> str:
    """Read one of the files that every page is made of."""
    return (_PAGE / name).read_text(encoding="utf-8")


Part = tuple[str, str, str]
"""A part of a page: text of its link, heading, and HTML."""


def result_page(
    record: Mapping[str, Any],
    kind: str,
    answer: tuple[str, str],
    parts: Mapping[str, Part],
    study: Mapping[str, Any],
    data: Mapping[str, Any],
) -> str:
    """Return the page of a run or an answer, with its study and its record at the end.

    Args:
        record: Record of the run or the answer.
        kind: Noun for the subtitle: "a sweep" or "an answer".
        answer: Heading and HTML of the first section.
        parts: Figures and table by name, in their order.
        study: The resolved study.
        data: What the scripts draw, as `page_data` returns it.
    """
    title = record["title"] or record["name"]
    numbers = escape(json.dumps(_without_long_lists(dict(study)), indent=1))
    document = (
        f"<details><summary>Every number, in SI units</summary><pre>{numbers}</pre></details>"
    )
    all_parts = {
        **parts,
        "study": ("Study", "The study", document),
        "record": ("Record", "What was computed, by what", _record_table(record)),
    }
    links = {"answer": "Answer"}
    sections = [section("answer", *answer, "answer")]
    for name, (link, heading, inner) in all_parts.items():
        links[name] = link
        sections.append(section(name, heading, inner))
    subtitle = f"{kind} by tendon, study {record['study_hash'][:12]}"
    return html_page(title, [head(title, subtitle, links), *sections], data, say.joint_name(study))


def _without_long_lists(content: Any) -> Any:
    """Return the document of a study with the first items of long lists, and a word on the rest."""
    if isinstance(content, dict):
        return {name: _without_long_lists(item) for name, item in content.items()}
    if not isinstance(content, list):
        return content
    items = [_without_long_lists(item) for item in content[:_LONGEST_LIST]]
    more = len(content) - len(items)
    return [*items, f"… and {more:,} more"] if more else items


def _record_table(record: Mapping[str, Any]) -> str:
    """Return the table of what was computed, by which versions, into which files."""
    rows = [("study, SHA-256", record["study_hash"])]
    rows += [(f"version of {name}", version) for name, version in record["versions"].items()]
    rows += [(name, record[name]) for name in ("designs", "states", "seconds") if name in record]
    for file in record["files"]:
        rows.append((f"{file['path']}, {file['size']} bytes, SHA-256", file["sha256"]))
    return table(("what", "value"), rows)


def _hash_source(script: str) -> str:
    """Return the source expression that allows a script by its hash in the content policy."""
    digest = hashlib.sha256(script.encode()).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _embedded(data: Mapping[str, Any]) -> str:
    """Return JSON that cannot end a script element, whatever text is in it."""
    text = json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


# --- Sections -------------------------------------------------------------------------------------


def section(name: str, heading: str, inner: str, kind: str = "") -> str:
    """Return a section with a heading, to which the navigation can link; `inner` is HTML."""
    return (
        f'<section id="{name}-section" class="{kind}"><h2>{escape(heading)}</h2>\n'
        f"{inner}</section>\n"
    )


def head(title: str, subtitle: str, links: Mapping[str, str]) -> str:
    """Return the title and the navigation; `links` has the text of the link to each section."""
    anchors = " ".join(
        f'<a href="#{name}-section">{escape(text)}</a>' for name, text in links.items()
    )
    text = f'<h1>{escape(title)}</h1><p class="says">{_escaped(subtitle)}</p><nav>{anchors}</nav>'
    return f'<header>{text}</header>\n<p id="fault" role="alert"></p>\n'


def _escaped(text: str) -> str:
    """Return a text as HTML; no line ends between a number and its unit."""
    return escape(say.unbroken(text))


def _breakable(text: str) -> str:
    """Return a text as HTML in which the name of a column may be broken between its words."""
    return re.sub(r"(?<=[a-z])([_.])(?=[a-z])", r"\1<wbr>", _escaped(text))


def blocks(contents: Iterable[Block]) -> str:
    """Return blocks of text (`say.Block`) as HTML for a screen of any width."""
    parts = []
    for kind, group in itertools.groupby(contents, key=lambda block: next(iter(block))):
        bodies = [block[kind] for block in group]
        if kind == "item":
            items = "".join(f"<li>{_escaped(text)}</li>" for text in bodies)
            parts.append(f"<ul>{items}</ul>")
        else:
            parts += [_HTML_OF_BLOCK[kind](body) for body in bodies]
    return "".join(parts)


def folded(summary: str, inner: str) -> str:
    """Return HTML that opens below a line of text."""
    return f"<details><summary>{escape(summary)}</summary>\n{inner}</details>\n"


def notes(texts: Sequence[str], kind: str = "note") -> str:
    """Return a paragraph for each text, set as a note or as a warning."""
    return "".join(f'<p class="{kind}">{_escaped(text)}</p>' for text in texts)


def plot(name: str, label: str) -> str:
    """Return the empty element of a figure, with a table of its numbers that can be opened."""
    return (
        f'<div id="{name}" class="plot" role="img" aria-label="{escape(label)}"></div>'
        f'<details id="{name}-table"><summary>{escape(label)} as a table</summary>'
        '<div class="rows scroll" tabindex="0"></div></details>'
    )


def table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a small table of text; without `heads` it has no head."""
    top = ""
    if heads:
        cells = "".join(f'<th scope="col" class="left">{escape(text)}</th>' for text in heads)
        top = f"<thead><tr>{cells}</tr></thead>"
    body = ""
    for row in rows:
        cells = "".join(f'<td class="left">{_breakable(str(cell))}</td>' for cell in row)
        body += f"<tr>{cells}</tr>"
    return f'<div class="scroll" tabindex="0"><table>{top}<tbody>{body}</tbody></table></div>'


_HTML_OF_BLOCK: dict[str, Callable[[Any], str]] = {
    "heading": lambda text: f"<h3>{escape(text)}</h3>",
    "sentence": lambda text: f"<p>{_escaped(text)}</p>",
    "note": lambda text: notes([f"Note: {text}"]),
    "command": lambda text: f"<pre>{escape(text)}</pre>",
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


_PLOTS_IN_TIME = {"states": "States over time", "between": "The window over time"}
"""Names of figures that are over time where the motion is."""


def part(name: str, *, is_in_time: bool = False) -> str:
    """Return a figure or the table, with its controls, from `page/parts.html`.

    Args:
        name: Name of the part.
        is_in_time: True if the motion of the study is one in time.
    """
    _, *texts = re.split(r"<!-- (\w+) -->\n", _page_file("parts.html"))
    parts = dict(zip(texts[::2], texts[1::2], strict=True))
    labels = _PLOTS | _PLOTS_IN_TIME if is_in_time else _PLOTS
    figure = plot(name, labels[name]) if name in labels else ""
    return parts[name].replace("{plot}", figure)
