"""A disk on which any operation may fail, or be the last before the process is killed."""

import errno
import io
import os
import shutil
import stat
from pathlib import Path

ERRORS = (errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EROFS, errno.EACCES)


class Killed(BaseException):
    """As SIGKILL: whoever catches it cannot do anything more."""


class File(io.FileIO):
    """A file whose writes go by the disk; one that fails has written half of what was asked."""

    def __init__(self, name, mode, disk):
        super().__init__(name, mode)
        self.disk = disk

    def write(self, data):
        try:
            self.disk.meet("write", self.name)
        except OSError:
            if len(data) > 1:
                super().write(memoryview(data)[: len(data) // 2])
            raise
        return super().write(data)


class Disk:
    """Every opening, write, flush, rename and making of a folder below a place goes by here, and one of them fails."""

    def __init__(self, patch, below):
        self.below = str(below)
        self.begin()
        fsync, path_open = os.fsync, Path.open

        def open_(path, mode="r", buffering=-1, **options):
            if "b" not in mode or mode == "rb" or not str(path).startswith(self.below):
                return path_open(path, mode, buffering, **options)
            self.meet("open", path)
            raw = File(path, mode.replace("b", ""), self)
            return io.BufferedWriter(raw, buffering if buffering > 0 else io.DEFAULT_BUFFER_SIZE)

        def fsync_(handle):
            self.meet(
                "fsync folder" if stat.S_ISDIR(os.fstat(handle).st_mode) else "fsync file", handle
            )
            return fsync(handle)

        def by_here(real, meet):
            def call(first, *rest, **options):
                meet(first)
                return real(first, *rest, **options)

            return call

        patch.setattr(Path, "open", open_)
        patch.setattr(os, "fsync", fsync_)
        patch.setattr(
            Path, "replace", by_here(Path.replace, lambda path: self.meet("rename", path))
        )
        patch.setattr(Path, "mkdir", by_here(Path.mkdir, lambda path: self.meet("mkdir", path)))
        patch.setattr(Path, "unlink", by_here(Path.unlink, lambda _path: self.go_on()))
        patch.setattr(shutil, "rmtree", by_here(shutil.rmtree, lambda _path: self.go_on()))

    def begin(self, fail_at=None, error=errno.ENOSPC, *, lasting=False):
        """From now on the operation of this number fails, if it is lasting all later ones too; error None is a kill."""
        self.seen, self.fail_at, self.error, self.lasting, self.dead = (
            [],
            fail_at,
            error,
            lasting,
            False,
        )

    def go_on(self):
        if self.dead:
            raise Killed

    def meet(self, kind, name):
        self.go_on()
        self.seen.append((kind, str(name)))
        at = len(self.seen) - 1
        if self.fail_at is None or at < self.fail_at or (at > self.fail_at and not self.lasting):
            return
        self.dead = self.error is None
        self.go_on()
        raise OSError(self.error, os.strerror(self.error))
