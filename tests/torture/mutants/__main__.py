"""Makes random mutants of the package and says which of them no quick test notices.

Every mutant stands in a copy of the source tree. It first answers many commands (`probe`), with compiled code and
without; where an answer or a file has changed the tests of its room run, and where they pass all quick tests.
Survivors of these are what the tests miss: the exit code is 1 where there are more than 3 in 100. Figures are left out:
their layout is judged by eye.
"""

from __future__ import annotations

import argparse
import json
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
    "model": ("tests/model", "tests/paper", "tests/sweep", "tests/cli/test_commands.py"),
    "studies": ("tests/study", "tests/cli", "tests/people"),
    "units.py": ("tests/test_units.py", "tests/study"),
    "quantities.py": ("tests/test_units.py", "tests/study", "tests/figures"),
    "tables": ("tests/tables", "tests/sweep"),
    "files.py": ("tests/tables", "tests/cli"),
    "answers": ("tests/design", "tests/cli"),
    "space": ("tests/sweep", "tests/people"),
    "engine": ("tests/sweep", "tests/cluster", "tests/cli"),
    "checks": ("tests/check",),
}
"""Tests that come first; of any other room those of its own name, and the command line's."""
ALLOWED = 0.03
MEMORY = 6 << 30


def main() -> int:
    """Try `count` mutants and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--room", help="only this room or file of the package")
    parser.add_argument("--no-rest", action="store_true", help="run only the tests of the mutant's room")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        copy = Path(folder) / "tree"
        _copy_tree(copy)
        missed = _try_all(copy, options)
    share = len(missed) / options.count
    _say(f"{len(missed)} of {options.count} change an answer or a file and survive ({100 * share:.0f} %)", *missed)
    return int(share > ALLOWED)


def _try_all(copy: Path, options: argparse.Namespace) -> list[str]:
    truth = {compiled: _probe(copy, compiled=compiled) for compiled in (True, False)}
    if None in truth.values() or truth[True] != _probe(copy, compiled=True):
        raise SystemExit("the answers of the package itself differ from run to run: nothing can be compared")
    missed = []
    for number, (file, made) in enumerate(_sample(copy, options), start=1):
        original = file.read_text(encoding="utf-8")
        file.write_text(made.source, encoding="utf-8")
        name = file.relative_to(copy)
        line = f"{name}:{made.line}: {made.before!r} -> {made.after!r}"
        changed = next(filter(None, (_changes(truth[way], _probe(copy, compiled=way)) for way in (True, False))), "")
        rooms = _tests_of(copy, name)
        missing = changed and _passes(copy, rooms) and (options.no_rest or _passes(copy, ["tests"]))
        verdict = "SURVIVES" if missing else "caught" if changed else "changes nothing that users get"
        _say(f"{number:3} {verdict}: {line}" + (f"  [{changed}]" if verdict == "SURVIVES" else ""))
        if verdict == "SURVIVES":
            missed.append(line)
        file.write_text(original, encoding="utf-8")
    return missed


def _copy_tree(copy: Path) -> None:
    """What git knows of and the compiled code, so that nothing of the working tree is ever touched."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    for name in [*filter(None, listed.split("\0")), *(str(file.relative_to(ROOT)) for file in _compiled(ROOT))]:
        if (ROOT / name).is_file():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name)


def _sample(copy: Path, options: argparse.Namespace) -> Iterator[tuple[Path, Mutant]]:
    """Mutants drawn evenly from every place of the package that can be changed."""
    package = copy / "tendon_cli"
    chance = random.Random(options.seed)  # noqa: S311 - nothing is guarded
    places = []
    for file in sorted(package.rglob("*.py")):
        room = file.relative_to(package).parts[0]
        if room not in LEFT_OUT and options.room in (None, room):
            places += [(file, place) for place in mutants(file.read_text(encoding="utf-8"))]
    for file, place in chance.sample(places, options.count):
        yield file, mutant(file.read_text(encoding="utf-8"), place, chance.randrange(1 << 30))


def _tests_of(copy: Path, name: Path) -> list[str]:
    room = name.parts[1]
    wanted = ROOMS.get(room, (f"tests/{room}", "tests/cli"))
    return [test for test in wanted if (copy / test).exists()]


def _compiled(tree: Path) -> list[Path]:
    return [*(tree / "tendon_cli").rglob("_*.so")]


def _probe(copy: Path, *, compiled: bool) -> dict[str, str] | None:
    """The answers of the package in the copy; None where it gives none."""
    if not compiled:
        code = _compiled(copy)
        away = [file.rename(file.with_suffix(".off")) for file in code]
        try:
            return _probe(copy, compiled=True)
        finally:
            for file, off in zip(code, away, strict=True):
                off.rename(file)
    with tempfile.TemporaryDirectory(dir=copy.parent) as place:
        (Path(place) / "configs").symlink_to(copy / "configs")
        said = _run(copy, [sys.executable, copy / "tests" / "torture" / "mutants" / "probe.py"], place, 300)
    if said is None or not said.startswith("{"):
        return None
    answers: dict[str, str] = json.loads(said)
    return answers


def _changes(truth: dict[str, str] | None, answers: dict[str, str] | None) -> str:
    """Which answers differ, in few words; nothing where none does."""
    if answers is None or truth is None:
        return "nothing is answered"
    differing = [name for name in truth | answers if truth.get(name) != answers.get(name)]
    return "; ".join(differing[:2])


def _passes(copy: Path, tests: list[str]) -> bool:
    if not tests:
        return True
    words = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not torture", *tests]
    return _run(copy, [*words, "--ignore", "tests/test_bench.py"], copy, 1800) is not None


def _run(copy: Path, words: list[str | Path], place: Path | str, seconds: int) -> str | None:
    """What a command prints; None where it fails or takes too long. It imports the package of the copy."""
    environment = os.environ | {"PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(
            words, cwd=place, env=environment, check=False, capture_output=True, text=True, timeout=seconds,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)),
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return None
    return done.stdout if done.returncode == 0 else None


def _say(*lines: str) -> None:
    sys.stdout.write("\n".join(lines) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
