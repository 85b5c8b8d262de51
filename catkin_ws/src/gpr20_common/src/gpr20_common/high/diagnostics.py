"""The 1 Hz report of a node on /diagnostics."""

from __future__ import annotations

import logging
import math
import time
from typing import Any, Callable, Dict, Optional, Tuple

import diagnostic_updater
import rospy

from gpr20_common.high.periodic import Periodic
from gpr20_common.low.thread_fault import LOGGER, SAID, faults_logged
from gpr20_common.message import Message, verbatim

OK, WARN, ERROR = 0, 1, 2

# Level, one sentence, and named values.
Health = Tuple[int, Message, Dict[str, Any]]
# Name of the value that holds the sentence with its fault, as JSON.
FAULT = "fault"

PERIOD_S = 1.0
# For so long an exception that nobody expected, in any thread, is said [s].
FAULT_S = 60.0


class _LastFault(logging.Handler):
    """Remembers for a while the last fault that was logged."""

    def __init__(self) -> None:
        super().__init__()
        self._said, self._said_s = verbatim(""), -math.inf

    def emit(self, record: logging.LogRecord) -> None:
        if hasattr(record, SAID):
            self._said, self._said_s = getattr(record, SAID), time.monotonic()

    def last(self) -> Optional[Message]:
        return self._said if time.monotonic() - self._said_s < FAULT_S else None


class Diagnostics:
    """Publishes what `health` returns once a second, under the node's full name."""

    def __init__(self, hardware_id: str, health: Callable[[], Health]) -> None:
        self._health = health
        self._last_fault = _LastFault()
        LOGGER.addHandler(self._last_fault)
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(hardware_id)
        self._updater.add("state", self._fill)
        self._periodic = Periodic(PERIOD_S, self._updater.force_update)
        # It may be why the node ends.
        rospy.on_shutdown(lambda: self._last_fault.last() and self._updater.force_update())

    def _fill(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> Any:
        found: Health = (ERROR, verbatim(""), {})
        with faults_logged("diagnostics"):
            found = self._health()
        level, message, values = found
        fault = self._last_fault.last()
        if fault is not None:
            level, message = ERROR, fault
        status.summary(level, str(message))
        status.add(FAULT, message.to_json())
        for name, value in values.items():
            status.add(name, str(value))
        return status
