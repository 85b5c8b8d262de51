"""A screen of its own for tests with a real window, with or without a window manager."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Dict

from waiting import wait_until

ROBOT_SIZE = "800x480"


def program_path(name: str) -> str:
    """Return the path of a program that the tests need."""
    path = shutil.which(name)
    if path is None:
        raise AssertionError(f"{name} is missing; run scripts/setup.sh --dev")
    return path


class VirtualScreen:
    """An X server of its own, on a display number that it chooses itself.

    Args:
        size: Width and height [pixels], as in 800x480.

    Attributes:
        name: The display, as in DISPLAY.
    """

    def __init__(self, size: str = ROBOT_SIZE) -> None:
        reading, writing = os.pipe()
        self._process = subprocess.Popen(
            [
                *(program_path("Xvfb"), "-displayfd", str(writing), "-nolisten", "tcp"),
                *("-screen", "0", f"{size}x24"),
            ],
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

    @property
    def environment(self) -> Dict[str, str]:
        """The environment of programs on this screen."""
        return {**os.environ, "DISPLAY": self.name, "QT_QPA_PLATFORM": "xcb"}

    def kill(self) -> None:
        """End the server without a warning to its clients."""
        self._process.kill()
        self._process.wait(timeout=60)

    def close(self) -> None:
        """End the server."""
        self._process.terminate()
        self._process.wait(timeout=60)


class WindowManager:
    """A window manager that gives every window a frame, as on a desktop.

    Args:
        screen: Where it runs.
    """

    def __init__(self, screen: VirtualScreen) -> None:
        with tempfile.TemporaryDirectory() as folder:
            started = Path(folder) / "started"
            self._process = subprocess.Popen(
                [program_path("openbox"), "--sm-disable", "--startup", f"touch {started}"],
                env=screen.environment,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            wait_until(started.exists, "the window manager runs")

    def close(self) -> None:
        """End it."""
        self._process.terminate()
        self._process.wait(timeout=60)
