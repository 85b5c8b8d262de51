"""A robot of plain objects, and a main control over it, for the tests of the survey."""

from __future__ import annotations

import json
import threading
import time
from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
from survey_examples import AXES, PARAMETERS

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, received_message, verbatim
from gpr20_common.mid.node_facts import NO_HARDWARE, Hardware
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.described_robot import AuxSensors, DescribedRobot
from gpr20_main_control.mid.devices.node_liveness import NodeLiveness
from gpr20_main_control.mid.devices.robot import (
    AnalyzerCalibration,
    AnalyzerSetup,
    AxisReading,
    Lease,
    Robot,
    SweepConfirmation,
    UnconfirmedSweep,
    motion_error,
)
from gpr20_main_control.mid.main_control import MainControl
from gpr20_main_control.mid.survey.survey_status import SurveyStatus
from gpr20_survey.axes import UNKNOWN_ZERO, AxisId, ZeroEpoch
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.annotation import EMPTY, Site
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.answers import ReopenedSurvey
from gpr20_survey.trace.sweep import CalibrationStatus, Sweep

LIMIT_S = 60.0
# The imaginary part of every sweep; the real part is its number, a small difference beside it.
LEVEL = 1.0e4
FIRST_SWEEP_US = 1_800_000_000_000_000
NODES = {
    "x_axis/axis_driver": Message("the x axis driver"),
    "vna_acquisition": Message("the VNA driver"),
    "vna_processing": Message("the storage"),
}


def reports(message, fault, *shown):
    """Return whether a fault decides what a message says, and whether it shows these values."""
    values = [value for one in message.nested() for value in one.values.values()]
    return message.fault_code == fault.code and all(one in values for one in shown)


def warning_of(entry):
    """Return the message of a warning in survey.json."""
    return received_message(entry["warning"], entry["warning_message"])


class FastClock(Clock):
    """Waits end a thousand times as fast, and everything else takes ten times its time.

    So a thread that gets no processor for a while on a busy computer reaches no limit.
    """

    WAITING, WORKING = 1000.0, 10.0

    def __init__(self):
        # What a test has set the time of day forward by, against the passing seconds.
        self.set_s = 1.8e9
        self._waited_s = 0.0
        self._adding = threading.Lock()
        self._read = threading.local()

    def time_of_day_us(self):
        self._read.now_s = self.now_s()
        return round(1e6 * (self._read.now_s + self.set_s))

    def now_s(self):
        # The same moment as the time of day that the thread read just before: what other threads
        # wait between the readings would be a clock that was set.
        read = vars(self._read).pop("now_s", None)
        return self._now_s() if read is None else read

    def wait_s(self, event, timeout_s):
        until_s = self._now_s() + timeout_s
        if event.wait(timeout_s / self.WAITING):
            return True
        with self._adding:
            self._waited_s += max(0.0, until_s - self._now_s())
        return False

    def _now_s(self):
        return self._waited_s + self.WORKING * time.monotonic()


class ManualClock(FastClock):
    """A test sets the time; each wait ends at once and takes a little of it."""

    def __init__(self):
        super().__init__()
        self.time_s = 0.0
        self.waits_s = []

    def now_s(self):
        return self.time_s

    def wait_s(self, event, timeout_s):
        self.waits_s.append(timeout_s)
        self.time_s += 0.01
        return event.wait(0.001)


class FakeAxis:
    """An axis that arrives at once, unless a test sets something else."""

    def __init__(self, finds_zero=True):
        self.finds_zero = finds_zero
        self.received = threading.Event()
        self.coordinate = 0.0
        self.homed = False
        self.zero = UNKNOWN_ZERO
        self.silent = False
        self.moves = []
        self.homings = 0
        self.stops = 0
        self.fail_move = ""
        self.blocked = threading.Event()
        self.blocked.set()
        self.begun = threading.Event()
        self.hanging = threading.Event()
        self.hanging.set()
        self.failure = None

    def reading(self):
        moving = not self.blocked.is_set()
        age_s = 100.0 if self.silent else 0.0
        return AxisReading(self.coordinate, self.homed, moving, age_s, self.zero)

    def begin_zero(self, found=True):
        """Find or set the zero, as the survey or somebody else does."""
        number = self.zero.number + 1
        self.zero = ZeroEpoch(number, FIRST_SWEEP_US + number if found else self.zero.time_us)

    def lease(self, number=0, release=False):
        return Lease(1, 2.0)

    def is_connected(self):
        return True

    def begin_move(self, target):
        assert target != self.coordinate, "a move that is none was sent"
        self.moves.append(target)
        self.begun.set()
        self.failure = motion_error(verbatim(self.fail_move)) if self.fail_move else None
        if not self.fail_move and self.blocked.is_set():
            self.coordinate = target

    def move_ended(self):
        if self.blocked.is_set() and self.failure is not None:
            raise self.failure
        return self.blocked.is_set()

    def home(self, time_limit_s):
        self.homings += 1
        self.hanging.wait(LIMIT_S)
        self.coordinate, self.homed = 0.0, True
        self.begin_zero(self.finds_zero)

    def set_zero(self):
        self.coordinate, self.homed = 0.0, True
        self.begin_zero()

    def stop(self):
        self.stops += 1


class FakeAnalyzer:
    """An analyzer whose sweeps are numbered."""

    def __init__(self):
        self.connections = []
        self.calibration_refusal = ""
        self.temperature_c = None
        self.sweeps = 0
        self.level = LEVEL
        self.failures = 0
        self.on_sweep = lambda: None
        self.on_confirm = lambda number: ()
        self.accept = lambda settings: settings
        self.identity = "Anritsu,MS2026C/2,SIMULATED,1.0"
        self.sweep_duration_s = 0.0
        self.releases = 0
        self.requested = []
        self.settings = None

    def connect(self, address):
        self.connections.append(address)
        return self.identity

    def release(self):
        self.releases += 1

    def calibration(self):
        self._check_calibration()
        return AnalyzerCalibration(CalibrationStatus.HIGH, {})

    def _check_calibration(self):
        if self.calibration_refusal:
            raise DeviceError(verbatim(self.calibration_refusal))

    def configure(self, settings):
        self.requested.append(settings)
        self.settings = self.accept(settings)
        return AnalyzerSetup(self.settings, self.sweep_duration_s, 40.0)

    def sweep(self):
        self.on_sweep()
        if self.failures:
            self.failures -= 1
            raise DeviceError(Message("the VNA did not answer"))
        self._check_calibration()
        self.sweeps += 1
        settings = self.settings
        values = np.full(settings.points, float(self.sweeps))
        began_us = FIRST_SWEEP_US + self.sweeps * 10
        sweep = Sweep(
            settings.frequencies_hz(),
            values,
            np.full(settings.points, self.level),
            began_us,
            began_us + 5,
            (),
            settings.analyzer,
        )
        return UnconfirmedSweep(self.sweeps, sweep)

    def confirm(self, number):
        assert number == self.sweeps, "another sweep was taken before this one was confirmed"
        return SweepConfirmation(self.on_confirm(number), self.temperature_c)


class FakeStorage:
    """Stores surveys in memory; refuses what the real one refuses, and what a test wants."""

    def __init__(self):
        self.records, self.samples = [], []
        self.ends, self.reports, self.notes = [], [], []
        self.opened, self.outcomes = "", {}
        self.reopened, self.reopenings = None, []
        self.broken, self.fail_close, self.lose = False, "", 0
        self.free = threading.Event()
        self.free.set()

    def stored(self, survey_id):
        return {one.index: one for one in self.samples if one.survey_id == survey_id}

    def open(self, record):
        self._check(not self.broken, "the disk of the robot is full")
        self.opened = record.survey_id
        self.records.append(record)
        return f"/data/{record.survey_id}"

    def reopen(self, survey):
        self.reopenings.append(survey)
        if self.reopened is not None:
            self.opened = self.reopened.survey_id
            return self.reopened
        known = {one.survey_id: one for one in self.records}
        self._check(survey in known, f"there is no survey {survey}")
        self._check(self.outcomes.get(survey) != "finished", "it is finished and complete")
        self.opened = survey
        self.outcomes.pop(survey, None)
        stored = self.stored(survey)
        in_order = list(stored.values())
        return ReopenedSurvey(
            survey,
            f"/data/{survey}",
            known[survey].metadata_json,
            "".join(map(json.dumps, self.reports[-1:])),
            tuple(sorted(stored)),
            (*in_order[:-8][:4], *in_order[-8:]),
        )

    def add_fact(self, survey_id, kind, values_json):
        self._check_open(survey_id)
        values = json.loads(values_json)
        if kind is Kind.REPORT:
            self.reports.append(values)
        else:
            self.notes.append(SimpleNamespace(kind=kind, values=values))
        before = 0 if self.reopened is None else len(self.reopened.stored_indices)
        return before + len(self.stored(survey_id)) - self.lose

    def store(self, sample):
        self.free.wait(LIMIT_S)
        self._check_open(sample.survey_id)
        stored = self.stored(sample.survey_id).get(sample.index, sample)
        self._check(stored is sample, f"index {sample.index} is stored with other content")
        self.samples.append(sample)

    def close(self, survey_id, end):
        self._check(not self.fail_close, self.fail_close)
        if not self.opened and self.outcomes.get(survey_id) == end.outcome:
            return
        self._check_open(survey_id)
        self.opened = ""
        self.outcomes[survey_id] = end.outcome
        self.ends.append(end)

    def _check_open(self, survey_id):
        self._check(not self.broken, "the disk of the robot is full")
        self._check(self.opened == survey_id, f"survey {survey_id} is not open")

    @staticmethod
    def _check(allowed, reason):
        if not allowed:
            raise DeviceError(verbatim(reason))


def described_robot(simulated=True):
    """Return what the nodes of a robot say about themselves."""
    robot = DescribedRobot(Site(), lambda _robot: None)
    configurations = {
        f"{axis_id.value}_axis/axis_driver": asdict(AXES[axis_id]) for axis_id in AxisId
    }
    configurations.update(height_sensor={"samples": 5}, vna_acquisition={"address": "127.0.0.2"})
    for node, configuration in configurations.items():
        hardware = Hardware(f"fake {node}", simulated)
        robot.note(NodeDescription(node, hardware, configuration))
    robot.note(NodeDescription("vna_processing", NO_HARDWARE, {"data": "/surveys"}))
    return robot


class HandNotedNodes(NodeLiveness):
    """Nodes that a test marks as alive or silent; they are not polled."""

    def __init__(self, clock, on_change):
        # On a busy computer the fast clock lets the time to start pass before all are there.
        started = []
        super().__init__(clock, lambda missing: started and on_change(missing))
        self.on_refresh = lambda: None
        for name, plain_name in NODES.items():
            self.watch(name, plain_name, None)
            self.note_alive(name, 1)
        started.append(True)

    def note_alive(self, name, process):
        self.note(name, process)

    def note_silent(self, name):
        self.note(name, None)

    def refresh(self):
        self.on_refresh()


class Bench:
    """A main control over a fake robot, and its history."""

    def __init__(
        self,
        clock=None,
        analyzer=None,
        storage=None,
        defaults=EMPTY,
        sensors=None,
        **settings,
    ):
        self.x, self.y, self.z = FakeAxis(), FakeAxis(), FakeAxis(finds_zero=False)
        self.analyzer = analyzer or FakeAnalyzer()
        # Over level ground.
        self.height = SimpleNamespace(height_m=lambda: 0.2)
        self.storage = storage or FakeStorage()
        # For what waits in a test.
        self.go_on = threading.Event()
        self.history = []
        self.verdicts = []
        self.activities = []
        self.parameters = []
        self._changed = threading.Condition()
        note_coverage = lambda coverage, _survey: self.verdicts.append(coverage.verdict())  # noqa: E731
        self.board = SurveyStatus(self._note, self.parameters.append, note_coverage)
        clock = self.clock = clock or FastClock()
        self.nodes = HandNotedNodes(clock, lambda missing: self.board.update(missing=missing))
        self.description = described_robot()
        self.robot = Robot(
            dict(zip(AxisId, self.axes)),
            self.analyzer,
            lambda: self.height.height_m(),
            self.storage,
            self.nodes,
            self.description,
            sensors or AuxSensors([], self.clock),
        )
        self.control = MainControl(
            self.robot,
            SurveySettings(**{"settle_s": 0.0, "return_limit_s": 3600.0, **settings}),
            self.board,
            clock,
            defaults,
            self.activities.append,
        )

    def _note(self, _before, after):
        with self._changed:
            self.history.append(after)
            self._changed.notify_all()

    def release(self):
        """Release everything that a test has blocked."""
        self.storage.free.set()
        self.go_on.set()
        for axis in self.axes:
            axis.blocked.set()
            axis.hanging.set()

    @property
    def axes(self):
        return [self.x, self.y, self.z]

    @property
    def states(self):
        """The states in the order in which they were entered."""
        states = [status.state.name for status in self.history]
        return [s for s, before in zip(states, [None, *states]) if s != before]

    def start(self, **changes):
        self.control.set_parameters(replace(PARAMETERS, **changes))
        return self.control.start()

    def at_sweep(self, number, act):
        """Act once, at the beginning of the sweep after so many."""

        def on_sweep():
            if self.analyzer.sweeps == number:
                self.analyzer.on_sweep = lambda: None
                act()

        self.analyzer.on_sweep = on_sweep

    def complete(self, total=24):
        """Wait for the end of a survey, which must have stored every point exactly once."""
        self.wait_for(SurveyState.FINISHED)
        assert [sample.index for sample in self.storage.samples] == list(range(total))

    def resume_to_the_end(self):
        self.control.resume("")
        self.complete()

    def wait_until(self, condition, limit_s=LIMIT_S):
        """Wait for a condition that is true after some change of the status."""
        with self._changed:
            assert self._changed.wait_for(condition, limit_s), f"still {self.board.status}"

    def wait_for_visited(self, points, limit_s=LIMIT_S):
        """Wait until a number of points is stored."""
        self.wait_until(lambda: self.board.status.visited_points >= points, limit_s)

    def wait_for_fault(self, fault, *shown):
        """Wait until the message of the control reports a fault and shows some values."""
        self.wait_until(lambda: reports(self.board.status.message, fault, *shown))

    def wait_for(self, *states):
        """Wait until the control is in one of the states and return its status."""
        with self._changed:
            self.wait_until(lambda: self.board.status.state in states)
            return self.board.status
