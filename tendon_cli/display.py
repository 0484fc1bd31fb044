"""What every result shows of itself in Python: a text, a picture, and both in a notebook."""

from __future__ import annotations

import sys
from typing import Any

_MOST_LINES = 15


class Displayed:
    """A result with `text` and `record`, whose picture is drawn when it is asked for."""

    @property
    def text(self) -> str:
        """The result in words."""
        raise NotImplementedError

    def plot(self, *what: str, out: Any = None, **how: Any) -> Any:
        """The picture of it, a matplotlib figure; written to the file `out`, too, if that is given.

        What can be chosen stands in `tendon.plot`. Raises UsageError for what cannot be drawn.
        """
        return face().plot(self, *what, out=out, **how)

    def __repr__(self) -> str:
        return shortened(self.text)

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        """The text with the main picture, for a notebook."""
        from html import escape

        picture = face().picture(self)
        image = (
            f'<img alt="" src="data:image/png;base64,{picture}" style="max-width: 100%"/>'
            if picture
            else ""
        )
        return f'<pre style="font-size: 80%">{escape(repr(self))}</pre>{image}'


def shortened(text: str) -> str:
    """The first lines of a text, as a session prints them."""
    lines = text.splitlines()
    if len(lines) <= _MOST_LINES:
        return text
    return "\n".join(
        [*lines[: _MOST_LINES - 1], f"... {len(lines) - _MOST_LINES + 1} more lines in .text"]
    )


def face() -> Any:
    """The package itself, which Python has loaded before any of its modules: what draws lies above what is drawn."""
    return sys.modules["tendon_cli"]
