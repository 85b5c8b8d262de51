"""The export of a survey to a USB stick, which the imaging node makes."""

from __future__ import annotations

import enum
from typing import Callable, FrozenSet, Optional, Tuple

from gpr20_common.message import Message
from gpr20_operator.jobs.imaging import (
    ExportDone,
    ExportRequests,
    RequestFailed,
    RequestProgress,
    VolumesFailed,
    VolumesListed,
    new_request_id,
)
from gpr20_operator.jobs.search import entered_permittivity
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_survey.results.volume import Volume

# A stick that is plugged in shows within this time [s].
LIST_PERIOD_S = 2.0
EXPORT_WAITS = Message("A survey is running. Export when it has ended.")
EXPORT_CANCELLED = Message("The export was cancelled. No unfinished file was left on the stick.")


class ExportPart(enum.Enum):
    """What can be exported, as the imaging node calls it."""

    REPORT_HTML = "report-html"
    REPORT_PDF = "report-pdf"
    CANDIDATES_CSV = "candidates-csv"
    CANDIDATES_GEOJSON = "candidates-geojson"
    SURVEY_ZIP = "survey-zip"


class ExportState(enum.Enum):
    """What the export does."""

    READY = "ready"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


class SurveyExport:
    """One export at a time, never begun during a survey. Belongs to one thread.

    Args:
        requests: The imaging node.
        now_s: A clock that never goes back [s].

    Attributes:
        survey: The survey in question; None before the first.
        state: What the export does.
        parts: What is to be exported.
        computer: Name of the computer in which the stick must be; empty if it is not known yet.
        volumes: The sticks.
        volume: Path of the chosen stick; empty: none.
        stage: What is being done; None if that is not known.
        problem: Why nothing was exported, or why there is no list of sticks; None: no problem.
        files: What is on the stick, when it is done.
        revision: Changes with everything that a view shows of this.
    """

    def __init__(self, requests: ExportRequests, now_s: Callable[[], float]) -> None:
        self._requests = requests
        self._now_s = now_s
        self._request_id = ""
        self._listed_s = -LIST_PERIOD_S
        self._survey_runs = False
        self.survey: Optional[SurveySummary] = None
        self.state = ExportState.READY
        self.parts: FrozenSet[ExportPart] = frozenset({ExportPart.REPORT_PDF})
        self.computer = ""
        self.volumes: Tuple[Volume, ...] = ()
        self.volume = ""
        self.stage: Optional[Message] = None
        self.problem: Optional[Message] = None
        self.files: Tuple[str, ...] = ()
        self.revision = 0

    @property
    def can_start(self) -> bool:
        """Whether an export can start now."""
        return (
            self.survey is not None
            and not self._survey_runs
            and self.state is not ExportState.RUNNING
            and bool(self.parts)
            and bool(self.volume)
        )

    def choose(self, survey: SurveySummary) -> None:
        """Choose a survey; an export that runs continues with its own."""
        if self.state is not ExportState.RUNNING:
            self.survey = survey
            self._rest(ExportState.READY, EXPORT_WAITS if self._survey_runs else None)

    def set_survey_runs(self, runs: bool) -> None:
        """Note whether a survey is running."""
        if runs == self._survey_runs:
            return
        self._survey_runs = runs
        if self.state is ExportState.READY:
            self._rest(ExportState.READY, EXPORT_WAITS if runs else None)

    def toggle(self, part: ExportPart) -> None:
        """Add or remove a part."""
        self.parts = self.parts ^ {part}
        self.revision += 1

    def choose_volume(self, path: str) -> None:
        """Choose a stick."""
        self.volume = path
        self.revision += 1

    def look_for_sticks(self) -> None:
        """Ask for the sticks, if that was not done just now; while the sheet is open."""
        if (
            self._now_s() - self._listed_s >= LIST_PERIOD_S
            and self.state is not ExportState.RUNNING
        ):
            self._listed_s = self._now_s()
            self._requests.list_volumes()

    def start(self, permittivity: str, language: str) -> None:
        """Start the export.

        Args:
            permittivity: As it was entered and checked; empty: not known.
            language: Code of the language of reports.
        """
        if not self.can_start or self.survey is None:
            return
        self._request_id = new_request_id()
        self._rest(ExportState.RUNNING, None)
        self._requests.export(
            self._request_id,
            self.survey.folder,
            [one.value for one in ExportPart if one in self.parts],
            entered_permittivity(permittivity),
            language,
            self.volume,
        )

    def cancel(self) -> None:
        """End an export that is running."""
        if self.state is ExportState.RUNNING:
            self._requests.cancel(self._request_id)
            self._rest(ExportState.READY, EXPORT_CANCELLED)

    def on_event(self, event: object) -> None:
        """Take the sticks, the progress and the end of the export; ignore other events."""
        if isinstance(event, VolumesListed):
            self._take_volumes(event)
        elif isinstance(event, VolumesFailed) and self.state is ExportState.READY:
            self.volumes, self.volume = (), ""
            self._rest(ExportState.READY, event.reason)
        elif isinstance(event, (ExportDone, RequestFailed, RequestProgress)):
            self._take_progress(event)

    def _take_volumes(self, event: VolumesListed) -> None:
        if (event.computer, event.volumes) == (self.computer, self.volumes):
            return
        self.computer, self.volumes = event.computer, event.volumes
        paths = [one.path for one in event.volumes if one.writable]
        if self.volume not in paths:
            self.volume = paths[0] if len(paths) == 1 else ""
        self.revision += 1

    def _take_progress(self, event: object) -> None:
        if self.state is not ExportState.RUNNING:
            return
        if getattr(event, "request_id", "") != self._request_id:
            return
        if isinstance(event, RequestProgress):
            self.stage = event.stage
            self.revision += 1
        elif isinstance(event, RequestFailed):
            self._rest(ExportState.FAILED, event.reason)
        elif isinstance(event, ExportDone):
            self._rest(ExportState.DONE, None)
            self.files = event.files

    def _rest(self, state: ExportState, problem: Optional[Message]) -> None:
        self.state, self.problem, self.stage, self.files = state, problem, None, ()
        self.revision += 1
