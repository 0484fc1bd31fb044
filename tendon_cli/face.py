"""Public functions that compute, open what was written, and draw any result."""

from __future__ import annotations

import base64
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict, Unpack

from tendon_cli.engine.results import Run, verified_record
from tendon_cli.engine.run import Draw, RunOptions, run_task
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import UsageError
from tendon_cli.files import result_path
from tendon_cli.studies.checks import without_intervals
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.load import AnyStudy, any_study
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableInMemory
from tendon_cli.units import described

if TYPE_CHECKING:
    from tendon_cli.answers.answer import Answer
    from tendon_cli.engine.cost import Estimate
    from tendon_cli.figures.backend import Figure
    from tendon_cli.figures.frame import Page

FileName: TypeAlias = str | PathLike[str]
_MAX_PICTURED_DESIGNS = 10**5
"""Most designs of a run that a notebook draws without being asked."""


class Options(TypedDict, total=False):
    """Further keyword arguments of `sweep` and `design`."""

    resume: bool
    """True to finish an unfinished run, or to make damaged files of a finished one again."""
    overwrite: bool
    """True to replace the run in the folder."""
    lock: bool
    """False for a file system that cannot lock."""
    scheduler: str | None
    """Address of a Dask cluster."""
    progress: Callable[[int, int], None]
    """Function that is called with the numbers of finished and of all parts."""
    stop: Event | None
    """Event that ends the run cleanly when it is set."""


def sweep(
    study: AnyStudy,
    out: FileName | None = None,
    jobs: int | None = None,
    figures: bool = False,
    **options: Unpack[Options],
) -> Run:
    """Run a study into a folder, or in memory.

    The folder is locked until its tables are written, recorded and verified. Ctrl-C, or an event
    `stop` that is set, ends the run cleanly; finished parts are kept.

    Args:
        study: Study, a dictionary as a study file has it, or the path of a study file.
        out: Folder of the run; without one the run is kept in memory.
        jobs: Parts that are computed at once, by default one for each core.
        figures: True to draw the figures. A declared figure that can have nothing to draw is
            an error before anything is computed; any other that cannot be drawn is a warning.
        options: See `Options`.

    Raises:
        TendonError: The study cannot be run, or its tables cannot be written.

    >>> import tendon_cli as tendon
    >>> run = tendon.sweep(tendon.study({"load": {"mass": ["0 kg", "5 kg"]}}))
    >>> run.designs[["load_mass", "required_pretension"]].round(2)
       load_mass  required_pretension
    0        0.0                96.83
    1        5.0               158.57
    >>> run.designs.attrs["units"]["required_pretension"]
    'N'
    """
    draw = _draw_run if figures else None
    folder, how = _settings_of_run("sweep", out, jobs, draw, options)
    return run_task(Sweep, Run, _study_to_sweep(study, figures=figures), folder, how)


def design(
    study: AnyStudy,
    out: FileName | None = None,
    jobs: int | None = None,
    figures: bool = False,
    **options: Unpack[Options],
) -> Answer:
    """Answer the design question of a study into a folder, or in memory.

    Arguments are those of `sweep`. The folder is locked until the answer is written, recorded and
    verified; the same question asked again is not computed again.

    Raises:
        TendonError: The study cannot be answered, or the answer cannot be written.

    >>> import tendon_cli as tendon
    >>> arm = {"spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}}
    >>> answer = tendon.design(tendon.study({**arm, "load": {"mass": ["0 kg", "10 kg"]}}))
    >>> answer.choices[["pretension_from", "pretension_to", "from_by", "to_by"]].round(1)
       pretension_from  pretension_to         from_by                to_by
    0            122.1          173.9  extensor slack  min_elbow_stiffness
    """
    from tendon_cli.answers.answer import Answer
    from tendon_cli.answers.choices import Choices

    draw = _draw_answer if figures else None
    folder, how = _settings_of_run("design", out, jobs, draw, options)
    return run_task(Choices, Answer, any_study(study), folder, how)


def estimate(study: AnyStudy, jobs: int | None = None, figures: bool = False) -> Estimate:
    """Estimate the cost of a sweep: rows exactly, the rest from one part computed in memory.

    Raises:
        SizeError: The study is too large to run.

    >>> import tendon_cli as tendon
    >>> tendon.estimate(tendon.study({})).rows
    {'designs': 1, 'states': 182}
    """
    from tendon_cli.engine.cost import estimate as estimate_cost
    from tendon_cli.engine.plan import Plan
    from tendon_cli.engine.threads import available_cores

    plan = Plan(_study_to_sweep(study, figures=figures))
    return estimate_cost(plan, _checked_jobs(jobs) or available_cores(), figures=figures)


def open(path: FileName) -> Run | Answer:  # noqa: A001 - as netCDF4, zarr and xarray have it
    """Open the run of `sweep` or the answer of `design` in a folder and verify all its tables.

    Raises:
        InputError: There is none, or a file of it is damaged.
        FolderError: It is unfinished.

    >>> import tendon_cli as tendon
    >>> study = {"load": {"mass": [0, 2]}, "spring": {"stiffness": [3000, 5000]}}
    >>> done = tendon.design(study, "results/mine")
    >>> tendon.open("results/mine").feasible == done.feasible
    True
    """
    from tendon_cli.answers.answer import Answer

    folder = result_path(path)
    record = verified_record(folder)
    result = Answer if record["verb"] == "design" else Run
    return result(record, folder, up_to_date=True)


def plot(result: Any, *what: str, out: str | PathLike[str] | None = None, **how: Any) -> Figure:
    """Draw a study, a state, a run, an answer or a fit as a matplotlib figure.

    The same as `result.plot(...)`.

    Args:
        result: Anything that the library gives.
        what: Columns of a run to draw; for an answer "tolerance_map", "window", "front" or
            "between".
        out: File to which the picture is written as well.
        how: For a run the keys of `[[figure]]`, such as `x`, `colour`, `where`, `unit`, `size`; for
            a study its `angles` in rad and a `case`.

    Raises:
        UsageError: This cannot be drawn.

    >>> import tendon_cli as tendon
    >>> run = tendon.sweep({"load": {"mass": [0, 5]}})
    >>> figure = run.plot("motor_torque", where="load_mass = 5 kg", out="torque.png")
    >>> len(figure.axes)
    1
    """
    page = _page(result, what, how)
    if out is not None:
        page.save(result_path(out))
    page.figure._repr_png_ = lambda: _png(page)  # type: ignore[attr-defined]
    return page.figure


def picture(result: Any) -> str:
    """Return the main picture of a result for a notebook, a PNG in base64; empty if it has none."""
    if isinstance(result, Run) and result.record["designs"] > _MAX_PICTURED_DESIGNS:
        return ""
    try:
        return base64.b64encode(_png(_page(result, (), {}))).decode()
    except Exception:  # noqa: BLE001 - the text is shown whatever happens to the picture
        return ""


def _study_to_sweep(given: AnyStudy, *, figures: bool) -> Study:
    """Return the validated study of a sweep.

    Raises:
        StudyError: A declared figure is known beforehand to have nothing to draw.
    """
    study = without_intervals(any_study(given))
    if figures and study.figure:
        from tendon_cli.figures.draw import check_figures_of

        check_figures_of(study)
    return study


def _settings_of_run(
    verb: str, out: FileName | None, jobs: int | None, draw: Draw | None, options: Options
) -> tuple[Path | None, RunOptions]:
    """Return the folder of a run and the settings by which the engine runs it.

    Raises:
        UsageError: Figures are asked for without a folder, or `jobs` is not a count.
    """
    if out is None and draw is not None:
        hint = f"name one: {verb}(study, out, figures=True)"
        raise UsageError("figures are drawn into a folder", hint=hint)
    folder = None if out is None else result_path(out)
    return folder, RunOptions(jobs=_checked_jobs(jobs), draw=draw, **options)


def _checked_jobs(jobs: object) -> int | None:
    """Return the number of jobs. Raise UsageError if it is neither None nor 1 or more."""
    if jobs is None:
        return None
    if isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1:
        problem = f"jobs = {jobs!r} is not possible, expected 1 or more, or None for every core"
        raise UsageError(problem)
    return jobs


def _draw_run(
    study: Study, folder: Path, out: Path, record: dict[str, Any]
) -> tuple[list[str], list[str], str | None]:
    """Draw the figures of a run. Return their names, warnings, and why it has no slack map."""
    from tendon_cli.figures.draw import draw_run  # only who draws pays for its import

    files, warnings, why_no_map = draw_run(study, folder, out)
    expects_map = not study.figure and record["designs"] > 1
    return files, warnings, why_no_map if expects_map else None


def _draw_answer(
    _: Study, folder: Path, out: Path, record: dict[str, Any]
) -> tuple[list[str], list[str], None]:
    """Draw the figures of an answer. Return their names and warnings."""
    from tendon_cli.figures.answer_figures import draw_answer

    files, warnings = draw_answer(folder, record, out)
    return files, warnings, None


def _png(page: Page) -> bytes:
    """Return a figure as a PNG."""
    from tendon_cli.figures.style import house_style, render

    with house_style():
        return render(page.figure, "png")


def _page(result: Any, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw any result. Raise UsageError if it cannot be drawn so."""
    from tendon_cli.answers.answer import Answer  # only who draws pays for these
    from tendon_cli.state_page.page import StatePage

    if isinstance(result, Run):
        return _page_of_run(result, what, how)
    if isinstance(result, Answer):
        return _page_of_answer(result, what, how)
    if what or set(how) - {"angles", "case"}:
        first = [*what, *how][0]
        hint = "plot() of a study takes angles, case"
        raise UsageError(f"{described(first)} cannot be chosen here", hint=hint)
    if isinstance(result, (Study, StatePage)):
        from tendon_cli.figures.arm import arm_page

        study = result if isinstance(result, Study) else result.study
        return arm_page(study, how.get("angles", ()), how.get("case"))
    from tendon_cli.figures.friction import fit_page

    return fit_page(result)


def _page_of_run(run: Run, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw designs as slack maps and states as curves, as `tendon plot` does."""
    from tendon_cli.cube.columns import TableColumns
    from tendon_cli.figures.draw import pages_of, table_of
    from tendon_cli.studies.figures import figure_spec

    if what:
        how = {**how, "quantity": list(what)}
    spec = figure_spec(**how)
    wanted = None  # the first table that has the quantities
    if not spec.named_columns:
        wanted = "states" if run.record["designs"] == 1 else "designs"
    if run.folder is not None:
        return pages_of(table_of(run.folder, spec, wanted), spec)[0]
    names = sorted(run.tables, reverse=True)  # states before designs
    if wanted is not None and wanted in run.tables:
        names = [wanted]
    tables = [TableInMemory(run.tables[name]) for name in names]
    for table in tables:
        if set(spec.named_columns) <= set(TableColumns.of(table.schema).quantities):
            return pages_of(table, spec)[0]
    return pages_of(tables[0], spec)[0]


def _page_of_answer(answer: Answer, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw the named figure of an answer, or the first that it has."""
    from tendon_cli.cube.cube import choices_of
    from tendon_cli.figures.answer_figures import FIGURES, answer_figure

    for name in (*what, *how):
        if name not in FIGURES:
            hint = hint_at_nearest(name, FIGURES) or ", ".join(FIGURES)
            raise UsageError(f"an answer has no figure {described(name)}", hint=hint)
    choices = choices_of(TableInMemory(answer.table("choices")))
    for name in what or FIGURES:
        page = answer_figure(name, choices, answer.record)
        if page is not None:
            return page
    problem = (
        "this answer has no such figure: "
        "a map needs two axes, a front two goals, the others a window"
    )
    raise UsageError(problem)
