"""The picture of a study, a run, an answer, a fit or a state, as a matplotlib figure."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

from tendon_cli.answers.result import Answer
from tendon_cli.cube.columns import Columns
from tendon_cli.cube.cube import choices_of
from tendon_cli.engine.results import Run
from tendon_cli.errors import UsageError
from tendon_cli.files import result_path
from tendon_cli.state_page.page import StatePage
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import AnyTable, TableInMemory, open_table
from tendon_cli.units import described

if TYPE_CHECKING:
    from os import PathLike

    from tendon_cli.figures.engine import Figure
    from tendon_cli.figures.frame import Page

_MOST_DESIGNS = 10**5
"""A run of more is not drawn unasked."""


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


def _png(page: Page) -> bytes:
    from tendon_cli.figures.style import house_style, render

    with house_style():
        return render(page.figure, "png")


def _page(result: Any, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    if isinstance(result, Run):
        return _of_run(result, what, how)
    if isinstance(result, Answer):
        return _of_answer(result, what, how)
    if (how and set(how) - {"angles", "case"}) or what:
        given = [*what, *how][0]
        raise UsageError(f"{described(given)} cannot be chosen here", hint="plot() of a study takes angles, case")
    if isinstance(result, (Study, StatePage)):
        from tendon_cli.figures.arm import arm_page

        study = result if isinstance(result, Study) else result.study
        return arm_page(study, how.get("angles", ()), how.get("case"))
    from tendon_cli.figures.friction import fit_page

    return fit_page(result)


def _table(result: Run | Answer, name: str) -> AnyTable:
    """A table of a result by its name."""
    if result.folder is None:
        return TableInMemory(result.tables[name])
    return open_table(result.folder / f"{name}.parquet")


def _of_run(run: Run, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """Designs as slack maps, states as curves, as `tendon plot` draws them."""
    from tendon_cli.figures.draw import pages_of, table_of
    from tendon_cli.studies.figures import figure_spec

    spec = figure_spec(**how | ({"quantity": list(what)} if what else {}))
    is_plain = not (spec.quantity or spec.x or spec.colour or spec.panels or spec.filters)
    wanted = ("states" if run.record["designs"] == 1 else "designs") if is_plain else None
    if run.folder is not None:
        return pages_of(table_of(run.folder, spec, wanted), spec)[0]
    asked = {*spec.quantity, *filter(None, (spec.x, spec.colour, spec.panels)), *(each.name for each in spec.filters)}
    names = [name for name in ("states", "designs") if name in run.tables and wanted in (None, name)]
    tables = [_table(run, name) for name in names or run.tables]
    fitting = [table for table in tables if asked <= set(Columns.of(table.schema).held)]
    return pages_of((fitting or tables)[0], spec)[0]


def _of_answer(answer: Answer, what: tuple[str, ...], how: dict[str, Any]) -> Page:
    """The map of tolerance, the front or the windows, by name; the first that there is."""
    from tendon_cli.figures.answer import FIGURES, answer_figure

    for name in (*what, *how):
        if name not in FIGURES:
            hint = nearest(name, FIGURES) or ", ".join(FIGURES)
            raise UsageError(f"an answer has no figure {described(name)}", hint=hint)
    for name in what or FIGURES:
        page = answer_figure(name, choices_of(_table(answer, "choices")), answer.record)
        if page is not None:
            return page
    raise UsageError("this answer has no such figure: a map needs two axes, a front two goals, the rest a window")
