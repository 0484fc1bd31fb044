"""The verbs that compute, and what they have written, opened again."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tendon_cli.face.studies import any_study, count_of_jobs

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path
    from threading import Event
    from typing import Any

    from tendon_cli.answers.result import Answer
    from tendon_cli.checks.check import Checked
    from tendon_cli.engine.estimate import Estimate
    from tendon_cli.engine.results import Run
    from tendon_cli.face import AnyStudy, Drawn, Name, Result
    from tendon_cli.studies.study import Study


def sweep(
    study: AnyStudy,
    out: Name | None = None,
    jobs: int | None = None,
    figures: bool = False,
    *,
    resume: bool = False,
    overwrite: bool = False,
    lock: bool = True,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
    stop: Event | None = None,
) -> Run:
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
    from tendon_cli.engine.results import Run
    from tendon_cli.engine.run import How, carried_out
    from tendon_cli.engine.sweep import Sweep
    from tendon_cli.studies.checks import without_intervals

    asked, folder = without_intervals(any_study(study)), _folder(out, "sweep", figures=figures)
    _check_figures(asked, figures=figures)
    draw = _draw_run if figures else None
    how = How(count_of_jobs(jobs), resume, overwrite, lock, scheduler, draw, progress, stop)
    return carried_out(Sweep, Run, asked, folder, how)


def design(
    study: AnyStudy,
    out: Name | None = None,
    jobs: int | None = None,
    figures: bool = False,
    *,
    resume: bool = False,
    overwrite: bool = False,
    lock: bool = True,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] = lambda _done, _all: None,
    stop: Event | None = None,
) -> Answer:
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
    from tendon_cli.answers.choices import Choices
    from tendon_cli.answers.result import Answer
    from tendon_cli.engine.run import How, carried_out

    asked, folder, draw = any_study(study), _folder(out, "design", figures=figures), _draw_answer if figures else None
    how = How(count_of_jobs(jobs), resume, overwrite, lock, scheduler, draw, progress, stop)
    return carried_out(Choices, Answer, asked, folder, how)


def open_run(path: Name) -> Run:
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


def open(path: Name) -> Run | Answer:  # noqa: A001 - as netCDF4, zarr and xarray have it
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
    run: Result, baseline: Result | None = None, *, tolerance: float = 1e-9,
    apart: Iterable[str] = (), worst: int = 10,
) -> Checked:  # fmt: skip
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


def report(result: Result, out: Name | None = None) -> Path:
    """Write one HTML page of a run or an answer, with everything in it; returns its path.

    By default it is `report.html` in the folder of the result. Raises InputError, OutputError.

    >>> import tendon_cli as tendon
    >>> tendon.report(tendon.sweep({}, "results/mine"), "page.html")
    PosixPath('page.html')
    """
    from tendon_cli.files import result_path
    from tendon_cli.reports.report import write_report

    return write_report(_folder_of(result), None if out is None else result_path(out))


def _folder(out: Name | None, verb: str, *, figures: bool) -> Path | None:
    """Where a verb writes to; raises UsageError where figures would have no place."""
    from tendon_cli.errors import UsageError
    from tendon_cli.files import result_path

    if out is None and figures:
        raise UsageError("figures are drawn into a folder", hint=f"name one: {verb}(study, out, figures=True)")
    return None if out is None else result_path(out)


def _folder_of(result: Result) -> Path:
    """The folder in which a result stands; raises UsageError for one in memory."""
    from tendon_cli.errors import UsageError
    from tendon_cli.files import result_path

    folder = getattr(result, "folder", result)
    if folder is None:
        raise UsageError("this result is in memory, expected one in a folder", hint="name one: sweep(study, out)")
    return result_path(folder)


def _check_figures(study: Study, *, figures: bool) -> None:
    """Raise StudyError for a declared figure that is known beforehand to have nothing to draw."""
    if figures and study.figure:
        from tendon_cli.figures.draw import check_figures_of

        check_figures_of(study)


def _draw_run(study: Study, folder: Path, out: Path, record: dict[str, Any]) -> Drawn:
    from tendon_cli.figures.draw import draw_run  # only who draws pays for its import

    drawn = draw_run(study, folder, out)
    no_map = None if study.figure or record["designs"] == 1 else drawn.no_map
    return [file.name for file in drawn.files], list(drawn.warnings), no_map


def _draw_answer(study: Study, folder: Path, out: Path, record: dict[str, Any]) -> Drawn:
    from tendon_cli.figures.answer import draw_answer  # only who draws pays for its import

    files, warnings = draw_answer(folder, record, out)
    if record["population"] is not None:
        from tendon_cli.answers.population_figures import draw_population
        from tendon_cli.answers.question import question

        files = files + draw_population(question(study), record, folder, out)
    return files, warnings, None


def estimate(study: AnyStudy, jobs: int | None = None, figures: bool = False) -> Estimate:
    """What a sweep would cost, rows exactly, the rest from one part computed in memory; raises SizeError.

    >>> import tendon_cli as tendon
    >>> tendon.estimate(tendon.study({})).rows
    {'designs': 1, 'states': 182}
    """
    from tendon_cli.engine.estimate import estimate as estimated
    from tendon_cli.engine.plan import Plan
    from tendon_cli.engine.threads import available_cores
    from tendon_cli.studies.checks import without_intervals

    asked = without_intervals(any_study(study))
    _check_figures(asked, figures=figures)
    return estimated(Plan(asked), count_of_jobs(jobs) or available_cores(), figures=figures)
