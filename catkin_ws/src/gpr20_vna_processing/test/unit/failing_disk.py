"""A disk that becomes full, or loses its power, at any of its calls; it knows what is durable."""

from __future__ import annotations

import contextlib
import errno
import os
import random
import stat
from dataclasses import dataclass

import pytest

CALLS = ("pwrite", "fsync", "ftruncate", "link", "unlink", "replace", "mkdir")


@dataclass(frozen=True)
class Failure:
    """What happens to the disk within a request, or behind it if the request needs fewer calls."""

    calls: int
    """How many calls of the disk still succeed."""
    power: bool
    """Whether its power is cut and the process gone; else it is full."""
    durable_share: float = 1.0
    """How much of what was not made durable is lost; nothing is, where only the process ends."""
    seed: int = 0


class FailingDisk:
    """Stands between this process and the disk, until it is released."""

    def __init__(self, place):
        self._patch = pytest.MonkeyPatch()
        self._failure = None
        self._left = 0
        self.has_failed = False
        self.folder = place
        self._after_cut = None
        self._names, self._contents, self._open = {}, {}, {}
        self.take_over(place)
        for name in CALLS:
            self._patch.setattr(os, name, self._passing_on(name, getattr(os, name)))

    def release(self):
        """Let the calls go to the disk itself."""
        self._patch.undo()
        self._forget()

    @contextlib.contextmanager
    def failing(self, failure, after_cut):
        """Fail in the middle of what is done, or after it.

        Args:
            failure: What fails; None: nothing does.
            after_cut: Where what a power cut leaves is put.
        """
        self.has_failed, self._after_cut = False, after_cut
        self._left = failure.calls if failure else 0
        self._failure = failure
        try:
            yield
        finally:
            self._failure = None
        if failure is not None and failure.power and not self.has_failed:
            self._cut(failure)

    def _passing_on(self, name, real):
        def call(*arguments, **options):
            failure = self._failure
            if failure is not None and self._left > 0:
                self._left -= 1
            elif failure is not None:
                self._fail(failure, name, real, arguments)
            result = real(*arguments, **options)
            if name == "fsync":
                self._note_durable(arguments[0])
            return result

        return call

    def _fail(self, failure, name, real, arguments):
        if not failure.power:
            self.has_failed = True
            if name != "unlink":  # which makes space
                raise OSError(errno.ENOSPC, "No space left on device")
            return
        if not self.has_failed:
            if name == "pwrite":
                descriptor, data, offset = arguments
                real(descriptor, bytes(data)[: len(data) // 2], offset)
            self._failure = None
            self._cut(failure)
            self._failure = failure
        raise OSError(errno.EIO, "the power is off")

    def _note_durable(self, descriptor):
        status = os.fstat(descriptor)
        if stat.S_ISDIR(status.st_mode):
            self._names[status.st_ino] = names_in(descriptor)
            return
        if status.st_ino not in self._open:
            # While a file is open, no other one gets its number.
            self._open[status.st_ino] = open(f"/proc/self/fd/{descriptor}", "rb")  # noqa: SIM115
        self._contents[status.st_ino] = self._read(status.st_ino)

    def _read(self, number):
        stream = self._open[number]
        return os.pread(stream.fileno(), os.fstat(stream.fileno()).st_size, 0)

    def take_over(self, place):
        """Begin with everything durable that is in a folder."""
        self._forget()
        self.folder = place
        for path in [place, *place.rglob("*")]:
            descriptor = os.open(str(path), os.O_RDONLY)
            self._note_durable(descriptor)
            os.close(descriptor)

    def _forget(self):
        for stream in self._open.values():
            stream.close()
        self._names, self._contents, self._open = {}, {}, {}

    def _cut(self, failure):
        """Write what the disk holds after a power cut: each thing as it is now, or was durable."""
        self.has_failed = True
        draw = random.Random(failure.seed)
        paths = {path.lstat().st_ino: path for path in [self.folder, *self.folder.rglob("*")]}

        def restore(number, target):
            is_lost = draw.random() < failure.durable_share
            if number in self._names or (number in paths and paths[number].is_dir()):
                durable = self._names.get(number, {})
                target.mkdir()
                for name, inner in sorted(
                    (durable if is_lost else names_in(paths[number])).items()
                ):
                    restore(inner, target / name)
            elif is_lost or (number not in self._open and number not in paths):
                target.write_bytes(self._contents.get(number, b""))
            elif number in self._open:
                target.write_bytes(self._read(number))
            else:
                target.write_bytes(paths[number].read_bytes())

        restore(self.folder.stat().st_ino, self._after_cut)


def names_in(folder):
    with os.scandir(folder) as entries:
        return {one.name: one.inode() for one in entries}
