"""Fit of a suit to its logs: read, check, pick the rows that slide, fit, judge, say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any, TypeAlias

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.fits.given_logs import given_logs
from tendon_cli.fits.one_thread import one_thread
from tendon_cli.fits.suit.fitted_numbers import fitted_numbers
from tendon_cli.fits.suit.log_columns import SPOOL_ANGLE
from tendon_cli.fits.suit.parameters import (
    LOAD,
    inertia_of,
    loads_of,
    numbers_of,
    sensors_of,
)
from tendon_cli.fits.suit.stroke_parts import (
    AGAINST,
    SLACK,
    Parts,
    Selection,
    selected,
    strokes_of,
)
from tendon_cli.fits.suit.suit_checks import check_durations, check_log, check_motion, note_on_load
from tendon_cli.fits.suit.suit_estimate import (
    SuitEstimate,
    channel_misfits,
    fitted,
    predicted_with,
)
from tendon_cli.fits.suit.suit_log import SuitLog, read_logs
from tendon_cli.fits.suit.suit_model import SuitModel
from tendon_cli.fits.suit.suit_remarks import fast_note, gear_note, warnings_of
from tendon_cli.fits.suit.suit_result import SuitFit
from tendon_cli.fits.suit.suit_window import fitted_window, rests_of
from tendon_cli.studies.load import AnyStudy, any_study
from tendon_cli.studies.study import Study, is_exact

LogSource: TypeAlias = str | PathLike[str] | Mapping[str, Any] | Any
_LEAST_LEARNED = 0.1
"""Least share of a prior's variance that a log takes away for it to tell anything."""
_ROUNDS = 3
"""Most rounds in which rows are picked by what was fitted before."""
_MOST_LEFT_OUT = 0.8
"""Share of the parts up to which those are left out for which the model does not vouch."""
_SAME_TURN = 0.2
"""Share by which the way of a turn may change between rounds."""


def estimate_of(study: Study, logs: tuple[SuitLog, ...]) -> tuple[SuitEstimate, Selection]:
    """Return the estimate of a suit's numbers, and the rows that it rests on.

    Raises:
        StudyError: if the study is not about one suit, or nothing is to be fitted.
        InputError: if the logs do not suit the study, or do not tell.
    """
    numbers = numbers_of(study)
    for log in logs:
        check_log(study, log)
    strokes = strokes_of(logs)
    check_durations(logs, strokes)
    has_time = all(log.time is not None for log in logs)
    channels = {
        name: np.concatenate([log.channels[name] for log in logs]) for name in logs[0].channels
    }
    sensors = sensors_of(channels, len(logs), study, has_time=has_time)
    stated = [log.load_mass for log in logs if log.load_mass is not None]
    if stated or is_exact(study, LOAD):
        numbers = [parameter for parameter in numbers if parameter.key != LOAD]
    weighed = []
    if stated and not is_exact(study, LOAD):
        weighed = loads_of(np.unique(np.concatenate(stated)).tolist())
    parameters = [*numbers, *weighed, *sensors]
    if has_time:
        parameters.append(inertia_of(study))
    model = SuitModel(study, parameters)
    middle = np.zeros(len(parameters))
    selection = selected(logs, strokes, 0.0, 1.0)
    check_motion(model, selection.parts, logs)
    model = _with_zeros(model, selection.parts)
    turn = model.turn(middle, selection.parts)
    estimate: SuitEstimate | None = None
    for _ in range(_ROUNDS):
        spool_per_joint = 1.0
        if SPOOL_ANGLE in selection.parts.values:
            spool = selection.parts.values[SPOOL_ANGLE]
            spool_per_joint = abs(np.polyfit(selection.parts.angle, spool, 1)[0])
        selection = selected(logs, strokes, turn, spool_per_joint)
        estimate = fitted(model, selection.parts, estimate)
        is_slack, is_back = model.set_aside(estimate.scores, selection.parts)
        is_left_out = is_slack | is_back
        if is_left_out.any() and np.mean(is_left_out) < _MOST_LEFT_OUT:
            of_back = is_back[~is_slack]
            selection = selection.without(is_slack, SLACK).without(of_back, AGAINST)
            estimate = fitted(model, selection.parts, estimate)
        before = turn
        turn = model.turn(estimate.scores, selection.parts)
        if abs(turn - before) <= _SAME_TURN * max(turn, 1e-3):
            break
    if estimate is None:
        raise ValueError("a fit has one round or more")
    return estimate, selection


def _with_zeros(model: SuitModel, parts: Parts) -> SuitModel:
    """Return the model with the zero of the spool's angle of each log near its measured one."""
    if SPOOL_ANGLE not in parts.values:
        return model
    scores = np.zeros((1, len(model.parameters)))
    away = parts.values[SPOOL_ANGLE] - model.predict(scores, parts, (SPOOL_ANGLE,))[0, 0]
    parameters = list(model.parameters)
    for place, parameter in enumerate(parameters):
        if parameter.log is not None:
            middle = np.mean(away[parts.log == parameter.log])
            law = replace(parameter.law, middle=middle)
            parameters[place] = replace(parameter, law=law)
    return SuitModel(model.study, parameters)


@one_thread()
def fit_suit(study: AnyStudy, logs: LogSource | Sequence[LogSource]) -> SuitFit:
    """Fit the numbers of a suit to logs of its own motor and joint.

    What the study gives with +/- or as a range is fitted, with that as its prior; every other
    number of arm, load and sensors has a usual tolerance, unless `[uncertainty] exact` names it.

    Args:
        study: Study of one suit, a dictionary as a study file has it, or the path of its file.
        logs: A CSV or a list of CSVs, DataFrames or mappings of names to arrays. Columns are
            `elbow_angle`, at least one of `spool_angle`, `motor_torque` and tensions such as
            `flexor_tension_proximal`, and optionally `time` and `load_mass`, with units.

    Raises:
        StudyError: if the study is not about one suit, or nothing is to be fitted.
        UsageError: if the study lacks what a column needs.
        InputError: if a log is wrong, or cannot tell anything.

    >>> import tendon_cli as tendon
    >>> fit = tendon.fit_suit("suit.toml", "suit_log.csv")
    >>> round(fit.numbers["sheath.friction"].value, 3)
    0.084
    """
    checked = any_study(study)
    read = read_logs(given_logs(logs), checked.fit)
    on_loads = [note for log in read for note in note_on_load(checked, log)]
    estimate, selection = estimate_of(checked, read)
    numbers = fitted_numbers(estimate)
    if not any(number.is_stated and number.learned >= _LEAST_LEARNED for number in numbers):
        raise InputError(
            "cannot tell: the logs narrow none of the numbers that the study asks for",
            where=read[0].source,
            hint="log the spool's angle and the motor's torque with two or more loads",
        )
    notes = [*on_loads, *(note for log in read for note in log.notes)]
    notes += [*selection.notes, *fast_note(estimate), *gear_note(numbers)]
    window, doubts = fitted_window(estimate, numbers)
    return SuitFit(
        estimate=estimate,
        selection=selection,
        fitted=tuple(numbers),
        channels=channel_misfits(estimate),
        predicted_from=predicted_with(selection.parts)[1],
        window=window,
        doubts=doubts,
        rests_on=rests_of(estimate, numbers),
        warnings=tuple(warnings_of(estimate, selection, numbers)),
        notes=tuple(notes),
    )
