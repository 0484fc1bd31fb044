"""A page of a text with pictures: one HTML file that fetches nothing."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

from tendon_cli.files import write_output
from tendon_cli.reports import html
from tendon_cli.reports.data import page_data
from tendon_cli.reports.report import is_page
from tendon_cli.say import Block


class Picture(NamedTuple):
    """A picture of a page."""

    caption: str
    png: bytes
    """The picture; empty if there is only the caption."""


def write_text_page(
    path: Path,
    title: str,
    subtitle: str,
    blocks: Iterable[Block],
    pictures: Sequence[Picture],
    joint: str,
    *,
    overwrite: bool = False,
) -> Path:
    """Write a page of a text with pictures.

    Args:
        path: File to write.
        title: Title of the page.
        subtitle: Sentence below it.
        blocks: The text.
        pictures: The pictures.
        joint: Word for the study's joint.
        overwrite: True to replace a file that tendon did not write.

    Raises:
        UsageError: The file exists and is not a page that tendon wrote.
        OutputError: The page cannot be written.
    """
    links = {"pictures": "Figures", "text": "Text"}
    sections = [
        html.head(title, subtitle, links),
        html.section("pictures", "Figures", "".join(map(_figure, pictures))),
        html.section("text", "In words", html.blocks(blocks), "answer"),
    ]
    page = html.html_page(title, sections, page_data(), joint)
    write_output(path, page.encode(), is_page, overwrite=overwrite)
    return path


def _figure(picture: Picture) -> str:
    """Return a picture with its caption as HTML."""
    caption = f"<figcaption>{escape(picture.caption)}</figcaption>"
    if not picture.png:
        return f"<figure>{caption}</figure>"
    data = base64.b64encode(picture.png).decode("ascii")
    image = f'<img src="data:image/png;base64,{data}" alt="{escape(picture.caption)}">'
    return f"<figure>{image}{caption}</figure>"
