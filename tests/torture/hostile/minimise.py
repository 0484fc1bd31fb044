"""Of many files those few that between them reach all that the many do, short ones rather than long ones.

    python -m hostile.minimise KIND CORPUS FOLDER...

FOLDERs are `found` of `hostile.guided`; what they and CORPUS/KIND hold that reaches lines of tendon in an order that
no other does is kept in CORPUS/KIND, the rest of it is deleted. Needs no atheris.
"""

import contextlib
import hashlib
import sys
import tempfile
from collections import Counter
from pathlib import Path

from .attempts import ATTEMPTS
from .seeds import seeds


def reached(attempt, file):
    """Every step from a line of tendon to the next one that an attempt takes."""
    steps = set()

    def watch(frame, event, _argument):
        if "tendon_cli" not in frame.f_code.co_filename:
            return None
        last = [0]

        def step(frame, event, _argument):
            if event == "line":
                steps.add((frame.f_code.co_filename, last[0], frame.f_lineno))
                last[0] = frame.f_lineno
            return step

        return step

    sys.settrace(watch)
    try:
        with contextlib.suppress(Exception):
            attempt(file)
    finally:
        sys.settrace(None)
    return steps


def needed(reach, covered):
    """Of contents, each with what it reaches, those without which something would not be reached: the long go first."""
    kept = sorted(reach, key=lambda content: (-len(content), content))
    times = Counter(step for content in kept for step in reach[content] - covered)
    for content in list(kept):
        mine = reach[content] - covered
        if all(times[step] > 1 for step in mine):
            times.subtract(mine)
            kept.remove(content)
    return kept


def minimise(kind, corpus, folders):
    """Leave in the corpus of a kind what adds to the files that every run starts from."""
    attempt, place = ATTEMPTS[kind], corpus / kind
    place.mkdir(parents=True, exist_ok=True)
    candidates = {file.read_bytes() for folder in (place, *folders) for file in folder.iterdir()}
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch, f"case.{kind}")

        def steps_of(content):
            file.write_bytes(content)
            return reached(attempt, file)

        covered = set().union(*map(steps_of, seeds(kind)))
        kept = needed({content: steps_of(content) for content in candidates}, covered)
    for file in place.iterdir():
        file.unlink()
    for content in kept:
        (place / f"{hashlib.sha256(content).hexdigest()[:12]}.{kind}").write_bytes(content)


if __name__ == "__main__":
    minimise(sys.argv[1], Path(sys.argv[2]), [Path(folder) for folder in sys.argv[3:]])
