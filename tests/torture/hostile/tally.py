"""Hostile files tried one by one: each within its time, and whatever it ends in counted."""

import json
import signal
import time
import traceback
from pathlib import Path

LONGEST = 10.0
MOST_MEGABYTES = 500


class TooSlow(BaseException):
    """Not an Exception, so that nothing that is fuzzed can take it for one of its own."""


def too_slow(_number, _frame):
    """The alarm."""
    raise TooSlow(f"longer than {LONGEST} s")


def peak():
    """Most memory that was ever in use, in MB; of this process alone, where getrusage counts its parent's."""
    status = dict(
        line.split(":", 1) for line in Path("/proc/self/status").read_text("utf-8").splitlines()
    )
    return int(status["VmHWM"].split()[0]) / 1024


class Tally:
    """What became of the cases; those that take longer than so many seconds are faults, but for 0 seconds."""

    def __init__(self, folder, attempt, longest=LONGEST):
        self.folder, self.attempt, self.longest = folder, attempt, longest
        self.cases, self.taken, self.refused, self.slowest = 0, 0, {}, 0.0
        self.faults, self.peak = {}, peak()

    def meet(self, suffix, content):
        """Try one file; whatever it ends in is counted."""
        from tendon_cli.errors import TendonError

        self.cases += 1
        file = self.folder / f"case{suffix}"
        file.write_bytes(content)
        began = time.perf_counter()
        signal.setitimer(signal.ITIMER_REAL, self.longest)
        try:
            self.attempt(file)
            self.taken += 1
        except TendonError as error:
            if error.exit not in (2, 3):
                self.fault(error, suffix, content)
            self.refused[error.kind] = self.refused.get(error.kind, 0) + 1
        except (Exception, TooSlow) as error:  # noqa: BLE001 - just what is looked for
            self.fault(error, suffix, content)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
        self.slowest = max(self.slowest, time.perf_counter() - began)
        before, self.peak = self.peak, peak()
        if before < MOST_MEGABYTES <= self.peak:
            self.fault(
                MemoryError(f"{self.peak:.0f} MB, {before:.0f} MB before it"), suffix, content
            )

    def fault(self, error, suffix, content):
        """Keep the first file of each kind of fault."""
        ours = [
            frame
            for frame in traceback.extract_tb(error.__traceback__)
            if "tendon_cli" in frame.filename
        ]
        where = f"{Path(ours[-1].filename).name}:{ours[-1].name}" if ours else "?"
        name = f"{type(error).__name__} in {where}"
        if name not in self.faults:
            file = self.folder / f"fault-{len(self.faults)}{suffix}"
            file.write_bytes(content)
            self.faults[name] = {"file": str(file), "says": str(error)[:300]}

    def save(self):
        """Leave it in the folder."""
        counts = ("cases", "taken", "refused", "slowest", "peak", "faults")
        (self.folder / "tally.json").write_text(
            json.dumps({name: getattr(self, name) for name in counts}), "utf-8"
        )
