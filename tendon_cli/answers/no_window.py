"""What an answer says where no choice has a window: which limits conflict, and what would fix it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tendon_cli.answers.answer import Findings
from tendon_cli.answers.conflicts import Conflict
from tendon_cli.answers.fixes import Fix
from tendon_cli.answers.sentences import conflict_named, end_said, filled, of_quantity, row_of, where_said
from tendon_cli.answers.words import broken, of_key, of_row, rounded, shown
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.study import keys
from tendon_cli.units import counted


def no_window(found: Findings) -> Iterator[str]:
    """The lines of an answer that no choice is."""
    conditions = len(found.problem.conditions)
    whom = "the design" if conditions == 1 else f"all {conditions} conditions"
    if found.problem.enough < 1.0:
        whom = f"{rounded(100 * found.problem.enough)} % of them"
    choices = found.gathered.choices
    of_what = "" if choices == 1 else f", whichever of {choices:,} choices is taken"
    yield from filled(f"No pretension suits {whom}{of_what}.")
    yield "\nWhy"
    for each in found.conflicts:
        yield from _conflict(found, each)
    if found.fixes:
        yield "\nWhat would fix it, all else equal"
        yield from _fixes(found)


def _conflict(found: Findings, each: Conflict) -> Iterator[str]:
    s = each.nearest.solutions
    what = of_row(found.problem.choices, row_of(each.nearest))
    if found.gathered.choices > 1:
        yield from filled(
            f"{conflict_named(each)} in {counted(each.choices, 'choice')}; nearest to a window: {what}", "  "
        )
    if np.isnan(s.pretension_from[0]):
        limit = LIMIT_NAMES[int(s.from_by[0])]
        said = broken(limit, found.problem.study.limits)
        yield from filled(f"whatever the pretension, {said}{where_said(found, each.nearest, 'from')}", "  ")
    else:
        yield from filled(f"below {end_said(found, each.nearest, 'from')},", "  ")
        yield from filled(f"above {end_said(found, each.nearest, 'to')}: {rounded(each.gap)} N apart", "  ")
        if s.served[0] > 0.0 and found.problem.enough >= 1.0 and len(found.problem.conditions) > 1:
            share = f"{rounded(100 * s.served[0])} % of the conditions"
            yield from filled(f"one pretension, {rounded(s.pretension[0])} N, suits {share}", "  ")
    for limit, value in each.relaxed.items():
        bound = shown(QUANTITIES[limit], value) if value is not None else ""
        yield from filled(f"{limit} {bound} would do" if bound else f"relaxing {limit} does not help", "  ")


def _fixes(found: Findings) -> Iterator[str]:
    helps = [fix for fix in found.fixes if fix.after is not None]
    rows = [_fix(fix) for fix in helps]
    if rows:
        head = ("", "N", "tension", "spring", "torque")
        widths = [max(len(row[at]) for row in (head, *rows)) for at in range(len(head))]
        for row in (head, *rows):
            yield ("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))).rstrip()
    idle = [keys()[fix.knobs[0]].number.quantity.symbol for fix in found.fixes if fix.after is None]
    if idle:
        yield from filled(f"none within its plausible range: {', '.join(idle)}; nor pretension", "  ")


def _fix(fix: Fix) -> tuple[str, ...]:
    changes = [
        f"{of_key(key, before)} to {shown(keys()[key].number.quantity, after)}"
        for key, before, after in zip(fix.knobs, fix.before, fix.after or (), strict=True)
    ]
    costs = fix.costs or {}
    names = ("max_tension", "max_spring_extension", "peak_motor_torque")
    return (" and ".join(changes), rounded(fix.pretension), *(of_quantity(name, costs[name]) for name in names))
