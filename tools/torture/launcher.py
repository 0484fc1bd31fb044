"""The command in a process of its own, made to run in small parts and to wait at chosen points.

    python launcher.py SETTINGS WORDS...

SETTINGS is a JSON object:

- `parts` is the length of parts, so that a short run has many;
- `hold` is a point at which the run makes the file `held` and waits for `seconds`, once it has
  passed the point `skip` times;
- `go` names the runner: it makes the file `go-RUNNER`, then waits for the file `go` before anything
  begins;
- `offline` lets nothing touch the network.
"""

import itertools
import json
import os
import sys
import time
from pathlib import Path


def hold(owner, name, settings):
    """Let a function wait, as a slow disk or a large part would."""
    function = getattr(owner, name)
    calls = itertools.count()

    def slow(*arguments, **options):
        if next(calls) >= settings["skip"]:
            if name == "fill":
                arguments[0].check_stopped()  # a run that is asked to stop begins no part
            Path("held").touch()
            until = time.monotonic() + settings["seconds"]
            while time.monotonic() < until:
                time.sleep(0.01)
        return function(*arguments, **options)

    setattr(owner, name, slow)


NETWORK = (
    "socket.connect",
    "socket.bind",
    "socket.getaddrinfo",
    "socket.gethostbyname",
    "socket.sendto",
)


def forbid_network(event, _arguments):
    """End the process with a code that nothing else has if it reaches for the network."""
    if event in NETWORK:
        sys.stderr.write(f"network: {event}\n")
        os._exit(99)


def make_small(settings):
    """Shorten the parts of a run, and hold it at a point if the settings say so."""
    from tendon_cli.answers import choices
    from tendon_cli.engine import folder, plan, sweep

    plan.STATES_PER_FILE = settings["parts"]
    plan.STATES_PER_PART = settings["parts"]
    plan.DESIGNS_PER_PART = settings["parts"]
    choices.CHOICES_PER_PART = 1
    points = {
        "part": [(sweep.Sweep, "fill"), (choices.Choices, "fill")],
        "figures": [(folder.RunFolder, "place_figures")],
        "record": [(folder.RunFolder, "finish")],
    }
    for owner, name in points.get(settings.get("hold"), ()):
        hold(owner, name, settings)


def main():
    """Apply the settings, then run the command."""
    settings = json.loads(sys.argv[1])
    words = sys.argv[2:]
    if settings.get("offline"):
        sys.addaudithook(forbid_network)
    from tendon_cli.commands import cli

    if "parts" in settings:
        make_small(settings)
    if "go" in settings:
        Path(f"go-{settings['go']}").touch()
        while not Path("go").exists():
            time.sleep(0.0005)
    cli.main(words)


if __name__ == "__main__":
    main()
