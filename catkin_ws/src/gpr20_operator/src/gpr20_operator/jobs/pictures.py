"""What the imaging node does for the window: images, where a mine could hide, exports."""

from __future__ import annotations

import math
from typing import Any, Callable, Dict, NamedTuple, Optional, Set, Tuple

from gpr20_common.message import Message
from gpr20_operator.jobs.job import Job, Requests, Service, job_of
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_survey.results.volume import Volume

NOT_KNOWN = 0.0
"""What is sent as the permittivity where none is known here: that of the stored survey is used."""
# An image takes a second of a core at the lowest priority.
PERIOD_S = 10.0
# A permittivity that is set in steps: the last one counts.
SETTLED_S = 1.0
# The imaging node refuses an image of fewer lines than three.
FEWEST_TRACES = 9
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
    """What the storage has of a survey: survey.json, and how many traces."""

    text: str
    stored_traces: int


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


class KnownSoils:
    """The permittivity of the ground of each survey: one for all pages and exports."""

    def __init__(self) -> None:
        self._values: Dict[str, Optional[float]] = {}
        self._unstored: Set[str] = set()

    def of(self, survey_id: str) -> Optional[float]:
        """Return the permittivity of a survey; None: it is not known."""
        return self._values.get(survey_id)

    def asked(self, survey_id: str, permittivity: Optional[float]) -> float:
        """Return what the imaging node is asked with, for one answer: it reads what is stored."""
        is_stored = survey_id not in self._unstored and permittivity == self.of(survey_id)
        return NOT_KNOWN if is_stored or permittivity is None else permittivity

    def enter(self, survey_id: str, permittivity: Optional[float]) -> None:
        """Take what a person entered here; it is not stored with the survey yet."""
        self._values[survey_id] = permittivity
        self._unstored.add(survey_id)

    def take(self, survey_id: str, noted: Optional[float]) -> None:
        """Take what is stored with a survey; None: that it is not known.

        Somebody at another screen may have entered it. What was entered here and is not stored
        yet is newer.
        """
        if survey_id not in self._unstored:
            self._values[survey_id] = noted

    def is_unstored(self, survey_id: str) -> bool:
        """Return whether something was entered here that is not stored with the survey yet."""
        return survey_id in self._unstored

    def note_stored(self, survey_id: str) -> None:
        """Note that what was entered here is stored."""
        self._unstored.discard(survey_id)


class Wanted(NamedTuple):
    """What an image depends on."""

    survey_id: str
    traces: int
    permittivity: Optional[float]


class Imaging:
    """Asks for images while somebody looks at them. Belongs to one thread.

    Args:
        requests: The imaging node and the storage.
        now_s: A clock that never goes back [s].
        pictures: Those of others, too; None: its own.
        again_s: After how long to ask again though nothing is new here: another screen may have
            entered what the ground is [s].

    Attributes:
        pictures: What it has found.
        soils: The permittivity of the ground of each survey.
    """

    def __init__(
        self,
        requests: Requests,
        now_s: Callable[[], float],
        pictures: Optional[Pictures] = None,
        again_s: float = math.inf,
    ) -> None:
        self._requests = requests
        self.now_s, self._again_s = now_s, again_s
        self.pictures = pictures or Pictures()
        self.soils = KnownSoils()
        self._shown = self.job(Service.FOCUS, self.pictures.add_image)
        self._asked: Optional[Wanted] = None
        self._ended_s: Optional[float] = None
        self._settling: Optional[Wanted] = None
        self._settling_s = 0.0

    def job(
        self,
        service: Service,
        done: Callable[[Any], None] = lambda _result: None,
        failed: Callable[[Message], None] = lambda _problem: None,
    ) -> Job[Any]:
        """Return a job of a service."""
        return job_of(self._requests, service, self.now_s, done, failed)

    @property
    def problem(self) -> Optional[Message]:
        """Why there is no newer image of the survey that is shown; None: nothing went wrong."""
        return self._shown.problem

    def keep(self, wanted: Wanted) -> None:
        """Ask for an image if it would differ from the last one and that is long enough ago."""
        if not wanted.survey_id or wanted.traces < FEWEST_TRACES or self._shown.running:
            return
        if self._ended_s is None:
            self._ended_s = self.now_s()
        is_new = wanted != self._asked or self.now_s() - self._ended_s >= self._again_s
        if not is_new or not self._is_due(wanted):
            return
        self._asked, self._ended_s = wanted, None
        permittivity = self.soils.asked(wanted.survey_id, wanted.permittivity)
        self._shown.ask(survey=wanted.survey_id, permittivity=permittivity)

    def end(self) -> None:
        """End what is awaited."""
        self._shown.end()

    def _is_due(self, wanted: Wanted) -> bool:
        asked, now_s = self._asked, self.now_s()
        if asked is None or asked.survey_id != wanted.survey_id:
            return True
        if asked.permittivity == wanted.permittivity:
            return now_s - (self._ended_s or 0.0) >= PERIOD_S
        # Only once the operator has stopped changing it.
        if self._settling is None or self._settling.permittivity != wanted.permittivity:
            self._settling, self._settling_s = wanted, now_s
        return now_s - self._settling_s >= SETTLED_S
