"""The record of an answer, as `design.json` holds it: types for whoever writes or reads one.

Values are SI. A number that is missing or not finite is null, so that JSON can hold it; a rigid
spring is "rigid". Whatever is said about an answer follows from its record alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

from tendon_cli.verbs.typed_record import AS_READ, OTHERS, Record

Value: TypeAlias = float | str
"""Value on an axis: a number, SI, "rigid", or a name."""
Values: TypeAlias = dict[str, Value]
"""Values by the columns of their axes."""
Interval: TypeAlias = Sequence[float]
"""Lower and upper end of a 95 % interval of a share."""


@dataclass(kw_only=True)
class GoalRecord(Record):
    """A goal by which choices are compared."""

    column: Annotated[str, "Column of `choices.parquet`"]
    maximise: Annotated[bool, "True if more of it is better"]


@dataclass(kw_only=True)
class AxisRecord(Record):
    """An axis of choices or of conditions."""

    key: Annotated[str, 'Dotted key of the number, or "case", "person" or "draw"']
    column: Annotated[str, "Column of `choices.parquet` or `conditions.parquet`"]
    named: Annotated[bool, "True if its values are names"]
    range: Annotated[
        list[float] | None,
        "Both ends of a range of which a grid is tried; null for a catalogue",
        "SI",
    ]
    step: Annotated[
        float | None,
        "Largest share by which neighbouring points of the grid differ; null for a catalogue",
    ]
    sets: Annotated[
        dict[str, dict[str, float]] | None,
        "Numbers that tell each row of a named axis from the others, by the row's name and their "
        "keys; null for another axis. Rows told by no number, or by many, are left out; of very "
        "many rows only those that the answer names are told",
        "SI",
    ]
    limits: Annotated[
        dict[str, dict[str, float]],
        "Limits that rows of a named axis of conditions set, by the row's name and the name of "
        "the limit",
        "SI",
    ]
    read: Annotated[
        str | None,
        "Gauge by which the limit on the pretension is read; only of its axis, if it is not F0",
    ] = None
    carries: Annotated[
        dict[str, list[str]] | None,
        "Words that rows of a table carry along, such as supplier and price, by the row's name; "
        "only of a table with such columns",
    ] = None
    drawn: Annotated[bool, "True for a table whose rows are draws; only there"] = False


@dataclass(kw_only=True)
class AccuracyRecord(Record):
    """Accuracy with which a suit can be set: one of both."""

    length: Annotated[float | None, "Length of both tendons", "m"]
    tension: Annotated[float | None, "Tension of the kind that is read", "N"]


@dataclass(kw_only=True)
class CarriedRecord(Record):
    """A number that rows of tables carry along, such as a price."""

    name: Annotated[str, "Name of its column in the tables"]
    unit: Annotated[str, "Unit as the tables have it; may be empty"]
    tables: Annotated[list[str], "Tables over which it is summed"]
    pieces: Annotated[
        dict[str, int], "Number of parts for which a row of a table counts, if it is not one"
    ] = field(default_factory=dict)


@dataclass(kw_only=True)
class QuestionRecord(Record):
    """The question that is answered, as far as words about the answer need it."""

    carried: Annotated[
        dict[str, CarriedRecord],
        "Numbers that rows of tables carry along, by their columns in the choices; only if there "
        "are any",
    ] = field(default_factory=dict)
    intervals: Annotated[
        list[str],
        "Keys of the conditions of which all values between two ends are meant; only if there are "
        "any",
    ] = field(default_factory=list)
    joint: Annotated[str, 'Name of the joint: "elbow"']
    own_words: Annotated[
        list[str],
        "Texts of the study itself that speak of an elbow; they stay whatever the joint is",
    ]
    read: Annotated[
        str,
        'Gauge by which a pretension is read: "pretension" (F0), "flexor at joint"',
    ]
    set_by_sample: Annotated[
        bool, "True if windows and settings of the named choices are those of a second sample"
    ] = False
    shows_own_f0: Annotated[
        bool,
        "True if pretensions in rows of choices are F0 of the study's own arm; all others are as "
        "they are read",
    ] = False
    unit: Annotated[
        str,
        'Unit of what is read, "N" or "N m"; that of pretensions, windows and their ends',
    ]
    pretension: Annotated[
        float | None, "Pretension of every choice, in this unit, if the question gives one", AS_READ
    ]
    limits: Annotated[
        dict[str, float],
        "Limits that the study states for all designs; those of an axis overrule them",
        "SI",
    ]
    own_limits: Annotated[
        list[str],
        "Limits that differ between choices; the row of a choice has its own in `limit_` and name",
    ]
    choices: Annotated[list[AxisRecord], "Axes of the choices"]
    conditions: Annotated[
        list[AxisRecord],
        "Axes of the conditions, in the order of `conditions.parquet`",
    ]
    counted: Annotated[
        str,
        'Noun for what a share counts: "persons", "pairs", "draws" or "conditions"',
    ]
    groups: Annotated[int, "Number of what a share counts"]
    counts: Annotated[dict[str, int], 'Numbers of persons ("person") and draws ("draw")']
    ranked_by: Annotated[
        list[GoalRecord],
        "Goals by which the best are named: those of the study, or the usual ones",
    ]
    accuracy: Annotated[AccuracyRecord, "Accuracy with which a suit can be set"]
    needed: Annotated[float, "Tolerance that is enough, as a multiple of the accuracy"]
    has_goals: Annotated[bool, "True if the study states goals"]
    place: Annotated[
        str,
        'Place in its window at which a choice is set: "reserve", "middle" or "least"',
    ]

    @property
    def setting_digits(self) -> int:
        """Significant digits of what to set: the seed of a sample decides on the fourth."""
        return 3 if self.set_by_sample else 4


@dataclass(kw_only=True)
class VerifiedRecord(Record):
    """Judgement of a fresh sample on a choice at its pretension."""

    value: Annotated[float, "Share that it serves"]
    interval_95: Annotated[Interval, "95 % interval of that of all who could have been drawn"]
    of: Annotated[int, "Number of persons or draws"]
    from_: Annotated[
        float | None, "Least pretension that serves enough; null if none does", AS_READ
    ]
    to: Annotated[float | None, "Largest one; null also if nothing bounds it", AS_READ]


@dataclass(kw_only=True)
class ChoiceRecord(Record):
    """A row of `choices.parquet`, with its place."""

    choice: Annotated[int, "Row in `choices.parquet`"]
    columns: Annotated[dict[str, Any], OTHERS]
    set_flexor_tension: Annotated[float | None, "Tension to set in the flexor at the joint", "N"]
    set_extensor_tension: Annotated[
        float | None,
        "Tension to set in the extensor at the joint",
        "N",
    ]
    set_flexor_tension_motor: Annotated[
        float | None,
        "Tension to set in the flexor at the motor",
        "N",
    ]
    set_extensor_tension_motor: Annotated[
        float | None,
        "Tension to set in the extensor at the motor",
        "N",
    ]
    set_flexor_tension_from: Annotated[
        float | None,
        "Tension in the flexor at the joint at the lower end of the window",
        "N",
    ]
    set_flexor_tension_to: Annotated[
        float | None,
        "The same at the upper end; null if nothing bounds it",
        "N",
    ]
    pretension: Annotated[float | None, "Pretension to which the choice is set", AS_READ]
    pretension_from: Annotated[
        float | None,
        "Lower end of the window; null if no pretension could do",
        AS_READ,
    ]
    pretension_to: Annotated[
        float | None,
        "Upper end of the window; null if nothing bounds it",
        AS_READ,
    ]
    windows: Annotated[int, "Number of intervals of pretension that serve enough"]
    tolerance: Annotated[float | None, "Share by which the pretension may be off to either side"]
    from_by: Annotated[str | None, "Limit that binds below, or what no pretension could keep"]
    to_by: Annotated[str | None, "Limit that binds above"]
    from_condition: Annotated[int, "Row of `conditions.parquet` that binds below"]
    to_condition: Annotated[int, "Row of `conditions.parquet` that binds above"]
    from_under: Annotated[Values, "Values of the condition that binds below"]
    to_under: Annotated[Values, "Values of the condition that binds above"]
    from_direction: Annotated[
        str | None,
        "Direction of the state that binds below; null where the limit belongs to no state",
    ]
    to_direction: Annotated[str | None, "Direction of the state that binds above"]
    from_elbow_angle: Annotated[float | None, "Elbow angle that binds below", "rad"]
    to_elbow_angle: Annotated[float | None, "Elbow angle that binds above", "rad"]
    served: Annotated[
        float | None,
        "Largest share of persons or draws that one pretension serves; null without both",
    ]
    served_at: Annotated[
        float | None,
        "Share of persons or draws that `pretension` serves; null without both",
    ]
    max_tension: Annotated[float | None, "Largest tension of either tendon", "N"]
    max_spring_extension: Annotated[float | None, "Largest extension of either spring", "m"]
    peak_motor_torque: Annotated[float | None, "Motor torque of the largest magnitude", "N m"]
    min_elbow_stiffness: Annotated[float | None, "Smallest stiffness of the elbow", "N m/rad"]
    max_contact_pressure: Annotated[float | None, "Largest pressure of the strap", "Pa"]
    tolerance_length: Annotated[
        float | None,
        "Half the window as a length of both tendons; null if nothing bounds it",
        "m",
    ]
    advice: Annotated[str | None, "Advice that it fails at its pretension; null if it keeps all"]
    between_samples: Annotated[
        str,
        "Status of the window between the samples: sampled, proven or open",
    ]
    feasible: Annotated[
        bool,
        "True if it has a window; if the pretension is given, one that serves enough; and if a "
        "fresh sample judges it, that its pretension serves enough of it",
    ]
    served_verified: Annotated[
        VerifiedRecord | None,
        "Judgement of a fresh sample; null without one, and for choices that are not named",
    ]
    on_front: Annotated[bool, "True if no other choice is as good in all goals and better in one"]


@dataclass(kw_only=True)
class CertificateRecord(Record):
    """Result of the proof of one window between the samples."""

    status: Annotated[str, "Status: sampled, proven or open"]
    cells: Annotated[int, "Number of cells that were tried"]
    margin: Annotated[
        float, "Distance from both ends within which the window is not proved", AS_READ
    ]
    estimate: Annotated[float | None, "Estimated error of the ends that are not proved", AS_READ]


@dataclass(kw_only=True)
class ChoiceCertificate(CertificateRecord):
    """Result of the proof of the window of a choice."""

    choice: Annotated[int, "Row of the choice in `choices.parquet`"]


@dataclass(kw_only=True)
class CurvesRecord(Record):
    """Pretensions that each limit allows the choice named first, over the motion."""

    elbow_angle: Annotated[
        list[float],
        "Angles: in order, or those of the samples of a motion in time",
        "rad",
    ]
    time: Annotated[
        list[float] | None,
        "Times of the samples of a motion in time; null if the motion is not in time",
        "s",
    ]
    at_record_end: Annotated[
        list[bool] | None,
        "True for samples at the ends of its record, which count for nothing; null likewise",
    ]
    samples: Annotated[list[float], "Angles of the study", "rad"]
    all_conditions: Annotated[
        bool,
        "True if the curves are over all conditions, not over those alone that are served",
    ]
    lower: Annotated[
        dict[str, list[float | None]],
        "Least pretension by limit; null where the limit asks for nothing",
        AS_READ,
    ]
    upper: Annotated[dict[str, list[float | None]], "Largest pretension by limit", AS_READ]


@dataclass(kw_only=True)
class BetweenSamples(CertificateRecord):
    """Proof of the window of the choice named first, and of all that are named."""

    choices: Annotated[list[ChoiceCertificate], "Proofs of all choices that the answer names"]
    method: Annotated[str, "Method of the proof, in words"]
    scope: Annotated[str, "Range in which the window is proved, in words"]
    curves: Annotated[CurvesRecord, "Limits over the motion"]


@dataclass(kw_only=True)
class SettingRecord(Record):
    """Posture in which the pretension is set."""

    angle: Annotated[float, "Elbow angle", "rad"]
    upper_arm_angle: Annotated[float, "Inclination of the upper arm", "rad"]
    load: Annotated[float, "Load in the hand", "kg"]
    after: Annotated[str, "Direction of the last motion"]
    read: Annotated[str, "Gauge by which a pretension is read"]
    on_wearer: Annotated[
        bool,
        "True if the tensions to set are those on the person on whom the anchors were measured",
    ]
    newtons_per_metre: Annotated[
        float,
        "Pretension F0 that a metre taken from both tendons adds",
        "N/m",
    ]
    read_per_metre: Annotated[
        float,
        "Growth of what is read per metre taken from both tendons, its unit per metre",
    ]
    accuracy: Annotated[float, "Accuracy of setting as a length of both tendons", "m"]
    reserve: Annotated[
        float, "Tension of the kind that is read that this accuracy is worth", AS_READ
    ]
    too_long: Annotated[
        float | None,
        "Length by which both tendons may be too long for the pretension; null without a window "
        "around it",
        "m",
    ]
    too_short: Annotated[
        float | None,
        "Length by which both may be too short; null if nothing bounds the window above, too",
        "m",
    ]


@dataclass(kw_only=True)
class DriftRecord(Record):
    """Motion of the joint that is let go at 10 % beyond the upper end of the window."""

    pretension: Annotated[float, "Pretension", AS_READ]
    start: Annotated[float, "Angle at which it is let go", "rad"]
    end: Annotated[float, "Angle at which it rests, or the end of the motion", "rad"]
    torque: Annotated[float, "Largest torque that drives it", "N m"]
    balanced: Annotated[bool, "True if it rests at the end"]


@dataclass(kw_only=True)
class StrapRecord(Record):
    """Strap around the joint."""

    width: Annotated[float | None, "Width; null if the study states none", "m"]
    pressure: Annotated[float | None, "Largest pressure at this width", "Pa"]
    most_pressure: Annotated[float, "Pressure from which on it hurts", "Pa"]
    least_width: Annotated[float, "Width at which it presses no harder than that", "m"]


@dataclass(kw_only=True)
class RopeRecord(Record):
    """Rope of the tendons."""

    tension: Annotated[float, "Largest tension", "N"]
    reserve: Annotated[float, "Customary ratio of the breaking tension to the largest one"]
    least_breaking_force: Annotated[float, "Tension below which it should not break", "N"]
    least_diameter: Annotated[float, "Diameter of a stainless 7x7 rope that breaks there", "m"]
    kinds: Annotated[
        dict[str, float], "Diameter of the weakest sufficient rope, by kinds that bend easily", "m"
    ]
    spools: Annotated[
        dict[str, float], "Diameter of the narrowest spool that suits it, by the same kinds", "m"
    ]
    breaking_force: Annotated[
        float | None,
        "Tension at which it breaks; null if the study states none",
        "N",
    ]
    construction: Annotated[str | None, 'Construction: "7x7"; null if the study states none']


@dataclass(kw_only=True)
class SpoolRecord(Record):
    """Spool that is the narrower for its rope."""

    side: Annotated[Literal["flexor", "extensor"], "Side whose spool it is"]
    diameter: Annotated[float, "Its diameter", "m"]
    rope_diameter: Annotated[float, "Diameter of its rope", "m"]
    ratio: Annotated[float, "Diameter of the spool over that of its rope"]
    construction: Annotated[str | None, "Construction of the rope; null if the study states none"]
    least_diameter: Annotated[
        float,
        "Diameter that suits the rope; for 7x7 if its construction is not stated",
        "m",
    ]
    least_ratios: Annotated[dict[str, float], "Ratio that a rope needs, by its construction"]
    largest_ropes: Annotated[
        dict[str, float],
        "Largest diameter of the rope that suits the spool, by its construction",
        "m",
    ]


@dataclass(kw_only=True)
class SpringRecord(Record):
    """Series springs."""

    stiffness: Annotated[float | None, "Stiffness of the flexor's; null if it is rigid", "N/m"]
    travel: Annotated[float, "Largest extension of either", "m"]
    free_length: Annotated[
        float | None,
        "Length of the flexor's without load; null if the study states none",
        "m",
    ]
    room: Annotated[
        float | None,
        "Least distance of the anchors less the spring between them: if its length without load "
        "is not stated, the longest that fits; null without a spring between anchors",
        "m",
    ]
    least_length: Annotated[
        float | None,
        "Shortest unloaded length, hooks included, to which the flexor's can be wound of music "
        "wire; null for a rigid one",
        "m",
    ]
    extension: Annotated[float | None, "Extension of the flexor's where room is least", "m"]
    distance: Annotated[float | None, "Distance of its anchors there", "m"]


@dataclass(kw_only=True)
class MotorRecord(Record):
    """Motor."""

    torque: Annotated[float, "Largest torque at the spool", "N m"]
    worn_torque: Annotated[
        float | None,
        "The same with worn sheaths, which pass 69 % of the tension; null where the study's pass "
        "less",
        "N m",
    ]
    speed: Annotated[float | None, "Largest speed; null if the study says nothing of time", "rad/s"]
    power: Annotated[float | None, "Largest power", "W"]


FailingPart: TypeAlias = Literal["spring", "strap", "rope", "spool"]
"""Part that fails advice."""


@dataclass(kw_only=True)
class PartsRecord(Record):
    """Parts that the choice named first needs at its pretension."""

    strap: Annotated[StrapRecord | None, "Strap; null if its radius of curvature is not known"]
    rope: Annotated[RopeRecord, "Rope of the tendons"]
    spool: Annotated[SpoolRecord, "The narrower spool"]
    spring: Annotated[SpringRecord | None, "Springs; null if both are rigid"]
    motor: Annotated[MotorRecord, "Motor"]
    fails: Annotated[list[FailingPart], "Parts that fail advice; none if the study wants no advice"]


@dataclass(kw_only=True)
class SensitivityRecord(Record):
    """Motion of one end of the window by a number."""

    end: Annotated[Literal["from", "to"], "End of the window"]
    key: Annotated[str, 'Dotted key of the number, or "limits." and the name of a limit']
    value: Annotated[float, "Value of the number", "SI"]
    slope: Annotated[float, "Derivative of the end by the number per SI unit", "N"]
    steady: Annotated[
        bool,
        "True if the same limit binds in the same state when the number is 1 % off; with people "
        "or draws, for the one that sets the end",
    ]
    per_percent: Annotated[float, "Motion of the end when the number grows by 1 %", AS_READ]


@dataclass(kw_only=True)
class AssumedRecord(Record):
    """A number that may be otherwise than a study says, and what that does."""

    key: Annotated[str, "Dotted key of the number, or of that of one side"]
    value: Annotated[
        float | None, "Value of the number in the choice named first; null for a rigid one", "SI"
    ]
    deviation: Annotated[
        float | None, "Standard deviation of such a number; null where `other` says it", "SI"
    ]
    deviation_words: Annotated[str, 'The deviation in words: "5 mm", "20 %", "a factor of 1.4"']
    kind: Annotated[
        str,
        'Shape in which it is drawn: "normal", "log-normal" or "uniform"; "exact" if it is not, '
        '"given" if it is no deviation',
    ]
    source: Annotated[str, "Reason why such a number deviates"]
    from_: Annotated[str, 'Who says how far: "study", "usual", "fit" or "person"']
    moves_from: Annotated[
        float | None,
        "Change of the lower end by this deviation; null if it is not known",
        AS_READ,
    ]
    moves_to: Annotated[float | None, "Change of the upper end", AS_READ]
    other: Annotated[float | None, "Value that what is given may well have", "SI"] = None
    served: Annotated[
        float | None, "Share that the choice named first then serves as it is set"
    ] = None
    served_anew: Annotated[
        float | None, "Largest share that any choice could then serve, set anew"
    ] = None


@dataclass(kw_only=True)
class ListedRecord(Record):
    """A pretension that the study lists, and whom the choice named first then serves."""

    pretension: Annotated[float, "The pretension as the study states it", "N"]
    reading: Annotated[float, "What the gauge of the answer shows", AS_READ]
    served: Annotated[float, "Share of the fresh sample, or of the conditions, that it serves"]


@dataclass(kw_only=True)
class DecisionRecord(Record):
    """Rule by which the best choice is named before all others, and choices that tie with it."""

    rule: Annotated[
        str | None,
        'Last rule that left fewer choices than the one before it: "built", "served_enough", '
        '"can_be_set", "advised", "settable" or the column of a goal; "front" with several goals; '
        "null if there is one choice with a window, or if all of them tie",
    ]
    after: Annotated[list[str], "Rules before it that left fewer choices, too"]
    choices: Annotated[
        int | None,
        "Number of choices among which this rule decides; null if it is not known, since choices "
        "that do not matter have no worst values, and may fail advice",
    ]
    left: Annotated[int, "Number of choices that it leaves"]
    is_settable: Annotated[bool, "True if the tolerance of the best choice is enough"]
    can_be_set: Annotated[bool, "True if it is at least the accuracy of setting"]
    by_default: Annotated[
        dict[str, float],
        "Numbers that a designer chooses and that have their default values, by key",
        "SI",
    ]
    needed: Annotated[float, "Tolerance that is enough, as a length of both tendons", "m"]
    ties: Annotated[int, "Number of choices that tie, with the best one; 1 if none does"]
    tied: Annotated[list[Values], "Values of the first few of these"]
    broken_by: Annotated[
        list[str],
        "Column of the motor torque, or keys of the axes, that break the tie, in this order",
    ]
    no_effect: Annotated[list[str], "Keys of the choices' axes on which no window depends"]


@dataclass(kw_only=True)
class ConflictRecord(Record):
    """Limits that leave some choices without a window."""

    limits: Annotated[
        list[str],
        "The limit that asks for more pretension and the one that asks for less; or one alone",
    ]
    choices: Annotated[int, "Number of these choices"]
    gap: Annotated[
        float | None,
        "Distance between the pretensions asked for in the choice nearest to a window",
        AS_READ,
    ]
    nearest: Annotated[ChoiceRecord, "The choice nearest to a window"]
    fails: Annotated[
        list[Values],
        "Conditions that it does not keep at its pretension; none if persons or draws are counted",
    ]


@dataclass(kw_only=True)
class PartRecord(Record):
    """A row of a table of choices, such as a part that one can buy."""

    table: Annotated[str, "Name of the table"]
    name: Annotated[str, "Name of the row"]
    value: Annotated[float, "Value that it sets of the number in question", "SI"]


@dataclass(kw_only=True)
class FixRecord(Record):
    """The least change of one number that gives the choice nearest to a window one."""

    parameter: Annotated[str, "Dotted key of the number"]
    before: Annotated[float, "Value of the choice", "SI"]
    after: Annotated[float | None, "Value that gives a window; null if no plausible one does", "SI"]
    plausible: Annotated[Interval, "Range of the values that are tried", "SI"]
    pretension: Annotated[float | None, "Pretension in that window", AS_READ]
    max_tension: Annotated[float | None, "Largest tension at it", "N"]
    max_spring_extension: Annotated[float | None, "Largest spring extension", "m"]
    peak_motor_torque: Annotated[float | None, "Motor torque of the largest magnitude", "N m"]
    min_elbow_stiffness: Annotated[float | None, "Smallest stiffness of the elbow", "N m/rad"]
    max_contact_pressure: Annotated[float | None, "Largest pressure of the strap", "Pa"]
    printed: Annotated[
        str,
        "The value with its unit, rounded so that it gives a window when it is typed in",
    ]
    printed_pretension: Annotated[str, "A pretension in the window of the printed value", "N"]
    served_verified: Annotated[
        VerifiedRecord | None,
        "Judgement of a fresh sample on the printed value at that pretension; null without one",
    ]
    nearest: Annotated[
        PartRecord | None,
        "Row whose value is nearest to the one that gives a window; only if a table sets it",
    ] = None


@dataclass(kw_only=True)
class RelaxationRecord(Record):
    """The least change of one demand that gives some choice a window."""

    key: Annotated[str, "Dotted key of the demand"]
    before: Annotated[float, "Value in the study; of several the largest magnitude", "SI"]
    farthest: Annotated[float, "Farthest value that is tried", "SI"]
    after: Annotated[
        float | None,
        "Value that gives a window; null if even the farthest gives none",
        "SI",
    ]
    printed: Annotated[str, "The value with its unit, rounded so that it gives a window"]
    choice: Annotated[int | None, "Row of the choice that then serves most"]
    values: Annotated[Values, "Its values; empty without one"]
    pretension: Annotated[float | None, "Its pretension", AS_READ]
    printed_pretension: Annotated[
        str,
        "The pretension, rounded so that it lies in the window; empty without one",
        "N",
    ]
    served: Annotated[
        float | None,
        "Share of persons or draws that it serves, without a choice the largest at the farthest "
        "value; null without both",
    ]
    served_verified: Annotated[
        VerifiedRecord | None,
        "Judgement of a fresh sample; null without one",
    ]


@dataclass(kw_only=True)
class SexRecord(Record):
    """Share served among men or among women."""

    sex: Annotated[Literal["male", "female"], "Sex"]
    persons: Annotated[int, "Number of persons"]
    served: Annotated[float, "Share that the pretension serves"]
    interval_95: Annotated[Interval, "95 % interval of the share"]


@dataclass(kw_only=True)
class ShareCurve(Record):
    """Share served over pretension."""

    pretension: Annotated[list[float], "Ends of windows, ascending, each twice", AS_READ]
    share: Annotated[list[float], "Share at that end, then between it and the next"]
    low: Annotated[list[float], "Lower ends of the 95 % intervals"]
    high: Annotated[list[float], "Upper ends"]


@dataclass(kw_only=True)
class BodyRecord(Record):
    """Difference of a dimension of the body between those not served and everyone."""

    theirs: Annotated[float, "Mean of those not served", "SI"]
    of_all: Annotated[float, "Mean of all", "SI"]
    deviations: Annotated[float, "Difference of the means in standard deviations"]


@dataclass(kw_only=True)
class ReasonRecord(Record):
    """A reason why the pretension does not serve some."""

    text: Annotated[str, "The reason in words"]
    needs: Annotated[str, 'Need of those not served: "more", "less" or "another suit"']
    limits: Annotated[list[str], "The limit that is not kept, or both that conflict"]
    conditions: Annotated[
        list[int],
        "For each limit the row of the condition under which it binds for most of them",
    ]
    under: Annotated[list[Values], "Values of these conditions"]
    count: Annotated[int, "Number of persons, draws or pairs"]
    share: Annotated[float, "Share of all"]
    interval_95: Annotated[Interval, "95 % interval of the share"]
    first: Annotated[list[str], "Names of the persons, the farthest from being served first"]
    bodies: Annotated[dict[str, BodyRecord], "Dimensions by name, the largest difference first"]


@dataclass(kw_only=True)
class SuitRecord(Record):
    """One suit of several sizes."""

    value: Annotated[Value, "Value on the axis of the sizes"]
    pretension: Annotated[float, "Its pretension", AS_READ]


@dataclass(kw_only=True)
class SizeRecord(Record):
    """The best few suits along an axis of choices."""

    choices: Annotated[list[SuitRecord], "The suits"]
    served: Annotated[float, "Share of the persons whom at least one of these suits serves"]
    interval_95: Annotated[Interval, "95 % interval of the share"]
    persons: Annotated[int, "Number of persons for whom the suits are chosen"]
    values_tried: Annotated[int, "Number of values of the axis that are tried"]
    all_values: Annotated[bool, "True if these are all values"]


@dataclass(kw_only=True)
class IndexRecord(Record):
    """Sobol indices of one uncertain input."""

    name: Annotated[str, "Name of the input in words"]
    first: Annotated[float, "First-order index: share of the variance that it explains alone"]
    first_standard_error: Annotated[float, "Its standard error"]
    total: Annotated[float, "Total index: share of the variance in which it has a part"]
    total_standard_error: Annotated[float, "Its standard error"]


@dataclass(kw_only=True)
class SobolRecord(Record):
    """Sobol indices of one end of the window."""

    end: Annotated[str, 'Column of the end: "pretension_from" or "pretension_to"']
    standard_deviation: Annotated[float, "Standard deviation of the end", AS_READ]
    inputs: Annotated[dict[str, IndexRecord], "Indices by the key of the input"]


@dataclass(kw_only=True)
class PopulationRecord(Record):
    """The choice named first for persons or draws: whom it serves, and why not the others."""

    choice: Annotated[int, "Row of the choice"]
    values: Annotated[Values, "Its values"]
    kind: Annotated[str, "Noun for what a share counts, in the plural"]
    count: Annotated[int, "Number of persons, draws or pairs"]
    effective_count: Annotated[float, "Effective size of the sample, (Σw)²/Σw²"]
    counts: Annotated[dict[str, int], 'Numbers of persons ("person") and draws ("draw")']
    window: Annotated[Sequence[float | None], "Window of the choice", AS_READ]
    pretension: Annotated[float | None, "Its pretension", AS_READ]
    served: Annotated[float, "Share that the pretension serves"]
    interval_95: Annotated[Interval, "95 % interval of the share"]
    served_verified: Annotated[
        VerifiedRecord | None,
        "Judgement of a fresh sample; null without one. The rest is of the study's own sample, "
        "but for `by` and `curve`, which are of the fresh one if its persons are drawn",
    ]
    largest_share: Annotated[float, "Largest share that one pretension serves"]
    largest_share_at: Annotated[
        float | None,
        "Pretension that serves this share; null if none serves anybody",
        AS_READ,
    ]
    set: Annotated[
        dict[str, list[float]],
        "Range over persons, draws or pairs of both of each tension to set",
        "N",
    ]
    by: Annotated[list[SexRecord], "Shares among men and women, if the study asks for them"]
    curve: Annotated[ShareCurve, "Share over pretension"]
    not_served: Annotated[list[ReasonRecord], "Reasons, the most frequent first"]
    sizes: Annotated[
        dict[str, list[SizeRecord]],
        "For each axis of choices the best suit, the best two, the best three",
    ]
    sobol: Annotated[list[SobolRecord], "Indices of both ends; empty if nothing is drawn"]
    title: Annotated[str, "The choice, its pretension and the share that it serves, in words"]


@dataclass(kw_only=True)
class CutoffCheck(Record):
    """Largest values over designs at the cutoff of a trajectory, and at 0.7 times that."""

    cutoff: Annotated[float, "Cutoff of the study", "Hz"]
    lower: Annotated[float, "Lower cutoff", "Hz"]
    peak_motor_speed: Annotated[
        tuple[float | None, float | None],
        "Largest speed of the motor at the cutoff and at the lower one; null if unknown",
        "rad/s",
    ]
    peak_motor_power: Annotated[
        tuple[float | None, float | None],
        "Largest power of the motor at both",
        "W",
    ]
    decides: Annotated[
        bool,
        "True if either changes by over 10 %: then it is the cutoff that decides it",
    ]


@dataclass(kw_only=True)
class ChecksRecord(Record):
    """Checks of what an answer rests on."""

    cutoff: Annotated[
        CutoffCheck,
        "Check of the cutoff of the trajectory's low-pass, for the choice named first at its "
        "pretension; without a window for the choice nearest to one",
    ]


@dataclass(kw_only=True)
class FreshRecord(Record):
    """The fresh sample that judges the choices that an answer names."""

    count: Annotated[int, "Number of members"]
    persons: Annotated[
        int,
        "Number of persons of a file, for all of whom there are draws; 0 without a file",
    ]
    kind: Annotated[
        Literal["persons", "draws"],
        "Noun for the members: persons are drawn, too, or draws alone",
    ]


@dataclass(kw_only=True)
class TradeOffRecord(Record):
    """Best choice with each value of a limit on which the choices differ."""

    key: Annotated[
        str,
        "Key of the axis that sets the limit: `limits.` and its name, or the name of a table",
    ]
    column: Annotated[str, "Column of `choices.parquet` of that axis"]
    values: Annotated[list[Value], "Values of the axis, or its names, in their order", "SI"]
    best: Annotated[
        list[ChoiceRecord | None],
        "For each the choice of the grid that would be named first; null if none has a window",
    ]


@dataclass(kw_only=True)
class AnswerResults(Record):
    """Answer without the facts of the run."""

    question: Annotated[QuestionRecord, "The question"]
    choices: Annotated[int, "Number of choices"]
    conditions: Annotated[int, "Number of conditions"]
    feasible: Annotated[int, "Number of choices that have a window"]
    trade_offs: Annotated[
        list[TradeOffRecord],
        "Best choice with each value of each limit on which the choices differ",
    ]
    serve: Annotated[float, "Share that a window must serve"]
    verified_by: Annotated[
        FreshRecord | None,
        "Fresh sample that judges the named choices; null without persons and draws, or if the "
        "study wants none",
    ]
    goals: Annotated[list[GoalRecord], "Goals of the study; empty if it leaves them open"]
    best: Annotated[
        ChoiceRecord | None,
        "The best choice; with several goals the best compromise; null if none has a window",
    ]
    best_by: Annotated[
        dict[str, ChoiceRecord],
        "Best choice by each usual goal's column, if the study names no goals",
    ]
    decided: Annotated[
        DecisionRecord | None,
        "Rule by which the best choice is named first; null without one",
    ]
    given_up: Annotated[
        float | None,
        "Largest share of the range of any goal that the best compromise gives up",
    ]
    window_for_all: Annotated[
        Sequence[float | None] | None,
        "Window that serves all, if fewer are enough and there is one",
        AS_READ,
    ]
    front: Annotated[
        list[ChoiceRecord],
        "Choices that no other beats in every goal, in the order of the first goal",
    ]
    setting: Annotated[
        SettingRecord | None,
        "Posture in which the best choice is set; null without one",
    ]
    drift: Annotated[
        DriftRecord | None,
        "Drift beyond the upper end; null if stability does not set it",
    ]
    parts_needed: Annotated[
        PartsRecord | None,
        "Parts that the choice named first needs; null if no choice has a window",
    ]
    sensitivities: Annotated[
        list[SensitivityRecord],
        "Motion of the ends of the best choice's window, the largest per 1 % first",
    ]
    assumed: Annotated[
        list[AssumedRecord],
        "Numbers that deviate, drawn or taken as exact, and what is taken as given, such as rigid "
        "cuffs; the one that moves an end most first",
    ]
    listed: Annotated[
        list[ListedRecord],
        "Pretensions that the study lists, judged with the choice named first",
    ]
    of_paper: Annotated[
        list[str],
        "Keys of the arm's numbers that the study does not state, so that they are the paper's",
    ]
    checks: Annotated[ChecksRecord | None, "There if a trajectory gives the motion"] = None
    between_samples: Annotated[
        BetweenSamples | None,
        "Proof of the windows; null if no choice has one",
    ]
    proved: Annotated[list[ChoiceRecord], "Choices that the study names to be proved"]
    conflicts: Annotated[
        list[ConflictRecord],
        "Reasons why choices have no window, the most frequent first",
    ]
    fixes: Annotated[
        list[FixRecord],
        "Changes that would give a window if no choice has one, the least change first",
    ]
    would_take: Annotated[
        list[RelaxationRecord],
        "Relaxations that would give a window if no choice has one",
    ]
    notes: Annotated[list[str], "Sentences on what is left out, and why"]
    population: Annotated[
        PopulationRecord | None,
        "The choice named first for persons or draws; null without them",
    ]


@dataclass(kw_only=True)
class AnswerRecord(AnswerResults):
    """The record in `design.json`: the answer, and what tells whose it is."""

    name: Annotated[str, "Name of the study"]
    title: Annotated[str, "Its title"]
    verb: Annotated[str, "Command that wrote the record"]
    study: Annotated[dict[str, Any], "Content of the study"]
    study_hash: Annotated[str, "SHA-256 of the study"]
    blocks: Annotated[list[dict[str, Any]], "The answer in words, with its tables"]
    text: Annotated[str, "The same as text"]

    @classmethod
    def has_more(cls) -> bool:
        """Return True: the engine adds the facts of its run."""
        return True


def population_of(record: AnswerResults) -> PopulationRecord:
    """Return the part of a record on persons or draws.

    Raises:
        ValueError: The answer has neither.
    """
    population: PopulationRecord | None = record.population
    if population is None:
        raise ValueError("an answer without persons and draws has no record of them")
    return population


def named_first(record: AnswerResults) -> ChoiceRecord | None:
    """Return the choice that an answer names first; None if it names none.

    It is the best choice. If no choice has a window, it is the one that comes nearest to one.
    """
    if record.best is not None:
        return record.best
    if record.conflicts:
        return record.conflicts[0].nearest
    return None


def value_of(row: Values | ChoiceRecord | FixRecord, column: str) -> Any:
    """Return the value of a choice in a column that is known by its name alone, such as an axis."""
    if isinstance(row, ChoiceRecord) and column in row.columns:
        return row.columns[column]
    return row[column] if isinstance(row, dict) else getattr(row, column)


def as_answer(record: Mapping[str, Any]) -> AnswerRecord:
    """Return the record of an answer, as read from `design.json`, by its types.

    Raises:
        ValueError: An entry is missing, or of another type.
    """
    return AnswerRecord.from_json(record)


AnyResults = TypeVar("AnyResults", bound=AnswerResults)
"""Record of an answer, with or without the facts of the run."""


def holds(record: AnswerResults) -> bool:
    """Return True if the choice named first may be built and worn as the answer says.

    It has a window, no fresh sample refutes it, and the suit can be set within it.
    """
    can_be_set = record.decided is None or record.decided.can_be_set
    return record.best is not None and record.best.feasible and can_be_set


# --- As it is read --------------------------------------------------------------------------------


def as_read(record: AnyResults) -> AnyResults:
    """Return a record whose choices, too, have pretensions as the gauge of the answer shows them.

    Whatever is said of an answer is said of this.
    """
    if not record.question.shows_own_f0:
        return record
    return replace(
        record,
        question=replace(record.question, shows_own_f0=False),
        best=None if record.best is None else row_as_read(record.best),
        best_by={column: row_as_read(row) for column, row in record.best_by.items()},
        front=[row_as_read(row) for row in record.front],
        proved=[row_as_read(row) for row in record.proved],
        trade_offs=[
            replace(
                trade_off,
                best=[None if row is None else row_as_read(row) for row in trade_off.best],
            )
            for trade_off in record.trade_offs
        ],
        conflicts=[
            replace(conflict, nearest=row_as_read(conflict.nearest))
            for conflict in record.conflicts
        ],
    )


def row_as_read(row: ChoiceRecord) -> ChoiceRecord:
    """Return a choice whose pretensions are readings of a gauge in the flexor at the joint."""
    return replace(
        row,
        pretension=row.set_flexor_tension,
        pretension_from=row.set_flexor_tension_from,
        pretension_to=row.set_flexor_tension_to,
    )
