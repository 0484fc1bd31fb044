"""Write a choice of an answer for the next tool: MuJoCo, a controller, or a list of numbers."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import BinaryIO, NamedTuple

from tendon_cli.answers.answer import Answer
from tendon_cli.errors import UsageError
from tendon_cli.exports.chosen import ChosenSuit
from tendon_cli.exports.csv_files import (
    CONTROLLER_MARK,
    PARAMETERS_MARK,
    controller_csv,
    parameters_csv,
)
from tendon_cli.exports.mujoco import MARK
from tendon_cli.exports.mujoco_suit import suit_xml
from tendon_cli.exports.order_list import ORDER_MARK, order_csv
from tendon_cli.files import Recogniser, begins_with, result_path, write_output
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.units import described, shorten
from tendon_cli.verbs.call_options import check_types


class ExportForm(NamedTuple):
    """A form in which an answer is exported."""

    suffix: str
    """Ending of the file."""
    is_ours: Recogniser
    """Function that recognises a file of this form that tendon wrote."""
    text: Callable[[ChosenSuit], str]
    """Function that returns the content of the file."""


def _is_controller_table(file: BinaryIO) -> bool:
    """Return True if tendon wrote a table for a controller: its first head may be in quotes."""
    beginning = file.read(len(CONTROLLER_MARK) + 2).replace(b'"', b"")
    return beginning.startswith(CONTROLLER_MARK.encode())


FORMS = {
    "mujoco": ExportForm(".xml", begins_with(MARK), suit_xml),
    "controller": ExportForm(".csv", _is_controller_table, controller_csv),
    "parameters": ExportForm(".csv", begins_with(PARAMETERS_MARK), parameters_csv),
    "parts": ExportForm(".csv", begins_with(ORDER_MARK), order_csv),
}
"""Forms by their names."""


def export_answer(
    answer: Answer,
    to: str,
    out: str | PathLike[str],
    *,
    choice: int | None = None,
    overwrite: bool = False,
) -> Path:
    """Write a choice of an answer for the next tool.

    Args:
        answer: The answer.
        to: "mujoco", "controller", "parameters", or "parts" for an order list.
        out: File to write.
        choice: Row of the choice; None for the one that the answer names first.
        overwrite: True to replace a file that tendon did not write.

    Returns:
        Path of the file.

    Raises:
        UsageError: There is no such form or choice, the ending is another one, or tendon did not
            write the file.
        InputError: A table of the answer is damaged.
        OutputError: The file cannot be written.
    """
    given = {"to": to, "choice": choice, "overwrite": overwrite}
    check_types("export", given, export_answer.__annotations__)
    form = FORMS.get(to)
    if form is None:
        hint = hint_at_nearest(to, FORMS) or f"expected {', '.join(FORMS)}"
        raise UsageError(f"{described(to)} is not a form of export", where="--to", hint=hint)
    path = result_path(out)
    if path.suffix.lower() != form.suffix:
        problem = f'"{shorten(path.name)}" does not end in {form.suffix}'
        raise UsageError(problem, where=f"--to {to}", hint=f"such as suit{form.suffix}")
    text = form.text(ChosenSuit.of(answer, choice))
    write_output(path, text.encode(), form.is_ours, overwrite=overwrite)
    return path
