"""What the robot's nodes say on the graph, as records, and what they do when they are asked."""

from __future__ import annotations

import os
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any, Dict, List, Mapping

import rospy
from diagnostic_msgs.msg import DiagnosticArray

from gpr20_common.high.answers import message_from, record_of
from gpr20_common.high.diagnostics import FAULT
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.low.clock import Clock
from gpr20_common.message import received_message
from gpr20_doctor.low.masters import MasterState
from gpr20_doctor.mid.node_health import HealthLevel, HealthTracker, NodeHealth
from gpr20_doctor.mid.robot_facts import Evidence, RobotFacts, unheard
from gpr20_msgs.msg import ControlStatus, RobotConfiguration
from gpr20_msgs.srv import TestAnalyzer
from gpr20_survey.faults import VNA_SILENT
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.plan.survey_state import RUNNING, SurveyState
from gpr20_survey.results.answers import AnalyzerTest

# Clocks are compared for so long at least [s].
WATCH_S = 1.5
POLL_S = 0.05
# rospy would end a program that cannot write its log: the doctor of a full or read-only disk.
NO_LOG = Path(__file__).with_name("no_log.yaml")


def node_healths(message: DiagnosticArray, namespace: str) -> List[NodeHealth]:
    """Convert the reports on `/diagnostics` of the nodes of one namespace.

    Args:
        message: Of any nodes; robots that share a master share the topic.
        namespace: The robot's, with slashes at both ends or alone.
    """
    prefix = namespace.strip("/")
    offset_s = 1e-6 * Clock().time_of_day_us() - message.header.stamp.to_sec()
    found = []
    for status in message.status:
        # diagnostic_updater writes "node: task", with the node's full name.
        name = status.name.split(":")[0].strip("/")
        if prefix and not name.startswith(f"{prefix}/"):
            continue
        values = {pair.key: pair.value for pair in status.values}
        level = _level(status.level)
        own_name = name[len(prefix) :].strip("/")
        text = received_message(status.message, values.pop(FAULT, ""))
        found.append(NodeHealth(own_name, level, text, values, offset_s))
    return found


def descriptions(message: RobotConfiguration) -> Dict[str, NodeDescription]:
    """Return what the nodes say they are; a node that says nonsense is left out."""
    found = {}
    for one in message.nodes:
        try:
            found[one.node] = NodeDescription.from_fields(one)
        except ValueError:
            continue  # the main control reports it as a problem of the configuration
    return found


def analyzer_test_of(answer: Any) -> AnalyzerTest:
    """Convert an answer of `test_analyzer`."""
    failure = None if answer.success else message_from(answer)
    return record_of(AnalyzerTest, answer, failure=failure)


def _level(level: Any) -> HealthLevel:
    # The type byte is an int in ROS 1's Python messages, and bytes in some builds of them.
    number = level[0] if isinstance(level, bytes) else int(level)
    # Anybody can publish here: what no version knows counts as bad.
    return HealthLevel(number) if number in set(HealthLevel) else HealthLevel.ERROR


class Graph:
    """The robot of one namespace; it is only listened to, unless a test is asked for."""

    def __init__(self, namespace: str, master: str, clock: Clock) -> None:
        """Join the graph of a master that answers, and listen.

        Args:
            namespace: Of the robot, with or without slashes.
            master: Address of the master.
            clock: Measures how long was listened.
        """
        self.namespace = f"/{namespace.strip('/')}"
        self.descriptions: Mapping[str, NodeDescription] = {}
        """What the nodes say they are."""
        self._master, self._clock, self._begun_s = master, clock, clock.now_s()
        self._prefix = self.namespace.rstrip("/") + "/"
        os.environ["ROS_PYTHON_LOG_CONFIG_FILE"] = str(NO_LOG)
        quiet = {"disable_rostime": True, "disable_rosout": True, "disable_signals": True}
        rospy.init_node("doctor", anonymous=True, **quiet)
        self._health = HealthTracker(clock)
        # Messages come in threads of their own.
        self._lock = threading.Lock()
        self._known = unheard(master, Evidence(MasterState.ANSWERS, self.namespace))
        self._analyzer = ServiceClient(f"{self._prefix}test_analyzer", TestAnalyzer)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics)
        rospy.Subscriber(f"{self._prefix}control_status", ControlStatus, self._on_status)
        rospy.Subscriber(
            f"{self._prefix}robot_configuration", RobotConfiguration, self._on_configuration
        )

    def wait(self, limit_s: float) -> None:
        """Return when every node has reported and clocks were compared, or after a limit [s]."""
        never = threading.Event()
        while self._clock.now_s() - self._begun_s < limit_s:
            known = self._known
            heard = known.configured and known.control_alive and not self.silent()
            if heard and self._clock.now_s() - self._begun_s >= WATCH_S:
                return
            self._clock.wait_s(never, POLL_S)

    def facts(self) -> RobotFacts:
        """Return what is known now."""
        with self._lock:
            return replace(self._known, nodes=self._health.report().nodes)

    def silent(self) -> List[str]:
        """Return the names of the nodes that should have reported and have not."""
        with self._lock:
            return self._health.silent

    def test_analyzer(self, limit_s: float) -> AnalyzerTest:
        """Have the VNA tested; the main control refuses it beside a survey.

        Args:
            limit_s: For the answer [s]. A test that takes longer ends by itself.
        """
        try:
            return analyzer_test_of(self._analyzer.call(limit_s))
        except ServiceUnavailableError as error:
            return AnalyzerTest("", failure=error.message.reporting_only(VNA_SILENT))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        with self._lock:
            for health in node_healths(message, self.namespace):
                self._health.note(health)

    def _on_configuration(self, message: RobotConfiguration) -> None:
        problem = None if message.known else message_from(message)
        self.descriptions = descriptions(message)
        self._note(
            configured=problem is None,
            configuration_problem=problem,
            simulated=message.simulated,
            software={name: one.software for name, one in self.descriptions.items()},
        )

    def _on_status(self, message: ControlStatus) -> None:
        self._note(control_alive=True, surveying=SurveyState(message.code) in RUNNING)

    def _note(self, **changes: Any) -> None:
        with self._lock:
            self._known = replace(self._known, **changes)
