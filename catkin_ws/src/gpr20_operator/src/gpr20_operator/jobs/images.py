"""Everything that the imaging node does for the window."""

from __future__ import annotations

from typing import Callable, NamedTuple, Optional

from gpr20_common.message import Message
from gpr20_operator.jobs.export import SurveyExport
from gpr20_operator.jobs.imaging import FocusRequests, ImageFailed, ImageFocused, ImagingRequests
from gpr20_operator.jobs.search import CandidateSearch
from gpr20_survey.results.focused_image import FocusedImage

# An image takes a second of a core at the lowest priority.
PERIOD_S = 10.0
# A permittivity that is set in steps: the last one counts.
SETTLED_S = 1.0
# The imaging node refuses an image of fewer lines than three.
FEWEST_TRACES = 9
# Without an answer for so long, the node has died.
LOST_S = 400.0


class Wanted(NamedTuple):
    """What an image depends on."""

    survey_id: str
    traces: int
    permittivity: float


class FocusedImages:
    """Asks for an image while somebody looks at it. Belongs to one thread.

    Args:
        requests: The imaging node.
        now_s: A clock that never goes back [s].

    Attributes:
        problem: Why there is no newer image; None if there is one, or it is on its way.
    """

    def __init__(self, requests: FocusRequests, now_s: Callable[[], float]) -> None:
        self._requests = requests
        self._now_s = now_s
        self._image: Optional[FocusedImage] = None
        self._asked: Optional[Wanted] = None
        self._asked_s = 0.0
        self._ended_s = -PERIOD_S
        self._waits = False
        self._settling: Optional[Wanted] = None
        self._settling_s = 0.0
        self.problem: Optional[Message] = None

    def image(self, survey_id: str) -> Optional[FocusedImage]:
        """Return the last image of a survey; None if there is none."""
        image = self._image
        return image if image is not None and image.survey_id == survey_id else None

    def keep(self, wanted: Wanted) -> None:
        """Ask for an image if it would differ from the last one and that is long enough ago.

        Args:
            wanted: What is shown now.
        """
        if not wanted.survey_id or wanted.traces < FEWEST_TRACES:
            return
        now_s = self._now_s()
        if self._waits and now_s - self._asked_s < LOST_S:
            return
        if wanted == self._asked and not self._waits:
            return
        if not self._is_due(wanted, now_s):
            return
        self._asked, self._asked_s, self._waits = wanted, now_s, True
        self._requests.focus(wanted.survey_id, wanted.permittivity)

    def on_event(self, event: object) -> None:
        """Take an image, or the reason why there is none; ignore other events."""
        if isinstance(event, ImageFocused):
            self._end(event.image.survey_id)
            self._image, self.problem = event.image, None
        elif isinstance(event, ImageFailed):
            self._end(event.survey_id)
            self.problem = event.reason

    def _end(self, survey_id: str) -> None:
        if self._waits and self._asked is not None and survey_id == self._asked.survey_id:
            self._waits, self._ended_s = False, self._now_s()

    def _is_due(self, wanted: Wanted, now_s: float) -> bool:
        asked = self._asked
        if asked is None or asked.survey_id != wanted.survey_id:
            return True
        if asked.permittivity == wanted.permittivity:
            return now_s - self._ended_s >= PERIOD_S
        # Only once the operator has stopped changing it.
        if self._settling is None or self._settling.permittivity != wanted.permittivity:
            self._settling, self._settling_s = wanted, now_s
        return now_s - self._settling_s >= SETTLED_S


class ImagingPresenter:
    """Focused images, the search for candidates and the export. Belongs to one thread.

    Args:
        requests: The imaging node.
        now_s: A clock that never goes back [s].

    Attributes:
        search: The search for candidates in a stored survey.
        export: The export to a stick.
        images: The focused image of the survey that is shown.
    """

    def __init__(self, requests: ImagingRequests, now_s: Callable[[], float]) -> None:
        self._requests = requests
        self.search = CandidateSearch(requests, now_s)
        self.export = SurveyExport(requests, now_s)
        self.images = FocusedImages(requests, now_s)

    def on_event(self, event: object) -> None:
        """Take an answer; other events are ignored."""
        self.search.on_event(event)
        self.export.on_event(event)
        self.images.on_event(event)

    def focus(self, survey_id: str, permittivity: float) -> None:
        """Ask for the focused image of another survey than the one that is shown."""
        self._requests.focus(survey_id, permittivity)

    def set_survey_runs(self, runs: bool) -> None:
        """Note whether a survey is running: nothing long begins during one."""
        self.search.set_survey_runs(runs)
        self.export.set_survey_runs(runs)

    def end(self) -> None:
        """End what the window would have waited for."""
        self.search.close()
        self.export.cancel()
