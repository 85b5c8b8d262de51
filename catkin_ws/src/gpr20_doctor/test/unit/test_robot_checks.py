"""Each fault that the nodes report has a finding with a remedy, the worst first."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.message import Message, verbatim
from gpr20_common.mid.node_software import NodeSoftware
from gpr20_doctor.mid.finding import Level
from gpr20_doctor.mid.findings import BAD, DOUBTFUL, GOOD, exit_status, findings
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth
from gpr20_doctor.mid.robot_facts import AnalyzerFacts, EndstopSeen, RobotFacts
from gpr20_survey.axes.axis_id import AxisId

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
    X_AXIS: {"homed": "True", "endstop": "open", "coordinate [mm]": "200.0"},
    "y_axis/axis_driver": {"homed": "True", "endstop": "pressed", "coordinate [mm]": "0.0"},
    HEIGHT: {"height [m]": "0.2000"},
}
SAME = NodeSoftware("0.1.0", "abc", "robot")


def facts(nodes=None, **changes):
    reports = {
        name: NodeHealth(name, OK, verbatim("ok"), VALUES.get(name, {})) for name in EXPECTED_NODES
    }
    for name, (level, message, values) in (nodes or {}).items():
        reports[name] = NodeHealth(name, level, message, {**VALUES.get(name, {}), **values})
    known = {
        "master_alive": True,
        "control_alive": True,
        "configured": True,
        "simulated": False,
        "surveying": False,
        "nodes": tuple(reports.values()),
        "software": {name: SAME for name in EXPECTED_NODES},
        **changes,
    }
    return RobotFacts(**known)


def report(name, level=OK, message="", **values):
    message = message if isinstance(message, Message) else verbatim(message)
    return {"nodes": {name: (level, message, values.get("values", {}))}}


def test_a_robot_without_a_fault_is_good():
    found = findings(facts(clock_offsets_s={HEIGHT: 0.01}), None)
    assert {one.level for one in found} == {Level.OK}
    assert len(found) > len(EXPECTED_NODES)
    assert all(one.remedy is None for one in found)
    assert exit_status(found) == GOOD


def test_who_has_just_begun_to_listen_has_not_heard_every_node():
    silent = facts(**report(HEIGHT, STALE))
    assert findings(replace(silent, listening_s=1.0), None)[0].level is Level.UNKNOWN
    assert findings(replace(silent, listening_s=6.0), None)[0].level is Level.FAULT


def test_without_the_master_nothing_is_called_good():
    found = findings(facts(master_alive=False, control_alive=False, nodes=None), None)
    assert any("ROS master" in str(one.text) for one in found)
    unheard = replace(facts(master_alive=False, control_alive=False), nodes=())
    found = findings(unheard, None)
    assert [one.level for one in found] == [Level.FAULT, Level.UNKNOWN]
    assert exit_status(found) == BAD


OTHER = {VNA: NodeSoftware("0.1.0", "abc", "pc"), HEIGHT: NodeSoftware("0.1.0", "def", "pi")}
LOST = AnalyzerFacts("", "", Message("no connection to the VNA"))
CASES = [
    ({"master_alive": False}, Level.FAULT, "ROS master"),
    ({"control_alive": False}, Level.FAULT, "no contact with the main control"),
    ({"configuration_problem": Message("parts are mixed")}, Level.FAULT, "No survey can"),
    ({"configured": False}, Level.UNKNOWN, "configuration is not known"),
    ({"simulated": True}, Level.NOTE, "is simulated"),
    (report(HEIGHT, STALE), Level.FAULT, "does not report"),
    (report(HEIGHT, ERROR, "out"), Level.FAULT, "Height sensor: out"),
    (report(X_AXIS, WARN, Message("not homed")), Level.NOTE, "not homed"),
    (report(VNA, WARN, Message("not connected")), Level.NOTE, "not connected"),
    (report(HEIGHT, WARN, Message("no height measured yet")), Level.UNKNOWN, "no height"),
    (report(HEIGHT, WARN, "odd"), Level.WARNING, "Height sensor: odd"),
    (report(HEIGHT, values={"height [m]": "1.9"}), Level.WARNING, "height of the antennas is 1.9"),
    (report(VNA, values={"calibration": "NONE"}), Level.FAULT, "no calibration"),
    (report(VNA, values={"calibration": "LOW"}), Level.WARNING, "10 °C"),
    (report(VNA, values={"calibration": "new word"}), Level.WARNING, "new word"),
    (report(VNA, values={"calibration": ""}), Level.UNKNOWN, "not been read"),
    (report(VNA, values={"identity": "A,SIMULATED,1"}), Level.FAULT, "not both simulated"),
    ({"analyzer": LOST}, Level.FAULT, "Test of the VNA: no connection"),
    (report(STORAGE, values={"free disk [MB]": "100"}), Level.FAULT, "0.1 GB"),
    (report(STORAGE, values={"free disk [MB]": "4000"}), Level.WARNING, "4.0 GB"),
    (report(STORAGE, values={"free disk [MB]": ""}), Level.UNKNOWN, "disk space is not known"),
    (
        report(X_AXIS, values={"endstop": "pressed"}),
        Level.FAULT,
        "endstop of the X axis is closed at 200 mm",
    ),
    (
        report(X_AXIS, values={"endstop": "pressed", "homed": "False"}),
        Level.WARNING,
        "closed; it is not homed",
    ),
    ({"clock_offsets_s": {HEIGHT: 0.1, VNA: -75.0}}, Level.WARNING, "VNA driver differs"),
    ({"software": OTHER}, Level.WARNING, "0.1.0 (abc) on pc; 0.1.0 (def) on pi"),
    ({"software": {VNA: NodeSoftware()}}, Level.UNKNOWN, "VNA driver does not say"),
    ({"software": {}}, Level.UNKNOWN, "software of the parts is not known"),
]


@pytest.mark.parametrize(("changes", "level", "words"), CASES)
def test_each_fault_is_found(changes, level, words):
    found = findings(facts(**changes), None)
    (fault,) = [one for one in found if words in str(one.text)]
    assert fault.level is level
    assert found[0].level is level
    assert fault.remedy is not None
    expected = {Level.FAULT: BAD, Level.NOTE: GOOD}.get(level, DOUBTFUL)
    assert exit_status(found) == expected


def test_an_endstop_that_changes_while_it_is_watched_works():
    seen = facts(endstops={AxisId.X: EndstopSeen(False, 2), AxisId.Y: EndstopSeen(True)})
    texts = [str(one.text) for one in findings(seen, None)]
    assert "The endstop of the X axis works: its state has changed." in texts
    assert "The endstop of the Y axis is closed, at its zero." in texts


def test_a_test_of_the_vna_counts_more_than_what_its_driver_remembers():
    tested = facts(analyzer=AnalyzerFacts("Anritsu", "LOW"))
    assert findings(tested, None)[0].level is Level.WARNING


WORDS = st.sampled_from(["", "1", "0.2", "-3", "nan", "inf", "True", "pressed", "HIGH", "x" * 30])
KEYS = st.sampled_from(
    ["height [m]", "calibration", "identity", "free disk [MB]", "endstop", "homed"]
    + ["coordinate [mm]", "voltage [V]"]
)
HEALTHS = st.builds(
    NodeHealth,
    st.sampled_from([*EXPECTED_NODES, "simulator"]),
    st.sampled_from(HealthLevel),
    st.builds(verbatim, WORDS),
    st.dictionaries(KEYS, WORDS),
)
MESSAGES = st.none() | st.builds(verbatim, WORDS)
ROBOTS = st.builds(
    RobotFacts,
    *[st.booleans()] * 5,
    nodes=st.lists(HEALTHS, max_size=9).map(tuple),
    configuration_problem=MESSAGES,
    clock_offsets_s=st.dictionaries(WORDS, st.floats()),
    listening_s=st.floats(0.0, 10.0),
    software=st.dictionaries(WORDS, st.builds(NodeSoftware, WORDS, WORDS, WORDS)),
    endstops=st.dictionaries(
        st.sampled_from(AxisId), st.builds(EndstopSeen, st.booleans(), st.integers(0, 3))
    ),
    analyzer=st.none() | st.builds(AnalyzerFacts, WORDS, WORDS, MESSAGES),
)


@given(ROBOTS)
def test_whatever_is_known_every_finding_has_a_sentence_and_a_remedy(robot):
    found = findings(robot, None)
    assert found
    for one in found:
        assert one.check and str(one.text)
        assert one.level < Level.UNKNOWN or str(one.remedy)
    if exit_status(found) == GOOD:
        assert robot.master_alive and robot.control_alive
        assert robot.configured and robot.configuration_problem is None
