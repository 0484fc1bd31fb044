"""The verbs that compute, what they have written, opened again, and the picture of any result."""

from __future__ import annotations

import base64
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict, Unpack

from tendon_cli.engine.results import Run, verified_record
from tendon_cli.engine.run import Draw, How, run_task
from tendon_cli.engine.sweep import Sweep
from tendon_cli.errors import UsageError
from tendon_cli.files import result_path
from tendon_cli.studies.checks import without_intervals
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.load import AnyStudy, any_study
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableInMemory
from tendon_cli.units import described

if TYPE_CHECKING:
    from tendon_cli.answers.answer import Answer
    from tendon_cli.engine.cost import Estimate
    from tendon_cli.figures.backend import Figure
    from tendon_cli.figures.frame import Page

Name: TypeAlias = str | PathLike[str]
_MOST_DESIGNS = 10**5
"""A run of more is not drawn unasked."""


class Options(TypedDict, total=False):
    """What else `sweep` and `design` take, by name."""

    resume: bool
    overwrite: bool
    lock: bool
    scheduler: str | None
    progress: Callable[[int, int], None]
    stop: Event | None


def sweep(
    study: AnyStudy,
    out: Name | None = None,
    jobs: int | None = None,
    figures: bool = False,
    **options: Unpack[Options],
) -> Run:
    """Run a study into the folder `out`, or without one in memory.

    The folder is locked until its tables stand written, recorded and verified. At most `jobs` parts are computed at
    once, by default one for each core. `resume=True` finishes an unfinished run, `overwrite=True` replaces the one that
    stands there, `lock=False` is for file systems that cannot lock. `scheduler` is the address of a Dask cluster,
    `progress` is called with the number of finished parts and of all parts. Ctrl-C, or an event `stop` that is set,
    ends it cleanly; what was finished is kept. A declared figure that can have nothing to draw is a fault before
    anything is computed, any other that cannot be drawn a warning. Raises TendonError.

    >>> import tendon_cli as tendon
    >>> run = tendon.sweep(tendon.study({"load": {"mass": ["0 kg", "5 kg"]}}))
    >>> run.designs[["load_mass", "required_pretension"]].round(2)
       load_mass  required_pretension
    0        0.0                96.83
    1        5.0               158.57
    >>> run.designs.attrs["units"]["required_pretension"]
    'N'
    """
    asked = _swept(study, figures=figures)
    return run_task(
        Sweep, Run, asked, *_how("sweep", out, jobs, _draw_run if figures else None, options)
    )


def design(
    study: AnyStudy,
    out: Name | None = None,
    jobs: int | None = None,
    figures: bool = False,
    **options: Unpack[Options],
) -> Answer:
    """Answer the design question of a study into the folder `out`, or without one in memory.

    All is as with `sweep`: the folder is locked until the answer stands written, recorded and verified, `resume`
    finishes an unfinished one, `overwrite` replaces the one that stands there, and the same question asked again is not
    worked out again. Raises TendonError.

    >>> import tendon_cli as tendon
    >>> arm = {"spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}}
    >>> answer = tendon.design(tendon.study({**arm, "load": {"mass": ["0 kg", "10 kg"]}}))
    >>> answer.choices[["pretension_from", "pretension_to", "from_by", "to_by"]].round(1)
       pretension_from  pretension_to         from_by                to_by
    0            122.1          173.9  extensor slack  min_elbow_stiffness
    """
    from tendon_cli.answers.answer import Answer
    from tendon_cli.answers.choices import Choices

    how = _how("design", out, jobs, _draw_answer if figures else None, options)
    return run_task(Choices, Answer, any_study(study), *how)


def estimate(study: AnyStudy, jobs: int | None = None, figures: bool = False) -> Estimate:
    """What a sweep would cost, rows exactly, the rest from one part computed in memory; raises SizeError.

    >>> import tendon_cli as tendon
    >>> tendon.estimate(tendon.study({})).rows
    {'designs': 1, 'states': 182}
    """
    from tendon_cli.engine.cost import estimate as estimated
    from tendon_cli.engine.plan import Plan
    from tendon_cli.engine.threads import available_cores

    plan = Plan(_swept(study, figures=figures))
    return estimated(plan, _count_of(jobs) or available_cores(), figures=figures)


def open(path: Name) -> Run | Answer:  # noqa: A001 - as netCDF4, zarr and xarray have it
    """The run of `sweep` or the answer of `design` that stands in a folder, every byte of its tables verified.

    Raises InputError if there is none or a file of it is damaged, FolderError if it is unfinished.

    >>> import tendon_cli as tendon
    >>> done = tendon.design({"load": {"mass": [0, 2]}, "spring": {"stiffness": [3000, 5000]}}, "results/mine")
    >>> tendon.open("results/mine").feasible == done.feasible
    True
    """
    from tendon_cli.answers.answer import Answer

    folder = result_path(path)
    record = verified_record(folder)
    return (Answer if record["verb"] == "design" else Run)(record, folder, up_to_date=True)


def plot(result: Any, *what: str, out: str | PathLike[str] | None = None, **how: Any) -> Figure:
    """The picture of a study, a state, a run, an answer or a fit, as a matplotlib figure; also `result.plot(...)`.

    A run takes the columns to draw and the keys of `[[figure]]`, such as `x`, `colour`, `where`, `unit`, `size`; an
    answer "tolerance_map", "window", "front" or "between"; a study its `angles` in rad and a `case`. `out` is a file
    that it is written to, too. Raises UsageError for what cannot be drawn.

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
    """The main picture of a result for a notebook, a PNG in base64; empty for what has none."""
    if isinstance(result, Run) and result.record["designs"] > _MOST_DESIGNS:
        return ""
    try:
        return base64.b64encode(_png(_page(result, (), {}))).decode()
    except Exception:  # noqa: BLE001 - a session shows the text of a result whatever its picture does
        return ""


def _swept(given: AnyStudy, *, figures: bool) -> Study:
    """A study to be swept; raises StudyError for a declared figure that is known beforehand to have nothing to draw."""
    study = without_intervals(any_study(given))
    if figures and study.figure:
        from tendon_cli.figures.draw import check_figures_of

        check_figures_of(study)
    return study


def _how(
    verb: str, out: Name | None, jobs: int | None, draw: Draw | None, options: Options
) -> tuple[Path | None, How]:
    """Where and how a verb is carried out; raises UsageError if figures would have no place."""
    if out is None and draw is not None:
        raise UsageError(
            "figures are drawn into a folder", hint=f"name one: {verb}(study, out, figures=True)"
        )
    return None if out is None else result_path(out), How(
        jobs=_count_of(jobs), draw=draw, **options
    )


def _count_of(jobs: object) -> int | None:
    if jobs is not None and (isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1):
        raise UsageError(
            f"jobs = {jobs!r} is not possible, expected 1 or more, or None for every core"
        )
    return jobs


def _draw_run(
    study: Study, folder: Path, out: Path, record: dict[str, Any]
) -> tuple[list[str], list[str], str | None]:
    from tendon_cli.figures.draw import draw_run  # only who draws pays for its import

    files, warnings, no_map = draw_run(study, folder, out)
    return files, warnings, None if study.figure or record["designs"] == 1 else no_map


def _draw_answer(
    _: Study, folder: Path, out: Path, record: dict[str, Any]
) -> tuple[list[str], list[str], None]:
    from tendon_cli.figures.answer_figures import draw_answer

    return *draw_answer(folder, record, out), None


def _png(page: Page) -> bytes:
    from tendon_cli.figures.style import house_style, render

    with house_style():
        return render(page.figure, "png")


def _page(result: Any, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    from tendon_cli.answers.answer import Answer  # only who draws pays for these
    from tendon_cli.state_page.page import StatePage

    if isinstance(result, Run):
        return _of_run(result, what, how)
    if isinstance(result, Answer):
        return _of_answer(result, what, how)
    if (how and set(how) - {"angles", "case"}) or what:
        given = [*what, *how][0]
        raise UsageError(
            f"{described(given)} cannot be chosen here", hint="plot() of a study takes angles, case"
        )
    if isinstance(result, (Study, StatePage)):
        from tendon_cli.figures.arm import arm_page

        study = result if isinstance(result, Study) else result.study
        return arm_page(study, how.get("angles", ()), how.get("case"))
    from tendon_cli.figures.friction import fit_page

    return fit_page(result)


def _of_run(run: Run, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Designs as slack maps, states as curves, as `tendon plot` draws them."""
    from tendon_cli.cube.columns import Columns
    from tendon_cli.figures.draw import pages_of, table_of
    from tendon_cli.studies.figures import figure_spec

    spec = figure_spec(**how | ({"quantity": list(what)} if what else {}))
    wanted = None if spec.asked else "states" if run.record["designs"] == 1 else "designs"
    if run.folder is not None:
        return pages_of(table_of(run.folder, spec, wanted), spec)[0]
    names = (
        [wanted] if wanted and wanted in run.tables else sorted(run.tables, reverse=True)
    )  # states before designs
    tables = [TableInMemory(run.tables[name]) for name in names]
    fitting = (table for table in tables if set(spec.asked) <= set(Columns.of(table.schema).held))
    return pages_of(next(fitting, tables[0]), spec)[0]


def _of_answer(answer: Answer, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """The map of tolerance, the front or the windows, by name; the first that there is."""
    from tendon_cli.cube.cube import choices_of
    from tendon_cli.figures.answer_figures import FIGURES, answer_figure

    for name in (*what, *how):
        if name not in FIGURES:
            hint = nearest(name, FIGURES) or ", ".join(FIGURES)
            raise UsageError(f"an answer has no figure {described(name)}", hint=hint)
    choices = choices_of(TableInMemory(answer.table("choices")))
    for name in what or FIGURES:
        if (page := answer_figure(name, choices, answer.record)) is not None:
            return page
    raise UsageError(
        "this answer has no such figure: a map needs two axes, a front two goals, the rest a window"
    )
