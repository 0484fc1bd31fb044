"""Interval arithmetic on Taylor series in one variable: enclosures of a function over cells.

An interval is a midpoint and a radius, which grows by what each operation may round (outward
rounding). A `Series` holds intervals of f, f', f''/2 ... over each cell of the variable, by the
usual recurrences. It also holds the partial derivatives of f with respect to other numbers, as
series of lower order. This module knows nothing of joints.

Arrays broadcast. What cannot be enclosed, such as 1/f where f may vanish, has an infinite radius
or is NaN.
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
Term = Interval | None
"""Coefficient of a series; None if it is exactly zero."""

ORDER = 4
"""Highest power of a series over a cell."""
COMPUTED = 1e-14
"""Relative error that a few operations of the model on plain numbers may have."""
_ORDER_OF_PARTIALS = 3  # terms of a partial derivative: as many as the slope of a slope takes
_UNIT = 2.0**-52  # of a result: twice what rounding to the nearest may change
_OUT = 1.0 + 2.0**-48  # a radius is rounded, too
_TINY = 1e-290  # a radius may underflow to zero
_FUNCTIONS = 2.0**-49  # relative error of NumPy's sine, cosine and exponential
_EXPONENTIAL_TERMS = 60  # of the power series of e^z, for |z| up to 10
_INVERSE_FACTORIALS: tuple[Interval, ...] = tuple(
    (1.0 / factorial, _UNIT) for factorial in (1, 1, 2, 6, 24)
)
_DERIVATIVES = range(len(_INVERSE_FACTORIALS) + 1)


# --- Intervals -----------------------------------------------------------------------------------


def _zero() -> Interval:
    return np.zeros(()), 0.0


def _add(a: Interval, b: Interval) -> Interval:
    middle = a[0] + b[0]
    radius = (a[1] + b[1] + _UNIT * abs(middle)) * _OUT
    return middle, radius


def _multiply(a: Interval, b: Interval) -> Interval:
    middle = a[0] * b[0]
    spread = abs(a[0]) * b[1] + a[1] * (abs(b[0]) + b[1])
    radius = (spread + _UNIT * abs(middle)) * _OUT + _TINY
    return middle, radius


def _invert(a: Interval) -> Interval:
    size = abs(a[0])
    least = size - a[1] * _OUT
    middle = 1.0 / a[0]
    radius = (a[1] / (size * least) + _UNIT * abs(middle)) * _OUT
    return middle, np.where(least > 0.0, radius, np.inf)


def _square_root(a: Interval) -> Interval:
    middle = np.sqrt(a[0])
    least = np.sqrt(a[0] - a[1] * _OUT)
    radius = (a[1] / (middle + least) + _UNIT * middle) * _OUT
    return middle, radius


def _add_terms(a: Term, b: Term) -> Term:
    if a is None:
        return b
    if b is None:
        return a
    return _add(a, b)


def _subtract_terms(a: Term, b: Term) -> Term:
    if b is None:
        return a
    return _add(a or _zero(), (-b[0], b[1]))


def _highest_term(a: Sequence[Term], b: Sequence[Term]) -> Term:
    """Return the highest term of the product of two series of equally many terms."""
    return _product_term(a, b, len(a) - 1)


def _product_term(a: Sequence[Term], b: Sequence[Term], power: int) -> Term:
    """Return the term of one power of the product of two series."""
    total: Term = None
    for place in range(power + 1):
        left = a[place]
        if left is None:
            continue
        right = b[power - place]
        if right is None:
            continue
        product = _multiply(left, right)
        total = product if total is None else _add(total, product)
    return total


# --- Series --------------------------------------------------------------------------------------


class Series(np.lib.mixins.NDArrayOperatorsMixin):
    """Taylor series of a function over cells: intervals of f, f', f''/2 ...

    NumPy's operators, `np.where`, and those of its functions that the model uses take series
    instead of arrays, so that the same code of the model serves numbers and proofs.

    Attributes:
        terms: Interval of each coefficient over each cell; None if it is exactly zero.
        partials: Partial derivatives with respect to numbers of a box, by the number's index.
    """

    def __init__(self, terms: Sequence[Term], partials: Mapping[int, Series] | None = None) -> None:
        self.terms = tuple(terms)
        self.partials = partials or {}

    @classmethod
    def of(cls, value: Any, rounded: float = 0.0) -> Series:
        """Return a constant as a series, or a series unchanged.

        Args:
            value: A number, an array or a series.
            rounded: Relative error that a plain number may have.
        """
        if isinstance(value, Series):
            return value
        middle = np.asarray(value, dtype=np.float64)
        radius = rounded * np.abs(middle) if rounded else 0.0
        return cls([(middle, radius), *[None] * ORDER])

    @classmethod
    def variable(cls, middle: Array, half: Array, order: int) -> Series:
        """Return the variable itself over cells of half-width `half` about `middle`."""
        return cls([(middle, half), (1.0, 0.0), *[None] * (order - 1)])

    @classmethod
    def number(cls, middle: Array, radius: Array, slope: Array, place: int) -> Series:
        """Return a number that lies in a box, with its partial derivative.

        Args:
            middle: Midpoint of the number in each cell.
            radius: Largest distance of the number from its midpoint.
            slope: Derivative of the number with respect to the number at `place`.
            place: Index of the number among those of the box.
        """
        rounding = (abs(middle) + abs(slope)) * COMPUTED
        derivative = cls([(slope, rounding), *[None] * (_ORDER_OF_PARTIALS - 1)])
        return cls([(middle, radius * _OUT + rounding), *[None] * ORDER], {place: derivative})

    @classmethod
    def point(cls, value: Array, slope: Array) -> Series:
        """Return a number at a point of a box, without its partial derivative.

        Args:
            value: The number in each cell.
            slope: Its derivative with respect to a number of the box; both may be rounded.
        """
        rounding = (abs(value) + abs(slope)) * COMPUTED
        return cls([(value, rounding), *[None] * ORDER])

    @classmethod
    def _of_partials(cls, partials: Mapping[int, Series]) -> Series:
        """Return a series of zeros with partial derivatives."""
        return cls([None] * (ORDER + 1), partials)

    @property
    def value(self) -> Interval:
        """Enclosure of the function over each cell."""
        return self.terms[0] or _zero()

    @property
    def real(self) -> Any:
        """Midpoint of the enclosure, by which a curve finds the piece that a cell lies in."""
        return self.value[0]

    def slope(self) -> Series:
        """Return the derivative, of one order less."""
        terms = [
            term and _multiply(term, (power, 0.0)) for power, term in enumerate(self.terms) if power
        ]
        partials = {place: derivative.slope() for place, derivative in self.partials.items()}
        return Series(terms, partials)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **_: Any) -> Any:
        """Apply one of NumPy's operators and functions to arrays and series."""
        if method != "__call__" or ufunc not in _UFUNCS:
            return NotImplemented
        return _UFUNCS[ufunc](*map(Series.of, inputs))

    def __array_function__(self, function: Any, _: Any, inputs: Any, __: Any) -> Any:
        """Apply `np.where`, the only array function that series know."""
        if function is not np.where:
            return NotImplemented
        condition, first, second = inputs
        return _choose(condition, Series.of(first), Series.of(second))

    def _compose(self, derivatives: Sequence[Interval]) -> Series:
        """Return g(f), from enclosures of g, g', g'' ... over the values of f.

        There is one derivative more than there are terms.
        """
        change: list[Term] = [None, *self.terms[1:]]
        count = min(len(change), ORDER + 1)

        def expand(derivatives: Sequence[Interval]) -> Series:
            power: list[Term] = [(1.0, 0.0), *[None] * ORDER]
            total: list[Term] = [_zero(), *[None] * ORDER]
            for derivative, factor in zip(derivatives, _INVERSE_FACTORIALS, strict=False):
                coefficient = _multiply(derivative, factor)
                total = [
                    _add_terms(known, term and _multiply(term, coefficient))
                    for known, term in zip(total, power, strict=True)
                ]
                power = [_product_term(power, change, place) for place in range(count)]
                total = total[:count]
            return Series(total)

        composed = expand(derivatives)
        slope = expand(derivatives[1:]) if self.partials else Series.of(0.0)
        partials = {place: slope * derivative for place, derivative in self.partials.items()}
        return Series(composed.terms, partials)

    def add(self, other: Series) -> Series:
        """Return the sum."""
        terms = [_add_terms(a, b) for a, b in zip(self.terms, other.terms, strict=False)]
        partials = {**other.partials, **self.partials}
        for place in self.partials.keys() & other.partials.keys():
            partials[place] = self.partials[place] + other.partials[place]
        return Series(terms, partials)

    def negate(self) -> Series:
        """Return the negative."""
        terms = [None if term is None else (-term[0], term[1]) for term in self.terms]
        partials = {place: -derivative for place, derivative in self.partials.items()}
        return Series(terms, partials)

    def multiply(self, other: Series) -> Series:
        """Return the product."""
        a = self.terms
        b = other.terms
        powers = range(min(len(a), len(b)))
        product = Series([_product_term(a, b, power) for power in powers])
        for changing, factor in ((self, other), (other, self)):
            if changing.partials:
                partials = {
                    place: derivative * Series(factor.terms)
                    for place, derivative in changing.partials.items()
                }
                product = product + Series._of_partials(partials)
        return product

    def divide(self, other: Series) -> Series:
        """Return the quotient."""
        if self.partials or other.partials:
            divisor = Series(other.terms)
            quotient = Series(self.terms) / divisor
            numerator = Series._of_partials(self.partials) - quotient * Series._of_partials(
                other.partials
            )
            partials = {
                place: derivative / divisor for place, derivative in numerator.partials.items()
            }
            return Series(quotient.terms, partials)
        inverse = _invert(other.value)
        terms: list[Term] = []
        for power in range(min(len(self.terms), len(other.terms))):
            known = _highest_term([*terms, None], other.terms[: power + 1])
            rest = _subtract_terms(self.terms[power], known)
            terms.append(rest and _multiply(rest, inverse))
        return Series(terms)

    def sqrt(self) -> Series:
        """Return the square root."""
        middle, radius = _square_root(self.value)
        terms: list[Term] = [(middle, radius)]
        inverse = _invert((2.0 * middle, 2.0 * radius))
        for term in self.terms[1:]:
            known = _highest_term([None, *terms[1:], None], [None, *terms[1:], None])
            rest = _subtract_terms(term, known)
            terms.append(rest and _multiply(rest, inverse))
        partials = {
            place: 0.5 / Series(terms) * derivative for place, derivative in self.partials.items()
        }
        return Series(terms, partials)

    def exp(self) -> Series:
        """Return the exponential."""
        middle, radius = self.value
        value = np.exp(middle)
        derivative = value, value * (np.expm1(radius) + _FUNCTIONS) * _OUT
        return self._compose([derivative for _ in _DERIVATIVES])

    def sin(self, quarters: int = 0) -> Series:
        """Return the sine of f + quarters π/2."""
        middle, radius = self.value
        sine = np.sin(middle)
        cosine = np.cos(middle)
        rest = 0.5 * radius * radius * _OUT + _FUNCTIONS
        values_and_slopes = ((sine, cosine), (cosine, sine), (-sine, cosine), (-cosine, sine))
        enclosures = [
            (value, np.abs(slope) * radius * _OUT + rest) for value, slope in values_and_slopes
        ]
        return self._compose([enclosures[(n + quarters) % 4] for n in _DERIVATIVES])

    def elongation(self) -> Series:
        """Return (e^f - 1)/f.

        Its n-th derivative is the integral of t^n e^(tf) over t from 0 to 1, which rises with f.
        """
        middle, radius = self.value

        def derivative(n: int, at: Array) -> Array:
            power = np.ones(np.shape(at))
            total = np.zeros(np.shape(at))
            for term in range(_EXPONENTIAL_TERMS):
                total = total + power / (n + term + 1)
                power = power * at / (term + 1)
            return total

        largest = abs(middle) + radius
        enclosures = []
        for n in _DERIVATIVES:
            spread = radius * derivative(n + 1, largest) * _OUT
            enclosures.append((derivative(n, middle), spread + _FUNCTIONS * derivative(n, largest)))
        return self._compose(enclosures)


def _choose(is_first: Any, first: Series, second: Series, is_certain: Any = True) -> Series:
    """Return one series or the other; enclose both where the choice is not certain."""

    def enclose(a: Series, b: Series) -> Series:
        terms: list[Term] = []
        for left, right in zip(a.terms, b.terms, strict=False):
            value, radius = left or (0.0, 0.0)
            other, other_radius = right or (0.0, 0.0)
            hull = (abs(value - other) + radius + other_radius) * _OUT
            chosen = np.where(is_first, radius, other_radius)
            middle = np.where(is_first, value, other)
            terms.append((middle, np.where(is_certain, chosen, hull)))
        return Series(terms)

    constant = Series([None] * _ORDER_OF_PARTIALS)
    partials = {
        place: enclose(first.partials.get(place, constant), second.partials.get(place, constant))
        for place in first.partials.keys() | second.partials.keys()
    }
    return Series(enclose(first, second).terms, partials)


def _choose_extreme(extreme: Any, first: Series, second: Series) -> Series:
    """Return the smaller, or larger, of two series."""
    value, radius = first.value
    other, other_radius = second.value
    is_first = extreme(value, other) == value
    is_certain = abs(value - other) > radius + other_radius
    return _choose(is_first, first, second, is_certain)


_UFUNCS: dict[Any, Callable[..., Any]] = {
    np.add: Series.add,
    np.subtract: lambda a, b: a + -b,
    np.negative: Series.negate,
    np.multiply: Series.multiply,
    np.true_divide: Series.divide,
    np.square: lambda a: a * a,
    np.sqrt: Series.sqrt,
    np.exp: Series.exp,
    np.sin: Series.sin,
    np.cos: lambda a: a.sin(1),
    np.minimum: partial(_choose_extreme, np.minimum),
    np.maximum: partial(_choose_extreme, np.maximum),
    np.isnan: lambda a: np.isnan(a.real),
}
