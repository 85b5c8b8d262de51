"""A screen of 800x480 for tests with a real window."""

from __future__ import annotations

import os
import shutil
import subprocess


class VirtualScreen:
    """An X server of its own, on a display number that it chooses itself."""

    def __init__(self) -> None:
        program = shutil.which("Xvfb")
        if program is None:
            raise AssertionError("Xvfb is missing: install the Debian package xvfb")
        reading, writing = os.pipe()
        self._process = subprocess.Popen(
            [program, "-displayfd", str(writing), "-screen", "0", "800x480x24", "-nolisten", "tcp"],
            pass_fds=[writing],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(writing)
        with os.fdopen(reading) as answer:
            # Ends with the server if it does not start.
            number = answer.readline().strip()
        if not number:
            raise AssertionError("Xvfb did not start")
        self.name = f":{number}"

    def close(self) -> None:
        self._process.terminate()
        self._process.wait(timeout=60)
