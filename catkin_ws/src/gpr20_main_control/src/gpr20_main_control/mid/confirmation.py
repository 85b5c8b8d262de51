"""Confirming a sweep while the axes move, and storing its trace once it is confirmed."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Callable, Optional, Tuple

from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace.trace import Trace


class Confirmation:
    """The confirmation of one trace: it is stored once, when it is confirmed, or never.

    `run` is called in the background. The survey may give the trace up at any moment, to measure
    its point again.
    """

    def __init__(
        self,
        trace: Trace,
        confirm: Callable[[], Tuple[str, ...]],
        store: Callable[[Trace], None],
    ) -> None:
        """Begin nothing yet.

        Args:
            trace: What was measured.
            confirm: Returns further remarks on its quality; raises if it is not confirmed.
            store: Accepts the trace for storing; returns at once.
        """
        self._trace = trace
        self._confirm = confirm
        self._store = store
        self._lock = threading.Lock()
        self._given_up = False
        self._stored: Optional[Trace] = None

    def run(self) -> Trace:
        """Confirm the trace, pass it to the storage and return it.

        Raises:
            UnconfirmedError: It was not confirmed.
            DeviceError: Nobody knows whether it would have been, or the trace was given up.
        """
        trace = self._with_remarks(self._confirm())
        with self._lock:
            if self._given_up:
                raise DeviceError(Message("the confirmation came too late"))
            self._stored = trace
            self._store(trace)
        return trace

    def give_up(self) -> Optional[Trace]:
        """Make sure that the trace is never stored, or return it if it is accepted already."""
        with self._lock:
            self._given_up = True
            return self._stored

    def _with_remarks(self, remarks: Tuple[str, ...]) -> Trace:
        if not remarks:
            return self._trace
        try:
            return replace(self._trace, quality=(*self._trace.quality, *remarks))
        except TraceRefusedError as error:
            raise DeviceError(error.message) from error
