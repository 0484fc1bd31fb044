"""Keys that a study had in earlier versions, each with what to use instead."""

from __future__ import annotations

from collections.abc import Iterable

_COLUMNS_OF_MOTION = {
    "max_spool_travel": "spool_travel",
    "max_backlash": "max_backlash",
    "max_torque_band": "max_torque_band",
    "max_motor_work_in": "motor_work_in",
    "max_friction_loss": "friction_loss",
    "min_efficiency": "efficiency",
}
"""Columns that limits of a whole motion bounded, by the name of the limit."""
GONE: dict[str, str] = {
    **{
        f"limits.{limit}": "a limit is kept or broken in a state; the column"
        f" `{column}` of designs and choices stays: filter by it, or make it a goal"
        for limit, column in _COLUMNS_OF_MOTION.items()
    },
    "motion.reversal": "leave it out: friction follows the sliding of the tendons, which follows "
    "from the motion and the suit",
    "uncertainty.cross": "leave it out: every person meets every draw if there are fewer persons "
    "than draws; else each has one",
    "table.header": "leave it out: columns stand in their own order",
    "people.completions": "leave it out: what was not measured of a person in `people.file` is "
    "always drawn",
    "people.content": "`people.file` names the file, or is a DataFrame of a program",
    "people.statistics_content": "`people.statistics` names the file",
    "fit.exact": "`uncertainty.exact` takes the same names, for fits and for draws",
}
"""Advice by dotted key; the keys and columns that it names stand in backticks."""
IS_GONE = "is no longer a key"
"""Problem of such a key."""


def instead_of(path: Iterable[str]) -> str | None:
    """Return what to use instead of a key that a study had; None for any other.

    Args:
        path: The key, part by part; places in lists do not count.
    """
    names = [part for part in path if not part.isdecimal()]
    return GONE.get(".".join(names))
