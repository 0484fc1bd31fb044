"""Elastic cables in sheaths that grip them by Coulomb friction, node by node.

A sheath of total bend φ is cut into n little bends φ/n, each gathered in one node. Between them
the cable is an elastic link. Positions along the sheath count toward the motor:

    motor end w ── link 0 ── node 0 ── link 1 ── … ── node n−1 ── link n ── elbow end h

Tension of a link is its stretch over its compliance, T = max(0, (u_before − u_after + natural)/c),
where `natural` is the stretch with all positions at zero. A node sticks while the tensions on its
sides are within a factor of r = exp(μφ/n) of each other, and slips at that factor, from the lower
tension to the higher one. Nothing depends on rates.

From one instant to the next the ends move, and each node either stays where it was or slips one
way: a complementarity problem per cable. It is solved exactly: with every node's state given,
the positions solve a tridiagonal system; states that contradict the outcome are changed, until
none does (`move_cables`). All cables are solved as one tridiagonal system.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgtsv

Array = NDArray[np.float64]

STICKS = 0
TOWARD_MOTOR = 1
TOWARD_ELBOW = -1

MOST_ROUNDS = 4000
"""Changes of states after which the nodes count as not solvable."""

ROUNDS_OF_GUESS = 2
"""Rounds after which a cable starts anew from the fronts at its ends."""

ROUNDS_OF_CORRECTION = 14
"""Rounds after which states are improved in the way that is sure to end."""

TOLERANCE = 1e-13
"""Way by which a choice must be better than the one that stands, m."""


@dataclass(frozen=True)
class Cables:
    """Elastic links of several cables.

    Attributes:
        compliance: Stretch per tension of each link (cables, nodes + 1), m/N.
        natural: Stretch of each link with all positions at zero (cables, nodes + 1), m.
    """

    compliance: Array
    natural: Array

    @property
    def nodes(self) -> int:
        """Number of nodes of each cable."""
        return self.compliance.shape[1] - 1

    def select(self, rows: NDArray[np.intp]) -> Cables:
        """Select cables by index."""
        return Cables(self.compliance[rows], self.natural[rows])


@dataclass
class Gripped:
    """Cables at one instant.

    Attributes:
        position: Way of each node toward the motor since the set-up (cables, nodes), m.
        tension: Tension of each link (cables, nodes + 1), N.
        state: `STICKS`, `TOWARD_MOTOR` or `TOWARD_ELBOW` of each node (cables, nodes).
        elbow_slope: Elbow tension per way of the motor end (cables,), N/m.
        is_slack: True if a cable is longer than its way (cables,).
    """

    position: Array
    tension: Array
    state: NDArray[np.int8]
    elbow_slope: Array
    is_slack: NDArray[np.bool_]

    def select(self, rows: NDArray[np.intp]) -> Gripped:
        """Select cables by index."""
        return Gripped(
            self.position[rows],
            self.tension[rows],
            self.state[rows],
            self.elbow_slope[rows],
            self.is_slack[rows],
        )

    def replace(self, rows: NDArray[np.intp], new: Gripped) -> None:
        """Write other cables' values into rows of this one."""
        self.position[rows] = new.position
        self.tension[rows] = new.tension
        self.state[rows] = new.state
        self.elbow_slope[rows] = new.elbow_slope
        self.is_slack[rows] = new.is_slack


def unstressed_grip(cables: Cables) -> Gripped:
    """Return cables as they were set up: no node has moved, every tension is its link's own."""
    count = len(cables.compliance)
    return Gripped(
        position=np.zeros((count, cables.nodes)),
        tension=np.maximum(cables.natural / cables.compliance, 0.0),
        state=np.zeros((count, cables.nodes), dtype=np.int8),
        elbow_slope=np.zeros(count),
        is_slack=np.zeros(count, dtype=np.bool_),
    )


def link_tensions(cables: Cables, position: Array, motor_end: Array, elbow_end: Array) -> Array:
    """Return stretch over compliance of every link (cables, nodes + 1), N; may be negative."""
    ways = np.concatenate([motor_end[:, None], position, elbow_end[:, None]], axis=1)
    stretch = ways[:, :-1] - ways[:, 1:] + cables.natural
    return stretch / cables.compliance


def solve_positions(
    cables: Cables,
    before: Array,
    state: NDArray[np.int8],
    grip: Array,
    motor_end: Array,
    elbow_end: Array,
) -> tuple[Array, Array]:
    """Solve the positions of nodes whose states are given.

    A sticking node stays at its position before. A slipping one has T_motor = r^s T_elbow of its
    two links; written times the compliance of the link toward the motor this is

        u₋ − (1 + q) u + q u₊ = q g₊ − g₋,   q = r^s c₋ / c₊.

    Args:
        cables: Links of the cables.
        before: Positions of the nodes one instant before (cables, nodes), m.
        state: States of the nodes (cables, nodes).
        grip: ln r of a node, μφ/n, of each cable (cables,).
        motor_end: Way of each motor end (cables,), m.
        elbow_end: Way of each elbow end (cables,), m.

    Returns:
        Positions (cables, nodes), m, and their derivative with respect to the motor end.
    """
    slips = state != STICKS
    factor = np.exp(grip[:, None] * state)
    toward_motor = cables.compliance[:, :-1]
    toward_elbow = cables.compliance[:, 1:]
    q = factor * toward_motor / toward_elbow

    diagonal = np.where(slips, -(1.0 + q), 1.0)
    lower = np.where(slips, 1.0, 0.0)
    upper = np.where(slips, q, 0.0)
    wanted = np.where(slips, q * cables.natural[:, 1:] - cables.natural[:, :-1], before)
    wanted[:, 0] -= lower[:, 0] * motor_end
    wanted[:, -1] -= upper[:, -1] * elbow_end
    by_motor = np.zeros_like(wanted)
    by_motor[:, 0] = -lower[:, 0]
    lower[:, 0] = 0.0
    upper[:, -1] = 0.0

    columns = np.stack([wanted.ravel(), by_motor.ravel()], axis=1)
    below = lower.ravel()[1:]
    above = upper.ravel()[:-1]
    *_, solved, failed = dgtsv(below, diagonal.ravel(), above, columns)
    if failed:
        raise RuntimeError(f"the nodes' positions have no solution: dgtsv says {failed}")
    return solved[:, 0].reshape(state.shape), solved[:, 1].reshape(state.shape)


def corrected_states(
    state: NDArray[np.int8], moved: Array, to_motor: Array, to_elbow: Array
) -> NDArray[np.int8]:
    """Return states with every contradiction mended by itself; quick, but it may go in circles.

    A node that slipped against its direction sticks; one that sticks beyond its limit slips.
    Arguments as `next_states` has them.
    """
    sticks = state == STICKS
    new = np.where(moved * state < -TOLERANCE, STICKS, state)
    new = np.where(sticks & (to_motor < -TOLERANCE), TOWARD_MOTOR, new)
    return np.where(sticks & (to_elbow > TOLERANCE), TOWARD_ELBOW, new).astype(np.int8)


def next_states(
    state: NDArray[np.int8], moved: Array, to_motor: Array, to_elbow: Array
) -> NDArray[np.int8]:
    """Return states that the outcome contradicts less, per cable.

    With m the way of a node, p the excess of the tension that holds it over the one that pulls it
    toward the motor, and e the same toward the elbow with its sign turned, its law is

        max(min(m, p), e) = 0,   p = c₋ (r T₊ − T₋),   e = c₋ (T₊/r − T₋),

    a game between a smaller and a larger choice, each row of which is that of an M-matrix. Such
    a game is solved by Hoffman and Karp's iteration: with the larger choice given (which nodes
    slip to the elbow) the smaller is improved until it settles, then the larger is improved once.

    Args:
        state: States that were assumed (cables, nodes).
        moved: m of each node (cables, nodes), m.
        to_motor: p of each node (cables, nodes), m.
        to_elbow: e of each node (cables, nodes), m.
    """
    slips_to_motor = state == TOWARD_MOTOR
    slips_to_elbow = state == TOWARD_ELBOW
    gain = np.where(slips_to_motor, TOLERANCE, -TOLERANCE)
    smaller = np.where(to_motor < moved + gain, TOWARD_MOTOR, STICKS)
    improved = np.where(slips_to_elbow, TOWARD_ELBOW, smaller)
    has_settled = (improved == state).all(axis=1)

    gain = np.where(slips_to_elbow, TOLERANCE, -TOLERANCE)
    least = np.minimum(moved, to_motor)
    larger = np.where(to_elbow + gain > least, TOWARD_ELBOW, smaller)
    return np.where(has_settled[:, None], larger, improved).astype(np.int8)


def front_from_end(
    position: Array, end: Array, compliance: Array, natural: Array, grip: Array
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the direction and the number of nodes that slip from one end of each cable.

    The end pulls or pays out, and nodes slip one after the other, all at their limit, up to the
    first that can hold the rest. All fronts are tried at once: with the first j nodes slipping
    the tensions of links 0 … j form a geometric series, whose stretch is known.

    Args:
        position: Positions before, counted toward this end, nearest node first (cables, nodes), m.
        end: Position of the end (cables,), m.
        compliance: Of each link, nearest first (cables, nodes + 1), m/N.
        natural: Stretch of each link at zero positions (cables, nodes + 1), m.
        grip: μφ/n of each cable (cables,).
    """
    inner = (position[:, :-1] - position[:, 1:] + natural[:, 1:-1]) / compliance[:, 1:-1]
    stretch = end[:, None] - position + np.cumsum(natural[:, :-1], axis=1)
    first = stretch[:, 0] / compliance[:, 0]
    direction = np.sign(first - inner[:, 0]).astype(np.intp)
    ratio = np.exp(grip * direction)[:, None]
    powers = ratio ** np.arange(position.shape[1])
    series = powers * np.cumsum(compliance[:, :-1] / powers, axis=1)
    at_front = (stretch / series)[:, :-1]
    holds = np.where(direction[:, None] > 0, at_front <= ratio * inner, at_front >= ratio * inner)
    slipping = np.where(holds.any(axis=1), holds.argmax(axis=1), position.shape[1])
    return direction, slipping


def guess_states(
    cables: Cables, before: Array, grip: Array, motor_end: Array, elbow_end: Array
) -> NDArray[np.int8]:
    """Guess the states of nodes from the fronts that start at both ends (cables, nodes)."""
    if cables.nodes < 2:
        return np.zeros(before.shape, dtype=np.int8)
    winds, from_motor = front_from_end(before, motor_end, cables.compliance, cables.natural, grip)
    yields, from_elbow = front_from_end(
        -before[:, ::-1],
        -elbow_end,
        cables.compliance[:, ::-1],
        cables.natural[:, ::-1],
        grip,
    )
    place = np.arange(cables.nodes)
    state = np.where(place < from_motor[:, None], winds[:, None], STICKS)
    slips = cables.nodes - place <= from_elbow[:, None]
    return np.where(slips & (state == STICKS), -yields[:, None], state).astype(np.int8)


def move_cables(
    cables: Cables,
    before: Gripped,
    guess: NDArray[np.int8],
    grip: Array,
    motor_end: Array,
    elbow_end: Array,
) -> Gripped:
    """Move the ends of cables and return what every node and link does.

    A cable that is longer than its way is slack throughout, since its tensions are within fixed
    factors of each other. Its nodes then go with the motor end: the slack gathers at the elbow.

    Args:
        cables: Links of the cables.
        before: The same cables one instant before.
        guess: States of the nodes to start from (cables, nodes).
        grip: μφ/n of each cable (cables,).
        motor_end: Way of each motor end (cables,), m.
        elbow_end: Way of each elbow end (cables,), m.

    Raises:
        RuntimeError: If the states of some cable's nodes do not settle.
    """
    is_slack = motor_end - elbow_end + cables.natural.sum(axis=1) <= 0.0
    unstretched = motor_end[:, None] + np.cumsum(cables.natural[:, :-1], axis=1)
    result = Gripped(
        position=unstretched,
        tension=np.zeros_like(cables.compliance),
        state=guess.copy(),
        elbow_slope=np.zeros(len(motor_end)),
        is_slack=is_slack,
    )
    result.state[is_slack] = STICKS
    rows = np.flatnonzero(~is_slack)
    factor = np.exp(grip)
    for trial in range(MOST_ROUNDS):
        if not len(rows):
            return result
        part = cables.select(rows)
        if trial == ROUNDS_OF_GUESS:
            result.state[rows] = guess_states(
                part, before.position[rows], grip[rows], motor_end[rows], elbow_end[rows]
            )
        position, slope = solve_positions(
            part,
            before.position[rows],
            result.state[rows],
            grip[rows],
            motor_end[rows],
            elbow_end[rows],
        )
        tension = link_tensions(part, position, motor_end[rows], elbow_end[rows])
        ratio = factor[rows][:, None]
        toward_motor = part.compliance[:, :-1]
        improve = corrected_states if trial < ROUNDS_OF_CORRECTION else next_states
        states = improve(
            result.state[rows],
            position - before.position[rows],
            toward_motor * (ratio * tension[:, 1:] - tension[:, :-1]),
            toward_motor * (tension[:, 1:] / ratio - tension[:, :-1]),
        )
        settled = (states == result.state[rows]).all(axis=1)
        result.position[rows] = position
        result.tension[rows] = tension
        result.elbow_slope[rows] = slope[:, -1] / part.compliance[:, -1]
        result.state[rows] = states
        rows = rows[~settled]
    raise RuntimeError(f"the nodes of {len(rows)} cables do not settle in {MOST_ROUNDS} rounds")


def friction_work(before: Gripped, after: Gripped) -> Array:
    """Return the work that friction takes between two instants (cables,), J; never negative.

    A node that slips resists with the difference of the tensions on its sides. If it resisted
    the same way before, the mean of both instants counts, else the later one alone.
    """
    moved = after.position - before.position
    resists = after.tension[:, :-1] - after.tension[:, 1:]
    resisted = before.tension[:, :-1] - before.tension[:, 1:]
    goes_on = (resisted * moved > 0.0) & (before.state == after.state)
    mean = np.where(goes_on, 0.5 * (resists + resisted), resists)
    work = np.where(after.is_slack[:, None] | before.is_slack[:, None], 0.0, mean * moved)
    return np.maximum(work, 0.0).sum(axis=1)
