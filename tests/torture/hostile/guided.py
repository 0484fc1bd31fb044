"""Hostile files bred by what they reach: those that come to new branches of tendon have offspring (atheris, libFuzzer).

    python -m hostile.guided KIND CASES FOLDER [CORPUS]

KIND is `toml`, `yaml`, `csv` or `parquet`. Leaves `tally.json` in FOLDER, as `hostile.fuzz` does, and in `found` every
file that reached something new. Ends with a code of libFuzzer's where a case hangs or ends the process.
"""

import contextlib
import os
import random
import resource
import sys
from pathlib import Path

import atheris

from .attempts import ATTEMPTS
from .edits import edited
from .forge import forged
from .seeds import TOKENS, dictionary, seeds
from .tally import Tally

SECONDS = 60
INSTRUMENTED = ["tendon_cli", "tomllib", "ruamel.yaml"]
LONGEST = {"toml": 8192, "yaml": 4096, "csv": 8192, "parquet": 65536}


def edit(chance):
    """One of `edited`."""
    return tuple(map(chance.randrange, (8, 2**20, 41, 2**16)))


def breeder(kind):
    """How a file of a kind becomes another: edits line by line, libFuzzer's own, and of tables ones that hold."""
    good = seeds(kind)

    def breed(content, most, seed):
        chance = random.Random(seed)  # noqa: S311 - a repeatable sample

        def mutate(piece):
            return atheris.Mutate(bytes(piece), min(most, len(piece) + 64))

        if kind != "parquet" and chance.random() < 0.3:  # what is bred from faults alone is seldom taken
            return edited(chance.choice(good), [edit(chance)], TOKENS[kind])[:most]
        if kind == "parquet":
            found = forged(content, chance, mutate) if chance.random() < 0.9 else mutate(content)
        elif chance.random() < 0.4:
            found = edited(content, [edit(chance) for _ in range(chance.randrange(1, 4))], TOKENS[kind])
        else:
            found = mutate(content)
        return found if len(found) <= most else content

    return breed


def prepare(kind, attempt, folder):
    """Instrument all that a file of a kind comes to, by letting good ones come to it."""
    before = [name for name in sys.modules if name.partition(".")[0] in {"tendon_cli", "tomllib", "ruamel"}]
    assert not before, f"{before} are not watched any more"
    with atheris.instrument_imports(include=INSTRUMENTED):
        for number, content in enumerate(seeds(kind)):
            file = folder / "seeds" / f"{number}.{kind}"
            file.write_bytes(content)
            with contextlib.suppress(Exception):  # a fault is a matter for the tally
                attempt(file)


def fuzz(kind, cases, folder, corpus):
    """All cases; ends the process after the last, with its tally written."""
    attempt = ATTEMPTS[kind]
    for name in ("seeds", "found"):
        (folder / name).mkdir()
    with contextlib.redirect_stdout(sys.stderr):
        prepare(kind, attempt, folder)
    (folder / "words").write_text(dictionary(kind), encoding="ascii")
    tally = Tally(folder, attempt, longest=None)

    def one(content):
        tally.meet(f".{kind}", content)
        if tally.cases >= cases:
            tally.save()
            os._exit(0)  # libFuzzer would print and leave with a code of its own

    most = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (16 << 30, most))  # the machine's memory is not the case's to take
    options = [
        "-seed=1", f"-max_len={LONGEST[kind]}", f"-timeout={SECONDS}", "-rss_limit_mb=0", "-len_control=0",
        "-mutate_depth=2", f"-dict={folder / 'words'}", f"-artifact_prefix={folder}/",
    ]  # fmt: skip
    folders = [str(folder / "found"), str(folder / "seeds"), *map(str, corpus)]
    atheris.Setup([sys.argv[0], *options, *folders], one, custom_mutator=breeder(kind))
    atheris.Fuzz()


if __name__ == "__main__":
    fuzz(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]), sys.argv[4:])
