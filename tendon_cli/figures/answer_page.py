"""Pages of an answer's figures, and what they read from its record.

The choice named first is said by what the gauges show, with the pretension behind it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.choice_grid import value_text
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import reading, reading_unit
from tendon_cli.figures.backend import Line2D
from tendon_cli.figures.frame import Page, framed, source_of
from tendon_cli.figures.layout import is_of_rows
from tendon_cli.figures.scales import off_default
from tendon_cli.figures.style import PAGE_WIDTH, STAR, key_line
from tendon_cli.studies.space.axis import Axis
from tendon_cli.verbs.answer_record import AnswerRecord, ChoiceRecord, value_of


def answer_page(
    cube: Cube,
    record: AnswerRecord,
    title: str,
    panels: float,
    key: Sequence[Any],
    notes: Sequence[str],
    *,
    subtitle: str = "",
    width: float = PAGE_WIDTH,
    height: float | None = None,
) -> Page:
    """Begin a page of an answer's figure.

    Below the notes it says which values of the study are not the default.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        title: Title after the name of the study.
        panels: Height of the panels, mm.
        key: Artists with a label.
        notes: Sentences below the panels.
        subtitle: Second title, which may hold formulas.
        width: Width of the page, mm.
        height: Height of the page, mm; None for one that fits.
    """
    lines = [*notes]
    # An answer chooses its pretensions, whichever the study has for its designs.
    told = [*(axis.column for axis in cube.axes), "pretension"]
    given = off_default(cube.study, told, {})
    if given:
        tables = [say.spaced(axis.key) for axis in cube.axes if is_of_rows(axis)]
        rest = "all else by default"
        if tables:
            word = "table" if len(tables) == 1 else "tables"
            rest = f"all else from the {word} {say.join_words(tables)}, or by default"
        lines.append(f"With {', '.join(given)}; {rest}.")
    name = record.title or record.name
    whole = f"{name}: {title}"
    return framed(
        whole,
        panels,
        key,
        lines,
        study=source_of(record),
        subtitle=subtitle,
        width=width,
        height=height,
    )


def gauge_text(record: AnswerRecord, choice: ChoiceRecord) -> str:
    """Say what the gauges show if a choice is set; empty if this is not known.

    >>> gauge_text(record, choice)  # doctest: +SKIP
    '108.7 N in the flexor, 72.3 N in the extensor (F₀ = 83.74 N)'
    """

    def shown(name: str) -> str | None:
        value = value_of(choice, name)
        return None if value is None else say.quantity(name, value, record.question.setting_digits)

    flexor = shown("set_flexor_tension")
    extensor = shown("set_extensor_tension")
    if flexor is None or extensor is None:
        return ""
    pretension = shown("pretension") if record.question.read == "pretension" else None
    behind = "" if pretension is None else f" (F₀ = {pretension})"
    return f"{flexor} in the flexor, {extensor} in the extensor{behind}"


def set_text(cube: Cube, record: AnswerRecord, choice: ChoiceRecord) -> str:
    """Describe a choice by its values, and say what the gauges show, or else what is read."""
    text = choice_text(cube, choice)
    set_to = gauge_text(record, choice)
    if not set_to and choice.pretension is not None:
        value = f"{say.number(choice.pretension)} {reading_unit(cube.document)}"
        words = reading(cube.document)
        set_to = f"F₀ = {value}" if words == "pretension" else f"{value} of {words}"
    return ": ".join(part for part in (text, set_to) if part)


def star(label: str) -> Line2D:
    """Return the star that marks the choice named first, for the key."""
    return key_line(label=label, **STAR)


def is_settable(record: AnswerRecord, length: ColumnArray, half: ColumnArray) -> ColumnArray:
    """Return True where a window is wide enough for the accuracy of setting.

    Args:
        record: Record of the answer.
        length: Tolerances as a length of both tendons, m; infinite without an upper end.
        half: Half the windows, N.
    """
    question = record.question
    accuracy = question.accuracy
    with np.errstate(invalid="ignore"):
        if accuracy.tension is not None:
            return np.asarray(half >= question.needed * accuracy.tension)
        return np.asarray(length >= question.needed * (accuracy.length or 0.0))


def settable_label(record: AnswerRecord) -> str:
    """Say what it takes to be set well enough: "can be set well enough (± 6 mm)"."""
    return f"can be set well enough (± {say.tolerance_that_is_enough(record.question)})"


def choice_text(cube: Cube, choice: ChoiceRecord) -> str:
    """Describe a choice by its values."""
    return ", ".join(value_text(cube, axis, value_of(choice, axis.column)) for axis in cube.axes)


def long_axes(cube: Cube) -> list[Axis]:
    """Return the axes of more than one value."""
    return [axis for axis in cube.axes if axis.length > 1]
