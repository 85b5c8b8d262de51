"""The 1 Hz report of a node on /diagnostics."""

from __future__ import annotations

from typing import Any, Callable, Dict, Tuple

import diagnostic_updater

from gpr20_common.high.periodic import Periodic
from gpr20_common.message import Message

OK = 0
WARN = 1
ERROR = 2

# Level, one sentence, and named values.
Health = Tuple[int, Message, Dict[str, Any]]
# Name of the value that holds the sentence's template and values.
MESSAGE_JSON = "message_json"
# Name of the value that holds the code of the fault; empty: none.
FAULT_CODE = "fault_code"

PERIOD_S = 1.0


class Diagnostics:
    """Publishes what `health` returns once a second, under the node's full name."""

    def __init__(self, hardware_id: str, health: Callable[[], Health]) -> None:
        self._health = health
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(hardware_id)
        self._updater.add("state", self._fill)
        self._periodic = Periodic(PERIOD_S, self._updater.force_update)

    def _fill(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> Any:
        level, message, values = self._health()
        status.summary(level, str(message))
        status.add(MESSAGE_JSON, message.to_json())
        status.add(FAULT_CODE, message.fault_code)
        for name, value in values.items():
            status.add(name, str(value))
        return status
