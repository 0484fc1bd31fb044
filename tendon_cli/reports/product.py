"""The designs of a run, or the choices of an answer, as a page maps them: axes, quantities, and what was thinned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.labels import Shown
from tendon_cli.reports.packed import packed, packed_classes

MOST_CELLS = 700_000
MOST_BYTES = 2_300_000
"""Of all maps together, so that a page stays under 5 MB beside its library and its states."""

CLASSES = (
    {"label": "feasible", "letter": "F", "colour": "feasible"},
    {"label": "beyond a limit", "letter": "L", "colour": "beyond"},
    {"label": "unstable", "letter": "U", "colour": "unstable"},
    {"label": "slack", "letter": "S", "colour": "slack"},
    {"label": "no equilibrium", "letter": "N", "colour": "nowhere"},
)
"""What a design comes to, the best first; letters say what colours do."""


@dataclass(frozen=True, eq=False)
class PageAxis:
    """An axis of the maps: a column, its SI values or names, and which of the run's positions the page keeps."""

    shown: Shown
    values: npt.NDArray[np.float64] | None
    names: tuple[str, ...]
    is_log: bool
    kept: npt.NDArray[np.int64]

    def record(self) -> dict[str, Any]:
        """As the page has it."""
        label = {"label": self.shown.name, "unit": "" if self.shown.unit == "1" else self.shown.unit}
        if self.values is None:
            return {**label, "values": None, "names": [self.names[at] for at in self.kept], "is_log": False}
        values = [_rounded(value) for value in self.shown.scaled(self.values[self.kept])]
        return {**label, "values": values, "names": None, "is_log": self.is_log}


def said_of_thinning(axes: Sequence[PageAxis], left_out: Sequence[str]) -> str:
    """What the page does not hold of the run; empty where it holds all."""
    found = []
    for axis in axes:
        whole = len(axis.names) if axis.values is None else len(axis.values)
        if len(axis.kept) < whole:
            found.append(f"{len(axis.kept)} of {whole} values of {axis.shown.name}")
    parts = [f"of the run it holds {', '.join(found)}"] if found else []
    parts += [f"it leaves out {', '.join(left_out)}"] if left_out else []
    return f"This page is kept small: {'; '.join(parts)}. The tables have everything." if parts else ""


def quantities(
    columns: Mapping[str, npt.NDArray[Any]], shown: Mapping[str, Shown]
) -> tuple[list[dict[str, Any]], list[str]]:
    """Columns in the order of their worth, as many as MOST_BYTES hold; and the names of the others."""
    found, left_out, budget = [], [], MOST_BYTES
    for name, values in columns.items():
        record = outcomes_record(values) if name == OUTCOME else number_record(shown[name], values)
        size = len(record["array"]["data"])
        if size > budget:
            left_out.append(record["label"])
            continue
        budget -= size
        found.append({"name": name, **record})
    return found, left_out


OUTCOME = "outcome"


def outcomes(columns: Mapping[str, npt.NDArray[Any]], no_equilibrium: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """The class of each design, an index into CLASSES."""
    worst = np.where(columns["feasible"], 0.0, 1.0)
    worst = np.where(columns["stable"], worst, 2.0)
    worst = np.where(columns["taut"], worst, 3.0)
    return np.where(no_equilibrium, 4.0, worst)


def outcomes_record(values: npt.NDArray[Any]) -> dict[str, Any]:
    """What designs come to, as the page has it."""
    return {"label": "what a design comes to", "unit": "", "classes": list(CLASSES), "array": packed_classes(values)}


def number_record(shown: Shown, values: npt.NDArray[Any]) -> dict[str, Any]:
    """A column of numbers as the page has it, in the unit shown."""
    scaled = shown.scaled(values)
    finite = scaled[np.isfinite(scaled)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    unit = "" if shown.unit == "1" else shown.unit
    return {"label": shown.name, "unit": unit, "classes": None, "low": low, "high": high, "array": packed(scaled)}


def _rounded(value: float) -> float:
    return float(f"{value:.10g}")
