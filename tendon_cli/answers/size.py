"""The size of a design question, for --dry-run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tendon_cli.answers.question_facts import notes_of
from tendon_cli.proof.subdivision import most_cells
from tendon_cli.studies.study import Study
from tendon_cli.windows.question import question_of

_SECONDS_PER_CELL = 3e-5
"""Time that a cell of a proof takes on a core of 2024, s, and again for each number in a box."""


def size_of_question(
    study: Study, _folder: Path, _jobs: int | None, _figures: bool
) -> tuple[dict[str, Any], str]:
    """Return the size of the question that a study asks, as a record and as text."""
    question = question_of(study)
    notes = notes_of(question)
    record: dict[str, Any] = {"name": study.name}
    lines = [f"{study.name}: nothing is written by --dry-run"]
    for name, product in (("choices", question.choices), ("conditions", question.conditions)):
        record[name] = {axis.key: len(axis) for axis in product.axes}
        axes = ", ".join(f"{key} {count:,}" for key, count in record[name].items())
        lines.append(f"  {name:<12} {len(product):,}" + (f"  ({axes})" if axes else ""))
    record["windows"] = len(question.choices) * len(question.conditions)
    record["states"] = record["windows"] * question.states_per_design
    numbers = len(question.box)
    cells = 0 if study.trajectory is not None else most_cells(numbers)
    record["most_cells"] = cells
    record["most_seconds"] = round(cells * _SECONDS_PER_CELL * (1 + numbers), 3)
    record["notes"] = notes
    lines += [f"  {name:<12} {record[name]:,}" for name in ("windows", "states")]
    if cells:
        seconds = record["most_seconds"]
        lines.append(
            f"  cells        at most {cells:,} in the proof of a choice, some {seconds:.0f} s"
        )
    lines += [f"  note         {note}" for note in notes]
    return record, "\n".join(lines)
