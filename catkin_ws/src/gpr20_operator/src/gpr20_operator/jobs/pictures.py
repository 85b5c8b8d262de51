"""What storage and imaging node answer; images and hiding maps, which all pages share."""

from __future__ import annotations

from typing import Any, Callable, Dict, Mapping, NamedTuple, Optional, Tuple

from gpr20_common.message import Message
from gpr20_operator.jobs.job import Job, JobState, Requests, Service
from gpr20_survey.results.answers import FocusedImage, SurveySummary, Volume
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_survey.trace.trace import TraceBlock

# An image takes a second of a core at the lowest priority.
PERIOD_S = 10.0
# The imaging node refuses an image of fewer lines than three.
FEWEST_TRACES = 9
SURVEYS_PER_PAGE = 50
# Images are large.
MOST_IMAGES = 6


class Sticks(NamedTuple):
    """The USB sticks that are mounted on the computer of the storage."""

    computer: str
    volumes: Tuple[Volume, ...]


class Exported(NamedTuple):
    """The names of files on a stick; without one, of the only file, and its content."""

    files: Tuple[str, ...]
    content: bytes = b""


class StoredSurvey(NamedTuple):
    """What the storage has of a survey: survey.json, and the places of its traces in the plan."""

    text: str
    stored_indices: Tuple[int, ...]


class SurveysListed(NamedTuple):
    """A page of the list of past surveys, the newest first."""

    surveys: Tuple[SurveySummary, ...]
    more: bool


class TracesRead(NamedTuple):
    """Stored traces, and why others cannot be read, by their places in the plan."""

    block: TraceBlock
    unreadable: Mapping[int, Message]


class Pictures:
    """Images and hiding maps of surveys, for every page."""

    def __init__(self) -> None:
        self.revision = 0
        self._images: Dict[str, FocusedImage] = {}
        self._hiding: Dict[str, HidingMap] = {}

    def image(self, survey_id: str) -> Optional[FocusedImage]:
        """Return the last image of a survey; None: none."""
        image = self._images.pop(survey_id, None)
        if image is not None:
            # Those that are looked at stay longest.
            self._images[survey_id] = image
        return image

    def hiding(self, survey_id: str) -> Optional[HidingMap]:
        """Return where a mine could hide in a survey; None: nobody asked."""
        return self._hiding.get(survey_id)

    def add_image(self, image: FocusedImage) -> None:
        """Keep an image, in the place of the last one of its survey, unless it is the same."""
        last = self.image(image.found.survey_id)
        if last is not None and (last.traces, last.found) == (image.traces, image.found):
            return
        self._images[image.found.survey_id] = image
        while len(self._images) > MOST_IMAGES:
            del self._images[next(iter(self._images))]
        self.revision += 1

    def add_hiding(self, found: HidingMap) -> None:
        """Keep where a mine could hide."""
        self._hiding[found.survey_id] = found
        self.revision += 1

    def drop_hiding(self, survey_id: str) -> None:
        """Forget where a mine could hide: it was found with another permittivity."""
        if self._hiding.pop(survey_id, None) is not None:
            self.revision += 1


class Imaging:
    """Asks for images while somebody looks at them. Belongs to one thread.

    Args:
        requests: The imaging node and the storage.
        now_s: A clock that never goes back [s].
        pictures: Those of others, too; None: its own.

    Attributes:
        pictures: What it has found.
    """

    def __init__(
        self,
        requests: Requests,
        now_s: Callable[[], float],
        pictures: Optional[Pictures] = None,
    ) -> None:
        self._requests, self._now_s = requests, now_s
        self.pictures = pictures or Pictures()
        self._shown = self.job(Service.FOCUS, self.pictures.add_image)
        self._asked: Tuple[str, Optional[float], int] = "", None, 0

    def job(
        self,
        service: Service,
        done: Callable[[Any], None] = lambda _result: None,
        failed: Callable[[Message], None] = lambda _problem: None,
    ) -> Job[Any]:
        """Return a job of a service."""
        return Job(self._requests, service, self._now_s, done, failed)

    @property
    def problem(self) -> Optional[Message]:
        """Why there is no newer image of the survey that is shown; None: nothing went wrong."""
        return self._shown.problem

    def keep(self, survey_id: str, permittivity: Optional[float], traces: int) -> None:
        """Ask for an image if it would differ from the last one and that is long enough ago."""
        if not survey_id or traces < FEWEST_TRACES or self._shown.running:
            return
        wanted = survey_id, permittivity, traces
        is_new = wanted[:2] != self._asked[:2]
        is_due = wanted != self._asked or self._shown.state is JobState.FAILED
        if is_new or (is_due and self._shown.age_s >= PERIOD_S):
            self._asked = wanted
            # With the permittivity that is stored, as without any in the request.
            self._shown.ask(survey=survey_id)

    def end(self) -> None:
        """End what is awaited."""
        self._shown.end()
