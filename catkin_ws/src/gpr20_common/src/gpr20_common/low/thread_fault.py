"""The log of exceptions that nobody expected in a thread; the diagnostics of a node say them."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import sys
import threading
import traceback
from typing import Iterator

from gpr20_common.faults import INTERNAL
from gpr20_common.message import Message

# rospy prints, keeps and publishes what is logged here.
LOGGER = logging.getLogger("rosout")
# Attribute of a record that diagnostics repeat: its message.
SAID = "said"


def log_fault(part: str) -> Message:
    """Log the exception that is being handled, with its traceback; return what to say of it."""
    error = sys.exc_info()[1]
    said = Message(
        "internal error in {service}; see the log",
        service=part,
        details=f"{type(error).__name__}: {error}",
    ).with_fault(INTERNAL)
    LOGGER.critical("%s failed:\n%s", part, traceback.format_exc(), extra={SAID: said})
    return said


@contextlib.contextmanager
def faults_logged(part: str) -> Iterator[None]:
    """Log an exception and continue, for work whose result nobody needs."""
    try:
        yield
    except Exception:  # whatever it is, nobody expected it
        log_fault(part)


def end_with_thread(failure: threading.ExceptHookArgs) -> None:
    """End this process in order, so that roslaunch starts it again; a `threading.excepthook`.

    Who waits for the thread would wait for ever. A thread of a library alone is only logged.
    """
    log_fault(f"thread {getattr(failure.thread, 'name', '')}")
    frames = traceback.walk_tb(failure.exc_traceback)
    if any(str(one.f_globals.get("__name__")).startswith("gpr20_") for one, _line in frames):
        os.kill(os.getpid(), signal.SIGTERM)
