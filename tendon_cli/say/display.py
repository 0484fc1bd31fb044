"""Text and picture that every result shows in a Python session or a notebook."""

from __future__ import annotations

from os import PathLike
from typing import Any, ClassVar

from tendon_cli.errors import UsageError
from tendon_cli.verbs.registry import load

_MOST_LINES = 15


class Displayed:
    """Result with a `text`, whose picture is drawn when it is asked for.

    Results lie below the figures, which import them. So a class of results names the function that
    draws it in `drawn_by`, and `plot` imports that function when somebody wants a picture: this is
    the only way from a result up to its figures.
    """

    drawn_by: ClassVar[str] = ""
    """Full dotted name of the function that draws the result as a `Page`; empty without one.

    It takes the result, what to draw, and the options of `plot`, and raises UsageError.
    """

    documented: ClassVar[tuple[str, ...]] = ()
    """Names besides `plot`, `record` and `text` that the page about Python has, and so a session
    completes."""

    def __dir__(self) -> list[str]:
        return sorted(["plot", "record", "text", *self.documented])

    @property
    def text(self) -> str:
        """Result in words."""
        raise NotImplementedError

    @property
    def short(self) -> str:
        """Result in few lines, as a command or a session shows it."""
        return self.text

    @property
    def is_pictured(self) -> bool:
        """True if a notebook draws the result without being asked."""
        return True

    def plot(
        self,
        *what: str,
        out: str | PathLike[str] | None = None,
        overwrite: bool = False,
        **how: Any,
    ) -> Any:
        """Return the picture of the result, a matplotlib figure.

        Args:
            what: What to draw; `tendon.plot` lists the choices.
            out: File to which the picture is written as well.
            overwrite: True to replace a file that tendon did not write.
            how: Options of `tendon.plot`.

        Raises:
            UsageError: This cannot be drawn, or tendon did not write the file.
        """
        if not self.drawn_by:
            raise UsageError("this result has no picture")
        return load(self.drawn_by)(self, what, how).shown(out, overwrite=overwrite)

    def __repr__(self) -> str:
        return shortened(self.short)

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        """Return the text with the main picture, for a notebook."""
        from html import escape

        picture = self._picture()
        image = ""
        if picture:
            source = f"data:image/png;base64,{picture}"
            image = f'<img alt="" src="{source}" style="max-width: 100%"/>'
        return f'<pre style="font-size: 80%">{escape(repr(self))}</pre>{image}'

    def _picture(self) -> str:
        """Return the main picture of the result, a PNG in base64; empty if it has none."""
        from base64 import b64encode

        if not self.is_pictured:
            return ""
        try:
            return b64encode(load(self.drawn_by)(self, (), {}).png()).decode()
        except Exception:  # noqa: BLE001 - the text is shown whatever happens to the picture
            return ""


def shortened(text: str) -> str:
    """Return the first lines of a text, as a session prints them."""
    lines = text.splitlines()
    if len(lines) <= _MOST_LINES:
        return text
    first = lines[: _MOST_LINES - 1]
    left_out = len(lines) - len(first)
    return "\n".join([*first, f"... {left_out} more lines in .text"])
