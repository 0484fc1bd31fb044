"""A comparison in words, from its record alone: blocks for a terminal, a page or Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tendon_cli import say
from tendon_cli.checks.comparison_record import (
    BrokenRecord,
    ComparedResult,
    ComparisonRecord,
    Judgement,
    MarginRecord,
    MoveRecord,
    QuantityRecord,
    UnservedRecord,
)
from tendon_cli.checks.markdown import escaped
from tendon_cli.quantities import AS_READ, QUANTITIES
from tendon_cli.say import Block

_LONGEST_CELL = 20
"""Most characters of a choice that the table of numbers shows; the sentences say longer ones."""
_SIDE_BY_SIDE = 4
"""Most results in one table; further ones stand in a table below."""
_MOST_DIFFERENCES = 20
"""Most differences of the studies that are shown."""
_MOST_NAMED = 3
"""Most persons, draws or designs that are named."""
_DIGITS = 3
"""Significant digits of a number."""
_MOST_DIGITS = 7
"""Most digits of a number that another one would equal with fewer."""
_WINDOW = ("pretension_from", "pretension_to")
"""Quantities that are shown together as a window."""
_NO_WINDOW = "none"
"""Word for a window that is empty."""
_SHARES = ("served", "feasible")
"""Quantities that are shown in percent."""


def comparison_blocks(record: ComparisonRecord) -> list[Block]:
    """Return the whole comparison: what came out, studies, answers, numbers, limits, people."""
    labels = [result["label"] for result in record["results"]]
    blocks = [say.heading(f"{say.join_words(labels[1:])} compared with {labels[0]}")]
    blocks += say.items(verdict_words(record))
    blocks.append(say.heading("How the studies differ"))
    blocks += _differences(record, labels)
    blocks.append(say.heading("What they say"))
    for result in record["results"]:
        blocks.append({"item": f"{result['label']}: {result['sentence']}"})
    blocks.append(say.heading("Numbers"))
    blocks += _numbers(record, labels)
    blocks += _limits(record, labels)
    blocks += _people(record, labels)
    blocks += [{"note": note} for note in record["notes"]]
    return blocks


def comparison_text(record: ComparisonRecord, joint: str) -> str:
    """Return the comparison for a terminal; `joint` is the name of the joint."""
    return say.as_text(comparison_blocks(record), joint)


def comparison_markdown(record: ComparisonRecord, joint: str) -> str:
    """Return the comparison in Markdown, for a comment in a pull request."""
    lines: list[str] = []
    for block in comparison_blocks(record):
        ((kind, content),) = block.items()
        if kind == "table":
            head, *rows = [
                [escaped(say.name_joint(cell, joint)) for cell in row] for row in content
            ]
            lines += [_row(head), _row(["---"] * len(head)), *map(_row, rows)]
            continue
        text = escaped(say.name_joint(content, joint))
        if kind == "heading":
            level = "####" if lines else "###"
            lines += ["", f"{level} {text}", ""]
        elif kind == "item":
            lines.append(f"- {text}")
        elif kind == "command":
            lines += ["", "```", content, "```"]
        else:
            lines += ["", text]
    return "\n".join(lines).strip() + "\n"


def _row(cells: Sequence[str]) -> str:
    """Return a row of a table in Markdown."""
    return f"| {' | '.join(cells)} |"


# --- What came out --------------------------------------------------------------------------------


def verdict_words(record: ComparisonRecord) -> Iterator[str]:
    """Say in what each later result is better or worse than the first."""
    for place, result in enumerate(record["results"][1:], 1):
        by_verdict: dict[str, list[str]] = {"better": [], "worse": [], "no difference": []}
        for quantity in record["quantities"]:
            verdict = quantity["verdicts"][place]
            if verdict is not None and _is_worth_saying(quantity, place, verdict):
                by_verdict[verdict].append(_verdict_item(quantity, place, verdict))
        parts = []
        if by_verdict["better"]:
            parts.append(f"better in {say.join_words(by_verdict['better'])}")
        if by_verdict["worse"]:
            parts.append(f"worse in {say.join_words(by_verdict['worse'])}")
        if by_verdict["no difference"]:
            parts.append(f"no difference in {say.join_words(by_verdict['no difference'])}")
        words = "; ".join(parts) or "no difference that can be judged"
        yield f"{result['label']}: {words}."


_ASPECTS = {
    "tolerance_length": "setting tolerance",
    "served": "share served",
    "feasible": "share of feasible designs",
}
"""Words for a quantity in a sentence, where its label does not suit."""


def _verdict_item(quantity: QuantityRecord, place: int, verdict: Judgement) -> str:
    """Name a quantity in the list of those that are better or worse, with the change of a share."""
    label = quantity["label"].removesuffix(", at least")
    without_extreme = label.removeprefix("largest ").removeprefix("least ")
    words = _ASPECTS.get(quantity["name"], without_extreme)
    interval = quantity["intervals"][place]
    if interval is None or verdict == "no difference":
        return words
    return f"{words} ({_difference_words(interval)})"


def _is_worth_saying(quantity: QuantityRecord, place: int, verdict: Judgement) -> bool:
    """Return True if a verdict belongs into a sentence: equal numbers alone do not."""
    is_judged_by_samples = quantity["intervals"][place] is not None
    is_of_window = quantity["name"] in _ASPECTS
    return verdict != "no difference" or is_judged_by_samples or is_of_window


def _difference_words(interval: Sequence[float]) -> str:
    """Say the interval of the difference of two shares: "by 3.1 to 5.2 percentage points"."""
    low, high = sorted(map(abs, interval))
    return f"by {say.number(100.0 * low, 2)} to {say.number(100.0 * high, 2)} percentage points"


# --- The studies ----------------------------------------------------------------------------------


def _differences(record: ComparisonRecord, labels: Sequence[str]) -> Iterator[Block]:
    """Yield the keys in which the studies differ, with the value of each."""
    differences = record["differences"]
    if not differences:
        yield {"item": "not at all: they are the same study"}
        return
    for columns in _groups(len(labels)):
        rows = [["key", *(labels[column] for column in columns)]]
        for difference in differences[:_MOST_DIFFERENCES]:
            shown = difference["shown"]
            rows.append([difference["key"], *(shown[column] for column in columns)])
        yield say.table(rows)
    left = len(differences) - _MOST_DIFFERENCES
    if left > 0:
        yield {"item": f"and {say.counted(left, 'more key')} (--json lists all)"}


def _groups(count: int) -> Iterator[Sequence[int]]:
    """Yield the results that stand side by side in a table, by their places."""
    for start in range(0, count, _SIDE_BY_SIDE):
        yield range(start, min(start + _SIDE_BY_SIDE, count))


# --- Numbers --------------------------------------------------------------------------------------


def _numbers(record: ComparisonRecord, labels: Sequence[str]) -> Iterator[Block]:
    """Yield the table of all quantities; of two results with a judgement."""
    is_pair = len(labels) == 2
    for columns in _groups(len(labels)):
        heads = [labels[column] for column in columns]
        rows = [["", *heads, f"{labels[1]} is"] if is_pair else ["", *heads]]
        said = [result["choice"] for result in record["results"]]
        if any(said) and all(len(choice or "") <= _LONGEST_CELL for choice in said):
            choices = [record["results"][column]["choice"] or "-" for column in columns]
            rows.append(["choice", *choices, ""] if is_pair else ["choice", *choices])
        if _has_window(record):
            windows = [_window(record, column) for column in columns]
            rows.append(["window", *windows, ""] if is_pair else ["window", *windows])
        for quantity in record["quantities"]:
            if quantity["name"] in _WINDOW:
                continue
            row = [quantity["label"], *(_cell(record, quantity, column) for column in columns)]
            if is_pair:
                row.append(quantity["verdicts"][1] or "")
            rows.append(row)
            if any(quantity["spans"]):
                spans = [_span_words(quantity, column) for column in columns]
                rows.append(["  95 % interval", *spans, ""] if is_pair else ["", *spans])
        yield say.table(rows)
    if not is_pair:
        yield from say.items(_marks(record))


def _marks(record: ComparisonRecord) -> Iterator[str]:
    """Say what the signs in the cells of a table of several results mean."""
    has_mark = any(
        verdict not in (None, "no difference")
        for quantity in record["quantities"]
        for verdict in quantity["verdicts"]
    )
    if has_mark:
        first = record["results"][0]["label"]
        yield f"+ better than {first}, - worse, = no difference"


_SIGNS = {"better": " +", "worse": " -", "no difference": " ="}


def _cell(record: ComparisonRecord, quantity: QuantityRecord, column: int) -> str:
    """Return the value of a quantity of one result, with a sign if there are several."""
    text = value_words(quantity, quantity["values"][column], _digits(quantity))
    if quantity["name"] == "tolerance_length" and quantity["values"][column] is None:
        has_window = _window(record, column) != _NO_WINDOW
        text = "any" if has_window else _NO_WINDOW
    verdict = quantity["verdicts"][column]
    if len(quantity["values"]) > 2 and verdict is not None:
        return text + _SIGNS[verdict]
    return text


def _span_words(quantity: QuantityRecord, column: int) -> str:
    """Say the 95 % interval of a share; "-" if it has none."""
    span = quantity["spans"][column]
    if span is None:
        return "-"
    low, high = span
    return say.interval_text(quantity["values"][column] or 0.0, low, high)


def _digits(quantity: QuantityRecord) -> int:
    """Return as many significant digits as tell values apart that differ."""
    values = {value for value in quantity["values"] if value is not None}
    is_same = all(verdict in (None, "no difference") for verdict in quantity["verdicts"])
    digits = _DIGITS
    while not is_same and digits < _MOST_DIGITS:
        if len({value_words(quantity, value, digits) for value in values}) == len(values):
            break
        digits += 1
    return digits


def value_words(quantity: QuantityRecord, value: float | None, digits: int = _DIGITS) -> str:
    """Say a value of a quantity with its unit."""
    if value is None:
        return "-"
    if quantity["name"] in _SHARES:
        return say.percent(value)
    if quantity["name"] in AS_READ:
        return f"{say.number(value, digits)} {quantity['unit']}"
    text = say.quantity(QUANTITIES[quantity["name"]], value, digits)
    return f"± {text}" if quantity["name"] == "tolerance_length" else text


def _has_window(record: ComparisonRecord) -> bool:
    """Return True if the results are answers, whose windows are shown."""
    return any(quantity["name"] in _WINDOW for quantity in record["quantities"])


def _window(record: ComparisonRecord, column: int) -> str:
    """Say the window of one answer."""
    ends = {
        quantity["name"]: quantity["values"][column]
        for quantity in record["quantities"]
        if quantity["name"] in _WINDOW
    }
    low = ends.get("pretension_from")
    high = ends.get("pretension_to")
    unit = record["results"][column]["unit"]
    if low is None:
        return _NO_WINDOW
    if high is None:
        return f"{say.number(low)} {unit} or more"
    if low > high:
        return _NO_WINDOW
    return say.window_text(low, high, unit=unit)


# --- Limits ---------------------------------------------------------------------------------------


def _limits(record: ComparisonRecord, labels: Sequence[str]) -> Iterator[Block]:
    """Yield which limit binds in each answer, or which limits designs of runs break."""
    binds = [(label, bind) for label, bind in zip(labels, record["binds"], strict=True) if bind]
    if binds:
        yield say.heading("What binds")
        yield from say.items(f"{label}: {'; '.join(bind['words'])}" for label, bind in binds)
    for result, beside in zip(record["results"][1:], record["beside"], strict=True):
        if beside["margins"] is None:
            continue
        yield say.heading(f"Margins and limits of {result['label']}")
        yield from say.items(_margin_words(beside["margins"]))
        first = record["results"][0]
        yield from say.items(_broken_words(broken, first, result) for broken in beside["broken"])


def _margin_words(margins: MarginRecord) -> Iterator[str]:
    """Say how margins moved, with their sign."""
    count = say.counted(margins["designs"], "design")
    if not margins["rose"] and not margins["fell"]:
        yield f"no margin changed in {count}"
        return
    median = ""
    if margins["median"] is not None:
        median = f", median {_signed(margins['median'])}"
    yield (f"margins of {count}: {margins['rose']:,} rose, {margins['fell']:,} fell{median}")
    if margins["largest_rise"] is not None:
        yield f"largest rise: {_signed(margins['largest_rise'])} at {margins['rise_at']}"
    if margins["largest_fall"] is not None:
        yield f"largest fall: {_signed(margins['largest_fall'])} at {margins['fall_at']}"


def _signed(value: float) -> str:
    """Say a change of a margin with its sign."""
    sign = "-" if value < 0.0 else "+"
    return f"{sign}{say.quantity('margin', abs(value))}"


def _broken_words(broken: BrokenRecord, first: ComparedResult, result: ComparedResult) -> str:
    """Say how many designs break a limit, and which newly do."""
    before = f"{say.counted(broken['before'], 'design')} of {first['label']}"
    words = f"{broken['limit']}: {broken['label']} in {before} and {broken['now']:,} of "
    words += result["label"]
    if broken["newly"]:
        words += f"; newly in {broken['newly']:,}: {_listed(broken['first'], broken['newly'])}"
    if broken["no_longer"]:
        words += f"; no longer in {broken['no_longer']:,}"
    return words


def _listed(names: Sequence[str], count: int) -> str:
    """List the first of some names, and say how many more there are."""
    shown = names[:_MOST_NAMED]
    left = count - len(shown)
    return "; ".join(shown) + (f"; and {left:,} more" if left > 0 else "")


# --- Who is gained and lost -----------------------------------------------------------------------


def _people(record: ComparisonRecord, labels: Sequence[str]) -> Iterator[Block]:
    """Yield who is gained and lost by each later result."""
    blocks: list[Block] = []
    for label, beside in zip(labels[1:], record["beside"], strict=True):
        if beside["gained"] is None or beside["lost"] is None:
            continue
        gained = _move_words(beside["gained"], "gained")
        lost = _move_words(beside["lost"], "lost")
        blocks += say.items([f"{label}: {gained}; {lost}"])
        for one in beside["why_gained"]:
            who, _ = _member_words(one, beside["gained"])
            words = f"{label} gains {who}, not served by {labels[0]}: {one['why']}."
            blocks += say.items([words])
        is_shown = False
        for one in beside["why_lost"]:
            blocks += _lost_words(one, beside["lost"], label, is_shown=is_shown)
            is_shown = True
    if blocks:
        yield say.heading("Gained and lost")
        yield from blocks


def _lost_words(
    one: UnservedRecord, lost: MoveRecord, label: str, *, is_shown: bool
) -> Iterator[Block]:
    """Say why one person or draw is lost to a result, and how to look at it.

    Args:
        one: The person or draw.
        lost: All that are lost.
        label: Name of the result.
        is_shown: True if the command for another one has been shown.
    """
    who, it = _member_words(one, lost)
    words = f"{label} loses {who}: {one['why']}."
    if one["command"] is None or is_shown:
        yield from say.items([words])
        return
    yield from say.items([f"{words} To look at {it}:"])
    yield say.command(one["command"])


def _member_words(one: UnservedRecord, move: MoveRecord) -> tuple[str, str]:
    """Return the words for a person or a draw, and the word for it after that."""
    if move["named"]:
        return one["name"], one["name"]
    return f"a new {move['kind'].removesuffix('s')} with {one['name']}", "it"


def _move_words(move: MoveRecord, word: str) -> str:
    """Say how many persons, draws or designs are gained or lost, and the first by name."""
    noun = move["kind"].removesuffix("s")
    text = f"no {noun} of {move['of']:,} {word}"
    if move["count"]:
        text = f"{move['count']:,} of {say.counted(move['of'], noun)} {word}"
    if move["count"] and move["kind"] != "designs":
        text += f" ({say.percent(move['share'])})"
    is_of_own_sample = move["named_of"] != move["of"]
    if not move["count"] or not move["named_of"]:
        return text
    if is_of_own_sample:
        own = f"the study's own {move['named_of']:,}"
        own += f" {move['named_kind']}" * (move["named_kind"] != move["kind"])
        count = f"{move['named']:,}" if move["named"] else "none"
        text += f", {count} of {own}"
    return f"{text}: {_listed(move['names'], move['named'])}" if move["named"] else text
