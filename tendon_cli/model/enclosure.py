"""Interval arithmetic on Taylor series in one variable: enclosures of a function and its derivatives over cells.

An interval is a midpoint and a radius, which grows by what each operation may round (outward rounding). A `Series` has
intervals of f, f', f''/2 ... over each cell of the variable, by the usual recurrences, and of what it does where other
numbers move, its partial derivatives, as series of lower order. Nothing here knows of joints.
Arrays broadcast. What cannot be enclosed, as 1/f where f may vanish, has an infinite radius or is NaN.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Interval = tuple[Any, Any]
"""Midpoint and radius, arrays or numbers."""

ORDER = 4
_ORDER_OF_PARTIALS = 3  # terms of a partial derivative: as many as the slope of a slope takes
_UNIT = 2.0**-52  # of a result: twice what rounding to the nearest may change
_OUT, _TINY = 1.0 + 2.0**-48, 1e-290  # a radius is rounded, too, and may vanish
_FUNCTIONS = 2.0**-49  # of the largest value: what NumPy's sine, cosine and exponential may be off
COMPUTED = 1e-14
"""Of a value: what a few operations of the model on plain numbers may be off."""
_TERMS = 60  # of a power series of e^z, for |z| up to 10
_PARTS: tuple[Interval, ...] = tuple((1.0 / part, _UNIT) for part in (1, 1, 2, 6, 24))  # 1/n!
_DERIVATIVES = range(len(_PARTS) + 1)


def _added(a: Interval, b: Interval) -> Interval:
    middle = a[0] + b[0]
    return middle, (a[1] + b[1] + _UNIT * abs(middle)) * _OUT


def _times(a: Interval, b: Interval) -> Interval:
    middle = a[0] * b[0]
    return middle, (
        abs(a[0]) * b[1] + a[1] * (abs(b[0]) + b[1]) + _UNIT * abs(middle)
    ) * _OUT + _TINY


def _inverse(a: Interval) -> Interval:
    size = abs(a[0])
    least = size - a[1] * _OUT
    middle = 1.0 / a[0]
    return middle, np.where(
        least > 0.0, (a[1] / (size * least) + _UNIT * abs(middle)) * _OUT, np.inf
    )


def _root(a: Interval) -> Interval:
    middle, least = np.sqrt(a[0]), np.sqrt(a[0] - a[1] * _OUT)
    return middle, (a[1] / (middle + least) + _UNIT * middle) * _OUT


class Series(np.lib.mixins.NDArrayOperatorsMixin):
    """f, f', f''/2 ... of a function over cells, each an interval, or None where it is exactly zero."""

    def __init__(
        self, terms: Sequence[Interval | None], partials: Mapping[int, Series] | None = None
    ) -> None:
        self.terms, self.partials = tuple(terms), partials or {}

    @classmethod
    def of(cls, value: Any, rounded: float = 0.0) -> Series:
        """A constant as it is, or but for a share that plain numbers are off; a series itself."""
        if isinstance(value, Series):
            return value
        middle = np.asarray(value, dtype=np.float64)
        return cls([(middle, rounded * np.abs(middle) if rounded else 0.0), *[None] * ORDER])

    @classmethod
    def variable(cls, middle: Array, half: Array, order: int) -> Series:
        """The variable itself over cells about `middle`."""
        return cls([(middle, half), (1.0, 0.0), *[None] * (order - 1)])

    @classmethod
    def number(cls, middle: Array, radius: Array, slope: Array, place: int) -> Series:
        """A number that is within a radius of `middle`, and moves by `slope` with the variable at a place besides."""
        about = (abs(middle) + abs(slope)) * COMPUTED
        moves = cls([(slope, about), *[None] * (_ORDER_OF_PARTIALS - 1)])
        return cls([(middle, radius * _OUT + about), *[None] * ORDER], {place: moves})

    @classmethod
    def _moved(cls, partials: Mapping[int, Series]) -> Series:
        return cls([None] * (ORDER + 1), partials)

    @property
    def value(self) -> Interval:
        """What it may be."""
        return self.terms[0] or (np.zeros(()), 0.0)

    @property
    def real(self) -> Any:
        """The middle of that, by which a curve knows its piece."""
        return self.value[0]

    def slope(self) -> Series:
        """Its derivative, of one order less."""
        terms = [
            term and _times(term, (place, 0.0)) for place, term in enumerate(self.terms) if place
        ]
        return Series(terms, {place: moves.slope() for place, moves in self.partials.items()})

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **_: Any) -> Any:
        """NumPy's operators and functions on arrays and series."""
        if method != "__call__" or ufunc not in _UFUNCS:
            return NotImplemented
        return _UFUNCS[ufunc](*map(Series.of, inputs))

    def __array_function__(self, function: Any, _: Any, inputs: Any, __: Any) -> Any:
        """`np.where` alone."""
        return (
            _chosen(inputs[0], *map(Series.of, inputs[1:]))
            if function is np.where
            else NotImplemented
        )

    def _composed(self, derivatives: Sequence[Interval]) -> Series:
        """g(f), from enclosures of g, g', g'' ... over the values of f, one more than there are terms."""

        def following(each: Sequence[Interval]) -> Series:
            change, power, total = Series([None, *self.terms[1:]]), Series.of(1.0), Series.of(0.0)
            for derivative, part in zip(each, _PARTS, strict=False):
                total, power = (
                    total + power * Series([_times(derivative, part), *[None] * ORDER]),
                    power * change,
                )
            return total

        slope = following(derivatives[1:]) if self.partials else Series.of(0.0)
        return Series(
            following(derivatives).terms,
            {place: slope * moves for place, moves in self.partials.items()},
        )

    def added(self, other: Series) -> Series:
        """Their sum."""
        pairs, partials = (
            zip(self.terms, other.terms, strict=False),
            {**other.partials, **self.partials},
        )
        for place in self.partials.keys() & other.partials.keys():
            partials[place] = self.partials[place] + other.partials[place]
        return Series([_added(a, b) if a and b else a or b for a, b in pairs], partials)

    def negative(self) -> Series:
        """Less than nothing by as much."""
        terms = [None if a is None else (-a[0], a[1]) for a in self.terms]
        return Series(terms, {place: -moves for place, moves in self.partials.items()})

    def times(self, other: Series) -> Series:
        """Their product."""
        a, b = self.terms, other.terms
        product = Series(
            [_dot(a[: place + 1], b[: place + 1]) for place in range(min(len(a), len(b)))]
        )
        for one, factor in ((self, other), (other, self)):
            if one.partials:
                product = product + Series._moved(
                    {at: moves * Series(factor.terms) for at, moves in one.partials.items()}
                )
        return product

    def over(self, other: Series) -> Series:
        """Their quotient."""
        if self.partials or other.partials:
            below = Series(other.terms)
            quotient = Series(self.terms) / below
            moves = Series._moved(self.partials) - quotient * Series._moved(other.partials)
            return Series(
                quotient.terms, {place: each / below for place, each in moves.partials.items()}
            )
        per = _inverse(other.value)
        terms: list[Interval | None] = []
        for place in range(min(len(self.terms), len(other.terms))):
            rest = _less(self.terms[place], _dot([*terms, None], other.terms[: place + 1]))
            terms.append(rest and _times(rest, per))
        return Series(terms)

    def root(self) -> Series:
        """Its square root."""
        middle, radius = _root(self.value)
        terms: list[Interval | None] = [(middle, radius)]
        per = _inverse((2.0 * middle, 2.0 * radius))
        for known in self.terms[1:]:
            rest = _less(known, _dot([None, *terms[1:], None], [None, *terms[1:], None]))
            terms.append(rest and _times(rest, per))
        return Series(
            terms, {place: 0.5 / Series(terms) * moves for place, moves in self.partials.items()}
        )

    def exp(self) -> Series:
        """e to it."""
        value, radius = np.exp(self.value[0]), self.value[1]
        return self._composed(
            [(value, value * (np.expm1(radius) + _FUNCTIONS) * _OUT) for _ in _DERIVATIVES]
        )

    def sine(self, ahead: int = 0) -> Series:
        """Its sine, or what is so many quarters of a turn ahead of that."""
        middle, radius = self.value
        sine, cosine = np.sin(middle), np.cos(middle)
        curved = 0.5 * radius * radius * _OUT + _FUNCTIONS
        turns = ((sine, cosine), (cosine, sine), (-sine, cosine), (-cosine, sine))
        each = [(value, np.abs(slope) * radius * _OUT + curved) for value, slope in turns]
        return self._composed([each[(n + ahead) % 4] for n in _DERIVATIVES])

    def elongation(self) -> Series:
        """(e^f - 1)/f, whose n-th derivative is the integral of t^n e^(tf) over t from 0 to 1: it rises everywhere."""
        middle, radius = self.value

        def derivative(n: int, at: Array) -> Array:
            power, total = np.ones(np.shape(at)), np.zeros(np.shape(at))
            for term in range(_TERMS):
                total, power = total + power / (n + term + 1), power * at / (term + 1)
            return total

        most = abs(middle) + radius
        radii = [
            radius * derivative(n + 1, most) * _OUT + _FUNCTIONS * derivative(n, most)
            for n in _DERIVATIVES
        ]
        return self._composed([(derivative(n, middle), about) for n, about in enumerate(radii)])


def _chosen(which: Any, a: Series, b: Series, apart: Any = True) -> Series:
    """One series or the other; where they are not apart all that either is."""

    def all_of(one: Series, two: Series) -> Series:
        terms: list[Interval | None] = []
        for first, second in zip(one.terms, two.terms, strict=False):
            (value, about), (other, about_other) = (each or (0.0, 0.0) for each in (first, second))
            hull = (abs(value - other) + about + about_other) * _OUT
            terms.append(
                (
                    np.where(which, value, other),
                    np.where(apart, np.where(which, about, about_other), hull),
                )
            )
        return Series(terms)

    still, places = Series([None] * _ORDER_OF_PARTIALS), a.partials.keys() | b.partials.keys()
    moves = {at: all_of(a.partials.get(at, still), b.partials.get(at, still)) for at in places}
    return Series(all_of(a, b).terms, moves)


def _extreme(choose: Any, a: Series, b: Series) -> Series:
    """The smaller, or larger, of two series."""
    (value, about), (other, about_other) = a.value, b.value
    return _chosen(choose(value, other) == value, a, b, abs(value - other) > about + about_other)


_UFUNCS: dict[Any, Callable[..., Any]] = {
    np.add: Series.added,
    np.subtract: lambda a, b: a + -b,
    np.negative: Series.negative,
    np.multiply: Series.times,
    np.true_divide: Series.over,
    np.square: lambda a: a * a,
    np.sqrt: Series.root,
    np.exp: Series.exp,
    np.sin: Series.sine,
    np.cos: lambda a: a.sine(1),
    np.minimum: partial(_extreme, np.minimum),
    np.maximum: partial(_extreme, np.maximum),
    np.isnan: lambda a: np.isnan(a.real),
}


def _less(a: Interval | None, b: Interval | None) -> Interval | None:
    return a if b is None else _added(a or (np.zeros(()), 0.0), (-b[0], b[1]))


def _dot(a: Sequence[Interval | None], b: Sequence[Interval | None]) -> Interval | None:
    """The highest term of a product, from as many terms of both."""
    total: Interval | None = None
    for one, other in zip(a, reversed(b), strict=True):
        if one and other:
            total = _added(total, _times(one, other)) if total else _times(one, other)
    return total
