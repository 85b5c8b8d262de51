"""The parts of the robot, as the survey uses them.

Every call returns or raises within its own time limit: `NodeLostError` without an answer, else
`DeviceError`.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, Optional, Protocol, Tuple

from gpr20_common.message import Message
from gpr20_main_control.errors import BLOCKED, DeviceError, NodeLostError
from gpr20_main_control.mid.devices.described_robot import AuxSensors, DescribedRobot
from gpr20_main_control.mid.devices.node_liveness import NodeLiveness
from gpr20_main_control.mid.survey.survey_status import Coverage, Status
from gpr20_main_control.mid.waits import Workers
from gpr20_survey.axes import UNKNOWN_ZERO, AxisId, ZeroEpoch, Zeros
from gpr20_survey.faults import CONTROL_SILENT
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.results.answers import ReopenedSurvey
from gpr20_survey.trace.sweep import CalibrationStatus, Sweep, SweepSettings
from gpr20_survey.trace.trace import Trace

# How long the other nodes may take for an answer [s].
ANALYZER_LIMIT_S, HEIGHT_LIMIT_S, STORAGE_LIMIT_S = 90.0, 10.0, 90.0
# The driver takes sweeps when it sets up the analyzer, to learn how long one takes; it ends that by
# itself when the instrument is silent [s].
SETUP_LIMIT_S = 3600.0


@dataclass(frozen=True)
class AxisReading:
    """The last reading of an axis: its coordinate [mm or deg], which refers to a zero if homed."""

    coordinate: float
    homed: bool
    moving: bool
    age_s: float
    zero: ZeroEpoch = UNKNOWN_ZERO


def zeros_of(zeros: Mapping[AxisId, ZeroEpoch]) -> Zeros:
    """Return the zeros of x, y and z; empty if an axis does not know its own."""
    found = tuple(zeros[axis_id] for axis_id in AxisId)
    return found if all(one.is_known for one in found) else ()


@dataclass(frozen=True)
class Position:
    """The position that the axes report: x and y [mm], z [deg], and since which zeros."""

    x_mm: float
    y_mm: float
    z_deg: float
    zeros: Zeros = ()

    @property
    def message(self) -> Message:
        """The position, for a sentence."""
        return Message(
            "x {x_mm:.9g} mm, y {y_mm:.9g} mm, z {z_deg:.9g} deg",
            x_mm=self.x_mm,
            y_mm=self.y_mm,
            z_deg=self.z_deg,
        )


def motion_error(reason: Message) -> DeviceError:
    """Return the error of a motion that failed for a reason that the axis said."""
    # It stopped by itself, because it had no contact with the main control.
    lost = reason.fault_code == CONTROL_SILENT.code
    return (NodeLostError if lost else DeviceError)(reason, reason.fault or BLOCKED)


@dataclass(frozen=True)
class Lease:
    """A lease of one axis, which ends when it is not renewed for its limit [s]."""

    number: int
    limit_s: float


class Axis(Protocol):
    """One axis of the positioner."""

    @property
    def received(self) -> threading.Event:
        """Set at each new reading and at the end of a move; who waits for one clears it."""

    def reading(self) -> Optional[AxisReading]:
        """Return the last reading of the axis; None before the first."""

    def lease(self, number: int = 0, release: bool = False) -> Lease:
        """Reserve the axis, or renew or release the lease with a number."""

    def is_connected(self) -> bool:
        """Return whether the axis driver will receive the next move."""

    def begin_move(self, target: float) -> None:
        """Begin a move to a target [mm or deg] and return at once."""

    def move_ended(self) -> bool:
        """Return whether the move has ended, or raise why it failed."""

    def home(self, time_limit_s: float) -> None:
        """Home the axis and return when it is homed."""

    def set_zero(self) -> None:
        """Make the present position of an axis without endstop its zero."""

    def stop(self) -> None:
        """End any motion; returns at once."""


@dataclass(frozen=True)
class AnalyzerSetup:
    """How the analyzer will measure: settings as read back, and times [s].

    A trace takes so long, with its averages (0: nobody knows), and a sweep or its confirmation at
    most the limit.
    """

    settings: SweepSettings
    sweep_duration_s: float
    request_limit_s: float


@dataclass(frozen=True)
class UnconfirmedSweep:
    """A fresh sweep, whose settings are not read back yet; its number is for `confirm`."""

    number: int
    sweep: Sweep


@dataclass(frozen=True)
class SweepConfirmation:
    """More remarks on a confirmed sweep, and the analyzer's temperature [degC] if it says so."""

    remarks: Tuple[str, ...] = ()
    temperature_c: Optional[float] = None


@dataclass(frozen=True)
class AnalyzerCalibration:
    """The state of the analyzer's calibration, and what else it says of it, for survey.json."""

    status: CalibrationStatus
    details: Mapping[str, Any] = field(default_factory=dict)


class Analyzer(Protocol):
    """The vector network analyzer."""

    def connect(self, address: str) -> str:
        """Connect or reconnect, and return the instrument's identity."""

    def calibration(self) -> AnalyzerCalibration:
        """Return the calibration; raise if it is not accepted."""

    def configure(self, settings: SweepSettings) -> AnalyzerSetup:
        """Configure the sweep and return what the instrument accepted."""

    def sweep(self) -> UnconfirmedSweep:
        """Take one sweep that starts now; the driver checks it and repeats a failed one."""

    def confirm(self, number: int) -> SweepConfirmation:
        """Confirm that the last sweep has the survey's settings, or raise UnconfirmedError."""

    def release(self) -> None:
        """Leave the instrument to its front panel; `connect` takes it back."""


@dataclass(frozen=True)
class SurveyRecord:
    """What is known about a survey when it begins [us since 1970, UTC], and its size on disk."""

    survey_id: str
    started_us: int
    metadata_json: str
    needed_bytes: int


@dataclass(frozen=True)
class SurveyEnd:
    """How a survey ended: in one word of survey.json, and with what its recordings end."""

    outcome: str
    reason: Message
    status: Status
    coverage: Optional[Coverage] = None


class Storage(Protocol):
    """The storage of surveys."""

    def open(self, record: SurveyRecord) -> str:
        """Begin a survey and return its folder; another one that is open is interrupted."""

    def reopen(self, survey: str) -> ReopenedSurvey:
        """Reopen a survey by its id or folder; another one that is open is interrupted."""

    def add_fact(self, survey_id: str, kind: Kind, values_json: str) -> int:
        """Add a fact to the survey's log, durably; return how many traces are stored."""

    def store(self, trace: Trace) -> None:
        """Store a trace; it is durable when this returns."""

    def close(self, survey_id: str, end: SurveyEnd) -> None:
        """Close a survey; its end is in the recordings when this returns."""


@dataclass(frozen=True)
class Robot:
    """All parts of the robot.

    Attributes:
        height_m: Measures the height of the antennas above the ground [m] now.
        nodes: The processes of all parts.
        description: What the parts are, as they say themselves.
        sensors: Other sensors beside the radar.
        workers: The threads of calls that may be made at the same time.
        analyzer_calls: The calls that set up the analyzer.
        storage_calls: The calls that open, report and close surveys.
    """

    axes: Mapping[AxisId, Axis]
    analyzer: Analyzer
    height_m: Callable[[], float]
    storage: Storage
    nodes: NodeLiveness
    description: DescribedRobot
    sensors: AuxSensors
    workers: Workers = field(default_factory=Workers, init=False)
    # Shared by all surveys: a call that one survey gave up must not disturb the next.
    analyzer_calls: Workers = field(default_factory=lambda: Workers(most=1), init=False)
    storage_calls: Workers = field(default_factory=lambda: Workers(most=1), init=False)
