"""The display that the window is shown on: none at the start, or lost later."""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
import sys
import tempfile
import time
from typing import Callable, Mapping, MutableMapping, NoReturn, Optional

from PyQt5.QtCore import QMessageLogContext, QtMsgType, qInstallMessageHandler
from PyQt5.QtGui import QGuiApplication

from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_operator.errors import DisplayUnavailableError

# A screen over a slow network opens within this time [s].
OPEN_LIMIT_S = 15.0
# A library that cannot open the display says why in a few lines.
MAX_WORDS_BYTES = 65536
NO_ANSWER = "no answer within {limit_s:g} s"
# Between two attempts, where a window waits for its display [s].
RETRY_S = 3.0
# What Qt says before it calls exit(): of X11, and of Wayland.
LOST = "connection broke"


def draw_without_opengl(environment: MutableMapping[str, str]) -> None:
    """Keep Qt from loading OpenGL, unless the user has set something there.

    It costs memory and time at the start, and crashes when the display closes while the
    window is made.
    """
    environment.setdefault("QT_XCB_GL_INTEGRATION", "none")


def check_display(environment: Mapping[str, str]) -> None:
    """Check that a window can be shown: Qt would end this process with a core dump.

    Call it before there are threads.

    Args:
        environment: `os.environ` or the like, for the sentence.

    Raises:
        DisplayUnavailableError: It cannot.
    """
    # Only the name of the program: the options of the window are not Qt's.
    problem = display_problem(lambda: QGuiApplication(sys.argv[:1]))
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


def on_display_lost(leave: Callable[[], None]) -> None:
    """Call a function, which ends the process, when the connection to the display breaks.

    Qt aborts, or calls exit() and so the destructors of what other threads still use.
    """

    def handle(kind: QtMsgType, _context: QMessageLogContext, text: Optional[str]) -> None:
        if kind == QtMsgType.QtFatalMsg or LOST in (text or ""):
            leave()
        say(text or "", file=sys.stderr, flush=True)

    qInstallMessageHandler(handle)


def display_problem(
    open_display: Callable[[], object], limit_s: float = OPEN_LIMIT_S
) -> Optional[str]:
    """Return why the display cannot be opened; None if it can.

    A library without a display ends its process with a core dump, so the attempt is made in
    a child. Call it before there are threads.

    Args:
        open_display: Opens the display, such as the constructor of an application.
        limit_s: How long the attempt may take [s].
    """
    with tempfile.TemporaryFile() as words:
        fork = multiprocessing.get_context("fork")
        child = fork.Process(target=_attempt, args=(open_display, words.fileno()))
        child.start()
        child.join(limit_s)
        if child.exitcode is None:
            child.kill()
            child.join()
            return NO_ANSWER.format(limit_s=limit_s)
        words.seek(0)
        # Warnings are no problem.
        said = words.read(MAX_WORDS_BYTES).decode(errors="replace")
        return None if child.exitcode == 0 else _first_line(said)


def _attempt(open_display: Callable[[], object], writing: int) -> NoReturn:
    status = 1
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for stream in (1, 2):
            os.dup2(writing, stream)
        open_display()
        status = 0
    except Exception as error:
        os.write(writing, repr(error).encode())
    finally:
        os._exit(status)


def _first_line(words: str) -> str:
    """Return the line that names the display, or else the first one."""
    lines = [line.strip() for line in words.splitlines() if line.strip()]
    named = [line for line in lines if "display" in line]
    return (named or lines or [""])[0]
