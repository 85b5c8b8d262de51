"""The parameters of the storage."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.yaml_file import data_folder, state_folder
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded
from gpr20_survey.files.durable_files import Readers
from gpr20_survey.folder.data_folder import DataFolderUse
from gpr20_survey.folder.signature import Signer
from gpr20_survey.plan.robot_description import TOPIC

BYTES_PER_MB = 1_000_000
POSITIVE = (1e-6, 1e9)
OF_AN_AXIS = (
    *("current_coord", "axis/goal", "axis/result", "axis/status", "axis/cancel"),
    "axis_driver/description",
)
DEFAULT_TOPICS = (
    *(f"{axis}_axis/{name}" for axis in "xyz" for name in OF_AN_AXIS),
    "height_sensor/description",
    "measured_height",
    "vna_acquisition/description",
    "vna_processing/description",
    "simulator/description",
    "robot_configuration",
    "control_status",
    "control_target_coordinate",
    "control_current_coordinate",
    "control_survey_data",
    "survey_coverage",
    "survey_parameters",
    "tf",
    "tf_static",
    "joint_states",
    "robot_description",
    "b_scan",
    "survey_area",
    "stops",
    "candidates",
    "candidate_markers",
    "/diagnostics",
    "/rosout_agg",
)


@dataclass(frozen=True)
class ProcessingParameters:
    """Where and how surveys are stored.

    Attributes:
        data: Folder of the surveys; empty: $GPR20_DATA, or ~/gpr20_data if that is not set.
        data_disk: Whether that folder is on a disk of its own. With true nothing is stored on the
            disk of the system, such as while the other one is not mounted.
        disk_reserve_mb: A survey starts only if this much stays free on the disk [MB].
        message_queue_mb: Size of the messages of other topics that may wait [MB].
        timeout_s: Time limit of a request [s].
        long_timeout_s: Time limit of requests that read a whole survey [s].
        commit_period_s: Messages of other topics are on the disk after this time [s].
        recorded_topics: Topics to record, relative to the robot's namespace.
        extra_recorded_topics: Further topics, such as those of your own nodes.
        readable_by: Who may read new surveys: owner, group or all.
        signing_key: File of the private key that signs the surveys,
            such as robot_config key makes it; empty: they are not signed.
    """

    data: str = ""
    data_disk: bool = False
    disk_reserve_mb: float = bounded(0.0, 1e9, 500.0)
    message_queue_mb: float = bounded(*POSITIVE, 16.0)
    timeout_s: float = bounded(*POSITIVE, 60.0)
    long_timeout_s: float = bounded(*POSITIVE, 600.0)
    commit_period_s: float = bounded(*POSITIVE, 2.0)
    recorded_topics: Tuple[str, ...] = DEFAULT_TOPICS
    extra_recorded_topics: Tuple[str, ...] = ()
    readable_by: Readers = Readers.GROUP
    signing_key: str = ""

    def __post_init__(self) -> None:
        key = self.signing_key
        if key and not (key.isprintable() and key.startswith(("/", "~/"))):
            raise InvalidValueError(
                Message("signing_key is {path}; it must be an absolute path", path=repr(key)),
                fault=CONFIGURATION,
            )
        for topic in self.all_topics:
            if not TOPIC.fullmatch(topic):
                raise InvalidValueError(
                    Message(
                        "{topic} is not the name of a topic; allowed are letters, digits, "
                        "underscores and slashes, such as {example}",
                        topic=repr(topic),
                        example="/my_node/my_topic",
                    ),
                    fault=CONFIGURATION,
                )

    @property
    def all_topics(self) -> Tuple[str, ...]:
        """Every topic to record, once."""
        return tuple(dict.fromkeys((*self.recorded_topics, *self.extra_recorded_topics)))

    @property
    def disk_reserve_bytes(self) -> int:
        """What must stay free on the disk [bytes]."""
        return round(self.disk_reserve_mb * BYTES_PER_MB)

    def data_folder(self) -> Path:
        """Return where surveys are stored."""
        return data_folder(self.data, os.environ)

    def signer(self) -> Optional[Signer]:
        """Return what signs the surveys; None if nothing does."""
        return Signer(Path(self.signing_key)) if self.signing_key else None

    def data_folder_use(self) -> DataFolderUse:
        """Return how the folder of the surveys is used."""
        state, mode = state_folder(os.environ), self.readable_by.folder_mode
        return DataFolderUse(self.data_folder(), state, self.data_disk, mode)
