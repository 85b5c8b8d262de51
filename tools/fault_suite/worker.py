"""What happens inside the process that asks the storage: each step, and what it sends of it."""

from __future__ import annotations

import enum
import json
import os
import time
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any, Container, Dict, Optional, Sequence, Set, Tuple

from failing_disk import MORE_CALLS, FailingDisk, Failure
from storage_kit import Kit, text_message

from fault_suite.evidence import survey_in
from fault_suite.script import METADATA, SURVEY, TRACES, Call, Step
from gpr20_survey.errors import ProcessingError, StorageFailedError
from gpr20_survey.folder.annotating import Fact, add_to_survey, annotate
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.annotation import from_values
from gpr20_survey.plan.markers import Marker, new_marker

MOST_REPEATS = 3  # after which a disk that does not recover is given up
START_LIMIT_S = 10.0
NOW = "2026-11-21T05:10:00.000000Z"
COMPLETE = "survey.complete"


class Broken(enum.Enum):
    """What a storage does wrong on purpose, so that the suite can show that it would be found."""

    NOTHING = "nothing"
    NO_FSYNC = "no-fsync"
    NO_MARKERS = "no-markers"


class Event(enum.Enum):
    """What a child sends."""

    ASKED = "asked"
    DONE = "done"
    REFUSED = "refused"
    COMPLETE = "complete"
    FAILED = "failed"
    ENDED = "ended"


Sent = Tuple[Event, int, float, float, str]
"""What happened, number of the step, when its call began and ended [s], and a text."""


@dataclass(frozen=True)
class Conduct:
    """How a child works, and what it does to its own calls of the disk.

    Attributes:
        failure: What fails; None: nothing.
        fails_from: Number of the step from which on the calls are counted.
        after_cut: Where what a power cut leaves is put.
        broken: What its storage does wrong.
        may_give_up: Whether it ends when the disk does not recover; else it repeats for ever.
        start: It begins together with the others that wait there.
        by_library: Whether it changes a survey that has ended by the functions that the command
            `gpr20 annotate` calls, not through a storage.
        continues: Whether it continues with the next step when one is refused.
    """

    failure: Optional[Failure] = None
    fails_from: int = 0
    after_cut: Path = Path()
    broken: Broken = Broken.NOTHING
    may_give_up: bool = False
    start: Optional[Barrier] = None
    by_library: bool = False
    continues: bool = False


def run(data: Path, steps: Sequence[Step], conduct: Conduct, connection: Connection) -> None:
    """Do the steps, send what happens, and end this process.

    Args:
        data: The data folder.
        steps: What is to be done.
        conduct: How.
        connection: Where it is sent.
    """
    disk = None
    if conduct.failure is not None:
        disk = FailingDisk(data, MORE_CALLS, on_cut=lambda: os._exit(0))
    if conduct.broken is Broken.NO_FSYNC:
        os.fsync = os.fdatasync = lambda _descriptor: None  # type: ignore[assignment]
    try:
        _Worker(data, steps, conduct, connection, disk).run()
    except Exception:
        connection.send((Event.FAILED, 0, 0.0, 0.0, traceback.format_exc()))
    if disk is not None:
        disk.end()
    os._exit(0)


class _Worker:
    def __init__(
        self,
        data: Path,
        steps: Sequence[Step],
        conduct: Conduct,
        connection: Connection,
        disk: Optional[FailingDisk],
    ) -> None:
        self._disk = disk
        self._parent = os.getppid()
        self._data, self._steps, self._conduct = data, steps, conduct
        self._connection = connection
        self._kit = self._new_kit()
        self._stored: Container[int] = ()
        self._passed_over: Set[str] = set()
        self._is_complete = self._is_failing = False

    def _new_kit(self) -> Kit:
        kit = Kit(self._data)
        if self._conduct.broken is Broken.NO_MARKERS:
            kit.add_marker = lambda *_: None  # type: ignore
            kit.remove_marker = lambda *_: None  # type: ignore
        return kit

    def run(self) -> None:
        """Do every step; end early where one is refused."""
        if self._conduct.start is not None:
            self._conduct.start.wait(START_LIMIT_S)
        for number, step in enumerate(self._steps):
            if self._is_to_do(step) and not self._do(number, step):
                break
        self._send(Event.ENDED, len(self._steps), time.monotonic(), self._calls_so_far)

    def _is_to_do(self, step: Step) -> bool:
        if self._is_complete and not step.ended:
            if step.call is Call.MARK:
                self._passed_over.add(step.value["marker_id"])
            return False
        if step.call is Call.UNMARK:
            return step.value not in self._passed_over
        return step.call is not Call.STORE or step.value not in self._stored

    def _do(self, number: int, step: Step) -> bool:
        """Repeat a call until the disk takes it, as the control does; return whether to go on."""
        begun_s = time.monotonic()
        if number >= self._conduct.fails_from and self._disk and not self._is_failing:
            self._is_failing = True
            self._disk.begin(self._conduct.failure, self._conduct.after_cut)
        self._send(Event.ASKED, number, begun_s, self._calls_so_far)
        repeats = 0
        while os.getppid() == self._parent:
            try:
                self._call(step)
            except StorageFailedError as error:
                repeats += 1
                if self._conduct.may_give_up and repeats > MOST_REPEATS:
                    self._send(Event.ENDED, number, begun_s, str(error))
                    os._exit(0)
            except ProcessingError as error:
                self._is_complete = error.message.fault_code == COMPLETE
                if not self._is_complete or step.call is not Call.REOPEN:
                    self._send(Event.REFUSED, number, begun_s, f"{step.phase}: {error}")
                    return self._conduct.continues
                self._send(Event.COMPLETE, number, begun_s)
                return True
            else:
                self._send(Event.DONE, number, begun_s)
                return True
            begun_s = time.monotonic()
        os._exit(1)

    @property
    def _calls_so_far(self) -> str:
        return str(self._disk.count) if self._disk else ""

    def _send(self, event: Event, number: int, begun_s: float, text: str = "") -> None:
        self._connection.send((event, number, begun_s, time.monotonic(), text))

    def _call(self, step: Step) -> None:
        if step.call is Call.INTERRUPT:
            self._kit.processing.shut_down()
            self._kit = self._new_kit()
        elif step.call is Call.OPEN:
            self._kit.open(metadata_json=METADATA)
        elif step.call is Call.REOPEN:
            self._stored = self._kit.processing.reopen_survey(SURVEY).stored_indices
        elif step.call is Call.STORE:
            self._kit.processing.record(text_message("/t", f"before {step.value}"))
            self._kit.processing.store(TRACES[step.value])
        else:
            self._add(step)

    def _add(self, step: Step) -> None:
        if self._conduct.by_library:
            self._add_by_library(step)
            return
        kit, processing = self._kit, self._kit.processing
        calls: Any = {
            Call.MARK: lambda: kit.add_marker(SURVEY, Marker(**step.value)),
            Call.UNMARK: lambda: kit.remove_marker(SURVEY, step.value, "Ana"),
            Call.ANNOTATE: lambda: kit.annotate(SURVEY, from_values(step.value)),
            Call.REPORT: lambda: kit.report(SURVEY, json.dumps(step.value)),
            Call.FINISH: lambda: processing.close_survey(SURVEY, "finished"),
            Call.STOP: lambda: processing.close_survey(SURVEY, "stopped"),
        }
        calls[step.call]()

    def _add_by_library(self, step: Step) -> None:
        folder = survey_in(self._data)
        assert folder is not None
        if step.call is Call.ANNOTATE:
            change = annotate(from_values(step.value))
        else:
            marker = Marker(**step.value)
            change = lambda values: _added(new_marker(values, marker, NOW))  # noqa: E731
        add_to_survey(folder, change, NOW)


def _added(values: Optional[Dict[str, Any]]) -> Optional[Fact]:
    return None if values is None else Fact(Kind.MARKER, values)
