"""Notes on what a question leaves out, and on what a proof holds for."""

from __future__ import annotations

from collections.abc import Mapping

from tendon_cli import say
from tendon_cli.answers.phrases import members
from tendon_cli.engine.windows.question import Question
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.space.axis import PRETENSION, split_side
from tendon_cli.studies.study import keys
from tendon_cli.verbs.answer_record import FreshRecord

PROOF_METHOD = (
    "interval arithmetic with outward rounding on Taylor forms of second order over cells of the"
    " angle and of numbers in a box, in both directions, at both ends of the window and of the"
    " loads"
)


def notes_of(question: Question) -> list[str]:
    """Return notes on numbers left out, on intervals, on people and on numbers not drawn."""
    study = question.study
    sampled_intervals = question.sampled_intervals
    whole_intervals = question.whole_intervals
    pretensions = [key for key in study.numbers if split_side(key)[0] == PRETENSION]
    tables = [
        "study's cases" if table.is_of_cases else f"table {table.key}"
        for table in study.row_tables
        if PRETENSION in [split_side(key)[0] for key in table.keys]
    ]
    stated = study.uncertainty
    draws_nothing = (
        stated is not None and stated.asks_for_draws and stated.draws and not study.to_draw
    )
    of_people = []
    if study.people is not None and not study.people.is_from_file:
        of_people = [(True, note) for note in study.people.population.notes]
    notes = [
        (
            any(split_side(key)[1] for key in pretensions),
            (
                "the study's pretensions per side are not used: the answer is one pretension for"
                " both sides"
            ),
        ),
        *(
            (
                True,
                (
                    f"the pretensions of the {whose} are not used: the answer computes what to set;"
                    " `tendon sweep` judges suits at the pretensions stated"
                ),
            )
            for whose in tables
        ),
        (
            sampled_intervals,
            (
                f"{', '.join(sampled_intervals)}: "
                f"{limit_phrases.proved_word(limit_phrases.SAMPLED)} at both ends of the"
                f" interval, {limit_phrases.proved_word(limit_phrases.OPEN)} between them"
            ),
        ),
        (
            whole_intervals,
            (
                f"{', '.join(whole_intervals)}: the window holds for the whole interval; the worst"
                " values are those at its ends"
            ),
        ),
        (
            "peak_motor_power" in study.limit_names,
            (
                "peak_motor_power: if several intervals of pretension keep this limit, the widest"
                " is used"
            ),
        ),
        (
            study.trajectory is not None,
            (
                "which way tendons slide depends on the pretension: if several intervals of"
                " pretension keep the limits along the motion, the widest is the window"
            ),
        ),
        *of_people,
        (
            study.uncertain and study.drawing is None,
            (
                f"uncertain numbers take their middle value ({', '.join(study.uncertain)}), because"
                " the study has draws = 0 under [uncertainty]"
            ),
        ),
        (draws_nothing, "nothing in this study is uncertain, so [uncertainty] draws nothing"),
    ]
    return [*study.warnings, *(words for holds, words in notes if holds)]


def note_on_motion(choices: int) -> str:
    """Note that most of so many choices have no columns of motion."""
    return (
        f"work, loss, travel and the other columns of the whole motion take too long for all"
        f" {choices:,} choices: they are null but for those that may be the best and for goals"
    )


def note_without_fresh_sample(counted: str, *, is_wanted: bool) -> str:
    """Note that what was chosen is judged by those by whom it was chosen, and why.

    Args:
        counted: Noun for these: "persons", "draws" or "pairs".
        is_wanted: True if the study wants a fresh sample, but draws nothing.
    """
    if is_wanted:
        return f"no fresh sample judges the choice: nothing is drawn for these {counted}"
    return (
        f"the choice is judged by the same {counted} that chose it, so the share is likely to be"
        " too large ([design] verify = 0)"
    )


def note_on_remedies(tried: int, groups: int, counted: str) -> str:
    """Note that what would help is worked out for some of all persons, draws or pairs alone."""
    return (
        f"what would help is computed for {tried:,} of the {groups:,} {counted}: those that bind,"
        " and others picked at random"
    )


def note_on_judges(judging: int, fresh: FreshRecord) -> str:
    """Note that what would help is judged by some of a fresh sample alone."""
    return f"what would help is judged by {judging:,} of the {members(fresh)}"


def scope_words(
    angles: tuple[float, float],
    ranges: Mapping[str, tuple[float, float]],
    times: tuple[float, float] | None = None,
) -> str:
    """Say what a proof holds for: "every angle from 0 to 90 deg and every load from 0 to 10 kg".

    Args:
        angles: First and last elbow angle, rad.
        ranges: Least and largest value of numbers, by their keys, SI.
        times: First and last time that count in a motion in time, s, which has its moments in place
            of angles; None without one.
    """
    words = [_every("angle", "elbow_angle", angles)]
    if times is not None:
        words = [_every("moment", "time", times)]
    for key, values in ranges.items():
        name = keys()[key].quantity.name
        noun = "load" if key == "load.mass" else say.spaced(name)
        words.append(_every(noun, name, values))
    return say.join_words(words)


def _every(noun: str, quantity: str, values: tuple[float, float]) -> str:
    """Say a range of values: "every load from 0 to 10 kg"; of a single one "the load of 5 kg"."""
    low, high = (say.quantity(quantity, value) for value in values)
    if low == high:
        return f"the {noun} of {high}"
    unit = high.partition(" ")[2]
    return f"every {noun} from {low.removesuffix(' ' + unit)} to {high}"
