"""`[[figure]]`: the figures that a study wants of its run. They change neither its tables nor its hash."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at every start.

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    StringConstraints,
    ValidationError,
    ValidationInfo,
)

from tendon_cli import quantities
from tendon_cli.errors import Fault, UsageError
from tendon_cli.quantities import OF_FIGURES, QUANTITIES, Quantity
from tendon_cli.studies.fields import OneOf, fault, nearest, one_or_many
from tendon_cli.studies.filters import Filter, read_filter
from tendon_cli.studies.parts import Name, Part, usual
from tendon_cli.units import UNITS, UnitError, described, parse_measure, shorten

MOST_QUANTITIES = 8
OF_STATES = (*quantities.OF_STATES, *OF_FIGURES)
OF_DESIGNS = (*quantities.OF_DESIGNS, *quantities.OF_CYCLES)
WORDS = ("direction", "status", "case", "taut", "stable", "feasible", "design")
"""Columns that are no quantities."""

WIDTHS = {"column": 85.0, "page": 175.0}
"""Named widths of figures, mm."""
_SIZE = re.compile(r"([\d.]+)(?:\s*[x×]\s*([\d.]+))?\s*(mm|cm|in)?")
_SMALLEST, _LARGEST = 40.0, 1000.0


def read_size(text: str) -> tuple[float, float | None]:
    """Width and perhaps height of a figure in mm; raises UsageError.

    >>> read_size("120 x 80 mm"), read_size("12 cm"), read_size("120"), read_size("column")
    ((120.0, 80.0), (120.0, None), (120.0, None), (85.0, None))
    """
    if text in WIDTHS:
        return WIDTHS[text], None
    match = _SIZE.fullmatch(text.strip()) if len(text) < 60 else None
    try:
        texts = (
            [f"{side} {match[3] or 'mm'}" for side in match.groups()[:2] if side] if match else []
        )
        sides = [parse_measure(each, "length").si * 1e3 for each in texts]
    except UnitError:
        sides = []
    if not sides or not all(_SMALLEST <= side <= _LARGEST for side in sides):
        hint = '"column", "page", "120 mm" or "120 x 80 mm"; a side has 40 mm to 1000 mm'
        raise UsageError(f'"{shorten(text)}" is not a size', where="--size", hint=hint)
    return sides[0], sides[1] if len(sides) > 1 else None


def _checked_by(read: Callable[[str], object]) -> Callable[[str], str]:
    """A validator that keeps the text, and gives the fault that `read` finds in it."""

    def check(text: str) -> str:
        try:
            read(text)
        except UsageError as error:
            raise fault(error.message, error.hint) from None
        return text

    return check


def _not_a_slack_map(name: str) -> str:
    if name.startswith("slack_map"):
        raise fault(f'"{name}" cannot name a figure', "slack_map is what the slack maps are called")
    return name


def _quantities(names: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
    """Of a figure with a name, which a study declares, results of one table."""
    if info.data.get("name", "") is None:
        return names
    for name in names:
        if name not in OF_STATES and name not in OF_DESIGNS:
            hint = (
                nearest(name, (*OF_STATES, *OF_DESIGNS))
                or "a result of the states or of the designs"
            )
            raise fault(f'"{shorten(name)}" is not a quantity of a table', hint)
    state, design = (
        next((name for name in names if name in table), None) for table in (OF_STATES, OF_DESIGNS)
    )
    if state and design:
        raise fault(
            f"{state} is of the states and {design} of the designs, a figure shows one table"
        )
    if not names:
        raise fault(
            "is missing or empty, each figure of a study needs one", 'such as "motor_torque"'
        )
    return names


def _unit(symbol: str) -> str:
    if symbol not in UNITS:
        hint = nearest(symbol, UNITS) or f"known units: {', '.join(UNITS)}"
        raise fault(f'unknown unit "{shorten(symbol)}"', hint)
    return symbol


_Text = Annotated[str, StringConstraints(strict=True)]
_Column = Annotated[
    str, StringConstraints(strict=True, pattern=r"^[A-Za-z_][\w.]*$", max_length=100)
]
_Filter = Annotated[_Text, AfterValidator(_checked_by(read_filter))]


class FigureSpec(Part):
    """A figure as it is asked for, by `[[figure]]`, the command line or Python; the rest follows from the table."""

    model_config = ConfigDict(json_schema_extra={"required": ["name", "quantity"]})

    name: Annotated[Name, AfterValidator(_not_a_slack_map)] | None = usual(
        None, description="stem of the figure's file, each once"
    )
    title: Annotated[str, StringConstraints(max_length=300, strict=True)] = usual(
        "", description="above the panels; default the title of the study"
    )
    quantity: Annotated[
        tuple[_Text, ...],
        Field(max_length=MOST_QUANTITIES),
        AfterValidator(_quantities),
        *one_or_many({"enum": [*OF_STATES, *OF_DESIGNS]}, MOST_QUANTITIES, each_once=True),
    ] = usual(
        (),
        description="what is drawn: one or more results of the states, or of the designs; a panel each",
    )
    overlay: Annotated[bool, Field(strict=True)] = usual(
        default=False, description="draw the quantities in one panel, one colour each"
    )
    x: _Column | None = usual(
        None, description="column along x; default the elbow angle, or of designs the first axis"
    )
    colour: _Column | None = usual(
        None, description="axis with one colour per value; default the load"
    )
    panels: _Column | None = usual(None, description="axis with one panel per value")
    where: Annotated[tuple[_Filter, ...], *one_or_many({"type": "string"}, 20)] = usual(
        (), max_length=20, description='filters, such as "load_mass = 5 kg"; all of them hold'
    )
    unit: Annotated[
        tuple[Annotated[_Text, AfterValidator(_unit)], ...], *one_or_many({"type": "string"}, 20)
    ] = usual((), max_length=20, description="units to show, each for its dimension, such as cm")
    format: Annotated[tuple[str, ...], OneOf(("png", "svg", "pdf"), is_list=True)] = usual(
        ("png",), description="png, svg, pdf, or several of them"
    )
    size: Annotated[_Text, AfterValidator(_checked_by(read_size))] = usual(
        "page",
        description='"column" (85 mm), "page" (175 mm), a width or width x height, such as "120 x 80 mm"',
    )

    @property
    def asked(self) -> tuple[str, ...]:
        """Every column that it names."""
        return (
            *self.quantity,
            *filter(None, (self.x, self.colour, self.panels)),
            *(each.name for each in self.filters),
        )

    @property
    def table(self) -> str:
        """The table that has its quantities."""
        return "states" if self.quantity[0] in OF_STATES else "designs"

    @property
    def filters(self) -> list[Filter]:
        """What `where` says."""
        return [read_filter(text) for text in self.where]

    @property
    def units(self) -> dict[str, str]:
        """The unit to show, by dimension."""
        return {UNITS[symbol].dimension: symbol for symbol in self.unit}


def figure_spec(**given: Any) -> FigureSpec:
    """A figure from Python or the command line, by the keys of `[[figure]]`; raises UsageError for the first fault.

    >>> figure_spec(quantity="motor_torque", where="load_mass = 5 kg").quantity
    ('motor_torque',)
    """
    try:
        return FigureSpec.model_validate(given)
    except ValidationError as error:
        detail = error.errors(include_url=False)[0]
        context = detail.get("ctx") or {}
        place = f"--{detail['loc'][0]}" if detail["loc"] else None
        if detail["type"] == "tendon":
            raise UsageError(context["problem"], where=place, hint=context["hint"]) from None
        problem = f"{described(detail.get('input'))} is not possible"
        raise UsageError(problem, where=place, hint=detail["msg"]) from None


def figure_faults(
    figures: tuple[FigureSpec, ...], axes: Mapping[str, Quantity], at_fault: set[str]
) -> Iterator[Fault]:
    """Every name in a study's figures that its tables do not have; `axes` are its numbers by their keys and columns."""
    names = [figure.name for figure in figures]
    for at, figure in enumerate(figures):
        if figure.name is not None:
            if figure.name in names[:at]:
                yield Fault(f"figure.{at}.name", f'"{figure.name}" names two figures')
            yield from _figure_faults(figure, f"figure.{at}", axes)
        elif f"figure.{at}.name" not in at_fault:
            yield Fault(f"figure.{at}.name", "is missing, each entry of figure needs it")


def _figure_faults(figure: FigureSpec, place: str, axes: Mapping[str, Quantity]) -> Iterator[Fault]:
    results = OF_STATES if figure.table == "states" else OF_DESIGNS
    known = (*axes, "direction", "elbow_angle", "case")
    asked = [(key, getattr(figure, key), known) for key in ("colour", "panels")]
    asked += [("x", figure.x, (*known, *results))]
    asked += [
        ("where", each.name, (*known, *OF_STATES, *OF_DESIGNS, *WORDS)) for each in figure.filters
    ]
    for key, name, names in asked:
        if name is not None and name not in names:
            yield Fault(
                f"{place}.{key}",
                f'there is no column "{shorten(name)}"',
                nearest(name, (*known, *results)),
            )
    if figure.overlay and figure.colour is not None:
        problem = "stands beside overlay, which gives the colours to the quantities"
        yield Fault(f"{place}.colour", problem, "leave one of them out; panels takes the axis")
    dimensions = {(QUANTITIES | OF_FIGURES)[name].dimension for name in figure.quantity}
    if figure.overlay and len(dimensions) > 1:
        problem = f"{' and '.join(sorted(dimensions))} cannot share a panel"
        yield Fault(f"{place}.overlay", problem, "one dimension in each")
    for each in figure.filters:
        try:
            if quantity := axes.get(each.name) or QUANTITIES.get(each.name):
                each.on(each.name, quantity)
        except UsageError as error:
            yield Fault(f"{place}.where", error.message, error.hint)
