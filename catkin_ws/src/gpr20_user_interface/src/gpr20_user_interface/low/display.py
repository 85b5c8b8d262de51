"""Whether there is a display for the window."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from typing import Callable, Mapping, Optional

from gpr20_common.message import Message
from gpr20_operator.errors import DisplayUnavailableError

# A screen over a slow network opens within this time [s].
OPEN_LIMIT_S = 15.0
# Without a display Qt ends its process with a core dump, so this is tried in another one.
OPEN = (
    "import resource; resource.setrlimit(resource.RLIMIT_CORE, (0, 0))\n"
    "from PyQt5.QtGui import QGuiApplication; QGuiApplication([])"
)
# Between two attempts, where a window waits for its display [s].
RETRY_S = 3.0


def check_display(environment: Mapping[str, str]) -> None:
    """Check that a window can be shown.

    Args:
        environment: `os.environ` or the like, for the sentence.

    Raises:
        DisplayUnavailableError: It cannot.
    """
    problem = problem_of(OPEN)
    if problem is None:
        return
    name = environment.get("DISPLAY", "")
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
            return check_display(os.environ)
        except DisplayUnavailableError as error:
            if not said:
                say(str(error))
            said = True
        # A signal ends the process meanwhile.
        time.sleep(RETRY_S)
