"""Focused images, candidates and exports of the surveys in the data folder."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

from gpr20_common.catalogue import languages
from gpr20_common.faults import ASKED_FOR, NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_imaging import faults
from gpr20_imaging.errors import ImagingError
from gpr20_imaging.low.analysis_process import AnalysisProcess
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_imaging.low.child_process import lower_this_thread
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_imaging.mid.export_kind import ExportKind
from gpr20_imaging.mid.exporting import Exporter, ExportRequest
from gpr20_imaging.mid.job_queue import JobQueue, Result
from gpr20_survey.folder.recovery import find_survey
from gpr20_survey.radar.soils import requested_permittivity
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_survey.results.hidden_target import target_of
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_survey.results.volume import Volume

MOST_ID_CHARACTERS = 64
# Memory is given back if nobody looks at images for so long [s].
IDLE_S = 60.0
Progress = Callable[[str, Message], None]
"""Called with the id of a request and what is done for it."""


class Imaging:
    """Carries out the requests, one at a time and with the lowest priority.

    Args:
        data: Folder of the surveys.
        analysis: The analysis.
        volumes: The sticks.
        progress: Called with what is done for a request.
    """

    def __init__(
        self, data: Path, analysis: AnalysisProcess, volumes: UsbVolumes, progress: Progress
    ) -> None:
        self._data = data
        self._analysis = analysis
        self._volumes = volumes
        self._progress = progress
        self._jobs = JobQueue(lower_this_thread, analysis.close, IDLE_S)
        self.computer = socket.gethostname()

    @property
    def requests(self) -> int:
        """Number of requests that wait or are carried out."""
        return self._jobs.waiting

    @property
    def missing(self) -> Optional[Message]:
        """What is missing on this computer; None if nothing is."""
        if self._analysis.is_installed:
            return None
        return Message(
            "The analysis is not installed on the computer {computer}: no focused image, "
            "candidates or report. Install it there with scripts/setup.sh, or copy the survey to "
            "a computer that has it.",
            computer=self.computer,
        ).with_fault(faults.OTHER_COMPUTER)

    def focus(self, request_id: str, survey: str, permittivity: float) -> FocusedImage:
        """Return the focused image of what is stored of a survey.

        Args:
            request_id: For `cancel`.
            survey: Its id, or the name of its folder.
            permittivity: Relative permittivity of the ground; 0: what the survey says.

        Raises:
            Gpr20Error: There is no image; the message says why.
        """
        value = requested_permittivity(permittivity)
        self._require_analysis()
        folder, _ = find_survey(self._data, survey)
        return self._run(request_id, lambda stop: self._analysis.focus(folder, value, stop))

    def map_hidden(
        self, request_id: str, survey: str, permittivity: float, target: str
    ) -> HidingMap:
        """Return where a target could hide in a survey.

        Args:
            request_id: For `cancel`.
            survey: Its id, or the name of its folder.
            permittivity: Relative permittivity of the ground; 0: what the survey says.
            target: As for `target_of`.

        Raises:
            Gpr20Error: There is no map; the message says why.
        """
        value = requested_permittivity(permittivity)
        target_of(target)
        self._require_analysis()
        folder, _ = find_survey(self._data, survey)
        return self._run(
            request_id, lambda stop: self._analysis.map_hidden(folder, value, target, stop)
        )

    def export(
        self,
        request_id: str,
        survey: str,
        kinds: Sequence[str],
        permittivity: float,
        language: str,
        volume: str,
    ) -> Tuple[List[str], bytes]:
        """Write parts of a survey to a stick; return the names of the files.

        Args:
            request_id: For `cancel`.
            survey: Its id, or the name of its folder.
            kinds: Values of `ExportKind`.
            permittivity: Relative permittivity of the ground; 0: what the survey says.
            language: Code of the language of reports.
            volume: Path of the stick; empty: the content of the only file is returned too.

        Raises:
            Gpr20Error: The export failed; the message says why.
        """
        value = requested_permittivity(permittivity)
        _check_language(language)
        chosen = tuple(dict.fromkeys(ExportKind.of(one) for one in kinds))
        if not chosen:
            raise ImagingError(Message("Choose what to export."), fault=NOT_ALLOWED)
        if any(one.analysis for one in chosen):
            self._require_analysis()
        folder, found = find_survey(self._data, survey)
        simulated = found.description.get("simulated") is not False
        request = ExportRequest(folder, simulated, chosen, value, language, volume)
        exporter = Exporter(
            self._analysis, self._volumes, lambda stage: self._progress(request_id, stage)
        )
        if not volume:
            name, content = self._run(request_id, lambda stop: exporter.make(request, stop))
            return [name], content
        return self._run(request_id, lambda stop: exporter.export(request, stop)), b""

    def volumes(self) -> List[Volume]:
        """Return the sticks that are mounted on this computer.

        Raises:
            ImagingError: They cannot be listed.
        """
        return self._volumes.mounted()

    def cancel(self, request_id: str) -> None:
        """End a request, or take it from the queue.

        Raises:
            ImagingError: There is none of this name.
        """
        if not request_id or not self._jobs.cancel(request_id):
            raise ImagingError(
                Message("There is no such request; it may have ended."), fault=ASKED_FOR
            )

    def close(self) -> None:
        """End every request and every child process."""
        self._jobs.close()

    def _run(self, request_id: str, work: Callable[[Cancellation], Result]) -> Result:
        if len(request_id) > MOST_ID_CHARACTERS:
            raise ImagingError(
                Message(
                    "request_id has {count} characters; at most {most} are allowed",
                    count=len(request_id),
                    most=MOST_ID_CHARACTERS,
                ),
                fault=NOT_ALLOWED,
            )
        return self._jobs.run(request_id, work)

    def _require_analysis(self) -> None:
        missing = self.missing
        if missing is not None:
            raise ImagingError(missing)


def health_values(imaging: Imaging) -> Dict[str, Any]:
    """Return what diagnostics show."""
    return {"computer": imaging.computer, "requests": imaging.requests}


def _check_language(language: str) -> None:
    known = [one.value for one in languages()]
    if language not in known:
        raise ImagingError(
            Message(
                "the language is {language}; allowed: {languages}",
                language=repr(language[:16]),
                languages=", ".join(known),
            ),
            fault=NOT_ALLOWED,
        )
