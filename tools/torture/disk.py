"""A disk on which any operation may fail, or be the last before the process is killed."""

import errno
import io
import os
import shutil
import stat
from pathlib import Path

ERRORS = (errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EROFS, errno.EACCES)


class Killed(BaseException):
    """Stands in for SIGKILL: no later operation of the disk succeeds."""


class File(io.FileIO):
    """A file whose writes are recorded by the disk; one that fails has written half of its data."""

    def __init__(self, name, mode, disk):
        super().__init__(name, mode)
        self.disk = disk

    def write(self, data):
        try:
            self.disk.record("write", self.name)
        except OSError:
            if len(data) > 1:
                super().write(memoryview(data)[: len(data) // 2])
            raise
        return super().write(data)


class Disk:
    """Records operations on files and folders below a place, and lets one of them fail.

    It sees every opening, write, flush, rename and making of a folder.
    """

    def __init__(self, patch, below):
        self.below = str(below)
        self.reset()
        real_fsync = os.fsync
        real_open = Path.open

        def open_recorded(path, mode="r", buffering=-1, **options):
            writes_bytes = "b" in mode and mode != "rb"
            if not writes_bytes or not str(path).startswith(self.below):
                return real_open(path, mode, buffering, **options)
            self.record("open", path)
            raw = File(path, mode.replace("b", ""), self)
            return io.BufferedWriter(raw, buffering if buffering > 0 else io.DEFAULT_BUFFER_SIZE)

        def fsync_recorded(handle):
            is_folder = stat.S_ISDIR(os.fstat(handle).st_mode)
            self.record("fsync folder" if is_folder else "fsync file", handle)
            return real_fsync(handle)

        def recorded(kind, real):
            def call(path, *arguments, **options):
                self.record(kind, path)
                return real(path, *arguments, **options)

            return call

        def refused_after_kill(real):
            def call(path, *arguments, **options):
                self.check_alive()
                return real(path, *arguments, **options)

            return call

        patch.setattr(Path, "open", open_recorded)
        patch.setattr(os, "fsync", fsync_recorded)
        patch.setattr(Path, "replace", recorded("rename", Path.replace))
        patch.setattr(Path, "mkdir", recorded("mkdir", Path.mkdir))
        patch.setattr(Path, "unlink", refused_after_kill(Path.unlink))
        patch.setattr(shutil, "rmtree", refused_after_kill(shutil.rmtree))

    def reset(self, fail_at=None, error=errno.ENOSPC, *, lasting=False):
        """Forget all operations, and choose the one that fails from now on.

        Args:
            fail_at: Number of the operation, from 0; None if none fails.
            error: Number of the error; None if the process is killed instead.
            lasting: True if all later operations fail as well.
        """
        self.operations = []
        self.fail_at = fail_at
        self.error = error
        self.lasting = lasting
        self.is_killed = False

    def check_alive(self):
        """Raise Killed if the process was killed."""
        if self.is_killed:
            raise Killed

    def record(self, kind, name):
        """Record an operation before it happens; raise if it is to fail."""
        self.check_alive()
        number = len(self.operations)
        self.operations.append((kind, str(name)))
        if self.fail_at is None or number < self.fail_at:
            return
        if number > self.fail_at and not self.lasting:
            return
        self.is_killed = self.error is None
        self.check_alive()
        raise OSError(self.error, os.strerror(self.error))
