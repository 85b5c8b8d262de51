"""A disk with faults, for tests that may not mount one: Python imports this at its start.

GPR20_FAULTY_DISK is a folder. While the file of that name with `.fault` behind it exists, what
writes below the folder fails with the errno that it holds, or takes the seconds that it holds.
"""

import os
import time
from pathlib import Path

FOLDER = os.environ["GPR20_FAULTY_DISK"]
FAULT = Path(FOLDER + ".fault")


def meet_fault(path):
    """Fail or wait, if the path is on the faulty disk and it is faulty now."""
    if not path.startswith(FOLDER + "/"):
        return
    try:
        kind, value = FAULT.read_text().split()
    except FileNotFoundError:
        return
    if kind == "slow":
        time.sleep(float(value))
    else:
        raise OSError(int(value), os.strerror(int(value)), path)


def of_descriptor(call):
    """Return a call that takes a descriptor first, with the faults of the disk."""

    def faulty(descriptor, *arguments):
        meet_fault(os.readlink(f"/proc/self/fd/{descriptor}"))
        return call(descriptor, *arguments)

    return faulty


def of_paths(call):
    """Return a call that takes two paths first, with the faults of the disk."""

    def faulty(source, target, **options):
        meet_fault(os.fspath(target))
        return call(source, target, **options)

    return faulty


os.fsync = of_descriptor(os.fsync)
os.pwrite = of_descriptor(os.pwrite)
os.link = of_paths(os.link)
os.replace = of_paths(os.replace)
