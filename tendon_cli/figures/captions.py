"""What a figure says below its panels: which filters it was drawn with, and the values that all of it has in common."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from tendon_cli.cube.axes import Ints, RowAxis
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import plain
from tendon_cli.studies.figures import FigureSpec

_LONGEST_NAME = 40


def caption(
    cube: Cube, spec: FigureSpec, read: Mapping[str, Values], *, varied: Collection[str]
) -> tuple[list[str], list[str]]:
    """The lines of a caption, and the values in them; `read` has the defining columns of the rows drawn."""
    fixed = []
    for axis in cube.axes:
        if axis.is_text and axis.column in read and axis.column not in varied and axis.length > 1:
            names = np.unique(read[axis.column])
            fixed += [plain(str(names[0]))] if len(names) == 1 else []
    for name in (name for name in cube.defining if name in read and name not in varied):
        values = np.unique(read[name])
        if len(values) == 1 and np.isfinite(values[0]):
            fixed.append(cube.shown(name, spec.units).equation(float(values[0])))
    lines = [f"Only where {plain(' and '.join(spec.where))}."] if spec.where else []
    return [*lines, *([f"At {', '.join(fixed)}."] if fixed else [])], fixed


def value_texts(cube: Cube, axis: RowAxis, at: Ints, units: Mapping[str, str]) -> list[str]:
    """The values at some positions of an axis, as a title or a key names them."""
    values = axis.values[at]
    if axis.is_text:
        # A legend leaves out what starts with an underscore.
        texts = [plain(str(value), width=_LONGEST_NAME, lines=1) for value in values]
        return [f" {text}" if text.startswith("_") else text for text in texts]
    return [cube.shown(axis.column, units).equation(float(value)) for value in values]
