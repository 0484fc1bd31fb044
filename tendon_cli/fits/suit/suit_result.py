"""Result of a fit to a suit's logs: numbers, how far they can be trusted, and their file."""

from __future__ import annotations

import json
import math
import os
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from tendon_cli import say
from tendon_cli.files import begins_with, write_output
from tendon_cli.fits.suit.fitted_numbers import FittedNumber
from tendon_cli.fits.suit.log_columns import MOTOR_TORQUE, SPOOL_ANGLE
from tendon_cli.fits.suit.parameters import GEAR_EFFICIENCY, loads_of_study
from tendon_cli.fits.suit.stroke_parts import Selection
from tendon_cli.fits.suit.suit_estimate import ChannelMisfit, SuitEstimate
from tendon_cli.fits.suit.suit_window import Doubt, FittedWindow, advice_on, loads_judged
from tendon_cli.fits.written import plain, toml_text
from tendon_cli.say.display import Displayed
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
_WIDTH = 100
_UNUSUAL = 1.0
"""Normal score from which a number that is stated as exact is named in the text."""
_MOST_NAMED = 8


@dataclass(frozen=True, eq=False, repr=False)
class SuitFit(Displayed):
    """Numbers of a suit, fitted to its own logs."""

    estimate: SuitEstimate
    selection: Selection
    fitted: tuple[FittedNumber, ...]
    """Numbers of the study and errors of sensors."""
    channels: Mapping[str, ChannelMisfit]
    """Misfit of each channel."""
    predicted_from: str
    """Group without which each part was predicted: "log" or "third of the strokes"."""
    window: FittedWindow | None
    """Window of the fitted suit at the loads of the logs; None without a fitted pretension."""
    doubts: tuple[Doubt, ...]
    """Numbers that leave most of the doubt in the window, the largest first."""
    rests_on: Mapping[str, Sequence[str]]
    """Fitted numbers that rest on a number as stated, which the logs do not tell, by its key."""
    warnings: tuple[str, ...]
    notes: tuple[str, ...]

    drawn_by: ClassVar[str] = "tendon_cli.face.page_of_suit_fit"

    @property
    def numbers(self) -> dict[str, FittedNumber]:
        """Numbers of the study, by key."""
        return {number.key: number for number in self.fitted if not number.is_sensor}

    @property
    def sensors(self) -> dict[str, FittedNumber]:
        """Errors of sensors, and loads, by name."""
        return {number.key: number for number in self.fitted if number.is_sensor}

    @property
    def used(self) -> int:
        """Number of rows used."""
        return self.selection.used

    @property
    def record(self) -> dict[str, Any]:
        """Fit as plain JSON values, as `--json` prints it; SI."""
        record = {
            "numbers": {key: number.record for key, number in self.numbers.items()},
            "sensors": {key: number.record for key, number in self.sensors.items()},
            "channels": self.channels,
            "predicted_from": self.predicted_from,
            "window": None if self.window is None else self.window.record,
            "rests_on": self.rests_on,
            "next": self.doubts,
            "warnings": self.warnings,
            "notes": self.notes,
            "used": self.used,
            "set_aside": self.selection.set_aside,
            "strokes": self.estimate.strokes,
            "logs": [{"file": log.source, "sha256": log.sha256} for log in self.selection.logs],
        }
        return dict(plain(record))

    @property
    def text(self) -> str:
        """Result in words, about one screen: what is wrong stands before any number."""
        stated = [number for number in self.fitted if number.is_stated]
        untold = [number.key for number in stated if not number.is_told]
        logs = say.counted(len(self.selection.logs), "log")
        strokes = say.counted(self.estimate.strokes, "stroke")
        of_these = f"{len(stated) - len(untold)} of {say.counted(len(stated), 'number')}"
        lines = [f"warning: {text}" for text in self.warnings]
        lines.append(f"{logs}, {strokes}: they determine {of_these} to be fitted")
        lines += _table(stated)
        lines += _lines("assumed", self._assumed())
        if untold:
            ranges = "range" if len(untold) == 1 else "ranges"
            text = f"{say.join_words(untold)}: the logs leave most of the stated {ranges}"
            lines += _lines("not told", [text])
        off = "; ".join(_unusual(self.fitted))
        lines += _lines("off", [off] if off else [])
        texts = [
            f"{_of_channel(channel, misfit)} ({say.percent(misfit.share)} of its swing)"
            for channel, misfit in self.channels.items()
        ]
        others = f"each {self.predicted_from} is predicted from the others"
        lines += _lines("holds?", [f"{others} to within {say.join_words(texts)}"])
        if self.window is not None:
            lines += _lines("window", [self.window.text])
        lines += _lines("helps", self._helps())
        aside = [f"{rows:,} {reason}" for reason, rows in self.selection.set_aside.items()]
        rest = f"; set aside: {', '.join(aside)}" if aside else ""
        lines += _lines("rows", [f"{self.used:,} used{rest}"])
        lines += [f"note: {text}" for text in self.notes]
        return "\n".join(lines)

    def _assumed(self) -> list[str]:
        """Return the numbers as stated on which others rest, and what would tell them."""
        by_key = {number.key: number for number in self.fitted}
        return [
            f"{key} is {by_key[key].prior}, which the logs do not tell; if it is further"
            f" off, so may be {say.join_words(resting)}: {advice_on(key)}"
            for key, resting in self.rests_on.items()
        ]

    def _helps(self) -> list[str]:
        """Return what would tell the numbers that leave most of the doubt in the window."""
        texts = []
        for doubt in self.doubts:
            share = f"{say.number(100.0 * doubt.share, 2)} % of the doubt in the window"
            texts.append(f"{doubt.key} leaves {share}: {doubt.advice}")
        usual = [number.key for number in self.fitted if number.prior.endswith("(usual)")]
        if usual:
            texts.append(
                "what you know better than is usual: state its +/-, or name it as exact under"
                f' [uncertainty], such as exact = ["{usual[0]}"]'
            )
        return texts


def _of_channel(channel: str, misfit: ChannelMisfit) -> str:
    """Return the misfit of a channel with its unit."""
    name = "torque" if channel == MOTOR_TORQUE else say.spaced(channel)
    if channel == SPOOL_ANGLE:
        return f"{say.number(math.degrees(misfit.predicted_rms), 2)} deg of {name}"
    return f"{say.number(misfit.predicted_rms, 2)} {misfit.unit} of {name}"


def _table(numbers: Sequence[FittedNumber]) -> list[str]:
    """Return the lines of the numbers that were asked for."""
    cells = [("", "fitted", "95 % interval", "stated", "learned")]
    for number in numbers:
        low, high = number.interval_95
        cells.append(
            (
                number.key,
                number.text(number.value),
                f"{number.text(low)} to {number.text(high)}",
                number.prior,
                say.percent(number.learned),
            )
        )
    widths = [max(len(row[column]) for row in cells) for column in range(len(cells[0]))]
    return [
        "  "
        + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in cells
    ]


def _unusual(numbers: Sequence[FittedNumber]) -> list[str]:
    """Return numbers that were not asked for and come out far from what is stated."""
    found = sorted(
        (
            number
            for number in numbers
            if not number.is_stated
            and number.log is None
            and number.key != GEAR_EFFICIENCY
            and abs(number.score) >= _UNUSUAL
        ),
        key=lambda number: -abs(number.score),
    )
    return [
        f"{number.key} {number.text(number.value)}, stated {number.prior}"
        for number in found[:_MOST_NAMED]
    ]


def _lines(name: str, texts: Sequence[str]) -> list[str]:
    """Return texts behind their name, wrapped."""
    lines = []
    for place, text in enumerate(texts):
        lines += say.wrap(text, f"  {'' if place else name:<10}", _WIDTH, " " * 12)
    return lines


# --- The file of fitted numbers ------------------------------------------------------------------


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
