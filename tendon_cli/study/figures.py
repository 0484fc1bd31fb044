"""`[[figure]]`: the figures that a study wants of its run. They change neither its tables nor its hash."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at every start.

import difflib
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, StringConstraints, ValidationError, WithJsonSchema
from pydantic_core import InitErrorDetails, PydanticCustomError, PydanticKnownError

from tendon_cli import quantities
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.study.derived import DERIVED
from tendon_cli.study.fields import fault
from tendon_cli.study.parts import Part
from tendon_cli.units import UnitError, parse_measure, shorten

MOST_QUANTITIES = 8
OF_STATES = (*quantities.OF_STATES, *DERIVED)
OF_DESIGNS = quantities.OF_DESIGNS
WORDS = ("direction", "status", "case", "taut", "stable", "feasible", "design")
"""Columns that are no quantities."""

_SIZE = re.compile(r"column|page|([\d.]+)(?:\s*[x×]\s*([\d.]+))?\s*(mm|cm|in)")
_SMALLEST, _LARGEST = 0.04, 1.0
_COLUMN = {"type": "string", "pattern": r"^[A-Za-z_][\w.]{0,99}$"}
_FILTER = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(<=|>=|!=|==|=|<|>|\bin\b)\s*(.+?)\s*")


def _as_list(value: object) -> object:
    return [value] if isinstance(value, str) else value


def _near(name: str, known: tuple[str, ...]) -> str | None:
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return f'did you mean "{near[0]}"?' if near else None


def _not_a_slack_map(name: str) -> str:
    if name.startswith("slack_map") or set(name) == {"."}:
        raise fault(f'"{name}" cannot name a figure', "slack_map is what the slack maps are called")
    return name


def _quantities(names: tuple[str, ...]) -> tuple[str, ...]:
    """Known names, all of one table, each once."""
    for name in names:
        if name not in OF_STATES and name not in OF_DESIGNS:
            hint = _near(name, (*OF_STATES, *OF_DESIGNS)) or "a result of the states or of the designs"
            raise fault(f'"{shorten(name)}" is not a quantity of a table', hint)
        if names.count(name) > 1:
            raise fault(f'"{name}" stands in the list twice, expected each quantity once')
    if len({name in OF_STATES for name in names}) > 1:
        state, design = (next(name for name in names if name in table) for table in (OF_STATES, OF_DESIGNS))
        raise fault(f"{state} is of the states and {design} of the designs, a figure shows one table")
    return names


def _size(text: str) -> str:
    match = _SIZE.fullmatch(text.strip()) if len(text) < 60 else None
    hint = '"column", "page", "120 mm" or "120 x 80 mm"'
    if match is None:
        raise fault(f'"{shorten(text)}" is not a size', hint)
    try:
        sides = [parse_measure(f"{side} {match[3]}", "length").si for side in match.groups()[:2] if side]
    except UnitError as error:
        raise fault(error.problem, hint) from None
    if not all(_SMALLEST <= side <= _LARGEST for side in sides):
        raise fault(f'"{shorten(text)}" is out of range, a side has 40 mm to 1000 mm')
    return text


def _no_endless_name(name: str) -> str:
    if len(name) > 100:
        raise PydanticKnownError("string_pattern_mismatch", {"pattern": _COLUMN["pattern"]})
    return name


def _filter(text: str) -> str:
    if len(text) > 500 or not _FILTER.fullmatch(text):
        hint = 'such as "load_mass = 5 kg", "elbow_angle <= 60 deg" or "load_mass in 3 kg, 5 kg"'
        raise fault(f'"{shorten(text)}" is not a filter', hint)
    return text


_Text = Annotated[str, StringConstraints(strict=True)]
_Format = Literal["png", "svg", "pdf"]
_Column = Annotated[  # its length is counted, since the pattern of the schema takes 10 ms to build, once per field
    str,
    StringConstraints(strict=True, pattern=r"^[A-Za-z_][\w.]*$"),
    AfterValidator(_no_endless_name),
    WithJsonSchema(_COLUMN),
]
_Filter = Annotated[_Text, AfterValidator(_filter)]


def _one_or_many(item: dict[str, Any], most: int) -> WithJsonSchema:
    return WithJsonSchema({"anyOf": [item, {"type": "array", "items": item, "minItems": 1, "maxItems": most}]})


class DeclaredFigure(Part):
    """A figure that `tendon sweep` draws of the tables, beside them."""

    name: Annotated[
        str, StringConstraints(pattern=r"^[A-Za-z0-9._-]{1,64}$", strict=True), AfterValidator(_not_a_slack_map)
    ] = Field(description="stem of the figure's file, each once")
    title: Annotated[str, StringConstraints(max_length=300, strict=True)] = Field(
        default="", description="above the panels; default the title of the study"
    )
    quantity: Annotated[
        tuple[_Text, ...],
        BeforeValidator(_as_list),
        Field(min_length=1, max_length=MOST_QUANTITIES),
        AfterValidator(_quantities),
        _one_or_many({"enum": [*OF_STATES, *OF_DESIGNS]}, MOST_QUANTITIES),
    ] = Field(description="what is drawn: one or more results of the states, or of the designs; a panel each")
    overlay: Annotated[bool, Field(strict=True)] = Field(
        default=False, description="draw the quantities in one panel, told apart by colour"
    )
    x: _Column | None = Field(
        default=None, description="column along x; default the elbow angle, or of designs the first axis"
    )
    colour: _Column | None = Field(default=None, description="axis with one colour per value; default the load")
    panels: _Column | None = Field(default=None, description="axis with one panel per value")
    where: Annotated[tuple[_Filter, ...], BeforeValidator(_as_list), _one_or_many({"type": "string"}, 20)] = Field(
        default=(), max_length=20, description='filters, such as "load_mass = 5 kg"; all of them hold'
    )
    format: Annotated[
        tuple[_Format, ...],
        BeforeValidator(_as_list),
        Field(min_length=1, max_length=3),
        _one_or_many({"enum": ["png", "svg", "pdf"]}, 3),
    ] = Field(default=("png",), description="png, svg, pdf, or several of them")
    size: Annotated[_Text, AfterValidator(_size)] = Field(
        default="page",
        description='"column" (85 mm), "page" (175 mm), a width or width x height, such as "120 x 80 mm"',
    )

    @property
    def table(self) -> str:
        """The table that has its quantities."""
        return "states" if self.quantity[0] in OF_STATES else "designs"


def check_figures(
    figures: tuple[DeclaredFigure, ...], axes: Mapping[str, tuple[str, Quantity]]
) -> tuple[DeclaredFigure, ...]:
    """The figures as they are; raises for every name in them that the tables do not have.

    `axes` has the column and the quantity of every number of a study, by its dotted key.
    """
    found: list[InitErrorDetails] = []
    for at, figure in enumerate(figures):
        if figure.name in {other.name for other in figures[:at]}:
            found.append(_error((at, "name"), figure.name, f'"{figure.name}" names two figures'))
        found += [_error((at, key), text, problem, hint) for key, text, problem, hint in _faults(figure, axes)]
    if found:
        raise ValidationError.from_exception_data("figure", found)
    return figures


def _error(place: tuple[int | str, ...], given: str, problem: str, hint: str | None = None) -> InitErrorDetails:
    error = PydanticCustomError("tendon", "{problem}", {"problem": problem, "hint": hint})
    return InitErrorDetails(type=error, loc=place, input=given)


def _faults(
    figure: DeclaredFigure, axes: Mapping[str, tuple[str, Quantity]]
) -> Iterator[tuple[str, str, str, str | None]]:
    """Key, text, problem and hint for each name that cannot be."""
    quantities = {name: quantity for key, (column, quantity) in axes.items() for name in (key, column)}
    results = OF_STATES if figure.table == "states" else OF_DESIGNS
    known = (*quantities, "direction", "elbow_angle", "case")
    given = (("x", (*known, *results)), ("colour", known), ("panels", known))
    for key, names in given:
        name = getattr(figure, key)
        if name is not None and name not in names:
            yield key, name, f'there is no column "{shorten(name)}"', _near(name, names)
    if figure.overlay:
        yield from _overlay_faults(figure)
    for text in figure.where:
        name, relation, value = _parts(text)
        if name not in (*known, *OF_STATES, *OF_DESIGNS, *WORDS):
            yield "where", text, f'there is no column "{shorten(name)}"', _near(name, (*known, *results))
        quantity = quantities.get(name) or QUANTITIES.get(name)
        yield from _value_faults(text, relation, value, quantity)


def _overlay_faults(figure: DeclaredFigure) -> Iterator[tuple[str, str, str, str | None]]:
    if figure.colour is not None:
        hint = "leave one of them out; panels takes the axis"
        yield "colour", figure.colour, "stands beside overlay, which gives the colours to the quantities", hint
    dimensions = {quantity_of(name).dimension for name in figure.quantity}
    if len(dimensions) > 1:
        yield "overlay", "true", f"{' and '.join(sorted(dimensions))} cannot share a panel", "one dimension in each"


def quantity_of(name: str) -> Quantity:
    """A quantity that a figure may show, the derived ones included."""
    return DERIVED[name].quantity if name in DERIVED else QUANTITIES[name]


def _parts(text: str) -> tuple[str, str, str]:
    match = _FILTER.fullmatch(text)
    return (match[1], match[2], match[3]) if match else ("", "", "")


def _value_faults(
    text: str, relation: str, value: str, quantity: Quantity | None
) -> Iterator[tuple[str, str, str, str | None]]:
    """A number with a unit that does not fit its column."""
    pieces = value.strip("[]").split(",") if relation == "in" else [value]
    for piece in pieces if quantity else ():
        try:
            parse_measure(piece.strip(), quantity.dimension if quantity else "")
        except UnitError as error:
            yield "where", text, f'"{shorten(text)}": {error.problem}', error.hint
