"""Studies from files, dictionaries and settings, and what one state or one sweep of them is."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from typing import Any

    from numpy.typing import ArrayLike
    from pandas import DataFrame

    from tendon_cli.face import AnyStudy, Name
    from tendon_cli.friction.result import Fit
    from tendon_cli.state_page.page import StatePage
    from tendon_cli.studies.study import Study


def load_study(path: Name, settings: Iterable[str] = ()) -> Study:
    """Read and check a study file (TOML, or YAML by its ending), then apply `KEY=VALUE` settings.

    Raises StudyError with every fault found, InputError for a file that it names and that cannot be trusted.

    >>> import tendon_cli as tendon
    >>> loaded = tendon.load_study("study.toml", ["load.mass=[0.0, 5.0]"])
    >>> loaded.axes
    ('load.mass',)
    """
    from tendon_cli.files import path_of
    from tendon_cli.studies.load import load_study as load

    return load(path_of(path), (settings,) if isinstance(settings, str) else tuple(settings))


def study(content: Mapping[str, Any]) -> Study:
    """A checked study from a dictionary with the keys of a study file; raises as `load_study` does.

    Numbers may be NumPy's, lists may be ranges, arrays or Series, and a `Fit` may be a friction coefficient. Relative
    paths in it are relative to the working directory. `study.vary(**{"load.mass": "3 kg"})` is the same study with
    another value.

    >>> import tendon_cli as tendon
    >>> asked = tendon.study({"tendon": {"pretension": "120 N"}, "load": {"mass": range(0, 6, 5)}})
    >>> asked.tendon.pretension.array, asked.load.mass.array
    (array([120.]), array([0., 5.]))
    >>> asked.vary(**{"load.mass": "3 kg"}).axes
    ()
    """
    from collections.abc import Mapping

    from tendon_cli.errors import Fault, StudyError
    from tendon_cli.studies.load import plain, study_from
    from tendon_cli.units import described

    if not isinstance(content, Mapping):
        raise StudyError([Fault("", f"{described(content)} is not a study, expected a dictionary of its keys")])
    return study_from(plain(content))


def any_study(given: AnyStudy) -> Study:
    """A study from whatever stands for one: itself, a dictionary, or the path of its file."""
    from collections.abc import Mapping

    from tendon_cli.studies.study import Study

    if isinstance(given, Study):
        return given
    return study(given) if isinstance(given, Mapping) else load_study(given)


def varied(study: Study, settings: Mapping[str, Any]) -> Study:
    """What `study.vary(**settings)` gives."""
    from tendon_cli.studies.load import varied_study

    return varied_study(study, settings)


def state(
    study: AnyStudy, case: str | None = None, person: str | None = None, draw: int | None = None, *,
    reversal: bool = False, plot: Name | None = None,
) -> StatePage:  # fmt: skip
    """The first state of a study's first design, or of a case's or a person's, line by line; raises UsageError.

    Uncertain numbers are nominal, or those of a `draw`, counted from 1.

    With `reversal` also what happens where the motion turns back there; `plot` draws the motor, and the turn.

    >>> import tendon_cli as tendon
    >>> page = tendon.state(tendon.study({"motion": {"elbow_angle": "75 deg"}}))
    >>> page.status, round(page.columns["motor_torque"], 4)
    ('taut', 0.3892)
    """
    from tendon_cli.files import result_path
    from tendon_cli.state_page.page import state_page

    target = None if plot is None else result_path(plot)
    return state_page(any_study(study), case, person, draw, reversal=reversal, plot=target)


def states(design: AnyStudy, angle: ArrayLike, flexion: ArrayLike = True) -> dict[str, Any]:
    """The results of a study's states at elbow angles in rad, moving in flexion or extension, as arrays.

    `angle` and `flexion` broadcast against each other. Every result has their shape, after one dimension for each axis
    of the study, and SI units; `status` is text. Raises TendonError.

    >>> import numpy as np
    >>> import tendon_cli as tendon
    >>> found = tendon.states({}, np.radians([0.0, 45.0, 90.0]))
    >>> found["motor_torque"].round(3)
    array([2.59 , 0.392, 0.72 ])
    """
    from tendon_cli.engine.at_angles import states_at

    return states_at(any_study(design), angle, flexion)


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


def count_of_jobs(jobs: object) -> int | None:
    """How many parts are computed at once; raises UsageError for what is no count."""
    from tendon_cli.errors import UsageError

    if jobs is not None and (isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1):
        raise UsageError(f"jobs = {jobs!r} is not possible, expected 1 or more, or None for every core")
    return jobs


def record_of(fit: Fit) -> dict[str, Any]:
    """What `fit.record` is."""
    from tendon_cli.friction import as_json

    return as_json(fit)


def text_of(result: Any) -> str:
    """What `result.text` is of a run or a fit."""
    from tendon_cli.engine.results import Run

    if isinstance(result, Run):
        from tendon_cli.summary import run_text

        return run_text(result)
    from tendon_cli.friction import summary_lines

    return summary_lines(result)
