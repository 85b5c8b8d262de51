"""The parts of the robot in one process, as its control calls them.

Each is the driver or the storage of the robot; what a node and a service are between it and the
control is here a call.
"""

from __future__ import annotations

import contextlib
import threading
from collections import Counter
from concurrent.futures import Future
from dataclasses import replace
from typing import Any, Callable, Dict, Iterator, Optional, Tuple

from simulated_world import MECHANICS, STEP_MM, World

from gpr20_axis_driver.faults import AxisException, MotionStopped
from gpr20_axis_driver.low.step_counter import open_step_counter
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.axis_lease import AxisLease
from gpr20_axis_driver.mid.pulse_loop import PulseLoop
from gpr20_axis_driver.mid.pulse_process import LOCK_LIMIT_S, MADE_US
from gpr20_axis_driver.motion import Ending, Motion, MotionReport, StopRequested
from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_common.mid.node_facts import Hardware
from gpr20_height_sensor.adc_interface import AdcInterface
from gpr20_height_sensor.height_driver import HeightDriver, HeightParameters
from gpr20_main_control.errors import DeviceError, NodeLostError, UnconfirmedError
from gpr20_main_control.mid.devices.robot import (
    AnalyzerCalibration,
    AnalyzerSetup,
    AxisReading,
    Lease,
    SurveyEnd,
    SurveyRecord,
    SweepConfirmation,
    UnconfirmedSweep,
    motion_error,
)
from gpr20_main_control.mid.waits import Workers
from gpr20_simulator.mid.analyzer.simulated_analyzer import StepTime
from gpr20_simulator.mid.carriage import AxisMotor, SimulatedPins, mechanics_of, wiring_of
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.range_sensor import RangeSensor, SimulatedSpi
from gpr20_survey.axes import AxisId, AxisParameters
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.results.answers import ReopenedSurvey
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.sweep import SweepSettings
from gpr20_survey.trace.trace import Trace
from gpr20_vna_acquisition.errors import VnaNotReadyError, VnaOldDataError, VnaSettingError
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_processing.mid.data_processing import DataProcessing

CALLER = "/main_control"
# Renewed so often that the control soon notices the end of a lease [s].
RENEWED_S = 0.04
AXES = {
    AxisId.X: AxisParameters(13, 15, STEP_MM, 0.0015, 0.005, 0.0001, 0.0, 650.0, "LIN", 16),
    AxisId.Y: AxisParameters(37, 38, STEP_MM, 0.0025, 0.005, 0.0001, 0.0, 800.0, "LIN", 40),
    AxisId.Z: AxisParameters(11, 12, 1.8, 0.010, 0.025, 0.005, -90.0, 90.0, "ROT"),
}
# A killed robot is gone for its control, too, which is ended only because it shares the process.
KILLED = Message("the robot was killed")


class DirectPulses:
    """Implements `AxisMotions`; what it does not make itself is asked of the counter.

    Args:
        runner: Makes the pulses: a `PulseLoop`.
        counter: Counts them: a `StepCounter`, or what stands for it.
    """

    failure: Optional[Message] = None
    scheduling = Message("ordinary")
    hardware = Hardware("pins")

    def __init__(self, runner: Any, counter: Any) -> None:
        self._runner, self._counter = runner, counter
        self.distrust = counter.begin

    def __getattr__(self, name: str) -> Any:
        return getattr(self._counter, name)

    def begin_zero(self, steps: int, time_us: int) -> None:
        self._counter.begin_zero(time_us)
        self._counter.place(steps)

    def run(self, motion: Motion, stop_requested: StopRequested) -> MotionReport:
        exact = self.trusted
        report: MotionReport = self._runner.run(motion, stop_requested)
        assert self.trusted == (exact and report.ending is not Ending.GAP)
        return report

    def revive(self) -> None:
        pass

    def close(self) -> None:
        self._runner.close()
        self._counter.close()


class Calls:
    """The calls of the control to the parts: what happens before one, and after the kill.

    Attributes:
        killed: Set when no part answers any more.
        disk: Held while files change.
        frozen_s: How long the control has not renewed its leases [s].
    """

    def __init__(self) -> None:
        self.killed = threading.Event()
        self.disk = threading.RLock()
        self.frozen_s = 0.0
        self._made: Counter[str] = Counter()
        self._planned: Dict[Tuple[str, int], Callable[[], object]] = {}
        self._lock = threading.Lock()

    def at(self, call: str, number: int, action: Callable[[], object]) -> None:
        """Do something before the call of a part, such as the 3rd "sweep" from now on, is made.

        Besides: "step x" and the like, and "stored", when a trace is, before that is said.
        """
        with self._lock:
            self._planned[call, self._made[call] + number] = action

    def note(self, call: str) -> None:
        """Do what is planned for now."""
        with self._lock:
            self._made[call] += 1
            action = self._planned.pop((call, self._made[call]), None)
        if action is not None:
            action()

    def forget_plans(self) -> None:
        """Forget what `at` has planned and has not happened."""
        with self._lock:
            self._planned.clear()

    @contextlib.contextmanager
    def answer(self, call: str) -> Iterator[None]:
        """Carry out a call to a part; its errors are those that the control knows."""
        self.note(call)
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


class ProcessAxis:
    """An axis as the control uses it."""

    def __init__(self, world: World, calls: Calls, axis_id: AxisId) -> None:
        self._calls, self._parameters = calls, AXES[axis_id]
        mechanics = mechanics_of(MECHANICS, axis_id)
        path = world.folder / f"{axis_id.value}_steps"
        new = not path.exists()
        counter = open_step_counter(path, self._parameters.step_size, LOCK_LIMIT_S)
        if new and not self._parameters.finds_zero:
            counter.begin_zero(MADE_US)
            counter.place(world.state.steps(axis_id))
        pins = SimulatedPins(
            AxisMotor(world.state, axis_id, mechanics), wiring_of(axis_id, mechanics)
        )
        loop = PulseLoop(pins, self._parameters, StepTime(), counter, realtime=False)
        self.driver = AxisDriver(self._parameters, DirectPulses(loop, counter))
        # No lease ends because this computer is slow.
        self.ownership = AxisLease(self._parameters.lease_limit_s, lambda: calls.frozen_s)
        self.received, self.stopped = threading.Event(), threading.Event()
        self._step = f"step {axis_id.value}"
        self._stops = 0
        self._move: Future[None] = Future()
        self._motions = Workers(most=1)

    def reading(self) -> AxisReading:
        here = self.driver.position
        return AxisReading(here.coordinate, here.homed, self.driver.moving, 0.0, here.zero)

    def is_connected(self) -> bool:
        return not self._calls.killed.is_set()

    def lease(self, number: int = 0, release: bool = False) -> Lease:
        with self._calls.answer("lease"):
            if release:
                self.ownership.release(CALLER, number)
            elif number:
                self.ownership.renew(CALLER, number)
            else:
                number = self.ownership.reserve(CALLER)
            return Lease(number, RENEWED_S)

    def begin_move(self, target: float) -> None:
        stops = self._stops
        with self._calls.answer("move"):
            self._move = self._motions.begin(
                lambda: self._owned(
                    stops, lambda ends: self.driver.move_to_coordinate(target, ends)
                )
            )
            self._move.add_done_callback(lambda _move: self.received.set())

    def move_ended(self) -> bool:
        return self._move.done() and self._move.result() is None

    def home(self, time_limit_s: float) -> None:
        stops = self._stops
        with self._calls.answer("home"):
            self._owned(stops, self.driver.homing)

    def set_zero(self) -> None:
        with self._calls.answer("set_zero"), self.ownership.use(CALLER):
            self.driver.set_zero()

    def stop(self) -> None:
        self._stops += 1
        self.stopped.set()

    def _owned(self, stops: int, motion: Callable[[StopRequested], None]) -> None:
        """Carry out a motion, until a stop, the end of the lease or the kill."""

        def stopped() -> bool:
            return self._stops != stops or self._calls.killed.is_set()

        def ends() -> bool:
            self._calls.note(self._step)
            return stopped() or lapsed() is not None

        try:
            with self.ownership.use(CALLER) as lapsed:
                motion(ends)
        except AxisException as error:
            message = error.message
            if isinstance(error, MotionStopped) and not stopped():
                message = self.ownership.lapse
            raise motion_error(message) from error


class ProcessAnalyzer:
    def __init__(self, calls: Calls, driver: VNADriver) -> None:
        self._answer, self._driver = calls.answer, driver

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


class ProcessHeightSensor:
    def __init__(self, world: World, calls: Calls) -> None:
        self._answer = calls.answer
        ground = Ground(world.scene)

        def true_height_m() -> float:
            here = world.position()
            return ground.antenna_height_m(here.x_mm, here.y_mm)

        sensor = RangeSensor(world.scene.adc, true_height_m, lambda: world.state.adc_fault)
        parameters = HeightParameters()
        adc = AdcInterface(SimulatedSpi(sensor.code), parameters.channel)
        self.driver = HeightDriver(adc, parameters, StepTime())

    def height_m(self) -> float:
        with self._answer("height"):
            return self.driver.take_measurement().height_m


class ProcessStorage:
    """The storage; what it acknowledged is in `World.acknowledged`."""

    def __init__(self, world: World, calls: Calls, processing: DataProcessing) -> None:
        self._answer, self._note, self._disk = calls.answer, calls.note, calls.disk
        self._processing, self._acknowledged = processing, world.acknowledged

    def open(self, record: SurveyRecord) -> str:
        with self._answer("open"), self._disk:
            self._processing.interrupt_other(record.survey_id)
            folder = self._processing.open_survey(
                record.survey_id, record.started_us, record.metadata_json, record.needed_bytes
            )
            return str(folder)

    def reopen(self, survey: str) -> ReopenedSurvey:
        with self._answer("reopen"), self._disk:
            interrupted = self._processing.interrupt_other(survey)
            return replace(self._processing.reopen_survey(survey), interrupted=interrupted)

    def add_fact(self, survey_id: str, kind: Kind, values_json: str) -> int:
        # By these names a test says when something happens.
        call = "report" if kind is Kind.REPORT else "note"
        with self._answer(call), self._disk:
            return self._processing.add_fact(survey_id, kind.value, values_json).stored_traces

    def store(self, trace: Trace) -> None:
        with self._answer("store"), self._disk:
            # As bytes, as it is sent.
            self._processing.store(trace_message.decode(trace_message.encode(trace)))
            self._note("stored")
        self._acknowledged.append(trace)

    def close(self, survey_id: str, end: SurveyEnd) -> None:
        with self._answer("close"), self._disk:
            self._processing.close_survey(survey_id, end.outcome, end.reason)
