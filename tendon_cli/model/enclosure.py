"""Interval arithmetic on Taylor series in one variable: enclosures of a function and its derivatives over cells.

An interval is a midpoint and a radius, which grows by what each operation may round (outward rounding). A `Series` has
intervals of f, f', f''/2 ... over each cell of the variable, by the usual recurrences, and of what it does where other
numbers move, its partial derivatives, as series of lower order. Nothing here knows of joints.
Arrays broadcast. What cannot be enclosed, as 1/f where f may vanish, has an infinite radius or is NaN.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Interval = tuple[Any, Any]
"""Midpoint and radius, arrays or numbers."""

ORDER = 4
_ORDER_OF_PARTIALS = 3
"""Terms of a partial derivative: as many as the slope of a slope takes."""
_UNIT = 2.0**-52
"""Of a result: twice what rounding to the nearest may change."""
_OUT, _TINY = 1.0 + 2.0**-48, 1e-290
"""A radius is rounded, too, and may vanish."""
_FUNCTIONS = 2.0**-49
"""Of the largest value: what NumPy's sine, cosine and exponential may be off."""
_COMPUTED = 1e-14
"""Of a value: what a few operations of the model on plain numbers may be off."""
_TERMS = 60
"""Of a power series of e^z, for |z| up to 10."""
_PARTS: tuple[Interval, ...] = tuple((1.0 / part, _UNIT) for part in (1, 1, 2, 6, 24))
"""1/n!."""


def _added(a: Interval, b: Interval) -> Interval:
    middle = a[0] + b[0]
    return middle, (a[1] + b[1] + _UNIT * abs(middle)) * _OUT


def _times(a: Interval, b: Interval) -> Interval:
    middle = a[0] * b[0]
    return middle, (abs(a[0]) * b[1] + a[1] * (abs(b[0]) + b[1]) + _UNIT * abs(middle)) * _OUT + _TINY


def _inverse(a: Interval) -> Interval:
    size = abs(a[0])
    least = size - a[1] * _OUT
    middle = 1.0 / a[0]
    return middle, np.where(least > 0.0, (a[1] / (size * least) + _UNIT * abs(middle)) * _OUT, np.inf)


def _root(a: Interval) -> Interval:
    middle, least = np.sqrt(a[0]), np.sqrt(a[0] - a[1] * _OUT)
    return middle, (a[1] / (middle + least) + _UNIT * middle) * _OUT


class Series:
    """f, f', f''/2 ... of a function over cells, each an interval, or None where it is exactly zero."""

    def __init__(self, terms: Sequence[Interval | None], partials: Mapping[int, Series] | None = None) -> None:
        self.terms, self.partials = tuple(terms), partials or {}

    @classmethod
    def of(cls, value: Any) -> Series:
        """A constant as it is; a series itself."""
        return (
            value if isinstance(value, Series) else cls([(np.asarray(value, dtype=np.float64), 0.0)] + [None] * ORDER)
        )

    @classmethod
    def near(cls, value: Any) -> Series:
        """A constant that the model worked out in plain numbers; a series itself."""
        if isinstance(value, Series):
            return value
        middle = np.asarray(value, dtype=np.float64)
        return cls([(middle, _COMPUTED * np.abs(middle))] + [None] * ORDER)

    @classmethod
    def variable(cls, middle: Array, half: Array, order: int) -> Series:
        """The variable itself over cells about `middle`."""
        return cls([(middle, half), (1.0, 0.0), *[None] * (order - 1)])

    @classmethod
    def number(cls, middle: Array, radius: Array, slope: Array, place: int) -> Series:
        """A number that is within a radius of `middle`, and moves by `slope` with the variable at a place besides."""
        about = (abs(middle) + abs(slope)) * _COMPUTED
        moves = cls([(slope, about), *[None] * (_ORDER_OF_PARTIALS - 1)])
        return cls([(middle, radius * _OUT + about), *[None] * ORDER], {place: moves})

    @property
    def alone(self) -> Series:
        """The same without partial derivatives."""
        return Series(self.terms)

    def _moving(self, terms: Sequence[Interval | None], slope: Callable[[], Series]) -> Series:
        """A function of it by its terms, and its derivative, which is asked for only if something moves."""
        if not self.partials:
            return Series(terms)
        by = slope()
        return Series(terms, {place: by * moves for place, moves in self.partials.items()})

    def elongation(self) -> Series:
        """(e^f - 1)/f, whose n-th derivative is the integral of t^n e^(tf) over t from 0 to 1: it rises everywhere."""
        middle, radius = _some(self.terms[0])

        def derivative(n: int, at: Array) -> Array:
            power, total = np.ones(np.shape(at)), np.zeros(np.shape(at))
            for term in range(_TERMS):
                total, power = total + power / (n + term + 1), power * at / (term + 1)
            return total

        most, count = abs(middle) + radius, len(_PARTS) + bool(self.partials)
        radii = [radius * derivative(n + 1, most) * _OUT + _FUNCTIONS * derivative(n, most) for n in range(count)]
        values = [(derivative(n, middle), of_value) for n, of_value in enumerate(radii)]
        return self._moving(_following(self.terms, values), lambda: Series(_following(self.terms, values[1:])))

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **_: Any) -> Any:
        """NumPy's operators on arrays and series, and the smaller and larger of two that do not cross."""
        if ufunc is np.isnan:
            return np.isnan(_some(inputs[0].terms[0])[0])
        a, b = map(Series.of, inputs) if len(inputs) == 2 else (None, None)
        if method != "__call__" or a is None or b is None or ufunc not in _UFUNCS:
            return NotImplemented
        return _UFUNCS[ufunc](a, b)

    def __array_function__(self, function: Any, _: Any, inputs: Any, __: Any) -> Any:
        """`np.where`, where the same is chosen everywhere."""
        if function is not np.where or len(choice := np.unique(inputs[0])) > 1:
            return NotImplemented
        return inputs[1 if choice[0] else 2]

    def __add__(self, other: Any) -> Series:
        given = Series.of(other)
        pairs = zip(self.terms, given.terms, strict=False)
        partials = {**given.partials, **self.partials}
        for place in self.partials.keys() & given.partials.keys():
            partials[place] = self.partials[place] + given.partials[place]
        return Series([_added(a, b) if a and b else a or b for a, b in pairs], partials)

    def __neg__(self) -> Series:
        terms = [None if a is None else (-a[0], a[1]) for a in self.terms]
        return Series(terms, {place: -moves for place, moves in self.partials.items()})

    def __sub__(self, other: Any) -> Series:
        return self + -Series.of(other)

    def __mul__(self, other: Any) -> Series:
        given = Series.of(other)
        a, b = self.terms, given.terms
        product = Series([_dot(a[: place + 1], b[: place + 1]) for place in range(min(len(a), len(b)))])
        for one, factor in ((self, given), (given, self)):
            if one.partials:
                product = product + Series(
                    [None] * (ORDER + 1), {k: of * factor.alone for k, of in one.partials.items()}
                )
        return product

    def __truediv__(self, other: Any) -> Series:
        given = Series.of(other)
        if self.partials or given.partials:
            quotient = self.alone / given.alone
            moves = Series([None] * (ORDER + 1), self.partials) - quotient * Series(
                [None] * (ORDER + 1), given.partials
            )
            each = {place: moved / given.alone for place, moved in moves.partials.items()}
            return Series(quotient.terms, each)
        below = given.terms
        over = _inverse(_some(below[0]))
        terms: list[Interval | None] = []
        for place in range(min(len(self.terms), len(below))):
            rest = _less(self.terms[place], _dot([*terms, None], below[: place + 1]))
            terms.append(rest and _times(rest, over))
        return Series(terms)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: Any) -> Series:
        return Series.of(other) - self

    def __rtruediv__(self, other: Any) -> Series:
        return Series.of(other) / self

    def root(self) -> Series:
        """Its square root."""
        first = _root(_some(self.terms[0]))
        terms: list[Interval | None] = [first]
        over = _inverse((2.0 * first[0], 2.0 * first[1]))
        for place in range(1, len(self.terms)):
            rest = _less(self.terms[place], _dot([None, *terms[1:], None], [None, *terms[1:], None]))
            terms.append(rest and _times(rest, over))
        return self._moving(terms, lambda: 0.5 / Series(terms))

    def slope(self) -> Series:
        """Its derivative, of one order less."""
        terms = [term and _times(term, (place, 0.0)) for place, term in enumerate(self.terms) if place]
        return Series(terms, {place: moves.slope() for place, moves in self.partials.items()})

    def exp(self) -> Series:
        """e to it."""
        middle, radius = _some(self.terms[0])
        value = np.exp(middle)
        first = value, value * (np.expm1(radius) + _FUNCTIONS) * _OUT
        terms = _following(self.terms, [first] * len(_PARTS))
        return self._moving(terms, lambda: Series(terms))

    def circular(self) -> tuple[Series, Series]:
        """Its sine and cosine."""
        middle, radius = _some(self.terms[0])
        curved = 0.5 * radius * radius * _OUT + _FUNCTIONS
        sine, cosine = np.sin(middle), np.cos(middle)
        of_sine, of_cosine = (np.abs(slope) * radius * _OUT + curved for slope in (cosine, sine))
        signed = ((sine, of_sine), (cosine, of_cosine), (-sine, of_sine), (-cosine, of_cosine))
        both = [_following(self.terms, [signed[(n + ahead) % 4] for n in range(len(_PARTS))]) for ahead in (0, 1)]
        return self._moving(both[0], lambda: Series(both[1])), self._moving(both[1], lambda: -Series(both[0]))


def _following(terms: Sequence[Interval | None], derivatives: Sequence[Interval]) -> tuple[Interval | None, ...]:
    """g(f) by the terms of f, from enclosures of g, g', g'' ... over the values of f."""
    change, power, total = Series([None, *terms[1:]]), Series.of(1.0), Series.of(0.0)
    for derivative, part in zip(derivatives, _PARTS, strict=False):
        total, power = total + power * Series([_times(derivative, part), *[None] * ORDER]), power * change
    return total.terms


def _extreme(choose: Any) -> Any:
    """The smaller, or larger, of two series; where they may cross all that either is."""

    def of(a: Series, b: Series) -> Series:
        first, other = _some(a.terms[0]), _some(b.terms[0])
        apart, is_first = abs(first[0] - other[0]) > first[1] + other[1], choose(first[0], other[0]) == first[0]

        def either(one: Interval | None, two: Interval | None) -> Interval:
            (value, about), (another, about_it) = _some(one), _some(two)
            hull = (abs(value - another) + about + about_it) * _OUT
            middle = np.where(is_first, value, another)
            return middle, np.where(apart, np.where(is_first, about, about_it), hull)

        def all_of(one: Series, two: Series) -> list[Interval | None]:
            return [either(*both) for both in zip(one.terms, two.terms, strict=False)]

        still = Series([None] * _ORDER_OF_PARTIALS)
        places = a.partials.keys() | b.partials.keys()
        moves = {at: Series(all_of(a.partials.get(at, still), b.partials.get(at, still))) for at in places}
        return Series(all_of(a, b), moves)

    return of


_UFUNCS = {
    np.add: Series.__add__,
    np.subtract: Series.__sub__,
    np.multiply: Series.__mul__,
    np.true_divide: Series.__truediv__,
    np.minimum: _extreme(np.minimum),
    np.maximum: _extreme(np.maximum),
}


def _some(term: Interval | None) -> Interval:
    return term or (np.zeros(()), 0.0)


def _less(a: Interval | None, b: Interval | None) -> Interval | None:
    return a if b is None else _added(_some(a), (-b[0], b[1]))


def _dot(a: Sequence[Interval | None], b: Sequence[Interval | None]) -> Interval | None:
    """The highest term of a product, from as many terms of both."""
    total: Interval | None = None
    for one, other in zip(a, reversed(b), strict=True):
        if one and other:
            total = _added(total, _times(one, other)) if total else _times(one, other)
    return total
