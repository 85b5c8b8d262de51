"""What the robot's nodes tell, and what they do when they are asked."""

from __future__ import annotations

from typing import Any, Dict, Iterable

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Range
from std_msgs.msg import Bool

from gpr20_common.high.answers import message_from
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_doctor.high.node_reports import (
    analyzer_test_of,
    axis_report,
    descriptions,
    height_m,
    node_healths,
)
from gpr20_doctor.low.masters import NodeState, launched_nodes, node_states
from gpr20_doctor.mid.robot_facts import Endstop, Listener
from gpr20_msgs.msg import ControlStatus, CurrentCoordinate, RobotConfiguration
from gpr20_msgs.srv import GetHeight, TestAnalyzer
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import VNA_SILENT
from gpr20_survey.plan.survey_state import RUNNING, SurveyState
from gpr20_survey.results.analyzer_test import AnalyzerTest

NODE = "doctor"


class Graph:
    """The robot of one namespace; it is only listened to, unless a test is asked for."""

    def __init__(self, namespace: str, master: str) -> None:
        """Join the graph of a master that answers, and listen.

        Args:
            namespace: Of the robot, with or without slashes.
            master: Address of the master.
        """
        self.namespace = f"/{namespace.strip('/')}"
        self._master = master
        self._prefix = self.namespace.rstrip("/")
        rospy.init_node(
            NODE, anonymous=True, disable_rostime=True, disable_rosout=True, disable_signals=True
        )
        full_names = launched_nodes(master)
        prefix = f"{self._prefix}/"
        launched = [one[len(prefix) :] for one in full_names if one.startswith(prefix)]
        self.listener = Listener(Clock(), master, launched)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics)
        self._subscribe("robot_configuration", RobotConfiguration, self._on_configuration)
        self._subscribe("control_status", ControlStatus, self._on_status)
        self._subscribe("measured_height", Range, self._on_height)
        for axis in AxisId:
            name = f"{axis.value}_axis"
            self._subscribe(f"{name}/current_coord", CurrentCoordinate, self._on_axis, axis)
            if axis is not AxisId.Z:
                self._subscribe(f"{name}/endstop", Bool, self._on_endstop, axis)
        self._height = ServiceClient(f"{self._prefix}/get_height", GetHeight)
        self._analyzer = ServiceClient(f"{self._prefix}/test_analyzer", TestAnalyzer)

    def measure_height(self, limit_s: float) -> None:
        """Have a height measured; what comes of it, the height sensor reports itself."""
        try:
            self._height.call(limit_s)
        except ServiceUnavailableError:
            return  # a sensor that does not report is a finding of its own

    def test_analyzer(self, limit_s: float) -> AnalyzerTest:
        """Have the VNA tested; the main control refuses it beside a survey.

        Args:
            limit_s: For the answer [s]. A test that takes longer ends by itself.
        """
        try:
            answer = self._analyzer.call(limit_s)
        except ServiceUnavailableError as error:
            late = Message(
                "the VNA gave no result within {limit_s:.0f} s; check that it is switched on and "
                "connected",
                limit_s=limit_s,
                details=error,
            ).with_fault(VNA_SILENT)
            return AnalyzerTest("", failure=late)
        return analyzer_test_of(answer)

    def node_states(self, names: Iterable[str]) -> Dict[str, NodeState]:
        """Ask nodes whether they are there.

        Args:
            names: Without the namespace.
        """
        own = list(names)
        states = node_states(self._master, [f"{self._prefix}/{name}" for name in own])
        return dict(zip(own, states.values()))

    def leave(self) -> None:
        """Leave the graph."""
        rospy.signal_shutdown("the doctor has finished")

    def _subscribe(self, name: str, kind: Any, received: Any, *extra: Any) -> None:
        rospy.Subscriber(f"{self._prefix}/{name}", kind, received, *extra)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for health in node_healths(message, self._prefix):
            self.listener.note_node(health)

    def _on_configuration(self, message: RobotConfiguration) -> None:
        problem = None if message.known else message_from(message)
        nodes = descriptions(message)
        self.listener.note_configuration(problem, message.simulated, nodes)

    def _on_status(self, message: ControlStatus) -> None:
        surveying = SurveyState(message.code) in RUNNING
        self.listener.note(control_alive=True, surveying=surveying)

    def _on_endstop(self, message: Bool, axis: AxisId) -> None:
        self.listener.note_endstop(Endstop(axis, message.data))

    def _on_axis(self, message: CurrentCoordinate, axis: AxisId) -> None:
        self.listener.note_axis(axis_report(axis, message))

    def _on_height(self, message: Range) -> None:
        self.listener.note(height_m=height_m(message))
