"""Public functions that compute, open what was written, and draw any result."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from tendon_cli import say
from tendon_cli.engine.results import Result, Run, open_result
from tendon_cli.engine.run import Draw, RunOptions, run_task
from tendon_cli.errors import UsageError
from tendon_cli.files import result_path
from tendon_cli.say.display import Displayed
from tendon_cli.studies.checks import without_intervals
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.figures import WIDTHS
from tendon_cli.studies.load import AnyStudy, any_study
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableInMemory
from tendon_cli.units import described
from tendon_cli.verbs.call_options import check_options
from tendon_cli.verbs.registry import TaskKind, by_name, kinds, load

if TYPE_CHECKING:
    from tendon_cli.answers.answer import Answer
    from tendon_cli.checks.compare import Comparison
    from tendon_cli.engine.cost import Estimate
    from tendon_cli.figures.backend import Figure
    from tendon_cli.figures.frame import Page
    from tendon_cli.fits.friction.fit_result import Fit
    from tendon_cli.fits.suit.suit_result import SuitFit
    from tendon_cli.state_page.page import StatePage

FileName: TypeAlias = str | PathLike[str]


def sweep(
    study: AnyStudy,
    out: FileName | None = None,
    jobs: int | None = None,
    figures: bool = False,
    *,
    resume: bool = False,
    overwrite: bool = False,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    stop: Event | None = None,
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
        resume: True to finish an unfinished run, or to make damaged files of a finished one again.
        overwrite: True to replace the run in the folder.
        scheduler: Address of a Dask cluster.
        progress: Function that is called with the numbers of finished and of all parts.
        stop: Event that ends the run cleanly when it is set.

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
    run = compute(
        "sweep",
        study,
        out,
        jobs,
        figures,
        resume=resume,
        overwrite=overwrite,
        scheduler=scheduler,
        progress=progress,
        stop=stop,
    )
    return cast(Run, run)


def design(
    study: AnyStudy,
    out: FileName | None = None,
    jobs: int | None = None,
    figures: bool = False,
    *,
    resume: bool = False,
    overwrite: bool = False,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
    stop: Event | None = None,
) -> Answer:
    """Answer the design question of a study into a folder, or in memory.

    Arguments are those of `sweep`. The folder is locked until the answer is written, recorded and
    verified; the same question asked again is not computed again.

    Raises:
        TendonError: The study cannot be answered, or the answer cannot be written.

    >>> import tendon_cli as tendon
    >>> arm = {"spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}}
    >>> exact = {"uncertainty": {"usual": False}}
    >>> loads = {"load": {"mass": ["0 kg", "10 kg"]}}
    >>> answer = tendon.design(tendon.study({**arm, **loads, **exact}))
    >>> answer.choices[["pretension_from", "pretension_to", "from_by", "to_by"]].round(1)
       pretension_from  pretension_to         from_by                to_by
    0            122.1          173.9  extensor slack  min_elbow_stiffness
    """
    answer = compute(
        "design",
        study,
        out,
        jobs,
        figures,
        resume=resume,
        overwrite=overwrite,
        scheduler=scheduler,
        progress=progress,
        stop=stop,
    )
    return cast("Answer", answer)


def compute(
    verb: str,
    study: AnyStudy,
    out: FileName | None = None,
    jobs: int | None = None,
    figures: bool = False,
    **options: Any,
) -> Result:
    """Run the task of a verb into a folder, or in memory; `sweep` and `design` call this.

    Arguments are those of `sweep`, and others of `RunOptions`; None is none.

    Raises:
        TendonError: The task cannot be run, or its result cannot be written.
    """
    kind = kinds()[verb]
    if out is None and figures:
        hint = f"name one: {verb}(study, out, figures=True)"
        raise UsageError("figures are drawn into a folder", hint=hint)
    folder = None if out is None else result_path(out)
    draw = _drawer(kind) if figures and kind.draw else None
    given = {name: value for name, value in options.items() if value is not None}
    how = RunOptions(jobs=_checked_jobs(jobs), draw=draw, **given)
    validated = any_study(study)
    if figures:
        _check_figures(kind, validated)
    result: Result = run_task(load(kind.task), load(kind.result), validated, folder, how)
    return result


def size(
    verb: str, study: AnyStudy, folder: Path, jobs: int | None = None, figures: bool = False
) -> tuple[dict[str, Any], str]:
    """Return the size of a task before it is run, as a record and as text.

    Args:
        verb: Verb of the task.
        study: Its study.
        folder: Folder into which it would be written.
        jobs: Parts that are computed at once, by default one for each core.
        figures: True if figures are drawn.

    Raises:
        TendonError: The task cannot be run.
    """
    kind = kinds()[verb]
    validated = any_study(study)
    if figures:
        _check_figures(kind, validated)
    if kind.size:
        record, text = load(kind.size)(validated, folder, _checked_jobs(jobs), figures)
        return record, text
    task = load(kind.task).of(validated)
    rows = {
        table: sum(task.rows(table, index) for index in range(max(1, parts)))
        for table, parts in task.tables.items()
    }
    lines = [f"{validated.name}: nothing is written by --dry-run"]
    lines += [f"  rows         {count:,} in {table}" for table, count in rows.items()]
    return {"name": validated.name, "rows": rows}, "\n".join(lines)


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

    validated = without_intervals(any_study(study))
    if figures:
        _check_figures(kinds()["sweep"], validated)
    at_once = _checked_jobs(jobs) or available_cores()
    return estimate_cost(Plan(validated), at_once, figures=figures)


def open(path: FileName) -> Result:  # noqa: A001 - as netCDF4, zarr and xarray have it
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
    return open_result(result_path(path))


def plot(
    result: Any,
    *what: str,
    out: str | PathLike[str] | None = None,
    overwrite: bool = False,
    **how: Any,
) -> Figure:
    """Draw a study, a state, a run, an answer or a fit as a matplotlib figure.

    The same as `result.plot(...)`.

    Args:
        result: Anything that the library gives.
        what: Columns of a run to draw; for an answer "tolerance_map", "window", "rows", "front" or
            "between".
        out: File to which the picture is written as well.
        overwrite: True to replace a file that tendon did not write.
        how: For a run the keys of `[[figure]]`, such as `x`, `colour`, `where`, `unit`, `size`; for
            a study its `angles` in rad and a `case`.

    Raises:
        UsageError: This cannot be drawn, or tendon did not write the file.

    >>> import tendon_cli as tendon
    >>> run = tendon.sweep({"load": {"mass": [0, 5]}})
    >>> figure = run.plot("motor_torque", where="load_mass = 5 kg", out="torque.png")
    >>> len(figure.axes)
    1
    """
    if not isinstance(result, Displayed):
        check_options("plot", how, (*_OF_PLOT, *_options_of_any_plot()))
        hint = "a study, a state, a run, an answer or a fit has a picture"
        raise UsageError(f"{described(result)} cannot be drawn", hint=hint)
    figure: Figure = result.plot(*what, out=out, overwrite=overwrite, **how)
    return figure


def _check_figures(kind: TaskKind, study: Study) -> None:
    """Raise StudyError if a figure that a study declares can have nothing to draw."""
    if kind.check_figures and study.figure:
        load(kind.check_figures)(study)


def _drawer(kind: TaskKind) -> Draw:
    """Return the function that draws the figures of a task; its module is imported for it."""

    def draw(
        study: Study, folder: Path, out: Path, record: dict[str, Any]
    ) -> tuple[list[str], list[str], str | None]:
        drawn: tuple[list[str], list[str], str | None]
        drawn = load(kind.draw)(study, folder, out, record)
        return drawn

    return draw


def _checked_jobs(jobs: object) -> int | None:
    """Return the number of jobs. Raise UsageError if it is neither None nor 1 or more."""
    if jobs is None:
        return None
    if isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1:
        problem = f"jobs = {jobs!r} is not possible, expected 1 or more, or None for every core"
        raise UsageError(problem)
    return jobs


# --- Pages that `plot` of a result draws ----------------------------------------------------------


def page_of_study(study: Study, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw the arm of a study. Raise UsageError for other options than `angles` and `case`."""
    from tendon_cli.figures.arm import arm_page

    _refuse_others("a study", what, how, _OF_ARM)
    return arm_page(study, how.get("angles", ()), how.get("case"))


def page_of_state(state: StatePage, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw the arm of the study of a state, as `page_of_study` does."""
    return page_of_study(state.study, what, how)


def page_of_fit(fit: Fit, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw a friction fit. Raise UsageError for any option."""
    from tendon_cli.figures.friction import fit_page

    _refuse_others("a fit", what, how, ())
    return fit_page(fit)


def page_of_suit_fit(fit: SuitFit, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw a fit to a suit's logs. Raise UsageError for any option."""
    from tendon_cli.figures.suit_fit import suit_fit_page

    _refuse_others("a fit", what, how, ())
    return suit_fit_page(fit)


_OF_PLOT = ("result", "what", "out", "overwrite")
"""Arguments of `plot` for every result."""
_OF_ARM = ("angles", "case")
"""Options of `plot` for a study or a state."""


def _options_of_run() -> tuple[str, ...]:
    """Return the options of `plot` for a run: the keys of `[[figure]]`."""
    from tendon_cli.studies.figures import FigureSpec

    return tuple(FigureSpec.model_fields)


def _options_of_any_plot() -> tuple[str, ...]:
    """Return the options that `plot` has for one kind of result or another."""
    return (*_OF_ARM, *_options_of_run())


def _refuse_others(
    result: str, what: tuple[str, ...], how: dict[str, Any], known: tuple[str, ...]
) -> None:
    """Raise UsageError for options of `plot` that a result does not have."""
    check_options("plot", how, (*_OF_PLOT, *known))
    if what:
        takes = ", ".join(known) or "no options besides out"
        hint = f"plot() of {result} takes {takes}"
        raise UsageError(f"{described(what[0])} cannot be chosen here", hint=hint)


def page_of_run(run: Run, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw designs as slack maps and states as curves, as `tendon plot` does."""
    from tendon_cli.cube.columns import TableColumns
    from tendon_cli.figures.draw import pages_of, table_of
    from tendon_cli.studies.figures import figure_spec

    check_options("plot", how, (*_OF_PLOT, *_options_of_run()))
    if what:
        how = {**how, "quantity": list(what)}
    spec = figure_spec(**how)
    wanted = None  # the first table that has the quantities
    if not spec.named_columns:
        wanted = "states" if run.record["designs"] == 1 else "designs"
    if run.folder is not None:
        table = table_of(run.folder, spec, wanted, run.study, by_name(run.record))
        return pages_of(table, spec, study=run.study)[0]
    names = sorted(run.tables, reverse=True)  # states before designs
    if wanted is not None and wanted in run.tables:
        names = [wanted]
    tables = [TableInMemory(run.tables[name]) for name in names]
    for table in tables:
        if set(spec.named_columns) <= set(TableColumns.of(table.schema).quantities):
            return pages_of(table, spec, study=run.study)[0]
    return pages_of(tables[0], spec, study=run.study)[0]


def page_of_comparison(comparison: Comparison, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw the windows of the answers of a comparison, or the margins of its first two runs."""
    _refuse_others("a comparison", what, how, ())
    return _picture_of_comparison(comparison, comparison.title)


def _picture_of_comparison(comparison: Comparison, title: str, **size: Any) -> Page:
    """Draw the windows or the margins of a comparison; an empty title leaves no room for one."""
    from tendon_cli.checks.compare_runs import pair_of_designs
    from tendon_cli.figures.side_by_side import margins_page, windows_page

    first, second, *_ = comparison.sides
    study = f"tendon study {first.name} {first.study_hash}"
    runs = [result for result in comparison.results if isinstance(result, Run)]
    if runs:
        before, now = pair_of_designs((runs[0], runs[1])).both("margin")
        return margins_page(before, now, (first.label, second.label), title, study, **size)
    read = "".join(say.setting_words(comparison.results[0].record["question"]["read"]))
    binds = [comparison.pairs[0].binds[0], *(pair.binds[1] for pair in comparison.pairs)]
    columns: dict[str, list[Any]] = {
        name: comparison.values(name) for name in ("pretension_from", "pretension_to", "pretension")
    }
    columns["from_by"] = [(bind and bind.lower) or "" for bind in binds]
    columns["to_by"] = [(bind and bind.upper) or "" for bind in binds]
    columns["fresh"] = [(bind and bind.fresh) or (None, None) for bind in binds]
    bounds = [result.record["question"]["limits"] for result in comparison.results]
    common = {
        name: value if all(one.get(name) == value for one in bounds) else None
        for one in bounds
        for name, value in one.items()
    }
    labels = [side.label for side in comparison.sides]
    return windows_page(labels, columns, common, title, f"{read} ({first.unit})", study, **size)


def write_comparison(comparison: Comparison, out: FileName, *, overwrite: bool = False) -> Path:
    """Write one HTML page of a comparison, with windows and maps on one scale.

    Raises:
        UsageError: The file exists and is not a page that tendon wrote.
        OutputError: The page cannot be written.
    """
    from tendon_cli.checks.compare_text import verdict_words
    from tendon_cli.cube.cube import cube_in
    from tendon_cli.figures.side_by_side import maps_on_one_scale
    from tendon_cli.reports.text_page import Picture, write_text_page

    pictures = []
    size = {"width": WIDTHS["column"]}  # a phone shows it whole
    try:
        page = _picture_of_comparison(comparison, "", **size)
        pictures.append(Picture("On one scale", page.png()))
    except UsageError as error:
        pictures.append(Picture(f"No figure: {error.message}", b""))
    answers = [result for result in comparison.results if not isinstance(result, Run)]
    cubes = [cube_in(one, "choices") for one in answers]
    pages = maps_on_one_scale(cubes, [one.record for one in answers], **size)
    for side, of_answer in zip(comparison.sides, pages, strict=False):
        if of_answer is not None:
            pictures.append(Picture(f"{side.label}: map of the choices", of_answer.png()))
    subtitle = " ".join(verdict_words(comparison.pairs))
    joint = say.joint_name(comparison.results[0].record)
    blocks = comparison.blocks
    headings = [place for place, block in enumerate(blocks) if "heading" in block]
    after_title = blocks[headings[1] :]  # title and subtitle of the page say what is before
    return write_text_page(
        result_path(out),
        comparison.title,
        subtitle,
        after_title,
        pictures,
        joint,
        overwrite=overwrite,
    )


def page_of_answer(answer: Answer, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Draw the named figure of an answer, or the first that it has.

    Raises:
        UsageError: The answer has no such figure, or an option is given.
    """
    from tendon_cli.cube.cube import cube_in
    from tendon_cli.figures.answer_figures import FIGURES, answer_figure

    check_options("plot", how, _OF_PLOT)
    for name in what:
        if name not in FIGURES:
            hint = hint_at_nearest(name, FIGURES) or ", ".join(FIGURES)
            raise UsageError(f"an answer has no figure {described(name)}", hint=hint)
    choices = cube_in(answer, "choices")
    for name in what or FIGURES:
        page = answer_figure(name, choices, answer.record)
        if page is not None:
            return page
    problem = (
        "this answer has no such figure: "
        "a map needs two axes, a front two goals, the others a window"
    )
    raise UsageError(problem)
