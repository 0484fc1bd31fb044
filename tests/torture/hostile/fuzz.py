"""Hostile files by the thousand, in a process of its own so that its memory can be measured.

    python -W error -m hostile.fuzz KIND CASES FOLDER

KIND is `study`, `friction` or `parquet`. Leaves `tally.json` in FOLDER: how many cases were refused or taken, the
slowest, the peak of memory, and each kind of fault that is not a refusal, with a file that brings it about.
"""

import contextlib
import random
import signal
import sys
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings

from .attempts import try_friction, try_parquet, try_study
from .readings import friction_files
from .studies import study_files
from .tables import parquet_files
from .tally import Tally, too_slow

CHUNK = 500
KINDS = {
    "study": (study_files, try_study),
    "friction": (friction_files, try_friction),
    "parquet": (parquet_files, try_parquet),
}


def main():
    """All cases, in chunks of so many that the generator's own memory stays small."""
    kind, cases, folder = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])
    make, attempt = KINDS[kind]
    tally, files = Tally(folder, attempt), make()
    signal.signal(signal.SIGALRM, too_slow)
    chunk = 0
    while tally.cases < cases:
        chunk += 1

        @seed(chunk)
        @settings(
            max_examples=min(CHUNK, cases - tally.cases), database=None, deadline=None, phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )  # fmt: skip
        @given(files)
        def one(case):
            tally.meet(*case)

        one()
    tally.save()


if __name__ == "__main__":
    random.seed(0)
    with contextlib.redirect_stdout(sys.stderr):
        main()
