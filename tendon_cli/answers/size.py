"""The size of a design question, for --dry-run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tendon_cli import say
from tendon_cli.answers.choices import Choices
from tendon_cli.answers.notes import notes_of
from tendon_cli.engine.folder import free_bytes
from tendon_cli.proof.subdivision import most_cells
from tendon_cli.studies.axis_words import name_words
from tendon_cli.studies.space.axis import SAMPLE_AXES, NamedAxis
from tendon_cli.studies.study import Study

_COMPRESSION = 0.5
"""Size of tables of choices on the disk over that in memory: 0.46 of 3,000 choices."""

_SECONDS_PER_CELL = 3e-5
"""Time that a cell of a proof takes on a core of 2024, s, and again for each number in a box."""


def size_of_question(
    study: Study, folder: Path, _jobs: int | None, _figures: bool
) -> tuple[dict[str, Any], str]:
    """Return the size of the question that a study asks, as a record and as text."""
    task = Choices.of(study)
    question = task.question
    notes = notes_of(question)
    record: dict[str, Any] = {"name": study.name}
    lines = [f"{study.name}: --dry-run writes nothing"]
    for name, product in (("choices", question.choices), ("conditions", question.conditions)):
        record[name] = {axis.key: len(axis) for axis in product.axes}
        axes = ", ".join(f"{key} {count:,}" for key, count in record[name].items())
        lines.append(f"  {name:<12} {len(product):,}" + (f"  ({axes})" if axes else ""))
        for axis in product.axes:
            if isinstance(axis, NamedAxis) and axis.key not in SAMPLE_AXES:
                first, last = (name_words(axis, axis.names[end]) for end in (0, -1))
                lines.append(f"    {axis.key:<10} {first} to {last}")
    record["windows"] = len(question.choices) * len(question.conditions)
    record["states"] = record["windows"] * question.states_per_design
    numbers = len(question.box)
    cells = 0 if study.trajectory is not None else most_cells(numbers)
    record["most_cells"] = cells
    record["most_seconds"] = round(cells * _SECONDS_PER_CELL * (1 + numbers), 3)
    record["bytes"] = round(_COMPRESSION * task.most_bytes)
    record["free_bytes"] = free_bytes(folder)
    record["notes"] = notes
    lines += [f"  {name:<12} {record[name]:,}" for name in ("windows", "states")]
    if cells:
        seconds = record["most_seconds"]
        lines.append(f"  cells        at most {cells:,} to prove a choice, about {seconds:.0f} s")
    free = say.byte_size(record["free_bytes"])
    lines.append(f"  disk         about {say.byte_size(record['bytes'])}, {free} free")
    lines += [f"  note         {note}" for note in notes]
    return record, "\n".join(lines)
