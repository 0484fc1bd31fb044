"""What the figures were measured on and of: nothing here names a host or a path."""

from __future__ import annotations

import datetime
import os
import platform
import shutil
import subprocess
from importlib.metadata import version as installed
from pathlib import Path

ROOT = Path(__file__).parent.parent
LIBRARIES = ("numpy", "pyarrow", "pydantic", "typer")


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def machine() -> dict[str, object]:
    """Processor, cores, memory, system and versions."""
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
    """The date, which tendon was measured, and how busy the machine was before.

    The commit is known where git and the repository are.
    """
    from tendon_cli.version import __version__

    commit, changed = (
        _git("rev-parse", "--short=12", "HEAD"),
        _git("status", "--porcelain", "--", "tendon_cli"),
    )
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "version": __version__,
        "commit": commit or None,
        "uncommitted_changes": bool(changed),
        "load_before": round(os.getloadavg()[0], 2),
    }


def free_memory() -> int:
    """Bytes that processes could still take; 0 where the system does not tell."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return 0
    return next(
        (int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable")), 0
    )


def lacking(folder: Path, *, disk: float, memory: float) -> str | None:
    """Why something that takes so many bytes cannot be measured here, or None where it can."""
    room, space = free_memory(), shutil.disk_usage(folder).free
    if room and room < memory:
        return f"skipped: takes {memory / 1e9:.0f} GB of memory, {room / 1e9:.0f} GB are free"
    if space < disk:
        return f"skipped: takes {disk / 1e9:.0f} GB of disk, {space / 1e9:.0f} GB are free"
    return None


def compiler() -> str | None:
    """The system's C compiler and its version, or None where there is none."""
    if shutil.which("cc") is None:
        return None
    said = subprocess.run(["cc", "--version"], capture_output=True, text=True, check=False).stdout
    return said.splitlines()[0] if said else "cc"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        said = subprocess.run(
            ["sysctl", "-n", "machdep.cpu.brand_string"],
            capture_output=True,
            text=True,
            check=False,
        )
        return said.stdout.strip() or platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _git(*arguments: str) -> str:
    if shutil.which("git") is None:
        return ""
    return subprocess.run(
        ["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.strip()
