"""Section `[[figure]]`: figures of a study's run. They change neither its tables nor its hash."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at
# every start.

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from tendon_cli.studies.fields import WordField, fault, hint_at_nearest, one_or_many
from tendon_cli.studies.filters import Filter, read_filter
from tendon_cli.studies.parts import Name, Part, field_default
from tendon_cli.units import UNITS, UnitError, described, parse_measure, shorten

MOST_QUANTITIES = 8
"""Largest number of quantities of one figure."""
OF_STATES = (*quantities.OF_STATES, *OF_FIGURES)
"""Results of the states that a figure may show."""
OF_DESIGNS = (*quantities.OF_DESIGNS, *quantities.OF_CYCLES)
"""Results of the designs that a figure may show."""
WORDS = ("direction", "status", "case", "taut", "stable", "feasible", "design")
"""Columns of words and flags, and the number of a design, by which a figure may filter."""

WIDTHS = {"column": 85.0, "page": 175.0}
"""Named widths of figures, mm."""
_SIZE = re.compile(r"([\d.]+)(?:\s*[x×]\s*([\d.]+))?\s*(mm|cm|in)?")
_SHORTEST_SIDE = 40.0
"""Shortest side of a figure, mm."""
_LONGEST_SIDE = 1000.0
"""Longest side of a figure, mm."""


def read_size(text: str) -> tuple[float, float | None]:
    """Return width and height of a figure in mm; the height is None if the text does not say it.

    Raises:
        UsageError: The text is not a size.

    >>> read_size("120 x 80 mm"), read_size("12 cm"), read_size("120"), read_size("column")
    ((120.0, 80.0), (120.0, None), (120.0, None), (85.0, None))
    """
    if text in WIDTHS:
        return WIDTHS[text], None
    sides = _sides(text)
    if not sides or not all(_SHORTEST_SIDE <= side <= _LONGEST_SIDE for side in sides):
        hint = '"column", "page", "120 mm" or "120 x 80 mm"; a side has 40 mm to 1000 mm'
        raise UsageError(f'"{shorten(text)}" is not a size', where="--size", hint=hint)
    return sides[0], sides[1] if len(sides) > 1 else None


def _sides(text: str) -> list[float]:
    """Return one or two sides of a figure in mm; none if the text cannot be read."""
    match = _SIZE.fullmatch(text.strip()) if len(text) < 60 else None
    if match is None:
        return []
    unit = match[3] or "mm"
    numbers = [number for number in (match[1], match[2]) if number]
    try:
        return [parse_measure(f"{number} {unit}", "length").si * 1e3 for number in numbers]
    except UnitError:
        return []


# --- Validators ----------------------------------------------------------------------------------


def _checked_by(read: Callable[[str], object]) -> Callable[[str], str]:
    """Return a validator that keeps a text, and raises the fault that `read` finds in it."""

    def check(text: str) -> str:
        try:
            read(text)
        except UsageError as error:
            raise fault(error.message, error.hint) from None
        return text

    return check


def _check_figure_name(name: str) -> str:
    """Return the name of a figure; refuse those of the slack maps."""
    if name.startswith("slack_map"):
        raise fault(f'"{name}" cannot name a figure', "slack_map is the name of the slack maps")
    return name


def _check_quantities(names: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
    """Return the quantities of a figure; those of a declared one are results of one table.

    A figure that a study declares has a name. One without a name is asked for on the command line,
    where its quantities are checked against a table.
    """
    if info.data.get("name", "") is None:
        return names
    for name in names:
        if name not in OF_STATES and name not in OF_DESIGNS:
            near = hint_at_nearest(name, (*OF_STATES, *OF_DESIGNS))
            hint = near or "a result of the states or of the designs"
            raise fault(f'"{shorten(name)}" is not a quantity of a table', hint)
    of_states = [name for name in names if name in OF_STATES]
    of_designs = [name for name in names if name in OF_DESIGNS]
    if of_states and of_designs:
        found = f"{of_states[0]} is a result of the states and {of_designs[0]} of the designs"
        raise fault(f"{found}, but a figure shows one table")
    if not names:
        problem = "is missing or empty, each figure of a study needs one"
        raise fault(problem, 'such as "motor_torque"')
    return names


def _check_unit(symbol: str) -> str:
    """Return the symbol of a known unit; refuse any other."""
    if symbol not in UNITS:
        hint = hint_at_nearest(symbol, UNITS) or f"known units: {', '.join(UNITS)}"
        raise fault(f'unknown unit "{shorten(symbol)}"', hint)
    return symbol


_Text = Annotated[str, StringConstraints(strict=True)]
_Column = Annotated[
    str, StringConstraints(strict=True, pattern=r"^[A-Za-z_][\w.]*$", max_length=100)
]
_Filter = Annotated[_Text, AfterValidator(_checked_by(read_filter))]


class FigureSpec(Part):
    """Figure as `[[figure]]`, the command line or Python asks for it; its table gives the rest."""

    model_config = ConfigDict(json_schema_extra={"required": ["name", "quantity"]})

    name: Annotated[Name, AfterValidator(_check_figure_name)] | None = field_default(
        None, description="stem of the figure's file, different for each"
    )
    title: Annotated[str, StringConstraints(max_length=300, strict=True)] = field_default(
        "", description="title above the panels; default that of the study"
    )
    quantity: Annotated[
        tuple[_Text, ...],
        Field(max_length=MOST_QUANTITIES),
        AfterValidator(_check_quantities),
        *one_or_many({"enum": [*OF_STATES, *OF_DESIGNS]}, MOST_QUANTITIES, each_once=True),
    ] = field_default(
        (),
        description="what is drawn: one or more results of the states, or of the designs; a panel "
        "each",
    )
    overlay: Annotated[bool, Field(strict=True)] = field_default(
        default=False, description="draw the quantities in one panel, one colour each"
    )
    x: _Column | None = field_default(
        None, description="column along x; default the elbow angle, for designs the first axis"
    )
    colour: _Column | None = field_default(
        None, description="axis with one colour per value; default the load"
    )
    panels: _Column | None = field_default(None, description="axis with one panel per value")
    where: Annotated[tuple[_Filter, ...], *one_or_many({"type": "string"}, 20)] = field_default(
        (),
        max_length=20,
        description='filters, such as "load_mass = 5 kg"; a row must meet all of them',
    )
    unit: Annotated[
        tuple[Annotated[_Text, AfterValidator(_check_unit)], ...],
        *one_or_many({"type": "string"}, 20),
    ] = field_default(
        (), max_length=20, description="units to show, each for its dimension, such as cm"
    )
    format: Annotated[tuple[str, ...], WordField(("png", "svg", "pdf"), is_list=True)] = (
        field_default(("png",), description="png, svg, pdf, or several of them")
    )
    size: Annotated[_Text, AfterValidator(_checked_by(read_size))] = field_default(
        "page",
        description='"column" (85 mm), "page" (175 mm), a width or width x height, such as '
        '"120 x 80 mm"',
    )

    @property
    def named_columns(self) -> tuple[str, ...]:
        """Columns that the figure names: quantities, then x, colour and panels, then filters."""
        optional = [name for name in (self.x, self.colour, self.panels) if name]
        filtered = [condition.name for condition in self.filters]
        return (*self.quantity, *optional, *filtered)

    @property
    def table(self) -> str:
        """Table that has the quantities."""
        return "states" if self.quantity[0] in OF_STATES else "designs"

    @property
    def filters(self) -> list[Filter]:
        """Filters of `where`."""
        return [read_filter(text) for text in self.where]

    @property
    def units(self) -> dict[str, str]:
        """Units to show, by dimension."""
        return {UNITS[symbol].dimension: symbol for symbol in self.unit}


def figure_spec(**given: Any) -> FigureSpec:
    """Return a figure from Python or the command line, by the keys of `[[figure]]`.

    Raises:
        UsageError: A key has a fault; the first is reported.

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
    figures: tuple[FigureSpec, ...],
    axes: Mapping[str, Quantity],
    own_columns: Sequence[str],
    at_fault: set[str],
) -> Iterator[Fault]:
    """Yield the faults of a study's figures: names, columns, overlays and filters.

    Args:
        figures: The figures that the study declares.
        axes: Quantities of the study's numbers, by their keys and by their columns.
        own_columns: Columns that name the rows of the study's tables, or are carried by these.
        at_fault: Dotted keys that are wrong by themselves and were left out.
    """
    names = [figure.name for figure in figures]
    for at, figure in enumerate(figures):
        place = f"figure.{at}"
        if figure.name is not None:
            if figure.name in names[:at]:
                yield Fault(f"{place}.name", f'"{figure.name}" names two figures')
            yield from _column_faults(figure, place, (*axes, *own_columns))
            yield from _overlay_faults(figure, place)
            yield from _filter_faults(figure, place, axes)
        elif f"{place}.name" not in at_fault:
            yield Fault(f"{place}.name", "is missing, each entry of figure needs it")


def _column_faults(figure: FigureSpec, place: str, columns: Sequence[str]) -> Iterator[Fault]:
    """Yield a fault for each column of a figure that its table does not have.

    Args:
        figure: The figure.
        place: Its place in the study, for errors.
        columns: Keys and columns of the study's numbers, and columns of its tables.
    """
    results = OF_STATES if figure.table == "states" else OF_DESIGNS
    varied = (*columns, "direction", "elbow_angle", "case")
    named: list[tuple[str, str | None, tuple[str, ...]]] = [
        ("colour", figure.colour, varied),
        ("panels", figure.panels, varied),
        ("x", figure.x, (*varied, *results)),
    ]
    filterable = (*varied, *OF_STATES, *OF_DESIGNS, *WORDS)
    named += [("where", condition.name, filterable) for condition in figure.filters]
    for key, name, known in named:
        if name is not None and name not in known:
            hint = hint_at_nearest(name, (*varied, *results))
            yield Fault(f"{place}.{key}", f'there is no column "{shorten(name)}"', hint)


def _overlay_faults(figure: FigureSpec, place: str) -> Iterator[Fault]:
    """Yield a fault if an overlay has other colours, or quantities of several dimensions."""
    if not figure.overlay:
        return
    if figure.colour is not None:
        problem = "cannot be given with overlay, which gives the colours to the quantities"
        yield Fault(f"{place}.colour", problem, "leave one of them out; panels takes the axis")
    dimensions = {(QUANTITIES | OF_FIGURES)[name].dimension for name in figure.quantity}
    if len(dimensions) > 1:
        problem = f"{' and '.join(sorted(dimensions))} cannot share a panel"
        yield Fault(f"{place}.overlay", problem, "draw each dimension in a figure of its own")


def _filter_faults(figure: FigureSpec, place: str, axes: Mapping[str, Quantity]) -> Iterator[Fault]:
    """Yield a fault for each filter of a figure whose value its column cannot have."""
    for condition in figure.filters:
        quantity = axes.get(condition.name) or QUANTITIES.get(condition.name)
        if quantity is not None:
            try:
                condition.condition_on(condition.name, quantity)
            except UsageError as error:
                yield Fault(f"{place}.where", error.message, error.hint)
