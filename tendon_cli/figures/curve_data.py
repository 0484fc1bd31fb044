"""What a figure of curves shows, read from a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import LOAD
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import Shown
from tendon_cli.errors import UsageError
from tendon_cli.figures.layout import CurvePlan
from tendon_cli.figures.map_data import MARGIN, margin_shown, meaning_of_margin
from tendon_cli.figures.scales import Scale, axis_scale, caption, value_texts
from tendon_cli.figures.style import OKABE_ITO, Colour, load_colours, sequence
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.filters import Condition, Truth

Floats = npt.NDArray[np.float64]

_SLACK_OF = {"flexor": ("flexor slack", "both slack"), "extensor": ("extensor slack", "both slack")}
_ANY_SLACK = ("flexor slack", "extensor slack", "both slack")
_STIFFNESS = "elbow_stiffness"
_OF_GEOMETRY = ("flexor_moment_arm", "flexor_travel", "extensor_travel", "radius_ratio")
"""What no tension changes, so that nothing is marked on it."""
_OF_A_TENDON = (
    "_tension_distal",
    "_tension_proximal",
    "_elongation",
    "_extensor_tension",
    "_flexor_tension",
)


_PARTS = ("values", "slack", "turned", "unstable")


@dataclass(frozen=True)
class CurveData:
    """Everything that the pages of curves show; arrays over quantities, panels, colours, dashes and x."""

    title: str
    study: str
    x: Scale | None
    """None where x is not an axis but a column that changes along one."""
    x_label: str
    x_values: Floats
    """Over panels, colours, dashes and x."""
    quantities: tuple[Shown, ...]
    values: Floats
    """In the unit shown, NaN where there is none."""
    slack: Truth
    """Where a tendon that the quantity speaks of is slack."""
    turned: Truth
    """Where any tendon is slack: where this changes, the line has a kink."""
    unstable: Truth
    """Where the elbow stiffness is below its limit."""
    colours: tuple[tuple[str, Colour], ...]
    """What each stands for, and how it looks; one at least."""
    dashes: tuple[str, ...]
    panels: tuple[str, ...]
    has_kinks: bool
    """Whether lines turn where a tendon goes slack; none does in a model in which tendons push."""
    is_slack_below_zero: bool
    notes: tuple[str, ...]

    @property
    def is_line(self) -> bool:
        """Whether values along x have places between them; names have none."""
        return not (self.x and self.x.names)


def curve_data(
    cube: Cube, plan: CurvePlan, asked: Sequence[Condition], spec: FigureSpec
) -> CurveData:
    """Read the lines of a plan; raises UsageError where the filters, or nulls, leave nothing to draw."""
    masks = [each for each in asked if cube.axis(each.column) is None]
    names = [
        *plan.quantities,
        "status",
        _STIFFNESS,
        "taut",
        "stable",
        *(each.column for each in masks),
        plan.x_column,
    ]
    names += [*cube.defining, *(axis.column for axis in cube.axes if axis.is_text)]
    read = cube.gather(plan.rows(cube), [name for name in names if name in cube.columns])
    kept = np.logical_and.reduce(
        [np.ones(read[plan.x_column].shape), *(each.holds(read[each.column]) for each in masks)]
    )
    quantities = [
        margin_shown(cube, spec) if name == MARGIN else cube.shown(name, spec.units)
        for name in plan.quantities
    ]
    values = np.array([np.where(kept, how.scaled(read[how.column]), np.nan) for how in quantities])
    if not np.isfinite(values).any():
        _raise_empty(plan, asked)
    marks = (
        np.array([_marks(cube, read, name) for name in plan.quantities])
        & np.isfinite(values)[:, np.newaxis]
    )
    slack, turned, unstable = np.moveaxis(marks, 1, 0)
    lines, _ = caption(
        cube, spec, read, varied=[axis.column for axis in plan.parts if axis is not None]
    )
    meaning = [meaning_of_margin(cube)] if MARGIN in plan.quantities else []
    panels, colours, dashes = (
        ()
        if axis is None
        else tuple(value_texts(cube, axis, plan.positions[axis.column], spec.units))
        for axis in plan.parts[:3]
    )
    # Below zero means slack of a margin, and in a model in which tendons push of their tensions and lengths.
    below_zero = all(
        name.endswith((MARGIN, *_OF_A_TENDON) if cube.pushes else MARGIN)
        for name in plan.quantities
    )
    data = CurveData(
        spec.title or cube.title,
        cube.source,
        *_along_x(cube, plan, read, spec),
        tuple(quantities),
        values,
        slack,
        turned,
        unstable,
        tuple(zip(colours or ("",), _colours(plan, len(colours)), strict=True)),
        dashes,
        panels,
        not cube.pushes,
        below_zero,
        (*meaning, *lines, *plan.notes),
    )
    return _each_panel_once(_overlaid(data) if spec.overlay else data)


def _marks(cube: Cube, read: Mapping[str, Values], name: str) -> tuple[Truth, Truth, Truth]:
    """Where the lines of a column are slack, where any tendon is, and where the elbow is unstable."""
    nowhere = np.zeros(read[name].shape, dtype=np.bool_)
    if name in _OF_GEOMETRY:
        return nowhere, nowhere, nowhere
    turned = slack = read["taut"] == 0.0 if "taut" in read and name != MARGIN else nowhere
    if "status" in read:
        side = next((side for side in _SLACK_OF if name.startswith(side)), "")
        slack, turned = (
            np.isin(read["status"], words)
            for words in (_SLACK_OF.get(side, _ANY_SLACK), _ANY_SLACK)
        )
    unstable = read["stable"] == 0.0 if "stable" in read else nowhere
    if _STIFFNESS in read:
        stiffness, limit = read[_STIFFNESS], cube.limit("min_elbow_stiffness")
        unstable = stiffness < limit - 1e-9 * np.nanmax(np.abs(stiffness), initial=0.0)
    return slack, turned, unstable


def _along_x(
    cube: Cube, plan: CurvePlan, read: Mapping[str, Values], spec: FigureSpec
) -> tuple[Scale | None, str, Floats]:
    """The scale of x, its label, and its values in the shape of the curves."""
    if plan.x_column != plan.x.column and cube.columns[plan.x_column] is not None:
        quantity = cube.shown(plan.x_column, spec.units)
        return None, quantity.label, quantity.scaled(read[plan.x_column])
    scale = axis_scale(cube, plan.x, plan.positions[plan.x.column], spec.units)
    places = np.empty(len(scale.places))
    places[scale.order] = scale.places
    label = plan.x.column if plan.x.is_text else scale.label
    return scale, label, np.broadcast_to(places, read[plan.x_column].shape)


def _colours(plan: CurvePlan, count: int) -> Sequence[Colour]:
    if plan.colour is None:
        return sequence(1)
    if plan.colour.is_text:
        return [OKABE_ITO[at % len(OKABE_ITO)] for at in range(count)]
    values = plan.colour.values[plan.positions[plan.colour.column]]
    return load_colours(values) if plan.colour.column == LOAD else sequence(count)


def _overlaid(data: CurveData) -> CurveData:
    """All quantities in each panel, a colour each."""
    first = data.quantities[0]
    same = replace(first.quantity, name=first.quantity.dimension, symbol="", shown_in=first.unit)
    names = [each.titled for each in data.quantities]
    return replace(
        data,
        quantities=(Shown(same.name, same, first.unit, first.factor),),
        x_values=np.repeat(data.x_values, len(names), axis=1),
        colours=tuple((name, OKABE_ITO[at % len(OKABE_ITO)]) for at, name in enumerate(names)),
        **{part: np.swapaxes(getattr(data, part), 0, 2) for part in _PARTS},
    )


def _each_panel_once(data: CurveData) -> CurveData:
    """Panels that would all repeat the same picture are drawn once, and a note says so."""
    parts = {part: getattr(data, part) for part in _PARTS} | {"x_values": data.x_values[np.newaxis]}
    first = {name: part[:, :1] for name, part in parts.items()}
    if len(data.panels) < 2 or not all(
        np.array_equal(part, np.broadcast_to(first[name], part.shape), equal_nan=True)
        for name, part in parts.items()
    ):
        return data
    note = f"The same picture for {', '.join(data.panels)}."
    return replace(
        data, **first | {"x_values": data.x_values[:1]}, panels=(), notes=(*data.notes, note)
    )


def _raise_empty(plan: CurvePlan, asked: Sequence[Condition]) -> None:
    if plan.quantities == (MARGIN,) and not asked:
        raise UsageError("no design has a margin, each has elbow angles without equilibrium")
    hint = "fewer or wider filters" if asked else "--where chooses other rows"
    raise UsageError(
        f"{', '.join(plan.quantities)}: all null in the rows drawn", where="--where", hint=hint
    )
