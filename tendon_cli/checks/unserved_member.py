"""One person or draw that an answer does not serve: why, and the command that shows it."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import Any

from tendon_cli import say
from tendon_cli.answer_record import ChoiceRecord, QuestionRecord, value_of
from tendon_cli.answers import phrases
from tendon_cli.answers.answer import Answer
from tendon_cli.answers.paired import UnservedMember
from tendon_cli.checks.comparison_record import UnservedRecord
from tendon_cli.errors import TendonError
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.axis_words import parameter
from tendon_cli.studies.contents import keys
from tendon_cli.studies.load import load_study
from tendon_cli.studies.value_words import quantity_of

_DIGITS = 6
"""Significant digits of a number that a command sets."""


def unserved_by_name(answer: Answer, choice: ChoiceRecord, table: str, name: str) -> UnservedRecord:
    """Say why a person or a draw of an answer's own sample is not served, and how to look at it.

    Args:
        answer: The answer that does not serve it.
        choice: Choice of the answer.
        table: "persons" or "draws".
        name: Its name.
    """
    question: QuestionRecord = answer.record["question"]
    rows = answer.table(table)
    axis = table.removesuffix("s")
    place = rows.column(axis).to_pylist().index(name)
    (row,) = rows.slice(place, 1).to_pylist()
    set_to = choice["pretension"]
    ends = []
    for end, side in (("from", "below"), ("to", "above")):
        value = row[f"pretension_{end}"]
        limit = row[f"{end}_by"]
        if value is None or limit is None:
            continue
        is_missed = set_to is not None and (set_to < value if end == "from" else set_to > value)
        under = _condition(answer, row[f"{end}_condition"])
        words = phrases.broken(question, limit, choice, under)
        condition = phrases.condition_of_group(question, under)
        condition = f" ({condition})" if condition else ""
        if is_missed:
            ends.append(f"{side} {say.number(value)} {question['unit']} {words}{condition}")
    why = " and ".join(ends)
    if why:
        why += f", and {say.number(set_to or 0.0)} {question['unit']} is set"
    else:
        why = f"{say.percent(row['served'])} of the draws are served"
    command = None
    if answer.folder is not None:
        of_one = ["--table", table, "--where", f"{axis} = {_quoted(name)}"]
        command = shlex.join(["tendon", "show", str(answer.folder), *of_one])
    return {"name": name, "why": why, "command": command}


def _condition(answer: Answer, row: int) -> dict[str, Any]:
    """Return a condition of an answer by its row."""
    (values,) = answer.table("conditions").slice(row, 1).to_pylist()
    found: dict[str, Any] = values
    return found


def _quoted(name: str) -> str:
    """Return a name as a filter takes it, in quotes where it would lose some of its signs."""
    is_plain = name == name.strip() and name[:1] not in "\"'"
    return name if is_plain else f'"{name}"'


def unserved_afresh(answer: Answer, choice: ChoiceRecord, member: UnservedMember) -> UnservedRecord:
    """Say why a member of the fresh sample is not served, and how to look at a draw.

    Args:
        answer: The answer that does not serve it.
        choice: Choice of the answer.
        member: The person or the draw.
    """
    question: QuestionRecord = answer.record["question"]
    set_to = float(choice["pretension"] or 0.0)
    unit = question["unit"]
    at = f"{say.number(set_to)} {unit} is set"
    if math.isnan(member.low) or member.low > member.high:
        why = "no pretension works"
    elif set_to < member.low:
        why = f"it needs at least {say.number(member.low)} {unit}, and {at}"
    else:
        why = f"it takes at most {say.number(member.high)} {unit}, and {at}"
    # Scales of a person's anchors have no key, and are not among the numbers of a study.
    stated = {key: value for key, value in member.numbers.items() if key in keys()}
    numbers = ", ".join(parameter(key, value) for key, value in stated.items())
    return {"name": numbers, "why": why, "command": _design_of(answer, choice, member)}


def _design_of(answer: Answer, choice: ChoiceRecord, member: UnservedMember) -> str | None:
    """Return the command that designs for one draw at the pretension of a choice.

    Return None if the study's file is not where the command would find it, if a choice is not
    told by numbers alone, or if bodies are drawn, whose arms no setting gives.
    """
    record = answer.record
    if answer.study.people is not None:
        return None
    axes = record["question"]["choices"]
    if any(axis["sets"] is not None or axis["named"] for axis in axes):
        return None
    file = _study_file(answer)
    if file is None:
        return None
    numbers = {axis["key"]: value_of(choice, axis["column"]) for axis in axes} | member.numbers
    settings = [f"{key}={_setting(key, value)}" for key, value in numbers.items()]
    unit = record["question"]["unit"]
    set_to = say.number(choice["pretension"] or 0.0, _DIGITS)
    settings += [f"design.pretension={set_to} {unit}", "design.serve=1"]
    arguments = [part for setting in settings for part in ("--set", setting)]
    return shlex.join(["tendon", "design", file, *arguments, "--out", "results/lost"])


def _study_file(answer: Answer) -> str | None:
    """Return the file of an answer's study, if it is in the working directory and unchanged."""
    record = answer.record
    name = record["name"]
    candidates = [f"{name}.toml", f"{name}.yaml", f"{name}.yml"]
    source = record.get("sources", {}).get("study")
    if source is not None:
        candidates.insert(0, source["file"])
    for file in candidates:
        if not Path(file).is_file():
            continue
        try:
            study = load_study(file).drawn()
        except TendonError:
            continue
        if study.hash == record["study_hash"]:
            return str(file)
    return None


def _setting(key: str, value: Any) -> str:
    """Return a number as `--set` takes it: SI, an angle with its unit."""
    if isinstance(value, str):
        return value
    quantity = quantity_of(key) or QUANTITIES["friction"]
    unit = f" {quantity.unit}" if quantity.unit != "1" else ""
    return f"{value:.{_DIGITS}g}{unit}"
