"""`python -m tendon_cli` is `tendon`: nothing in the working directory is executed.

Two things are out of its reach: what Python itself has imported by now, and a `tendon_cli` in the
working directory. `python -P` avoids both.
"""

import os  # Python has both already; any other import would look into the working directory
import sys


def main() -> None:
    """Run `tendon`; from here on a signal ends it without a traceback."""
    from tendon_cli.commands.startup import quit_on_signals, spare_time

    quit_on_signals()
    spare_time()
    from tendon_cli.commands.cli import main as run

    run()


if __name__ == "__main__":
    try:
        is_first = sys.path[0] == os.getcwd()  # noqa: PTH109 - pathlib is not imported yet
    except OSError:  # there is none any more
        is_first = False
    if is_first and not sys.flags.safe_path:  # with -P it is first only if PYTHONPATH says so
        del sys.path[0]
    main()
