"""The fitted coefficient as a small TOML file that a study takes by `[sheath] friction_from = "friction.toml"`."""

from __future__ import annotations

import json
from pathlib import Path

from tendon_cli.files import write_whole
from tendon_cli.friction.result import Fit
from tendon_cli.version import __version__

MARK = "# A friction coefficient fitted by `tendon fit-friction`."
"""The first line of a fragment; a file without it is nobody's to write over."""
_HEADER = """\
# A friction coefficient fitted by `tendon fit-friction`. A study takes it by
#     [sheath]
#     friction_from = "friction.toml"
# The bend angle is that of the rig, not of the study's sheath.
"""


def fragment_text(fit: Fit) -> str:
    """The fragment: the coefficient, how far it can be trusted, and where it comes from."""
    low, high = fit.uncertainty.interval_95
    values = {
        "coefficient": repr(fit.friction),
        "standard_error": repr(fit.uncertainty.standard_error),
        "interval_95": f"[{low!r}, {high!r}]",
        "bend_angle": _quoted(fit.bend_angle_text),
        "bend_angle_uncertainty": _quoted(fit.bend_angle_uncertainty_text) if fit.bend_angle_uncertainty_text else None,
        "gain_ratio": repr(fit.gain_ratio),
        "source": _quoted(fit.source),
        "sha256": _quoted(fit.sha256),
        "rows_used": str(int(fit.rows.used.sum())),
        "rows_set_aside": str(int((~fit.rows.used).sum())),
        "tendon_version": _quoted(__version__),
    }
    lines = [f"{key} = {value}" for key, value in values.items() if value is not None]
    return "\n".join([_HEADER, "[friction]", *lines, ""])


def write_fragment(fit: Fit, path: Path) -> None:
    """Write the fragment, whole or not at all; raises OutputError."""
    write_whole(path, fragment_text(fit).encode())


def _quoted(text: str) -> str:
    """A TOML basic string; its escapes are those of JSON, and the one JSON leaves out (DEL) is written too."""
    return json.dumps(text.encode("utf-8", "replace").decode(), ensure_ascii=False).replace("\x7f", "\\u007f")
