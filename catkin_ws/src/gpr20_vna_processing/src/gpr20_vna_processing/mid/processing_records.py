"""What DataProcessing takes and returns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, NamedTuple, Optional, Sequence, Tuple

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_survey.folder.survey_metadata import INTERRUPTED
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.recording.mcap_writer import McapFile, RecordedMessage
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_vna_processing.low.bag_processes import BagProcesses
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters
from gpr20_vna_processing.mid.storage_thread import QueueState

OUTCOMES: Dict[str, Tuple[Message, Tuple[SurveyState, ...]]] = {
    "finished": (Message("Finished"), (SurveyState.FINISHED,)),
    "stopped": (Message("Stopped"), (SurveyState.STOPPED,)),
    "failed": (Message("Failed"), (SurveyState.FAILED,)),
    # Without every trace, as a failed one; a main control that ends says that it has stopped.
    INTERRUPTED: (Message("Interrupted before its end"), (SurveyState.FAILED, SurveyState.STOPPED)),
}
"""How surveys end: the sentence and the states of the last status, the first by the storage."""


class SurveyEnd(NamedTuple):
    """The last status of a survey that nobody but the storage knows to have ended."""

    survey_id: str
    state: SurveyState
    message: Message
    simulated: bool
    """Whether its data show no real ground."""
    time_ns: int
    """When it ended [ns since 1970, UTC]."""


@dataclass(frozen=True)
class Storage:
    """What the storage uses; passed in so that tests can replace each part."""

    parameters: ProcessingParameters
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
    publish: Callable[[RecordedMessage], None] = lambda _message: None
    """Called with the message of every survey that was opened, and of every trace and record of the
    log when it is durable; must not raise."""
    open_recording: Callable[[Path], McapFile] = McapFile
    """Begins the recording of a new survey."""

    @property
    def data(self) -> Path:
        """Folder of the surveys."""
        return self.parameters.data_folder()


class ChangedSurvey(NamedTuple):
    """A survey that was closed, or whose log has a fact."""

    survey_id: str
    stored_traces: int = 0
    """0 if the fact is of another survey than the open one."""
    markers: Sequence[Mapping[str, Any]] = ()
    """Of a fact of markers: all of the survey, removed ones too."""


class ProcessingState(NamedTuple):
    """What the operator should know about the storage."""

    survey_id: str
    """Empty while no survey is open."""
    folder: str
    stored_traces: int
    unrecorded: int
    """Messages of other topics that are not recorded: the disk was too slow, or refused them."""
    last_error: Optional[Message]
    """What was refused or failed last; None once something succeeded again."""
    failing: bool
    """Whether the disk refused what was written last."""
    queues: QueueState
    unsigned: Optional[Message]
    """Why the survey that was closed last is not signed, although there is a key."""
