"""Friction from readings, given as anything that a program has; and results as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from os import PathLike
    from typing import Any, TypeAlias

    from pandas import DataFrame

    from tendon_cli.friction.result import Fit

    Name: TypeAlias = str | PathLike[str]


def fit_friction(
    path: Name | Sequence[Name] | DataFrame | Mapping[str, Any],
    bend_angle: str | float | None = None,
    *,
    route: Name | None = None,
    path_smoothing: str | float | None = None,
    cell_1: str | None = None,
    cell_2: str | None = None,
    motor: str | None = None,
    position: str | None = None,
    zero_motor: str | float | None = None,
    zero_load: str | float | None = None,
    cell_uncertainty: str | None = None,
) -> Fit:
    """The friction coefficient from the readings of two load cells, with its uncertainty.

    `path` is a CSV, a list of CSVs that are one fit, a DataFrame or a mapping of names to arrays. `position` names the
    column of the motor's position or speed, `zero_motor` and `zero_load` are what the cells read without load,
    `cell_uncertainty` is that of a cell's zero and gain, "0.2 N, 0.5 %".

    `bend_angle` is a text such as "144 deg +/- 2 deg", or a number in rad. Instead, `route` is a CSV of way-points x, y
    and z along the sheath, whose bend angle is found with its uncertainty, and `path_smoothing` their noise, such as
    "0.5 mm". Without a bend angle the answer is μφ. Raises UsageError for what is asked, InputError for the files.

    >>> import tendon_cli as tendon
    >>> fit = tendon.fit_friction("readings.csv", bend_angle="144 deg")
    >>> round(fit.friction, 3)
    0.074
    """
    from tendon_cli.files import path_of
    from tendon_cli.friction import fit_file

    given: Any = path
    if isinstance(path, str) or hasattr(path, "__fspath__"):
        given = path_of(path)
    elif isinstance(path, list | tuple):
        given = [path_of(each) for each in path]
    return fit_file(
        given, bend_angle=bend_angle, route=None if route is None else path_of(route), path_smoothing=path_smoothing,
        cell_1=cell_1, cell_2=cell_2, motor=motor, position=position, zero_motor=zero_motor, zero_load=zero_load,
        cell_uncertainty=cell_uncertainty,
    )  # fmt: skip


def text_of(result: Any) -> str:
    """What `result.text` is of a run, which has tables, or a fit; a command loads nothing that draws for it."""
    if hasattr(result, "tables"):
        from tendon_cli.summary import run_text

        return run_text(result)
    from tendon_cli.friction import summary_lines

    return summary_lines(result)
