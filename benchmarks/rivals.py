"""What tendon is measured against; each is run as a process of its own: `python -m benchmarks.rivals NAME ...`."""

from __future__ import annotations

import json
import sys
import threading
import time
from pathlib import Path


def bare_write(run_folder: str, target: str) -> dict[str, float]:
    """The machine's limit: the same tables, already in memory, written by bare pyarrow with the same encoding.

    Two threads, one file each; only the writing is timed.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    seconds = 0.0
    for path in sorted(Path(run_folder).glob("*.parquet")):
        table = pq.read_table(path).combine_chunks()
        halves = [table.slice(0, table.num_rows // 2), table.slice(table.num_rows // 2)]
        results = [
            field.name
            for field in table.schema
            if field.type == pa.float64() and table.schema.names.index(field.name) >= _first_result(table.schema.names)
        ]
        options = {
            "compression": "snappy",
            "use_dictionary": [name for name in table.schema.names if name not in results],
            "column_encoding": dict.fromkeys(results, "BYTE_STREAM_SPLIT"),
            "write_statistics": False,
            "row_group_size": 2**17,
        }
        threads = [
            threading.Thread(target=pq.write_table, args=(half, f"{target}-{index}.parquet"), kwargs=options)
            for index, half in enumerate(halves)
        ]
        started = time.perf_counter()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        seconds += time.perf_counter() - started
    return {"seconds": seconds}


def _first_result(names: list[str]) -> int:
    return names.index("status") if "status" in names else names.index("min_flexor_tension")


def joblib_per_design(study: str, target: str, most: str) -> dict[str, float]:
    """The straightforward script: joblib over designs, a small data frame each, one `to_parquet` at the end.

    Takes the first `most` designs only; says how many, so that the rate can be compared.
    """
    import pandas as pd
    from joblib import Parallel, delayed

    from tendon_cli.study.load import load_study
    from tendon_cli.sweep.evaluate import evaluate, state_columns
    from tendon_cli.sweep.inputs import Inputs
    from tendon_cli.sweep.plan import Plan

    plan = Plan(load_study(Path(study)))
    inputs = Inputs(plan)
    count = min(plan.designs, int(most))
    states_wanted = "states" in plan.study.output.tables

    def one(design: int) -> pd.DataFrame:
        block = next(plan.blocks(range(design, design + 1)))
        columns = state_columns(evaluate(inputs, block))
        import numpy as np

        frame = pd.DataFrame({name: np.broadcast_to(values, block.shape).ravel() for name, values in columns.items()})
        frame.insert(0, "design", design)
        return frame if states_wanted else frame.agg(["min", "max"])

    started = time.perf_counter()
    frames = Parallel(n_jobs=2)(delayed(one)(design) for design in range(count))
    pd.concat(frames).to_parquet(f"{target}.parquet")
    return {"seconds": time.perf_counter() - started, "designs": count}


if __name__ == "__main__":
    chosen = {"bare_write": bare_write, "joblib_per_design": joblib_per_design}[sys.argv[1]]
    Path(sys.argv[-1]).write_text(json.dumps(chosen(*sys.argv[2:-1])))
