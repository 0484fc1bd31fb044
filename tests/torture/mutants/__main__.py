"""Make random mutants of the package and say which of them no quick test notices.

Every mutant stands in a copy of the source tree. It first answers many commands (`probe`), with
compiled code and without; if an answer or a file has changed the tests of its room run, and if they
pass all quick tests. Survivors of these are what the tests miss: the exit code is 1 if there are
more than 3 in 100. Figures are left out: their layout is judged by eye.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from .change import Mutant, mutant, mutants

ROOT = Path(__file__).parents[3]
LEFT_OUT = ("figures", "reports", "version.py", "__main__.py")
ROOMS = {
    "model": ("model", "paper", "sweep"),
    "studies": ("study", "people"),
    "units.py": ("test_units.py", "study"),
    "quantities.py": ("study", "figures"),
    "tables": ("tables", "sweep"),
    "files.py": ("tables",),
    "windows": ("design", "people"),
    "answers": ("design",),
    "space": ("sweep", "people"),
    "engine": ("sweep", "cluster"),
    "checks": ("check",),
}
"""Tests of a room that come first, before those of the command line; else those of its name."""
ALLOWED = 0.03
"""Share of mutants that may survive."""
MEMORY = 6 << 30
"""Most memory of a process, bytes."""


def main() -> int:
    """Try `count` mutants and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--room", help="only this room or file of the package")
    parser.add_argument(
        "--no-rest", action="store_true", help="run only the tests of the mutant's room"
    )
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        survivors = try_all(copied(Path(folder) / "tree"), options)
    summary = f"{len(survivors)} of {options.count} change an answer or a file and survive"
    print_lines(summary, *survivors)
    return int(len(survivors) > ALLOWED * options.count)


def try_all(copy: Path, options: argparse.Namespace) -> list[str]:
    """Return a line for each mutant that users would meet and no test notices."""
    truth = {compiled: probed(copy, compiled=compiled) for compiled in (True, False)}
    if None in truth.values() or truth[True] != probed(copy, compiled=True):
        raise SystemExit(
            "the answers of the package itself differ from run to run: nothing can be compared"
        )
    survivors = []
    for number, (file, made) in enumerate(sample(copy / "tendon_cli", options), start=1):
        original = file.read_text(encoding="utf-8")
        file.write_text(made.source, encoding="utf-8")
        room = file.relative_to(copy).parts[1]
        line = f"{file.relative_to(copy)}:{made.line}: {made.before!r} -> {made.after!r}"
        is_changed = any(
            probed(copy, compiled=compiled) != truth[compiled] for compiled in (True, False)
        )
        if not is_changed:
            verdict = "changes nothing that users get"
        elif is_caught(copy, room, rest=not options.no_rest):
            verdict = "caught"
        else:
            verdict = "SURVIVES"
            survivors.append(line)
        print_lines(f"{number:3} {verdict}: {line}")
        file.write_text(original, encoding="utf-8")
    return survivors


def is_caught(copy: Path, room: str, *, rest: bool) -> bool:
    """Return True if a test of a room, of the command line or, with `rest`, any other fails."""
    names = (*ROOMS.get(room, (room,)), "cli")
    if not passes(copy, *(f"tests/{name}" for name in names)):
        return True
    return rest and not passes(copy, "tests")


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
    return copy


def sample(package: Path, options: argparse.Namespace) -> Iterator[tuple[Path, Mutant]]:
    """Yield mutants drawn evenly from every place of the package that can be changed."""
    rng = random.Random(options.seed)  # noqa: S311 - nothing is guarded
    places = []
    for file in sorted(package.rglob("*.py")):
        room = file.relative_to(package).parts[0]
        if room not in LEFT_OUT and options.room in (None, room):
            places += [(file, place) for place in mutants(file.read_text(encoding="utf-8"))]
    for file, place in rng.sample(places, options.count):
        yield file, mutant(file.read_text(encoding="utf-8"), place, rng.randrange(1 << 30))


def compiled_code(tree: Path) -> list[Path]:
    """Return the files of compiled code in a source tree."""
    return [*(tree / "tendon_cli").rglob("_*.so")]


def probed(copy: Path, *, compiled: bool) -> str | None:
    """Return the answers of the package in the copy; None if it gives none."""
    with tempfile.TemporaryDirectory(dir=copy.parent) as place:
        (Path(place) / "configs").symlink_to(copy / "configs")
        environment = {} if compiled else {"TENDON_NO_COMPILED": "1"}
        probe = str(copy / "tests/torture/mutants/probe.py")
        return printed_by(copy, [probe], place, 300, environment)


def passes(copy: Path, *tests: str) -> bool:
    """Return True if the tests pass; those that do not exist are left out."""
    existing = [test for test in tests if (copy / test).exists()]
    words = ["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not torture", *existing]
    words += ["--ignore", "tests/test_bench.py"]
    return printed_by(copy, words, copy, 1800, {}) is not None


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
