"""Each fault that the nodes report has a finding with a remedy, the worst first."""

import math
from collections import ChainMap
from dataclasses import replace

from case_kit import each_case
from hypothesis import strategies as st

from gpr20_common import faults as common_faults
from gpr20_common.faults import NOT_RUNNING, OTHER_LAUNCH
from gpr20_common.message import Fault, Message, Severity, verbatim
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_doctor.low.masters import MasterState, NodeState
from gpr20_doctor.mid.finding import Level
from gpr20_doctor.mid.findings import BAD, DOUBTFUL, GOOD, exit_status, findings
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth
from gpr20_doctor.mid.place import Place, advised
from gpr20_doctor.mid.robot_facts import AxisReport, Endstop, Evidence, RobotFacts
from gpr20_survey import faults as survey_faults
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import CLOCK_WRONG, ENDSTOP, NO_GROUND, NOT_CALIBRATED, WRONG_VNA
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.trace.calibration import CalibrationStatus

OK, WARN, ERROR, STALE = HealthLevel
VNA, STORAGE, HEIGHT, X_AXIS = (
    "vna_acquisition",
    "vna_processing",
    "height_sensor",
    "x_axis/axis_driver",
)
VALUES = {
    VNA: {"calibration": "HIGH"},
    STORAGE: {"free disk [MB]": "20000"},
}
AXES = {
    AxisId.X: AxisReport(AxisId.X, 200.0, True, False),
    AxisId.Y: AxisReport(AxisId.Y, 0.0, True, False),
    AxisId.Z: AxisReport(AxisId.Z, 0.0, True, False),
}
ENDSTOPS = {AxisId.X: Endstop(AxisId.X, False), AxisId.Y: Endstop(AxisId.Y, True)}
CLOSED = {**ENDSTOPS, AxisId.X: Endstop(AxisId.X, True)}
NOT_HOMED = {**AXES, AxisId.X: AxisReport(AxisId.X, 0.0, False, False)}
NOTED = Message("not used").with_fault(
    Fault("vna.not_used", Message("Nothing to do."), Severity.NOTE)
)
FAILED = Message("it failed").with_fault(Fault("vna.failed", Message("Look at it.")))
UNHOMED = Message("lost").with_fault(survey_faults.NOT_HOMED).as_warning()
PAUSED = Message("paused").with_fault(survey_faults.NOT_HOMED)
SAME = NodeSoftware("0.1.0", "abc", "robot")


def facts(nodes=None, offsets_s=None, **changes):
    reports = {
        name: NodeHealth(name, OK, verbatim("ok"), VALUES.get(name, {})) for name in EXPECTED_NODES
    }
    for name, (level, message, values) in (nodes or {}).items():
        reports[name] = NodeHealth(name, level, message, {**VALUES.get(name, {}), **values})
    for name, offset_s in (offsets_s or {}).items():
        reports[name] = replace(reports[name], clock_offset_s=offset_s)
    known = {
        "master_alive": True,
        "control_alive": True,
        "configured": True,
        "simulated": False,
        "surveying": False,
        "nodes": tuple(reports.values()),
        "software": {name: SAME for name in EXPECTED_NODES},
        "axes": AXES,
        "endstops": ENDSTOPS,
        "height_m": 0.2,
        **changes,
    }
    return RobotFacts(**known)


def report(name, level=OK, message="", **values):
    message = message if isinstance(message, Message) else verbatim(message)
    return {"nodes": {name: (level, message, values.get("values", {}))}}


def test_a_robot_without_a_fault_is_good():
    # An endstop that changes while it is watched works.
    seen = {**ENDSTOPS, AxisId.X: Endstop(AxisId.X, False, 2)}
    found = findings(facts(offsets_s={HEIGHT: 0.01}, endstops=seen), None)
    assert {one.level for one in found} == {Level.OK}
    assert len(found) > len(EXPECTED_NODES)
    assert all(one.remedy is None for one in found)
    assert exit_status(found) == GOOD
    texts = [str(one.text) for one in found]
    assert "The endstop of the X axis works: its state has changed." in texts
    assert "The endstop of the Y axis is closed, at its zero." in texts


def test_who_has_just_begun_to_listen_has_not_heard_every_node():
    silent = facts(**report(HEIGHT, STALE))
    assert findings(replace(silent, listening_s=1.0), None)[0].level is Level.UNKNOWN
    assert findings(replace(silent, listening_s=6.0), None)[0].level is Level.FAULT


OTHER = {VNA: NodeSoftware("0.1.0", "abc", "pc"), HEIGHT: NodeSoftware("0.1.0", "def", "pi")}
LOST = AnalyzerTest("", failure=FAILED)
FOREIGN = report(VNA, values={"identity": "A,SIMULATED,1"})
NOWHERE = {"endstops": CLOSED, "axes": NOT_HOMED}
LATE = {"offsets_s": {HEIGHT: 0.1, VNA: -75.0}}
LEFT = {**dict.fromkeys(EXPECTED_NODES, SAME), VNA: NodeSoftware("0.1.0", "def", "robot")}
HEARD = {name: SAME for name in EXPECTED_NODES if name != HEIGHT}


def free_mb(text):
    return report(STORAGE, values={"free disk [MB]": text})


NO_CONTACT, FULL = common_faults.PART_SILENT, common_faults.DISK_FULL
DIFFERS = common_faults.VERSIONS_DIFFER
WITH_FAULT = [
    ({"master_alive": False}, Level.FAULT, "ROS master", NOT_RUNNING, ""),
    ({"control_alive": False}, Level.FAULT, "no contact with the main control", NO_CONTACT, ""),
    (report(HEIGHT, STALE), Level.FAULT, "does not report", NO_CONTACT, ""),
    ({"height_m": 1.9}, Level.WARNING, "antennas is 1.9", NO_GROUND, "offset in height.yaml"),
    (FOREIGN, Level.FAULT, "not both simulated", WRONG_VNA, ""),
    (free_mb("100"), Level.FAULT, "0.1 GB", FULL, ""),
    (free_mb("4000"), Level.WARNING, "4.0 GB", FULL, ""),
    ({"endstops": CLOSED}, Level.FAULT, "X axis is closed at 200 mm", ENDSTOP, ""),
    (NOWHERE, Level.WARNING, "closed; it is not homed", ENDSTOP, "whether the carriage presses"),
    (LATE, Level.WARNING, "VNA driver differs", CLOCK_WRONG, "clocks of both computers"),
    ({"software": OTHER}, Level.WARNING, "(abc) on pc; 0.1.0 (def) on pi", DIFFERS, ""),
    ({"software": LEFT}, Level.WARNING, "(def) on robot", OTHER_LAUNCH, "from one installation"),
]
OTHERS = [
    ({"configuration_problem": Message("parts are mixed")}, Level.FAULT, "No survey can"),
    ({"configured": False}, Level.UNKNOWN, "configuration is not known"),
    ({"simulated": True}, Level.NOTE, "is simulated"),
    (report(HEIGHT, ERROR, "out"), Level.FAULT, "Height sensor: out"),
    (report(X_AXIS, WARN, UNHOMED), Level.NOTE, "X axis: lost"),
    (report(X_AXIS, WARN, PAUSED), Level.WARNING, "X axis: paused"),
    ({**report(X_AXIS, WARN, FAILED), "axes": NOT_HOMED}, Level.WARNING, "X axis: it failed"),
    (report(VNA, WARN, NOTED), Level.NOTE, "not used"),
    (report(VNA, WARN, FAILED), Level.WARNING, "it failed"),
    ({"height_m": math.nan}, Level.UNKNOWN, "has not been measured"),
    (report(VNA, values={"calibration": "new word"}), Level.UNKNOWN, "new word"),
    (report(VNA, values={"calibration": ""}), Level.UNKNOWN, "not been read"),
    ({"analyzer": LOST}, Level.FAULT, "Test of the VNA: it failed"),
    (free_mb(""), Level.UNKNOWN, "disk space is not known"),
    ({"software": {VNA: NodeSoftware()}}, Level.UNKNOWN, "VNA driver does not say"),
    ({"software": HEARD}, Level.UNKNOWN, "the software of Height sensor"),
    ({"analyzer": AnalyzerTest("", "Anritsu", "LOW")}, Level.WARNING, "Calibration of the VNA"),
    ({"software": {}}, Level.UNKNOWN, "software of the parts is not known"),
]


ALL = [*WITH_FAULT, *((*one, None, "") for one in OTHERS)]


@each_case("changes, level, words, expected, advice", ALL)
def test_each_fault_is_found(changes, level, words, expected, advice):
    found = findings(facts(**changes), None)
    (fault,) = [one for one in found if words in str(one.text)]
    assert fault.level is level
    assert found[0].level is level
    assert fault.remedy is not None and advice in str(fault.remedy)
    if level in (Level.FAULT, Level.WARNING):
        assert fault.text.fault_code
        assert (fault.remedy == fault.text.remedy) == (not advice)
    if expected is not None:
        assert fault.text.fault_code == expected.code
    assert exit_status(found) == {Level.FAULT: BAD, Level.NOTE: GOOD}.get(level, DOUBTFUL)


@each_case("status", CalibrationStatus)
def test_a_calibration_has_level_code_and_remedy_of_its_fault(status):
    found = findings(facts(**report(VNA, values={"calibration": status.name})), None)
    (one,) = [one for one in found if one.check == "calibration"]
    assert one.text.values["state"] == status.meaning
    fault = one.text.cause
    assert (fault is None) == (status is CalibrationStatus.HIGH)
    assert (one.level is Level.FAULT) == (status is CalibrationStatus.NONE)
    assert fault in (None, NOT_CALIBRATED, NOT_CALIBRATED.as_warning())
    if status is CalibrationStatus.NOT_REPORTED:
        assert str(one.remedy) == "Make sure that the VNA is calibrated."
    else:
        assert one.remedy == (None if fault is None else fault.remedy)


def test_a_height_that_is_missing_has_a_remedy_and_a_fault_of_the_sensor_is_said_once():
    found = findings(facts(**report(X_AXIS, WARN, UNHOMED), height_m=math.nan), None)
    remedies = {one.check: one.remedy for one in found}
    assert remedies[X_AXIS] == survey_faults.NOT_HOMED.remedy
    assert remedies["height"] == survey_faults.HEIGHT_NOT_MEASURED.remedy
    broken = facts(**report(HEIGHT, ERROR, "broken"), height_m=math.nan)
    assert "height" not in {one.check for one in findings(broken, None)}


HERE = Place(service="gpr20-robot", two_computers=True)
GONE, HANGS = NodeState.GONE, NodeState.HANGS
MISSING, RESTART = "robot.not_running", "sudo systemctl restart "


def unheard(state, **found):
    nothing = replace(facts(master_alive=False, control_alive=False), nodes=())
    return replace(nothing, evidence=Evidence(state, "/a", **found))


M, ELSEWHERE = MasterState, {"elsewhere": (("http://x:1", "/a"),)}
SILENT = [
    (unheard(M.NOT_THERE), "robot.not_running", "On the other computer run: sudo sys"),
    (unheard(M.HANGS), "robot.master_lost", "robot again. On the other computer run"),
    (unheard(M.UNREACHABLE), "robot.not_running", "the cable between them"),
    (unheard(M.NOT_THERE, local_nodes=3), "robot.master_lost", "the motors' power"),
    (
        unheard(M.ANSWERS, robots=("/b", "/c")),
        "robot.not_running",
        "Run: gpr20 doctor --ns b.",
    ),
    (unheard(M.NOT_THERE, **ELSEWHERE), "robot.not_running", "ROS_MASTER_URI=http://x:1."),
    (unheard(M.HANGS, **ELSEWHERE), "robot.master_lost", "Switch off the motors' power."),
    (unheard(M.ANSWERS), "robot.not_running", "sudo systemctl restart gpr20-robot"),
]


@each_case("robot, code, advice", SILENT)
def test_a_robot_that_is_not_heard_has_one_fault_with_its_reason(robot, code, advice):
    fault, unknown = findings(robot, None)
    assert (fault.level, fault.text.fault_code) == (Level.FAULT, code)
    assert unknown.level is Level.UNKNOWN
    assert advice in str(advised(fault, HERE).remedy)


@each_case(
    "silent, code, words, advice",
    [
        ({HEIGHT: HANGS}, "robot.part_lost", "Height sensor hangs", "Wait one minute"),
        ({HEIGHT: GONE, X_AXIS: GONE}, MISSING, "X axis; Height sensor", f"{RESTART}gpr20-robot."),
        ({VNA: NodeState.UNREACHED}, "network.address", "they listen: VNA", "Check the link"),
        ({VNA: GONE}, MISSING, "Not running: VNA driver", f"other computer run: {RESTART}gpr20-se"),
        ({HEIGHT: NodeState.ANSWERS}, "robot.part_silent", "does not report", "Wait one minute"),
    ],
)
def test_a_silent_part_is_judged_by_what_it_answers(silent, code, words, advice):
    nodes = {name: (STALE, verbatim(""), {}) for name in silent}
    robot = facts(nodes, evidence=Evidence(MasterState.ANSWERS, nodes=silent))
    (fault,) = [one for one in findings(robot, None) if one.level is Level.FAULT]
    assert fault.text.fault_code == code and words in str(fault.text)
    assert advice in str(advised(fault, HERE).remedy)


@each_case(
    "place, command",
    [
        (Place(), "start it: roslaunch gpr20 survey.launch"),
        (Place(two_computers=True), "start it: roslaunch gpr20 server.launch"),
        (Place(service="gpr20-robot"), f"Run: {RESTART}gpr20-robot."),
        (Place(service="gpr20-server", two_computers=True), f"Run: {RESTART}gpr20-server."),
    ],
)
def test_an_advice_names_what_is_installed_here(place, command):
    fault = advised(findings(unheard(MasterState.NOT_THERE), None)[0], place)
    assert command in str(fault.remedy)


CHANGES = [*(one[0] for one in [*WITH_FAULT, *OTHERS]), {"listening_s": 1.0}]
CHANGES += [{"evidence": Evidence(M.ANSWERS, nodes={HEIGHT: state})} for state in NodeState]
ROBOTS = st.one_of(
    st.lists(st.sampled_from(CHANGES)).map(lambda some: facts(**dict(ChainMap(*some)))),
    st.sampled_from([one[0] for one in SILENT]),
)
