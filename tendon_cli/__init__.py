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
    from typing import Any

    from tendon_cli.answers.run import Answer
    from tendon_cli.engine.estimate import Estimate
    from tendon_cli.engine.results import Run
    from tendon_cli.friction.result import Fit
    from tendon_cli.state_page.page import StatePage
    from tendon_cli.studies.study import Study

    Name = str | PathLike[str]
    Drawn = tuple[list[str], list[str], str | None]

__all__ = ["__version__", "design", "estimate", "fit_friction", "load_study", "open_run", "state", "study", "sweep"]


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

    Relative paths in it are relative to the working directory.

    >>> import tendon_cli as tendon
    >>> asked = tendon.study({"tendon": {"pretension": "120 N"}, "load": {"mass": ["0 kg", "5 kg"]}})
    >>> asked.tendon.pretension.array
    array([120.])
    """
    from tendon_cli.studies.load import study_from

    return study_from(dict(content))


def sweep(
    study: "Study",
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

    folder = _folder(out, "sweep", figures=figures)
    if figures and study.figure:
        from tendon_cli.figures.draw import check_figures_of

        check_figures_of(study)
    return run(
        study, folder, jobs=jobs, resume=resume, overwrite=overwrite, lock=lock, scheduler=scheduler,
        draw=_draw_run if figures else None, progress=progress, stop=stop,
    )  # fmt: skip


def _folder(out: "Name | None", verb: str, *, figures: bool) -> "Path | None":
    """Where a verb writes to; raises UsageError where figures would have no place."""
    from pathlib import Path

    from tendon_cli.errors import UsageError

    if out is None and figures:
        raise UsageError("figures are drawn into a folder", hint=f"name one: {verb}(study, out, figures=True)")
    return None if out is None else Path(out)


def _draw_run(study: "Study", folder: "Path", out: "Path", record: "dict[str, Any]") -> "Drawn":
    from tendon_cli.figures.draw import draw_run  # only who draws pays for its import

    drawn = draw_run(study, folder, out)
    no_map = None if study.figure or record["designs"] == 1 else drawn.no_map
    return [file.name for file in drawn.files], list(drawn.warnings), no_map


def design(
    study: "Study",
    out: "Name | None" = None,
    jobs: int | None = None,
    figures: bool = False,
    *,
    overwrite: bool = False,
    scheduler: str | None = None,
    progress: "Callable[[int, int], None]" = lambda _done, _all: None,
    stop: "Event | None" = None,
) -> "Answer":
    """Answer the design question of a study into the folder `out`, or without one in memory.

    The folder appears whole or not at all. `overwrite` replaces the answer that stands there; the same question asked
    again is not worked out again. Choices are solved on a Dask `scheduler`, if there is one. Raises TendonError.

    >>> import tendon_cli as tendon
    >>> arm = {"spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}}
    >>> answer = tendon.design(tendon.study({**arm, "load": {"mass": ["0 kg", "10 kg"]}}))
    >>> answer.choices[["pretension_from", "pretension_to", "from_by", "to_by"]].round(1)
       pretension_from  pretension_to         from_by                to_by
    0            122.1          173.9  extensor slack  min_elbow_stiffness
    """
    from tendon_cli.answers.run import design as answer

    return answer(
        study, _folder(out, "design", figures=figures), jobs=jobs, overwrite=overwrite, scheduler=scheduler,
        draw=_draw_answer if figures else None, progress=progress, stop=stop,
    )  # fmt: skip


def _draw_answer(folder: "Path", record: "dict[str, Any]") -> "tuple[list[str], list[str]]":
    from tendon_cli.figures.answer.draw import draw_answer  # only who draws pays for its import

    return draw_answer(folder, record)


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


def estimate(study: "Study", jobs: int | None = None, figures: bool = False) -> "Estimate":
    """What a sweep would cost, rows exactly, the rest from one part computed in memory; raises SizeError.

    >>> import tendon_cli as tendon
    >>> tendon.estimate(tendon.study({})).rows
    {'designs': 1, 'states': 182}
    """
    from tendon_cli.engine.estimate import estimate as estimated
    from tendon_cli.engine.plan import Plan
    from tendon_cli.engine.run import available_cores

    return estimated(Plan(study), jobs or available_cores(), figures=figures)


def state(
    study: "Study", case: str | None = None, person: str | None = None, *, reversal: bool = False,
    plot: "Name | None" = None,
) -> "StatePage":  # fmt: skip
    """The first state of a study's first design, or of a case's or a person's, line by line; raises UsageError.

    With `reversal` also what happens where the motion turns back there; `plot` draws the motor, and the turn.

    >>> import tendon_cli as tendon
    >>> page = tendon.state(tendon.study({"motion": {"elbow_angle": "75 deg"}}))
    >>> page.status, round(page.columns["motor_torque"], 4)
    ('taut', 0.3892)
    """
    from pathlib import Path

    from tendon_cli.state_page.page import state_page

    return state_page(study, case, person, reversal=reversal, plot=None if plot is None else Path(plot))


def fit_friction(
    path: "Name",
    bend_angle: str | float | None = None,
    *,
    route: "Name | None" = None,
    path_smoothing: str | float | None = None,
    cell_1: str | None = None,
    cell_2: str | None = None,
    motor: str | None = None,
    offset: bool | None = None,
    delay: bool | None = None,
    robust: bool = False,
) -> "Fit":
    """The friction coefficient from a CSV of two load cells' readings, with its uncertainty.

    `bend_angle` is a text such as "144 deg +/- 2 deg", or a number in rad. Instead, `route` is a CSV of way-points x, y
    and z along the sheath, whose bend angle is found with its uncertainty, and `path_smoothing` their noise, such as
    "0.5 mm". `offset` and `delay` force these effects of the rig into the fit or bar them, None fits them where the
    readings show them. Raises UsageError for what is asked, InputError for the files.

    >>> import tendon_cli as tendon
    >>> fit = tendon.fit_friction("readings.csv", bend_angle="144 deg")
    >>> round(fit.friction, 3)
    0.074
    """
    from pathlib import Path

    from tendon_cli.friction import fit_file

    return fit_file(
        Path(path), bend_angle=bend_angle, route=None if route is None else Path(route), path_smoothing=path_smoothing,
        cell_1=cell_1, cell_2=cell_2, motor=motor, offset=offset, delay=delay, robust=robust,
    )  # fmt: skip
