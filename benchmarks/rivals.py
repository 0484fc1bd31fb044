"""What tendon is measured against, each in a process of its own: `python -m benchmarks.rivals NAME ...`.

`bare_write` and `ready_table` are the machine's limit: a table that is ready in memory, written by pyarrow as tendon
writes it (row groups, encoding of each column, compression, statistics, page checksums) and by as many threads, but to
one file a thread, without fsync, SHA-256, footer check, journal and record. Pages have the library's own length, with
which encoding takes a quarter longer than with tendon's. `joblib_per_design` is a plain script.
"""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.measure import Took, in_threads

if TYPE_CHECKING:
    import pyarrow as pa

TABLES = ("states", "designs")


def encoding_of(file: Path) -> dict[str, Any]:
    """How a table file is encoded, as arguments for pyarrow's writer; read from its footer, whoever wrote it."""
    import pyarrow.parquet as pq

    footer = pq.read_metadata(file)
    group = footer.row_group(0)
    columns = [group.column(index) for index in range(group.num_columns)]
    plain = {"PLAIN", "RLE", "BIT_PACKED"}
    return {
        "version": footer.format_version,
        "row_group_size": group.num_rows,
        "compression": {column.path_in_schema: column.compression for column in columns},
        "use_dictionary": [
            column.path_in_schema for column in columns if column.has_dictionary_page
        ],
        "column_encoding": {
            column.path_in_schema: special[0]
            for column in columns
            if not column.has_dictionary_page and (special := sorted(set(column.encodings) - plain))
        },
        "write_statistics": [column.path_in_schema for column in columns if column.is_stats_set],
        "write_page_checksum": True,
    }


def table_files(run_folder: Path, table: str) -> list[Path]:
    """The files of a table of a run, in order: one, or those of its parts."""
    path = run_folder / f"{table}.parquet"
    return sorted(path.glob("part-*.parquet")) if path.is_dir() else [path] if path.exists() else []


def in_memory(files: list[Path]) -> pa.Table:
    """A table as a whole, each column in one piece."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.concat_tables(
        [pq.ParquetFile(file).read().replace_schema_metadata() for file in files]
    )
    for index, field in enumerate(table.schema):
        table = table.set_column(index, field, table.column(index).combine_chunks())
    return table


class Ready:
    """Tables of a run in memory, to be written again and again."""

    def __init__(self, run_folder: Path, target: Path, threads: int) -> None:
        found = [files for name in TABLES if (files := table_files(run_folder, name))]
        self._tables = [(in_memory(files), encoding_of(files[0])) for files in found]
        self._target, self._threads = target, threads

    def write(self) -> Took:
        """Write each table in as many slices as there are threads."""
        return in_threads(partial(self._slices, thread) for thread in range(self._threads))

    def flush(self) -> float:
        """Wait until what was written is on the disk, then remove it; seconds of the waiting."""
        files = sorted(self._target.parent.glob(f"{self._target.name}-*.parquet"))
        started = time.perf_counter()
        for file in files:
            with file.open("rb") as opened:
                os.fsync(opened.fileno())
        taken = time.perf_counter() - started
        for file in files:
            file.unlink()
        return taken

    def _slices(self, thread: int) -> None:
        import pyarrow.parquet as pq

        for number, (table, encoding) in enumerate(self._tables):
            start, stop = (table.num_rows * at // self._threads for at in (thread, thread + 1))
            file = self._target.with_name(f"{self._target.name}-{number}-{thread}.parquet")
            pq.write_table(table.slice(start, stop - start), file, **encoding)


def bare_write(run_folder: str, target: str, threads: str) -> None:
    """Keep the tables of a run in memory; write them, and say what it took, for every line on standard input."""
    ready = Ready(Path(run_folder), Path(target), int(threads))
    print("ready", flush=True)
    for _ in sys.stdin:
        print(json.dumps({**asdict(ready.write()), "flush": ready.flush()}), flush=True)


def ready_table(run_folder: str, target: str, threads: str) -> None:
    """Import what tendon needs for a sweep and write a table: when that ended, and how long reading the table took."""
    import numpy as np  # noqa: F401
    import pyarrow.parquet as pq  # noqa: F401
    import pydantic  # noqa: F401
    import typer  # noqa: F401

    started, worked = time.monotonic(), time.process_time()
    ready = Ready(Path(run_folder), Path(target), int(threads))
    reading, working = time.monotonic() - started, time.process_time() - worked
    ready.write()
    print(
        json.dumps(
            {
                "ended": time.monotonic(),
                "reading": reading,
                "processor": time.process_time() - working,
            }
        )
    )


def joblib_per_design(study: str, target: str, most: str) -> None:
    """The straightforward script: joblib over designs, a small data frame each, one `to_parquet` at the end.

    Takes the first `most` designs only; says how many, so that the rate can be compared.
    """
    import numpy as np
    import pandas as pd
    from joblib import Parallel, delayed

    from tendon_cli.engine.plan import Plan
    from tendon_cli.studies.load import load_study

    plan = Plan(load_study(Path(study)))
    count = min(plan.designs, int(most))

    def one(design: int) -> pd.DataFrame:
        block = next(plan.blocks(range(design, design + 1)))
        columns = plan.state(block).columns()
        frame = pd.DataFrame(
            {name: np.broadcast_to(values, block.shape).ravel() for name, values in columns.items()}
        )
        frame.insert(0, "design", design)
        return frame if "states" in plan.study.output.tables else frame.agg(["min", "max"])

    started, worked = time.perf_counter(), time.process_time()
    frames = Parallel(n_jobs=2)(delayed(one)(design) for design in range(count))
    pd.concat(frames).to_parquet(target)
    took = {"seconds": time.perf_counter() - started, "processor": time.process_time() - worked}
    print(json.dumps({**took, "designs": count}))


if __name__ == "__main__":
    {"bare_write": bare_write, "ready_table": ready_table, "joblib_per_design": joblib_per_design}[
        sys.argv[1]
    ](*sys.argv[2:])
