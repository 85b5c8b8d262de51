"""The robot below ROS in one process: control, axes, height sensor, VNA driver and storage.

Everything is that of the robot but the threads and services between the parts, which here are
calls, and what `simulated_world` simulates.
"""

from __future__ import annotations

import json
import re
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence

import numpy as np
from robot_parts import (
    AXES,
    Calls,
    ProcessAnalyzer,
    ProcessAxis,
    ProcessHeightSensor,
    ProcessStorage,
)
from simulated_world import LIMIT_S, World
from storage_kit import NO_BAGS, bag_traces, end_status, mcap_traces, torn_mcap_traces, with_bag
from trace_examples import assert_same_numbers

from gpr20_common.catalogue import FOLDER, read_translations
from gpr20_common.low.clock import Clock
from gpr20_common.mid.codec import plain
from gpr20_common.mid.node_facts import NO_HARDWARE, Hardware
from gpr20_height_sensor.height_driver import HeightParameters
from gpr20_main_control.mid.devices.described_robot import AuxSensors, DescribedRobot
from gpr20_main_control.mid.devices.node_liveness import NodeLiveness
from gpr20_main_control.mid.devices.robot import Robot
from gpr20_main_control.mid.main_control import MainControl
from gpr20_main_control.mid.survey.survey import NOTHING, Accepted
from gpr20_main_control.mid.survey.survey_status import Status, SurveyStatus
from gpr20_simulator.mid.world.medium import probed_rotation_deg
from gpr20_survey.axes import AxisId
from gpr20_survey.files.durable_files import ensure_folders
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.annotation import Site
from gpr20_survey.plan.robot_description import PLAIN_NAMES, STORAGE, STORAGE_NAME, NodeDescription
from gpr20_survey.plan.survey_parameters import SurveyParameters, SurveySettings
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.trace.trace import Trace
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits
from gpr20_vna_acquisition.mid.analyzers import make_analyzer
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters
from gpr20_vna_processing.mid.data_processing import DataProcessing
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters
from gpr20_vna_processing.mid.processing_records import Storage as StorageParts

# 18 points, and few frequencies.
PARAMETERS = SurveyParameters(
    "127.0.0.1", 600.0e6, 6.0e9, 51, x_start_mm=10.0, x_stop_mm=20.0, x_points=3,
    y_start_mm=10.0, y_stop_mm=20.0, y_points=3, polarizations_deg=(0.0, 90.0),
)  # fmt: skip
ENDS = (SurveyState.FINISHED, SurveyState.PAUSED, SurveyState.STOPPED, SurveyState.FAILED)
TRACES = 18
SPANISH = read_translations(FOLDER / "es.po")
NUMERAL = re.compile(r"\{number:[^{}]*\}")


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


class RobotInProcess:
    """A robot in a world, and what its control says.

    Args:
        world: What it moves and measures.
        parameters: Those of the VNA driver; None for the usual ones.
        settings: Settings of the surveys that differ from the usual ones.
    """

    def __init__(
        self, world: World, parameters: Optional[VnaParameters] = None, **settings: Any
    ) -> None:
        self.world, self._parameters, self._settings = world, parameters, settings
        parameters = parameters or VnaParameters()
        self.calls = Calls()
        self.data = world.data
        self.clock = ControlTime()
        self.history: List[Status] = []
        self._changed = threading.Condition()
        self.status = SurveyStatus(self._note, lambda _given: None, lambda _coverage, _id: None)
        self.processing = self._build_storage()
        self.axes = {axis_id: ProcessAxis(world, self.calls, axis_id) for axis_id in AxisId}
        self.driver = self._build_driver(parameters)
        self._nodes = NodeLiveness(self.clock, lambda missing: self.status.update(missing=missing))
        for name, plain_name in {**PLAIN_NAMES, STORAGE: STORAGE_NAME}.items():
            # Always the same process.
            self._nodes.watch(name, plain_name, lambda: 1)
        self.height_sensor = ProcessHeightSensor(world, self.calls)
        self.parts = Robot(
            self.axes,
            ProcessAnalyzer(self.calls, self.driver),
            self.height_sensor.height_m,
            ProcessStorage(world, self.calls, self.processing),
            self._nodes,
            self._description(parameters),
            AuxSensors([], self.clock),
        )
        self.control = MainControl(
            self.parts, SurveySettings(settle_s=0.0, **settings), self.status, self.clock
        )

    def _note(self, _before: Status, after: Status) -> None:
        with self._changed:
            self.history.append(after)
            self._changed.notify_all()

    def wait(self, condition: Callable[[], bool]) -> None:
        """Return when the condition holds after some change of the status, or the kill."""
        with self._changed:
            assert self._changed.wait_for(condition, LIMIT_S), f"still {self.status.status}"

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
        self.wait(lambda: self.status.status.state in ENDS)
        return self.status.status

    def die(self) -> None:
        """Give no more answers from now on, as after a power cut; any thread may call it."""
        self.calls.killed.set()
        self.clock.pace = 1000.0
        self.look()

    def look(self) -> None:
        """Let `wait` look at its condition."""
        with self._changed:
            self._changed.notify_all()

    def kill(self) -> RobotInProcess:
        """Return the robot that is started after a kill: on the disk as it is now."""
        self.die()
        with self.calls.disk:
            self.world.keep_disk()
        self.close()
        return RobotInProcess(self.world, self._parameters, **self._settings)

    def close(self) -> None:
        """End everything in order; a survey that runs is interrupted."""
        self.control.shut_down(LIMIT_S)
        self._nodes.stop()
        self.driver.shut_down()
        self.processing.shut_down()
        for axis in self.axes.values():
            axis.driver.close(LIMIT_S)

    def _build_storage(self) -> DataProcessing:
        parts = StorageParts(
            ProcessingParameters(data=str(self.data)),
            check_data=lambda: ensure_folders(self.data, 0o750),
            topics=SurveyTopics(),
            free_bytes=lambda _path: self.world.free_bytes,
            now_ns=lambda: time.time_ns(),  # as it is set by then
            clock=Clock(),
            revision="1.2.3",
            end_status=end_status,
            bags=NO_BAGS,
        )
        processing = DataProcessing(parts)
        processing.start()
        return processing

    def _build_driver(self, parameters: VnaParameters) -> VNADriver:
        limits = LinkLimits(parameters.connect_timeout_s, parameters.answer_timeout_s)
        deadline, connect = RequestDeadline(self.world.time), self.world.vna.connect
        analyzer = make_analyzer(parameters, lambda address: connect(address, limits), deadline)
        return VNADriver(analyzer, parameters, deadline, lambda _warning: None)

    def _description(self, analyzer: VnaParameters) -> DescribedRobot:
        """Return what the nodes of the robot say of themselves."""
        described = DescribedRobot(Site(), lambda _robot: None)
        configurations: Dict[str, Any] = {
            f"{axis_id.value}_axis/axis_driver": AXES[axis_id] for axis_id in AxisId
        }
        configurations.update(height_sensor=HeightParameters(), vna_acquisition=analyzer)
        for node, parameters in configurations.items():
            hardware = Hardware(f"simulated {node}", simulated=True)
            described.note(NodeDescription(node, hardware, plain(parameters)))
        described.note(NodeDescription(STORAGE, NO_HARDWARE, {"data": str(self.data)}))
        return described


def folder_of(robot: RobotInProcess, survey_id: str = "") -> Path:
    """Return the folder of a survey; of the present or last one by default."""
    (folder,) = robot.world.data.glob(f"*_{(survey_id or robot.status.status.survey_id)[:8]}")
    return folder


def description_in(robot: RobotInProcess, survey_id: str = "") -> Dict[str, Any]:
    """Return what the log of a survey says of it."""
    return read_description(folder_of(robot, survey_id))


def json_traces(robot: RobotInProcess, survey_id: str = "") -> List[Dict[str, Any]]:
    """Return the JSON traces of a survey in the order of their index."""
    files = sorted((folder_of(robot, survey_id) / "traces").glob("*.json"))
    return [json.loads(path.read_text()) for path in files]


def check_state(robot: RobotInProcess, state: SurveyState) -> Status:
    """Return the status with which the survey ends or pauses; all of it is in Spanish too."""
    status = robot.wait_for_end()
    assert status.state is state, status.message
    assert str(status.full_message).isprintable()
    shown = {one.template for one in status.full_message.nested()}
    assert {one for one in shown if not NUMERAL.fullmatch(one)} <= SPANISH.keys()
    return status


def check_pause(robot: RobotInProcess, code: str, *values: str) -> None:
    """Wait until the survey pauses with a fault; the operator must read these values."""
    message = check_state(robot, SurveyState.PAUSED).message
    assert message.fault_code == code, message
    assert all(value in str(message) for value in values), message


def check_resumed(robot: RobotInProcess, accepted: Accepted = NOTHING) -> List[Dict[str, Any]]:
    """Resume the paused survey; it must end complete. Return its traces."""
    robot.go_on(accepted)
    check_state(robot, SurveyState.FINISHED)
    return check_complete(robot)


def check_complete(robot: RobotInProcess, survey_id: str = "") -> List[Dict[str, Any]]:
    """Return the traces: each point once, a whole sweep of its own that was made there."""
    stored = json_traces(robot, survey_id)
    assert [one["index"] for one in stored] == list(range(TRACES))
    places = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
    assert len(places) == TRACES
    check_places(stored, [0.0] * TRACES)
    return stored


def check_places(stored: List[Dict[str, Any]], turned_deg: Sequence[float]) -> None:
    """Check that each trace is a whole sweep of its own that was made where it says.

    Args:
        stored: The traces of a survey.
        turned_deg: By how much the zero of z was off the mark of the antennas [deg].
    """
    sweeps = [one["s21_real"][0] for one in stored]
    assert len(set(sweeps)) == len(stored), "a sweep was stored twice"
    for one, sweep, angle_deg in zip(stored, sweeps, turned_deg):
        assert set(one["s21_real"]) == {sweep}, "two sweeps are mixed"
        place = np.float32(one["x_coord_mm"] + one["y_coord_mm"] / 1000.0)
        assert set(one["s21_imag"]) == {float(place)}
        off_deg = probed_rotation_deg(complex(sweep)) - one["z_coord_deg"] - angle_deg
        assert abs((off_deg + 100.0) % 200.0 - 100.0) < 0.4
        assert abs(one["antennae_height_m"] - 0.20) < 0.01


def check_acknowledged(
    robot: RobotInProcess, acknowledged: List[Trace], survey_id: str = ""
) -> None:
    """Find each trace whose storage was acknowledged, once, in every form of the survey."""
    folder = folder_of(robot, survey_id)
    stored = {one["index"]: one for one in json_traces(robot, survey_id)}
    if (folder / "manifest.json").exists():
        bag = with_bag(folder) / "survey.bag"
        recordings = [bag_traces(bag), mcap_traces(folder / "survey.mcap")]
    else:
        # It was cut off, and nobody has resumed it: it has no bag.
        recordings = [torn_mcap_traces(folder / "survey.mcap")]
    recorded = [{one.index: one for one in found} for found in recordings]
    assert all(stored.keys() == found.keys() for found in recorded)
    for trace in acknowledged:
        for form in (stored, *recorded):
            assert_same_numbers(trace, form[trace.index])
