"""The program doctor: where it looks for a robot, what it asks of it, and what it prints.

Masters and nodes are servers of this process; a doctor beside a running robot is in
scripts/test/test_web_page.py.
"""

import contextlib
import json
import os
import re
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from case_kit import each_case
from robot_kit import RpcServer, free_port

pytest.importorskip("rospy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from gpr20_common.high.service_client import ServiceUnavailableError
from gpr20_common.message import Message
from gpr20_doctor.high import doctor, graph
from gpr20_doctor.low import masters
from gpr20_doctor.mid.machine import MachineReport
from gpr20_doctor.mid.node_health import EXPECTED_NODES
from gpr20_msgs.msg import ControlStatus, NodeDescription, RobotConfiguration
from gpr20_simulator.mid.analyzer.simulated_analyzer import StepTime
from gpr20_survey.plan.survey_state import SurveyState

ROBOT = ("/field/start_survey", "/field/stop_survey", "/half/start_survey", "/b/restart_survey")


def closed_uri():
    return f"http://127.0.0.1:{free_port()}"


@pytest.fixture
def hanging():
    """The address of a program that takes calls and answers none."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"http://127.0.0.1:{server.getsockname()[1]}"


@pytest.fixture
def master():
    """A master with the services of robots."""
    state = [[], [["/topic", ["/node"]]], [[name, ["/node"]] for name in ROBOT]]
    known = {
        "getPid": lambda *_caller: (1, "", os.getpid()),
        "getSystemState": lambda _caller: (1, "", state),
    }
    with contextlib.closing(RpcServer(**known)) as server:
        yield server


@pytest.fixture(autouse=True)
def computer(tmp_path, monkeypatch):
    """A computer on which nothing of this one is seen, and a graph that nobody really joins."""
    monkeypatch.setattr(doctor.signal, "signal", lambda *_all: None)
    for name in ("init_node", "Subscriber", "signal_shutdown"):
        monkeypatch.setattr(graph.rospy, name, lambda *_all, **_more: None)
    moment = SimpleNamespace(time_of_day_us=lambda: 1_000_000_000)
    monkeypatch.setattr(graph, "Clock", lambda: moment)
    monkeypatch.setattr(graph, "ServiceClient", Services())
    monkeypatch.setattr(doctor, "ROOT", tmp_path)
    monkeypatch.setattr(masters, "ANSWER_LIMIT_S", 30.0)
    monkeypatch.setattr(doctor, "examine", lambda one: MachineReport(machine=one))
    monkeypatch.setenv("GPR20_CONFIG", str(tmp_path))
    monkeypatch.setenv("LC_ALL", "C")
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)


@pytest.fixture
def run(monkeypatch, capsys):
    """Return a function that runs the doctor; it returns status, findings and complaints."""

    def run(master, *arguments):
        monkeypatch.setenv("ROS_MASTER_URI", master)
        monkeypatch.setattr(sys, "argv", ["doctor", "--json", *arguments])
        status = doctor.main()
        printed, said = capsys.readouterr()
        if not printed:
            return status, {}, said
        record = json.loads(printed)
        assert status in (record["status"], 3)
        return status, {one["check"]: one for one in reversed(record["findings"])}, said

    return run


def test_a_master_names_its_robots_and_a_silent_one_has_none(master, hanging, monkeypatch):
    assert masters.robots_at(master.uri) == ("/field",)
    monkeypatch.setattr(masters, "ANSWER_LIMIT_S", 0.2)
    for silent in (closed_uri(), hanging):
        assert masters.robots_at(silent) == ()


def test_the_advice_leads_to_the_namespace_of_the_robot(run, master):
    status, found, _said = run(master.uri, "--quick", "--ns", "other", "--wait", "0")
    assert (status, found["master"]["fault_code"]) == (2, "robot.not_running")
    assert re.search(r"gpr20 doctor --ns field\.", found["master"]["remedy"])
    assert found["parts"]["level"] == "UNKNOWN"


def test_a_bundle_over_a_file_a_wrong_option_and_a_folder_of_no_user_are_refused(
    run, tmp_path, monkeypatch
):
    bundle = tmp_path / "a.json"
    monkeypatch.setattr(doctor, "write_bundle", lambda file, *_all: file.write_text("{}") and {})
    assert run(closed_uri(), "--bundle", str(bundle))[0] == 2
    # Before any check.
    for name, why in ((bundle, "choose another name"), (tmp_path / "x.tar.gz", "is JSON")):
        status, found, said = run(closed_uri(), "--bundle", str(name))
        assert (status, found) == (3, {}) and why in said
    assert bundle.read_text() == "{}"
    status, _found, said = run(closed_uri(), "--wait", "-1")
    assert status == 3 and "allowed: 0 or more seconds" in said
    monkeypatch.setenv("GPR20_CONFIG", "~no_such_user/robot")
    status, found, said = run(closed_uri(), "--quick")
    assert (status, found) == (3, {})
    assert said.startswith("The doctor could not work: ") and "\n-> " in said


class Services:
    """Those that the doctor calls, and that answer nothing."""

    def __init__(self):
        self.called = []

    def __call__(self, name, _kind):
        def call(_limit_s):
            self.called.append(name)
            raise ServiceUnavailableError(Message("no answer"))

        return SimpleNamespace(call=call)


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
    heard["/field/robot_configuration"](RobotConfiguration(known=True, nodes=nodes))
    for one in (late, now):
        heard["/diagnostics"](one)


CALLED = ["/field/test_analyzer"]


@each_case(
    "state, options, called",
    [
        (SurveyState.PAUSED, (), []),
        (SurveyState.IDLE, ("--quick",), []),
        (SurveyState.IDLE, (), CALLED),
    ],
)
def test_what_is_published_is_judged_and_the_vna_is_tested_but_never_beside_a_survey(
    run, master, monkeypatch, state, options, called
):
    services, heard = Services(), {}
    monkeypatch.setattr(graph, "ServiceClient", services)
    monkeypatch.setattr(
        *(graph.rospy, "Subscriber"), lambda name, _kind, take: heard.update({name: take})
    )

    def wait(_graph, _limit_s):
        report_all(heard)
        heard["/field/control_status"](ControlStatus(code=state.value))

    monkeypatch.setattr(graph.Graph, "wait", wait)
    status, found, _said = run(master.uri, "--ns", "field", *options)
    assert status == (2 if called else 1) and found["master"]["level"] == "OK"
    assert {found[one]["level"] for one in EXPECTED_NODES} == {"OK"}
    assert found["clocks"]["fault_code"] == "clock.wrong"
    assert found["versions"]["fault_code"] == "robot.versions_differ"
    assert services.called == called
    untested = "NOTE" if state is SurveyState.PAUSED else "UNKNOWN"
    assert found["vna"]["level"] == ("FAULT" if called else untested)


def test_waiting_ends_when_everything_has_reported_or_at_its_limit(master, monkeypatch):
    heard, clock = {}, StepTime()
    monkeypatch.setattr(
        *(graph.rospy, "Subscriber"), lambda name, _kind, take: heard.update({name: take})
    )
    own = graph.Graph("field", master.uri, clock)
    own.wait(3.0)
    assert clock.now_s() == pytest.approx(3.0, abs=0.1)
    assert own.silent() == [*EXPECTED_NODES]
    report_all(heard)
    heard["/field/control_status"](ControlStatus(code=SurveyState.IDLE.value))
    own.wait(60.0)
    assert clock.now_s() == pytest.approx(3.0, abs=0.1)


def test_without_a_python_package_that_it_needs_it_says_how_to_install_it(tmp_path):
    (tmp_path / "polib.py").write_text("raise ModuleNotFoundError(name='polib')")
    program = Path(__file__).resolve().parents[2] / "nodes/doctor"
    path = os.pathsep.join([str(tmp_path), *sys.path])
    command = [sys.executable, str(program), "--help"]
    ended = subprocess.run(command, env={"PYTHONPATH": path}, stderr=subprocess.PIPE, text=True)
    assert ended.returncode == 3
    assert ended.stderr == "the Python package polib is missing; run: scripts/setup.sh\n"
