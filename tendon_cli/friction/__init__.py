"""A friction coefficient from the readings of two load cells."""

from tendon_cli.friction.fit import fit_file
from tendon_cli.friction.report import as_json, summary_lines, write_fragment
from tendon_cli.friction.strokes import write_strokes

__all__ = ["as_json", "fit_file", "summary_lines", "write_fragment", "write_strokes"]
