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
# For so long an exception that nobody expected, in any thread, and a remark are said [s].
FAULT_S = 60.0


class _LastSaid(logging.Handler):
    """Remembers for a while the last fault that was logged, and the last remark."""

    def __init__(self) -> None:
        super().__init__()
        self._said: Dict[bool, Tuple[Message, float]] = {}

    def emit(self, record: logging.LogRecord) -> None:
        said = getattr(record, SAID, None)
        if said is not None:
            self._said[bool(said.fault)] = said, time.monotonic()

    def last(self, is_fault: bool) -> Optional[Message]:
        said, said_s = self._said.get(is_fault, (None, -math.inf))
        return said if time.monotonic() - said_s < FAULT_S else None


class Diagnostics:
    """Publishes what `health` returns once a second, under the node's full name."""

    def __init__(self, hardware_id: str, health: Callable[[], Health]) -> None:
        self._health = health
        self._said = _LastSaid()
        LOGGER.addHandler(self._said)
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(hardware_id)
        self._updater.add("state", self._fill)
        self._periodic = Periodic(PERIOD_S, self._updater.force_update)
        # It may be why the node ends.
        rospy.on_shutdown(lambda: self._said.last(is_fault=True) and self._updater.force_update())

    def _fill(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> Any:
        found: Health = (ERROR, verbatim(""), {})
        with faults_logged("diagnostics"):
            found = self._health()
        level, message, values = found
        remark, fault = self._said.last(is_fault=False), self._said.last(is_fault=True)
        if remark is not None and level == OK:
            level, message = WARN, remark
        if fault is not None:
            level, message = ERROR, fault
        status.summary(level, str(message))
        status.add(FAULT, message.to_json())
        for name, value in values.items():
            status.add(name, str(value))
        return status
