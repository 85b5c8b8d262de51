"""Requests for images, candidates, maps and exports of the surveys in the data folder."""

from __future__ import annotations

import os
import socket
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

from gpr20_common.catalogue import language_from_code
from gpr20_common.faults import ASKED_FOR, BUSY, NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_imaging.faults import OTHER_COMPUTER, ImagingError
from gpr20_imaging.low.worker_process import WorkerProcess
from gpr20_imaging.mid.exporting import ExportRequest
from gpr20_survey.errors import storing
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import RecoveredSurvey, find_survey
from gpr20_survey.folder.survey_folder import TRACES_FOLDER
from gpr20_survey.radar import requested_permittivity
from gpr20_survey.results.answers import ExportPart, FocusedImage
from gpr20_survey.results.candidates import CandidateList
from gpr20_survey.results.hiding_map import HidingMap, target_of

MOST_WAITING = 8
# The last with a stick of the slowest kind.
FOCUS_LIMIT_S, LIMIT_S, EXPORT_LIMIT_S = 300.0, 1800.0, 7200.0
# Images are large.
MOST_KEPT = 6
# What people add to a survey that changes no answer.
ADDED = frozenset((Kind.FOUND, Kind.MARKER, Kind.MARKER_REMOVED, Kind.EXPORT, Kind.AUDIT, Kind.BAG))


@dataclass(frozen=True)
class ImagingParameters:
    """The parameters of the node.

    Attributes:
        data: Folder of the surveys; empty: $GPR20_DATA, or ~/gpr20_data if that is not set.
    """

    data: str = ""


@dataclass
class _Request:
    id: str
    is_cancelled: bool = False

    def check(self) -> None:
        if self.is_cancelled:
            raise ImagingError(Message("The request was cancelled."), fault=ASKED_FOR)


class Imaging:
    """Carries out the requests, one at a time; each caller waits for its own.

    A request has an id for `cancel`. A survey is its id, or the name of its folder; permittivity 0
    is what the survey says. What cannot be done raises a `Gpr20Error` that says why.

    Args:
        data: Folder of the surveys.
        worker: Does the work.
        progress: Called with the id of a request and what is done for it.
        found: Called with each list of candidates that is new.
    """

    def __init__(
        self,
        data: Path,
        worker: WorkerProcess,
        progress: Callable[[str, Message], None],
        found: Callable[[CandidateList], None] = lambda _found: None,
    ) -> None:
        self._data, self._worker = data, worker
        self._progress, self._found = progress, found
        # The last image of each survey and permittivity; None: what the survey says.
        self._kept: Dict[Tuple[str, Optional[float]], Tuple[object, FocusedImage]] = {}
        # The worker is killed with the thread that has started it.
        self._queue = ThreadPoolExecutor(1, "imaging")
        self._lock = threading.Lock()
        self._requests: List[_Request] = []
        self._running: Optional[_Request] = None
        self._is_closed = False
        self.computer = socket.gethostname()

    @property
    def requests(self) -> int:
        """Number of requests that wait or are carried out."""
        return len(self._requests)

    @property
    def missing(self) -> Optional[Message]:
        """What is missing on this computer; None if nothing is."""
        if self._worker.has_analysis:
            return None
        return Message(
            "The analysis is not installed on the computer {computer}: no focused image, "
            "candidates or report. Install it there with scripts/setup.sh, or copy the survey to "
            "a computer that has it.",
            computer=self.computer,
        ).with_fault(OTHER_COMPUTER)

    def focus(
        self, request_id: str, survey: str, permittivity: float, only_known: bool = False
    ) -> FocusedImage:
        """Return the focused image of what is stored of a survey.

        Whoever asks gets what anybody has found before, unless what it was made of has changed;
        only_known: and nothing is searched.
        """
        value = requested_permittivity(permittivity)
        self._require_analysis()
        folder, recovered = find_survey(self._data, survey)
        state, wanted = _state_of(folder, recovered), (folder.name, value)

        def known() -> Optional[FocusedImage]:
            before, image = self._kept.get(wanted, (None, None))
            return image if before == state else None

        def search(request: _Request) -> FocusedImage:
            # Who waited before this one may have asked for the same.
            image = known()
            if image is None:
                image = self._ask(FOCUS_LIMIT_S, "focus", (folder, value), request)
                self._kept.pop(wanted, None)
                self._kept[wanted] = state, image
                if len(self._kept) > MOST_KEPT:
                    del self._kept[next(iter(self._kept))]
                self._found(image.found)
            return image

        image = known()
        if image is None and only_known:
            raise ImagingError(Message("this survey was not searched yet"), fault=ASKED_FOR)
        return self._run(request_id, search) if image is None else image

    def map_hidden(
        self, request_id: str, survey: str, permittivity: float, target: str
    ) -> HidingMap:
        """Return where a target, as for `target_of`, could hide in a survey."""
        value = requested_permittivity(permittivity)
        target_of(target)
        self._require_analysis()
        folder, _ = find_survey(self._data, survey)
        work = partial(self._ask, LIMIT_S, "map_hidden", (folder, value, target))
        found: HidingMap = self._run(request_id, work)
        return found

    def export(
        self,
        request_id: str,
        survey: str,
        kinds: Sequence[str],
        permittivity: float,
        language: str,
        volume: str,
    ) -> Tuple[List[str], bytes]:
        """Write parts of a survey to a stick, see `ExportRequest`; return the names of the files.

        Kinds are values of `ExportPart`. Without a stick the content of the only file comes too.
        """
        value = requested_permittivity(permittivity)
        language_from_code(language[:16])
        chosen = tuple(one for one in ExportPart if one.value in kinds)
        if not chosen or len(chosen) != len(set(kinds)):
            allowed = ", ".join(one.value for one in ExportPart)
            raise ImagingError(
                Message("choose what to export; allowed: {kinds}", kinds=allowed), fault=NOT_ALLOWED
            )
        if chosen != (ExportPart.SURVEY_ZIP,):
            self._require_analysis()
        folder, found = find_survey(self._data, survey)
        simulated = found.description.get("simulated") is not False
        request = ExportRequest(folder, simulated, chosen, value, language, volume)
        if not volume:
            name, content = self._run(request_id, partial(self._ask, LIMIT_S, "make", (request,)))
            return [name], content
        work = partial(self._ask, EXPORT_LIMIT_S, "export", (request,))
        return self._run(request_id, work), b""

    def cancel(self, request_id: str) -> None:
        """End a request, or take it from the queue.

        Raises:
            ImagingError: There is none of this name.
        """
        with self._lock:
            found = [one for one in self._requests if request_id and one.id == request_id]
            for one in found:
                one.is_cancelled = True
            if self._running in found:
                self._worker.end()
        if not found:
            raise ImagingError(
                Message("There is no such request; it may have ended."), fault=ASKED_FOR
            )

    def close(self) -> None:
        """End every request and the worker."""
        with self._lock:
            self._is_closed = True
            for one in self._requests:
                one.is_cancelled = True
            self._worker.end()
        self._queue.shutdown()
        self._worker.close()

    def _run(self, request_id: str, work: Callable[[_Request], Any]) -> Any:
        """Return what a request gives, when it is its turn."""
        request = _Request(request_id)
        with self._lock:
            if self._is_closed or len(self._requests) >= MOST_WAITING:
                raise ImagingError(
                    Message("Too many requests are waiting. Try again later."), fault=BUSY
                )
            self._requests.append(request)
            answer = self._queue.submit(work, request)
        try:
            return answer.result()
        except ImagingError:
            # Its worker may have been ended for that.
            request.check()
            raise
        finally:
            with self._lock:
                self._requests.remove(request)

    def _ask(self, limit_s: float, name: str, arguments: Tuple, request: _Request) -> Any:
        request.check()
        self._worker.start()
        with self._lock:
            request.check()
            self._running = request
        try:
            return self._worker.ask(
                limit_s, lambda stage: self._progress(request.id, stage), name, *arguments
            )
        finally:
            with self._lock:
                self._running = None

    def _require_analysis(self) -> None:
        missing = self.missing
        if missing is not None:
            raise ImagingError(missing)


def _state_of(folder: Path, survey: RecoveredSurvey) -> object:
    """Return what an answer depends on: the traces, and facts, of which none ever changes."""
    facts = (one.number for one in survey.found.records if one.kind not in ADDED)
    with storing(Message("the survey could not be read"), folder):
        traces = [one.stat() for one in os.scandir(str(folder / TRACES_FOLDER))]
    files = ((one.st_ino, one.st_mtime_ns, one.st_size) for one in traces)
    return (*facts, *survey.unconfirmed), frozenset(files)
