"""The program doctor: where it looks for a robot, what it asks of it, and what it prints.

Masters and nodes are servers of this process; a doctor beside a running robot is in
scripts/test/test_web_page.py.
"""

import contextlib
import json
import os
import re
import socket
import sys
import threading
from dataclasses import replace
from types import SimpleNamespace
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from case_kit import each_case
from robot_kit import free_port
from test_machine_checks import HEALTHY
from test_robot_checks import AXES, ENDSTOPS

pytest.importorskip("rospy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from sensor_msgs.msg import Range
from std_msgs.msg import Bool

from gpr20_common.high.service_client import ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_doctor.high import doctor, graph, node_reports
from gpr20_doctor.low import masters
from gpr20_doctor.low.masters import MasterState, NodeState
from gpr20_doctor.mid.finding import Level
from gpr20_doctor.mid.findings import findings
from gpr20_doctor.mid.machine_request import REAL
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel
from gpr20_msgs.msg import ControlStatus, CurrentCoordinate, NodeDescription, RobotConfiguration
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import SurveyState

ROBOT = ("/field/start_survey", "/field/stop_survey", "/half/start_survey")


class Server(SimpleXMLRPCServer):
    """A master with the services of a robot, its nodes, and the launch that keeps them."""

    def __init__(self):
        super().__init__(("127.0.0.1", 0), logRequests=False)
        self.port = self.server_address[1]
        self.uri = f"http://127.0.0.1:{self.port}"
        self.nodes = {"node": self.uri}
        state = [[], [["/topic", ["/node"]]], [[name, ["/node"]] for name in ROBOT]]
        known = {
            "getPid": lambda *_caller: (1, "", os.getpid()),
            "getSystemState": lambda _caller: (1, "", state),
            "lookupNode": self._look_up,
            "getParam": lambda _caller, _name: (1, "", {"one": self.uri, "gone": closed_uri()}),
            "get_node_names": lambda: (1, "", ["field/storage-7", "rosout-1"]),
        }
        for name, method in known.items():
            self.register_function(method, name)
        self._thread = threading.Thread(target=self.serve_forever, args=(0.01,))
        self._thread.start()

    def _look_up(self, _caller, name):
        uri = self.nodes.get(name.rpartition("/")[2])
        return (1, "", uri) if uri else (-1, "unknown node", 0)

    def close(self):
        self.shutdown()
        self._thread.join()
        self.server_close()


def closed_uri():
    return f"http://127.0.0.1:{free_port()}"


@pytest.fixture
def hanging():
    """The address of a program that takes calls and answers none."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"http://127.0.0.1:{server.getsockname()[1]}"


@pytest.fixture
def master():
    with contextlib.closing(Server()) as server:
        yield server


@pytest.fixture(autouse=True)
def computer(tmp_path, monkeypatch):
    """A computer on which nothing of this one is seen, and a graph that nobody really joins."""
    monkeypatch.setattr(doctor.signal, "signal", lambda *_all: None)
    monkeypatch.setattr(graph.rospy, "init_node", lambda *_all, **_more: None)
    monkeypatch.setattr(graph.rospy, "Subscriber", lambda *_all: None)
    moment = SimpleNamespace(time_of_day_us=lambda: 1_000_000_000)
    monkeypatch.setattr(node_reports, "Clock", lambda: moment)
    monkeypatch.setattr(graph.rospy, "signal_shutdown", lambda _why: None)
    monkeypatch.setattr(graph, "ServiceClient", Services())
    monkeypatch.setattr(doctor, "ROOT", tmp_path)
    monkeypatch.setattr(doctor.system, "DEFAULT_PORT", 1)
    monkeypatch.setattr(masters, "ANSWER_LIMIT_S", 30.0)
    monkeypatch.setattr(doctor, "probe_machine", lambda request: replace(HEALTHY, pins=True))
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)


@pytest.fixture
def run(monkeypatch, capsys):
    """Return a function that runs the doctor; it returns status, findings and complaints."""

    def run(master, *arguments):
        monkeypatch.setenv("ROS_MASTER_URI", master)
        monkeypatch.setattr(sys, "argv", ["doctor", "--json", "--language", "en", *arguments])
        status = doctor.main()
        printed, said = capsys.readouterr()
        if not printed:
            return status, {}, said
        record = json.loads(printed)
        assert record["status"] == status
        return status, {one["check"]: one for one in reversed(record["findings"])}, said

    return run


LOST = "http://no-such-host.invalid:1"


def test_a_master_names_its_robots_its_nodes_and_where_they_listen(master):
    assert masters.state_of(master.uri) is MasterState.ANSWERS
    assert masters.robots_at(master.uri) == ("/field",)
    assert masters.launched_nodes(master.uri) == {"/field/storage", "/rosout"}
    assert masters.node_ports(master.uri) == {master.port}


def test_a_master_that_hangs_is_told_from_one_that_is_missing_or_not_reached(
    run, hanging, monkeypatch
):
    monkeypatch.setattr(masters, "ANSWER_LIMIT_S", 0.2)
    states = [masters.state_of(one) for one in (closed_uri(), hanging, LOST)]
    assert states == [MasterState.NOT_THERE, MasterState.HANGS, MasterState.UNREACHABLE]
    for silent in (closed_uri(), hanging):
        assert masters.robots_at(silent) == ()
        assert masters.launched_nodes(silent) == masters.node_ports(silent) == frozenset()
    status, found, _said = run(hanging, "--quick")
    assert (status, found["master"]["fault_code"]) == (2, "robot.master_lost")
    assert found["master"]["remedy"].startswith("Switch off the motors' power.")


def test_a_node_is_there_hangs_is_not_reached_or_has_ended(master, hanging, monkeypatch):
    # The others have to answer in this time.
    monkeypatch.setattr(masters, "ANSWER_LIMIT_S", 1.5)
    master.nodes.update(hangs=hanging, lost=LOST)
    found = masters.node_states(master.uri, ["/a/node", "/a/hangs", "/a/lost", "/a/never"])
    states = (NodeState.ANSWERS, NodeState.HANGS, NodeState.UNREACHED, NodeState.GONE)
    assert tuple(found.values()) == states


def test_the_advice_leads_to_where_the_robot_is(run, master, monkeypatch):
    status, found, _said = run(master.uri, "--quick", "--ns", "other", "--wait", "0")
    assert (status, found["master"]["fault_code"]) == (2, "robot.not_running")
    assert re.search(r"gpr20 doctor --ns field\.", found["master"]["remedy"])
    monkeypatch.setattr(doctor.system, "DEFAULT_PORT", master.port)
    status, found, _said = run(closed_uri(), "--quick")
    assert (status, found["master"]["fault_code"]) == (2, "robot.not_running")
    assert found["parts"]["level"] == "UNKNOWN"
    assert f"export ROS_MASTER_URI=http://localhost:{master.port}" in found["master"]["remedy"]


def test_a_master_that_starts_later_is_waited_for_if_that_was_asked_for(monkeypatch):
    states = [MasterState.NOT_THERE, MasterState.HANGS, MasterState.ANSWERS]
    times_s = iter(range(9))
    clock = SimpleNamespace(now_s=lambda: next(times_s), wait_s=lambda *_all: None)
    monkeypatch.setattr(doctor, "Clock", lambda: clock)
    monkeypatch.setattr(masters, "state_of", lambda _uri: states.pop(0))
    assert doctor._state_of_master("", 4.0) is MasterState.NOT_THERE
    assert doctor._state_of_master("", 6.0) is MasterState.ANSWERS


def test_a_bundle_over_a_file_and_a_folder_of_no_user_are_refused(run, tmp_path, monkeypatch):
    monkeypatch.setattr(doctor, "write_bundle", lambda file, *_all: file.write_text("zip") and {})
    assert run(closed_uri(), "--bundle", str(tmp_path / "a.zip"))[0] == 2
    assert (tmp_path / "a.zip").read_text() == "zip"
    assert run(closed_uri(), "--bundle", str(tmp_path / "a.zip"))[0] == 3
    monkeypatch.setenv("GPR20_CONFIG", "~no_such_user/robot")
    status, found, said = run(closed_uri(), "--quick")
    assert (status, found) == (3, {})
    assert said.startswith("The doctor could not work: ") and "\n-> " in said


def test_a_configuration_that_is_named_is_that_of_a_real_robot(run, tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(doctor, "probe_machine", lambda one: asked.append(one) or HEALTHY)
    named = ("--quick", "--config", str(tmp_path / "mole"))
    for arguments in (named, (*named, "--robot", "simulated"), ("--quick",)):
        run(closed_uri(), *arguments)
    assert [one.files for one in asked] == [REAL, "simulated", REAL]
    assert asked[0].place.config == tmp_path / "mole" and not asked[0].thorough


class Services:
    """Those that the doctor calls, and that answer nothing."""

    def __init__(self):
        self.called = []

    def __call__(self, name, _kind):
        def call(_limit_s):
            self.called.append(name)
            raise ServiceUnavailableError(Message("no answer"))

        return SimpleNamespace(call=call)


@pytest.fixture
def join(monkeypatch, master):
    """Return a function that joins a graph whose published messages the test gives."""

    def join(services=None):
        heard = {}
        monkeypatch.setattr(
            *(graph.rospy, "Subscriber"),
            lambda name, _kind, take, *more: heard.update({name: lambda one: take(one, *more)}),
        )
        monkeypatch.setattr(graph, "ServiceClient", services or Services())
        return graph.Graph("field", master.uri), heard

    return join


def report_all(heard):
    """Let all nodes report; those of the Pi, whose clock is 75 s behind, by a message alone."""
    late = DiagnosticArray(status=[DiagnosticStatus(name="field/height_sensor: Status")])
    late.header.stamp = graph.rospy.Time(925)
    rest = [one for one in EXPECTED_NODES if one != "height_sensor"]
    others = [DiagnosticStatus(name=f"/field/{one}: Status", message="ok") for one in rest]
    now = DiagnosticArray(status=[*others, DiagnosticStatus(name="/b/imaging: Status", level=2)])
    now.header.stamp = graph.rospy.Time(1000)
    software = {"configuration_json": "{}", "version": "0.1.0", "revision": "a", "host": "pc"}
    nodes = [
        *(NodeDescription(node=one, **software) for one in rest),
        NodeDescription(node="height_sensor", **{**software, "revision": "b", "host": "pi"}),
        NodeDescription(node="nonsense", **{**software, "configuration_json": "["}),
    ]
    heard["/field/control_status"](ControlStatus(code=SurveyState.PAUSED.value))
    heard["/field/robot_configuration"](RobotConfiguration(known=True, nodes=nodes))
    for one in (late, now):
        heard["/diagnostics"](one)


def test_what_is_published_becomes_facts_and_findings(run, join, monkeypatch):
    own, heard = join()
    report_all(heard)
    for axis, position in AXES.items():
        coordinate = CurrentCoordinate(coordinate=position.coordinate, homed=True)
        heard[f"/field/{axis.value}_axis/current_coord"](coordinate)
    for axis in (AxisId.X, AxisId.Y):
        heard[f"/field/{axis.value}_axis/endstop"](Bool(ENDSTOPS[axis].pressed))
    for height_m, known in ((0.2, True), (9.0, False), (0.2, True)):
        heard["/field/measured_height"](Range(range=height_m, min_range=0.1, max_range=2.0))
        assert (own.listener.facts().height_m == pytest.approx(0.2)) is known
    facts = own.listener.facts()
    assert facts.axes == AXES
    assert {axis: one.pressed for axis, one in facts.endstops.items()} == {
        axis: one.pressed for axis, one in ENDSTOPS.items()
    }
    assert facts.control_alive and facts.surveying and facts.configured
    assert {one.level for one in facts.nodes} == {HealthLevel.OK}
    assert facts.clock_offsets_s["height_sensor"] == pytest.approx(75.0)
    assert set(facts.software) == set(EXPECTED_NODES)
    found = {one.check: one.text for one in findings(facts, None) if one.level is Level.WARNING}
    assert found["clocks"].fault_code == "clock.wrong"
    assert found["versions"].fault_code == "robot.versions_differ"
    monkeypatch.setattr(own.listener, "wait", lambda _limit_s: None)
    monkeypatch.setattr(doctor, "Graph", lambda _namespace, _master: own)
    status, found, _said = run(own._master, "--ns", "field")
    assert status == 1 and found["master"]["level"] == "OK"
    assert found["versions"]["fault_code"] == "robot.versions_differ"
    heard["/field/robot_configuration"](RobotConfiguration(known=False, message="mixed"))
    assert str(own.listener.facts().configuration_problem) == "mixed"


@each_case(
    "code, called",
    [
        (None, set()),
        (SurveyState.PAUSED, set()),
        (SurveyState.IDLE, {"/field/get_height", "/field/test_analyzer"}),
    ],
)
def test_vna_and_height_are_tested_by_the_robot_itself_and_never_beside_a_survey(
    join, monkeypatch, code, called
):
    services = Services()
    own, heard = join(services)
    monkeypatch.setattr(own.listener, "wait_for_next", lambda *_all: None)
    if code is not None:
        heard["/field/control_status"](ControlStatus(code=code.value))
    found = doctor._test(own)
    assert set(services.called) == called
    assert (found is None) == (not called)
    assert found is None or found.failure.fault_code == "vna.no_answer"
