"""The machine and the version that are measured; nothing here names a host or a path."""

from __future__ import annotations

import datetime as dt
import os
import platform
import shutil
import subprocess
from importlib.metadata import version as installed
from pathlib import Path

ROOT = Path(__file__).parent.parent
LIBRARIES = ("numpy", "pyarrow", "pydantic", "typer")


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def machine() -> dict[str, object]:
    """Return processor, cores, memory, system and versions."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return {
        "processor": _processor(),
        "cores": cores(),
        "memory_gb": round(memory / 1e9, 1),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        **{name: installed(name) for name in LIBRARIES},
        "compiler": compiler(),
    }


def when_and_what() -> dict[str, object]:
    """Return the date, the version of tendon, and the load of the machine before.

    The commit is known if there are git and the repository.
    """
    from tendon_cli.version import __version__

    commit = _git("rev-parse", "--short=12", "HEAD")
    changed = _git("status", "--porcelain", "--", "tendon_cli")
    return {
        "date": dt.datetime.now(dt.UTC).isoformat(timespec="seconds"),
        "version": __version__,
        "commit": commit or None,
        "uncommitted_changes": bool(changed),
        "load_before": round(os.getloadavg()[0], 2),
    }


def free_memory() -> int:
    """Return the bytes that processes could still take; 0 if the system does not tell."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return 0
    for line in lines:
        if line.startswith("MemAvailable"):
            return int(line.split()[1]) * 1024
    return 0


def lacking(folder: Path, *, disk: float, memory: float) -> str | None:
    """Return why something that takes so many bytes cannot be measured here; None if it can."""
    room = free_memory()
    space = shutil.disk_usage(folder).free
    if room and room < memory:
        return f"skipped: takes {memory / 1e9:.0f} GB of memory, {room / 1e9:.0f} GB are free"
    if space < disk:
        return f"skipped: takes {disk / 1e9:.0f} GB of disk, {space / 1e9:.0f} GB are free"
    return None


def compiler() -> str | None:
    """Return the version of the system's C compiler; None if there is none."""
    if shutil.which("cc") is None:
        return None
    done = subprocess.run(["cc", "--version"], capture_output=True, text=True, check=False)
    return done.stdout.splitlines()[0] if done.stdout else "cc"


def _processor() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        done = subprocess.run(
            ["sysctl", "-n", "machdep.cpu.brand_string"],
            capture_output=True,
            text=True,
            check=False,
        )
        return done.stdout.strip() or platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _git(*arguments: str) -> str:
    """Return what git prints; empty if there is no git."""
    if shutil.which("git") is None:
        return ""
    done = subprocess.run(
        ["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return done.stdout.strip()
