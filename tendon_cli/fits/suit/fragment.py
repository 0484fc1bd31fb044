"""File of a suit's fitted numbers for a study: values, laws and correlations."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.files import begins_with, write_output
from tendon_cli.fits.suit.fitted_numbers import FittedNumber
from tendon_cli.fits.suit.parameters import loads_of_study
from tendon_cli.fits.suit.suit_result import SuitFit
from tendon_cli.fits.suit.suit_window import loads_judged
from tendon_cli.fits.written import toml_text
from tendon_cli.version import __version__

_MARK = "# Numbers of a suit fitted by `tendon fit-suit`."
_HEADER = f"""\
{_MARK} To use them in a study, at its top:
#     fitted_from = "fit.toml"
"""
is_suit_fragment = begins_with(_MARK)
"""Function that recognises a file of fitted numbers."""
_KEEPS_RANGE = 0.3
"""Share of the prior's variance under which a number keeps its stated range."""
_NOT_OF_THE_SUIT = ("load.",)
"""Tables of numbers that a log states, and that are no part of the suit."""


def next_command(fit: SuitFit, study: Path, settings: Sequence[str], out: Path) -> str:
    """Return the command that finds the window of the fitted suit, as a shell takes it.

    Args:
        fit: The fit.
        study: File of its study.
        settings: Changes of the study that were given, such as `load.mass="3 kg"`.
        out: File that the fit is written to.
    """
    named = os.path.relpath(out.absolute(), study.absolute().parent)
    changes = [*settings, f"fitted_from={json.dumps(named, ensure_ascii=False)}"]
    loads = loads_judged(fit.estimate)
    if len(loads) > 1 and len(loads_of_study(fit.estimate.model.study)) == 1:
        listed = ", ".join(f'"{say.number(load, 6)} kg"' for load in loads.tolist())
        changes.append(f"load.mass=[{listed}]")
    words = ["tendon", "design", str(study)]
    for change in changes:
        words += ["--set", change]
    return shlex.join([*words, "--out", f"results/{out.stem}-design"])


def write_suit_fragment(fit: SuitFit, path: Path, *, overwrite: bool = False) -> None:
    """Write the fitted numbers with their covariance, the file whole or not at all.

    Raises:
        UsageError: if tendon did not write the file that is there, and `overwrite` is not true.
        OutputError: if it cannot be written.
    """
    content = suit_fragment(fit).encode()
    write_output(path, content, is_suit_fragment, overwrite=overwrite)


def suit_fragment(fit: SuitFit) -> str:
    """Return the content of the file."""
    places = [
        place
        for place, number in enumerate(fit.fitted)
        if not number.is_sensor and not number.key.startswith(_NOT_OF_THE_SUIT)
    ]
    covariance = fit.estimate.covariance[np.ix_(places, places)]
    deviation = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviation, deviation)
    kept = [fit.fitted[place] for place in places]
    std = np.array([number.std for number in kept])
    lines = [
        _HEADER,
        "[fit]",
        f"logs = {toml_text([log.source for log in fit.selection.logs])}",
        f"sha256 = {toml_text([log.sha256 for log in fit.selection.logs])}",
        f"strokes = {fit.estimate.strokes}",
        f"warnings = {toml_text(fit.warnings)}",
        f'tendon_version = "{__version__}"',
        "",
        "[numbers]  # SI; learned: share of the prior's variance that the logs took away",
        *(f'"{number.key}" = {_law(number)}' for number in kept),
        "",
        "[covariance]  # SI, in the order of keys",
        f"keys = {toml_text([number.key for number in kept])}",
        f"matrix = {_rows(correlation * np.outer(std, std))}",
        "",
    ]
    return "\n".join(lines)


def _law(number: FittedNumber) -> str:
    """Return value and deviation of a number as an inline table.

    A number that keeps its range has the two ends of it instead.
    """
    law = number.law
    values: dict[str, Any] = {"value": number.value, "std": number.std}
    if law.kind == "uniform" and number.learned < _KEEPS_RANGE:
        values = {"from": law.middle - law.spread, "to": law.middle + law.spread}
    values["learned"] = round(number.learned, 4)
    return "{ " + ", ".join(f"{name} = {value!r}" for name, value in values.items()) + " }"


def _rows(matrix: Any) -> str:
    """Return a matrix in TOML, a line for each row."""
    rows = (", ".join(f"{value:.12g}" for value in row) for row in matrix)
    return "[\n" + "".join(f"  [{row}],\n" for row in rows) + "]"
