"""A window on a screen of its own, touched with real events of the X server."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Dict, Iterator, Optional, Sequence, Tuple

from virtual_screen import VirtualScreen, WindowManager, program_path
from waiting import wait_until

# As long as the window takes no touch after something has opened or closed, and a little more.
QUIET_S = 0.5
# How long a finger touches.
TAP_S = 0.06
HOLD_S = 1.3


class TouchedWindow:
    """A window, and the finger on it.

    Args:
        folder: Where it keeps settings and profiles.
        size: Width and height of the screen, as in 800x480.
        full_screen: Whether the window covers the screen.
        managed: Whether a window manager runs.
        arguments: More arguments of the window, such as its language or services of another name.

    Attributes:
        touches: How many times the finger touched.
    """

    def __init__(
        self,
        folder: Path,
        size: str = "800x480",
        full_screen: bool = True,
        managed: bool = True,
        arguments: Sequence[str] = (),
    ) -> None:
        self.touches = 0
        self._closed = False
        self.screen = VirtualScreen(size)
        self._manager: Optional[WindowManager] = None
        if managed:
            self._manager = WindowManager(self.screen)
        program = Path(__file__).with_name("touch_window.py")
        options = ["--full-screen"] if full_screen else []
        self._process = subprocess.Popen(
            [sys.executable, str(program), "--folder", str(folder), *options, *arguments],
            env={**self.screen.environment, "QT_XCB_GL_INTEGRATION": "none"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            universal_newlines=True,
        )
        wait_until(lambda: self.find("top_bar.stop")["visible"], "the window is there")

    def find(self, name: str) -> Dict[str, Any]:
        """Return where a part of the window is on the screen, and how it is."""
        if self._process.stdin is None or self._process.stdout is None:
            raise AssertionError("the window has no pipes")
        self._process.stdin.write(f"{name}\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise AssertionError(f"the window has ended with {self._process.wait()}")
        return json.loads(line)

    def is_shown(self, name: str) -> bool:
        """Whether a part of the window is visible."""
        return bool(self.find(name)["visible"])

    def tap(self, name: str) -> None:
        """Touch a part of the window when it takes touches."""
        wait_until(lambda: self.takes_touches(name), f"{name} takes touches")
        time.sleep(QUIET_S)
        self.tap_at(*self.centre(name))

    def hold(self, name: str, for_s: float = HOLD_S) -> None:
        """Touch a part of the window for long."""
        wait_until(lambda: self.takes_touches(name), f"{name} takes touches")
        time.sleep(QUIET_S)
        self.tap_at(*self.centre(name), for_s)

    def tap_at(self, x: int, y: int, for_s: float = TAP_S) -> None:
        """Touch a place on the screen, whatever is there."""
        self.touches += 1
        self._finger(
            *("mousemove", str(x), str(y), "mousedown", "1"),
            *("sleep", f"{for_s:g}", "mouseup", "1"),
        )

    def drag(self, start: Tuple[int, int], end: Tuple[int, int]) -> None:
        """Wipe over the screen."""
        self.touches += 1
        self._finger(
            *("mousemove", str(start[0]), str(start[1]), "mousedown", "1"),
            *("mousemove", str(end[0]), str(end[1]), "mouseup", "1"),
        )

    @contextmanager
    def stalled(self, for_s: float) -> Iterator[None]:
        """Let the window do nothing for a time; touches meanwhile wait for it."""
        self._process.send_signal(signal.SIGSTOP)
        begin_s = time.monotonic()
        try:
            yield
            time.sleep(max(0.0, for_s - (time.monotonic() - begin_s)))
        finally:
            self._process.send_signal(signal.SIGCONT)

    def centre(self, name: str) -> Tuple[int, int]:
        """Return the middle of a part of the window."""
        found = self.find(name)
        return found["x"] + found["width"] // 2, found["y"] + found["height"] // 2

    def close(self) -> None:
        """End the window, the window manager and the screen."""
        if self._closed:
            return
        self._closed = True
        if self._process.poll() is None and self._process.stdin is not None:
            self._process.stdin.close()
        self._process.wait(timeout=60)
        if self._process.stdout is not None:
            self._process.stdout.close()
        if self._manager is not None:
            self._manager.close()
        self.screen.close()

    def takes_touches(self, name: str) -> bool:
        """Return whether a part of the window is seen and can be touched."""
        found = self.find(name)
        return bool(found["visible"] and found["enabled"])

    def _finger(self, *words: str) -> None:
        subprocess.run(
            [program_path("xdotool"), *words], env=self.screen.environment, check=True, timeout=60
        )
