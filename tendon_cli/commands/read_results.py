"""Commands that read results: `tendon check`, `report`, `plot`, `show` and `export`."""

import contextlib
import io
import math
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tendon_cli.answers.design_kind import DESIGN
from tendon_cli.commands import completion, options
from tendon_cli.errors import EXIT_NEGATIVE, InputError, UsageError
from tendon_cli.terminal import print_note, print_result

if TYPE_CHECKING:
    from tendon_cli.cube.cube import Cube
    from tendon_cli.tables.read import AnyTable


def _tolerance(text: str | float) -> float:
    """Return the number of --tolerance; raise UsageError unless it is 0 or more."""
    try:
        share = float(text)
    except ValueError:
        share = math.nan
    if not 0.0 <= share < math.inf:
        from tendon_cli.units import shorten

        problem = f'"{shorten(str(text))}" is not possible, expected a share of a column\'s scale, '
        raise UsageError(f"{problem}0 or more", where="--tolerance", hint="such as 1e-9")
    return share


BaselineOption = Annotated[
    Path | None, options.output_option("report only what changed since this run", "RUN")
]
ToleranceOption = Annotated[
    float | None,
    options.option(
        "SHARE",
        "largest difference allowed, as a share of a column's scale; default 1e-9",
        parser=_tolerance,
    ),
]
ExceptOption = Annotated[
    list[str] | None,
    options.option(
        "KEY",
        "key in which the studies may differ; repeatable",
        "--except",
        completer=completion.keys,
    ),
]
WorstOption = Annotated[
    int,
    options.option(
        "N",
        "number of designs to list, the worst first",
        parser=options.number_parser("--worst", 1),
    ),
]
MarkdownOption = Annotated[
    bool, typer.Option("--markdown", help="print Markdown, for the summary of a CI job")
]

AnnotateOption = Annotated[
    bool,
    typer.Option(
        "--annotate", help="print on stderr the annotation that GitHub shows beside a failed job"
    ),
]


def check(
    run: options.RunArgument,
    baseline: BaselineOption = None,
    tolerance: ToleranceOption = None,
    apart: ExceptOption = None,
    worst: WorstOption = 10,
    markdown: MarkdownOption = False,
    annotate: AnnotateOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Check that every design of a run keeps its limits, or that two runs agree; exit 4 if not.

    An answer of `tendon design` passes if the choice that it names first keeps the limits for as
    many as its study demands; with --baseline, if its window, share and tensions have not moved.
    """
    from tendon_cli.checks.check_since import TOLERANCE
    from tendon_cli.checks.check_text import annotation, as_markdown

    options.refuse_both("--json", as_json, "--markdown", markdown)
    if baseline is None and (apart or tolerance is not None):
        given = "--except" if tolerance is None else "--tolerance"
        raise UsageError(f"{given} is for a comparison", hint="--baseline names the other run")
    tolerance = TOLERANCE if tolerance is None else tolerance
    from tendon_cli.checks.check import check as check_results

    checked = check_results(run, baseline, tolerance=tolerance, apart=apart or (), worst=worst)
    text = as_markdown(checked.text, checked.verdict) if markdown else checked.text
    print_result(checked.record if as_json else text)
    if not checked.holds:
        if annotate:
            print_note(annotation(checked.text, checked.verdict))
        raise typer.Exit(EXIT_NEGATIVE)


ResultsArgument = Annotated[
    list[Path],
    typer.Argument(
        parser=options.results_path,
        metavar="A B",
        help="folders of two or more sweeps, or of two or more designs; the first is the reference",
    ),
]
ComparedChoiceOption = Annotated[
    int | None,
    options.option(
        "ROW",
        "compare this choice of A with the same choice of the others",
        "--choice",
        parser=options.number_parser("--choice", 0),
    ),
]
HtmlOption = Annotated[
    Path | None, options.output_option("write one page with figures on one scale", "FILE.html")
]


def compare(
    results: ResultsArgument,
    choice: ComparedChoiceOption = None,
    markdown: MarkdownOption = False,
    html: HtmlOption = None,
    overwrite: options.OverwriteFileOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Compare runs, or answers: what differs, what is better or worse, who is gained and lost.

    Exits with 0 whatever the outcome; `tendon check --baseline` is the gate.
    """
    from tendon_cli.checks.compare import compare_results
    from tendon_cli.face import write_comparison

    options.refuse_both("--json", as_json, "--markdown", markdown)
    compared = compare_results(*results, choice=choice)
    if html is not None:
        write_comparison(compared, html, overwrite=overwrite)
    text = compared.markdown if markdown else compared.text
    print_result(compared.record if as_json else text)


PageOption = Annotated[
    Path | None,
    options.out_option("file to write; default: report.html in the run's folder"),
]


def report(
    run: options.RunArgument,
    out: PageOption = None,
    overwrite: options.OverwriteFileOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Write one HTML page with everything that a run or an answer holds."""
    from tendon_cli.reports.report import write_report

    written = str(write_report(run, out, overwrite=overwrite))
    print_result({"report": written} if as_json else written)


FigureSourceArgument = Annotated[
    Path,
    typer.Argument(
        parser=options.read_path,
        metavar="RUN_OR_TABLE",
        help="a run folder, or any one of its tables; a study with --arm",
    ),
]
BetweenOption = Annotated[
    bool,
    typer.Option(
        "--between",
        help="for an answer: draw the pretension that each limit allows over the angle or time, "
        "and show which limit binds where",
    ),
]
ArmOption = Annotated[
    bool,
    typer.Option("--arm", help="draw the arm of a study to scale, and the route of its sheath"),
]
PlotTableOption = Annotated[str | None, options.option("states|designs", "table of a run folder")]
QuantityOption = Annotated[
    list[str] | None,
    options.option(
        "COLUMN",
        "column to draw, or the axis up of a map; repeatable",
        "--quantity",
        "-y",
        completer=completion.columns,
    ),
]
AcrossOption = Annotated[
    str | None,
    options.option(
        "COLUMN",
        "column along the horizontal axis; for an answer a limit, such as limits.max_tension",
        "--x",
        "-x",
        completer=completion.columns,
    ),
]
ColourOption = Annotated[
    str | None,
    options.option("AXIS", "a colour for each value of this axis", completer=completion.columns),
]
PanelsOption = Annotated[
    str | None,
    options.option("AXIS", "a panel for each value of this axis", completer=completion.columns),
]
UnitOption = Annotated[
    list[str] | None, options.option("UNIT", "unit to show a dimension in, such as cm; repeatable")
]
AngleOption = Annotated[
    list[str] | None,
    options.option("ANGLE", "with --arm: elbow angle to draw, such as 45 deg; repeatable"),
]
FormatOption = Annotated[str, options.option("png|svg|pdf", "format of the figure", "--format")]
SizeOption = Annotated[
    str, options.option("SIZE", "size of the figure: column, page, '120 mm' or '120 x 80 mm'")
]


def plot(
    source: FigureSourceArgument,
    arm: ArmOption = False,
    between: BetweenOption = False,
    table: PlotTableOption = None,
    quantity: QuantityOption = None,
    x: AcrossOption = None,
    colour: ColourOption = None,
    panels: PanelsOption = None,
    where: options.WhereOption = None,
    unit: UnitOption = None,
    angle: AngleOption = None,
    case: options.CaseOption = None,
    settings: options.SettingsOption = None,
    format_: FormatOption = "png",
    size: SizeOption = "page",
    out: options.OutFileOption = None,
    overwrite: options.OverwriteFileOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Draw figures of a run, of any table of tendon's, of an answer, or of the arm of a study."""
    if str(source) == "-":
        raise UsageError(
            "a figure needs a file or a folder, not standard input",
            hint="tendon plot --arm study.toml",
        )
    is_answer = (source / DESIGN.record).exists()
    of_figure = {
        "quantity": quantity,
        "x": x,
        "colour": colour,
        "panels": panels,
        "where": where,
        "unit": unit,
    }
    of_table = any((table, quantity, colour, panels, where, unit))
    asks = {
        "table": table,
        **of_figure,
        "format": None if format_ == "png" else format_,
        "size": None if size == "page" else size,
    }
    if arm or between:
        unused = [f"--{name}" for name, value in asks.items() if value is not None]
        _refuse_unused(unused, "--arm" if arm else "--between")
    elif is_answer and size != "page" and x is None and not any((table, quantity)):
        _refuse_unused(["--size"], "the figures of an answer")
    if arm:
        from tendon_cli.figures.geometry import draw_geometry

        angles = [_angle(text) for text in angle or ()]
        drawn = draw_geometry(source, tuple(settings or ()), angles, out, case, overwrite=overwrite)
    elif between or (is_answer and (x is not None or not of_table)):
        from tendon_cli.figures import answer_figures

        choices, record = _choices_and_record(source)
        if between:
            drawn = [answer_figures.draw_between_samples(choices, record, out, overwrite=overwrite)]
        elif x is not None:
            from tendon_cli.studies.figures import read_size

            width, height = read_size(size)
            drawn = answer_figures.draw_over(
                choices,
                record,
                x,
                quantity[0] if quantity else None,
                out,
                width=width,
                height=height,
                form=format_,
                overwrite=overwrite,
            )
        else:
            drawn = answer_figures.draw_again(
                source, choices, record, out, form=format_, overwrite=overwrite
            )
    else:
        from tendon_cli.figures.draw import plot as draw
        from tendon_cli.figures.draw import table_of
        from tendon_cli.studies.figures import figure_spec

        given = {name: value for name, value in of_figure.items() if value is not None}
        spec = figure_spec(**given, format=format_, size=size)
        drawn = draw(table_of(source, spec, table), spec, out, overwrite=overwrite)
    written = [str(file) for file in drawn]
    print_result({"figures": written} if as_json else "\n".join(written))


def _refuse_unused(given: list[str], drawn: str) -> None:
    """Refuse options that a kind of figure has no use for.

    Args:
        given: Such options that are given.
        drawn: The option, or the words, that say which figure is drawn.

    Raises:
        UsageError: One is given.
    """
    if not given:
        return
    from tendon_cli import say

    hint = f"leave out {say.join_words(given)}"
    if "--format" in given:
        hint = "--out FILE.svg or FILE.pdf chooses the format"
    raise UsageError(f"has no use with {drawn}", where=given[0], hint=hint)


def _choices_and_record(source: Path) -> tuple["Cube", dict[str, Any]]:
    """Return the choices of the answer in a folder, and its record.

    Raises:
        UsageError: The folder holds something else.
    """
    from tendon_cli.answers.answer import Answer
    from tendon_cli.cube.cube import cube_in
    from tendon_cli.engine.results import open_result

    answer = open_result(source)
    if not isinstance(answer, Answer):
        hint = "tendon design STUDY writes one"
        raise UsageError(
            "is not an answer, and only answers have a window to draw",
            where=str(source),
            hint=hint,
        )
    return cube_in(answer, "choices"), answer.record


def _angle(text: str) -> float:
    """Return an angle in rad; raise UsageError if the text is not an angle."""
    from tendon_cli.units import UnitError, parse_measure

    try:
        return parse_measure(text, "angle").si
    except UnitError as error:
        raise UsageError(error.problem, where="--angle", hint=error.hint) from None


SortOption = Annotated[
    str | None,
    options.option(
        "COLUMN", "sort by this column; -COLUMN: the largest first", completer=completion.columns
    ),
]
HeadOption = Annotated[
    int,
    options.option("N", "number of rows to show", parser=options.number_parser("--head", 0)),
]
CsvOption = Annotated[
    bool, typer.Option("--csv", help="print CSV in SI units, named in the header")
]


def show(
    source: options.TableArgument,
    table: options.TableOption = None,
    where: options.WhereOption = None,
    sort: SortOption = None,
    columns: options.ColumnsOption = None,
    head: HeadOption = 20,
    as_json: options.JsonOption = False,
    as_csv: CsvOption = False,
) -> None:
    """Show rows of a table in the terminal.

    Shows the designs of a run and the choices of an answer, unless --table names another table; a
    CSV of people is shown as tendon reads it.
    """
    from tendon_cli.cube.rows import rows_in, write_csv
    from tendon_cli.cube.rows_text import head_words, rows_text

    options.refuse_both("--json", as_json, "--csv", as_csv)
    rows = rows_in(source, table, where or (), options.split_names(columns), sort)
    _print_notes(rows.table)
    shown, total = rows.head(head, sort)
    if as_csv:
        text = io.BytesIO()
        write_csv(rows, text, iter([shown]))
        if shown.num_rows < total:
            print_note(f"note: {head_words(shown.num_rows, total)}")
        print_result(text.getvalue().decode().rstrip("\n"))
    elif as_json:
        units = {name: rows.unit(name) for name in rows.names}
        data = [_as_json(row) for row in shown.to_pylist()]
        print_result({"rows": total, "units": units, "data": data})
    else:
        width = shutil.get_terminal_size().columns
        print_result(rows_text(rows, shown, total, width, has_all=columns is not None))


def _print_notes(table: "AnyTable") -> None:
    """Print the notes on the file of a table, such as on columns that are not read."""
    for note in table.notes:
        print_note(f"note: {note}")


def _as_json(row: dict[str, object]) -> dict[str, object]:
    """Return a row that JSON can hold: "rigid" for an infinite stiffness, null for no number."""
    result = dict(row)
    for name, value in row.items():
        if isinstance(value, float) and not math.isfinite(value):
            result[name] = "rigid" if value == math.inf else None
    return result


CsvArgument = Annotated[
    Path,
    typer.Argument(
        parser=options.results_path, metavar="FILE", help="file to write: .csv, or .xml for MuJoCo"
    ),
]
ToOption = Annotated[
    str | None,
    options.option(
        "mujoco|controller|parameters|parts",
        "for an answer: write its choice for this tool, instead of a table",
    ),
]
ExportedChoiceOption = Annotated[
    int | None,
    options.option(
        "ROW",
        "with --to: this choice instead of the one named first",
        "--choice",
        parser=options.number_parser("--choice", 0),
    ),
]
LocaleOption = Annotated[
    str,
    options.option(
        "LANGUAGE",
        "format numbers as in this language: de writes 1,5 and separates columns by semicolons",
    ),
]
UnitsOption = Annotated[
    str, options.option("si|study", "SI units, or those of studies, such as mm", "--units")
]
RoundOption = Annotated[
    int | None,
    options.option(
        "DIGITS",
        "round to so many significant digits, as a paper's table has them",
        "--round",
        parser=options.number_parser("--round", 1),
    ),
]


def _export_choice(source: Path, to: str, file: Path, choice: int | None, overwrite: bool) -> Path:
    """Write the choice of an answer for another tool; raise InputError if it is no answer."""
    from tendon_cli.engine.results import open_result
    from tendon_cli.verbs.registry import load

    result = open_result(source)
    if not result.kind.export:
        problem = f"holds {result.kind.noun}, expected an answer"
        hint = "tendon design STUDY writes one"
        raise InputError(problem, where=str(source), hint=hint)
    written: Path = load(result.kind.export)(result, to, file, choice=choice, overwrite=overwrite)
    return written


def export(
    source: options.TableArgument,
    file: CsvArgument,
    to: ToOption = None,
    choice: ExportedChoiceOption = None,
    table: options.TableOption = None,
    where: options.WhereOption = None,
    columns: options.ColumnsOption = None,
    locale: LocaleOption = "en",
    units: UnitsOption = "si",
    digits: RoundOption = None,
    overwrite: options.OverwriteFileOption = False,
    as_json: options.JsonOption = False,
) -> None:
    """Write a table as CSV, in SI units, or with --to the choice of an answer for another tool.

    For a study, --table names one of its [[table]] entries, whose rows are written.
    """
    if to is not None:
        of_tables = {
            "--table": table,
            "--where": where,
            "--columns": columns,
            "--locale": locale != "en",
            "--units": units != "si",
            "--round": digits,
        }
        for flag, value in of_tables.items():
            if value:
                raise UsageError(f"{flag} is for tables, and --to writes none")
        written = str(_export_choice(source, to, file, choice, overwrite))
        print_result({"file": written} if as_json else f"{written} written")
        return
    if choice is not None:
        raise UsageError("--choice needs --to", hint="tendon export ANSWER --to mujoco FILE.xml")
    from tendon_cli.cube.rows import CsvForm, rows_in
    from tendon_cli.cube.rows import export as write_rows

    form = CsvForm(locale, units, digits)
    rows = rows_in(source, table, where or (), options.split_names(columns))
    _print_notes(rows.table)
    with contextlib.suppress(OSError):
        if file.samefile(source):
            raise UsageError(
                f"{file.name} is an input and would be overwritten", hint="choose another name"
            )
    count = write_rows(rows, file, form, overwrite=overwrite)
    record = {"file": str(file), "rows": count, "columns": rows.names}
    text = f"{file} written: {count:,} rows, {len(rows.names)} columns"
    print_result(record if as_json else text)
