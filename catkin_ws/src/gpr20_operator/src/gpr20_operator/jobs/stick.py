"""The export of a survey to a USB stick: with one stick there, it begins by itself."""

from __future__ import annotations

from typing import Any, Dict, FrozenSet, Optional, Tuple

from gpr20_common.message import Message
from gpr20_operator.jobs.job import Job, JobState, Service
from gpr20_operator.jobs.pictures import Exported, Imaging, Sticks
from gpr20_survey.results.volume import ExportPart, Volume

# A stick that is plugged in shows within this time [s].
LIST_PERIOD_S = 2.0
CANCELLING = Message("Cancelling. Unfinished files are removed from the stick.")
NO_STICKS = Sticks("", ())
REPORT = frozenset({ExportPart.REPORT_HTML})


class StickExport:
    """One export at a time. Belongs to one thread.

    Attributes:
        job: The export.
        choosing: Whether a person chooses the parts; else the only stick is written at once.
    """

    def __init__(self, imaging: Imaging) -> None:
        self._now_s = imaging.now_s
        self._listed_s = -LIST_PERIOD_S
        self._order: Dict[str, Any] = {}
        self.job: Job[Exported] = imaging.job(Service.EXPORT)
        self.listing: Job[Sticks] = imaging.job(Service.STICKS, self._take_sticks)
        self.sticks = NO_STICKS
        self.parts: FrozenSet[ExportPart] = REPORT
        self.choosing = False

    @property
    def revision(self) -> Tuple[object, ...]:
        """Changes with everything that a view shows of this."""
        return self.job.revision, self.listing.problem, self.sticks, self.parts, self.choosing

    @property
    def survey(self) -> str:
        """Id of the survey that is exported; empty: none."""
        return str(self._order.get("survey", ""))

    @property
    def offered(self) -> Tuple[Volume, ...]:
        """The sticks, those that can be written first."""
        return tuple(sorted(self.sticks.volumes, key=lambda one: not one.writable))

    @property
    def writable(self) -> Tuple[Volume, ...]:
        """The sticks that can be written."""
        return tuple(one for one in self.sticks.volumes if one.writable)

    @property
    def only(self) -> Optional[Volume]:
        """The only stick that can be written; None: there is none, or several."""
        return self.writable[0] if len(self.writable) == 1 else None

    def begin(self, survey: str, permittivity: float, language: str) -> None:
        """Write the report on a survey, as soon as it is clear to which stick."""
        if self.job.running:
            return
        self.job.end()
        self._order = {"survey": survey, "permittivity": permittivity, "language": language}
        self.parts, self.choosing = REPORT, False
        # A stick of an earlier list may have been removed.
        self.sticks, self._listed_s = NO_STICKS, -LIST_PERIOD_S
        self.look_for_sticks()

    def look_for_sticks(self) -> None:
        """Ask for the sticks, if that was not done just now; while somebody waits for them."""
        waits = self.job.state is JobState.READY or self.choosing
        late = self._now_s() - self._listed_s >= LIST_PERIOD_S
        if waits and late and not self.job.running and not self.listing.running:
            self._listed_s = self._now_s()
            self.listing.ask()

    def choose_parts(self) -> None:
        """Let a person choose what is written, and where."""
        if not self.job.running:
            self.job.end()
            self.choosing = True

    def toggle(self, part: ExportPart) -> None:
        """Add or remove a part."""
        self.parts = self.parts ^ {part}

    def write(self, volume: str) -> None:
        """Write the parts to the stick that is mounted at a path."""
        if self.job.running or not self.parts:
            return
        self.choosing = False
        kinds = [one.value for one in ExportPart if one in self.parts]
        self.job.ask(**self._order, kinds=kinds, volume=volume)

    def cancel(self) -> None:
        """Ask to end an export that is running, or end the wait for a stick."""
        self.choosing = True
        if self.job.running:
            self.job.cancel(CANCELLING)
        else:
            self.job.end()

    def _take_sticks(self, sticks: Sticks) -> None:
        self.sticks = sticks
        if self.only is not None and self.job.state is JobState.READY and not self.choosing:
            self.write(self.only.path)
