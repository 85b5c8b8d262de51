"""Each fault that can be judged from outside has a finding with a remedy, the worst first."""

from dataclasses import replace

import pytest

from gpr20_common.message import Message, verbatim
from gpr20_survey.plan.survey_parameters import RobotTravel, Travel
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.doctor import Facts, findings
from gpr20_user_interface.mid.events import ControlState, HealthLevel, NodeHealth
from gpr20_user_interface.mid.robot_health import EXPECTED_NODES, HealthReport
from gpr20_user_interface.mid.survey_model import Snapshot

TRAVEL = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))
OK, WARN, ERROR, STALE = HealthLevel
VALUES = {
    "vna_acquisition": {"calibration": "HIGH"},
    "vna_processing": {"free disk [MB]": "20000"},
    "x_axis/axis_driver": {"homed": "True", "endstop": "open", "coordinate [mm]": "200.0"},
    "y_axis/axis_driver": {"homed": "True", "endstop": "pressed", "coordinate [mm]": "0.0"},
}


def facts(problem=None, offsets_s=None, nodes=None, simulated=False, **snapshot):
    reports = {name: NodeHealth(name, OK, verbatim("ok"), {}) for name in EXPECTED_NODES}
    for name, values in VALUES.items():
        reports[name] = NodeHealth(name, OK, verbatim("ok"), values)
    for name, (level, message, values) in (nodes or {}).items():
        reports[name] = NodeHealth(name, level, message, {**VALUES.get(name, {}), **values})
    known = {
        "control_alive": True,
        "control_silent_s": 0.1,
        "state": ControlState(SurveyState.FINISHED, verbatim(""), "", simulated),
        "progress": None,
        "current": None,
        "target": None,
        "height_m": None,
        "pending": frozenset(),
        "travel": TRAVEL,
        "health": HealthReport(tuple(reports.values())),
        **snapshot,
    }
    return Facts(Snapshot(**known), problem, offsets_s or {})


def test_a_robot_without_a_fault_is_good():
    found = findings(facts(offsets_s={"height_sensor": 0.01}))
    assert {one.level for one in found} == {OK}
    assert len(found) > len(EXPECTED_NODES)
    assert all(one.remedy is None for one in found)


def test_a_window_that_has_just_opened_has_not_heard_every_node():
    silent = facts(nodes={"height_sensor": (STALE, verbatim(""), {})})
    assert findings(replace(silent, listening_s=1.0))[0].level is WARN
    assert findings(replace(silent, listening_s=6.0))[0].level is ERROR


CASES = [
    ({"master_alive": False}, ERROR, "ROS master"),
    ({"control_alive": False}, ERROR, "no contact with the main control"),
    ({"problem": Message("the height sensor is mixed; end every launch")}, ERROR, "No survey can"),
    ({"travel": None}, WARN, "configuration is not known"),
    ({"simulated": True}, WARN, "simulated"),
    ({"nodes": {"height_sensor": (STALE, verbatim(""), {})}}, ERROR, "does not report"),
    ({"nodes": {"height_sensor": (ERROR, verbatim("out"), {})}}, ERROR, "Height sensor: out"),
    ({"nodes": {"x_axis/axis_driver": (WARN, Message("not homed"), {})}}, WARN, "not homed"),
    ({"nodes": {"vna_acquisition": (WARN, Message("not connected"), {})}}, WARN, "not connected"),
    ({"nodes": {"vna_acquisition": (OK, verbatim(""), {"calibration": "NONE"})}}, ERROR, "no cal"),
    ({"nodes": {"vna_acquisition": (OK, verbatim(""), {"calibration": "LOW"})}}, WARN, "10 °C"),
    (
        {"nodes": {"vna_acquisition": (OK, verbatim(""), {"calibration": ""})}},
        WARN,
        "not been read",
    ),
    ({"nodes": {"vna_processing": (OK, verbatim(""), {"free disk [MB]": "100"})}}, ERROR, "0.1 GB"),
    ({"nodes": {"vna_processing": (OK, verbatim(""), {"free disk [MB]": "4000"})}}, WARN, "4.0 GB"),
    ({"nodes": {"vna_processing": (OK, verbatim(""), {"free disk [MB]": ""})}}, WARN, "not known"),
    (
        {"nodes": {"x_axis/axis_driver": (OK, verbatim(""), {"endstop": "pressed"})}},
        ERROR,
        "endstop of the X axis is closed at 200 mm",
    ),
    ({"offsets_s": {"height_sensor": 0.1, "vna_acquisition": -75.0}}, WARN, "VNA driver differs"),
]


@pytest.mark.parametrize(("changes", "level", "words"), CASES)
def test_each_fault_is_found(changes, level, words):
    found = findings(facts(**changes))
    (fault,) = [one for one in found if words in str(one.text)]
    assert fault.level is level
    assert found[0].level is level
    # An own message of a node, or of the configuration, says what to do.
    own = level is ERROR and ("out" in words or "survey" in words)
    assert own or fault.remedy is not None
