"""Reports of nodes from the graph, where anybody can publish."""

import pytest

pytest.importorskip("diagnostic_msgs.msg")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from gpr20_doctor.high.node_reports import node_healths
from gpr20_doctor.mid.node_health import HealthLevel


def test_a_level_that_nobody_knows_is_an_error_of_that_part_alone():
    levels = (0, 7, 3, b"\x01", 255)
    status = [DiagnosticStatus(name=f"/part_{level}", level=level) for level in levels]
    found = node_healths(DiagnosticArray(status=status), "/")
    assert [one.level for one in found] == [
        HealthLevel.OK,
        HealthLevel.ERROR,
        HealthLevel.STALE,
        HealthLevel.WARN,
        HealthLevel.ERROR,
    ]
