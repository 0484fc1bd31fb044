"""`python -m verification.paper [FOLDER]`: reproduce the paper into results/paper; `make paper`."""

import sys
from pathlib import Path

from tendon_cli.errors import EXIT_NEGATIVE, TendonError
from tendon_cli.startup import stopped_by_signals
from tendon_cli.terminal import print_error, print_result, progress
from verification.paper.reproduce import reproduce


def main(arguments: list[str]) -> int:
    """Write the paper's page and figures, and return the exit code: 4 if a finding fails."""
    out = Path(*arguments or ("results", "paper"))
    try:
        with (
            stopped_by_signals(str(out), "make paper") as stop,
            progress("paper", quiet=False) as show,
        ):
            done = reproduce(out, progress=show.parts, stop=stop)
    except TendonError as error:
        print_error(error, as_json=False)
        return error.exit
    print_result(done.text())
    return 0 if done.holds else EXIT_NEGATIVE


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
