"""What DataProcessing takes and returns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, Sequence

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.files.access import Readers
from gpr20_survey.folder.signature import Signer
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.recording import RecordedMessage
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_vna_processing.low.bag_processes import BagProcesses
from gpr20_vna_processing.mid.storage_thread import QueueState
from gpr20_vna_processing.mid.survey_end import SurveyEnd

BYTES_PER_MB = 1_000_000


@dataclass(frozen=True)
class Storage:
    """What the storage uses; passed in so that tests can replace each part."""

    data: Path
    check_data: Callable[[], None]
    """Refuses a data folder that is not the one that was used before; makes it at first."""
    topics: SurveyTopics
    free_bytes: Callable[[Path], int]
    now_ns: Callable[[], int]
    """Time of day [ns since 1970, UTC]."""
    clock: Clock
    revision: str
    end_status: Callable[[SurveyEnd], RecordedMessage]
    """Makes the last message of `control_status` in the recording."""
    bags: BagProcesses
    readers: Readers = Readers.GROUP
    """Who may read a new survey."""
    on_opened: Callable[[str], None] = lambda _text: None
    """Called with the JSON description of a survey that was opened; must not raise."""
    on_stored: Callable[[RecordedMessage], None] = lambda _message: None
    """Likewise with the message of every trace when it is durable."""
    on_logged: Callable[[RecordedMessage], None] = lambda _message: None
    """Likewise with that of every record of a survey's log."""
    signer: Optional[Signer] = None
    """Signs a survey whenever its manifest was written; None: surveys are not signed."""
    open_recording: Callable[[Path], McapFile] = McapFile
    """Begins the recording of a new survey."""


@dataclass(frozen=True)
class Limits:
    """How long and how much the storage waits."""

    queue_bytes: int = 16 * BYTES_PER_MB
    """How large the messages that wait for the disk may be together."""
    disk_reserve_bytes: int = 500 * BYTES_PER_MB
    timeout_s: float = 60.0
    long_timeout_s: float = 600.0
    """For requests that read the whole survey: reopening and closing it."""
    period_s: float = 2.0


@dataclass(frozen=True)
class ClosedSurvey:
    """How a survey ended on the disk."""

    survey_id: str
    folder: Path
    stored_traces: int


@dataclass(frozen=True)
class AddedFact:
    """A survey whose log has a fact."""

    survey_id: str
    folder: Path
    stored_traces: int = 0
    """Those of the open survey; 0: the fact is of another one."""
    markers: Sequence[Mapping[str, Any]] = ()
    """Of a fact of markers: all that survey.json has, removed ones too."""


@dataclass(frozen=True)
class ProcessingState:
    """What the operator should know about the storage."""

    survey_id: str
    """Empty while no survey is open."""
    folder: str
    stored_traces: int
    unrecorded: int
    """Messages of other topics that are not recorded, without those the queue dropped."""
    last_error: Optional[Message]
    """What was refused or failed last; None once something succeeded again."""
    failing: bool
    """Whether the disk refused what was written last."""
    queues: QueueState
    unsigned: Optional[Message] = None
    """Why the survey that was changed last is not signed, although there is a key."""
    bag_problem: Optional[Message] = None
    """Which bag could not be made, and why."""
