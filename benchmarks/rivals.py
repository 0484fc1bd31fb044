"""Rivals of tendon, each run in a process of its own: `python -m benchmarks.rivals NAME ...`.

`bare_write` and `ready_table` are the machine's limit: a table that is ready in memory, written by
pyarrow as tendon writes it (row groups, encoding of each column, compression, statistics, page
checksums) and by as many threads, but to one file a thread, without fsync, SHA-256, footer check,
footers and record. Pages have the library's own length, with which encoding takes a quarter longer
than with tendon's. `joblib_per_design` is a plain script.
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
_PLAIN_ENCODINGS = {"PLAIN", "RLE", "BIT_PACKED"}


def encoding_of(file: Path) -> dict[str, Any]:
    """Return the encoding of a table file, by its footer, as arguments of pyarrow's writer."""
    import pyarrow.parquet as pq

    footer = pq.read_metadata(file)
    group = footer.row_group(0)
    columns = [group.column(index) for index in range(group.num_columns)]
    compression = {}
    with_dictionary = []
    special_encodings = {}
    with_statistics = []
    for column in columns:
        name = column.path_in_schema
        compression[name] = column.compression
        special = sorted(set(column.encodings) - _PLAIN_ENCODINGS)
        if column.has_dictionary_page:
            with_dictionary.append(name)
        elif special:
            special_encodings[name] = special[0]
        if column.is_stats_set:
            with_statistics.append(name)
    return {
        "version": footer.format_version,
        "row_group_size": group.num_rows,
        "compression": compression,
        "use_dictionary": with_dictionary,
        "column_encoding": special_encodings,
        "write_statistics": with_statistics,
        "write_page_checksum": True,
    }


def table_files(run_folder: Path, table: str) -> list[Path]:
    """Return the files of a table of a run in order: one, those of its parts, or none."""
    path = run_folder / f"{table}.parquet"
    if path.is_dir():
        return sorted(path.glob("part-*.parquet"))
    return [path] if path.exists() else []


def in_memory(files: list[Path]) -> pa.Table:
    """Read files as one table, each column in one piece."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    parts = [pq.ParquetFile(file).read().replace_schema_metadata() for file in files]
    table = pa.concat_tables(parts)
    for index, field in enumerate(table.schema):
        table = table.set_column(index, field, table.column(index).combine_chunks())
    return table


class Ready:
    """Tables of a run in memory, to be written again and again."""

    def __init__(self, run_folder: Path, target: Path, threads: int) -> None:
        self._tables = []
        for name in TABLES:
            files = table_files(run_folder, name)
            if files:
                self._tables.append((in_memory(files), encoding_of(files[0])))
        self._target = target
        self._threads = threads

    def write(self) -> Took:
        """Write each table in as many slices as there are threads."""
        return in_threads(partial(self._slices, thread) for thread in range(self._threads))

    def flush(self) -> float:
        """Wait until all files are on the disk, then remove them; return the waiting time, s."""
        files = sorted(self._target.parent.glob(f"{self._target.name}-*.parquet"))
        started = time.perf_counter()
        for file in files:
            with file.open("rb") as opened:
                os.fsync(opened.fileno())
        waited = time.perf_counter() - started
        for file in files:
            file.unlink()
        return waited

    def _slices(self, thread: int) -> None:
        """Write the slice of one thread of each table."""
        import pyarrow.parquet as pq

        for number, (table, encoding) in enumerate(self._tables):
            start = table.num_rows * thread // self._threads
            stop = table.num_rows * (thread + 1) // self._threads
            file = self._target.with_name(f"{self._target.name}-{number}-{thread}.parquet")
            pq.write_table(table.slice(start, stop - start), file, **encoding)


def bare_write(run_folder: str, target: str, threads: str) -> None:
    """Keep the tables of a run in memory, and write them for every line on standard input.

    Prints the times of each write as JSON.
    """
    ready = Ready(Path(run_folder), Path(target), int(threads))
    print("ready", flush=True)
    for _ in sys.stdin:
        print(json.dumps({**asdict(ready.write()), "flush": ready.flush()}), flush=True)


def ready_table(run_folder: str, target: str, threads: str) -> None:
    """Import what tendon needs for a sweep, and write a table.

    Prints when that ended, how long reading the table took before, and the processor time of all
    else.
    """
    import numpy as np  # noqa: F401
    import pyarrow.parquet as pq  # noqa: F401
    import pydantic  # noqa: F401
    import typer  # noqa: F401

    started = time.monotonic()
    worked = time.process_time()
    ready = Ready(Path(run_folder), Path(target), int(threads))
    reading = time.monotonic() - started
    worked_reading = time.process_time() - worked
    ready.write()
    record = {
        "ended": time.monotonic(),
        "reading": reading,
        "processor": time.process_time() - worked_reading,
    }
    print(json.dumps(record))


def joblib_per_design(study: str, target: str, most: str) -> None:
    """Run the straightforward script: joblib over designs, a small data frame for each.

    All frames are written by one `to_parquet` at the end. Takes the first `most` designs only;
    prints how many, so that the rate can be compared.
    """
    import numpy as np
    import pandas as pd
    from joblib import Parallel, delayed

    from tendon_cli.engine.plan import Plan
    from tendon_cli.studies.load import load_study

    plan = Plan(load_study(Path(study)))
    count = min(plan.designs, int(most))

    def frame_of(design: int) -> pd.DataFrame:
        block = next(plan.blocks(range(design, design + 1)))
        columns = plan.state(block).columns()
        frame = pd.DataFrame(
            {name: np.broadcast_to(values, block.shape).ravel() for name, values in columns.items()}
        )
        frame.insert(0, "design", design)
        return frame if "states" in plan.study.output.tables else frame.agg(["min", "max"])

    started = time.perf_counter()
    worked = time.process_time()
    frames = Parallel(n_jobs=2)(delayed(frame_of)(design) for design in range(count))
    pd.concat(frames).to_parquet(target)
    record = {
        "seconds": time.perf_counter() - started,
        "processor": time.process_time() - worked,
        "designs": count,
    }
    print(json.dumps(record))


_RIVALS = {
    "bare_write": bare_write,
    "ready_table": ready_table,
    "joblib_per_design": joblib_per_design,
}

if __name__ == "__main__":
    name, *arguments = sys.argv[1:]
    _RIVALS[name](*arguments)
