"""The robot below ROS in one process: control, axes, height sensor, VNA driver and storage.

Everything is that of the robot but the threads and services between the parts, which here are
calls, and what `simulated_world` simulates.
"""

from __future__ import annotations

import contextlib
import json
import queue
import threading
import time
from collections import Counter
from dataclasses import asdict, replace
from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple

import numpy as np
from simulated_world import LIMIT_S, MECHANICS, STEP_MM, StepTime, World
from storage_kit import end_status
from trace_examples import TRACE_DEFINITION

from gpr20_axis_driver.axis_exceptions import AxisException
from gpr20_axis_driver.low.step_counter import StepCounter, open_step_counter
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.axis_lease import AxisLease
from gpr20_axis_driver.mid.pulse_client import LOCK_LIMIT_S, MADE_US
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.motion import Motion, MotionReport, StopRequested
from gpr20_common.errors import Gpr20Error, NodeGoneError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.hardware import NO_HARDWARE, Hardware
from gpr20_height_sensor.low.adc_interface import AdcInterface
from gpr20_height_sensor.mid.height_driver import HeightDriver
from gpr20_height_sensor.mid.height_parameters import HeightParameters
from gpr20_main_control.errors import DeviceError, NodeLostError, UnconfirmedError
from gpr20_main_control.mid.devices.aux_sensors import AuxSensors
from gpr20_main_control.mid.devices.axis_leases import Lease
from gpr20_main_control.mid.devices.described_robot import DescribedRobot, TimeLimits
from gpr20_main_control.mid.devices.node_liveness import NodeLiveness, WatchedNode
from gpr20_main_control.mid.devices.robot import (
    AnalyzerCalibration,
    AnalyzerSetup,
    AxisReading,
    MoveOutcome,
    OpenedSurvey,
    Robot,
    SurveyEnd,
    SurveyRecord,
    SweepConfirmation,
    UnconfirmedSweep,
)
from gpr20_main_control.mid.main_control import MainControl
from gpr20_main_control.mid.survey.engine import NOTHING, Accepted
from gpr20_main_control.mid.survey.survey_notes import Note
from gpr20_main_control.mid.survey.survey_status import Status, SurveyStatus
from gpr20_main_control.mid.waits import Workers
from gpr20_simulator.low.pins import SimulatedPins
from gpr20_simulator.low.spi import SimulatedSpi
from gpr20_simulator.mid.axis_hardware import NO_LIMITS
from gpr20_simulator.mid.carriage import AxisMotor, mechanics_of, wiring_of
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.range_sensor import RangeSensor
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.axes.zero_epoch import ZeroEpoch
from gpr20_survey.files.durable_files import ensure_folders
from gpr20_survey.plan.robot_description import PLAIN_NAMES, STORAGE, STORAGE_NAME, NodeDescription
from gpr20_survey.plan.site import Site
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.results.reopened_survey import ReopenedSurvey
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_survey.trace.trace import Trace
from gpr20_vna_acquisition.errors import VnaNotReadyError, VnaOldDataError, VnaSettingError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits
from gpr20_vna_acquisition.mid.analyzers import make_analyzer
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters
from gpr20_vna_processing.mid.data_processing import DataProcessing
from gpr20_vna_processing.mid.processing_records import Limits
from gpr20_vna_processing.mid.processing_records import Storage as StorageParts

CALLER = "/main_control"
AXES = {
    AxisId.X: AxisParameters(13, 15, STEP_MM, 0.0015, 0.005, 0.0001, 0.0, 650.0, "LIN", 16),
    AxisId.Y: AxisParameters(37, 38, STEP_MM, 0.0025, 0.005, 0.0001, 0.0, 800.0, "LIN", 40),
    AxisId.Z: AxisParameters(11, 12, 1.8, 0.010, 0.025, 0.005, -90.0, 90.0, "ROT"),
}
# 18 points, and few frequencies.
PARAMETERS = SurveyParameters(
    "127.0.0.1", 600.0e6, 6.0e9, 51, x_start_mm=10.0, x_stop_mm=20.0, x_points=3,
    y_start_mm=10.0, y_stop_mm=20.0, y_points=3, polarizations_deg=(0.0, 90.0),
)  # fmt: skip
ENDS = (SurveyState.FINISHED, SurveyState.PAUSED, SurveyState.STOPPED, SurveyState.FAILED)
# A killed robot is gone for its control, too, which is ended only because it shares the process.
KILLED = Message("the robot was killed")


class ControlTime(Clock):
    """Real seconds, and those that a test lets pass besides.

    Attributes:
        more_s: How many those are [s].
        pace: How many seconds pass in a real one; more for a robot that nobody waits for.
    """

    def __init__(self) -> None:
        self.more_s = 0.0
        self.pace = 1.0

    def now_s(self) -> float:
        """Return the time [s]."""
        return super().now_s() * self.pace + self.more_s

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        """Wait for the event for at most `timeout_s` [s]; return whether it is set."""
        return event.wait(timeout_s / self.pace)


class _Pulses:
    """Makes the pulses of an axis in this process; implements `AxisMotions`."""

    failure = None
    scheduling = Message("ordinary")
    unpunctual = False

    def __init__(self, loop: PulseLoop, counter: StepCounter) -> None:
        self._loop, self._counter = loop, counter
        self.begin_zero, self.place = counter.begin_zero, counter.place
        self.distrust = counter.begin

    @property
    def steps(self) -> int:
        return self._counter.steps

    @property
    def trusted(self) -> bool:
        return self._counter.trusted

    @property
    def zero(self) -> ZeroEpoch:
        return self._counter.zero

    @property
    def endstop_pressed(self) -> Optional[bool]:
        return self._counter.endstop_pressed

    @property
    def endstop_presses(self) -> int:
        return self._counter.endstop_presses

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        return self._loop.run(motion, stop_requested)

    def revive(self) -> None:
        pass

    def close(self) -> None:
        self._loop.close()
        self._counter.close()


class _Axis:
    """An axis as the control uses it."""

    def __init__(self, parts: RobotInProcess, axis_id: AxisId) -> None:
        self._parts, self._parameters = parts, AXES[axis_id]
        world, mechanics = parts.world, mechanics_of(MECHANICS, axis_id)
        path = world.folder / f"{axis_id.value}_steps"
        new = not path.exists()
        counter = open_step_counter(path, self._parameters.step_size, LOCK_LIMIT_S)
        if new and not self._parameters.finds_zero:
            counter.begin_zero(MADE_US)
            counter.place(world.state.steps(axis_id))
        pins = SimulatedPins(
            AxisMotor(world.state, axis_id, mechanics), wiring_of(axis_id, mechanics)
        )
        loop = PulseLoop(pins, self._parameters, StepTime(), NO_LIMITS, counter)
        self.driver = AxisDriver(self._parameters, _Pulses(loop, counter))
        # No lease ends because this computer is slow.
        self.lease = AxisLease(self._parameters.lease_limit_s, lambda: 0.0)
        self.received = threading.Event()
        self._stops = 0
        self._outcomes: queue.SimpleQueue[MoveOutcome] = queue.SimpleQueue()
        self._motions = Workers(most=1)

    def reading(self) -> AxisReading:
        here = self.driver.position
        return AxisReading(here.coordinate, here.homed, self.driver.moving, 0.0, here.zero)

    def is_connected(self) -> bool:
        return not self._parts.killed.is_set()

    def reserve(self) -> Lease:
        with self._parts.answer("reserve"):
            return Lease(self.lease.reserve(CALLER), self.lease.limit_s)

    def renew(self, lease: Lease) -> bool:
        return not self._parts.killed.is_set()

    def release_lease(self, lease: Lease) -> None:
        self.lease.release(CALLER, lease.number)

    def begin_move(self, target: float) -> None:
        outcomes: queue.SimpleQueue[MoveOutcome] = queue.SimpleQueue()
        self._outcomes = outcomes
        stopped = self._stop_since_now()

        def move() -> None:
            try:
                with self.lease.use(CALLER) as lapsed:
                    self.driver.move_to_coordinate(target, lambda: stopped() or lapsed())
                outcomes.put(MoveOutcome(True, verbatim("")))
            except AxisException as error:
                outcomes.put(MoveOutcome(False, error.message))
            self.received.set()

        with self._parts.answer("move"):
            self._motions.begin(move)

    def move_outcome(self, wait_s: float) -> Optional[MoveOutcome]:
        try:
            return self._outcomes.get(timeout=wait_s)
        except queue.Empty:
            return None

    def home(self, time_limit_s: float) -> None:
        stopped = self._stop_since_now()
        with self._parts.answer("home"), self.lease.use(CALLER):
            self.driver.homing(stopped)

    def set_zero(self) -> None:
        with self._parts.answer("set_zero"), self.lease.use(CALLER):
            self.driver.set_zero()

    def stop(self) -> None:
        self._stops += 1

    def _stop_since_now(self) -> Callable[[], bool]:
        stops, killed = self._stops, self._parts.killed
        return lambda: self._stops != stops or killed.is_set()


class _Analyzer:
    def __init__(self, parts: RobotInProcess, driver: VNADriver) -> None:
        self._answer, self._driver = parts.answer, driver

    def connect(self, address: str) -> str:
        with self._answer("connect"):
            return self._driver.connect_to_vna(address)

    def calibration(self) -> AnalyzerCalibration:
        with self._answer("calibration"):
            status = self._driver.check_calibration_status()
            refusal = self._driver.calibration_refusal(status)
            if refusal:
                raise DeviceError(refusal)
            return AnalyzerCalibration(status, dict(self._driver.state.calibration_details))

    def configure(self, settings: SweepSettings) -> AnalyzerSetup:
        with self._answer("configure"):
            accepted = self._driver.set_frequency_sweep(settings)
            duration_s, limit_s = self._driver.trace_duration_s, self._driver.answered_within_s
            return AnalyzerSetup(accepted, duration_s, limit_s)

    def frequencies_hz(self) -> np.ndarray:
        with self._answer("frequencies"):
            return self._driver.get_freq()

    def prepare(self) -> None:
        pass

    def sweep(self) -> UnconfirmedSweep:
        with self._answer("sweep"):
            return UnconfirmedSweep(*self._driver.take_sweep())

    def confirm(self, number: int) -> SweepConfirmation:
        with self._answer("confirm"):
            try:
                confirmed = self._driver.confirm(number)
            except Gpr20Error as error:
                again = isinstance(error, (VnaSettingError, VnaNotReadyError, VnaOldDataError))
                raise UnconfirmedError(error.message, again) from error
            return SweepConfirmation(confirmed.remarks, confirmed.temperature_c)

    def release(self) -> None:
        with self._answer("release"):
            self._driver.disconnect_from_vna()


class _HeightSensor:
    def __init__(self, parts: RobotInProcess) -> None:
        self._answer, world = parts.answer, parts.world
        ground = Ground(world.scene)

        def true_height_m() -> float:
            here = world.position()
            return ground.antenna_height_m(here.x_mm, here.y_mm)

        sensor = RangeSensor(world.scene.adc, true_height_m, lambda: world.state.adc_fault)
        parameters = HeightParameters()
        adc = AdcInterface(SimulatedSpi(sensor.code), parameters.channel)
        self._driver = HeightDriver(adc, parameters, StepTime())

    def height_m(self) -> float:
        with self._answer("height"):
            return self._driver.take_measurement().height_m


class _Storage:
    """The storage; what it acknowledged is in `World.acknowledged`."""

    def __init__(self, parts: RobotInProcess, processing: DataProcessing) -> None:
        self._parts, self._answer, self._processing = parts, parts.answer, processing

    def open(self, record: SurveyRecord) -> OpenedSurvey:
        with self._answer("open"), self._parts.disk:
            interrupted = self._processing.interrupt_other(record.survey_id)
            folder = self._processing.open_survey(
                record.survey_id, record.started_us, record.metadata_json, record.needed_bytes
            )
            return OpenedSurvey(str(folder), interrupted)

    def reopen(self, survey: str) -> ReopenedSurvey:
        with self._answer("reopen"), self._parts.disk:
            interrupted = self._processing.interrupt_other(survey)
            return replace(self._processing.reopen_survey(survey), interrupted=interrupted)

    def report(self, survey_id: str, report_json: str) -> int:
        with self._answer("report"), self._parts.disk:
            return self._processing.report(survey_id, report_json)

    def note(self, survey_id: str, note: Note) -> None:
        with self._answer("note"), self._parts.disk:
            self._processing.note(survey_id, note.kind.value, json.dumps(note.values))

    def store(self, trace: Trace) -> None:
        with self._answer("store"), self._parts.disk:
            # As bytes, as it is sent.
            self._processing.store(trace_message.decode(trace_message.encode(trace)))
        self._parts.world.acknowledged.append(trace)

    def close(self, survey_id: str, end: SurveyEnd) -> None:
        with self._answer("close"), self._parts.disk:
            self._processing.close_survey(survey_id, end.outcome, end.reason)


class RobotInProcess:
    """A robot in a world, and what its control says.

    Args:
        world: What it moves and measures.
        analyzer: Parameters of the VNA driver that differ from the usual ones.
    """

    def __init__(self, world: World, **analyzer: Any) -> None:
        self.world, self._analyzer = world, analyzer
        # Held while files change.
        self.disk = threading.RLock()
        self.killed = threading.Event()
        self._calls: Counter[str] = Counter()
        self._planned: Dict[Tuple[str, int], Callable[[], object]] = {}
        self._call_lock = threading.Lock()
        self.data = world.data
        self.clock = ControlTime()
        self.history: List[Status] = []
        self._changed = threading.Condition()
        self.status = SurveyStatus(self._note, lambda _given: None, lambda _coverage, _id: None)
        self.processes = {name: 1 for name in (*PLAIN_NAMES, STORAGE)}
        parameters = VnaParameters(**analyzer)
        self.processing = self._build_storage()
        self.axes = {axis_id: _Axis(self, axis_id) for axis_id in AxisId}
        self.driver = self._build_driver(parameters)
        self._nodes = NodeLiveness(self._watched_nodes(), self.clock, self.status.set_missing)
        robot = Robot(
            self.axes,
            _Analyzer(self, self.driver),
            _HeightSensor(self),
            _Storage(self, self.processing),
            self._nodes,
            _description(parameters),
            AuxSensors([], self.clock),
        )
        settings = SurveySettings(settle_s=0.0)
        self.control = MainControl(robot, settings, self.status, self.clock)
        self._nodes.start()

    def at(self, call: str, number: int, action: Callable[[], object]) -> None:
        """Do something before the call of a part, such as the 3rd "sweep" from now on, is made."""
        with self._call_lock:
            self._planned[call, self._calls[call] + number] = action

    def forget_plans(self) -> None:
        """Forget what `at` has planned and has not happened."""
        with self._call_lock:
            self._planned.clear()

    @contextlib.contextmanager
    def answer(self, call: str) -> Iterator[None]:
        """Carry out a call to a part; its errors are those that the control knows."""
        with self._call_lock:
            self._calls[call] += 1
            action = self._planned.pop((call, self._calls[call]), None)
        if action is not None:
            action()
        self._refuse_if_killed()
        try:
            yield
        except DeviceError:
            raise
        except Gpr20Error as error:
            raise DeviceError(error.message) from error
        self._refuse_if_killed()

    def _refuse_if_killed(self) -> None:
        if self.killed.is_set():
            raise NodeLostError(KILLED)

    def _note(self, _before: Status, after: Status) -> None:
        with self._changed:
            self.history.append(after)
            self._changed.notify_all()

    def wait(self, condition: Callable[[], bool]) -> None:
        """Return when the condition holds after some change of the status, or the kill."""
        with self._changed:
            assert self._changed.wait_for(condition, LIMIT_S), f"still {self.status.status}"

    def wait_for(self, *states: SurveyState) -> Status:
        """Return the status in which one of the states is entered."""
        self.wait(lambda: self.status.status.state in states)
        return self.status.status

    def begin(self, **changes: Any) -> str:
        """Set parameters that differ from the usual ones, and start."""
        self.control.set_parameters(replace(PARAMETERS, **changes))
        self.history.clear()
        return self.control.start()

    def go_on(self, accepted: Accepted = NOTHING, survey: str = "") -> None:
        """Resume the paused survey, or one on the disk."""
        self.history.clear()
        self.control.resume(survey, accepted)

    def wait_for_end(self) -> Status:
        """Return the status with which the survey ends or pauses."""
        return self.wait_for(*ENDS)

    @property
    def ended(self) -> bool:
        """Whether the survey has ended or is paused."""
        return self.status.status.state in ENDS

    def die(self) -> None:
        """Give no more answers from now on, as after a power cut; any thread may call it."""
        self.killed.set()
        self.clock.pace = 1000.0
        with self._changed:
            self._changed.notify_all()

    def kill(self) -> RobotInProcess:
        """Return the robot that is started after a kill: on the disk as it is now."""
        self.die()
        with self.disk:
            self.world.keep_disk()
        self.close()
        return RobotInProcess(self.world, **self._analyzer)

    def close(self) -> None:
        """End everything in order; a survey that runs is interrupted."""
        self.control.shut_down(LIMIT_S)
        self._nodes.stop()
        self.driver.shut_down()
        self.processing.shut_down()
        for axis in self.axes.values():
            axis.driver.close(LIMIT_S)

    def _build_storage(self) -> DataProcessing:
        data = self.data
        parts = StorageParts(
            data=data,
            check_data=lambda: ensure_folders(data, 0o750),
            open_recordings=open_recordings,
            topics=SurveyTopics(TRACE_DEFINITION),
            free_bytes=lambda _path: 10**12,
            now_ns=time.time_ns,
            clock=Clock(),
            revision="1.2.3",
            end_status=end_status,
        )
        drop: Callable[[Any], None] = lambda _message: None  # noqa: E731
        processing = DataProcessing(parts, Limits(), drop, drop, drop)
        processing.start()
        return processing

    def _build_driver(self, parameters: VnaParameters) -> VNADriver:
        limits = LinkLimits(parameters.connect_timeout_s, parameters.answer_timeout_s)
        deadline = RequestDeadline(self.world.time)
        analyzer = make_analyzer(
            parameters, lambda address: self.world.link(address, limits), deadline
        )
        return VNADriver(analyzer, parameters, deadline, lambda _warning: None)

    def _watched_nodes(self) -> Dict[str, WatchedNode]:
        def probe(name: str) -> Callable[[], int]:
            def process() -> int:
                if self.processes[name] == 0:
                    raise NodeGoneError(Message("{node} has ended", node=name))
                return self.processes[name]

            return process

        names = {**PLAIN_NAMES, STORAGE: STORAGE_NAME}
        return {name: WatchedNode(plain, [probe(name)]) for name, plain in names.items()}


def _description(analyzer: VnaParameters) -> DescribedRobot:
    """Return what the nodes of the robot say of themselves."""
    described = DescribedRobot(Site(), TimeLimits(), lambda _robot: None)
    configurations: Dict[str, Any] = {
        f"{axis_id.value}_axis/axis_driver": AXES[axis_id] for axis_id in AxisId
    }
    configurations.update(height_sensor=HeightParameters(), vna_acquisition=analyzer)
    for node, parameters in configurations.items():
        hardware = Hardware(f"simulated {node}", simulated=True)
        as_sent = json.loads(json.dumps(asdict(parameters), default=lambda value: value.value))
        described.note(NodeDescription(node, hardware, as_sent))
    described.note(NodeDescription(STORAGE, NO_HARDWARE, {}))
    return described
