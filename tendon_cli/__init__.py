"""tendon: parameter studies of tendon-driven exosuits that move the elbow with one motor and two tendons.

The library's face, usually imported as `import tendon_cli as tendon`; the commands call it, too. Whatever is wrong is
raised as a `TendonError`, whose `exit` is the exit code of the commands. Importing it loads no other module.
"""

# No import but of tendon's own: `python -m tendon_cli` would take it from the working directory.
from tendon_cli.version import __version__

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from os import PathLike
    from pathlib import Path
    from threading import Event
    from typing import Any, TypeAlias

    from numpy.typing import ArrayLike

    from tendon_cli.answers.result import Answer
    from tendon_cli.checks.check import Checked
    from tendon_cli.engine.estimate import Estimate
    from tendon_cli.engine.results import Run
    from tendon_cli.figures.engine import Figure
    from tendon_cli.friction.result import Fit
    from tendon_cli.state_page.page import StatePage
    from tendon_cli.studies.study import Study

    Name: TypeAlias = str | PathLike[str]
    AnyStudy: TypeAlias = Name | Mapping[str, Any] | Study
    Result: TypeAlias = Name | Run | Answer
    Drawn = tuple[list[str], list[str], str | None]

_ERRORS = (
    "FolderError", "InputError", "InterruptError", "MemoryShortError", "OutputError", "SizeError", "StudyError",
    "TendonError", "UsageError", "WorkersLostError",
)  # fmt: skip
__all__ = [  # noqa: PLE0604 - errors are read when they are wanted
    "__version__", "arms", "check", "design", "estimate", "fit_friction", "load_study", "open", "open_run", "plot",
    "report", "state", "states", "study", "sweep", *_ERRORS,
]  # fmt: skip


def __getattr__(name: str) -> "Any":
    """The errors and the arms, read when they are wanted."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return import_module(f"{__name__}.arms") if name == "arms" else getattr(import_module(f"{__name__}.errors"), name)


def load_study(path: "Name", settings: "Iterable[str]" = ()) -> "Study":
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


def study(content: "Mapping[str, Any]") -> "Study":
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


def _study(given: "AnyStudy") -> "Study":
    """A study from whatever stands for one: itself, a dictionary, or the path of its file."""
    from collections.abc import Mapping

    from tendon_cli.studies.study import Study

    if isinstance(given, Study):
        return given
    return study(given) if isinstance(given, Mapping) else load_study(given)


def varied(study: "Study", settings: "Mapping[str, Any]") -> "Study":
    """What `study.vary(**settings)` gives."""
    from tendon_cli.studies.load import varied_study

    return varied_study(study, settings)


def sweep(
    study: "AnyStudy",
    out: "Name | None" = None,
    jobs: int | None = None,
    figures: bool = False,
    *,
    resume: bool = False,
    overwrite: bool = False,
    lock: bool = True,
    scheduler: str | None = None,
    progress: "Callable[[int, int], None]" = lambda _done, _all: None,
    stop: "Event | None" = None,
) -> "Run":
    """Run a study into the folder `out`, or without one in memory.

    The folder is locked until its tables stand written, recorded and verified. At most `jobs` parts are computed at
    once, by default one for each core. `resume` finishes an unfinished run, `overwrite` replaces the one that stands
    there. Ctrl-C ends it cleanly; what was finished is kept. A declared figure that can have nothing to draw is a
    fault before anything is computed, any other that cannot be drawn a warning. Raises TendonError.

    >>> import tendon_cli as tendon
    >>> run = tendon.sweep(tendon.study({"load": {"mass": ["0 kg", "5 kg"]}}))
    >>> run.designs[["load_mass", "required_pretension"]].round(2)
       load_mass  required_pretension
    0        0.0                96.83
    1        5.0               158.57
    >>> run.designs.attrs["units"]["required_pretension"]
    'N'
    """
    from tendon_cli.engine.sweep import sweep as run
    from tendon_cli.studies.checks import without_intervals

    asked, folder = without_intervals(_study(study)), _folder(out, "sweep", figures=figures)
    _check_figures(asked, figures=figures)
    return run(
        asked, folder, jobs=_jobs(jobs), resume=resume, overwrite=overwrite, lock=lock, scheduler=scheduler,
        draw=_draw_run if figures else None, progress=progress, stop=stop,
    )  # fmt: skip


def _folder(out: "Name | None", verb: str, *, figures: bool) -> "Path | None":
    """Where a verb writes to; raises UsageError where figures would have no place."""
    from tendon_cli.errors import UsageError
    from tendon_cli.files import result_path

    if out is None and figures:
        raise UsageError("figures are drawn into a folder", hint=f"name one: {verb}(study, out, figures=True)")
    return None if out is None else result_path(out)


def _jobs(jobs: object) -> int | None:
    """How many parts are computed at once; raises UsageError for what is no count."""
    from tendon_cli.errors import UsageError

    if jobs is not None and (isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1):
        raise UsageError(f"jobs = {jobs!r} is not possible, expected 1 or more, or None for every core")
    return jobs


def _draw_run(study: "Study", folder: "Path", out: "Path", record: "dict[str, Any]") -> "Drawn":
    from tendon_cli.figures.draw import draw_run  # only who draws pays for its import

    drawn = draw_run(study, folder, out)
    no_map = None if study.figure or record["designs"] == 1 else drawn.no_map
    return [file.name for file in drawn.files], list(drawn.warnings), no_map


def design(
    study: "AnyStudy",
    out: "Name | None" = None,
    jobs: int | None = None,
    figures: bool = False,
    *,
    resume: bool = False,
    overwrite: bool = False,
    lock: bool = True,
    scheduler: str | None = None,
    progress: "Callable[[int, int], None]" = lambda _done, _all: None,
    stop: "Event | None" = None,
) -> "Answer":
    """Answer the design question of a study into the folder `out`, or without one in memory.

    All is as with `sweep`: the folder is locked until the answer stands written, recorded and verified, `resume`
    finishes an unfinished one, `overwrite` replaces the one that stands there, and the same question asked again is not
    worked out again. Choices are solved on a Dask `scheduler`, if there is one. Raises TendonError.

    >>> import tendon_cli as tendon
    >>> arm = {"spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}}
    >>> answer = tendon.design(tendon.study({**arm, "load": {"mass": ["0 kg", "10 kg"]}}))
    >>> answer.choices[["pretension_from", "pretension_to", "from_by", "to_by"]].round(1)
       pretension_from  pretension_to         from_by                to_by
    0            122.1          173.9  extensor slack  min_elbow_stiffness
    """
    from tendon_cli.answers.choices import design as answer

    return answer(
        _study(study), _folder(out, "design", figures=figures), jobs=_jobs(jobs), resume=resume, overwrite=overwrite,
        lock=lock, scheduler=scheduler, draw=_draw_answer if figures else None, progress=progress, stop=stop,
    )  # fmt: skip


def _draw_answer(study: "Study", folder: "Path", out: "Path", record: "dict[str, Any]") -> "Drawn":  # noqa: ARG001
    from tendon_cli.figures.answer import draw_answer  # only who draws pays for its import

    return *draw_answer(folder, record, out), None


def open_run(path: "Name") -> "Run":
    """A finished run from its folder; its record and every byte of its tables are verified.

    Raises InputError where there is none or a file of it is damaged, FolderError where it is unfinished.

    >>> import tendon_cli as tendon
    >>> done = tendon.sweep(tendon.load_study("study.toml"), "results/mine")
    >>> run = tendon.open_run("results/mine")
    >>> run.record["designs"], len(run.states)
    (1, 182)
    >>> run.to_xarray()["motor_torque"].dims
    ('direction', 'elbow_angle')
    """
    from tendon_cli.engine.results import open_run as opened
    from tendon_cli.files import result_path

    return opened(result_path(path))


def open(path: "Name") -> "Run | Answer":  # noqa: A001 - as netCDF4, zarr and xarray have it
    """The run of `sweep` or the answer of `design` that stands in a folder, every byte of its tables verified.

    Raises InputError where there is none or a file of it is damaged, FolderError where it is unfinished.

    >>> import tendon_cli as tendon
    >>> done = tendon.design({"load": {"mass": [0, 2]}, "spring": {"stiffness": [3000, 5000]}}, "results/mine")
    >>> tendon.open("results/mine").feasible == done.feasible
    True
    """
    from tendon_cli.answers.result import Answer
    from tendon_cli.engine.results import Run, verified_record
    from tendon_cli.files import result_path

    folder = result_path(path)
    record = verified_record(folder)
    return (Answer if record["verb"] == "design" else Run)(record, folder, up_to_date=True)


def check(
    run: "Result", baseline: "Result | None" = None, *, tolerance: float = 1e-9,
    apart: "Iterable[str]" = (), worst: int = 10,
) -> "Checked":  # fmt: skip
    """Whether every design of a run is within its limits, or with a baseline what changed since that run.

    The result has `holds`, `text` and `record`. `tolerance` is the share of a column's scale by which numbers may
    differ, `apart` are keys in which the studies may differ. Raises InputError, UsageError.

    >>> import tendon_cli as tendon
    >>> tendon.sweep({"limits": {"max_tension": "150 N"}}, "results/mine").designs.max_tension.round().item()
    151.0
    >>> tendon.check("results/mine").holds
    False
    """
    from tendon_cli.checks.check import check as checked
    from tendon_cli.checks.check import compare

    if baseline is None:
        return checked(_folder_of(run), worst=worst)
    return compare(_folder_of(run), _folder_of(baseline), tolerance=tolerance, apart=tuple(apart), worst=worst)


def report(result: "Result", out: "Name | None" = None) -> "Path":
    """Write one HTML page of a run or an answer, with everything in it; returns its path.

    By default it is `report.html` in the folder of the result. Raises InputError, OutputError.

    >>> import tendon_cli as tendon
    >>> tendon.report(tendon.sweep({}, "results/mine"), "page.html")
    PosixPath('page.html')
    """
    from tendon_cli.files import result_path
    from tendon_cli.reports.report import write_report

    return write_report(_folder_of(result), None if out is None else result_path(out))


def _folder_of(result: "Result") -> "Path":
    """The folder in which a result stands; raises UsageError for one in memory."""
    from tendon_cli.errors import UsageError
    from tendon_cli.files import result_path

    folder = getattr(result, "folder", result)
    if folder is None:
        raise UsageError("this result is in memory, expected one in a folder", hint="name one: sweep(study, out)")
    return result_path(folder)


def plot(result: "Any", *what: str, out: "Name | None" = None, **how: "Any") -> "Figure":
    """The picture of a study, a state, a run, an answer or a fit, as a matplotlib figure; also `result.plot(...)`.

    A run takes the columns to draw and the keys of `[[figure]]`, such as `x`, `colour`, `where`, `unit`, `size`; an
    answer "tolerance_map", "window" or "front"; a study its `angles` in rad and a `case`. `out` is a file that it is
    written to, too. Raises UsageError for what cannot be drawn.

    >>> import tendon_cli as tendon
    >>> run = tendon.sweep({"load": {"mass": [0, 5]}})
    >>> figure = run.plot("motor_torque", where="load_mass = 5 kg", out="torque.png")
    >>> len(figure.axes)
    1
    """
    from tendon_cli.files import result_path
    from tendon_cli.pictures import plot as drawn

    return drawn(result, what, None if out is None else result_path(out), **how)


def picture(result: "Any") -> str:
    """The main picture of a result for a notebook, a PNG in base64; empty for what has none."""
    from tendon_cli.pictures import encoded

    return encoded(result)


def record_of(fit: "Fit") -> "dict[str, Any]":
    """What `fit.record` is."""
    from tendon_cli.friction import as_json

    return as_json(fit)


def text_of(result: "Any") -> str:
    """What `result.text` is of a run or a fit."""
    from tendon_cli.engine.results import Run

    if isinstance(result, Run):
        from tendon_cli.summary import run_text

        return run_text(result)
    from tendon_cli.friction import summary_lines

    return summary_lines(result)


def states(design: "AnyStudy", angle: "ArrayLike", flexion: "ArrayLike" = True) -> "dict[str, Any]":
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

    return states_at(_study(design), angle, flexion)


def _check_figures(study: "Study", *, figures: bool) -> None:
    """Raise StudyError for a declared figure that is known beforehand to have nothing to draw."""
    if figures and study.figure:
        from tendon_cli.figures.draw import check_figures_of

        check_figures_of(study)


def estimate(study: "AnyStudy", jobs: int | None = None, figures: bool = False) -> "Estimate":
    """What a sweep would cost, rows exactly, the rest from one part computed in memory; raises SizeError.

    >>> import tendon_cli as tendon
    >>> tendon.estimate(tendon.study({})).rows
    {'designs': 1, 'states': 182}
    """
    from tendon_cli.engine.estimate import estimate as estimated
    from tendon_cli.engine.plan import Plan
    from tendon_cli.engine.threads import available_cores
    from tendon_cli.studies.checks import without_intervals

    asked = without_intervals(_study(study))
    _check_figures(asked, figures=figures)
    return estimated(Plan(asked), _jobs(jobs) or available_cores(), figures=figures)


def state(
    study: "AnyStudy", case: str | None = None, person: str | None = None, draw: int | None = None, *,
    reversal: bool = False, plot: "Name | None" = None,
) -> "StatePage":  # fmt: skip
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
    return state_page(_study(study), case, person, draw, reversal=reversal, plot=target)


def fit_friction(
    path: "Name",
    bend_angle: str | float | None = None,
    *,
    route: "Name | None" = None,
    path_smoothing: str | float | None = None,
    cell_1: str | None = None,
    cell_2: str | None = None,
    motor: str | None = None,
) -> "Fit":
    """The friction coefficient from a CSV of two load cells' readings, with its uncertainty.

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

    return fit_file(
        path_of(path), bend_angle=bend_angle, route=None if route is None else path_of(route),
        path_smoothing=path_smoothing, cell_1=cell_1, cell_2=cell_2, motor=motor,
    )  # fmt: skip
