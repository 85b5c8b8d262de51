"""This process: its display, signals that ask it to stop, and its end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from types import FrameType
from typing import Any, Callable, Dict, NoReturn, Optional

from gpr20_common.message import Message
from gpr20_operator.errors import DisplayUnavailableError

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """While entered, the first signal calls one callable, each further one another.

    Both are called in the main thread between any two steps of the program: they may set a
    flag, use `queue.SimpleQueue.put` or end the process, but not wait for a lock.
    """

    def __init__(self, on_first: Callable[[], None], on_next: Callable[[], None]) -> None:
        self._on_first = on_first
        self._on_next = on_next
        self._count = 0
        self._former: Dict[int, Any] = {}

    @property
    def received(self) -> bool:
        """Whether there was a signal."""
        return self._count > 0

    def __enter__(self) -> StopSignals:
        for number in SIGNALS:
            self._former[number] = signal.signal(number, self._receive)
        return self

    def __exit__(self, *_exception: object) -> None:
        for number, handler in self._former.items():
            signal.signal(number, handler)

    def _receive(self, _number: int, _frame: Optional[FrameType]) -> None:
        self._count += 1
        (self._on_first if self._count == 1 else self._on_next)()


def leave_now(status: int) -> NoReturn:
    """End the process without the exit handlers of libraries, which may wait for the network."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


# A screen over a slow network opens within this time [s].
OPEN_LIMIT_S = 15.0
# Without a display Qt ends its process with a core dump, so this is tried in another one.
OPEN = (
    "import resource; resource.setrlimit(resource.RLIMIT_CORE, (0, 0))\n"
    "from PyQt5.QtGui import QGuiApplication; QGuiApplication([])"
)
# Between two attempts, where a window waits for its display [s].
RETRY_S = 3.0


def check_display() -> None:
    """Check that a window can be shown.

    Raises:
        DisplayUnavailableError: It cannot.
    """
    problem = problem_of(OPEN)
    if problem is None:
        return
    name = os.environ.get("DISPLAY", "")
    what = (
        Message("the display {name} cannot be opened", name=repr(name))
        if name
        else Message("DISPLAY is not set")
    )
    raise DisplayUnavailableError(
        Message(
            "no screen for the window, {what}; set DISPLAY to the screen of this computer "
            "(usually :0), or launch with ui:=false to run without a window",
            what=what,
            details=problem,
        )
    )


def problem_of(program: str, limit_s: float = OPEN_LIMIT_S) -> Optional[str]:
    """Return why a program does not succeed; None if it does.

    Args:
        program: Python code.
        limit_s: How long it may take [s].
    """
    command = [sys.executable, "-c", program]
    try:
        done = subprocess.run(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=limit_s
        )
    except subprocess.TimeoutExpired:
        return f"no answer within {limit_s:g} s"
    if done.returncode == 0:
        return None
    lines = [one.strip() for one in done.stdout.decode(errors="replace").splitlines()]
    # The line that names the display, or else the first one.
    return next((one for one in lines if "display" in one), next(filter(None, lines), ""))


def wait_for_display(say: Callable[[str], None]) -> None:
    """Return when a window can be shown; say once why not: a screen may start later."""
    said = False
    while True:
        try:
            return check_display()
        except DisplayUnavailableError as error:
            if not said:
                say(str(error))
            said = True
        # A signal ends the process meanwhile.
        time.sleep(RETRY_S)
