"""A run on a file system of its own that is too small, then with more room; started in a mount namespace of its own.

    unshare --mount python small_disk.py MOUNT_POINT KILOBYTES LAUNCHER_COMMAND...

Prints a JSON object: what the first run left, and what became of the resumed one.
"""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path


def mount(point, kilobytes, *, again=False):
    """Mount, or resize."""
    options = f"size={kilobytes}k" + (",remount" if again else "")
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", point], check=True, capture_output=True)


def state(run):
    """What stands in a run folder."""
    files = [file for file in sorted(run.rglob("*")) if file.is_file()]
    return {
        "files": [str(file.relative_to(run)) for file in files],
        "hashes": {
            str(file.relative_to(run)): hashlib.sha256(file.read_bytes()).hexdigest()
            for file in files
            if file.suffix == ".parquet"
        },
    }


def attempt(words):
    """Run a command; returns its exit code and words."""
    ran = subprocess.run(words, check=False, capture_output=True, text=True, timeout=60)
    return {"exit": ran.returncode, "out": ran.stdout, "err": ran.stderr}


def main():
    """Fill the disk, look, make room, resume."""
    point, kilobytes, words = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
    mount(point, kilobytes)
    os.chdir(point)
    words = [*words, "--out", str(point / "run"), "--resume", "--json"]
    first = attempt(words) | state(point / "run")
    again = attempt(words) | state(point / "run")
    mount(point, 64 * 1024, again=True)
    second = attempt(words) | state(point / "run")
    sys.stdout.write(json.dumps({"first": first, "again": again, "second": second}))


if __name__ == "__main__":
    main()
