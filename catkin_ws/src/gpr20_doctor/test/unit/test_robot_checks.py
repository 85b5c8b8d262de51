"""Each fault that the nodes report has a finding with a remedy, the worst first."""

import threading
from collections import ChainMap
from dataclasses import replace

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common import faults as common_faults
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_doctor.low.masters import MasterState
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.findings import exit_status, findings
from gpr20_doctor.mid.machine import Machine, MachineReport
from gpr20_doctor.mid.node_health import (
    EXPECTED_NODES,
    STALE_S,
    HealthLevel,
    HealthTracker,
    NodeHealth,
)
from gpr20_doctor.mid.robot_facts import Evidence, RobotFacts, unheard
from gpr20_simulator.mid.analyzer.simulated_analyzer import StepTime
from gpr20_survey import faults as survey_faults
from gpr20_survey.faults import NOT_CALIBRATED
from gpr20_survey.results.answers import AnalyzerTest
from gpr20_survey.trace.sweep import CalibrationStatus

OK, WARN, ERROR, STALE = HealthLevel
VNA, HEIGHT, X_AXIS = "vna_acquisition", "height_sensor", "x_axis/axis_driver"
SAME = NodeSoftware("0.1.0", "abc", "robot")
NOTED = Message("not used").with_fault(
    Fault("vna.not_used", Message("Nothing to do."), Severity.NOTE)
)
FAILED = Message("it failed").with_fault(Fault("vna.failed", Message("Look at it.")))
UNHOMED = Message("lost").with_fault(survey_faults.NOT_HOMED).as_warning()
PAUSED = Message("paused").with_fault(survey_faults.NOT_HOMED)


def facts(**changes):
    """Return a robot without a fault, with changes."""
    nodes = tuple(NodeHealth(name, OK, verbatim("ok"), {}) for name in EXPECTED_NODES)
    software = dict.fromkeys(EXPECTED_NODES, SAME)
    tested = AnalyzerTest("", "Anritsu", "HIGH")
    known = {"master_alive": True, "control_alive": True, "configured": True, "simulated": False}
    known.update(nodes=nodes, software=software, analyzer=tested)
    return RobotFacts(**{**known, **changes})


def report(name, level=OK, message="", **values):
    """Return that robot with another report of one node."""
    message = message if isinstance(message, Message) else verbatim(message)
    own = NodeHealth(name, HealthLevel(level), message, values)
    return facts(nodes=tuple(own if one.name == name else one for one in facts().nodes))


def stale(name):
    return report(name, STALE)


def test_a_robot_without_a_fault_is_good():
    found = findings(facts(), MachineReport(software=SAME))
    assert {one.level for one in found} == {Level.OK}
    assert len(found) > len(EXPECTED_NODES)
    assert all(one.remedy is None for one in found)
    assert exit_status(found) == 0


OTHER = {
    **dict.fromkeys(EXPECTED_NODES, SAME),
    VNA: NodeSoftware("0.1.0", "abc", "pc"),
    HEIGHT: NodeSoftware("0.1.0", "def", "pi"),
}
HEARD = {name: SAME for name in EXPECTED_NODES if name != HEIGHT}
MEASURES = replace(report(VNA, calibration="HIGH"), surveying=True)
CASES = [
    (facts(control_alive=False), Level.FAULT, "main control", common_faults.PART_SILENT),
    (stale(HEIGHT), Level.FAULT, "does not report", common_faults.PART_SILENT),
    (replace(stale(HEIGHT), listening_s=1.0), Level.UNKNOWN, "does not report", None),
    (facts(configuration_problem=FAILED), Level.FAULT, "No survey can", None),
    (facts(configured=False), Level.UNKNOWN, "configuration is not known", None),
    (facts(simulated=True, analyzer=None), Level.UNKNOWN, "has not been read", None),
    (facts(analyzer=None), Level.UNKNOWN, "VNA was not tested", None),
    (replace(MEASURES, analyzer=None), Level.NOTE, "not tested beside a survey", None),
    (report(HEIGHT, ERROR, "out"), Level.FAULT, "Height sensor: out", common_faults.INTERNAL),
    (report(X_AXIS, WARN, UNHOMED), Level.NOTE, "X axis: lost", None),
    (report(X_AXIS, WARN, PAUSED), Level.WARNING, "X axis: paused", None),
    (report(VNA, WARN, NOTED), Level.NOTE, "not used", None),
    (report(VNA, WARN, FAILED), Level.WARNING, "it failed", None),
    (facts(analyzer=AnalyzerTest("", failure=FAILED)), Level.FAULT, "Test of the VNA", None),
    (facts(analyzer=AnalyzerTest("", "", "new word")), Level.UNKNOWN, "not been read", None),
    (facts(software=OTHER), Level.WARNING, "(def) on pi", common_faults.VERSIONS_DIFFER),
    (facts(software=HEARD), Level.UNKNOWN, "the software of Height sensor", None),
    (facts(software={}), Level.UNKNOWN, "Not known: the software", None),
]


@each_case("robot, level, words, expected", CASES)
def test_each_fault_is_found(robot, level, words, expected):
    found = findings(robot, None)
    (fault,) = [one for one in found if words in str(one.text)]
    assert fault.level is level
    assert found[0].level is level
    assert fault.remedy is not None
    assert bool(fault.text.fault_code) or level < Level.WARNING
    assert expected is None or fault.text.fault_code == expected.code
    assert exit_status(found) == {Level.FAULT: 2, Level.NOTE: 0}.get(level, 1)


@each_case("status", CalibrationStatus)
def test_a_calibration_has_level_code_and_remedy_of_its_fault(status):
    found = findings(facts(analyzer=AnalyzerTest("", "", status.name)), None)
    (one,) = [one for one in found if one.check == "calibration"]
    fault = one.text.cause
    assert (fault is None) == (status is CalibrationStatus.HIGH)
    assert (one.level is Level.FAULT) == (status is CalibrationStatus.NONE)
    assert fault in (None, NOT_CALIBRATED, NOT_CALIBRATED.as_warning())
    assert bool(one.remedy) == (fault is not None)


def test_a_calibration_that_was_read_before_is_not_called_good():
    heard = replace(report(VNA, calibration="HIGH"), analyzer=None)
    levels = {one.check: one.level for one in findings(heard, None)}
    assert (levels["vna"], levels["calibration"]) == (Level.UNKNOWN, Level.NOTE)


@each_case("host, code", [("robot", "robot.other_launch"), ("laptop", "robot.versions_differ")])
def test_another_software_than_the_one_installed_here_is_found(host, code):
    updated = replace(SAME, revision="new", host=host)
    found = findings(facts(), MachineReport(software=updated))[0]
    assert (found.level, found.text.fault_code) == (Level.WARNING, code)
    assert "0.1.0 (abc)" in str(found.text) and "0.1.0 (new)" in str(found.text)


NOT_THERE = unheard("http://x:1", Evidence())
RESTART = "sudo systemctl restart "


TWO = {"GPR20_ROBOT": "10.20.0.1", "GPR20_SERVER": "10.20.0.2"}


@each_case(
    "here, command",
    [
        (Machine(), "roslaunch gpr20 survey.launch"),
        (Machine(TWO), "roslaunch gpr20 robot.launch, server.launch"),
        (Machine(service="gpr20"), f"Run: {RESTART}gpr20."),
        (Machine(TWO, service="gpr20"), f"on both computers: {RESTART}gpr20"),
        (Machine({"GPR20_ROLE": ""}, service="gpr20"), "GPR20_ROLE into /etc/gpr20/robot.conf"),
    ],
)
def test_an_advice_names_what_is_installed_here(here, command):
    assert command in str(findings(NOT_THERE, MachineReport(machine=here))[0].remedy)


ROBOTS = st.one_of(
    st.lists(st.sampled_from([one[0] for one in CASES]), min_size=1).map(
        lambda some: RobotFacts(**dict(ChainMap(*map(vars, some))))
    ),
    st.sampled_from(list(MasterState)).map(lambda one: unheard("http://x:1", Evidence(one))),
)
SPACE = Finding.of("data_disk", Message("space"))


@given(ROBOTS, st.sampled_from([None, MachineReport(), MachineReport((SPACE,), SAME)]))
def test_whatever_is_known_every_finding_has_a_sentence_and_a_remedy(robot, machine):
    found = findings(robot, machine)
    assert [one.level for one in found] == sorted((one.level for one in found), reverse=True)
    for one in found:
        assert one.check and str(one.text)
        assert one.level < Level.UNKNOWN or str(one.remedy)
        assert one.level < Level.WARNING or one.text.fault_code
    if not exit_status(found):
        assert robot.master_alive and robot.control_alive
        assert robot.configured and robot.configuration_problem is None


def test_nodes_are_missed_if_they_are_expected_or_have_reported():
    clock = StepTime()
    tracker = HealthTracker(clock)

    def note(name, offset_s=0.1):
        return tracker.note(NodeHealth(name, OK, verbatim("ok"), {}, offset_s))

    for name in (*EXPECTED_NODES[1:], "web", "sensors/gnss"):
        assert note(name)
    assert not note("foreign")
    for offset_s in (3.0, -0.05, 1.0):
        note("height_sensor", offset_s)
    assert tracker.silent == [EXPECTED_NODES[0]]
    found = {one.name: one for one in tracker.report().nodes}
    assert set(found) == {*EXPECTED_NODES, "web", "sensors/gnss"} and found["web"].level is OK
    # Of the offsets the smallest has the least delay in it.
    assert found["height_sensor"].clock_offset_s == pytest.approx(-0.05)
    clock.wait_s(threading.Event(), STALE_S + 0.1)
    note(EXPECTED_NODES[0])
    silent = [one.name for one in tracker.report().nodes if one.level is STALE]
    assert set(silent) == {*found} - {EXPECTED_NODES[0]}
