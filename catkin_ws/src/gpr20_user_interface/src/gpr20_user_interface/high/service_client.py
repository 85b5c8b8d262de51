"""The services and topics of SERVICE as events."""

from __future__ import annotations

import math
import os
import socket
import threading
from functools import partial
from typing import Any, Callable, List, Mapping

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Bool

from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_common.sent_message import message_from
from gpr20_doctor.mid.machine_probe import probe_machine
from gpr20_doctor.mid.machine_request import ThisMachine
from gpr20_doctor.mid.node_health import NodeHealth
from gpr20_msgs.msg import ServiceStatus
from gpr20_msgs.srv import DailyCheck, GetHeight, ServiceMove, TestAnalyzer
from gpr20_operator import faults
from gpr20_operator.robot.senders import Senders
from gpr20_operator.robot.service_events import (
    AxisAction,
    AxisMoved,
    CheckStepTaken,
    ClockOffset,
    EndstopState,
    HeightTested,
    MachineExamined,
)
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.analyzer_test import AnalyzerTest, analyzer_test_of
from gpr20_survey.results.daily_check import Part
from gpr20_user_interface.high import conversions
from gpr20_user_interface.high.ros_events import RosEvents, in_background, no_answer

# At the lowest speed an axis of 800 mm takes 800 s to its endstop. The motion can be stopped
# meanwhile, and goes to its end whether this client waits or not.
MOVE_TIMEOUT_S = 1200.0
HEIGHT_TIMEOUT_S = 10.0
# Several requests to the VNA, of which each has its own limit in the main control.
ANALYZER_TIMEOUT_S = 300.0
ENDSTOP_AXES = (AxisId.X, AxisId.Y)


class ServiceToolsClient(RosEvents):
    """Asks the main control and the height sensor without waiting; implements `ServiceRequests`."""

    def __init__(self, listener: Callable[[Any], None], senders: Senders) -> None:
        super().__init__(listener, senders)
        self._move = ServiceClient("service_move", ServiceMove)
        self._height = ServiceClient("get_height", GetHeight)
        self._analyzer = ServiceClient("test_analyzer", TestAnalyzer)
        self._daily_check = ServiceClient("daily_check", DailyCheck)
        self._watched: List[rospy.Subscriber] = []
        self._wanted = False
        self._following = threading.Lock()

    def listen(self) -> None:
        """Subscribe to what is done for maintenance."""
        self._subscribe("service_status", ServiceStatus, conversions.service_activity, None)

    def close(self) -> None:
        """Call the listener no more."""
        self.set_watched(False)
        super().close()

    def set_watched(self, watched: bool) -> None:
        """Follow endstops and clocks, or no longer: each message costs time."""
        self._wanted = watched
        # A subscription waits for the master, which may be away.
        in_background(self._follow)

    def _follow(self) -> None:
        with self._following:
            if self._wanted == bool(self._watched):
                return
            for subscriber in self._watched:
                subscriber.unregister()
            self._watched = self._subscriptions() if self._wanted else []

    def _subscriptions(self) -> List[rospy.Subscriber]:
        endstops = [
            self._subscriber(
                f"{axis.value}_axis/endstop", Bool, partial(self._on_endstop, axis), 10
            )
            for axis in ENDSTOP_AXES
        ]
        return [*endstops, self._diagnostics_subscriber(self._on_health)]

    def move(self, axis: AxisId, action: AxisAction, distance: float) -> None:
        """Ask to home or to jog an axis [mm or deg], or to set its zero; the answer is an event."""

        def ask() -> AxisMoved:
            try:
                response = self._move.call(
                    MOVE_TIMEOUT_S, axis=axis.value, action=int(action), distance=distance
                )
            except ServiceUnavailableError as error:
                return AxisMoved(False, no_answer(error))
            return AxisMoved(response.success, message_from(response))

        in_background(lambda: self._emit(ask()))

    def measure_height(self) -> None:
        """Ask for one height; the answer is an event."""

        def ask() -> HeightTested:
            try:
                response = self._height.call(HEIGHT_TIMEOUT_S)
            except ServiceUnavailableError as error:
                no_answer = Message(
                    "the height sensor does not answer; check that it is running", details=error
                ).with_fault(faults.PART_SILENT)
                return HeightTested(math.nan, math.nan, math.nan, no_answer)
            return conversions.height_tested(response)

        in_background(lambda: self._emit(ask()))

    def test_analyzer(self) -> None:
        """Ask for a test of the VNA; the answer is an event."""

        def ask() -> AnalyzerTest:
            try:
                response = self._analyzer.call(ANALYZER_TIMEOUT_S)
            except ServiceUnavailableError as error:
                return AnalyzerTest("", failure=no_answer(error))
            return analyzer_test_of(response)

        in_background(lambda: self._emit(ask()))

    def check_daily(self, part: Part) -> None:
        """Ask to measure a part of the daily check; the answer is an event."""

        def ask() -> CheckStepTaken:
            try:
                response = self._daily_check.call(ANALYZER_TIMEOUT_S, step=list(Part).index(part))
            except ServiceUnavailableError as error:
                return CheckStepTaken(False, no_answer(error))
            return CheckStepTaken(response.success, message_from(response), response.good)

        in_background(lambda: self._emit(ask()))

    def examine(
        self, nodes: Mapping[str, NodeDescription], surveying: bool, thorough: bool
    ) -> None:
        """Ask what is known about this computer; the answer is an event."""

        def look() -> MachineExamined:
            machine = ThisMachine(socket.gethostname(), os.environ)
            request = machine.request(nodes, surveying, thorough=thorough)
            return MachineExamined(probe_machine(request))

        in_background(lambda: self._emit(look()))

    def _on_endstop(self, axis: AxisId, message: Bool) -> None:
        self._emit(EndstopState(axis, message.data))

    def _on_health(self, health: NodeHealth, message: DiagnosticArray) -> None:
        offset_s = (rospy.Time.now() - message.header.stamp).to_sec()
        self._emit(ClockOffset(health.name, offset_s))
