"""Measurements of `make bench`, one function each: it puts its ratios into the report."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

from benchmarks import studies
from benchmarks.machine import compiler, lacking
from benchmarks.measure import Cost, Times, Took, interleaved, run
from benchmarks.report import Ratio
from benchmarks.setting import Bench, designs_in, record_of

_READY_BYTES = 230  # of a state in memory, with some room
_WRITTEN_BYTES = 90  # of a state on the disk


def states_sweep(bench: Bench) -> None:
    """Measure a sweep with both tables against a bare write, and the script of an expert."""
    study = bench.study(studies.states_study(*bench.states))
    states = designs_in(bench.states) * studies.STATES_PER_DESIGN
    rounds = f"medians of the ratios of {bench.rounds} interleaved rounds"
    bench.report.heading(f"Both tables, {states:,} states ({rounds})")
    # In memory twice, for the bare write and by the expert's script, and some more while they are
    # being made ready.
    why = lacking(
        bench.scratch, disk=4 * states * _WRITTEN_BYTES, memory=2.5 * states * _READY_BYTES
    )
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
    """Run tendon, the bare write and the script of the expert in turn."""
    sweeps: list[tuple[Cost, float]] = []
    flushes: list[float] = []
    scripts: list[Cost] = []
    script = Path(__file__).with_name("expert.py")
    table = bench.scratch / "expert.parquet"

    def tendon() -> Took:
        cost, seconds_by_record = bench.sweep(study)
        sweeps.append((cost, seconds_by_record))
        return cost

    def bare() -> Took:
        times = write()
        flushes.append(times.pop("flush"))
        return Took(**times)

    def expert() -> Took:
        cost = run([sys.executable, str(script), str(table), *map(str, bench.states)])
        scripts.append(cost)
        table.unlink()
        return cost

    ours, bares, experts = interleaved(bench.rounds, tendon, bare, expert)
    inside = Times(tuple(Took(seconds, cost.processor) for cost, seconds in sweeps))
    flushed = [
        Took(took.seconds + flush, took.processor)
        for took, flush in zip(bares.runs, flushes, strict=True)
    ]
    on_disk = Times(tuple(flushed))
    peak = max(cost.memory for cost, _ in sweeps) / 1e6
    experts_peak = min(cost.memory for cost in scripts) / 1e6
    bench.report.times |= {
        "states: tendon": ours,
        "states: tendon by run.json": inside,
        "states: bare write": bares,
        "states: bare write with fsync": on_disk,
        "states: expert's script": experts,
    }
    bench.report.memory |= {"states: tendon": peak, "states: expert's script": experts_peak}
    bench.report.add(
        Ratio.of("tendon / bare write", ours, bares, 1.25),
        Ratio.of("without tendon's start-up / bare write", inside, bares),
        Ratio.of("tendon / bare write with fsync", ours, on_disk, note="tendon's has it"),
        Ratio.of("expert's script / tendon", experts, ours, 3.0, "at least"),
        Ratio(
            "tendon's peak memory / the expert's",
            peak / experts_peak,
            0.125,
            note=f"{peak:.0f} MB, {experts_peak:.0f} MB",
        ),
    )


def motion_in_time(bench: Bench) -> None:
    """Measure a sweep along a trajectory against as many states at a constant speed."""
    pretensions, ratios = bench.motion
    states = pretensions * ratios * studies.SAMPLES
    bench.report.heading(
        f"Along a trajectory, {states:,} states ({bench.rounds} interleaved pairs)"
    )
    studies.swing(bench.scratch / "swing.csv")
    along = bench.study(studies.motion_study(pretensions, ratios, motion=studies.ALONG))
    still = bench.study(studies.motion_study(pretensions, ratios, motion=studies.STILL))
    pairs = interleaved(bench.rounds, lambda: bench.sweep(along)[0], lambda: bench.sweep(still)[0])
    bench.report.times |= {"motion: along": pairs[0], "motion: at a speed": pairs[1]}
    bench.report.add(Ratio.of("along a trajectory / at a speed", *pairs, 2.0))


def kept_columns(bench: Bench) -> None:
    """Measure a sweep that keeps three columns of its states against one that keeps them all."""
    whole = studies.states_study(*bench.states)
    states = designs_in(bench.states) * studies.STATES_PER_DESIGN
    bench.report.heading(
        f"Three columns of {states:,} states against all ({bench.rounds} interleaved pairs)"
    )
    few = bench.study(whole + studies.KEPT)
    every = bench.study(whole)
    size: dict[Path, int] = {}

    def swept(study: Path) -> Took:
        folder = bench.fresh("kept")
        cost, _ = bench.sweep(study, keep=folder)
        size[study] = sum(file.stat().st_size for file in folder.rglob("*.parquet"))
        shutil.rmtree(folder)
        return cost

    ours, theirs = interleaved(bench.rounds, lambda: swept(few), lambda: swept(every))
    bench.report.times |= {"kept: three columns": ours, "kept: all columns": theirs}
    note = f"{size[few] / 1e6:.0f} MB, {size[every] / 1e6:.0f} MB"
    bench.report.add(
        Ratio.of("three columns of states / all", ours, theirs, 0.5),
        Ratio("disk of three columns / of all", size[few] / size[every], 0.5, note=note),
    )


def designs_sweep(bench: Bench) -> None:
    """Measure a sweep with only the designs table against imports and a bare write of it."""
    study = bench.study(studies.designs_study(*bench.designs))
    designs = designs_in(bench.designs)
    size = f"{designs:,} designs, {designs * studies.STATES_PER_DESIGN:,} states"
    bench.report.heading(
        f"Designs only, {size} (median of the ratios of {bench.rounds} interleaved pairs)"
    )
    first = bench.fresh("first")
    target = bench.fresh("ready")
    bench.sweep(study, keep=first)

    def rival() -> Took:
        started = time.monotonic()
        record = record_of("rivals", "ready_table", first, target, bench.threads)
        seconds = record["ended"] - started - record["reading"]
        return Took(float(seconds), float(record["processor"]))

    ours, theirs = interleaved(bench.rounds, lambda: bench.sweep(study)[0], rival)
    bench.report.times |= {"designs: tendon": ours, "designs: imports and ready table": theirs}
    bench.report.add(Ratio.of("tendon / imports and write of the ready table", ours, theirs, 2.5))


def kernel_share(bench: Bench) -> None:
    """Measure the kernel alone against a fused loop in C over the same states."""
    pairs = f"median of the ratios of {bench.rounds} interleaved pairs"
    bench.report.heading(f"Kernel alone, {bench.threads} threads each ({pairs})")
    designs = studies.designs_study(*bench.kernel)
    windows = studies.windows_study(*bench.windows)
    for how, text, target, environment in (
        ("compiled", designs, 0.4, {}),
        ("in NumPy alone", designs, 0.1, {"TENDON_NO_COMPILED": "1"}),
        ("windows", windows, 0.5, {}),
    ):
        name = f"tendon's states per second, {how} / C's"
        if compiler() is None:
            bench.report.add(Ratio(name, None, target, "at least", "skipped: no C compiler (cc)"))
            continue
        record = record_of(
            "kernel", bench.study(text), bench.scratch, bench.threads, bench.rounds, **environment
        )
        ours = Times(tuple(Took(**run) for run in record["tendon"]))
        theirs = Times(tuple(Took(**run) for run in record["c"]))
        bench.report.times |= {f"kernel: tendon, {how}": ours, f"kernel: C, beside {how}": theirs}
        our_rate = record["states"] / min(ours.seconds) / 1e6
        their_rate = record["states"] / min(theirs.seconds) / 1e6
        note = f"tendon {our_rate:.0f} M/s, C {their_rate:.0f} M/s; cc {record['options']}"
        # The rate of tendon over that of C is the time of C over that of tendon.
        bench.report.add(Ratio.of(name, theirs, ours, target, "at least", note))


def lock(bench: Bench) -> None:
    """Measure the time for which a part holds Python's lock, beside the time that it takes."""
    bench.report.heading(
        f"Python's lock, a part with both tables in one thread (median of {bench.lock_parts} parts)"
    )
    study = bench.study(studies.states_study(*bench.many_parts))
    folder = bench.fresh("lock")
    record = record_of("lock", study, folder, bench.lock_parts)
    shutil.rmtree(folder)
    processor = record["processor"]
    held = record["held"]
    note = (
        f"{1e3 * processor:.0f} ms of processor time for {record['states']:,} states, "
        f"so {processor / held:.0f} cores at most"
    )
    bench.report.add(Ratio("ms under Python's lock for each part", 1e3 * held, 5.0, note=note))


def memory(bench: Bench) -> None:
    """Measure peak memory as studies grow."""
    bench.report.heading("Peak memory as studies grow (one run each)")
    peaks = {size: _peak(bench, f"memory: {size}", text) for size, text in bench.growing.items()}
    largest = list(peaks)[-1]
    grows = peaks[largest] / peaks[studies.MANY_PARTS]
    note = "; ".join(f"{size}: {peak:.0f} MB" for size, peak in peaks.items())
    bench.report.add(Ratio(f"peak of {largest} / of {studies.MANY_PARTS}", grows, 1.1, note=note))
    high = max(peaks.values())
    bench.report.add(Ratio("highest peak / 500 MB", high / 500.0, 1.0, note=f"{high:.0f} MB"))


def _peak(bench: Bench, name: str, text: str) -> float:
    """Run a study, and return its peak of memory, MB."""
    cost, _ = bench.sweep(bench.study(text))
    peak = cost.memory / 1e6
    bench.report.times[name] = Times((cost,))
    bench.report.memory[name] = peak
    return peak


def plain_script(bench: Bench) -> None:
    """Measure the script that most would write: joblib over designs, on a sample of them."""
    bench.report.heading(
        "joblib over designs, by its rate on 2,000 of them (one run each, tendon's median of above)"
    )
    for what, text, designs in (
        ("states", studies.states_study(*bench.states), designs_in(bench.states)),
        ("designs", studies.designs_study(*bench.designs), designs_in(bench.designs)),
    ):
        ours = bench.report.times.get(f"{what}: tendon")
        if not ours:
            continue
        record = record_of(
            "rivals", "joblib_per_design", bench.study(text), bench.fresh("plain.parquet"), 2000
        )
        count = record.pop("designs")
        bench.report.times[f"{what}: joblib over {count} designs"] = Times((Took(**record),))
        seconds = record["seconds"] / count * designs
        processor = record["processor"] / count * designs
        bench.report.add(
            Ratio(
                f"joblib over designs / tendon, {what} study",
                seconds / median(ours.seconds),
                note=f"{seconds:.0f} s by its rate",
                processor=processor / median(ours.processor),
            )
        )
