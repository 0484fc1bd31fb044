"""An answer in blocks, from its record: one sentence, then the reasons, then alternatives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerResults,
    ChoiceRecord,
    ConflictRecord,
    FreshRecord,
    GoalRecord,
    QuestionRecord,
    SensitivityRecord,
    VerifiedRecord,
    value_of,
)
from tendon_cli.answers import phrases
from tendon_cli.answers.phrases import (
    COSTS,
    carried_words,
    choice_words,
    costs,
    ends_of,
    pretension_words,
    short_choice_words,
    sums_words,
    window_of,
)
from tendon_cli.answers.text_bench import bench_heading, drift_words, to_set
from tendon_cli.answers.text_exact import exact_words
from tendon_cli.answers.text_order import (
    goal_name,
    state_words,
    ties_words,
    tolerance_millimetres,
    tolerance_percent,
    tolerance_words,
    unsettable_words,
    why_first,
)
from tendon_cli.answers.text_parts import HEADING, but_words, parts_words
from tendon_cli.answers.text_people import population_blocks
from tendon_cli.answers.text_remedies import fixes_table, relaxations_words
from tendon_cli.answers.text_trade_off import trade_off_blocks
from tendon_cli.answers.text_verified import judgement_words
from tendon_cli.space.axis import limit_of
from tendon_cli.studies.axis_words import parameter
from tendon_cli.studies.study import keys

CHANGES = "What relaxing one demand would give, all else equal"
"""Heading of the values that each demand alone would have to take."""
_MOST_ALTERNATIVES = 8
_MOST_FAILING = 3
_MOST_MOVES = 5
_FAR_APART = 0.1
"""Share by which neighbouring points of a grid differ from which on a finer one is suggested."""
_LEAST_MOVE = 1e-3
"""Motion of an end per 1 % of a number below which it is not printed, N."""
_WORST = {
    "max_tension": "a tension of",
    "max_spring_extension": "a spring extension of",
    "peak_motor_torque": "a motor torque of",
    "min_elbow_stiffness": "an elbow stiffness of",
    "max_contact_pressure": "a strap pressure of",
}


def answer_text(record: AnswerResults) -> str:
    """Return the answer in 80 columns, from its record alone."""
    return say.as_text(answer_blocks(record), say.joint_name(record["question"]))


def answer_blocks(record: AnswerResults) -> Iterator[say.Block]:
    """Yield the blocks of the whole answer, with its part on persons or draws, and its notes."""
    if record["best"] is None:
        yield from _no_window(record)
    else:
        yield from _answer(record, record["best"])
    if record["population"] is not None:
        yield from population_blocks(record, record["population"])
    yield from ({"note": note} for note in record["notes"])


def _parts(record: AnswerResults, best: ChoiceRecord) -> Iterator[str]:
    """Yield what the parts of the best choice add up to, and what parts it needs."""
    sums = sums_words(record["question"], best)
    if sums:
        yield sums
    yield from parts_words(record)


def _list(heading: str, texts: Iterable[str]) -> Iterator[say.Block]:
    """Yield a list under its heading; nothing if it is empty."""
    items = [*texts]
    if items:
        yield say.heading(heading)
        yield from say.items(items)


# --- There is a window ----------------------------------------------------------------------------


def _answer(record: AnswerResults, best: ChoiceRecord) -> Iterator[say.Block]:
    """Yield the answer if a choice has a window."""
    question = record["question"]
    first_sentence = f"{_first_sentence(record, best)} {but_words(record)}".rstrip()
    own_sample = ""
    if best["served_verified"] is not None:
        own_sample = f" for {phrases.own_sample(question)}"
    if record["between_samples"] is not None:
        proof = say.proof_sentence(record["between_samples"])
        if own_sample:
            proof = f"The window{own_sample} is {proof[0].lower()}{proof[1:]}"
        first_sentence += f" {proof}"
    decided = say.cutoff_words(record.get("checks"))
    yield say.sentence(f"{first_sentence} {decided}".rstrip())
    yield from _list(f"Why,{own_sample}" if own_sample else "Why", _why(record, best))
    changes = relaxations_words(record, record["would_take"])
    yield from _list(CHANGES, changes)
    if record["fixes"]:
        yield from fixes_table(question, record["fixes"])
    setting = record["setting"]
    if setting is not None:
        yield from _list(bench_heading(question, setting), to_set(record, best, setting))
    yield from _list(HEADING, _parts(record, best))
    yield from _list(
        "What moves the window most, per 1 %", _moves(question, record["sensitivities"])
    )
    exact = exact_words(question, record["taken_as_exact"])
    if exact:
        yield say.sentence(exact)
    yield from _alternatives(record, best)
    yield from trade_off_blocks(record)
    yield from _list("Choices to be proved", (_proved(question, row) for row in record["proved"]))
    if record["choices"] > 1:
        choices = say.counted(record["choices"], "choice")
        with_window = f"{record['feasible']:,} of {choices}"
        if record["feasible"] == record["choices"]:
            with_window = say.all_of(choices).capitalize()
        have = "has" if record["feasible"] == 1 else "have"
        yield say.sentence(f"{with_window} {have} a window.")
    yield from say.items(_in_choices(question, conflict) for conflict in record["conflicts"])


def _first_sentence(record: AnswerResults, best: ChoiceRecord) -> str:
    """Say the best pretension, whom it serves, and the window."""
    question = record["question"]
    unit = question["unit"]
    noun, where = say.setting_words(question["read"])
    low, high = window_of(best) or (np.nan, np.nan)
    choice = choice_words(question, best)
    start = f"{choice}: a {noun}" if choice else f"A {noun}"
    unsettable = unsettable_words(record)
    but = f"But it {unsettable}." if unsettable else ""
    reasons = (but, why_first(record), state_words(record))
    rule = "".join(f" {words}" for words in reasons if words)
    judged = best["served_verified"]
    fresh = record["verified_by"]
    if judged is not None and fresh is not None:
        start = f"{start} of {pretension_words(question, best)}{where}"
        return f"{start} {_judged(record, best, fresh, judged)}.{rule}"
    served = best["served_at"]
    whom = _all_of(question)
    if served is not None and served < 1.0:
        whom = f"{say.percent(served)} of {_everyone(question)}"
    if question["pretension"] is not None:
        pretension = say.number(question["pretension"])
        margins = phrases.margins(question, best)
        return f"{start} of {pretension} {unit}{where} works for {whom}; {margins}.{rule}"
    either_way = f", ± {tolerance_words(best)} about the middle" if np.isfinite(high) else ""
    span = f"anything {_span(low, high, unit)}"
    if record["serve"] >= 1.0 or question["groups"] == 1:
        then = f"works for {whom}; {span} works{either_way}"
    else:
        then = f"serves {whom}; {span} serves at least {say.percent(record['serve'])}{either_way}"
        window_for_all = record["window_for_all"]
        if window_for_all is not None:
            all_low, all_high = ends_of(window_for_all)
            is_same = (all_low, all_high) == (low, high)
            all_span = "all of this" if is_same else f"anything {_span(all_low, all_high, unit)}"
            then += f"; {all_span} serves all of them"
    return f"{start} of {pretension_words(question, best)}{where} {then}.{rule}"


def _judged(
    record: AnswerResults, best: ChoiceRecord, fresh: FreshRecord, judged: VerifiedRecord
) -> str:
    """Say whom the best pretension serves in a fresh sample, and what would serve enough of it."""
    question = record["question"]
    serve = record["serve"]
    share = f"serves {judgement_words(fresh, judged, serve)}"
    enough = _enough(serve)
    if judged["from"] is None:
        noun, _ = say.setting_words(question["read"])
        return f"{share}; no {noun} serves {enough} of them"
    if question["pretension"] is not None:
        window: ChoiceRecord = {
            **best,
            "pretension_from": judged["from"],
            "pretension_to": judged["to"],
        }
        return f"{share}; {phrases.margins(question, window)}, which serves {enough} of them"
    return f"{share}; {window_words(question, judged, serve)}"


def window_words(
    question: QuestionRecord, judged: VerifiedRecord, serve: float, gauge: str = ""
) -> str:
    """Say what serves enough of a fresh sample: "anything from 74 to 277 N serves all of them".

    Args:
        question: The question.
        judged: Judgement of the sample, which has such a window.
        serve: Share that is enough.
        gauge: Words for what is read, behind the window: " of pretension".
    """
    low, high = ends_of([judged["from"], judged["to"]])
    span = f"{_span(low, high, question['unit'])}{gauge}"
    return f"anything {span} serves {_enough(serve)} of them"


def _enough(serve: float) -> str:
    """Say the share that is enough: "all", "at least 95 %"."""
    return "all" if serve >= 1.0 else f"at least {say.percent(serve)}"


def _span(low: float, high: float, unit: str) -> str:
    """Say a window: "from 100 to 120 N"."""
    if np.isfinite(high):
        return f"from {say.number(low)} to {say.number(high)} {unit}"
    return f"from {say.number(low)} {unit} up"


def _everyone(question: QuestionRecord) -> str:
    """Say who or what a share is counted in: "1,000 persons"."""
    return phrases.everyone(question["counts"], question["groups"], question["counted"])


def _all_of(question: QuestionRecord) -> str:
    """Say whom or what a pretension must suit: "all 1,000 persons", "the design"."""
    whom = _everyone(question)
    is_single = question["groups"] == 1
    if _are_countless(question):
        return "all conditions"
    if question["counted"] == "conditions" and is_single:
        return "the design"
    return whom if whom.startswith("this") and is_single else say.all_of(whom)


def _are_countless(question: QuestionRecord) -> bool:
    """Return True if conditions are counted, but all values of an interval are among them."""
    return question["counted"] == "conditions" and bool(question.get("intervals"))


def _superlative(goal: GoalRecord) -> str:
    """Say what is best by a goal: "largest tolerance"."""
    return f"{'largest' if goal['maximise'] else 'smallest'} {goal_name(goal['column'])}"


def _why(record: AnswerResults, best: ChoiceRecord) -> Iterator[str]:
    """Say the limits that bind at both ends, the worst values, and ranges that should be wider."""
    question = record["question"]
    yield phrases.lower_words(question, best)
    yield phrases.upper_words(question, best)
    drift = drift_words(record["drift"])
    if drift:
        yield drift
    worst = []
    for name, words in _WORST.items():
        value = value_of(best, name)
        if value:
            worst.append(f"{words} {say.quantity(name, value)}")
    are = "values are" if len(worst) > 1 else "value is"
    yield f"at {pretension_words(question, best)} the worst {are} {say.join_words(worst)}"
    yield from ties_words(record)
    yield from edges_words(question, best)


def _proved(question: QuestionRecord, row: ChoiceRecord) -> str:
    """Say the window of a choice that was to be proved."""
    result = "no window"
    window = window_of(row)
    if row["feasible"] and window is not None:
        span = say.window_text(*window, unit=question["unit"])
        result = f"{span}, {say.proved_word(row['between_samples'])}"
    return f"{choice_words(question, row) or 'the design'}: {result}"


def edges_words(question: QuestionRecord, best: ChoiceRecord) -> Iterator[str]:
    """Say which ranges have the best choice at their end, or between points that are far apart."""
    between = []
    for axis in question["choices"]:
        if axis["range"] is None or axis["step"] is None:
            continue
        limit = limit_of(axis["key"])
        symbol = keys()[axis["key"]].quantity.symbol
        if limit is not None:
            symbol = f"the {say.limit_on(limit)}"
        value = float(value_of(best, axis["column"]))
        is_inside = True
        for edge, word in zip(axis["range"], ("lower", "upper"), strict=True):
            if abs(value - edge) <= 1e-9 * abs(edge):
                is_inside = False
                at_edge = parameter(axis["key"], value)
                yield f"{symbol} is at the {word} end of its range, {at_edge}: widen the range"
        if is_inside and axis["step"] > _FAR_APART:
            between.append(f"{symbol} (now up to {say.percent(axis['step'])} apart)")
    if between:
        yield f"a finer grid of {say.join_words(between)} may hold a better choice"


def _moves(question: QuestionRecord, moves: Sequence[SensitivityRecord]) -> Iterator[str]:
    """Say which numbers move the ends of the window most."""
    for end, word in (("from", "lower"), ("to", "upper")):
        of_end = [
            move for move in moves if move["end"] == end and abs(move["per_percent"]) >= _LEAST_MOVE
        ]
        if of_end:
            yield f"{word} end: {', '.join(_move(question, move) for move in of_end[:_MOST_MOVES])}"
    if any(not move["steady"] for move in moves):
        yield "* within 1 % another limit or state becomes the one that binds"


def _move(question: QuestionRecord, move: SensitivityRecord) -> str:
    """Say how a number moves an end: "K +1.2 N"."""
    key = move["key"]
    name = say.column(key.rpartition(".")[2])
    if key in keys() and limit_of(key) is None:
        name = keys()[key].quantity.symbol
    return f"{name} {move['per_percent']:+.2g} {question['unit']}{'' if move['steady'] else '*'}"


# --- Other choices --------------------------------------------------------------------------------


def _alternatives(record: AnswerResults, best: ChoiceRecord) -> Iterator[say.Block]:
    """Yield the best by each goal, or the front, as a small table."""
    front = record["front"]
    goals = record["question"]["ranked_by"]
    if front:
        counted = say.counted(len(front), "choice")
        head = f"Pareto front ({counted}; none is as good in all goals and better in one)"
        rows = [("", row) for row in front[:: max(1, len(front) // _MOST_ALTERNATIVES)]]
    else:
        head = "Best by"
        best_by = {goals[0]["column"]: best} if record["goals"] else record["best_by"]
        rows = [] if record["goals"] else [("named first", best)]
        rows += [
            (_superlative(goal), best_by[goal["column"]])
            for goal in goals
            if goal["column"] in best_by
        ]
        if record["choices"] < 2:
            return
    yield say.heading(head)
    yield _table_of_choices(record, rows)


def _table_of_choices(record: AnswerResults, rows: Sequence[tuple[str, ChoiceRecord]]) -> say.Block:
    """Return a table of choices, each with a name, its window, pretension and costs."""
    shows_share = record["serve"] < 1.0
    share_head = ["served"] if shows_share else []
    unit = record["question"]["unit"]
    question = record["question"]
    columns = [goal["column"] for goal in record["goals"]]
    carried = [column for column in columns if column in question.get("carried", {})]
    heads = [say.spaced(column) for column in carried]
    lines = [["", "", *heads, f"window {unit}", "±mm", "±%", unit, *share_head, *COSTS.values()]]
    for name, row in rows:
        low, high = window_of(row) or (np.nan, np.nan)
        upper = "on" if np.isinf(high) else f"to {say.number(high, 3)}"
        share = [say.percent(row["served_at"] or 0.0)] if shows_share else []
        pretension = row["pretension"]
        lines.append(
            [
                name,
                short_choice_words(question, row),
                *(carried_words(question, row, column) for column in carried),
                f"{say.number(low, 3)} {upper}",
                tolerance_millimetres(row),
                tolerance_percent(row),
                "-" if pretension is None else say.number(pretension, 3),
                *share,
                *costs(row),
            ]
        )
    return say.table(lines)


# --- There is no window ---------------------------------------------------------------------------


def _no_window(record: AnswerResults) -> Iterator[say.Block]:
    """Yield the answer if no choice has a window."""
    question = record["question"]
    decided = say.cutoff_words(record.get("checks"))
    yield say.sentence(f"{no_window_words(record)} {decided}".rstrip())
    reasons = (text for conflict in record["conflicts"] for text in _reasons(record, conflict))
    yield from _list("Why", reasons)
    changes = relaxations_words(record, record["would_take"])
    yield from _list(CHANGES, changes)
    if record["fixes"]:
        yield from fixes_table(question, record["fixes"])


def no_window_words(record: AnswerResults) -> str:
    """Say that no choice has a window, or that the given pretension suits none."""
    question = record["question"]
    choices = record["choices"]
    noun, where = say.setting_words(question["read"])
    any_of = "either" if choices == 2 else "any"
    with_any = "" if choices == 1 else f" with {any_of} of the {choices:,} choices"
    whom = _all_of(question)
    if record["serve"] < 1.0:
        whom = f"{say.percent(record['serve'])} of {_everyone(question)}"
    start = f"No {noun}{where} works for"
    if question["pretension"] is not None:
        given = f"{say.number(question['pretension'])} {question['unit']}"
        start = f"A {noun} of {given}{where} does not work for"
    return f"{start} {whom}{with_any}."


def _in_choices(question: QuestionRecord, conflict: ConflictRecord) -> str:
    """Say in how many choices which limits leave no window."""
    choices = say.counted(conflict["choices"], "choice")
    limits = conflict["limits"]
    has_window = window_of(conflict["nearest"]) is not None
    if question["pretension"] is not None and has_window and len(limits) == 1:
        broken = phrases.broken(question, limits[0], *_only_choice(conflict))
        given = f"{say.number(question['pretension'])} {question['unit']}"
        return f"in {choices} {given} does not work: {broken}"
    bounds = phrases.bounds(question, *_only_choice(conflict))
    return f"in {choices} {say.conflict(limits, bounds, question['read'])}"


def _only_choice(conflict: ConflictRecord) -> tuple[ChoiceRecord, ...]:
    """Return the choice of a conflict if it is the only one: its limits are those of the words."""
    return (conflict["nearest"],) if conflict["choices"] == 1 else ()


def _reasons(record: AnswerResults, conflict: ConflictRecord) -> Iterator[str]:
    """Say what leaves some choices without a window, and how far the nearest is from one."""
    question = record["question"]
    if record["choices"] > 1:
        nearest = choice_words(question, conflict["nearest"])
        yield f"{_in_choices(question, conflict)}; closest to a window: {nearest}"
    yield from conflict_words(record, conflict)


def conflict_words(record: AnswerResults, conflict: ConflictRecord) -> Iterator[str]:
    """Say the ends that leave the choice nearest to a window none, and how far they are apart."""
    question = record["question"]
    row = conflict["nearest"]
    given = question["pretension"]
    window = window_of(row)
    if window is None:
        end = phrases.lower_end(row)
        limit = end.limit or conflict["limits"][0]
        broken = phrases.broken(question, limit, row, end.under)
        yield f"at any pretension {broken}{phrases.where(question, end)}"
        return
    low, high = window
    if given is not None and low <= high:
        lower_is_missed = given < low
        missed = phrases.upper_words(question, row)
        if lower_is_missed:
            missed = phrases.lower_words(question, row)
        yield f"{missed}; {phrases.margins(question, row)}"
        return
    yield from phrases.gap_words(question, row, conflict["gap"])
    if row["pretension"] is None:
        return
    pretension = f"{say.number(row['pretension'], 3)} {question['unit']}"
    fails = conflict["fails"]
    if row["served"] and record["serve"] >= 1.0 and record["conditions"] > 1:
        yield f"{pretension} works for {say.percent(row['served'])} of the {question['counted']}"
    elif 0 < len(fails) < record["conditions"] and not _are_countless(question):
        words = [phrases.condition_words(question, values) for values in fails[:_MOST_FAILING]]
        more = [f"{len(fails) - len(words)} more"] if len(fails) > len(words) else []
        of_all = f"{len(fails)} of {record['conditions']} conditions"
        yield f"{pretension} does not work in {of_all}: {'; '.join([*words, *more])}"
