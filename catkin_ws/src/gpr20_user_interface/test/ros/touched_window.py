"""A window on a screen of its own, touched with real events of the X server."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any, Callable, Dict, Iterator

sys.path.append(str(Path(__file__).resolve().parents[5] / "tools/kits"))
from wait_kit import wait_until
from window_kit import virtual_screen

# As long as the window takes no touch after something has opened or closed, and a little more.
QUIET_S = 0.5
# How long a finger touches.
TAP_S = 0.06
HOLD_S = 1.3
LIMIT_S = 200.0


class Screen:
    """A virtual screen without a window manager."""

    def __init__(self) -> None:
        self._processes = ExitStack()
        self._processes.enter_context(virtual_screen())

    def finger(self, *words: str) -> None:
        """Let xdotool do something."""
        subprocess.run(["xdotool", *words], check=True, timeout=LIMIT_S)

    def kill(self) -> None:
        """End it without a warning to its windows; more than once does nothing."""
        self._processes.close()


class TouchedWindow:
    """A window, and the finger on it.

    Args:
        screen: Where it is shown.
        arguments: Options of the window's program.
        environment: Variables of the window alone.
    """

    def __init__(self, screen: Screen, *arguments: str, **environment: str) -> None:
        self._screen = screen
        program = Path(__file__).with_name("window_process.py")
        self.process = subprocess.Popen(
            [sys.executable, str(program), *arguments],
            env={**os.environ, **environment},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            universal_newlines=True,
        )
        wait_until(lambda: self.takes_touches("top_bar.stop"), "the window is there")

    def find(self, name: str = "") -> Dict[str, Any]:
        """Return where a part of the window is on the screen, and how it is; empty: all of it."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(f"{name}\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError(f"the window has ended with {self.process.wait()}")
        return json.loads(line)

    def wait_for(self, condition: Callable[[Dict[str, Any]], bool], what: str) -> Dict[str, Any]:
        """Wait for what the window shows; return it."""
        seen: Dict[str, Any] = {}

        def holds() -> bool:
            seen.update(self.find())
            return condition(seen)

        try:
            wait_until(holds, what)
        except AssertionError as error:
            raise AssertionError(f"{error}: {seen}") from error
        return seen

    def takes_touches(self, name: str) -> bool:
        """Return whether a part of the window is seen and can be touched."""
        found = self.find(name)
        return bool(found["visible"] and found["enabled"])

    def tap(self, name: str, for_s: float = TAP_S) -> None:
        """Touch a part of the window when it takes touches."""
        wait_until(lambda: self.takes_touches(name), f"{name} takes touches")
        time.sleep(QUIET_S)
        found = self.find(name)
        middle = found["x"] + found["width"] // 2, found["y"] + found["height"] // 2
        self.tap_at(*middle, for_s)

    def tap_for(self, wanted: str, name: str) -> None:
        """Touch a part until it has opened another one: a touch is dropped where one closes."""

        def is_open() -> bool:
            if self.find(wanted)["visible"]:
                return True
            if self.takes_touches(name):
                self.tap(name)
            return False

        wait_until(is_open, f"{name} opens {wanted}")

    def hold(self, name: str) -> None:
        """Touch a part of the window for long: again if a busy one has noticed a break."""

        def has_acted() -> bool:
            self.tap(name, HOLD_S)
            with suppress(AssertionError):
                wait_until(lambda: not self.takes_touches(name), limit_s=5.0)
                return True
            return False

        wait_until(has_acted, f"{name} acts")

    def tap_at(self, x: int, y: int, for_s: float = TAP_S) -> None:
        """Touch a place on the screen, whatever is there."""
        self._screen.finger(
            *("mousemove", str(x), str(y), "mousedown", "1"),
            *("sleep", f"{for_s:g}", "mouseup", "1"),
        )

    @contextmanager
    def stalled(self) -> Iterator[None]:
        """Let the window do nothing for a time; touches meanwhile wait for it."""
        self.process.send_signal(signal.SIGSTOP)
        try:
            yield
        finally:
            self.process.send_signal(signal.SIGCONT)

    def end(self, end: Callable[[], None]) -> int:
        """Let something end the window; return how it ended."""
        if self.process.poll() is None:
            end()
        # Both streams are closed; waits for the end.
        self.process.communicate(timeout=LIMIT_S)
        return self.process.returncode

    def kill(self) -> int:
        """End it as a crash does; more than once does nothing."""
        return self.end(self.process.kill)
