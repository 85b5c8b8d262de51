"""The screen saver and the power saving of an X screen."""

from __future__ import annotations

import re
import subprocess
from typing import Callable, List, Optional

PROGRAM = "xset"
DEBIAN_PACKAGE = "x11-xserver-utils"
# A screen that hangs must not keep the window from starting or ending.
LIMIT_S = 3.0
_TIMES = re.compile(r"timeout:\s*(\d+)\s+cycle:\s*(\d+)")
_POWER_SAVING = re.compile(r"DPMS is Enabled")

Run = Callable[[List[str]], str]


def run_program(command: List[str]) -> str:
    """Run a program and return what it prints.

    Raises:
        OSError: It is not installed.
        subprocess.SubprocessError: It fails, or takes too long.
    """
    return subprocess.run(
        command,
        check=True,
        timeout=LIMIT_S,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ).stdout


class ScreenSaver:
    """Switches the screen saver and the power saving off, and back to what they were."""

    def __init__(self, run: Run = run_program) -> None:
        self._run = run
        self._restore: List[str] = []

    def switch_off(self) -> Optional[str]:
        """Keep the screen on; return why that is not possible, for the log."""
        try:
            self._restore = _settings(self._run([PROGRAM, "q"]))
            self._run([PROGRAM, "s", "off", "-dpms"])
        except FileNotFoundError:
            return f"{PROGRAM} is not installed (Debian package {DEBIAN_PACKAGE})"
        except (OSError, subprocess.SubprocessError) as error:
            return str(error)
        return None

    def restore(self) -> Optional[str]:
        """Set what there was before, if it was changed; return why that is not possible."""
        settings, self._restore = self._restore, []
        if not settings:
            return None
        try:
            self._run([PROGRAM, *settings])
        except (OSError, subprocess.SubprocessError) as error:
            return str(error)
        return None


def _settings(printed: str) -> List[str]:
    """Return the arguments that bring back what `xset q` has printed."""
    times = _TIMES.search(printed)
    arguments = ["s", times.group(1), times.group(2)] if times else ["s", "default"]
    # Without the extension there is no power saving to bring back.
    return [*arguments, "+dpms"] if _POWER_SAVING.search(printed) else arguments
