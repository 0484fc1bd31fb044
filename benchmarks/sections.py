"""The measurements of `make bench`, one function each: they run things in turn, and put ratios into the report."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

from benchmarks import studies
from benchmarks.machine import ROOT, compiler, lacking
from benchmarks.measure import interleaved, median_ratio, run
from benchmarks.report import Ratio
from benchmarks.setting import TENDON, Bench, designs_in, said_by

LIBRARIES = "import typer, pydantic, numpy, pyarrow.parquet"

_READY_BYTES = 230  # of a state in memory, with some room
_WRITTEN_BYTES = 90  # of a state on the disk


def states_sweep(bench: Bench) -> None:
    """A sweep with both tables against a bare write of them, and against the script of an expert."""
    study = bench.study(studies.states_study(*bench.states))
    states = designs_in(bench.states) * studies.STATES_PER_DESIGN
    bench.report.heading(f"Both tables, {states:,} states (medians of the ratios of {bench.rounds} interleaved rounds)")
    # In memory twice, for the bare write and by the expert's script, and some more while they are being made ready.
    why = lacking(bench.scratch, disk=4 * states * _WRITTEN_BYTES, memory=2.5 * states * _READY_BYTES)
    if why is not None:
        bench.report.add(
            Ratio("tendon / bare write", None, 1.25, note=why),
            Ratio("expert's script / tendon", None, 3.0, "at least", note=why),
            Ratio("tendon's peak memory / the expert's", None, 0.125, note=why),
        )
        return
    first = bench.fresh("first")
    bench.sweep(study, keep=first)  # also warms the file cache
    with bench.bare_writer(first) as write:
        shutil.rmtree(first)
        _states_rounds(bench, study, write)


def _states_rounds(bench: Bench, study: Path, write: Callable[[], dict[str, float]]) -> None:
    sweeps, writes, scripts = [], [], []
    script, table = Path(__file__).with_name("expert.py"), bench.scratch / "expert.parquet"

    def tendon() -> float:
        sweeps.append(bench.sweep(study))
        return sweeps[-1][0].seconds

    def bare() -> float:
        writes.append(write())
        return writes[-1]["seconds"]

    def expert() -> float:
        scripts.append(run([sys.executable, str(script), str(table), *map(str, bench.states)]))
        table.unlink()
        return scripts[-1].seconds

    ours, bares, experts = interleaved(bench.rounds, tendon, bare, expert)
    inside = [seconds for _, seconds in sweeps]
    on_disk = [taken["seconds"] + taken["flush"] for taken in writes]
    peak, theirs = max(cost.memory for cost, _ in sweeps) / 1e6, min(cost.memory for cost in scripts) / 1e6
    bench.report.seconds |= {
        "states: tendon": ours, "states: tendon by run.json": inside, "states: bare write": bares,
        "states: bare write with fsync": on_disk, "states: expert's script": experts,
    }  # fmt: skip
    bench.report.memory |= {"states: tendon": peak, "states: expert's script": theirs}
    bench.report.add(
        Ratio("tendon / bare write", median_ratio(ours, bares), 1.25, note=f"{min(ours):.2f} s, {min(bares):.2f} s"),
        Ratio("without tendon's start-up / bare write", median_ratio(inside, bares), note=f"{min(inside):.2f} s"),
        Ratio(
            "tendon / bare write with fsync", median_ratio(ours, on_disk), note=f"{min(on_disk):.2f} s; tendon's has it"
        ),
        Ratio("expert's script / tendon", median_ratio(experts, ours), 3.0, "at least", f"{min(experts):.2f} s"),
        Ratio("tendon's peak memory / the expert's", peak / theirs, 0.125, note=f"{peak:.0f} MB, {theirs:.0f} MB"),
    )


def designs_sweep(bench: Bench) -> None:
    """A sweep with only the designs table against a process that imports the libraries and writes the ready table."""
    study = bench.study(studies.designs_study(*bench.designs))
    designs = designs_in(bench.designs)
    size = f"{designs:,} designs, {designs * studies.STATES_PER_DESIGN:,} states"
    bench.report.heading(f"Designs only, {size} (median of the ratios of {bench.rounds} interleaved pairs)")
    first, target = bench.fresh("first"), bench.fresh("ready")
    bench.sweep(study, keep=first)

    def rival() -> float:
        started = time.monotonic()
        said = said_by("rivals", "ready_table", first, target, bench.threads)
        return float(said["ended"] - started - said["reading"])

    ours, theirs = interleaved(bench.rounds, lambda: bench.sweep(study)[0].seconds, rival)
    bench.report.seconds |= {"designs: tendon": ours, "designs: imports and ready table": theirs}
    note = f"{min(ours):.2f} s, {min(theirs):.2f} s"
    bench.report.add(Ratio("tendon / imports and write of the ready table", median_ratio(ours, theirs), 2.5, note=note))


def kernel_share(bench: Bench) -> None:
    """The kernel alone against a fused loop in C over the same states."""
    pairs = f"median of the ratios of {bench.rounds} interleaved pairs"
    bench.report.heading(f"Kernel alone, {bench.threads} threads each ({pairs})")
    study = bench.study(studies.designs_study(*bench.kernel))
    for how, target, environment in (("compiled", 0.4, {}), ("in NumPy alone", 0.1, {"TENDON_NO_COMPILED": "1"})):
        name = f"tendon's states per second, {how} / C's"
        if compiler() is None:
            bench.report.add(Ratio(name, None, target, "at least", "skipped: no C compiler (cc)"))
            continue
        said = said_by("kernel", study, bench.scratch, bench.threads, bench.rounds, **environment)
        bench.report.seconds |= {f"kernel: tendon, {how}": said["tendon"], f"kernel: C, beside {how}": said["c"]}
        ours, theirs = (said["states"] / min(said[side]) / 1e6 for side in ("tendon", "c"))
        note = f"{ours:.0f} M/s, {theirs:.0f} M/s; cc {said['options']}"
        bench.report.add(Ratio(name, median_ratio(said["c"], said["tendon"]), target, "at least", note))


def memory(bench: Bench) -> None:
    """Peak memory of the whole process tree as studies grow."""
    bench.report.heading("Peak memory of the process tree (one run each; flat is half of the range over its middle)")
    peaks = {size: _peak(bench, f"memory: {size}", text) for size, text in bench.growing.items()}
    low, high = min(peaks.values()), max(peaks.values())
    note = "; ".join(f"{size}: {peak:.0f} MB" for size, peak in peaks.items())
    bench.report.add(Ratio("flat within", (high - low) / (high + low), 0.1, note=note))
    bench.report.add(Ratio("highest peak / 500 MB", high / 500.0, 1.0, note=f"{high:.0f} MB"))


def _peak(bench: Bench, name: str, text: str) -> float:
    cost, _ = bench.sweep(bench.study(text), watch_tree=True)
    bench.report.seconds[name], bench.report.memory[name] = [cost.seconds], cost.tree / 1e6
    return cost.tree / 1e6


def start_up(bench: Bench) -> None:
    """A small study and the help against the imports that they cannot do without."""
    bench.report.heading(f"Start-up (ratios of the minima of {bench.small_rounds} interleaved runs)")
    fig07 = ROOT / "configs" / "paper" / "fig07.toml"
    python = [sys.executable, "-c"]
    names = ("small study (Fig. 7)", "imports of its libraries", "tendon --help", "import typer")
    taken = interleaved(
        bench.small_rounds,
        lambda: bench.sweep(fig07)[0].seconds,
        lambda: run([*python, LIBRARIES]).seconds,
        lambda: run([*TENDON, "--help"]).seconds,
        lambda: run([*python, "import typer"]).seconds,
    )
    bench.report.seconds |= {f"start-up: {name}": seconds for name, seconds in zip(names, taken, strict=True)}
    small, libraries, helped, typer = map(min, taken)
    bench.report.add(
        Ratio(
            "small study / importing its libraries", small / libraries, 1.5, note=f"{small:.3f} s, {libraries:.3f} s"
        ),
        Ratio("tendon --help / import typer", helped / typer, 1.3, note=f"{helped:.3f} s, {typer:.3f} s"),
    )


def plain_script(bench: Bench) -> None:
    """What most would write: joblib over designs, on a sample of them."""
    bench.report.heading("joblib over designs, by its rate on 2,000 of them (one run each, tendon's median of above)")
    for what, text, designs in (
        ("states", studies.states_study(*bench.states), designs_in(bench.states)),
        ("designs", studies.designs_study(*bench.designs), designs_in(bench.designs)),
    ):
        ours = bench.report.seconds.get(f"{what}: tendon")
        if not ours:
            continue
        said = said_by("rivals", "joblib_per_design", bench.study(text), bench.fresh("plain.parquet"), 2000)
        theirs = said["seconds"] / said["designs"] * designs
        bench.report.seconds[f"{what}: joblib over {said['designs']} designs"] = [said["seconds"]]
        note = f"{theirs:.0f} s by its rate"
        bench.report.add(Ratio(f"joblib over designs / tendon, {what} study", theirs / median(ours), note=note))
