"""A study in a few lines, as a session prints it."""

from __future__ import annotations

from typing import Any

from tendon_cli import say
from tendon_cli.studies.values import Values
from tendon_cli.units import counted

_MOST_VALUES = 6


def study_text(study: Any, numbers: dict[str, tuple[str, Values]]) -> str:
    """Name, axes, limits and what was made of its files; `numbers` has the quantity and the values of every number."""
    lines = [f"{study.name}: {study.title}" if study.title else f"study {study.name}"]
    lines += [_line("axis", f"{key}: {_axis(study, key, numbers)}") for key in study.axes]
    motion = _values(*numbers["motion.elbow_angle"])
    lines += [_line("motion", f"{' and '.join(study.motion.direction)}, elbow angle {motion}")]
    lines += [_line("conditions", ", ".join(study.conditions))] if study.conditions else []
    lines += [_line("limit", f"{name} {say.quantity(name, value)}") for name, value in study.limits.items()]
    lines += [_line("uncertain", ", ".join(study.uncertain))] if study.uncertain else []
    lines += [_line("note", note) for note in study.notes]
    lines += [_line("warning", warning) for warning in study.warnings]
    return "\n".join(lines)


def _line(name: str, text: str) -> str:
    return f"  {name:<11} {text}"


def _axis(study: Any, key: str, numbers: dict[str, tuple[str, Values]]) -> str:
    if key in numbers:
        return _values(*numbers[key])
    if key == "draw":
        return counted(study.draws, "draw")
    if key == "person":
        return f"those of {study.people.file}" if study.people.file else counted(study.people.count, "person")
    names = [str(case.name) for case in study.cases]
    more = f", ... ({counted(len(names), 'case')})" if len(names) > _MOST_VALUES else ""
    return ", ".join(names[:_MOST_VALUES]) + more


def _values(quantity: str, values: Values) -> str:
    """The values of a number as people write them, the middle of a long axis left out."""
    if len(values) > _MOST_VALUES:
        first, last = (say.quantity(quantity, value) for value in (values.array[0], values.array[-1]))
        return f"{first} to {last}, {len(values):,} values"
    return ", ".join(say.quantity(quantity, value) for value in values.array)
