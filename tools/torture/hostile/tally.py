"""Hostile files tried one by one: each within its time, and every result counted."""

import json
import signal
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

LONGEST = 10.0
"""Time of the processor after which a case is a fault, s; a busy machine takes longer."""
LONGEST_ANSWER = 120.0
"""Time of the processor after which an answer to a small study is a fault, s."""
MOST_MEGABYTES = 500
"""Peak of memory from which on a case is a fault, MB."""
MOST_MEGABYTES_OF_AN_ANSWER = 1500
"""The same for an answer to a small study, whose proof may need many cells."""


class TooSlow(BaseException):
    """The time is over. Not an Exception, so that nothing that is fuzzed handles it as its own."""


def too_slow(_number, _frame):
    """Raise TooSlow at the alarm."""
    raise TooSlow(f"longer than {LONGEST} s")


def peak_memory():
    """Return the peak of memory in MB, of this process alone; getrusage counts its parent's."""
    status = Path("/proc/self/status").read_text("utf-8")
    fields = dict(line.split(":", 1) for line in status.splitlines())
    return int(fields["VmHWM"].split()[0]) / 1024


@dataclass
class Tally:
    """Counts of the cases and of their results."""

    folder: Path
    attempt: Callable[[Path], object]
    longest: float = LONGEST
    """Time of the processor after which a case is a fault, s; 0 for no limit."""
    most_megabytes: float = MOST_MEGABYTES
    """Peak of memory from which on a case is a fault, MB."""
    cases: int = 0
    taken: int = 0
    refused: dict[str, int] = field(default_factory=dict)
    """Number of refusals by kind of error."""
    slowest: float = 0.0
    """Longest time of the processor of a case, s."""
    peak: float = field(default_factory=peak_memory)
    """Peak of memory, MB."""
    faults: dict[str, dict[str, str]] = field(default_factory=dict)
    """First file and message of each kind of fault."""

    def meet(self, suffix, content):
        """Try a file and count its result."""
        from tendon_cli.errors import TendonError

        self.cases += 1
        file = self.folder / f"case{suffix}"
        file.write_bytes(content)
        began = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, self.longest)
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
            signal.setitimer(signal.ITIMER_PROF, 0)
        self.slowest = max(self.slowest, time.process_time() - began)
        before = self.peak
        self.peak = peak_memory()
        if before < self.most_megabytes <= self.peak:
            error = MemoryError(f"{self.peak:.0f} MB, {before:.0f} MB before it")
            self.fault(error, suffix, content)

    def fault(self, error, suffix, content):
        """Keep the first file of each kind of fault."""
        frames = traceback.extract_tb(error.__traceback__)
        ours = [frame for frame in frames if "tendon_cli" in frame.filename]
        last = [*frames, *ours][-1:]
        where = "".join(f"{Path(frame.filename).name}:{frame.name}" for frame in last) or "?"
        name = f"{type(error).__name__} in {where}"
        if name not in self.faults:
            file = self.folder / f"fault-{len(self.faults)}{suffix}"
            file.write_bytes(content)
            self.faults[name] = {"file": str(file), "says": str(error)[:300]}

    def save(self):
        """Write the counts into the folder."""
        names = ("cases", "taken", "refused", "slowest", "peak", "faults")
        counts = {name: getattr(self, name) for name in names}
        (self.folder / "tally.json").write_text(json.dumps(counts), "utf-8")
