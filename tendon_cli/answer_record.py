"""The record of an answer, as `design.json` holds it: types for whoever writes or reads one.

Values are SI. A number that is missing or not finite is null, so that JSON can hold it; a rigid
spring is "rigid". Whatever is said about an answer follows from its record alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NotRequired, TypeAlias, TypedDict, cast

Value: TypeAlias = float | str
"""Value on an axis: a number, SI, "rigid", or a name."""
Values: TypeAlias = dict[str, Value]
"""Values by the columns of their axes."""
Interval: TypeAlias = Sequence[float]
"""Lower and upper end of a 95 % interval of a share."""


# --- The question ---------------------------------------------------------------------------------


class GoalRecord(TypedDict):
    """A goal by which choices are compared."""

    column: str
    """Column of `choices.parquet`."""
    maximise: bool
    """True if more of it is better."""


class AxisRecord(TypedDict):
    """An axis of choices or of conditions."""

    key: str
    """Dotted key of the number, or "case", "person" or "draw"."""
    column: str
    """Column of `choices.parquet` or `conditions.parquet`."""
    named: bool
    """True if its values are names."""
    range: list[float] | None
    """Both ends of a range of which a grid is tried, SI; null for a catalogue."""
    step: float | None
    """Largest share by which neighbouring points of the grid differ; null for a catalogue."""
    sets: dict[str, dict[str, float]] | None
    """Numbers that tell each row of a named axis from the others, SI, by the row's name and their
    keys; null for another axis. Rows told by no number, or by many, are left out; of very many rows
    only those that the answer names are told."""
    limits: dict[str, dict[str, float]]
    """Limits that rows of a named axis of conditions set, SI, by the row's name and the name of the
    limit."""
    read: NotRequired[str]
    """Gauge by which the limit on the pretension is read; only of its axis, if it is not F0."""
    carries: NotRequired[dict[str, list[str]]]
    """Words that rows of a table carry along, such as supplier and price, by the row's name;
    only of a table with such columns."""
    drawn: NotRequired[bool]
    """True for a table whose rows are draws; only there."""


class AccuracyRecord(TypedDict):
    """Accuracy with which a suit can be set: one of both."""

    length: float | None
    """Length of both tendons, m."""
    tension: float | None
    """Tension of the kind that is read, N."""


class CarriedRecord(TypedDict):
    """A number that rows of tables carry along, such as a price."""

    name: str
    """Name of its column in the tables."""
    unit: str
    """Unit as the tables have it; may be empty."""
    tables: list[str]
    """Tables over which it is summed."""


class QuestionRecord(TypedDict):
    """The question that is answered, as far as words about the answer need it."""

    carried: NotRequired[dict[str, CarriedRecord]]
    """Numbers that rows of tables carry along, by their columns in the choices; only if there are
    any."""
    intervals: NotRequired[list[str]]
    """Keys of the conditions of which all values between two ends are meant; only if there are
    any."""
    joint: str
    """Name of the joint: "elbow"."""
    own_words: list[str]
    """Texts of the study itself that speak of an elbow; they stay whatever the joint is."""
    read: str
    """Gauge by which a pretension is read: "pretension" (F0), "flexor at joint"."""
    unit: str
    """Unit of what is read, "N" or "N m"; that of pretensions, windows and their ends."""
    pretension: float | None
    """Pretension of every choice, in this unit, if the question gives one."""
    limits: dict[str, float]
    """Limits that the study states for all designs, SI; those of an axis overrule them."""
    own_limits: list[str]
    """Limits that differ between choices; the row of a choice has its own in `limit_` and name."""
    choices: list[AxisRecord]
    """Axes of the choices."""
    conditions: list[AxisRecord]
    """Axes of the conditions, in the order of `conditions.parquet`."""
    counted: str
    """Noun for what a share counts: "persons", "pairs", "draws" or "conditions"."""
    groups: int
    """Number of what a share counts."""
    counts: dict[str, int]
    """Numbers of persons ("person") and draws ("draw")."""
    ranked_by: list[GoalRecord]
    """Goals by which the best are named: those of the study, or the usual ones."""
    accuracy: AccuracyRecord
    """Accuracy with which a suit can be set."""
    needed: float
    """Tolerance that is enough, as a multiple of the accuracy."""
    has_goals: bool
    """True if the study states goals."""
    place: str
    """Place in its window at which a choice is set: "reserve", "middle" or "least"."""


# --- Choices --------------------------------------------------------------------------------------

VerifiedRecord = TypedDict(
    "VerifiedRecord",
    {"value": float, "interval_95": Interval, "of": int, "from": float | None, "to": float | None},
)
"""Judgement of a fresh sample on a choice at its pretension.

`value` is the share that it serves, `interval_95` that of all who could have been drawn, and `of`
the number of persons or draws. From `from` to `to`, N, at least `serve` are served; `from` is null
if no pretension serves so many, `to` also if nothing bounds it.
"""


class ChoiceRecord(TypedDict):
    """A row of `choices.parquet`, with its place.

    It has a value for the column of each axis, too, and where there is a motion for its columns.

    `value_of` reads these and any other column by its name.
    """

    choice: int
    """Row in `choices.parquet`."""
    pretension_from: float | None
    """Lower end of the window, N; null if no pretension could do."""
    pretension_to: float | None
    """Upper end of the window, N; null if nothing bounds it."""
    windows: int
    """Number of intervals of pretension that serve enough."""
    tolerance: float | None
    """Share by which the pretension may be off to either side."""
    from_by: str | None
    """Limit that binds below, or what no pretension could keep."""
    to_by: str | None
    """Limit that binds above."""
    from_condition: int
    """Row of `conditions.parquet` that binds below."""
    to_condition: int
    """Row of `conditions.parquet` that binds above."""
    from_under: Values
    """Values of the condition that binds below."""
    to_under: Values
    """Values of the condition that binds above."""
    from_direction: str | None
    """Direction of the state that binds below; null where the limit belongs to no state."""
    to_direction: str | None
    """Direction of the state that binds above."""
    from_elbow_angle: float | None
    """Elbow angle that binds below, rad."""
    to_elbow_angle: float | None
    """Elbow angle that binds above, rad."""
    from_time: NotRequired[float | None]
    """Moment of a trajectory that binds below, s; there with a trajectory alone."""
    to_time: NotRequired[float | None]
    """Moment of a trajectory that binds above, s."""
    served: float | None
    """Largest share of persons or draws that one pretension serves; null without both."""
    served_at: float | None
    """Share of persons or draws that `pretension` serves; null without both."""
    pretension: float | None
    """Pretension to which the choice is set, N."""
    max_tension: float | None
    """Largest tension of either tendon, N."""
    max_spring_extension: float | None
    """Largest extension of either spring, m."""
    peak_motor_torque: float | None
    """Motor torque of the largest magnitude, N m."""
    min_elbow_stiffness: float | None
    """Smallest stiffness of the elbow, N m/rad."""
    max_contact_pressure: float | None
    """Largest pressure of the strap, Pa."""
    set_flexor_tension: float | None
    """Tension to set in the flexor at the joint, N."""
    set_extensor_tension: float | None
    """Tension to set in the extensor at the joint, N."""
    set_flexor_tension_motor: float | None
    """Tension to set in the flexor at the motor, N."""
    set_extensor_tension_motor: float | None
    """Tension to set in the extensor at the motor, N."""
    tolerance_length: float | None
    """Half the window as a length of both tendons, m; null if nothing bounds it."""
    advice: str | None
    """Advice that it fails at its pretension; null if it keeps all."""
    between_samples: str
    """Status of the window between the samples: one of `say.STATUSES`."""
    feasible: bool
    """True if it has a window; if the pretension is given, one that serves enough; and if a fresh
    sample judges it, that its pretension serves enough of it."""
    served_verified: VerifiedRecord | None
    """Judgement of a fresh sample; null without one, and for choices that are not named."""
    on_front: bool
    """True if no other choice is as good in all goals and better in one."""


def value_of(row: Mapping[str, Any], column: str) -> Any:
    """Return the value of a record in a column that is known by its name alone, such as an axis."""
    return row[column]


# --- Windows between the samples ------------------------------------------------------------------


class CertificateRecord(TypedDict):
    """Result of the proof of one window between the samples."""

    status: str
    """One of `say.STATUSES`."""
    cells: int
    """Number of cells that were tried."""
    margin: float
    """Distance from both ends within which the window is not proved, N."""
    estimate: float | None
    """Estimated error of the ends that are not proved, N."""


class ChoiceCertificate(CertificateRecord):
    """Result of the proof of the window of a choice."""

    choice: int
    """Row of the choice in `choices.parquet`."""


class CurvesRecord(TypedDict):
    """Pretensions that each limit allows the choice named first, over the motion."""

    elbow_angle: list[float]
    """Angles, rad: in order, or those of the samples of a motion in time."""
    time: list[float] | None
    """Times of the samples of a motion in time, s; null if the motion is not in time."""
    at_record_end: list[bool] | None
    """True for samples at the ends of its record, which count for nothing; null likewise."""
    samples: list[float]
    """Angles of the study, rad."""
    all_conditions: bool
    """True if the curves are over all conditions, not over those alone that are served."""
    lower: dict[str, list[float | None]]
    """Least pretension by limit, N; null where the limit asks for nothing."""
    upper: dict[str, list[float | None]]
    """Largest pretension by limit, N."""


class BetweenSamples(CertificateRecord):
    """Proof of the window of the choice named first, and of all that are named."""

    choices: list[ChoiceCertificate]
    """Proofs of all choices that the answer names."""
    method: str
    """Method of the proof, in words."""
    scope: str
    """Range in which the window is proved, in words."""
    curves: CurvesRecord


# --- The suit on the bench ------------------------------------------------------------------------


class SettingRecord(TypedDict):
    """Posture in which the pretension is set."""

    angle: float
    """Elbow angle, rad."""
    upper_arm_angle: float
    """Inclination of the upper arm, rad."""
    load: float
    """Load in the hand, kg."""
    after: str
    """Direction of the last motion."""
    read: str
    """Gauge by which a pretension is read."""
    on_wearer: bool
    """True if the tensions to set are those on the person on whom the anchors were measured."""
    newtons_per_metre: float
    """Pretension F0 that a metre taken from both tendons adds, N/m."""
    read_per_metre: float
    """Growth of what is read per metre taken from both tendons, its unit per metre."""
    accuracy: float
    """Accuracy of setting as a length of both tendons, m."""
    reserve: float
    """Tension of the kind that is read that this accuracy is worth, N."""
    too_long: float | None
    """Length by which both tendons may be too long for the pretension, m; null without a window
    around it."""
    too_short: float | None
    """Length by which both may be too short, m; null if nothing bounds the window above, too."""


class DriftRecord(TypedDict):
    """Motion of the joint that is let go at 10 % beyond the upper end of the window."""

    pretension: float
    """Pretension, N."""
    start: float
    """Angle at which it is let go, rad."""
    end: float
    """Angle at which it rests, or the end of the motion, rad."""
    torque: float
    """Largest torque that drives it, N m."""
    balanced: bool
    """True if it rests at the end."""


class StrapRecord(TypedDict):
    """Strap around the joint."""

    width: float | None
    """Width, m; null if the study states none."""
    pressure: float | None
    """Largest pressure at this width, Pa."""
    most_pressure: float
    """Pressure from which on it hurts, Pa."""
    least_width: float
    """Width at which it presses no harder than that, m."""


class RopeRecord(TypedDict):
    """Rope of the tendons."""

    tension: float
    """Largest tension, N."""
    reserve: float
    """Customary ratio of the breaking tension to the largest one."""
    least_breaking_force: float
    """Tension below which it should not break, N."""
    least_diameter: float
    """Diameter of a stainless 7x7 rope that breaks there, m."""
    breaking_force: float | None
    """Tension at which it breaks, N; null if the study states none."""
    construction: str | None
    """Construction: "7x7"; null if the study states none."""


class SpoolRecord(TypedDict):
    """Spool that is the narrower for its rope."""

    side: Literal["flexor", "extensor"]
    """Side whose spool it is."""
    diameter: float
    """Its diameter, m."""
    rope_diameter: float
    """Diameter of its rope, m."""
    ratio: float
    """Diameter of the spool over that of its rope."""
    construction: str | None
    """Construction of the rope; null if the study states none."""
    least_diameter: float
    """Diameter that suits the rope, m; for 7x7 if its construction is not stated."""
    least_ratios: dict[str, float]
    """Ratio that a rope needs, by its construction."""
    largest_ropes: dict[str, float]
    """Largest diameter of the rope that suits the spool, m, by its construction."""


class SpringRecord(TypedDict):
    """Series springs."""

    stiffness: float | None
    """Stiffness of the flexor's, N/m; null if it is rigid."""
    travel: float
    """Largest extension of either, m."""
    free_length: float | None
    """Length of the flexor's without load, m; null if the study states none."""
    room: float | None
    """Least distance of the anchors less the spring between them, m: if its length without load is
    not stated, the longest that fits; null without a spring between anchors."""
    extension: float | None
    """Extension of the flexor's where room is least, m."""
    distance: float | None
    """Distance of its anchors there, m."""


class MotorRecord(TypedDict):
    """Motor."""

    torque: float
    """Largest torque, N m."""
    speed: float | None
    """Largest speed, rad/s; null if the study says nothing of time."""
    power: float | None
    """Largest power, W."""


FailingPart: TypeAlias = Literal["spring", "strap", "rope", "spool"]
"""Part that fails advice."""


class PartsRecord(TypedDict):
    """Parts that the choice named first needs at its pretension."""

    strap: StrapRecord | None
    """Strap; null if its radius of curvature is not known."""
    rope: RopeRecord
    spool: SpoolRecord
    spring: SpringRecord | None
    """Springs; null if both are rigid."""
    motor: MotorRecord
    fails: list[FailingPart]
    """Parts that fail advice; none if the study wants no advice."""


class SensitivityRecord(TypedDict):
    """Motion of one end of the window by a number."""

    end: Literal["from", "to"]
    key: str
    """Dotted key of the number, or "limits." and the name of a limit."""
    value: float
    """Value of the number, SI."""
    slope: float
    """Derivative of the end by the number, N per SI unit."""
    steady: bool
    """True if the same limit binds in the same state when the number is 1 % off; with people or
    draws, for the one that sets the end."""
    per_percent: float
    """Motion of the end when the number grows by 1 %, N."""


class ExactRecord(TypedDict):
    """Effect of the usual error of a number that the study takes as exact, to first order."""

    key: str
    """Dotted key of the number."""
    value: float
    """Value of the number, SI."""
    deviation: float
    """Usual standard deviation of such a number, SI."""
    deviation_words: str
    """The deviation in words: "5 mm", "20 %", "a factor of 2"."""
    source: str
    """Reason why such a number deviates."""
    moves_from: float | None
    """Change of the lower end if the number grows by it, N; null if the end has no slope."""
    moves_to: float | None
    """Change of the upper end, N."""


class DecisionRecord(TypedDict):
    """Rule by which the best choice is named before all others, and choices that tie with it."""

    rule: str | None
    """Last rule that left fewer choices than the one before it: "built", "served_enough",
    "can_be_set", "advised", "settable" or the column of a goal; "front" with several goals; null if
    there is one choice with a window, or if all of them tie."""
    after: list[str]
    """Rules before it that left fewer choices, too."""
    choices: int | None
    """Number of choices among which this rule decides; null if it is not known, since choices that
    do not matter have no worst values, and may fail advice."""
    left: int
    """Number of choices that it leaves."""
    is_settable: bool
    """True if the tolerance of the best choice is enough."""
    can_be_set: bool
    """True if it is at least the accuracy of setting."""
    by_default: dict[str, float]
    """Numbers that a designer chooses and that have their default values, SI, by key."""
    needed: float
    """Tolerance that is enough, as a length of both tendons, m."""
    ties: int
    """Number of choices that tie, with the best one; 1 if none does."""
    tied: list[Values]
    """Values of the first few of these."""
    broken_by: list[str]
    """Column of the motor torque, or keys of the axes, that break the tie, in this order."""
    no_effect: list[str]
    """Keys of the choices' axes on which no window depends."""


# --- No window ------------------------------------------------------------------------------------


class ConflictRecord(TypedDict):
    """Limits that leave some choices without a window."""

    limits: list[str]
    """The limit that asks for more pretension and the one that asks for less; or one alone."""
    choices: int
    """Number of these choices."""
    gap: float | None
    """Distance between the pretensions asked for in the choice nearest to a window, N."""
    nearest: ChoiceRecord
    """The choice nearest to a window."""
    fails: list[Values]
    """Conditions that it does not keep at its pretension; none if persons or draws are counted."""


class PartRecord(TypedDict):
    """A row of a table of choices, such as a part that one can buy."""

    table: str
    """Name of the table."""
    name: str
    """Name of the row."""
    value: float
    """Value that it sets of the number in question, SI."""


class FixRecord(TypedDict):
    """The least change of one number that gives the choice nearest to a window one."""

    parameter: str
    """Dotted key of the number."""
    before: float
    """Value of the choice, SI."""
    after: float | None
    """Value that gives a window, SI; null if no plausible one does."""
    plausible: Interval
    """Range of the values that are tried, SI."""
    pretension: float | None
    """Pretension in that window, N."""
    max_tension: float | None
    """Largest tension at it, N."""
    max_spring_extension: float | None
    """Largest spring extension, m."""
    peak_motor_torque: float | None
    """Motor torque of the largest magnitude, N m."""
    min_elbow_stiffness: float | None
    """Smallest stiffness of the elbow, N m/rad."""
    max_contact_pressure: float | None
    """Largest pressure of the strap, Pa."""
    printed: str
    """The value with its unit, rounded so that it gives a window when it is typed in."""
    printed_pretension: str
    """A pretension in the window of the printed value, N."""
    can_be_built: bool | None
    """False if the flexor's spring then has no room; null if no value helps."""
    served_verified: VerifiedRecord | None
    """Judgement of a fresh sample on the printed value at that pretension; null without one."""
    nearest: NotRequired[PartRecord]
    """Row whose value is nearest to the one that gives a window; only if a table sets it."""


class RelaxationRecord(TypedDict):
    """The least change of one demand that gives some choice a window."""

    key: str
    """Dotted key of the demand."""
    before: float
    """Value in the study, SI; of several the largest magnitude."""
    farthest: float
    """Farthest value that is tried, SI."""
    after: float | None
    """Value that gives a window, SI; null if even the farthest gives none."""
    printed: str
    """The value with its unit, rounded so that it gives a window."""
    choice: int | None
    """Row of the choice that then serves most."""
    values: Values
    """Its values; empty without one."""
    pretension: float | None
    """Its pretension, N."""
    printed_pretension: str
    """The pretension, rounded so that it lies in the window, N; empty without one."""
    served: float | None
    """Share of persons or draws that it serves, without a choice the largest at the farthest value;
    null without both."""
    can_be_built: bool | None
    """False if the flexor's spring then has no room; null without a choice."""
    served_verified: VerifiedRecord | None
    """Judgement of a fresh sample; null without one."""


# --- Persons and draws ----------------------------------------------------------------------------


class SexRecord(TypedDict):
    """Share served among men or among women."""

    sex: Literal["male", "female"]
    persons: int
    """Number of persons."""
    served: float
    """Share that the pretension serves."""
    interval_95: Interval


class ShareCurve(TypedDict):
    """Share served over pretension."""

    pretension: list[float]
    """Ends of windows, ascending, each twice, N."""
    share: list[float]
    """Share at that end, then between it and the next."""
    low: list[float]
    """Lower ends of the 95 % intervals."""
    high: list[float]
    """Upper ends."""


class BodyRecord(TypedDict):
    """Difference of a dimension of the body between those not served and everyone."""

    theirs: float
    """Mean of those not served, SI."""
    of_all: float
    """Mean of all, SI."""
    deviations: float
    """Difference of the means in standard deviations."""


class ReasonRecord(TypedDict):
    """A reason why the pretension does not serve some."""

    text: str
    """The reason in words."""
    needs: str
    """Need of those not served: "more", "less" or "another suit"."""
    limits: list[str]
    """The limit that is not kept, or both that conflict."""
    conditions: list[int]
    """For each limit the row of the condition under which it binds for most of them."""
    under: list[Values]
    """Values of these conditions."""
    count: int
    """Number of persons, draws or pairs."""
    share: float
    """Share of all."""
    interval_95: Interval
    first: list[str]
    """Names of the persons, the farthest from being served first."""
    bodies: dict[str, BodyRecord]
    """Dimensions by name, the largest difference first."""


class SuitRecord(TypedDict):
    """One suit of several sizes."""

    value: Value
    """Value on the axis of the sizes."""
    pretension: float
    """Its pretension, N."""


class SizeRecord(TypedDict):
    """The best few suits along an axis of choices."""

    choices: list[SuitRecord]
    served: float
    """Share of the persons whom at least one of these suits serves."""
    interval_95: Interval
    persons: int
    """Number of persons for whom the suits are chosen."""
    values_tried: int
    """Number of values of the axis that are tried."""
    all_values: bool
    """True if these are all values."""


class IndexRecord(TypedDict):
    """Sobol indices of one uncertain input."""

    name: str
    """Name of the input in words."""
    first: float
    """First-order index: share of the variance that it explains alone."""
    first_standard_error: float
    total: float
    """Total index: share of the variance in which it has a part."""
    total_standard_error: float


class SobolRecord(TypedDict):
    """Sobol indices of one end of the window."""

    end: str
    """Column of the end: "pretension_from" or "pretension_to"."""
    standard_deviation: float
    """Standard deviation of the end, N."""
    inputs: dict[str, IndexRecord]
    """Indices by the key of the input."""


class PopulationRecord(TypedDict):
    """The choice named first for persons or draws: whom it serves, and why not the others."""

    choice: int
    """Row of the choice."""
    values: Values
    """Its values."""
    kind: str
    """Noun for what a share counts, in the plural."""
    count: int
    """Number of persons, draws or pairs."""
    effective_count: float
    """Effective size of the sample, (Σw)²/Σw²."""
    counts: dict[str, int]
    """Numbers of persons ("person") and draws ("draw")."""
    window: Sequence[float | None]
    """Window of the choice, N."""
    pretension: float | None
    """Its pretension, N."""
    served: float
    """Share that the pretension serves."""
    interval_95: Interval
    served_verified: VerifiedRecord | None
    """Judgement of a fresh sample; null without one. The rest is of the study's own sample, but
    for `by` and `curve`, which are of the fresh one if its persons are drawn."""
    largest_share: float
    """Largest share that one pretension serves."""
    largest_share_at: float | None
    """Pretension that serves this share, N; null if none serves anybody."""
    set: dict[str, list[float]]
    """Range over persons, draws or pairs of both of each tension to set, N."""
    by: list[SexRecord]
    """Shares among men and women, if the study asks for them."""
    curve: ShareCurve
    not_served: list[ReasonRecord]
    """Reasons, the most frequent first."""
    sizes: dict[str, list[SizeRecord]]
    """For each axis of choices the best suit, the best two, the best three."""
    sobol: list[SobolRecord]
    """Indices of both ends; empty if nothing is drawn."""
    title: str
    """The choice, its pretension and the share that it serves, in words."""


# --- The answer -----------------------------------------------------------------------------------


class CutoffCheck(TypedDict):
    """Largest values over designs at the cutoff of a trajectory, and at 0.7 times that."""

    cutoff: float
    """Cutoff of the study, Hz."""
    lower: float
    """Lower cutoff, Hz."""
    peak_motor_speed: tuple[float | None, float | None]
    """Largest speed of the motor at the cutoff and at the lower one, rad/s; null if unknown."""
    peak_motor_power: tuple[float | None, float | None]
    """Largest power of the motor at both, W."""
    decides: bool
    """True if either changes by over 10 %: then it is the cutoff that decides it."""


class ChecksRecord(TypedDict):
    """Checks of what an answer rests on."""

    cutoff: CutoffCheck
    """Check of the cutoff of the trajectory's low-pass, for the choice named first at its
    pretension; without a window for the choice nearest to one."""


class Checked(TypedDict):
    """Part of the record that only some answers have."""

    checks: NotRequired[ChecksRecord]
    """There if a trajectory gives the motion."""


class BestRecord(TypedDict):
    """The best choices, and the first of them on the bench."""

    goals: list[GoalRecord]
    """Goals of the study; empty if it leaves them open."""
    best: ChoiceRecord | None
    """The best choice; with several goals the best compromise; null if none has a window."""
    best_by: dict[str, ChoiceRecord]
    """Best choice by each usual goal's column, if the study names no goals."""
    decided: DecisionRecord | None
    """Rule by which the best choice is named first; null without one."""
    given_up: float | None
    """Largest share of the range of any goal that the best compromise gives up."""
    window_for_all: Sequence[float | None] | None
    """Window that serves all, N, if fewer are enough and there is one."""
    front: list[ChoiceRecord]
    """Choices that no other beats in every goal, in the order of the first goal."""
    setting: SettingRecord | None
    """Posture in which the best choice is set; null without one."""
    drift: DriftRecord | None
    """Drift beyond the upper end; null if stability does not set it."""
    parts_needed: PartsRecord | None
    """Parts that the choice named first needs; null if no choice has a window."""
    sensitivities: list[SensitivityRecord]
    """Motion of the ends of the best choice's window, the largest per 1 % first."""
    taken_as_exact: list[ExactRecord]
    """Numbers that the study takes as exact, the one that moves an end most first."""


class FreshRecord(TypedDict):
    """The fresh sample that judges the choices that an answer names."""

    count: int
    """Number of members."""
    persons: int
    """Number of persons of a file, for all of whom there are draws; 0 without a file."""
    kind: Literal["persons", "draws"]
    """Noun for the members: persons are drawn, too, or draws alone."""


class TradeOffRecord(TypedDict):
    """Best choice with each value of a limit on which the choices differ."""

    key: str
    """Key of the axis that sets the limit: `limits.` and its name, or the name of a table."""
    column: str
    """Column of `choices.parquet` of that axis."""
    values: list[Value]
    """Values of the axis, SI, or its names, in their order."""
    best: list[ChoiceRecord | None]
    """For each the choice of the grid that would be named first; null if none has a window."""


class AnswerResults(BestRecord, Checked):
    """Answer without the facts of the run."""

    question: QuestionRecord
    choices: int
    """Number of choices."""
    conditions: int
    """Number of conditions."""
    feasible: int
    """Number of choices that have a window."""
    trade_offs: list[TradeOffRecord]
    """Best choice with each value of each limit on which the choices differ."""
    serve: float
    """Share that a window must serve."""
    verified_by: FreshRecord | None
    """Fresh sample that judges the named choices; null without persons and draws, or if the study
    wants none."""
    between_samples: BetweenSamples | None
    """Proof of the windows; null if no choice has one."""
    proved: list[ChoiceRecord]
    """Choices that the study names to be proved."""
    conflicts: list[ConflictRecord]
    """Reasons why choices have no window, the most frequent first."""
    fixes: list[FixRecord]
    """Changes that would give a window if no choice has one, the least change first."""
    would_take: list[RelaxationRecord]
    """Relaxations that would give a window if no choice has one."""
    notes: list[str]
    """Sentences on what is left out, and why."""
    population: PopulationRecord | None
    """The choice named first for persons or draws; null without them."""


class FileRecord(TypedDict):
    """A file of a table."""

    path: str
    rows: int
    size: int
    """Size, bytes."""
    sha256: str


class AnswerRecord(AnswerResults):
    """The whole record in `design.json`."""

    name: str
    title: str
    verb: str
    study: dict[str, Any]
    """Content of the study."""
    axes: list[str]
    """Keys of the axes of the study, slowest first."""
    sources: dict[str, Any]
    """Files that the study names."""
    study_hash: str
    results_version: int
    versions: dict[str, str]
    parts: int
    resumed_parts: int
    seconds: float
    figures: list[str]
    figure_seconds: float
    warnings: list[str]
    files: list[FileRecord]
    checksum: str
    blocks: list[dict[str, Any]]
    """The answer in words, as headings, sentences, items, tables and notes."""
    text: str
    """The same in 80 columns."""


def population_of(record: AnswerResults) -> PopulationRecord:
    """Return the part of a record on persons or draws.

    Raises:
        ValueError: The answer has neither.
    """
    if record["population"] is None:
        raise ValueError("an answer without persons and draws has no record of them")
    return record["population"]


def named_first(record: AnswerResults) -> ChoiceRecord | None:
    """Return the choice that an answer names first; None if it names none.

    It is the best choice. If no choice has a window, it is the one that comes nearest to one.
    """
    best = record["best"]
    if best is not None:
        return best
    if record["conflicts"]:
        return record["conflicts"][0]["nearest"]
    return None


def as_answer(record: Mapping[str, Any]) -> AnswerRecord:
    """Return the record of an answer, as read from `design.json`, with its type."""
    return cast("AnswerRecord", record)
