"""Result of a fit to a suit's logs: the numbers, and how far they can be trusted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from tendon_cli import say
from tendon_cli.fits.suit.fitted_numbers import FittedNumber
from tendon_cli.fits.suit.log_columns import MOTOR_TORQUE, SPOOL_ANGLE
from tendon_cli.fits.suit.parameters import GEAR_EFFICIENCY
from tendon_cli.fits.suit.stroke_parts import Selection
from tendon_cli.fits.suit.suit_estimate import ChannelMisfit, SuitEstimate
from tendon_cli.fits.suit.suit_window import Doubt, FittedWindow, advice_on
from tendon_cli.fits.written import plain
from tendon_cli.say.display import Displayed

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
