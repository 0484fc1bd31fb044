"""The command in a process of its own, with parts so small that a short run has many, and stops where it is told to.

    python launcher.py SETTINGS WORDS...

SETTINGS is a JSON object: `states` and `choices` are the lengths of parts; `hold` is a point at which the run makes the
file `held` and waits to be killed, after `skip` times that it passes; `fail` is what cannot be written; `go` is a file
to wait for before anything begins; `offline` lets nothing touch the network; `flock` is the error with which no file
can be locked.
"""

import itertools
import json
import sys
import time
from pathlib import Path

POINTS = {
    "rows": ("tendon_cli.engine.sweep", "state_rows"),
    "figures": ("tendon_cli.engine.folder.RunFolder", "place_figures"),
    "record": ("tendon_cli.engine.folder.RunFolder", "finish"),
    "journal": ("tendon_cli.engine.journal.Journal", "add"),
    "delete": ("tendon_cli.engine.folder.RunFolder", "_delete"),
    "rename": ("pathlib.Path", "replace"),
    "solve": ("tendon_cli.answers.choices", "part_of"),
    "compare": ("tendon_cli.answers.choices", "findings"),
    "last": ("tendon_cli.engine.journal.Journal", "announce_last"),
}


def owner_of(name):
    """A module, or a class in one."""
    import importlib

    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        module, _, inner = name.rpartition(".")
        return getattr(importlib.import_module(module), inner)


def hold(point, marker, seconds, skip):
    """Let a function wait, once it is called so many times, as a slow disk or a large part would."""
    owner, name = owner_of(POINTS[point][0]), POINTS[point][1]
    before, calls = getattr(owner, name), itertools.count()

    def slow(*arguments, **options):
        if next(calls) < skip:
            return before(*arguments, **options)
        Path(marker).touch()
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            time.sleep(0.01)
        return before(*arguments, **options)

    setattr(owner, name, slow)


def full_journal():
    """Let the journal be what does not fit on the disk any more, after a few parts."""
    import errno
    import os

    from tendon_cli.engine.journal import Journal
    from tendon_cli.errors import OutputError

    add = Journal.add

    def limited(self, result):
        if len(self.parts) >= 5:
            raise OutputError(f"cannot be written: {os.strerror(errno.ENOSPC)}", where=str(self.path))
        add(self, result)

    Journal.add = limited


def forbid_network():
    """Whatever reaches for the network ends the process with a code that nothing else has."""
    import os

    touched = ("socket.connect", "socket.bind", "socket.getaddrinfo", "socket.gethostbyname", "socket.sendto")

    def watch(event, _arguments):
        if event in touched:
            sys.stderr.write(f"network: {event}\n")
            os._exit(99)

    sys.addaudithook(watch)


FLOCK = {"x86_64": 73, "aarch64": 32}
"""Number of the system call."""


def refuse_locks(name):
    """Let every lock fail as on a file system that has none: in the kernel where it can be asked to, else in Python."""
    import ctypes
    import errno
    import fcntl
    import os
    import platform
    import struct

    number = getattr(errno, name)

    def refused(*_arguments):
        raise OSError(number, os.strerror(number))

    call = FLOCK.get(platform.machine()) if sys.platform == "linux" else None
    if call is not None:
        # Load the number of the call; where it is flock's, give the error back; else allow it.
        steps = [(0x20, 0, 0, 0), (0x15, 0, 1, call), (0x06, 0, 0, 0x00050000 | number), (0x06, 0, 0, 0x7FFF0000)]
        code = ctypes.create_string_buffer(b"".join(struct.pack("=HBBI", *step) for step in steps))
        program = ctypes.create_string_buffer(struct.pack("@HP", len(steps), ctypes.addressof(code)))
        ask = ctypes.CDLL(None, use_errno=True).prctl
        ask(38, 1, 0, 0, 0)  # no new privileges, without which nobody may set a filter
        if ask(22, 2, program, 0, 0) == 0:
            return
    fcntl.flock = refused


def main():
    """Set the stage, then run the command."""
    settings, words = json.loads(sys.argv[1]), sys.argv[2:]
    if settings.get("offline"):
        forbid_network()
    if "flock" in settings:
        refuse_locks(settings["flock"])
    from tendon_cli import cli
    from tendon_cli.engine import plan

    if "states" in settings:
        plan.STATES_PER_FILE = plan.STATES_PER_PART = plan.DESIGNS_PER_PART = settings["states"]
    if "choices" in settings:
        from tendon_cli.answers import choices

        choices.CHOICES_PER_PART = settings["choices"]
    if settings.get("fail") == "journal":
        full_journal()
    if "hold" in settings:
        hold(settings["hold"], settings["held"], settings.get("seconds", 60.0), settings.get("skip", 0))
    if "go" in settings:
        import tendon_cli.answers.choices
        import tendon_cli.engine.sweep  # noqa: F401

        Path(f"{settings['go']}-{settings['runner']}").touch()
        while not Path(settings["go"]).exists():
            time.sleep(0.0005)
    cli.main(words)


if __name__ == "__main__":
    main()
