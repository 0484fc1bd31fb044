"""A suit of one motor and two gripped cables that a joint's balance drives, instant by instant.

The joint's angle is given over time. At each instant the spool angle α is sought at which

    J_f(θ) x − J_e(θ) y = τ,   τ = G sin(θ + ψ) + τ_joint(θ) + τ_task(t) + I θ̈,

x and y being the tensions at the elbow ends of the flexor and extensor cables, which follow from
the history of every node of their sheaths (`gripped_cables`). The cables have one natural length
each: the one at which both carry their pretension, without friction, at the travels of zero.
The motor carries R_f (T_f − η T_e). Nothing of `tendon` is used.

Many suits with one motion each are driven at once; they differ in every number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from .gripped_cables import (
    TOWARD_ELBOW,
    TOWARD_MOTOR,
    Array,
    Cables,
    Gripped,
    friction_work,
    move_cables,
    unstressed_grip,
)

Curve = Callable[[Array], Array]
"""Function of the joint's angle, on arrays."""

BALANCE_TOLERANCE = 1e-9
"""Torque at the joint that may be out of balance, N m."""

LEAST_SLOPE = 1e-6
"""Torque at the joint per spool angle below which the sheath holds it, N m/rad."""

FIRST_STRIDE = 1e-4
"""Spool angle tried first where the sheath holds the joint's torque, rad."""

MOST_TRIALS = 300
"""Spool angles tried at one instant before the balance counts as not to be found."""

JUMP = 4.0
"""Times the turn that the stiffness asks for beyond which a spool jumps."""

REASON_TO_JUMP = 0.003
"""Torque out of balance at the joint that makes a spool jump, N m."""

PARTS = 8
"""Parts of a step in which nodes change their states."""

LEAD_IN = 80
"""Instants from the set-up to the first sample of a motion."""


def _zero(angle: Array) -> Array:
    return np.zeros_like(np.asarray(angle, dtype=float))


@dataclass(frozen=True)
class Tendon:
    """One cable from the spool to its anchor.

    Attributes:
        cable: Compliance of the whole cable, L/(AE), m/N.
        spring: Compliance of the series spring, 1/K, m/N; 0 if there is none.
        tissue: Compliance of its anchors on the body, 1/K_t, m/N; 0 if they are rigid.
        friction: Coulomb coefficient of the sheath.
        bend: Total bend of the sheath over the joint's angle, rad.
        pretension: Tension at the set-up, N.
        spring_at_motor: True if the spring is at the motor's end.
        hardening: Share by which the tissue is stiffer at twice the pretension than at it.
    """

    cable: float
    spring: float
    tissue: float
    friction: float
    bend: Curve
    pretension: float
    spring_at_motor: bool = False
    hardening: float = 0.0

    def further_give(self, tension: Array) -> Array:
        """Return how much more tissue that hardens gives than tissue that does not, m.

        Its stiffness is K_t (1 + h (T − F)/F), at least a tenth of K_t, so that its stretch from
        the pretension F on is F/(h K_t) ln(1 + h (T − F)/F).
        """
        if not self.hardening:
            return np.zeros_like(tension)
        further = (tension - self.pretension) / self.pretension
        stiffer = np.maximum(1.0 + self.hardening * further, 0.1)
        bent = np.log(stiffer) / self.hardening
        return self.pretension * self.tissue * (bent - further)

    def link_compliances(self, nodes: int) -> Array:
        """Return the compliance of each link (nodes + 1,), m/N; the outer links are half ones."""
        links = np.full(nodes + 1, self.cable / nodes)
        links[[0, -1]] *= 0.5
        links[0 if self.spring_at_motor else -1] += self.spring
        links[-1] += self.tissue
        return links


@dataclass(frozen=True)
class Rig:
    """A suit and the arm in it, as numbers and functions of the joint's angle.

    Attributes:
        flexor: Cable that pulls the joint up.
        extensor: Cable that pulls it down.
        flexor_travel: Shortening of the flexor's path since the set-up, m.
        extensor_travel: Lengthening of the extensor's path since the set-up, m.
        flexor_arm: Slope of the flexor's travel, m.
        extensor_arm: Slope of the extensor's travel, m.
        flexor_radius: Radius of the flexor's spool, m.
        ratio: Radius of the extensor's spool over the flexor's.
        weight_moment: Largest torque of forearm, hand and load about the joint, N m.
        upper_arm_angle: Inclination of the upper arm, forward positive, rad.
        inertia: Of forearm, hand and load about the joint, kg m².
        joint_torque: Torque that the joint itself asks for, N m.
        setup_angle: Joint's angle at the set-up, rad.
    """

    flexor: Tendon
    extensor: Tendon
    flexor_travel: Curve
    extensor_travel: Curve
    flexor_arm: Curve
    extensor_arm: Curve
    flexor_radius: float
    ratio: float
    weight_moment: float
    upper_arm_angle: float = 0.0
    inertia: float = 0.0
    joint_torque: Curve = _zero
    setup_angle: float = 0.0

    def static_torque(self, angle: Array) -> Array:
        """Return what gravity and the joint itself ask for, N m."""
        gravity = self.weight_moment * np.sin(angle + self.upper_arm_angle)
        return gravity + self.joint_torque(angle)


@dataclass(frozen=True)
class Motion:
    """The joint's motion in time.

    Attributes:
        time: Instants (samples,), s.
        angle: Joint's angle (samples,), rad.
        acceleration: Its second derivative (samples,), rad/s².
        task: Further torque that the suit must give (samples,), N m; none if it is empty.
        slip: Way that both anchors have slipped along the arm (samples,), m; none if it is empty.
    """

    time: Array
    angle: Array
    acceleration: Array
    task: Array = field(default_factory=lambda: np.zeros(0))
    slip: Array = field(default_factory=lambda: np.zeros(0))

    def slip_with_lead_in(self) -> Array:
        """Return how far the anchors have slipped, from the set-up on, m."""
        slip = self.slip if len(self.slip) else np.zeros(len(self.time))
        return np.concatenate([np.full(LEAD_IN, slip[0]), slip])

    def required_torque(self, rig: Rig) -> Array:
        """Return the torque that the tendons of a rig must give (samples,), N m."""
        static = rig.static_torque(self.angle) + rig.inertia * self.acceleration
        return static + self.task if len(self.task) else static


@dataclass(frozen=True)
class History:
    """Course of a rig along its motion; all arrays are (samples,).

    Attributes:
        time: Instants, s.
        angle: Joint's angle, rad.
        spool_angle: Spool's angle since the set-up, rad.
        motor_torque: Torque of the motor, N m.
        required_torque: Torque that the tendons gave at the joint, N m.
        flexor_motor: Flexor's tension at the motor, N.
        flexor_elbow: Flexor's tension at the elbow, N.
        extensor_motor: Extensor's tension at the motor, N.
        extensor_elbow: Extensor's tension at the elbow, N.
        motor_work: Work of the motor since the first sample, J.
        dissipated: Friction's work in both sheaths since the first sample, J.
        stored: Elastic energy of both cables, springs and tissue, J.
        flexor_slack: True if the flexor is slack.
        extensor_slack: True if the extensor is slack.
        flexor_slides: Share of the flexor's nodes that slide to the motor less those that slide
            to the elbow.
        extensor_slides: The same of the extensor.
    """

    time: Array
    angle: Array
    spool_angle: Array
    motor_torque: Array
    required_torque: Array
    flexor_motor: Array
    flexor_elbow: Array
    extensor_motor: Array
    extensor_elbow: Array
    motor_work: Array
    dissipated: Array
    stored: Array
    flexor_slack: Array
    extensor_slack: Array
    flexor_slides: Array
    extensor_slides: Array

    def select(self, rows: slice) -> History:
        """Select samples."""
        values = {name: value[rows] for name, value in vars(self).items()}
        return replace(self, **values)


@dataclass(frozen=True)
class Demand:
    """Demand of the joints on the cables, over all samples or at one instant.

    Cables stand for all flexors first, then for all extensors (2 rigs, …). A last axis of samples
    is there only in what `make_demand` returns.

    Attributes:
        grip: μφ of a node of each cable (2 rigs, …).
        travel: Way of each elbow end toward the motor (2 rigs, …), m.
        arm: Torque at the joint per tension of each cable (2 rigs, …), m.
        required: Torque that the tendons must give (rigs, …), N m.
    """

    grip: Array
    travel: Array
    arm: Array
    required: Array

    def at(self, sample: int) -> Demand:
        """Return the demand at one instant."""
        return Demand(
            self.grip[:, sample],
            self.travel[:, sample],
            self.arm[:, sample],
            self.required[:, sample],
        )

    def select(self, rows: NDArray[np.intp]) -> Demand:
        """Select rigs of an instant by index."""
        both = both_sides(rows, len(self.required))
        return Demand(self.grip[both], self.travel[both], self.arm[both], self.required[rows])

    def with_give(self, give: Array) -> Demand:
        """Return the demand of an instant with anchors that give further (2 rigs,), m."""
        return replace(self, travel=self.travel + give)

    def between(self, later: Demand, share: float) -> Demand:
        """Return the demand a share of the way to a later instant."""
        return Demand(
            self.grip + share * (later.grip - self.grip),
            self.travel + share * (later.travel - self.travel),
            self.arm + share * (later.arm - self.arm),
            self.required + share * (later.required - self.required),
        )


@dataclass(frozen=True)
class Spooled:
    """The cables of several rigs, on their spools.

    Attributes:
        cables: Links of all flexors, then of all extensors.
        spool: Way of each motor end per spool angle (2 rigs,), m/rad; negative if it pays out.
    """

    cables: Cables
    spool: Array

    def select(self, rows: NDArray[np.intp]) -> Spooled:
        """Select rigs by index."""
        both = both_sides(rows, len(self.spool) // 2)
        return Spooled(self.cables.select(both), self.spool[both])

    def motor_torque(self, cables: Gripped) -> Array:
        """Return the torque of each motor (rigs,), N m."""
        return (cables.tension[:, 0] * self.spool).reshape(2, -1).sum(axis=0)

    def move(
        self,
        before: Gripped,
        guess: NDArray[np.int8],
        demand: Demand,
        angle: Array,
    ) -> Gripped:
        """Turn the spools and move the joints; return what the cables do."""
        motor_end = self.spool * np.concatenate([angle, angle])
        return move_cables(self.cables, before, guess, demand.grip, motor_end, demand.travel)


def both_sides(rows: NDArray[np.intp], rigs: int) -> NDArray[np.intp]:
    """Return the rows of the flexors and extensors of some rigs."""
    return np.concatenate([rows, rigs + rows])


def lead_in(rig: Rig, motion: Motion) -> tuple[Array, Array]:
    """Return angles and required torques from the set-up to the start of a motion."""
    start = motion.angle[0]
    share = np.linspace(0.0, 1.0, LEAD_IN, endpoint=False)
    angle = rig.setup_angle + share * (start - rig.setup_angle)
    missing = motion.required_torque(rig)[0] - rig.static_torque(start)
    return angle, rig.static_torque(angle) + share * missing


def make_demand(rigs: Sequence[Rig], motions: Sequence[Motion], nodes: int) -> Demand:
    """Work out every function of angle and time that the solver needs.

    Args:
        rigs: Suits.
        motions: Motion of each suit, all with the same number of samples.
        nodes: Nodes of each sheath.
    """
    angles = []
    required = []
    for rig, motion in zip(rigs, motions, strict=True):
        angle, torque = lead_in(rig, motion)
        angles.append(np.concatenate([angle, motion.angle]))
        required.append(np.concatenate([torque, motion.required_torque(rig)]))
    moving = list(zip(rigs, angles, strict=True))

    slip = np.array([motion.slip_with_lead_in() for motion in motions])
    flexor_travel = [rig.flexor_travel(angle) for rig, angle in moving]
    extensor_travel = [-rig.extensor_travel(angle) for rig, angle in moving]
    flexor_arm = [rig.flexor_arm(angle) for rig, angle in moving]
    extensor_arm = [-rig.extensor_arm(angle) for rig, angle in moving]
    flexor_grip = [rig.flexor.friction * rig.flexor.bend(angle) / nodes for rig, angle in moving]
    extensor_grip = [
        rig.extensor.friction * rig.extensor.bend(angle) / nodes for rig, angle in moving
    ]
    return Demand(
        grip=np.array(flexor_grip + extensor_grip),
        travel=np.array(flexor_travel + extensor_travel) + np.concatenate([slip, slip]),
        arm=np.array(flexor_arm + extensor_arm),
        required=np.array(required),
    )


def make_spooled(rigs: Sequence[Rig], nodes: int) -> Spooled:
    """Make the cables of several rigs, with their natural lengths."""
    tendons = [rig.flexor for rig in rigs] + [rig.extensor for rig in rigs]
    compliance = np.array([tendon.link_compliances(nodes) for tendon in tendons])
    pretension = np.array([tendon.pretension for tendon in tendons])
    radius = np.array([rig.flexor_radius for rig in rigs])
    ratio = np.array([rig.ratio for rig in rigs])
    return Spooled(
        cables=Cables(compliance, compliance * pretension[:, None]),
        spool=np.concatenate([radius, -ratio * radius]),
    )


def find_spool_angle(
    spooled: Spooled, before: Gripped, demand: Demand, guess: Array
) -> tuple[Array, Gripped]:
    """Find the spool angles at which every joint is in balance at one instant.

    The joint's torque never falls with the spool angle, and is piecewise linear. Newton's step
    is taken where it has a slope, kept within the bracket found so far; where the sheath holds
    (no slope), the spool goes on by strides that double.

    Args:
        spooled: Cables of the rigs.
        before: All cables one instant before.
        demand: Demand at this instant.
        guess: Spool angles to start from (rigs,), rad.

    Raises:
        RuntimeError: If a balance is not found: no spool angle gives the torque.
    """
    rigs = len(guess)
    angle = guess.copy()
    low = np.full(rigs, -np.inf)
    high = np.full(rigs, np.inf)
    stride = np.full(rigs, FIRST_STRIDE)
    found = before.select(np.arange(2 * rigs))
    rows = np.arange(rigs)
    for _ in range(MOST_TRIALS):
        both = both_sides(rows, rigs)
        part = spooled.select(rows)
        asked = demand.select(rows)
        moved = part.move(before.select(both), found.state[both], asked, angle[rows])
        found.replace(both, moved)
        torque = (asked.arm * moved.tension[:, -1]).reshape(2, -1).sum(axis=0)
        slope = (asked.arm * moved.elbow_slope * part.spool).reshape(2, -1).sum(axis=0)
        surplus = torque - asked.required

        low[rows] = np.where(surplus < 0.0, angle[rows], low[rows])
        high[rows] = np.where(surplus > 0.0, angle[rows], high[rows])
        closed = high[rows] - low[rows] <= 1e-14 * (1.0 + np.abs(angle[rows]))
        is_found = (np.abs(surplus) <= BALANCE_TOLERANCE) | closed
        rows = rows[~is_found]
        if not len(rows):
            return angle, found
        surplus = surplus[~is_found]
        slope = slope[~is_found]
        has_slope = slope > LEAST_SLOPE
        newton = angle[rows] - surplus / np.where(has_slope, slope, 1.0)
        strode = angle[rows] - np.sign(surplus) * stride[rows]
        stride[rows] = np.where(has_slope, stride[rows], 2.0 * stride[rows])
        trial = np.where(has_slope, newton, strode)
        is_within = (trial > low[rows]) & (trial < high[rows])
        is_bracketed = np.isfinite(low[rows]) & np.isfinite(high[rows])
        middle = np.where(is_bracketed, 0.5 * (low[rows] + high[rows]), strode)
        angle[rows] = np.where(is_within, trial, middle)
    raise RuntimeError(f"no spool angle balances rigs {rows.tolist()}")


def has_turned(before: Gripped, after: Gripped) -> NDArray[np.bool_]:
    """Return True for each rig some of whose nodes have changed their states (rigs,)."""
    return (before.state != after.state).any(axis=1).reshape(2, -1).any(axis=0)


def settle(
    spooled: Spooled, before: Gripped, demand: Demand, angle: Array, guess: Array
) -> tuple[Array, Gripped]:
    """Find the spool angles of one instant, but let no spool jump for next to nothing.

    Where a spool turns while its joint goes on, neither way of sliding may agree with itself: a
    spool that winds would have to pay out, and the other way about. The balance then has the
    spool cross the whole play of its sheath at every instant, which friction would have to pay
    for as often as there are samples. No motor does this. So a spool that would turn by
    `JUMP` times as much as the cables' stiffness asks for stays where it was until the joint is
    out of balance by `REASON_TO_JUMP`.

    Args:
        spooled: Cables of the rigs.
        before: All cables one instant before.
        demand: Demand at this instant.
        angle: Spool angles one instant before (rigs,), rad.
        guess: Spool angles to start from (rigs,), rad.
    """
    new_angle, after = find_spool_angle(spooled, before, demand, guess)
    rigs = len(angle)
    softness = spooled.cables.compliance.sum(axis=1)
    stiffness = (demand.arm * spooled.spool / softness).reshape(2, -1).sum(axis=0)
    turn = np.abs(new_angle - angle) * stiffness
    rows = np.flatnonzero((turn > BALANCE_TOLERANCE) & has_turned(before, after))
    if not len(rows):
        return new_angle, after
    both = both_sides(rows, rigs)
    asked = demand.select(rows)
    held = spooled.select(rows).move(before.select(both), after.state[both], asked, angle[rows])
    torque = (asked.arm * held.tension[:, -1]).reshape(2, -1).sum(axis=0)
    surplus = np.abs(torque - asked.required)
    stays = (surplus < REASON_TO_JUMP) & (turn[rows] > JUMP * surplus)
    kept = rows[stays]
    new_angle[kept] = angle[kept]
    after.replace(both_sides(kept, rigs), held.select(both_sides(np.flatnonzero(stays), len(rows))))
    return new_angle, after


def step(
    spooled: Spooled,
    before: Gripped,
    angle: Array,
    guess: Array,
    now: Demand,
    then: Demand,
) -> tuple[Array, Gripped, Array, Array]:
    """Go from one sample to the next.

    Where the nodes' states change the way between matters: the spool may turn by the whole play
    of the sheath while the joint hardly moves. There the step is taken in `PARTS` parts, the last
    of which finds the balance again.

    Args:
        spooled: Cables of the rigs.
        before: All cables at the first sample.
        angle: Spool angles there (rigs,), rad.
        guess: Spool angles to start from at the second sample (rigs,), rad.
        now: Demand at the first sample.
        then: Demand at the second sample.

    Returns:
        Spool angles, cables, work of the motors and of friction in the step, J.
    """
    rigs = len(angle)
    new_angle, after = settle(spooled, before, then, angle, guess)
    mean_torque = 0.5 * (spooled.motor_torque(before) + spooled.motor_torque(after))
    motor_work = mean_torque * (new_angle - angle)
    lost = friction_work(before, after).reshape(2, -1).sum(axis=0)

    rows = np.flatnonzero(has_turned(before, after))
    if not len(rows):
        return new_angle, after, motor_work, lost
    both = both_sides(rows, rigs)
    part = spooled.select(rows)
    first = now.select(rows)
    last = then.select(rows)
    cables = before.select(both)
    turned = angle[rows]
    whole_turn = new_angle[rows] - turned
    motor_work[rows] = 0.0
    lost[rows] = 0.0
    for place in range(1, PARTS + 1):
        share = place / PARTS
        demand = first.between(last, share)
        aim = angle[rows] + share * whole_turn
        if place < PARTS:
            moved = part.move(cables, cables.state, demand, aim)
        else:
            aim, moved = settle(part, cables, last, aim, aim)
        mean_torque = 0.5 * (part.motor_torque(cables) + part.motor_torque(moved))
        motor_work[rows] += mean_torque * (aim - turned)
        lost[rows] += friction_work(cables, moved).reshape(2, -1).sum(axis=0)
        turned = aim
        cables = moved
    new_angle[rows] = turned
    after.replace(both, cables)
    return new_angle, after, motor_work, lost


def simulate(rigs: Sequence[Rig], motions: Sequence[Motion], nodes: int = 48) -> list[History]:
    """Drive rigs along their motions.

    Args:
        rigs: Suits.
        motions: Motion of each suit, all with the same number of samples.
        nodes: Nodes of each sheath.

    Returns:
        History of each rig, at the samples of its motion.

    Raises:
        RuntimeError: If no spool angle balances a joint, as where its flexor has no moment arm.
    """
    spooled = make_spooled(rigs, nodes)
    tendons = [rig.flexor for rig in rigs] + [rig.extensor for rig in rigs]
    demand = make_demand(rigs, motions, nodes)
    count = len(rigs)
    samples = demand.required.shape[1]
    motor_tension = np.zeros((samples, 2 * count))
    elbow_tension = np.zeros((samples, 2 * count))
    stored = np.zeros((samples, 2 * count))
    slides = np.zeros((samples, 2 * count))
    slack = np.zeros((samples, 2 * count), dtype=bool)
    spool_angle = np.zeros((samples, count))
    motor_work = np.zeros((samples, count))
    lost = np.zeros((samples, count))

    cables = unstressed_grip(spooled.cables)
    angle = np.zeros(count)
    last_turn = np.zeros(count)
    now = demand.at(0)
    for sample in range(samples):
        held = cables.tension[:, -1]
        give = [tendon.further_give(held[side]) for side, tendon in enumerate(tendons)]
        then = demand.at(sample).with_give(np.array(give))
        new_angle, moved, work, loss = step(spooled, cables, angle, angle + last_turn, now, then)
        last_turn = new_angle - angle
        angle = new_angle
        cables = moved
        now = then
        spool_angle[sample] = angle
        motor_tension[sample] = cables.tension[:, 0]
        elbow_tension[sample] = cables.tension[:, -1]
        stored[sample] = 0.5 * (spooled.cables.compliance * cables.tension**2).sum(axis=1)
        to_motor = (cables.state == TOWARD_MOTOR).mean(axis=1)
        to_elbow = (cables.state == TOWARD_ELBOW).mean(axis=1)
        slides[sample] = to_motor - to_elbow
        slack[sample] = cables.is_slack
        if sample > LEAD_IN:
            motor_work[sample] = motor_work[sample - 1] + work
            lost[sample] = lost[sample - 1] + loss

    motor_torque = motor_tension * spooled.spool
    histories = []
    for rig, motion in enumerate(motions):
        both = [rig, count + rig]
        histories.append(
            History(
                time=motion.time,
                angle=motion.angle,
                spool_angle=spool_angle[LEAD_IN:, rig],
                motor_torque=motor_torque[LEAD_IN:, both].sum(axis=1),
                required_torque=demand.required[rig, LEAD_IN:],
                flexor_motor=motor_tension[LEAD_IN:, rig],
                flexor_elbow=elbow_tension[LEAD_IN:, rig],
                extensor_motor=motor_tension[LEAD_IN:, count + rig],
                extensor_elbow=elbow_tension[LEAD_IN:, count + rig],
                motor_work=motor_work[LEAD_IN:, rig],
                dissipated=lost[LEAD_IN:, rig],
                stored=stored[LEAD_IN:, both].sum(axis=1),
                flexor_slack=slack[LEAD_IN:, rig],
                extensor_slack=slack[LEAD_IN:, count + rig],
                flexor_slides=slides[LEAD_IN:, rig],
                extensor_slides=slides[LEAD_IN:, count + rig],
            )
        )
    return histories
