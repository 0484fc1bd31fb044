"""The numbers of a study, with what choices and conditions say of them, as the model takes them."""

from __future__ import annotations

import numpy as np

from tendon_cli.answers.factors import REFERENCE, Numbers, scale_of
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Flag, Real
from tendon_cli.space.inputs import design_of
from tendon_cli.studies.checks import PRETENSION
from tendon_cli.studies.study import Study


def model_design(
    study: Study, choices: Numbers, conditions: Numbers, pretension: Real = 0.0, *, paired: bool = False
) -> Design:
    """Designs of shape (choices, conditions, 1, 1), or as much of it as each number varies over.

    Where they are `paired` each choice has the condition of its own place: (choices, 1, 1, 1).

    A condition says more than a choice, a choice more than the study, and what is said of one side more than what is
    said of both; what conditions scale is multiplied last. `pretension` has the shape (choices,).
    """

    def number(key: str, side: str | None) -> Real | Flag:
        if key == PRETENSION:
            return _spread(pretension, choice=True)
        if key == "model.slack":
            return True
        found = _number(study, ((choices, True), (conditions, paired)), key, side)
        return np.asarray(found) > 0.5 if key == REFERENCE else found

    return design_of(number)


def _number(study: Study, layers: tuple[tuple[Numbers, bool], ...], key: str, side: str | None) -> Real:
    """A number by its common key; with `side`, as it is on that side of the arm.

    Each layer says whether its rows are choices; what the last one scales is multiplied at the end.
    """
    table, _, name = key.rpartition(".")
    found: Real = np.nan
    if key == REFERENCE:
        found = float(study.model.reference == "initial")
    for candidate in [key, f"{table}.{side}.{name}"] if side else [key]:
        values = study.numbers.get(candidate)
        if values is not None and not values.is_axis:
            found = values.single
        for layer, choice in layers:
            if candidate in layer:
                found = _over(found, _spread(layer[candidate], choice=choice))
    conditions, along_choices = layers[-1]
    scale = conditions.get(scale_of(key))
    return found if scale is None else found * _spread(scale, choice=along_choices)


def _spread(values: Real, *, choice: bool) -> Real:
    """Values of rows along the first axis of (choices, conditions, 1, 1), or along the second."""
    array = np.asarray(values)
    if array.ndim == 0:
        return array.item() if array.dtype.kind == "f" else array
    return array.reshape((-1, 1, 1, 1) if choice else (1, -1, 1, 1))


def _over(below: Real, above: Real) -> Real:
    """What is said above, and where nothing is, what is said below."""
    silent = np.isnan(above)
    return above if not np.any(silent) else np.where(silent, below, above)
