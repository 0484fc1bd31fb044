"""Hostile files by the thousand, in a process of its own so that its memory can be measured.

    python -W error -m tools.torture.hostile.fuzz KIND CASES FOLDER
        Files bred by chance from good files.
    python -m tools.torture.hostile.fuzz KIND CASES FOLDER --guided [WORDS]
        Files bred by what they reach: those that come to new branches of tendon have offspring
        (atheris, libFuzzer).
    python -W error -m tools.torture.hostile.fuzz valid FIRST:CASES FOLDER
        Valid studies by chance, from a seed on, each answered, swept and held to what is true.
    python -W error -m tools.torture.hostile.fuzz replay CORPUS FOLDER
        Files of a corpus, which once reached something new.

KIND is `toml`, `yaml`, `csv` or `parquet`. Leaves `tally.json` in FOLDER: how many cases were
refused or taken, the slowest, the peak of memory, and each kind of fault that is not a refusal,
with a file that brings it about; guided also `found`, files that reached something new. WORDS are
for libFuzzer, for instance folders of a corpus.
"""

import contextlib
import json
import os
import random
import resource
import signal
import sys
from pathlib import Path

from .attempts import ATTEMPTS
from .breed import breeder
from .seeds import seeds
from .tally import LONGEST_ANSWER, MOST_MEGABYTES_OF_AN_ANSWER, Tally, too_slow
from .truths import try_valid
from .valid import FILES, Maker

SECONDS = 60
MOST_BYTES = {"toml": 8192, "yaml": 4096, "csv": 8192, "parquet": 65536}


def by_chance(kind, cases, folder):
    """Try cases that are bred by chance, each from a good file."""
    good = seeds(kind)
    breed = breeder(kind, good)
    rng = random.Random(1)  # noqa: S311 - a repeatable sample
    tally = Tally(folder, ATTEMPTS[kind])
    for _ in range(cases):
        content = breed(rng.choice(good), rng)
        tally.meet(f".{kind}", content[: MOST_BYTES[kind]])
    tally.save()


def valid(seeds_tried, folder):
    """Try the valid studies of some seeds."""
    for name, text in FILES.items():
        (folder / name).write_text(text, "utf-8")
    tally = Tally(folder, try_valid, LONGEST_ANSWER, MOST_MEGABYTES_OF_AN_ANSWER)
    for seed in seeds_tried:
        content = json.dumps(Maker(seed).study(), indent=1)
        tally.meet(".yaml", content.encode())
    tally.save()


def replay(corpus, folder):
    """Try the files of all kinds in a corpus, in one tally."""
    tally = Tally(folder, attempt=None)
    for kind, attempt in ATTEMPTS.items():
        tally.attempt = attempt
        for file in sorted((corpus / kind).iterdir()):
            tally.meet(file.suffix, file.read_bytes())
    tally.save()


def guided(kind, cases, folder, words):
    """Try cases that are bred by what they reach.

    The process ends after the last with its tally written, or with a code of libFuzzer's.
    """
    import atheris

    attempt = ATTEMPTS[kind]
    good_files = folder / "seeds"
    reached = folder / "found"
    good_files.mkdir()
    reached.mkdir()
    with atheris.instrument_imports(include=["tendon_cli", "tomllib", "ruamel.yaml"]):
        good = seeds(kind)
        # Good files come to all modules that are to be watched.
        for number, content in enumerate(good):
            file = good_files / f"{number}.{kind}"
            file.write_bytes(content)
            with contextlib.suppress(Exception):  # a fault is a matter for the tally
                attempt(file)
    tally = Tally(folder, attempt, longest=0)

    def try_case(content):
        tally.meet(f".{kind}", content)
        if tally.cases >= cases:
            tally.save()
            os._exit(0)  # libFuzzer would print and leave with a code of its own

    def breed_case(content, most, seed):
        def mutate(piece):
            return atheris.Mutate(bytes(piece), min(most, len(piece) + 64))

        breed = breeder(kind, good, mutate)
        bred = breed(content, random.Random(seed))  # noqa: S311 - a repeatable sample
        return bred if len(bred) <= most else content

    _, hard_limit = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (16 << 30, hard_limit))
    options = [
        "-seed=1",
        f"-max_len={MOST_BYTES[kind]}",
        f"-timeout={SECONDS}",
        "-rss_limit_mb=0",
        "-len_control=0",
        "-mutate_depth=2",
        f"-artifact_prefix={folder}/",
    ]
    arguments = [sys.argv[0], *options, str(reached), str(good_files), *words]
    atheris.Setup(arguments, try_case, custom_mutator=breed_case)
    atheris.Fuzz()


def main(kind, cases, folder, *words):
    """Breed by chance, guided, or replay a corpus."""
    signal.signal(signal.SIGPROF, too_slow)
    if kind == "valid":
        first, _, count = cases.partition(":")
        valid(range(int(first), int(first) + int(count)), Path(folder))
    elif kind == "replay":
        replay(Path(cases), Path(folder))
    elif words:
        guided(kind, int(cases), Path(folder), words[1:])
    else:
        by_chance(kind, int(cases), Path(folder))


if __name__ == "__main__":
    random.seed(0)
    with contextlib.redirect_stdout(sys.stderr):
        main(*sys.argv[1:])
