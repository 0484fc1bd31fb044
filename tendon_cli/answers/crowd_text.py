"""What is told of a crowd: as text of 80 columns, and as `design.json` has it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tendon_cli.answers import shares
from tendon_cli.answers.crowd import AxisSizes, Crowd
from tendon_cli.answers.doubt import BODY, Indices
from tendon_cli.answers.factors import Factor
from tendon_cli.answers.left_out import LESS, MORE, NEITHER, Difference, Reason
from tendon_cli.answers.record import finite
from tendon_cli.answers.words import broken, of_key, of_row, rounded, shown
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.study import keys
from tendon_cli.units import counted

_MOST_NAMED = 3
_DIFFERENT = 0.5
"""Standard deviations from which on those left out are said to differ."""
_NEEDS = {MORE: "would need more", LESS: "would need less", NEITHER: "no pretension would do"}
_HOW_MANY = ("one suit", "two suits", "three suits")


def lines_of(crowd: Crowd) -> Iterator[tuple[str, str]]:
    """Paragraphs with the indent of each."""
    everyone = counted(len(crowd.windows.low), crowd.kind[:-1])
    yield "", ""
    yield "For whom" if crowd.people is not None else "How sure", ""
    what = of_row(crowd.problem.choices, {name: values[0] for name, values in crowd.chosen.columns.items()})
    which = f"{what}: " if what else ""
    if not crowd.best_share > 0.0:
        yield f"{which}no pretension serves anyone of {everyone}", "  "
    else:
        error = f" +/- {_percent(crowd.error)}" if len(crowd.windows.low) > 1 else ""
        share = f"{_percent(crowd.share)}{error} of {everyone}"
        yield f"{which}{rounded(crowd.pretension, 4)} N serves {share}{_best(crowd)}", "  "
    for reason in crowd.reasons:
        yield _left_out(crowd, reason), "  "
    yield from _sizes(crowd)
    yield from _indices(crowd)


def _best(crowd: Crowd) -> str:
    if crowd.best_share - crowd.share < 1e-9:
        return ""
    return f"; at {rounded(crowd.curve.best, 4)} N it would be {_percent(crowd.best_share)}"


def _left_out(crowd: Crowd, reason: Reason) -> str:
    start = f"{_percent(reason.share)} {_NEEDS[reason.needs]}: {why(crowd, reason)}"
    if crowd.people is None:
        return start
    differing = [each for each in reason.differences if abs(each.deviations) >= _DIFFERENT][:2]
    said = [f"{each.dimension.replace('_', ' ')} {_compared(each)}" for each in differing]
    names = [crowd.people.names[at] for at in reason.members[:_MOST_NAMED].tolist()]
    more = ", ..." if len(reason.members) > len(names) else ""
    return f"{start}; {'; '.join([*said, ', '.join(names) + more])}"


def why(crowd: Crowd, reason: Reason) -> str:
    """What happens to those left out, under which condition."""
    limits = crowd.problem.study.limits
    return " and ".join(
        f"{broken(limit, limits)}{_condition(crowd, condition)}"
        for limit, condition in zip(reason.limits, reason.conditions, strict=False)
    )


def _compared(each: Difference) -> str:
    quantity = QUANTITIES[each.dimension]
    return f"{shown(quantity, each.theirs)} against {shown(quantity, each.of_all)}"


def _condition(crowd: Crowd, condition: int) -> str:
    """The condition that binds, without the person that it is of."""
    columns = crowd.problem.conditions.columns(np.array([condition]))
    words = [
        factor.names[int(columns[factor.column][0])] if factor.names else of_key(factor.key, columns[factor.column][0])
        for factor in crowd.problem.conditions.factors[1:]
    ]
    return f" ({', '.join(words)})" if words else ""


def _sizes(crowd: Crowd) -> Iterator[tuple[str, str]]:
    for each in crowd.sizes if len(crowd.windows.low) > 1 else ():
        few = f", by the first {each.persons} persons" if each.persons < len(crowd.windows.low) else ""
        thin = f", among {len(each.values)} of its values" if each.thinned else ""
        factor = next(factor for factor in crowd.problem.choices.factors if factor.column == each.column)
        yield "", ""
        yield f"Sizes of {factor.key}{few}{thin}", ""
        for count, found in enumerate(each.found):
            if count and found == each.found[count - 1]:
                yield "more suits serve nobody more", "  "
                break
            suits = ", ".join(
                f"{_value(factor, each.values[choice])} at {rounded(at, 4)} N"
                for choice, at in zip(found.choices, found.pretensions, strict=True)
            )
            error = float(shares.standard_error(found.share, np.ones(each.persons)))
            yield f"{_HOW_MANY[count]:<11} {_percent(found.share)} +/- {_percent(error)}: {suits or 'none'}", "  "


def _value(factor: Factor, value: float | str) -> str:
    return value if isinstance(value, str) else of_key(factor.key, value)


def _indices(crowd: Crowd) -> Iterator[tuple[str, str]]:
    if not crowd.indices:
        return
    yield "", ""
    yield "What the doubt in the window comes from (Sobol index alone, total)", ""
    for each in crowd.indices:
        end = "lower" if each.end == "pretension_from" else "upper"
        said = [
            f"{name_of(name)} {_index(each.first[at], each.first_error[at])}, "
            f"{_index(each.total[at], each.total_error[at])}"
            for at, name in sorted(enumerate(each.inputs), key=lambda pair: -each.total[pair[0]])
        ]
        yield f"{end} end, {rounded(each.deviation, 2)} N of standard deviation: {'; '.join(said)}", "  "
    if BODY in crowd.indices[0].inputs:
        yield "the dimensions of a body are correlated, so that they are one input", "  "


def name_of(key: str) -> str:
    """An input of the indices, as people call it."""
    if key not in keys():
        return key
    side = next((f" of the {word}" for word in ("flexor", "extensor") if f".{word}." in key), "")
    return f"{keys()[key].number.quantity.name.replace('_', ' ')}{side}"


def _index(share: float, error: float) -> str:
    return f"{rounded(100.0 * max(share, 0.0), 2)} +/- {rounded(100.0 * error, 1)} %"


def _percent(share: float) -> str:
    """A share in percent with a decimal."""
    return f"{100.0 * share:.1f} %"


# --- For a program ---------------------------------------------------------------------------------------------------


def record_of_crowd(crowd: Crowd) -> dict[str, Any]:
    """The same for a program, SI; `choice` is a row of choices.parquet, members are numbers of persons or draws."""
    row = int(crowd.chosen.row[0])
    return {
        "choice": row if row >= 0 else None,
        "kind": crowd.kind,
        "count": len(crowd.windows.low),
        "effective_count": shares.effective_count(crowd.problem.weighting),
        "pretension": finite(crowd.pretension),
        "served": crowd.share,
        "standard_error": crowd.error,
        "interval_95": [float(end) for end in shares.interval(crowd.share, crowd.problem.weighting)],
        "largest_share": crowd.best_share,
        "left_out": [_reason(crowd, reason) for reason in crowd.reasons],
        "sizes": {each.column: [_size(each, found) for found in each.found] for each in crowd.sizes},
        "sobol": [_sobol(each) for each in crowd.indices],
    }


def _reason(crowd: Crowd, reason: Reason) -> dict[str, Any]:
    names = [crowd.people.names[at] for at in reason.members[:100].tolist()] if crowd.people is not None else []
    return {
        "needs": {MORE: "more", LESS: "less", NEITHER: "another suit"}[reason.needs],
        "limits": list(reason.limits),
        "conditions": list(reason.conditions),
        "count": len(reason.members),
        "share": reason.share,
        "standard_error": float(shares.standard_error(reason.share, crowd.problem.weighting)),
        "first": names,
        "bodies": {each.dimension: {"theirs": each.theirs, "of_all": each.of_all} for each in reason.differences},
    }


def _size(each: AxisSizes, found: Any) -> dict[str, Any]:
    return {
        "suits": [
            {"value": each.values[choice], "pretension": at}
            for choice, at in zip(found.choices, found.pretensions, strict=True)
        ],
        "served": found.share,
        "standard_error": float(shares.standard_error(found.share, np.ones(each.persons))),
        "persons": each.persons,
        "values_tried": len(each.values),
    }


def _sobol(each: Indices) -> dict[str, Any]:
    rows = zip(
        each.inputs, each.first.tolist(), each.first_error.tolist(), each.total.tolist(), each.total_error.tolist(),
        strict=True,
    )  # fmt: skip
    names = ("first", "first_standard_error", "total", "total_standard_error")
    inputs = {key: dict(zip(names, numbers, strict=True)) for key, *numbers in rows}
    return {"end": each.end, "standard_deviation": each.deviation, "inputs": inputs}
