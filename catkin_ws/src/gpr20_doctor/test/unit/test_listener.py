"""What the nodes report becomes facts; waiting ends when enough is known."""

import json
import threading

import pytest

from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.node_facts import NO_HARDWARE
from gpr20_doctor.mid.finding import Finding, Level
from gpr20_doctor.mid.findings import as_json, lines
from gpr20_doctor.mid.node_health import EXPECTED_NODES, STALE_S, HealthLevel, NodeHealth
from gpr20_doctor.mid.robot_facts import WATCH_S, Endstop, Listener
from gpr20_simulator.mid.analyzer.in_process import StepTime
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.robot_description import NodeDescription


@pytest.fixture
def clock():
    return StepTime()


@pytest.fixture
def listener(clock):
    return Listener(clock, "http://localhost:11311")


def report_all(listener, names=EXPECTED_NODES):
    for name in names:
        listener.note_node(NodeHealth(name, HealthLevel.OK, verbatim("ok"), {}, 0.1))
    description = NodeDescription("main_control", NO_HARDWARE, {})
    listener.note_configuration(None, True, {"main_control": description})
    listener.note(control_alive=True, surveying=False)


def test_waiting_ends_when_everything_has_reported(listener, clock):
    report_all(listener)
    listener.wait(60.0)
    assert WATCH_S <= clock.now_s() < WATCH_S + 0.2
    facts = listener.facts()
    assert facts.master_alive and facts.control_alive and facts.simulated
    assert len(facts.nodes) == len(EXPECTED_NODES)
    assert list(facts.software) == ["main_control"]


def test_waiting_ends_at_its_limit_and_silent_nodes_are_named(listener, clock):
    report_all(listener, EXPECTED_NODES[1:])
    listener.wait(3.0)
    assert clock.now_s() == pytest.approx(3.0, abs=0.1)
    silent = [one.name for one in listener.facts().nodes if one.level is HealthLevel.STALE]
    assert silent == listener.silent() == [EXPECTED_NODES[0]]


def test_parts_that_not_every_robot_has_are_judged_only_if_they_report_or_were_launched(clock):
    listener = Listener(clock, "http://localhost:11311", ["visualization", "rviz"])
    facts = listener.facts()
    assert not facts.control_alive and not facts.configured and facts.software == {}
    report_all(listener)
    assert listener.silent() == ["visualization"]
    found = {one.name: one.level for one in listener.facts().nodes}
    assert set(found) == {*EXPECTED_NODES, "visualization"}
    assert found["visualization"] is HealthLevel.STALE
    report_all(listener, ("web", "simulator"))
    assert {"web", "simulator"} <= {one.name for one in listener.facts().nodes}


def test_findings_are_printed_with_their_remedies():
    printed = list(lines(FOUND, Catalogue({"no bus": "sin bus"})))
    assert printed == [
        "FAULT       sin bus (ENOENT)",
        "            -> switch it on",
        "GOOD        pins",
        "1 faults, 0 warnings, 0 unknown, 0 notes, 1 good",
    ]
    record = json.loads(as_json(FOUND, Catalogue()))
    assert record["status"] == 2
    assert record["findings"][0] == {
        **{"check": "spi", "fault_code": "", "level": "FAULT", "text": "no bus"},
        **{"details": "ENOENT", "remedy": "switch it on"},
    }


def test_changes_of_an_endstop_are_counted_and_the_smallest_offset_kept(listener):
    for pressed in (False, True, True, False):
        listener.note_endstop(Endstop(AxisId.X, pressed))
    for offset_s in (3.0, -0.2, 1.0):
        listener.note_node(NodeHealth("height_sensor", HealthLevel.OK, verbatim(""), {}, offset_s))
    for name in ("foreign", "sensors/gnss"):
        listener.note_node(NodeHealth(name, HealthLevel.OK, verbatim(""), {}, 0.1))
    facts = listener.facts()
    assert [one.name for one in facts.nodes] == [*EXPECTED_NODES, "sensors/gnss"]
    assert facts.endstops[AxisId.X].changes == 2
    assert facts.clock_offsets_s == {"height_sensor": -0.2, "sensors/gnss": 0.1}


def test_the_next_reports_are_waited_for_within_a_limit(listener, clock):
    report_all(listener)
    listener.wait_for_next(["height_sensor"], 2.0)
    assert clock.now_s() == pytest.approx(2.0, abs=0.1)
    listener.wait_for_next(["never heard"], 2.0)
    assert clock.now_s() == pytest.approx(2.0, abs=0.1)


def test_a_node_that_has_fallen_silent_is_offline(listener, clock):
    report_all(listener)
    clock.wait_s(threading.Event(), STALE_S + 0.1)
    report_all(listener, EXPECTED_NODES[1:])
    found = {one.name: one.level for one in listener.facts().nodes}
    assert [name for name, level in found.items() if level is HealthLevel.STALE] == [
        EXPECTED_NODES[0]
    ]


FOUND = (
    Finding("spi", Level.FAULT, Message("no bus", details="ENOENT"), Message("switch it on")),
    Finding("gpio", Level.OK, Message("pins")),
)


def test_a_level_that_nobody_knows_is_an_error_of_that_part_alone():
    # Anybody can publish there.
    messages = pytest.importorskip("diagnostic_msgs.msg")
    node_reports = pytest.importorskip("gpr20_doctor.high.node_reports")
    given = (0, 7, 3, b"\x01", 255)
    status = [messages.DiagnosticStatus(name=f"/part_{one}", level=one) for one in given]
    found = node_reports.node_healths(messages.DiagnosticArray(status=status), "/")
    ok, warn, error, stale = HealthLevel
    assert [one.level for one in found] == [ok, error, stale, warn, error]
