"""The 1 Hz report of a node on /diagnostics."""

from __future__ import annotations

import logging
import math
import time
from typing import Any, Callable, Dict, Tuple

import diagnostic_updater
import rospy

from gpr20_common.faults import INTERNAL
from gpr20_common.high.periodic import Periodic
from gpr20_common.low.thread_fault import LOGGER, PART, REMARK, faults_logged
from gpr20_common.message import Message, verbatim

OK, WARN, ERROR = 0, 1, 2

# Level, one sentence, and named values.
Health = Tuple[int, Message, Dict[str, Any]]
# Name of the value that holds the sentence with its fault, as JSON.
FAULT = "fault"

PERIOD_S = 1.0
# For so long an exception that nobody expected, in any thread, and a remark are said [s].
FAULT_S = 60.0


class _LastLogged(logging.Handler):
    """Remembers for a while what was logged last under an attribute; None: nothing."""

    def __init__(self, attribute: str) -> None:
        super().__init__()
        self._attribute, self._logged, self._logged_s = attribute, None, -math.inf

    def emit(self, record: logging.LogRecord) -> None:
        if hasattr(record, self._attribute):
            self._logged, self._logged_s = getattr(record, self._attribute), time.monotonic()

    @property
    def now(self) -> Any:
        return self._logged if time.monotonic() - self._logged_s < FAULT_S else None


class Diagnostics:
    """Publishes what `health` returns once a second, under the node's full name."""

    def __init__(self, hardware_id: str, health: Callable[[], Health]) -> None:
        self._health = health
        self._failed, self._remark = _LastLogged(PART), _LastLogged(REMARK)
        LOGGER.addHandler(self._failed)
        LOGGER.addHandler(self._remark)
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(hardware_id)
        self._updater.add("state", self._fill)
        self._periodic = Periodic(PERIOD_S, self._updater.force_update)
        # It may be why the node ends.
        rospy.on_shutdown(lambda: self._failed.now and self._updater.force_update())

    def _fill(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> Any:
        found: Health = (ERROR, verbatim(""), {})
        with faults_logged("diagnostics"):
            found = self._health()
        level, message, values = found
        remark, failed_part = self._remark.now, self._failed.now
        if remark is not None and level == OK:
            level, message = WARN, remark
        if failed_part is not None:
            failed = Message("internal error in {service}; see the log", service=failed_part)
            level, message = ERROR, failed.with_fault(INTERNAL)
        status.summary(level, str(message))
        status.add(FAULT, message.to_json())
        for name, value in values.items():
            status.add(name, str(value))
        return status
