"""A process that asks the storage for a random course of steps, and says what it acknowledged."""

from __future__ import annotations

import contextlib
import enum
import json
import multiprocessing
import os
import random
import signal
import traceback
import uuid
from multiprocessing.context import ForkProcess
from pathlib import Path
from typing import Any, Collection, Dict, Iterator, List, NamedTuple, Optional, Sequence, Tuple

from failing_disk import MORE_CALLS, FailingDisk, Failure
from storage_kit import Kit, text_message
from trace_examples import METADATA, POINTS, SURVEY, planned_trace

from gpr20_survey.errors import ProcessingError, StorageFailedError
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import Fact
from gpr20_vna_processing.mid.data_processing import DataProcessing

TRACES = dict(enumerate(map(planned_trace, range(len(POINTS)))))
TIME = "2026-11-21T05:10:00.000000+00:00"
WORDS = ("metal", "raíz", "日本", "=1+1", "a, b; c", '"', "\\u0041", "")
# What may be added to a survey that is closed, and to one that is open.
CLOSED_KINDS = (Kind.MARKER, Kind.ANNOTATION, Kind.DECISION)
OPEN_KINDS = (*CLOSED_KINDS, Kind.REPORT)
# Before each trace: how often one more fact is added, and how often the survey is closed.
FACT_SHARE, CLOSED_SHARE = 0.4, 0.1
MOST_ATTEMPTS = 4  # after which a disk that does not recover is given up
IS_COMPLETE = "survey.complete"

# What is asked of the storage; for a close the outcome.
Call = enum.Enum("Call", "OPEN REOPEN STORE ADD SHUT_DOWN STOPPED FINISHED")
# What a worker says of a step; broken: there was no answer, or a new survey was refused.
Event = enum.Enum("Event", "ASKED DONE FAILED REFUSED BROKEN")


class Step(NamedTuple):
    """One call, with the index of the trace, or the fact and what no other one contains."""

    call: Call
    trace: int = -1
    fact: Optional[Fact] = None
    mark: bytes = b""

    @property
    def phase(self) -> str:
        """What is being done."""
        return self.call.name.lower() + (f" {self.fact.kind.value}" if self.fact else "")


def new_course(chance: random.Random, begins: bool) -> List[Step]:
    """Return a new survey, or the rest of one that was cut off, to its end and after it."""
    steps = [Step(Call.OPEN if begins else Call.REOPEN)]
    for index in TRACES:
        while chance.random() < FACT_SHARE:
            steps.append(_addition(chance, OPEN_KINDS))
        steps.append(Step(Call.STORE, index))
        if chance.random() < CLOSED_SHARE:
            steps.append(Step(chance.choice([Call.SHUT_DOWN, Call.STOPPED])))
            steps += [_addition(chance, CLOSED_KINDS), Step(Call.REOPEN)]
    more = [_addition(chance, CLOSED_KINDS) for _ in range(chance.randint(1, 4))]
    return [*steps, Step(Call.FINISHED), *more]


def _addition(chance: random.Random, kinds: Sequence[Kind]) -> Step:
    kind, identity = chance.choice(kinds), str(uuid.UUID(int=chance.getrandbits(128), version=4))
    # No other fact has this text.
    text = " ".join([*chance.choices(WORDS, k=chance.randint(0, 5)), identity]).strip()
    marker = {"x_mm": 0.1, "y_mm": 700.0, "depth_mm": None, "author": "Ana", "text": text}
    others: Dict[Kind, Dict[str, Any]] = {
        Kind.MARKER: {**marker, "marker_id": identity},
        Kind.ANNOTATION: {"operator": "", "site": "", "notes": f"1\n{text}", "position": None},
    }
    fact = Fact(kind, others.get(kind, {"time": TIME, "text": text}))
    return Step(Call.ADD, fact=fact, mark=identity.encode())


def new_storage(data: Path) -> Kit:
    """Return a storage as that of the robot."""
    return Kit(data)


def add_fact(processing: DataProcessing, fact: Fact) -> None:
    """Ask for a fact in the survey, open or not."""
    processing.add_fact(SURVEY, fact.kind.value, json.dumps(fact.values))


class Worker(ForkProcess):
    """It begins at once.

    Args:
        data: The data folder.
        steps: What it asks.
        fails_from: The step from which on its disk fails.
        failure: How that fails; None: it does not.
        after_cut: Where a cut of its power leaves the data folder.
    """

    def __init__(
        self,
        data: Path,
        steps: Sequence[Step],
        fails_from: int = 0,
        failure: Optional[Failure] = None,
        after_cut: Path = Path(),
    ) -> None:
        super().__init__(daemon=True)
        self.steps, self.said = steps, [(Event.ASKED, -1, "")][1:]
        self._data, self._failure, self._after_cut = data, failure, after_cut
        self._fails_from = fails_from
        self._stored: Collection[int] = ()
        self._hears, self._says = multiprocessing.Pipe(duplex=False)
        self.start()
        self._says.close()

    def wait_for(self, number: int) -> None:
        """Return when a step begins, or the worker ends."""
        next((one for one in self._hear() if one[0] is Event.ASKED and one[1] >= number), None)

    def freeze(self) -> None:
        """Halt it: what it has said was so before anything that happens from now on."""
        with contextlib.suppress(ChildProcessError, ProcessLookupError):
            os.kill(self.pid or 0, signal.SIGSTOP)
            os.waitid(os.P_PID, self.pid or 0, os.WSTOPPED | os.WEXITED | os.WNOWAIT)

    def end(self, kill: bool = False) -> bool:
        """Kill it or wait for its end; end all that it has started; return if it was killed."""
        if kill:
            self.kill()
        for _ in self._hear():
            pass
        self.join()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid or 0, signal.SIGKILL)
        self._hears.close()
        if self.exitcode not in (0, -signal.SIGKILL):
            self.said.append((Event.BROKEN, 0, f"ended with status {self.exitcode}"))
        return self.exitcode == -signal.SIGKILL

    def texts(self, event: Event) -> List[str]:
        """Return what it said of an event."""
        return [text for one, _number, text in self.said if one is event]

    def _hear(self) -> Iterator[Tuple[Event, int, str]]:
        # It may end in the middle of a word.
        with contextlib.suppress(EOFError, OSError):
            while True:
                self.said.append(self._hears.recv())
                yield self.said[-1]

    def run(self) -> None:
        """Do the steps, in the new process."""
        os.setsid()
        disk = None
        if self._failure is not None:
            disk = FailingDisk(self._data, MORE_CALLS, on_cut=lambda: os._exit(0))
        self._kit = new_storage(self._data)
        for number, step in enumerate(self.steps):
            if disk and number == self._fails_from:
                disk.begin(self._failure, self._after_cut)
            # A call is repeated until the disk takes it, as the control does.
            for _ in range(0 if step.trace in self._stored else MOST_ATTEMPTS):
                self._says.send((Event.ASKED, number, ""))
                event, text = self._answer(step)
                self._says.send((event, number, text))
                if event is not Event.FAILED:
                    break
        if disk is not None:
            disk.end()
        # Like a crash: the storage is not shut down.
        os._exit(0)

    def _answer(self, step: Step) -> Tuple[Event, str]:
        try:
            self._call(step)
        except StorageFailedError as error:
            return Event.FAILED, str(error)
        except ProcessingError as error:
            if error.message.fault_code == IS_COMPLETE:
                self._stored = TRACES
            return Event.BROKEN if step.call is Call.OPEN else Event.REFUSED, str(error)
        except Exception:
            return Event.BROKEN, traceback.format_exc(limit=-1)
        return Event.DONE, ""

    def _call(self, step: Step) -> None:
        processing = self._kit.processing
        if step.call is Call.OPEN:
            self._kit.open(metadata_json=METADATA)
        elif step.call is Call.REOPEN:
            self._stored = processing.reopen_survey(SURVEY).stored_indices
        elif step.call is Call.STORE:
            processing.record(text_message("/t", f"before {step.trace}"))
            processing.store(TRACES[step.trace])
            if [one.index for one in self._kit.stored].count(step.trace) != 1:
                raise AssertionError(f"trace {step.trace} was not published once")
        elif step.fact is not None:
            add_fact(processing, step.fact)
        elif step.call is Call.SHUT_DOWN:
            processing.shut_down()
            self._kit = new_storage(self._data)
        else:
            processing.close_survey(SURVEY, step.call.name.lower())
