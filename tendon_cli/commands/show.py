"""`tendon show` and `tendon export`: rows of a table in the terminal, and as CSV."""

import contextlib
import io
import math
import shutil
from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options, values
from tendon_cli.errors import UsageError
from tendon_cli.terminal import print_result

Sort = Annotated[
    str | None, options.option("COLUMN", "sort by this column; -COLUMN: the largest first", among=values.columns)
]
Head = Annotated[int, typer.Option(min=0, metavar="N", help="how many rows to show")]
AsCsv = Annotated[bool, typer.Option("--csv", help="print CSV in SI units, named in the header")]


def show(
    source: options.Table,
    table: options.TableName = None,
    where: options.Where = None,
    sort: Sort = None,
    columns: options.Columns = None,
    head: Head = 20,
    as_json: options.AsJson = False,
    as_csv: AsCsv = False,
) -> None:
    """Show rows of a table in the terminal.

    A run shows its designs and an answer its choices, unless --table names another table; a CSV of people is shown as
    tendon reads it.
    """
    from tendon_cli.cube.rows import rows_in, write_csv
    from tendon_cli.summary import rows_text

    options.exclude("--json", as_json, "--csv", as_csv)
    rows = rows_in(Path(source), table, where or (), options.listed(columns), sort)
    shown, total = rows.head(head, sort)
    if as_csv:
        written = io.BytesIO()
        write_csv(rows, written, iter([shown]))
        print_result(written.getvalue().decode().rstrip("\n"))
    elif as_json:
        units = {name: rows.unit(name) for name in rows.names}
        print_result({"rows": total, "units": units, "data": [*map(_finite, shown.to_pylist())]})
    else:
        print_result(rows_text(rows, shown, total, shutil.get_terminal_size().columns))


def _finite(row: dict[str, object]) -> dict[str, object]:
    """A row that JSON can hold."""
    odd = {name: value for name, value in row.items() if isinstance(value, float) and not math.isfinite(value)}
    return row | {name: "rigid" if value == math.inf else None for name, value in odd.items()}


CsvFile = Annotated[Path, typer.Argument(parser=options.place, metavar="FILE.csv", help="file to write")]
Locale = Annotated[
    str, options.option("LANGUAGE", "numbers as this language writes them: de writes 1,5 and separates by semicolons")
]
InUnits = Annotated[str, options.option("si|study", "SI units, or those people read, such as mm", "--units")]


def export(
    source: options.Table,
    file: CsvFile,
    table: options.TableName = None,
    where: options.Where = None,
    columns: options.Columns = None,
    locale: Locale = "en",
    units: InUnits = "si",
    as_json: options.AsJson = False,
) -> None:
    """Write a table as CSV, in SI units, for tools that cannot read Parquet."""
    from tendon_cli.cube.rows import CsvForm, rows_in
    from tendon_cli.cube.rows import export as written

    form = CsvForm(locale, units)
    rows = rows_in(source, table, where or (), options.listed(columns))
    with contextlib.suppress(OSError):
        if file.samefile(source):
            raise UsageError(f"{file.name}, which is read, would be written over", hint="choose another name")
    count = written(rows, file, form)
    text = f"{file} written: {count:,} rows, {len(rows.names)} columns"
    print_result({"file": str(file), "rows": count, "columns": rows.names} if as_json else text)
