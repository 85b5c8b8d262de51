"""Writes a survey as fast as it can, and sends each acknowledgement."""

from __future__ import annotations

import contextlib
import json
import os
import time

from planned_survey import METADATA, POINTS, planned_trace
from storage_kit import Kit, text_message
from trace_examples import SURVEY

from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.recording.recordings import open_recordings

TRACES = [planned_trace(index) for index in range(len(POINTS))]
HALF = len(TRACES) // 2
ENDED = "finished"
RESUMED = ("reopening", "storing the rest", "last report", "finishing")
FIRST = ("opening", "storing", "report", "interrupting", *RESUMED)


class Child:
    """Writes the survey and reports what was acknowledged."""

    def __init__(self, data, connection):
        self._parent = os.getppid()
        self._connection = connection
        self._data = data
        self._kit = Kit(data, open_recordings)

    def run(self, resumed):
        """Write a whole survey, or what is missing of one that is there."""
        if not resumed:
            self._do("opening", "opened", lambda: self._kit.open(metadata_json=METADATA))
            self._store("storing", TRACES[:HALF])
            self._report("report", 1)
            self._do("interrupting", "interrupted", self._kit.processing.shut_down)
            self._kit = Kit(self._data, open_recordings)
        self._store("storing the rest", self._reopen())
        self._report("last report", 2)
        close = self._kit.processing.close_survey
        self._do("finishing", ENDED, lambda: close(SURVEY, "finished", ""))

    def _reopen(self):
        reopen = self._kit.processing.reopen_survey
        stored = self._do("reopening", "reopened", lambda: reopen(SURVEY)).stored_indices
        return [trace for trace in TRACES if trace.index not in stored]

    def _store(self, phase, traces):
        self._begin(phase)
        for trace in traces:
            self._kit.processing.record(text_message("/t", f"before {trace.index}"))
            self._repeat(
                "stored", trace.index, lambda trace=trace: self._kit.processing.store(trace)
            )

    def _report(self, phase, number):
        text = json.dumps({"number": number})
        self._do(phase, f"report {number}", lambda: self._kit.processing.report(SURVEY, text))

    def _do(self, phase, done, call):
        self._begin(phase)
        return self._repeat("done", done, call)

    def _begin(self, phase):
        now_s = time.monotonic()
        self._connection.send(("phase", phase, now_s, now_s))

    def _repeat(self, kind, value, call):
        """Repeat a call until the disk takes it, as the control does, or the parent is gone."""
        while os.getppid() == self._parent:
            begun_s = time.monotonic()
            with contextlib.suppress(StorageFailedError):
                result = call()
                self._connection.send((kind, value, begun_s, time.monotonic()))
                return result
        os._exit(1)


def run_child(data, connection, resumed, durable):
    """Run the child in its own process."""
    if not durable:
        os.fsync = os.fdatasync = lambda _descriptor: None
    try:
        Child(data, connection).run(resumed)
    except SurveyRefusedError:
        # A call that failed half way, because of the cut, is refused when it is repeated.
        os._exit(1)
    os._exit(0)
