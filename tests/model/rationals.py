"""A state once more, in intervals of exact rationals: section by section from the paper, with nothing of the package.

Ends are whole multiples of 2^-BITS, rounded outwards; sine, cosine and exponential are their series with the rest.
"""

from fractions import Fraction
from math import floor, isqrt

BITS = 160
ONE = 1 << BITS
PI = Fraction(
    31415926535897932384626433832795028841971693993751058209749445923, 10**64
)  # but for 1e-64, far below what is rounded


class Exact:
    """An interval [low, high] 2^-BITS."""

    def __init__(self, low, high=None):
        self.low, self.high = low, low if high is None else high

    @classmethod
    def of(cls, value):
        """A number as it is, but for the last bit."""
        if isinstance(value, cls):
            return value
        scaled = Fraction(value) * ONE
        return cls(floor(scaled), -floor(-scaled))

    def __add__(self, other):
        other = Exact.of(other)
        return Exact(self.low + other.low, self.high + other.high)

    def __neg__(self):
        return Exact(-self.high, -self.low)

    def __sub__(self, other):
        return self + -Exact.of(other)

    def __mul__(self, other):
        other = Exact.of(other)
        ends = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return Exact(min(ends) >> BITS, -(-max(ends) >> BITS))

    def __truediv__(self, other):
        other = Exact.of(other)
        assert other.low > 0 or other.high < 0, "it may be zero"
        ends = [
            Fraction(a * ONE, b) for a in (self.low, self.high) for b in (other.low, other.high)
        ]
        return Exact(floor(min(ends)), -floor(-max(ends)))

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other):
        return Exact.of(other) - self

    def __rtruediv__(self, other):
        return Exact.of(other) / self

    def root(self):
        """Its square root."""
        return Exact(isqrt(self.low << BITS), isqrt(self.high << BITS) + 1)

    def series(self, first, step, terms=90):
        """first + first step(1) + first step(1) step(2) ..., each step falling below a half; the rest is one more."""
        total = term = first
        for n in range(1, terms):
            term = term * step(n)
            total = total + term
        size = 2 * max(abs(term.low), abs(term.high)) + 1
        return total + Exact(-size, size)

    def sine(self):
        """Of at most a few radians."""
        return self.series(self, lambda n: -(self * self) / ((2 * n) * (2 * n + 1)))

    def cosine(self):
        """The same."""
        return self.series(Exact.of(1), lambda n: -(self * self) / ((2 * n - 1) * (2 * n)))

    def exp(self):
        """e to it."""
        return self.series(Exact.of(1), lambda n: self / n)

    def holds(self, value, radius=0):
        """Whether it lies within a radius of a number of floats."""
        value, radius = Fraction(float(value)), Fraction(float(radius))
        return self.low >= floor((value - radius) * ONE) and self.high <= -floor(
            -(value + radius) * ONE
        )


def elongation(exponent):
    """(e^z - 1)/z; 1 at z = 0."""
    return exponent.series(Exact.of(1), lambda n: exponent / (n + 1))


def state(p, angle, flexion, pretension):
    """Tensions at both ends, k, the motor's torque of a taut state at an angle, by flat numbers as in `designs`."""
    p = {name: Exact.of(value) for name, value in p.items() if not isinstance(value, bool)} | {
        "angle": Exact.of(angle)
    }
    sides = {}
    for side, way in (("flexor", -1 if flexion else 1), ("extensor", 1 if flexion else -1)):
        turns = p[f"{side}_friction"] * p[f"{side}_bend_angle"] * way
        area = Exact.of(PI) * p[f"{side}_diameter"] * p[f"{side}_diameter"] / 4
        tendon = p[f"{side}_length"] / (area * p[f"{side}_youngs_modulus"]) * elongation(-turns)
        sides[side] = turns.exp(), tendon + 1 / p[f"{side}_spring_stiffness"]
    (flexor_end, flexor), (extensor_end, extensor) = sides["flexor"], sides["extensor"]
    sine, cosine, radius = p["angle"].sine(), p["angle"].cosine(), p["elbow_radius"]
    forward = p["b2"] * sine + p["a2"] * cosine - p["a1"]
    up = p["a2"] * sine - p["b2"] * cosine - p["b1"]
    path = (forward * forward + up * up).root()
    along = (up + p["b1"]) * forward - (forward + p["a1"]) * up  # -(path²)'/2
    arm = along / path
    # As the forearm's anchor q goes round, (path²)''/2 = q·r, r that of the upper arm.
    around = (forward + p["a1"]) * p["a1"] + (up + p["b1"]) * p["b1"]
    slope = (arm * arm - around) / path
    lean = p["angle"] + p["upper_arm_angle"]
    moment = Exact.of("9.81") * (
        p["forearm_mass"] * p["forearm_com"] + p["load_mass"] * p["load_distance"]
    )
    torque, torque_slope = moment * lean.sine(), moment * lean.cosine()
    turned, ratio = p["ratio"] * flexor, p["ratio"]
    apart = (
        radius * p["angle"] - ratio * (p["b1"] + p["b2"] - path) + (turned + extensor) * pretension
    )
    det = arm * extensor + radius * turned
    x, y = (torque * extensor + radius * apart) / det, (arm * apart - turned * torque) / det
    stiffness = arm * arm / flexor + radius * radius / extensor + torque_slope - slope * x
    motor = p["flexor_radius"] * (x / flexor_end - ratio * y / extensor_end)
    return {
        "x": x,
        "y": y,
        "stiffness": stiffness,
        "motor": motor,
        "x_proximal": x / flexor_end,
        "y_proximal": y / extensor_end,
    }
