"""The files that reached something new, tried again, in a process of its own so that its memory can be measured.

    python -W error -m hostile.replay CORPUS FOLDER

CORPUS has a folder for each kind of file. Leaves `tally.json` in FOLDER, as `hostile.fuzz` does.
"""

import contextlib
import signal
import sys
from pathlib import Path

from .attempts import ATTEMPTS
from .tally import Tally, too_slow


def replay(corpus, folder):
    """All kinds, one after the other, in one tally."""
    signal.signal(signal.SIGALRM, too_slow)
    tally = Tally(folder, None)
    for kind, attempt in ATTEMPTS.items():
        tally.attempt = attempt
        for file in sorted((corpus / kind).iterdir()):
            tally.meet(file.suffix, file.read_bytes())
    tally.save()


if __name__ == "__main__":
    with contextlib.redirect_stdout(sys.stderr):
        replay(Path(sys.argv[1]), Path(sys.argv[2]))
