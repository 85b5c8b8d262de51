"""What nodes report on the graph, as the records of the lower levels."""

from __future__ import annotations

import math
from typing import Any, Dict, List

from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import Range

from gpr20_common.high.answers import message_from, record_of
from gpr20_common.high.diagnostics import FAULT
from gpr20_common.low.clock import Clock
from gpr20_common.message import received_message
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_msgs.msg import CurrentCoordinate, RobotConfiguration
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import NodeDescription
from gpr20_survey.results.answers import AnalyzerTest


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


def axis_report(axis: AxisId, message: CurrentCoordinate) -> AxisReport:
    """Convert `current_coord` of an axis."""
    return AxisReport(axis, message.coordinate, message.homed, message.moving, message.owner)


def height_m(message: Range) -> float:
    """Convert `measured_height` [m]; a value outside the sensor's range is none (REP 117)."""
    within = message.min_range <= message.range <= message.max_range
    return float(message.range) if within else math.nan


def analyzer_test_of(answer: Any) -> AnalyzerTest:
    """Convert an answer of `test_analyzer`."""
    failure = None if answer.success else message_from(answer)
    return record_of(AnalyzerTest, answer, failure=failure)


def _level(level: Any) -> HealthLevel:
    # The type byte is an int in ROS 1's Python messages, and bytes in some builds of them.
    number = level[0] if isinstance(level, bytes) else int(level)
    # Anybody can publish here: what no version knows counts as bad.
    return HealthLevel(number) if number in set(HealthLevel) else HealthLevel.ERROR
