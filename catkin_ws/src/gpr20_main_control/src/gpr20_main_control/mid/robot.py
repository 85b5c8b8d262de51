"""The parts of the robot as the survey sees them.

Every call returns or raises `DeviceError` within a time limit of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Mapping, Optional, Protocol, Tuple

import numpy as np

from gpr20_main_control.mid.node_liveness import NodeLiveness
from gpr20_main_control.mid.serial_calls import SerialCalls
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_survey.trace.trace import Trace


@dataclass(frozen=True)
class AxisReading:
    """What an axis last said of itself.

    Attributes:
        coordinate: Where it is [mm or deg].
        homed: Whether the coordinate is referred to the axis's zero.
        moving: Whether the motor is being stepped.
        age_s: How long ago it said so [s].
    """

    coordinate: float
    homed: bool
    moving: bool
    age_s: float


@dataclass(frozen=True)
class MoveOutcome:
    """How a move ended, in the words of the axis."""

    success: bool
    message: str


class Axis(Protocol):
    """One axis of the positioner."""

    def reading(self) -> Optional[AxisReading]:
        """Return what the axis last said of itself; None if it never did."""

    def begin_move(self, target: float) -> None:
        """Tell the axis to move [mm or deg] and return at once."""

    def move_outcome(self, wait_s: float) -> Optional[MoveOutcome]:
        """Wait up to `wait_s` [s] for the end of the move; None while it goes on."""

    def home(self, time_limit_s: float) -> None:
        """Home the axis and return when it is homed."""

    def stop(self) -> None:
        """End any motion; returns at once."""


class Analyzer(Protocol):
    """The vector network analyzer."""

    def connect(self, address: str) -> str:
        """Connect, or connect again, and return the instrument's identity."""

    def calibration(self) -> CalibrationStatus:
        """Return the state of the calibration, or refuse one that is not accepted."""

    def configure(self, settings: SweepSettings) -> SweepSettings:
        """Configure the sweep and return what the instrument accepted."""

    def frequencies_hz(self) -> np.ndarray:
        """Return the frequencies of the sweep [Hz]."""

    def sweep(self) -> Sweep:
        """Take one sweep that starts now, checked, and repeated where it failed."""


class HeightSensor(Protocol):
    """The sensor of the antenna height."""

    def height_m(self) -> float:
        """Measure the height of the antennas above the ground [m] now."""


@dataclass(frozen=True)
class SurveyRecord:
    """What is known of a survey when it begins.

    Attributes:
        survey_id: UUID.
        started_us: When it began [us since 1970, UTC].
        metadata_json: Parameters, instrument and axes, as they go on disk.
        needed_bytes: Estimate of the whole survey on disk [bytes].
    """

    survey_id: str
    started_us: int
    metadata_json: str
    needed_bytes: int


@dataclass(frozen=True)
class OpenedSurvey:
    """A survey that has begun.

    Attributes:
        folder: Where it is.
        interrupted: Folder of another survey that was still open and was closed; else empty.
    """

    folder: str
    interrupted: str = ""


@dataclass(frozen=True)
class ReopenedSurvey:
    """A survey that was cut off or ended early, open again.

    Attributes:
        survey_id: UUID.
        folder: Where it is.
        metadata_json: As it was recorded at its start.
        report_json: The last report of it; empty if there is none.
        stored_indices: Places in the plan whose traces are on the disk.
        last: The trace stored last; None if there is none.
        interrupted: Folder of another survey that was still open and was closed; else empty.
    """

    survey_id: str
    folder: str
    metadata_json: str
    report_json: str
    stored_indices: Tuple[int, ...]
    last: Optional[Trace]
    interrupted: str = ""


class Storage(Protocol):
    """The place where traces are kept."""

    def open(self, record: SurveyRecord) -> OpenedSurvey:
        """Begin a survey; one that is still open is closed as interrupted."""

    def reopen(self, survey: str) -> ReopenedSurvey:
        """Open a survey again, by its id or folder; another that is open is interrupted."""

    def report(self, survey_id: str, report_json: str) -> None:
        """Keep a report of the survey beside its metadata."""

    def store(self, trace: Trace) -> None:
        """Store a trace; returning means that it is durable."""

    def close(self, survey_id: str, outcome: str, reason: str) -> int:
        """End a survey and return how many traces its folder holds."""


@dataclass(frozen=True)
class Robot:
    """All parts of the robot.

    Attributes:
        axes: The three axes.
        analyzer: Of S21.
        height_sensor: Of the antennas.
        storage: Of traces.
        nodes: The processes of all of them.
        analyzer_calls: Through which the analyzer is set up.
        storage_calls: Through which surveys are opened, reported and closed.
    """

    axes: Mapping[AxisId, Axis]
    analyzer: Analyzer
    height_sensor: HeightSensor
    storage: Storage
    nodes: NodeLiveness
    # Of all surveys: a call that one has given up must not disturb the next.
    analyzer_calls: SerialCalls = field(default_factory=SerialCalls, init=False)
    storage_calls: SerialCalls = field(default_factory=SerialCalls, init=False)
