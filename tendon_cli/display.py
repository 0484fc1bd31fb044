"""Text and picture that every result shows in a Python session or a notebook."""

from __future__ import annotations

import sys
from typing import Any

_MOST_LINES = 15


class Displayed:
    """Result with a `text`, whose picture is drawn when it is asked for."""

    @property
    def text(self) -> str:
        """Result in words."""
        raise NotImplementedError

    def plot(self, *what: str, out: Any = None, **how: Any) -> Any:
        """Return the picture of the result, a matplotlib figure.

        Args:
            what: What to draw; `tendon.plot` lists the choices.
            out: File to which the picture is written as well.
            how: Options of `tendon.plot`.

        Raises:
            UsageError: This cannot be drawn.
        """
        return face().plot(self, *what, out=out, **how)

    def __repr__(self) -> str:
        return shortened(self.text)

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        """Return the text with the main picture, for a notebook."""
        from html import escape

        picture = face().picture(self)
        image = ""
        if picture:
            source = f"data:image/png;base64,{picture}"
            image = f'<img alt="" src="{source}" style="max-width: 100%"/>'
        return f'<pre style="font-size: 80%">{escape(repr(self))}</pre>{image}'


def shortened(text: str) -> str:
    """Return the first lines of a text, as a session prints them."""
    lines = text.splitlines()
    if len(lines) <= _MOST_LINES:
        return text
    first = lines[: _MOST_LINES - 1]
    left_out = len(lines) - len(first)
    return "\n".join([*first, f"... {left_out} more lines in .text"])


def face() -> Any:
    """Return the package tendon_cli, by which results reach the functions that draw them.

    Modules of results cannot import those of figures, which import them.
    """
    return sys.modules["tendon_cli"]
