"""Why an answer names one choice first, and what ties with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tendon_cli import say
from tendon_cli.answers.phrases import carried_words, choice_words, window_of
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.space.axis import limit_of
from tendon_cli.studies.study import keys
from tendon_cli.verbs.answer_record import (
    AnswerResults,
    DecisionRecord,
    GoalRecord,
    QuestionRecord,
    value_of,
)

_KEPT = {
    "built": "can be built",
    "served_enough": "serve enough",
    "can_be_set": "can be set",
    "advised": "keep the advice",
}
"""Words for the choices that a rule before all goals leaves, by the rule."""


# --- The rule -------------------------------------------------------------------------------------


def why_first(record: AnswerResults) -> str:
    """Say by which rule the best choice is named first; empty if there is only one choice."""
    decided = record.decided
    if decided is None or record.choices == 1:
        return ""
    if not decided.can_be_set and decided.rule != "settable":
        return _none_can_be_set(record, decided)
    if len(record.front) == 1:
        return "This choice is the best in every goal."
    if record.given_up is not None:
        return _why_compromise(record, decided, record.given_up)
    question = record.question
    among = f"{_of_choices(decided)}{_left_before(question, decided)}"
    rule = decided.rule
    if rule is None:
        if decided.choices == 1:
            return "This is the only choice with a window."
        tied = say.all_of(_of_choices(decided).removeprefix("the "))
        return f"{tied.capitalize()} with a window tie{_and_breaks(decided)}."
    if rule == "settable":
        return _why_settable(record, decided)
    enough = f"{say.percent(record.serve)}{_of_own_sample(record)}"
    said_of_rule = {
        "built": ("can be built", "can be built"),
        "can_be_set": ("can be set", "can be set"),
        "advised": ("keeps the advice", "keep the advice"),
        "served_enough": (f"serves {enough}", f"serve {enough}"),
    }
    if rule in said_of_rule:
        one, several = said_of_rule[rule]
        if decided.left == 1:
            return f"Only this one of {among} {one}."
        return f"{decided.left:,} of {among} {several} and tie{_and_breaks(decided)}."
    among = f"the {among.removeprefix('the ')}"
    best = record.best
    if rule == "max_tension" and not question.has_goals and best is not None:
        tension = say.quantity("max_tension", value_of(best, "max_tension"))
        return f"The tension of this choice reaches {tension} in motion, the least of {among}."
    return f"This choice {_superlative_of(record, rule)} of {among}."


def _none_can_be_set(record: AnswerResults, decided: DecisionRecord) -> str:
    """Say that no choice can be set, or that there is no other; empty if one can be set.

    One that can be set may be unable to be built or serve too few.
    """
    if {decided.rule, *decided.after} & {"built", "served_enough"}:
        return ""
    if record.feasible == 1:
        return "No other choice has a window."
    if record.feasible == 2:
        return "Neither choice with a window can be set."
    return f"None of the {say.counted(record.feasible, 'choice')} with a window can be set."


def _why_compromise(record: AnswerResults, decided: DecisionRecord, given_up: float) -> str:
    """Say of which choices the front is, what range each goal has on it, and what is given up."""
    kept = [words for rule, words in _KEPT.items() if rule in decided.after]
    of_whom = ""
    if kept and decided.choices is not None:
        among = say.counted(decided.choices, "choice")
        of_whom = f" of the {among} that {say.join_words(kept)}"
    in_order = sorted(record.goals, key=lambda goal: goal.column)
    ranges = [_range_on_front(record, goal) for goal in in_order]
    on_front = ", ".join(words for words in ranges if words)
    on_front = f" ({on_front})" if on_front else ""
    return (
        f"This choice is the best compromise on the Pareto front{of_whom}: it gives up at most"
        f" {say.percent(given_up)} of the range that any goal has on the front{on_front}."
    )


def _range_on_front(record: AnswerResults, goal: GoalRecord) -> str:
    """Say the values of a goal on the front: "price 90 to 154 EUR"; empty if one has no end."""
    question = record.question
    column = goal.column
    values = [value_of(row, column) for row in record.front]
    if any(not isinstance(value, int | float) for value in values):
        return ""
    ends = sorted(values, key=float)
    if column in question.carried:
        low, high = (carried_words(question, end, column) for end in (ends[0], ends[-1]))
    elif column in QUANTITIES:
        low, high = (say.quantity(column, float(end)) for end in (ends[0], ends[-1]))
    else:
        return ""
    unit = high.partition(" ")[2]
    return f"{goal_name(column)} {low.removesuffix(f' {unit}')} to {high}"


def unsettable_words(record: AnswerResults) -> str:
    """Say that the window of the choice named first is narrower than an error of setting.

    Empty if the choice can be set.
    """
    decided = record.decided
    best = record.best
    if decided is None or decided.can_be_set or best is None:
        return ""
    question = record.question
    accuracy = say.tolerance_that_is_enough(question, 1.0 / question.needed)
    window = window_of(best)
    if question.accuracy.tension is not None and window is not None:
        half = f"{say.number(0.5 * (window[1] - window[0]), 2)} {question.unit}"
    else:
        half = say.length_to_spare(best.tolerance_length or 0.0)
    return f"cannot be set: the window is ± {half}, the accuracy of setting ± {accuracy}"


def state_words(record: AnswerResults) -> str:
    """Say which numbers have their default values, to change if a choice cannot be set."""
    decided = record.decided
    if decided is None or decided.can_be_set:
        return ""
    defaults = []
    for key, value in decided.by_default.items():
        number = say.quantity(keys()[key].quantity, value)
        defaults.append(f"{key} (now {number}, its default)")
    return f"Try other values of {say.join_words(defaults)}." if defaults else ""


def _of_own_sample(record: AnswerResults) -> str:
    """Say that a share is one of the study's own sample, if a fresh one judges the choice."""
    if record.verified_by is None:
        return ""
    return f" of the study's own {record.question.counted}"


def _of_choices(decided: DecisionRecord) -> str:
    """Count the choices among which a rule decides: "12 choices", "the choices" if unknown."""
    count = decided.choices
    return "the choices" if count is None else say.counted(count, "choice")


def _left_before(question: QuestionRecord, decided: DecisionRecord) -> str:
    """Say what the choices have in common among which a goal decides."""
    if decided.rule != "max_tension" or question.has_goals:
        return " with a window"
    if not decided.is_settable:
        return " that can be set equally well"
    return f" whose window is at least {say.tolerance_that_is_enough(question, 2.0)} wide"


def _why_settable(record: AnswerResults, decided: DecisionRecord) -> str:
    """Say that the window of a choice is the widest, or alone wide enough to set."""
    question = record.question
    best = record.best
    wide = f"a window at least {say.tolerance_that_is_enough(question, 2.0)} wide"
    if decided.after == ["can_be_set"]:
        # What cannot be set has no such window, either: it is counted, too.
        decided = replace(decided, choices=record.feasible)
    if decided.is_settable:
        if decided.left > 1:
            return (
                f"{decided.left:,} of {_of_choices(decided)} have {wide} and"
                f" tie{_and_breaks(decided)}."
            )
        return f"Only this one of {_of_choices(decided)} has {wide}."
    none = f"None of {_of_choices(decided)}"
    if decided.choices == 2:
        none = "Neither choice"
    words = f"{none} has {wide}"
    if best is None or best.tolerance_length is None:
        return f"{words}."
    length = say.quantity("tolerance_length", 2.0 * best.tolerance_length, 2)
    return f"{words}; this one's is the widest ({length})."


def _superlative_of(record: AnswerResults, column: str) -> str:
    """Say what a choice has by the goal that decides: "has the smallest motor torque"."""
    maximise = any(goal.maximise for goal in record.goals if goal.column == column)
    return f"has the {'largest' if maximise else 'smallest'} {goal_name(column)}"


def goal_name(column: str) -> str:
    """Say the name of a column without its extreme: "tension" of "max tension"."""
    if column == "tolerance_length":
        return "tolerance"
    return say.column(column).removeprefix("max ").removeprefix("min ").removeprefix("peak ")


def ties_words(record: AnswerResults) -> Iterator[str]:
    """Say which choices tie with the best one, what breaks the tie, and what does not matter."""
    decided = record.decided
    if decided is None:
        return
    question = record.question
    if decided.ties > 1:
        named = [choice_words(question, values) for values in decided.tied]
        more = decided.ties - len(named)
        if more > 0:
            named.append(f"{more:,} more")
        breaks = _breaks(decided)
        yield f"{decided.ties:,} choices tie: {_listed(named)}{f'; {breaks}' if breaks else ''}"
    symbols = [axis_words(key) for key in decided.no_effect]
    if symbols:
        do = "does" if len(symbols) == 1 else "do"
        it = "it" if len(symbols) == 1 else "them"
        yield f"{say.join_words(symbols)} {do} not matter here: no window depends on {it}"


def _listed(choices: list[str]) -> str:
    """List choices, whose own values may be parted by commas."""
    if any(", " in words for words in choices):
        return "; ".join(choices)
    return say.join_words(choices)


def _and_breaks(decided: DecisionRecord) -> str:
    """Say what breaks a tie, behind the words for it; empty if nothing does."""
    breaks = _breaks(decided)
    return f": {breaks}" if breaks else ""


def _breaks(decided: DecisionRecord) -> str:
    """Say what breaks a tie: "the least motor torque decides, then the smaller R_f"."""
    words = []
    for key in decided.broken_by:
        if key == "peak_motor_torque":
            words.append("the least motor torque decides")
        elif words:
            words.append(f"then the smaller {symbol_of_axis(key)}")
        else:
            words.append(f"the smaller {symbol_of_axis(key)} decides")
    return ", ".join(words)


def axis_words(key: str) -> str:
    """Say the number of an axis as `symbol_of_axis` does, a limit with its article."""
    symbol = symbol_of_axis(key)
    return f"the {symbol}" if limit_of(key) else symbol


def symbol_of_axis(key: str) -> str:
    """Say the number of an axis by its symbol, a limit in words, a named axis by its name."""
    limit = limit_of(key)
    if limit is not None:
        return limit_phrases.limit_on(limit)
    return keys()[key].quantity.symbol if key in keys() else key
