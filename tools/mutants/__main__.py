"""Make random mutants of the package and say which of them no quick test notices.

Every mutant stands in a copy of the source tree, at a line that `probe` runs. It first answers the
commands of `probe`: if an answer, a file or the data of a figure has changed, the tests of its room
run and those that import it, and if they pass all quick tests.
Survivors of these are what the tests miss: the exit code is 1 if there are more than 3 in 100, and
with `--no-rest`, which runs the tests of the room only, more than 20 in 100.
What tests did not finish in their time is neither noticed nor a survivor, and is named apart.

With `--kept FOLDER` what the package itself gives and what became of each mutant are kept there:
the same command goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

from .change import Mutant, mutant, mutants

ROOT = Path(__file__).parents[2]
PROBE = "tools/mutants/probe.py"
LEFT_OUT = ("version.py", "__main__.py")
ROOMS = {
    "model": ("model", "kernel", "sweep"),
    "kernel": ("kernel", "sweep"),
    "studies": ("study", "rows", "people", "test_face.py", "sweep"),
    "engine": ("sweep", "tables", "cluster", "design", "limits", "people"),
    "tables": ("tables", "sweep"),
    "cube": ("cube", "figures", "report"),
    "proof": ("proof", "design"),
    "answers": ("design", "limits", "rows", "people"),
    "verbs": ("design", "test_registry.py", "test_call_types.py"),
    "checks": ("check",),
    "reports": ("report",),
    "state_page": ("cli/test_state_numbers.py", "cli/test_motor_page.py", "people"),
    "say": ("test_say.py", "test_in_a_notebook.py", "design"),
    "exports": ("exports",),
    "fits": ("friction", "suit_fit"),
    "face.py": ("test_face.py", "test_in_a_notebook.py"),
    "files.py": ("test_files.py", "tables"),
    "units.py": ("test_units.py", "study"),
    "quantities.py": ("study", "figures"),
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
"""Processor time after which a process counts as failed, s."""
CLOCK = 10
"""Longest wait for a process, in units of its processor time."""


@dataclass(frozen=True)
class Truth:
    """Answers of the package itself, with compiled code or without."""

    is_compiled: bool
    folder: Path
    """Answers and files, as `probe` keeps them."""
    lines: dict[int, dict[str, list[int]]]
    """Lines that each command runs, by its number and by file of the package."""
    seconds: dict[int, float]
    """Processor time of each command by its number, s."""
    most: int
    """Number of commands that are compared at most."""

    def reaching(self, made: Mutant, file: str) -> list[int]:
        """Return the numbers of the cheapest commands that run a line of the mutant's statement.

        A module is imported by the first command that needs it, but what stands outside functions
        concerns all.
        """
        found = []
        for number, lines in self.lines.items():
            if any(line in made.lines for line in lines.get(file, ())):
                found.append(number)
        if found and not made.is_in_function:
            found = list(self.lines)
        return sorted(sorted(found, key=self.seconds.__getitem__)[: self.most])


@dataclass(frozen=True)
class Trial:
    """A mutant, and what became of it."""

    number: int
    line: str
    verdict: str
    """Begins with `nothing` if users get the same, with `noticed`, `SURVIVES` or `unfinished`."""

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
    parser.add_argument(
        "--room", help="only these rooms or files of the package, such as exports,model/moving.py"
    )
    parser.add_argument("--commands", help="probe only these commands, by number, such as 0,27-40")
    parser.add_argument(
        "--most", type=int, default=1000, help="compare only so many of a mutant's commands"
    )
    parser.add_argument(
        "--test-seconds",
        type=int,
        default=TEST_SECONDS,
        help="processor time after which a mutant's tests count as unfinished, s",
    )
    parser.add_argument("--kept", type=Path, help="folder that keeps what is found")
    parser.add_argument("--only", help="only these mutants, by number, such as 3,17")
    parser.add_argument(
        "--no-rest", action="store_true", help="run only the tests of the mutant's room"
    )
    options = parser.parse_args()
    if options.kept:
        options.kept.mkdir(parents=True, exist_ok=True)
        trials = try_all(options.kept.resolve(), options)
    else:
        with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
            trials = try_all(Path(folder), options)
    changed = [trial for trial in trials if not trial.verdict.startswith("nothing")]
    survivors = [trial for trial in changed if trial.verdict == "SURVIVES"]
    unfinished = [trial for trial in changed if trial.verdict == "unfinished"]
    print_lines(
        f"{len(changed)} of {len(trials)} change an answer, a file or a figure;"
        f" {len(survivors)} of these survive, tests of {len(unfinished)} did not finish",
        *(trial.text for trial in (*survivors, *unfinished)),
    )
    allowed = ALLOWED_BY_ROOM if options.no_rest else ALLOWED
    return int(len(survivors) > allowed * len(changed))


def try_all(folder: Path, options: argparse.Namespace) -> list[Trial]:
    """Return what became of each mutant, in the order in which they ended."""
    copies = [copied(folder / str(job) / "tree") for job in range(options.jobs)]
    kinds = (True, False) if options.plain else (True,)
    truths = [truth_of(copies[0], options, compiled=compiled) for compiled in kinds]
    package = copies[0] / "tendon_cli"
    sources = {
        str(file.relative_to(package)): file.read_text(encoding="utf-8")
        for file in sorted(package.rglob("*.py"))
    }
    queue = sample(sources, truths, options)
    guard = threading.Lock()
    log = folder / "trials.jsonl"
    known = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
    trials = [Trial(**json.loads(line)) for line in known]
    tried = {trial.number for trial in trials}

    def changed() -> int:
        return sum(not trial.verdict.startswith("nothing") for trial in trials)

    def next_drawn() -> tuple[int, str, Mutant] | None:
        with guard:
            if changed() >= options.count:
                return None
            return next((drawn for drawn in queue if drawn[0] not in tried), None)

    def work(copy: Path) -> None:
        while (drawn := next_drawn()) is not None:
            number, name, made = drawn
            file = copy / "tendon_cli" / name
            file.write_text(made.source, encoding="utf-8")
            verdict = verdict_on(copy, name, made, truths, options)
            file.write_text(sources[name], encoding="utf-8")
            line = f"tendon_cli/{name}:{made.line}: {made.before!r} -> {made.after!r}"
            trial = Trial(number, line, verdict)
            trials.append(trial)
            with log.open("a", encoding="utf-8") as kept:
                kept.write(json.dumps(asdict(trial)) + "\n")
            print_lines(f"{changed():3} {trial.text}")

    with ThreadPoolExecutor(options.jobs) as pool:
        for ended in [pool.submit(work, copy) for copy in copies]:
            ended.result()
    return trials


def truth_of(copy: Path, options: argparse.Namespace, *, compiled: bool) -> Truth:
    """Return what the package itself gives, or leave if that differs from run to run."""
    folder = copy.parent / ("compiled" if compiled else "plain")
    words = [str(folder)]
    if options.commands:
        words += ["--commands", ",".join(map(str, numbers_in(options.commands)))]
    if not (folder / "lines.json").exists():
        folder.mkdir(exist_ok=True)
        if probed(copy, *words, compiled=compiled) is None:
            raise SystemExit("the package itself cannot be probed")
        difference = probed(copy, *words, "--compare", "--trace", compiled=compiled)
        if difference is None or difference.strip():
            raise SystemExit(f"the package itself differs from run to run: {difference}")
    lines = json.loads((folder / "lines.json").read_text(encoding="utf-8"))
    seconds = json.loads((folder / "seconds.json").read_text(encoding="utf-8"))
    return Truth(
        compiled,
        folder,
        {int(number): files for number, files in lines.items()},
        {int(number): value for number, value in seconds.items()},
        options.most,
    )


def numbers_in(text: str) -> list[int]:
    """Return the numbers of a list such as 0,27-40."""
    numbers: list[int] = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        numbers += range(int(first), int(last or first) + 1)
    return numbers


def verdict_on(
    copy: Path, name: str, made: Mutant, truths: list[Truth], options: argparse.Namespace
) -> str:
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
    is_noticed = is_caught(copy, name, options)
    seconds = time.monotonic() - start
    print_lines(f"      {name}:{made.line} changes {changed[:80]} ({seconds:.0f} s of tests)")
    if is_noticed is None:
        return "unfinished"
    return "noticed" if is_noticed else "SURVIVES"


def is_caught(copy: Path, name: str, options: argparse.Namespace) -> bool | None:
    """Return True if a test that imports a file, one of its room or, with the rest, any fails.

    Return None if the tests did not finish and none has failed before.
    """
    room = Path(name).parts[0]
    of_room = [f"tests/{test}" for test in ROOMS.get(room, (room,))]
    if not any((copy / test).exists() for test in of_room):
        of_room = ["tests/cli"]
    has_passed = passes(copy, options.test_seconds, *importing(copy, name), *of_room)
    if has_passed and not options.no_rest:
        has_passed = passes(copy, options.test_seconds, "tests")
    return None if has_passed is None else not has_passed


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
    if (copy / "tendon_cli/__pycache__").exists():
        return copy
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
    rooms = options.room.split(",") if options.room else None
    places = []
    for name, source in sources.items():
        room = Path(name).parts[0]
        is_wanted = rooms is None or room in rooms or name in rooms
        if room not in LEFT_OUT and is_wanted:
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


def passes(copy: Path, seconds: int, *tests: str) -> bool | None:
    """Return True if the tests pass, in their order; None if they do not finish.

    Tests that do not exist are left out.
    """
    existing = [test for test in dict.fromkeys(tests) if (copy / test).exists()]
    words = ["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not torture", *existing]
    words += ["--ignore", "tests/test_bench.py"]
    ended = ended_by(copy, words, copy, seconds, {})
    if ended is None or ended.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        return None
    return ended.returncode == 0


def printed_by(
    copy: Path, words: list[str], place: Path | str, seconds: int, more: dict[str, str]
) -> str | None:
    """Return the output of Python with the package of the copy; None if it fails."""
    ended = ended_by(copy, words, place, seconds, more)
    return ended.stdout if ended is not None and ended.returncode == 0 else None


def ended_by(
    copy: Path, words: list[str], place: Path | str, seconds: int, more: dict[str, str]
) -> subprocess.CompletedProcess[str] | None:
    """Return the ended process of Python with the package of the copy; None if it hangs.

    Args:
        copy: Copy of the source tree.
        words: Arguments of Python.
        place: Folder in which it runs.
        seconds: Processor time after which it is ended, s.
        more: Further environment variables.
    """
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"} | more

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))

    try:
        return subprocess.run(
            [sys.executable, *words],
            cwd=place,
            env=environment,
            check=False,
            capture_output=True,
            text=True,
            timeout=CLOCK * seconds,
            preexec_fn=limit,
        )
    except subprocess.TimeoutExpired:
        return None


def print_lines(*lines: str) -> None:
    """Print lines at once, though the output may go into a file."""
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
