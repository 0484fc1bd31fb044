"""What the figures of a study name, held against what its tables have."""

# No `from __future__ import annotations` here: pydantic would compile each annotation anew, at every start.

from collections.abc import Iterator, Mapping

from pydantic import ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from tendon_cli.errors import UsageError
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.studies.figures import OF_DESIGNS, OF_STATES, WORDS, FigureSpec, near, quantity_of
from tendon_cli.units import shorten


def check_figures(figures: tuple[FigureSpec, ...], axes: Mapping[str, tuple[str, Quantity]]) -> tuple[FigureSpec, ...]:
    """The figures of a study as they are; raises for every name in them that the tables do not have.

    `axes` has the column and the quantity of every number of a study, by its dotted key.
    """
    found: list[InitErrorDetails] = []
    for at, figure in enumerate(figures):
        if figure.name is None:
            found.append(InitErrorDetails(type="missing", loc=(at, "name"), input={}))
            continue
        if figure.name in {other.name for other in figures[:at]}:
            found.append(_error((at, "name"), figure.name, f'"{figure.name}" names two figures'))
        found += [_error((at, key), text, problem, hint) for key, text, problem, hint in _faults(figure, axes)]
    if found:
        raise ValidationError.from_exception_data("figure", found)
    return figures


def _error(place: tuple[int | str, ...], given: str, problem: str, hint: str | None = None) -> InitErrorDetails:
    error = PydanticCustomError("tendon", "{problem}", {"problem": problem, "hint": hint})
    return InitErrorDetails(type=error, loc=place, input=given)


_Found = tuple[str, str, str, str | None]
"""Key, text, problem and hint."""


def _faults(figure: FigureSpec, axes: Mapping[str, tuple[str, Quantity]]) -> Iterator[_Found]:
    """What names a column or a value that cannot be."""
    quantities = {name: quantity for key, (column, quantity) in axes.items() for name in (key, column)}
    results = OF_STATES if figure.table == "states" else OF_DESIGNS
    known = (*quantities, "direction", "elbow_angle", "case")
    given = (("x", (*known, *results)), ("colour", known), ("panels", known))
    for key, names in given:
        name = getattr(figure, key)
        if name is not None and name not in names:
            yield key, name, f'there is no column "{shorten(name)}"', near(name, names)
    if figure.overlay:
        yield from _overlay_faults(figure)
    for each in figure.filters:
        if each.name not in (*known, *OF_STATES, *OF_DESIGNS, *WORDS):
            yield "where", each.text, f'there is no column "{shorten(each.name)}"', near(each.name, (*known, *results))
        quantity = quantities.get(each.name) or QUANTITIES.get(each.name)
        try:
            each.on(each.name, quantity) if quantity else None
        except UsageError as error:
            yield "where", each.text, error.message, error.hint


def _overlay_faults(figure: FigureSpec) -> Iterator[_Found]:
    if figure.colour is not None:
        hint = "leave one of them out; panels takes the axis"
        yield "colour", figure.colour, "stands beside overlay, which gives the colours to the quantities", hint
    dimensions = {quantity_of(name).dimension for name in figure.quantity}
    if len(dimensions) > 1:
        yield "overlay", "true", f"{' and '.join(sorted(dimensions))} cannot share a panel", "one dimension in each"
