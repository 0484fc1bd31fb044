"""What designs are held to, as bounds on lines: each limit on a form of a state over its margin v.

That is how far the pretension is above what keeps the state taut; with it the tensions are x = flexor_floor +
flexor_gain v and y likewise (`statics.Response`), and the elbow stiffness is a line, too. Compiled code takes what
`held_forms` gives, and knows no limit by name. Arguments broadcast as in `actuator`; SI units, angles in radians.
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
    PRETENSION,
)
from tendon_cli.model.statics import SLACK_TOLERANCE

SHARES = ("flexor", "extensor", "stiffness")


class Bounds(Mapping[str, "Real"]):
    """What designs are held to: limits by name, SI, infinite where nothing is asked, and the elbow's speed, rad/s."""

    def __init__(self, *, speed: Real = np.nan, **limits: Real) -> None:
        """Raises KeyError for a limit that there is not."""
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
        """The same with another value of one limit, or of the speed."""
        return Bounds(**{"speed": self.speed, **self._values, name: value})

    @cached_property
    def asked(self) -> list[DesignLimit]:
        """The limits that hold for any design, in the order of the table."""
        return [
            limit
            for name, limit in LIMITS.items()
            if name in self and not np.all(np.isinf(self[name]))
        ]

    @property
    def of_motion(self) -> list[DesignLimit]:
        """Those of them that compare states of the whole motion."""
        return [limit for limit in self.asked if limit.of_motion]


@dataclass(frozen=True, eq=False)
class Held:
    """A form without constant and the range that it is held to, which a limit asks for; None is no bound."""

    limit: int
    """Index into LIMIT_NAMES."""
    form: Form
    """Of one of x, y and k alone it is this itself: its share is the number 1.0."""
    least: Real | None
    most: Real | None


def held_forms(at: State, bounds: Bounds) -> list[Held]:
    """The forms of states that bounds hold, in the order of the table."""
    return [
        _held(limit, form, bounds[limit.name])
        for limit in bounds.asked
        if limit.forms is not None
        for form in limit.forms(at, bounds.speed)
    ]


def _held(limit: DesignLimit, form: Form, bound: Real) -> Held:
    ends = [
        None if end is None else end - np.asarray(form.constant) for end in limit.range_of(bound)
    ]
    shares = {name: getattr(form, name) for name in SHARES if not is_nothing(getattr(form, name))}
    code = LIMIT_NAMES.index(limit.name)
    if len(shares) != 1:
        return Held(code, Form(form.flexor, form.extensor, form.stiffness), *ends)
    ((name, share),) = shares.items()
    backward = bool(np.all(np.real(share) < 0.0))
    with np.errstate(divide="ignore"):  # a rigid spring is never extended
        least, most = (
            None if end is None else end / np.asarray(share)
            for end in (ends[::-1] if backward else ends)
        )
    return Held(code, Form(**{name: 1.0}), least, most)


def stiffness_line(at: State) -> tuple[Array, Array]:
    """k of a taut state over v, the margin: base and gain, N m/rad and per newton."""
    response, (of_flexor, of_extensor) = at.response, at.arm_slopes
    base, gain = (
        at.held_stiffness[0] - response.flexor_floor * of_flexor,
        -(response.flexor_gain * of_flexor),
    )
    if np.any(of_extensor):
        base, gain = (
            base + response.extensor_floor * of_extensor,
            gain + response.extensor_gain * of_extensor,
        )
    return base, gain


def ends_of(at: State, bounds: Bounds) -> Iterator[tuple[int, Array, Flags, Array, Flags]]:
    """Every bound on a form of states, which is a line in the margin v.

    It gives the limit's code, the v at which it is just kept, whether that is a lower end, the gain of the form (where
    that is 0 it bounds nothing), and whether no v keeps it.
    """
    response, (k_base, k_gain) = at.response, stiffness_line(at)
    for held in held_forms(at, bounds):
        base = held.form.of(response.flexor_floor, response.extensor_floor, k_base)
        gain = held.form.of(response.flexor_gain, response.extensor_gain, k_gain)
        for bound, below in ((held.least, True), (held.most, False)):
            if bound is None:
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                end = np.asarray((bound - base) / gain)
            short = bound - base if below else base - bound
            hopeless = (gain == 0.0) & (short > SLACK_TOLERANCE * np.abs(bound))
            yield held.limit, end, (gain > 0.0) == below, gain, hopeless


def limit_end(
    code: int, design: Design, elbow_angle: Real, flexion: Flag, bounds: Bounds, *, upper: bool
) -> Array:
    """The pretension at which one limit is just kept in each state, N; also of complex numbers, for derivatives."""
    if code == PRETENSION:
        return np.asarray(bounds["max_pretension"])
    at = State.of(design, elbow_angle, flexion)
    required, tightest = at.response.required, np.full((), np.inf if upper else -np.inf)
    if code in (FLEXOR_SLACK, EXTENSOR_SLACK):
        return required
    for limit, end, is_lower, gain, _ in ends_of(at, bounds):
        if limit == code:
            binds = (
                (is_lower != upper)
                & (gain != 0.0)
                & ((end < tightest) if upper else (end > tightest))
            )
            tightest = np.where(binds, end, tightest)
    return np.asarray(required + tightest)
