"""A third verb, `tendon weigh`: the weight of every load, in a room of its own."""

# ruff: noqa: ARG002 - a task is given more than this one needs

from __future__ import annotations

import os
import threading
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from tendon_cli.engine.results import Result
from tendon_cli.engine.task import Task
from tendon_cli.kernel import columns_writer
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import Column
from tendon_cli.verbs.registry import TableKind, TaskKind

G = 9.80665
"""Acceleration by weight, m/s²."""

WEIGH = TaskKind(
    verb="weigh",
    help="Weigh every load of a study.",
    noun="a weighing",
    record="weigh.json",
    counts=("loads",),
    tables=(TableKind("weights", axes="tests.weigh.weight_axes"),),
    task="tests.weigh.Weigh",
    result="tests.weigh.Weighing",
    suffix="-weights",
    draw="tests.weigh.draw",
)


def weight_axes(study):
    """Return the axis of loads."""
    from tendon_cli.studies.spaces import space_of

    return tuple(axis for axis in space_of(study).axes if axis.key == "load.mass")


@dataclass(frozen=True)
class Weigh(Task):
    """Task that weighs the loads of a study, each in a part of its own."""

    kind = WEIGH
    asked: Study
    stop: threading.Event = field(default_factory=threading.Event)
    least_bytes = 1

    @classmethod
    def of(cls, study, stop=None):
        return cls(study, stop or threading.Event())

    @property
    def study(self):
        return self.asked

    @property
    def tables(self):
        return {"weights": len(self.asked.load.mass)}

    def columns(self, table):
        mass = Column.of(QUANTITIES["load_mass"], is_axis=True, nullable=False)
        return (mass, Column.of(QUANTITIES["max_tension"], "load_weight", nullable=False))

    def rows(self, table, index):
        return 1

    def fill(self, tables, index):
        if index == 1 and "BROKEN_SCALES" in os.environ:
            raise RuntimeError("the scales are broken")
        mass = self.asked.load.mass.array[[index]]
        columns = {"load_mass": mass, "load_weight": G * mass}
        tables["weights"].fill(1, columns_writer(columns, (1,)))
        return {"weight": float(G * mass[0])}

    def is_note(self, index, note):
        return isinstance(note, dict) and isinstance(note.get("weight"), float)

    def place(self, index):
        return f"load {index}"

    def results(self, notes, *_):
        return {"loads": len(notes), "heaviest": max(note["weight"] for note in notes)}


class Weighing(Result):
    """The result of `tendon weigh`."""

    drawn_by: ClassVar[str] = "tests.weigh.page"

    @property
    def text(self):
        return f"{self.record['loads']} loads, the heaviest weighs {self.record['heaviest']:.1f} N"


def page(result, _what, _how):
    """Draw the weights over the masses."""
    from tendon_cli.figures.frame import framed
    from tendon_cli.figures.style import house_style

    table = result.table("weights")
    with house_style():
        framed_page = framed("weights", 60.0)
        axes = framed_page.figure.subplots()
        axes.plot(np.asarray(table["load_mass"]), np.asarray(table["load_weight"]))
    return framed_page


def draw(study, folder, out, record):
    """Draw the weights beside their table."""
    drawn = page(Weighing(record, folder, validated=study), (), {})
    return [drawn.save(out / "weights.png").name], [], None
