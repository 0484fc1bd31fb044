"""What is to be said of numbers that a study may well state, and most likely does not mean."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from tendon_cli.quantities import PLAUSIBLE
from tendon_cli.studies.fields import Single
from tendon_cli.studies.values import Values

_SHARE_TO_TELL = 1e-3


def remarks(numbers: Iterable[tuple[str, Single, Values]]) -> Iterator[str]:
    """A sentence for each number that is far from any arm, or whose distribution reaches where it is impossible."""
    for key, number, values in numbers:
        low, high = PLAUSIBLE.get(number.name, (number.low, number.high))
        unit = f" {number.quantity.unit}".removesuffix(" 1")
        for value in dict.fromkeys(values.extremes):
            if not low <= value <= high and not math.isinf(value):
                yield f"{key} = {value:g} is {value:g}{unit}, far from any arm ({low:g} to {high:g}{unit})"
                break
        known = values.uncertain
        if known is not None and known.cut_share > _SHARE_TO_TELL:
            span = f"{known.low:g} to {known.high:g}{unit}"
            yield f"{key} can only be {span}: {known.cut_share:.1%} of its distribution is cut off"
