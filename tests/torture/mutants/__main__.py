"""Make random mutants of the package and say which of them no quick test notices.

Every mutant stands in a copy of the source tree, at a line that `probe` runs. It first answers the
commands of `probe`: if an answer, a file or the data of a figure has changed, the tests of its room
run and those that import it, and if they pass all quick tests.
Survivors of these are what the tests miss: the exit code is 1 if there are more than 3 in 100, and
with `--no-rest`, which runs the tests of the room only, more than 20 in 100.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from .change import Mutant, mutant, mutants

ROOT = Path(__file__).parents[3]
PROBE = "tests/torture/mutants/probe.py"
LEFT_OUT = ("version.py", "__main__.py")
ROOMS = {
    "model": ("model", "kernel", "sweep"),
    "kernel": ("kernel", "sweep"),
    "studies": ("study", "people"),
    "space": ("sweep", "people"),
    "engine": ("sweep", "tables", "cluster"),
    "tables": ("tables", "sweep"),
    "cube": ("cube", "figures", "report"),
    "windows": ("design", "people"),
    "proof": ("proof", "design"),
    "answers": ("design", "people"),
    "answer_record.py": ("design",),
    "checks": ("check",),
    "reports": ("report",),
    "state_page": ("cli/test_state_numbers.py", "cli/test_motor_page.py", "people"),
    "say": ("test_say.py", "design"),
    "face.py": ("test_face.py", "test_in_a_notebook.py"),
    "display.py": ("test_in_a_notebook.py", "test_face.py"),
    "registry.py": ("test_registry.py",),
    "files.py": ("test_files.py", "tables"),
    "cells.py": ("study", "friction"),
    "units.py": ("test_units.py", "study"),
    "quantities.py": ("study", "figures"),
    "arms.py": ("test_face.py", "design"),
}
"""Tests of a room, which come first; else those of its name, or those of the command line."""
ALLOWED = 0.03
"""Share of mutants that may survive all tests."""
ALLOWED_BY_ROOM = 0.2
"""Share of mutants that may survive the tests of their room."""
MEMORY = 6 << 30
"""Most memory of a process, bytes."""


PROBE_SECONDS = 900
TEST_SECONDS = 1800
"""Time after which a process counts as failed, s."""


@dataclass(frozen=True)
class Truth:
    """Answers of the package itself, with compiled code or without."""

    is_compiled: bool
    folder: Path
    """Answers and files, as `probe` keeps them."""
    lines: list[dict[str, list[int]]]
    """Lines that each command runs, by file of the package."""

    def reaching(self, made: Mutant, file: str) -> list[int]:
        """Return the numbers of the commands that run a line of the mutant's statement.

        A module is imported by the first command that needs it, but what stands outside functions
        concerns all.
        """
        found = []
        for number, lines in enumerate(self.lines):
            if any(line in made.lines for line in lines.get(file, ())):
                found.append(number)
        if found and not made.is_in_function:
            return list(range(len(self.lines)))
        return found


@dataclass(frozen=True)
class Trial:
    """A mutant, and what became of it."""

    number: int
    line: str
    verdict: str
    """Begins with `nothing` if users get the same, with `noticed`, or is `SURVIVES`."""

    @property
    def text(self) -> str:
        return f"{self.number:3} {self.verdict}: {self.line}"


def main() -> int:
    """Try mutants until `count` of them change what users get, and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60, help="mutants that change what users get")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="mutants that are tried at once")
    parser.add_argument("--plain", action="store_true", help="probe without compiled code, too")
    parser.add_argument("--room", help="only this room or file of the package")
    parser.add_argument("--only", help="only these mutants, by number, such as 3,17")
    parser.add_argument(
        "--no-rest", action="store_true", help="run only the tests of the mutant's room"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        trials = try_all(Path(folder), options)
    changed = [trial for trial in trials if not trial.verdict.startswith("nothing")]
    survivors = [trial for trial in changed if trial.verdict == "SURVIVES"]
    print_lines(
        f"{len(changed)} of {len(trials)} change an answer, a file or a figure;"
        f" {len(survivors)} of these survive",
        *(trial.text for trial in survivors),
    )
    allowed = ALLOWED_BY_ROOM if options.no_rest else ALLOWED
    return int(len(survivors) > allowed * len(changed))


def try_all(folder: Path, options: argparse.Namespace) -> list[Trial]:
    """Return what became of each mutant, in the order in which they ended."""
    copies = [copied(folder / str(job) / "tree") for job in range(options.jobs)]
    kinds = (True, False) if options.plain else (True,)
    truths = [truth_of(copies[0], compiled=compiled) for compiled in kinds]
    package = copies[0] / "tendon_cli"
    originals = {file: file.read_text(encoding="utf-8") for file in sorted(package.rglob("*.py"))}
    names = {str(file.relative_to(package)): text for file, text in originals.items()}
    queue = sample(names, truths, options)
    guard = threading.Lock()
    trials: list[Trial] = []

    def changed() -> int:
        return sum(not trial.verdict.startswith("nothing") for trial in trials)

    def next_drawn() -> tuple[int, str, Mutant] | None:
        with guard:
            return next(queue, None) if changed() < options.count else None

    def work(copy: Path) -> None:
        while (drawn := next_drawn()) is not None:
            number, name, made = drawn
            file = copy / "tendon_cli" / name
            file.write_text(made.source, encoding="utf-8")
            verdict = verdict_on(copy, name, made, truths, rest=not options.no_rest)
            file.write_text(names[name], encoding="utf-8")
            line = f"tendon_cli/{name}:{made.line}: {made.before!r} -> {made.after!r}"
            trial = Trial(number, line, verdict)
            trials.append(trial)
            print_lines(f"{changed():3} {trial.text}")

    with ThreadPoolExecutor(options.jobs) as pool:
        for ended in [pool.submit(work, copy) for copy in copies]:
            ended.result()
    return trials


def truth_of(copy: Path, *, compiled: bool) -> Truth:
    """Return what the package itself gives, or leave if that differs from run to run."""
    folder = copy.parent / ("compiled" if compiled else "plain")
    if probed(copy, str(folder), compiled=compiled) is None:
        raise SystemExit("the package itself cannot be probed")
    difference = probed(copy, str(folder), "--compare", "--trace", compiled=compiled)
    if difference is None or difference.strip():
        raise SystemExit(f"the package itself differs from run to run: {difference}")
    lines = json.loads((folder / "lines.json").read_text(encoding="utf-8"))
    return Truth(compiled, folder, lines)


def verdict_on(copy: Path, name: str, made: Mutant, truths: list[Truth], *, rest: bool) -> str:
    """Return what becomes of the mutant that stands in a copy."""
    for truth in truths:
        if numbers := truth.reaching(made, name):
            words = ("--compare", "--commands", ",".join(map(str, numbers)))
            difference = probed(copy, str(truth.folder), *words, compiled=truth.is_compiled)
            if difference is None or difference.strip():
                break
    else:
        return "nothing changes"
    changed = "it cannot be probed" if difference is None else difference.strip()
    start = time.monotonic()
    is_noticed = is_caught(copy, name, rest=rest)
    seconds = time.monotonic() - start
    print_lines(f"      {name}:{made.line} changes {changed[:80]} ({seconds:.0f} s of tests)")
    return "noticed" if is_noticed else "SURVIVES"


def is_caught(copy: Path, name: str, *, rest: bool) -> bool:
    """Return True if a test that imports a file, one of its room or, with `rest`, any fails."""
    room = Path(name).parts[0]
    of_room = [f"tests/{test}" for test in ROOMS.get(room, (room,))]
    if not any((copy / test).exists() for test in of_room):
        of_room = ["tests/cli"]
    if not passes(copy, *importing(copy, name), *of_room):
        return True
    return rest and not passes(copy, "tests")


def importing(copy: Path, name: str) -> list[str]:
    """Return the test files that import a file of the package."""
    module = name.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    parent, _, last = f"tendon_cli.{module}".rpartition(".")
    pattern = re.compile(
        rf"^(from|import) {re.escape(parent)}\.{last}\b"
        rf"|^from {re.escape(parent)} import .*\b{last}\b",
        re.MULTILINE,
    )
    tests = sorted((copy / "tests").rglob("test_*.py"))
    found = [test for test in tests if pattern.search(test.read_text(encoding="utf-8"))]
    return [str(test.relative_to(copy)) for test in found if "torture" not in test.parts]


def copied(copy: Path) -> Path:
    """Copy the files that git knows and the compiled code; the working tree is never touched."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout
    names = [Path(name) for name in listed.split("\0") if name]
    names += [file.relative_to(ROOT) for file in compiled_code(ROOT)]
    for name in names:
        if (ROOT / name).is_file():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name)
    # Compiled once; a mutant is compiled anew, for its file is younger.
    words = ["-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider", "tests"]
    printed_by(copy, words, copy, TEST_SECONDS, {"PYTHONDONTWRITEBYTECODE": ""})
    printed_by(copy, ["-m", "compileall", "-q", "tendon_cli"], copy, TEST_SECONDS, {})
    return copy


def sample(
    sources: dict[str, str], truths: list[Truth], options: argparse.Namespace
) -> Iterator[tuple[int, str, Mutant]]:
    """Yield number, file and fault of mutants drawn evenly from all places that the probe runs.

    Args:
        sources: Sources of the package by file.
        truths: What the package itself runs.
        options: Options of the command.
    """
    rng = random.Random(options.seed)  # noqa: S311 - nothing is guarded
    wanted = {int(number) for number in options.only.split(",")} if options.only else None
    places = []
    for name, source in sources.items():
        room = Path(name).parts[0]
        if room not in LEFT_OUT and options.room in (None, room):
            places += [(name, place) for place in mutants(source)]
    rng.shuffle(places)
    number = 0
    for name, place in places:
        made = mutant(sources[name], place, rng.randrange(1 << 30))
        if any(truth.reaching(made, name) for truth in truths):
            number += 1
            if wanted is None or number in wanted:
                yield number, name, made


def compiled_code(tree: Path) -> list[Path]:
    """Return the files of compiled code in a source tree."""
    return [*(tree / "tendon_cli").rglob("_*.so")]


def probed(copy: Path, *words: str, compiled: bool) -> str | None:
    """Return what `probe` prints of the package in the copy; None if it cannot be probed."""
    with tempfile.TemporaryDirectory(dir=copy.parent) as place:
        (Path(place) / "configs").symlink_to(copy / "configs")
        environment = {} if compiled else {"TENDON_NO_COMPILED": "1"}
        return printed_by(copy, [str(copy / PROBE), *words], place, PROBE_SECONDS, environment)


def passes(copy: Path, *tests: str) -> bool:
    """Return True if the tests pass, in their order; those that do not exist are left out."""
    existing = [test for test in dict.fromkeys(tests) if (copy / test).exists()]
    words = ["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not torture", *existing]
    words += ["--ignore", "tests/test_bench.py"]
    return printed_by(copy, words, copy, TEST_SECONDS, {}) is not None


def printed_by(
    copy: Path, words: list[str], place: Path | str, seconds: int, more: dict[str, str]
) -> str | None:
    """Return the output of Python with the package of the copy; None if it fails.

    Args:
        copy: Copy of the source tree.
        words: Arguments of Python.
        place: Folder in which it runs.
        seconds: Time after which it counts as failed, s.
        more: Further environment variables.
    """
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"} | more
    try:
        ended = subprocess.run(
            [sys.executable, *words],
            cwd=place,
            env=environment,
            check=False,
            capture_output=True,
            text=True,
            timeout=seconds,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)),
        )
    except subprocess.TimeoutExpired:
        return None
    return ended.stdout if ended.returncode == 0 else None


def print_lines(*lines: str) -> None:
    """Print lines at once, though the output may go into a file."""
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
