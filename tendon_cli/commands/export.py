"""`tendon export`: a table as CSV."""

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.errors import UsageError
from tendon_cli.terminal import as_json_text, print_result

CsvFile = Annotated[Path, typer.Argument(parser=options.place, metavar="FILE.csv", help="file to write")]
Locale = Annotated[
    str, typer.Option(metavar="LANGUAGE", help="decimal sign and separator of a language: de has 1,5 and semicolons")
]
InUnits = Annotated[str, typer.Option("--units", metavar="si|study", help="SI units, or those of studies, such as mm")]


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
    print_result(as_json_text({"file": str(file), "rows": count, "columns": rows.names}) if as_json else text)
