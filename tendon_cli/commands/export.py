"""`tendon export`: a table as CSV."""

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from tendon_cli.commands import options
from tendon_cli.errors import UsageError
from tendon_cli.terminal import as_json_text, print_result

CsvFile = Annotated[Path, typer.Argument(parser=options.place, metavar="FILE.csv", help="file to write")]


def export(
    source: options.Table,
    file: CsvFile,
    table: options.TableName = None,
    where: options.Where = None,
    columns: options.Columns = None,
    as_json: options.AsJson = False,
) -> None:
    """Write a table as CSV, in SI units, for tools that cannot read Parquet."""
    from tendon_cli.cube.rows import export as written
    from tendon_cli.cube.rows import rows_in

    rows = rows_in(source, table, where or (), options.listed(columns))
    with contextlib.suppress(OSError):
        if file.samefile(source):
            raise UsageError(f"{file.name}, which is read, would be written over", hint="choose another name")
    count = written(rows, file)
    text = f"{file} written: {count:,} rows, {len(rows.names)} columns"
    print_result(as_json_text({"file": str(file), "rows": count, "columns": rows.names}) if as_json else text)
