"""Results as text."""

from __future__ import annotations

from typing import Any


def text_of(result: Any) -> str:
    """What `result.text` is of a run, which has tables, or a fit; a command loads nothing that draws for it."""
    if hasattr(result, "tables"):
        from tendon_cli.summary import run_text

        return run_text(result)
    from tendon_cli.friction import summary_lines

    return summary_lines(result)
