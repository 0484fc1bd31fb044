"""Measure start-up: a small study, the help, figures and `import`, beside needed imports."""

from __future__ import annotations

import sys
from collections.abc import Callable

from benchmarks import studies
from benchmarks.machine import ROOT
from benchmarks.measure import Times, Took, interleaved, run
from benchmarks.report import Ratio
from benchmarks.setting import TENDON, Bench

# `import pydantic` alone imports nothing.
LIBRARIES = "import typer, numpy, pyarrow.parquet; from pydantic import BaseModel"
MATPLOTLIB = "import matplotlib.figure, matplotlib.backends.backend_agg"


def start_up(bench: Bench) -> None:
    """Measure a small study, the help and the library against the imports that they need."""
    bench.report.heading(
        f"Start-up (ratios of the minima of {bench.small_rounds} interleaved runs)"
    )
    fig07 = ROOT / "configs" / "paper" / "fig07.toml"
    small, libraries, helped, typer, library = _measured(
        bench,
        {
            "small study (Fig. 7)": lambda: bench.sweep(fig07)[0],
            "imports of its libraries": _python(LIBRARIES),
            "tendon --help": lambda: run([*TENDON, "--help"]),
            "import typer": _python("import typer"),
            "import tendon_cli": _python("import tendon_cli"),
        },
    )
    beyond_typer = (min(library.seconds) - min(typer.seconds)) * 1e3
    worked = (min(library.processor) - min(typer.processor)) * 1e3
    bench.report.add(
        _of_minima("small study / importing its libraries", small, libraries, 1.5),
        _of_minima("tendon --help / import typer", helped, typer, 1.3),
        Ratio("import tendon_cli beyond import typer, ms", beyond_typer, 10.0, processor=worked),
    )


def fresh_sample(bench: Bench) -> None:
    """Measure what judging one choice by 10,000 fresh persons adds to an answer."""
    bench.report.heading(
        f"Fresh sample of 10,000 for one choice (of the minima of"
        f" {bench.small_rounds} interleaved runs)"
    )
    study = bench.study(studies.ONE_SUIT)

    def answered(verify: int) -> Took:
        folder = bench.fresh("answer")
        setting = ["--set", f"design.verify={verify}"]
        words = ["design", str(study), "--out", str(folder), "--quiet", "--no-figures", *setting]
        return run([*TENDON, *words])

    judged, alone = _measured(
        bench,
        {
            "answer with a fresh sample": lambda: answered(10_000),
            "answer without one": lambda: answered(0),
        },
    )
    more = min(judged.seconds) - min(alone.seconds)
    worked = min(judged.processor) - min(alone.processor)
    note = f"{min(judged.seconds):.2f} s, {min(alone.seconds):.2f} s"
    bench.report.add(
        Ratio("seconds more for the fresh sample", more, 1.0, note=note, processor=worked)
    )


def suit_logs(bench: Bench) -> None:
    """Measure what fitting a suit to its logs takes of the processor, imports included."""
    bench.report.heading("Fit of a suit to its own logs, processor time over its target")
    folder = ROOT / "configs" / "suit"
    short = folder / "suit_log.csv"
    header, *rows = short.read_text(encoding="utf-8").splitlines()
    long = bench.fresh("logs.csv")
    every = 10**6 // len(rows)
    with long.open("w", encoding="utf-8") as file:
        file.write(f"{header}\n")
        for row in rows:
            time, _, rest = row.partition(",")
            file.writelines(f"{float(time) + 6e-5 * part:.6f},{rest}\n" for part in range(every))
    for name, log, target in (("1,600 rows", short, 5.0), ("a million rows", long, 30.0)):
        took = run([*TENDON, "fit-suit", str(folder / "suit.toml"), str(log)])
        note = f"{took.processor:.1f} s of processor time, {target:.0f} s at most"
        bench.report.add(Ratio(name, took.processor / target, 1.0, note=note))


def figures(bench: Bench) -> None:
    """Measure what drawing adds to a sweep, against importing the library that draws."""
    bench.report.heading(
        f"Figures of the quickstart (of the minima of {bench.small_rounds} interleaved runs)"
    )
    study = ROOT / "configs" / "quickstart.toml"
    drawn, bare, imports, nothing = _measured(
        bench,
        {
            "quickstart with figures": lambda: bench.sweep(study, figures=True)[0],
            "quickstart without figures": lambda: bench.sweep(study)[0],
            "import matplotlib": _python(f"import numpy; {MATPLOTLIB}"),
            "import numpy": _python("import numpy"),
        },
    )
    ours = min(drawn.seconds) - min(bare.seconds)
    theirs = min(imports.seconds) - min(nothing.seconds)
    worked = min(drawn.processor) - min(bare.processor)
    needed = min(imports.processor) - min(nothing.processor)
    note = f"{ours:.3f} s, {theirs:.3f} s, both less what comes before"
    bench.report.add(
        Ratio(
            "drawing / importing matplotlib",
            ours / theirs,
            1.5,
            note=note,
            processor=worked / needed,
        )
    )


def _measured(bench: Bench, sides: dict[str, Callable[[], Took]]) -> list[Times]:
    """Run the sides in turn, and put their times into the report."""
    times_of_sides = interleaved(bench.small_rounds, *sides.values())
    bench.report.times |= {
        f"start-up: {name}": times for name, times in zip(sides, times_of_sides, strict=True)
    }
    return times_of_sides


def _python(code: str) -> Callable[[], Took]:
    """Return a function that runs code as a whole process."""
    return lambda: run([sys.executable, "-c", code])


def _of_minima(name: str, above: Times, below: Times, target: float) -> Ratio:
    """Return the ratio of the shortest runs: whatever disturbs a start-up makes it longer."""
    ours = min(above.seconds)
    theirs = min(below.seconds)
    processor = min(above.processor) / min(below.processor)
    note = f"{ours:.3f} s, {theirs:.3f} s"
    return Ratio(name, ours / theirs, target, note=note, processor=processor)
