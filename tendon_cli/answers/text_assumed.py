"""Assumptions of an answer in words: deviations that are drawn or not, cuffs, posture, the arm."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tendon_cli import say
from tendon_cli.studies.space.axis import split_side
from tendon_cli.studies.study import keys
from tendon_cli.verbs.answer_record import (
    AnswerResults,
    AssumedRecord,
    ChoiceRecord,
    QuestionRecord,
)

_MOST_NAMED = 3
"""Most numbers that are named."""
_MOST_PRETENSIONS = 6
"""Most pretensions of a list that are named."""
_LEAST_MOVE = 0.05
"""Change of an end below which it is not said, N."""
_CUFFS = "anchor.stiffness"
_LEAN = "arm.upper_arm_angle"
_DIGITS = 2
"""Digits of a share of the sample that chooses, of some hundreds of draws."""
_NOBODY = 0.005
"""Share that is as good as none."""


def cuffs_words(record: AnswerResults) -> str:
    """Say what cuffs as soft as measured would do, where a study does not say how soft they are."""
    softer = [entry for entry in record.assumed if entry.key == _CUFFS and entry.kind == "given"]
    if not softer:
        return ""
    low, high = (
        say.number(1e-3 * stiffness, 3)
        for stiffness in sorted(entry.other or 0.0 for entry in softer)
    )
    measured = f"with cuffs as soft as measured ({low} to {high} kN/m per tendon)"
    best = max(entry.served_anew or 0.0 for entry in softer)
    as_set = min(entry.served or 0.0 for entry in softer)
    if as_set >= record.serve:
        works = f"this setting still serves at least {say.percent(as_set, _DIGITS)}"
    elif best < _NOBODY:
        works = "no setting works"
    elif best < record.serve:
        works = f"no setting serves more than {say.percent(best, _DIGITS)}"
    else:
        most = max(entry.served or 0.0 for entry in softer)
        works = (
            f"it serves {say.percent(as_set, _DIGITS)} to {say.percent(most, _DIGITS)} as set,"
            f" and another setting up to {say.percent(best, _DIGITS)}"
        )
    return f"This is as if cuffs did not give: {measured} {works}."


def posture_words(record: AnswerResults) -> str:
    """Say whom the setting serves if the upper arm leans otherwise while the suit is worn."""
    leaning = [entry for entry in record.assumed if entry.key == _LEAN and entry.kind == "given"]
    if not leaning:
        return ""
    leaning.sort(key=lambda entry: entry.other or 0.0)
    served = " and ".join(say.percent(entry.served or 0.0, _DIGITS) for entry in leaning)
    values = [entry.other or 0.0 for entry in leaning]
    step = say.quantity("upper_arm_angle", 0.5 * (max(values) - min(values)))
    return f"with the upper arm {step} farther back or forward it serves {served}"


def deviations_words(record: AnswerResults, best: ChoiceRecord | None) -> str:
    """Say which deviations are drawn, or are not, and how far they move the window together.

    "Drawn are usual deviations of R_elb (3 mm), a₁ (5 mm), a₂ (5 mm) and 17 others". In an exact
    suit: "b₁, K and 6 others are taken as exact: their usual errors together move the lower end by
    16 N (the setting is 5.9 N above it)". Empty if nothing moves the window.
    """
    question = record.question
    named = [
        entry
        for entry in record.assumed
        if entry.kind != "given" and _largest(entry) >= _LEAST_MOVE
    ]
    if not named:
        return ""
    exact = [entry for entry in named if entry.kind == "exact"]
    if exact:
        moved = _together(question, exact, best)
        symbols = _listed([_symbol(entry.key) for entry in exact])
        if len(exact) == 1:
            return f"{symbols} is taken as exact: its usual error moves {moved}"
        return f"{symbols} are taken as exact: their usual errors together move {moved}"
    symbols = _listed([f"{_symbol(entry.key)} (± {entry.deviation_words})" for entry in named])
    is_usual = any(entry.from_ == "usual" for entry in named)
    whose = "usual deviations of " if is_usual else ""
    if len(named) == 1:
        return f"{symbols} is drawn; it moves {_together(question, named)}"
    return f"{whose}{symbols} are drawn; together they move {_together(question, named)}"


def errors_reach_setting(record: AnswerResults, best: ChoiceRecord) -> bool:
    """Return True if errors of exact numbers move an end of the window as far as the setting."""
    exact = [entry for entry in record.assumed if entry.kind == "exact"]
    return any(_distance(best, end) < together for end, together in _moved_ends(exact).items())


def listed_words(record: AnswerResults) -> str:
    """Say which of the pretensions that the study lists serves most.

    "Of your 100, 140 and 180 N, 100 N would serve 96 %".
    """
    if not record.listed:
        return ""
    values = [say.number(entry.pretension) for entry in record.listed]
    unit = record.question.unit
    best = max(record.listed, key=lambda entry: entry.served)
    of_these = f"of your {_listed(values, len(values))} {unit}"
    if len(values) > _MOST_PRETENSIONS:
        of_these = f"of your {len(values):,} pretensions"
    if best.served <= 0.0:
        return f"{of_these} none works with this choice"
    one = f"{say.number(best.pretension)} {unit}"
    if best.reading != best.pretension:
        one += f" ({say.number(best.reading, 3)} {unit} in the flexor)"
    serves = "works" if best.served >= 1.0 else f"would serve {say.percent(best.served)}"
    return f"{of_these}, {one} {serves}"


def paper_words(record: AnswerResults) -> str:
    """Say which numbers of the arm are the paper's because the study does not state them."""
    if not record.of_paper:
        return ""
    symbols = [keys()[key].quantity.symbol for key in record.of_paper]
    if len(symbols) > _MOST_NAMED and len(symbols) >= len(_ARM):
        return "the arm is the paper's: the study states none of its numbers"
    return f"{say.join_words(symbols)} {'is' if len(symbols) == 1 else 'are'} the paper's"


_ARM = ("a1", "b1", "a2", "b2", "elbow_radius", "forearm_mass", "forearm_com", "load_distance")


def _listed(words: Sequence[str], most: int = _MOST_NAMED) -> str:
    """List the first few words, and count the others."""
    named = [*words[:most]]
    if len(words) > most:
        named.append(say.counted(len(words) - most, "other"))
    return say.join_words(named)


def _together(
    question: QuestionRecord, named: Sequence[AssumedRecord], best: ChoiceRecord | None = None
) -> str:
    """Say how far all errors together move each end: the root of the sum of squares.

    Args:
        question: The question.
        named: The numbers.
        best: The choice that is set, to say how near the setting is to an end that moves farther.
    """
    ends = []
    for end, together in _moved_ends(named).items():
        if together < _LEAST_MOVE:
            continue
        words = f"the {end} end by {say.number(together, 2)} {question.unit}"
        away = _distance(best, end)
        if away < together:
            side = "above" if end == "lower" else "below"
            words += f" (the setting is {say.number(away, 2)} {question.unit} {side} it)"
        ends.append(words)
    return say.join_words(ends)


def _moved_ends(named: Sequence[AssumedRecord]) -> dict[str, float]:
    """Return how far all errors together move each end of the window, N."""
    lower = [entry.moves_from or 0.0 for entry in named]
    upper = [entry.moves_to or 0.0 for entry in named]
    return {"lower": math.hypot(*lower), "upper": math.hypot(*upper)}


def _distance(best: ChoiceRecord | None, end: str) -> float:
    """Return how far a setting lies within an end of its window, N; infinite if not known."""
    if best is None or best.pretension is None:
        return math.inf
    limit = best.pretension_from if end == "lower" else best.pretension_to
    return math.inf if limit is None else abs(best.pretension - limit)


def _symbol(key: str) -> str:
    """Return the symbol of a number, with its side if it is one side's."""
    symbol = keys()[split_side(key)[0]].quantity.symbol
    side = say.side_of(key)
    return f"{symbol} of the {side}" if side else symbol


def _largest(entry: AssumedRecord) -> float:
    return max(abs(entry.moves_from or 0.0), abs(entry.moves_to or 0.0))
