"""A state once more, in intervals of exact rationals.

It is computed section by section from the paper, with nothing of the package. Ends of intervals are
whole multiples of 2^-BITS, rounded outwards; sine, cosine and exponential are their series with a
bound on the rest.
"""

from fractions import Fraction
from itertools import product
from math import floor, isqrt

BITS = 160
ONE = 1 << BITS

PI = Fraction(31415926535897932384626433832795028841971693993751058209749445923, 10**64)
"""π within 1e-64, far below what is rounded."""


class Exact:
    """An interval [low, high] 2^-BITS."""

    def __init__(self, low, high=None):
        self.low = low
        self.high = low if high is None else high

    @classmethod
    def of(cls, value):
        """Return the interval of a number, exact but for the last bit."""
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
        pairs = product((self.low, self.high), (other.low, other.high))
        products = [a * b for a, b in pairs]
        return Exact(min(products) >> BITS, -(-max(products) >> BITS))

    def __truediv__(self, other):
        other = Exact.of(other)
        assert other.low > 0 or other.high < 0, "the divisor may be zero"
        pairs = product((self.low, self.high), (other.low, other.high))
        quotients = [Fraction(a * ONE, b) for a, b in pairs]
        return Exact(floor(min(quotients)), -floor(-max(quotients)))

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other):
        return Exact.of(other) - self

    def __rtruediv__(self, other):
        return Exact.of(other) / self

    def root(self):
        """Return the square root."""
        return Exact(isqrt(self.low << BITS), isqrt(self.high << BITS) + 1)

    def series(self, first, step, terms=90):
        """Return first + first step(1) + first step(1) step(2) + ….

        Each step falls below a half, so that the rest is at most twice the last term.
        """
        term = first
        total = first
        for n in range(1, terms):
            term = term * step(n)
            total = total + term
        rest = 2 * max(abs(term.low), abs(term.high)) + 1
        return total + Exact(-rest, rest)

    def sine(self):
        """Return the sine of at most a few radians."""
        return self.series(self, lambda n: -(self * self) / ((2 * n) * (2 * n + 1)))

    def cosine(self):
        """Return the cosine of at most a few radians."""
        return self.series(Exact.of(1), lambda n: -(self * self) / ((2 * n - 1) * (2 * n)))

    def exp(self):
        """Return the exponential."""
        return self.series(Exact.of(1), lambda n: self / n)

    def holds(self, value, radius=0):
        """Return True if the interval lies within a radius of a value, both floats."""
        value = Fraction(float(value))
        radius = Fraction(float(radius))
        lowest = floor((value - radius) * ONE)
        highest = -floor(-(value + radius) * ONE)
        return self.low >= lowest and self.high <= highest


def elongation(exponent):
    """Return (e^z - 1)/z, which is 1 at z = 0."""
    return exponent.series(Exact.of(1), lambda n: exponent / (n + 1))


def sheath(p, side, sign):
    """Return the capstan factor and the compliance of a side, per newton at the elbow."""
    turns = p[f"{side}_friction"] * p[f"{side}_bend_angle"] * sign
    area = Exact.of(PI) * p[f"{side}_diameter"] * p[f"{side}_diameter"] / 4
    rope = p[f"{side}_length"] / (area * p[f"{side}_youngs_modulus"]) * elongation(-turns)
    return turns.exp(), rope + 1 / p[f"{side}_spring_stiffness"]


def state(p, angle, flexion, pretension):
    """Return tensions at both ends, stiffness and motor torque of a taut state at an angle.

    `p` holds flat numbers as in `designs`.
    """
    p = {name: Exact.of(value) for name, value in p.items() if not isinstance(value, bool)}
    angle = Exact.of(angle)
    flexor_end, flexor = sheath(p, "flexor", -1 if flexion else 1)
    extensor_end, extensor = sheath(p, "extensor", 1 if flexion else -1)

    # Path of the flexor between its anchors, its moment arm, and the slope of that.
    sine = angle.sine()
    cosine = angle.cosine()
    forward = p["b2"] * sine + p["a2"] * cosine - p["a1"]
    up = p["a2"] * sine - p["b2"] * cosine - p["b1"]
    path = (forward * forward + up * up).root()
    along = (up + p["b1"]) * forward - (forward + p["a1"]) * up  # -(path²)'/2
    arm = along / path
    # As the forearm's anchor q goes round, (path²)''/2 = q·r, r that of the upper arm.
    around = (forward + p["a1"]) * p["a1"] + (up + p["b1"]) * p["b1"]
    slope = (arm * arm - around) / path

    # Torque that the weights ask for.
    lean = angle + p["upper_arm_angle"]
    mass_moment = p["forearm_mass"] * p["forearm_com"] + p["load_mass"] * p["load_distance"]
    moment = Exact.of("9.81") * mass_moment
    torque = moment * lean.sine()
    torque_slope = moment * lean.cosine()

    # Tensions that balance the elbow.
    radius = p["elbow_radius"]
    ratio = p["ratio"]
    wound = ratio * flexor
    shortening = p["b1"] + p["b2"] - path
    stretch = radius * angle - ratio * shortening + (wound + extensor) * pretension
    det = arm * extensor + radius * wound
    x = (torque * extensor + radius * stretch) / det
    y = (arm * stretch - wound * torque) / det
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
