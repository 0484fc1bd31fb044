"""Files that a friction fit writes: a fragment for a study, and a table of strokes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tendon_cli.files import begins_with, write_output
from tendon_cli.fits.friction.fit_result import Fit
from tendon_cli.fits.written import toml_text
from tendon_cli.version import __version__

_STROKES_MARK = "# strokes of a log, by tendon fit-friction"
_MARK = "# A friction coefficient fitted by `tendon fit-friction`."
"""Beginning of a fragment."""
_HEADER = f"""\
{_MARK} To use it in a study:
#     [sheath]
#     friction_from = "friction.toml"
"""
is_fragment = begins_with(_MARK)
"""Function that recognises a fragment."""
is_strokes = begins_with(_STROKES_MARK)
"""Function that recognises a table of strokes."""
_OF_THE_RIG = "# The bend angle is that of the rig, not of the study's sheath.\n"
_OF_ONE_SHEATH = (
    '#     bend_angle = "..."      # not known here: give that of this sheath'
    " when μφ was measured\n"
)


def write_fragment(fit: Fit, path: Path, *, overwrite: bool = False) -> None:
    """Write the coefficient (or μφ) for a study, with its uncertainty and its source.

    The file is written whole or not at all. One that tendon did not write is replaced only if
    `overwrite` is true.

    Raises:
        UsageError: if tendon did not write the file.
        OutputError: if it cannot be written.
    """
    values: dict[str, Any] = {}
    if fit.friction is not None:
        values = {
            "coefficient": fit.friction,
            "standard_error": fit.standard_error,
            "interval_95": fit.interval_95,
            "bend_angle": fit.bend.text,
            "bend_angle_uncertainty": fit.bend.uncertainty_text,
        }
    values |= {
        "friction_bend": fit.friction_bend,
        "friction_bend_standard_error": fit.friction_bend_standard_error,
        "gain_ratio": fit.gain_ratio,
        "source": fit.source,
        "sha256": fit.sha256,
        "rows_used": int(fit.rows["used"].sum()),
        "rows_set_aside": int((~fit.rows["used"]).sum()),
        "tendon_version": __version__,
    }
    lines = [
        f"{key} = {toml_text(value)}" for key, value in values.items() if value not in {None, ""}
    ]
    header = _HEADER + (_OF_ONE_SHEATH if fit.friction is None else _OF_THE_RIG)
    content = "\n".join([header, "[friction]", *lines, ""]).encode()
    write_output(path, content, is_fragment, overwrite=overwrite)


def write_strokes(fit: Fit, path: Path, *, overwrite: bool = False) -> None:
    """Write the table of strokes as CSV.

    A file that tendon did not write is replaced only if `overwrite` is true.

    Raises:
        UsageError: if tendon did not write the file.
        OutputError: if the file cannot be written.
    """
    content = f"{_STROKES_MARK}\n{fit.stroke_table.to_csv(index=False)}".encode()
    write_output(path, content, is_strokes, overwrite=overwrite)
