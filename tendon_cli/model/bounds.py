"""Limits on forms of states, as bounds on straight lines in the margin v of each state.

The margin v is the pretension less the smallest that keeps the state taut. The tensions are lines
in it, x = flexor_floor + flexor_gain v and y likewise (`statics.Response`), and so is the elbow
stiffness. Compiled code takes the result of `bounded_forms`, and knows no limit by name. Arguments
broadcast as in `actuator`; SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.forms import DesignLimit, Form, is_nothing
from tendon_cli.model.kinematics import Array, Flag, Flags, Real
from tendon_cli.model.limits import (
    EXTENSOR_SLACK,
    FLEXOR_SLACK,
    LIMIT_NAMES,
    LIMITS,
    POWER,
    PRETENSION,
)
from tendon_cli.model.statics import SLACK_TOLERANCE

SHARES = ("flexor", "extensor", "stiffness")
"""Parts of a form that multiply x, y and k."""


class Bounds(Mapping[str, "Real"]):
    """Values of the limits that designs must keep, by name, SI; infinite if there is no limit.

    Limits that designs do not share stand in `Design.limits`; `of` puts them here.

    Attributes:
        speed: Speed of the elbow, rad/s; NaN if none is given.
    """

    def __init__(self, *, speed: Real = np.nan, **limits: Real) -> None:
        """Set limits, the others to their defaults. Raise KeyError for an unknown limit."""
        defaults = {
            limit.name: limit.default for limit in LIMITS.values() if limit.default is not None
        }
        self.speed = speed
        self._values: dict[str, Real] = {
            LIMITS[name].name: bound for name, bound in (defaults | limits).items()
        }

    def __getitem__(self, name: str) -> Real:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def changed(self, name: str, value: Real) -> Bounds:
        """Return the same bounds with another value of one limit, or of the speed."""
        return Bounds(**{"speed": self.speed, **self._values, name: value})

    def of(self, design: Design) -> Bounds:
        """Return the bounds of designs: their own limits where they have some, else these."""
        if not design.limits:
            return self
        own = {name: LIMITS[name].bound_of(values) for name, values in design.limits.items()}
        return Bounds(**{"speed": self.speed, **self._values, **own})

    def asks(self, name: str) -> Flags:
        """Return True for designs that a limit bounds."""
        return ~np.isinf(self.get(name, np.inf))

    @cached_property
    def asked(self) -> list[DesignLimit]:
        """Limits that bound at least one of the designs, in the order of LIMITS."""
        return [limit for name, limit in LIMITS.items() if name in self and self.asks(name).any()]

    @property
    def asks_power(self) -> bool:
        """True if the motor's power is bounded in at least one of the designs."""
        return bool(np.any(self.asks(LIMIT_NAMES[POWER])))


@dataclass(frozen=True, eq=False)
class BoundedForm:
    """A form without its constant, and the range that a limit allows it."""

    limit: int
    """Index into LIMIT_NAMES."""
    form: Form
    """Form of the state."""
    alone: str
    """Share of the form that is its only one, one of SHARES, and by which it is divided, so that
    it is 1.0; "" if there are several."""
    least: Real | None
    """Lower bound; None if there is none."""
    most: Real | None
    """Upper bound; None if there is none."""


def bounded_forms(at: State, bounds: Bounds) -> list[BoundedForm]:
    """Return the forms of states with the bounds on them, in the order of LIMITS."""
    bounds = bounds.of(at.design)
    return [
        _bounded_form(limit, form, bounds[limit.name])
        for limit in bounds.asked
        if limit.forms is not None
        for form in limit.forms(at, bounds.speed)
    ]


def _bounded_form(limit: DesignLimit, form: Form, bound: Real) -> BoundedForm:
    """Return a form with the range that a bound on its limit leaves, as `BoundedForm` has it."""
    code = LIMIT_NAMES.index(limit.name)
    least, most = (
        None if end is None else end - np.asarray(form.constant) for end in limit.range_of(bound)
    )
    shares = {name: getattr(form, name) for name in SHARES if not is_nothing(getattr(form, name))}
    if len(shares) != 1:
        several = Form(form.flexor, form.extensor, form.stiffness)
        return BoundedForm(code, several, "", least, most)
    ((name, share),) = shares.items()
    if np.all(np.real(share) < 0.0):
        least, most = most, least
    with np.errstate(divide="ignore", invalid="ignore"):
        least, most = (None if end is None else end / np.asarray(share) for end in (least, most))
    # A bound of 0 on what is always 0, such as the extension of a rigid spring, is kept.
    least, most = (
        None if end is None else np.where(np.isnan(end), unbounded, end)
        for end, unbounded in ((least, -np.inf), (most, np.inf))
    )
    return BoundedForm(code, Form(**{name: 1.0}), name, least, most)


def stiffness_line(at: State) -> tuple[Array, Array]:
    """Return k of a taut state over the margin v: base (N m/rad) and gain (N m/rad per newton)."""
    response = at.response
    flexor_slope, extensor_slope = at.arm_slopes
    base = at.held_stiffness[0] - response.flexor_floor * flexor_slope
    gain = -(response.flexor_gain * flexor_slope)
    if np.any(extensor_slope):
        base = base + response.extensor_floor * extensor_slope
        gain = gain + response.extensor_gain * extensor_slope
    return base, gain


@dataclass(frozen=True, eq=False)
class BoundEnd:
    """The margin v at which states just keep one bound on a form, a straight line in v."""

    code: int
    """Index of the limit into LIMIT_NAMES."""
    margin: Array
    """v at which the bound is just kept, N."""
    is_lower: Flags
    """True where larger margins keep the bound, too."""
    gain: Array
    """Slope of the form over v; where it is 0 the margin bounds nothing."""
    is_hopeless: Flags
    """True where no margin keeps the bound."""


def bound_ends(at: State, bounds: Bounds) -> Iterator[BoundEnd]:
    """Yield, for every bound on a form of states, the margin v at which it is just kept."""
    response = at.response
    stiffness_base, stiffness_gain = stiffness_line(at)
    for held in bounded_forms(at, bounds):
        base = held.form.of(response.flexor_floor, response.extensor_floor, stiffness_base)
        gain = held.form.of(response.flexor_gain, response.extensor_gain, stiffness_gain)
        for bound, is_least in ((held.least, True), (held.most, False)):
            if bound is None:
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                margin = np.asarray((bound - base) / gain)
            shortfall = bound - base if is_least else base - bound
            is_hopeless = (gain == 0.0) & (shortfall > SLACK_TOLERANCE * np.abs(bound))
            yield BoundEnd(held.limit, margin, (gain > 0.0) == is_least, gain, is_hopeless)


def limit_end(
    code: int, design: Design, elbow_angle: Real, flexion: Flag, bounds: Bounds, *, upper: bool
) -> Array:
    """Return the pretension at which one limit is just kept in each state, N.

    Numbers may be complex, for derivatives.

    Args:
        code: Index of the limit into LIMIT_NAMES.
        design: Designs.
        elbow_angle: Angles, rad.
        flexion: True for flexion, else extension.
        bounds: Limits of the designs.
        upper: True for the upper end that the limit sets, else the lower.
    """
    if code == PRETENSION:
        return np.asarray(bounds.of(design)["max_pretension"])
    at = State.of(design, elbow_angle, flexion)
    required = at.response.required
    if code in (FLEXOR_SLACK, EXTENSOR_SLACK):
        return required
    tightest = np.full((), np.inf if upper else -np.inf)
    for end in bound_ends(at, bounds):
        if end.code == code:
            # An infinite bound, such as that of a rigid spring, has no margin at which it is kept.
            margin = np.where(np.isfinite(end.margin), end.margin, tightest)
            is_tighter = margin < tightest if upper else margin > tightest
            binds = (end.is_lower != upper) & (end.gain != 0.0) & is_tighter
            tightest = np.where(binds, margin, tightest)
    return np.asarray(required + tightest)
