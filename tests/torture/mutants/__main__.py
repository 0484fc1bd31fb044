"""Makes random mutants of the package and says which of them no quick test notices.

Every mutant stands in a copy of the source tree. It first answers many commands (`probe`), with compiled code and
without; if an answer or a file has changed the tests of its room run, and if they pass all quick tests. Survivors of
these are what the tests miss: the exit code is 1 if there are more than 3 in 100. Figures are left out: their layout is
judged by eye.
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
    "answers": ("design",),
    "space": ("sweep", "people"),
    "engine": ("sweep", "cluster"),
    "checks": ("check",),
}
"""Tests that come first, before those of the command line; of any other room those of its name."""
ALLOWED = 0.03
MEMORY = 6 << 30


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
        missed = try_all(copied(Path(folder) / "tree"), options)
    tell(f"{len(missed)} of {options.count} change an answer or a file and survive", *missed)
    return int(len(missed) > ALLOWED * options.count)


def try_all(copy: Path, options: argparse.Namespace) -> list[str]:
    """Those that users would meet and no test does."""
    truth = {compiled: probed(copy, compiled=compiled) for compiled in (True, False)}
    if None in truth.values() or truth[True] != probed(copy, compiled=True):
        raise SystemExit(
            "the answers of the package itself differ from run to run: nothing can be compared"
        )
    missed = []
    for number, (file, made) in enumerate(sample(copy / "tendon_cli", options), start=1):
        original = file.read_text(encoding="utf-8")
        file.write_text(made.source, encoding="utf-8")
        room = file.relative_to(copy).parts[1]
        line = f"{file.relative_to(copy)}:{made.line}: {made.before!r} -> {made.after!r}"
        changed = any(probed(copy, compiled=way) != truth[way] for way in (True, False))
        survives = changed and passes(
            copy, *(f"tests/{name}" for name in (*ROOMS.get(room, (room,)), "cli"))
        )
        survives = survives and (options.no_rest or passes(copy, "tests"))
        verdict = (
            "SURVIVES" if survives else "caught" if changed else "changes nothing that users get"
        )
        tell(f"{number:3} {verdict}: {line}")
        missed += [line] if survives else []
        file.write_text(original, encoding="utf-8")
    return missed


def copied(copy: Path) -> Path:
    """What git knows of and the compiled code, so that nothing of the working tree is ever touched."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout
    for name in [
        *filter(None, listed.split("\0")),
        *(file.relative_to(ROOT) for file in compiled_code(ROOT)),
    ]:
        if (ROOT / name).is_file():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name)
    return copy


def sample(package: Path, options: argparse.Namespace) -> Iterator[tuple[Path, Mutant]]:
    """Mutants drawn evenly from every place of the package that can be changed."""
    chance = random.Random(options.seed)  # noqa: S311 - nothing is guarded
    places = []
    for file in sorted(package.rglob("*.py")):
        room = file.relative_to(package).parts[0]
        if room not in LEFT_OUT and options.room in (None, room):
            places += [(file, place) for place in mutants(file.read_text(encoding="utf-8"))]
    for file, place in chance.sample(places, options.count):
        yield file, mutant(file.read_text(encoding="utf-8"), place, chance.randrange(1 << 30))


def compiled_code(tree: Path) -> list[Path]:
    return [*(tree / "tendon_cli").rglob("_*.so")]


def probed(copy: Path, *, compiled: bool) -> str | None:
    """The answers of the package in the copy; None where it gives none."""
    with tempfile.TemporaryDirectory(dir=copy.parent) as place:
        (Path(place) / "configs").symlink_to(copy / "configs")
        environment = {} if compiled else {"TENDON_NO_COMPILED": "1"}
        return ran(copy, [str(copy / "tests/torture/mutants/probe.py")], place, 300, environment)


def passes(copy: Path, *tests: str) -> bool:
    """Whether those of the tests pass that there are."""
    there = [test for test in tests if (copy / test).exists()]
    words = ["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not torture", *there]
    return ran(copy, [*words, "--ignore", "tests/test_bench.py"], copy, 1800, {}) is not None


def ran(
    copy: Path, words: list[str], place: Path | str, seconds: int, more: dict[str, str]
) -> str | None:
    """What Python prints; None where it fails or takes too long. It imports the package of the copy."""
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"} | more
    try:
        done = subprocess.run(
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
    return done.stdout if done.returncode == 0 else None


def tell(*lines: str) -> None:
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
