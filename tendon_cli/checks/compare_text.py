"""A comparison in words, from its record alone: blocks for a terminal, a page or Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tendon_cli import say
from tendon_cli.checks.check_text import escaped
from tendon_cli.checks.compared import Compared, Move, Number, Value
from tendon_cli.quantities import AS_READ, QUANTITIES
from tendon_cli.say import Block

_LONGEST_CELL = 20
"""Most characters of a choice that the table of numbers shows; the sentences say longer ones."""
_SIDE_BY_SIDE = 3
"""Most results beside the first in one table; further ones stand in a table below."""
_MOST_DIFFERENCES = 20
"""Most differences of the studies that are shown."""
_MOST_NAMED = 3
"""Most persons, draws or designs that are named."""
_DIGITS = range(3, 18)
"""Significant digits of numbers, of which as many are shown as tell two values apart."""
_WINDOW = ("pretension_from", "pretension_to")
"""Quantities that are shown together as a window."""
_SHARES = ("served", "feasible", "taut", "stable")
"""Quantities that are shown in percent."""


def comparison_blocks(pairs: Sequence[Compared]) -> list[Block]:
    """Return the whole comparison: what came out, studies, answers, numbers, limits, people.

    Args:
        pairs: Each later result beside the first.
    """
    sides = _sides(pairs)
    first, *later = [pair.sides[place].label for pair, place in sides]
    blocks = [say.heading(f"{say.join_words(later)} compared with {first}")]
    blocks += say.items(verdict_words(pairs))
    blocks.append(say.heading("How the studies differ"))
    blocks += _differences(pairs)
    blocks.append(say.heading("What they say"))
    said = [pair.sides[place] for pair, place in sides]
    blocks += say.items(f"{side.label}: {side.sentence}" for side in said)
    blocks.append(say.heading("Numbers"))
    for start in range(0, len(pairs), _SIDE_BY_SIDE):
        blocks.append(_numbers(pairs[start : start + _SIDE_BY_SIDE]))
    if len(pairs) > 1 and any(number.verdict for pair in pairs for number in pair.quantities):
        blocks += say.items([f"+ better than {first}, - worse, = no difference"])
    binds = []
    for pair, place in sides:
        bind = pair.binds[place]
        if bind is not None:
            binds.append(f"{pair.sides[place].label}: {'; '.join(bind.words)}")
    moves = [line for pair in pairs for line in move_words(pair)]
    for title, lines in (("What binds", binds), ("Gained and lost", moves)):
        if lines:
            blocks += [say.heading(title), *say.items(lines)]
    notes = dict.fromkeys(note for pair in pairs for note in pair.notes)
    blocks += [{"note": note} for note in notes]
    return blocks


def _sides(pairs: Sequence[Compared]) -> list[tuple[Compared, int]]:
    """Return all results: each as a pair that has it, and its place there, 0 for the first."""
    return [(pairs[0], 0), *((pair, 1) for pair in pairs)]


def comparison_markdown(blocks: Sequence[Block], joint: str) -> str:
    """Return the blocks of a comparison in Markdown; `joint` is the name of the joint."""
    lines: list[str] = []
    for block in blocks:
        ((kind, content),) = block.items()
        if kind == "table":
            head, *rows = [
                [escaped(say.name_joint(cell, joint)) for cell in row] for row in content
            ]
            lines += [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]
            continue
        text = escaped(say.name_joint(content, joint))
        if kind == "heading":
            level = "####" if lines else "###"
            lines += ["", f"{level} {text}", ""]
        else:
            lines += [f"- {text}"] if kind == "item" else ["", text]
    return "\n".join(lines).strip() + "\n"


# --- What came out --------------------------------------------------------------------------------

_ASPECTS = {
    "tolerance_length": "setting tolerance",
    "served": "share served",
    "feasible": "share of feasible designs",
}
"""Words for a quantity in a sentence, where its label does not suit."""


def verdict_words(pairs: Sequence[Compared]) -> Iterator[str]:
    """Say in what each later result is better or worse than the first."""
    for pair in pairs:
        if pair.is_equal:
            yield f"{pair.b.label}: equal."
            continue
        parts = []
        for verdict, words in (
            ("better", "better in"),
            ("worse", "worse in"),
            ("no difference", "no difference in"),
        ):
            judged = [number for number in pair.quantities if number.verdict == verdict]
            # Equal numbers alone are not worth saying.
            said = [
                _verdict_item(number)
                for number in judged
                if verdict != "no difference" or number.interval or number.name in _ASPECTS
            ]
            if said:
                parts.append(f"{words} {say.join_words(said)}")
        yield f"{pair.b.label}: {'; '.join(parts) or 'no difference that can be judged'}."


def _verdict_item(number: Number) -> str:
    """Name a quantity in the list of those that are better or worse, with the change of a share."""
    label = number.label.removesuffix(", at least")
    without_extreme = label.removeprefix("largest ").removeprefix("least ")
    words = _ASPECTS.get(number.name, without_extreme)
    if number.interval is None or number.verdict == "no difference":
        return words
    low, high = (say.number(100.0 * end, 2) for end in sorted(map(abs, number.interval)))
    return f"{words} (by {low} to {high} percentage points)"


# --- The studies ----------------------------------------------------------------------------------


def _differences(pairs: Sequence[Compared]) -> Iterator[Block]:
    """Yield the keys in which the studies differ, with the value of each."""
    found = [{each.key: each.shown for each in pair.differences} for pair in pairs]
    keys = list(dict.fromkeys(key for of_pair in found for key in of_pair))
    if not keys:
        yield {"item": "not at all: they are the same study"}
        return
    for start in range(0, len(pairs), _SIDE_BY_SIDE):
        beside = range(start, min(start + _SIDE_BY_SIDE, len(pairs)))
        rows = [["key", pairs[0].a.label, *(pairs[place].b.label for place in beside)]]
        for key in keys[:_MOST_DIFFERENCES]:
            first = next(of_pair[key][0] for of_pair in found if key in of_pair)
            later = [found[place][key][1] if key in found[place] else first for place in beside]
            rows.append([key, first, *later])
        yield say.table(rows)
    left = len(keys) - _MOST_DIFFERENCES
    if left > 0:
        yield {"item": f"and {say.counted(left, 'more key')} (--json lists all)"}


# --- Numbers --------------------------------------------------------------------------------------

_SIGNS = {"better": " +", "worse": " -", "no difference": " =", None: ""}


def _numbers(pairs: Sequence[Compared]) -> Block:
    """Return the table of all quantities; of two results with a judgement."""
    is_pair = len(pairs) == 1
    sides = _sides(pairs)
    labels = [pair.sides[place].label for pair, place in sides]
    rows = [["", *labels, *[f"{labels[-1]} is"] * is_pair]]
    shown = [number for pair in pairs for number in pair.quantities if _is_shown(number)]
    for name in dict.fromkeys(number.name for number in shown):
        if name == "pretension_from":
            rows.append(["window", *(_window(*side) for side in sides), *[""] * is_pair])
        if name in _WINDOW:
            continue
        numbers = [pair.number(name) for pair, _ in sides]
        known = [number for number in numbers if number is not None]
        digits = max(digits_of(number) for number in known)
        cells = []
        spans = []
        for (pair, place), number in zip(sides, numbers, strict=True):
            if number is None:
                cells.append("-")
                spans.append("-")
                continue
            value = number.values[place]
            cell = value_words(number, value, digits)
            if name == "tolerance_length" and value is None:
                cell = "none" if _window(pair, place) == "none" else "any"
            cells.append(cell + _SIGNS[number.verdict] * (place and not is_pair))
            span = number.spans[place]
            if span is None or not isinstance(value, float):
                spans.append("-")
            else:
                low, high = span
                spans.append(say.interval_text(value, low, high))
        rows.append([known[0].label, *cells, *[known[0].verdict or ""] * is_pair])
        if any(any(number.spans) for number in known):
            rows.append(["  95 % interval", *spans, *[""] * is_pair])
    return say.table(rows)


def _is_shown(number: Number) -> bool:
    """Return True if the table of numbers has a quantity."""
    if number.name == "choice":
        return all(len(str(value)) <= _LONGEST_CELL for value in number.values)
    if number.table == "choices":
        return number.unit is not None
    return number.table == "designs" and number.verdict is not None


def digits_of(number: Number) -> int:
    """Return as many significant digits as tell both values apart if they differ."""
    if number.a == number.b or number.verdict == "no difference":
        return min(_DIGITS)
    for digits in _DIGITS:
        if value_words(number, number.a, digits) != value_words(number, number.b, digits):
            return digits
    return min(_DIGITS)


def value_words(number: Number, value: Value, digits: int = 3) -> str:
    """Say a value of a quantity with its unit."""
    if value is None or isinstance(value, str):
        return value or "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if number.name in _SHARES:
        return say.percent(value)
    if number.name in AS_READ:
        return f"{say.number(value, digits)} {number.unit}"
    if number.name == "tolerance_length":
        return f"± {say.length_to_spare(value, digits - 1)}"
    return say.quantity(QUANTITIES[number.name], value, digits)


def _window(pair: Compared, place: int) -> str:
    """Say the window of the first answer of a pair, 0, or of the second, 1."""
    numbers = [pair.number(name) for name in _WINDOW]
    low, high = (None if number is None else number.values[place] for number in numbers)
    if not isinstance(low, float):
        return "none"
    high = high if isinstance(high, float) else float("inf")
    return say.window_text(low, high, unit=pair.sides[place].unit)


# --- Who is gained and lost -----------------------------------------------------------------------


def move_words(pair: Compared) -> Iterator[str]:
    """Say who is gained and lost by the second result, and by which limit."""
    if pair.gained is None or pair.lost is None:
        return
    label = pair.b.label
    counts = f"{_count_words(pair.gained, 'gained')}; {_count_words(pair.lost, 'lost')}"
    yield f"{label}: {counts}"
    for move, verb in ((pair.gained, "gains"), (pair.lost, "loses")):
        for one in move.why:
            who = one.name if move.named else f"a new {move.kind.removesuffix('s')} with {one.name}"
            yield f"{label} {verb} {who}: {one.why}"


def _count_words(move: Move, word: str) -> str:
    """Say how many persons, draws or designs are gained or lost, and the first by name."""
    noun = move.kind.removesuffix("s")
    if not move.count:
        return f"no {noun} of {move.of:,} {word}"
    text = f"{move.count:,} of {say.counted(move.of, noun)} {word}"
    if move.kind != "designs":
        text += f" ({say.percent(move.share)})"
    if move.named_of and move.named_of != move.of:
        own = f"the study's own {move.named_of:,}"
        own += f" {move.named_kind}" * (move.named_kind != move.kind)
        text += f", {f'{move.named:,}' if move.named else 'none'} of {own}"
    left = move.named - _MOST_NAMED
    if not move.named:
        return text
    more = f"; and {left:,} more" if left > 0 else ""
    return f"{text}: {'; '.join(move.names[:_MOST_NAMED])}{more}"
