"""The processes of window and client: how they end, by signals or without a display."""

import argparse
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from case_kit import each_case

pytest.importorskip("rospy")

from gpr20_common.catalogue import Language
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.errors import MasterUnavailableError
from gpr20_user_interface.high import user_interface
from gpr20_user_interface.low.process import StopSignals, problem_of


def test_the_first_signal_and_those_after_it_call_what_they_are_for():
    called = []
    for number in (signal.SIGINT, signal.SIGTERM):
        before = signal.getsignal(number)
        with StopSignals(lambda: called.append("first"), lambda: called.append("next")) as signals:
            assert not signals.received
            for sent in (number, signal.SIGTERM, signal.SIGINT):
                os.kill(os.getpid(), sent)
            assert signals.received
        assert signal.getsignal(number) is before
    assert called == ["first", "next", "next"] * 2


@each_case(
    "program, limit_s, problem",
    [
        ("print('a warning')", 100.0, None),
        ("raise SystemExit('no such plugin')", 100.0, "no such plugin"),
        (
            "print('loading\\ncould not connect to display :7\\nmore'); exit(1)",
            100.0,
            "could not connect to display :7",
        ),
        ("import signal; signal.pause()", 0.2, "no answer within 0.2 s"),
    ],
)
def test_a_display_that_does_not_open_is_a_problem_with_its_reason(program, limit_s, problem):
    assert problem_of(program, limit_s) == problem


PROGRAM = Path(__file__).resolve().parents[2] / "nodes" / "user_interface"
LIMIT_S = 100.0


def started(*arguments, display=""):
    """Start the program with a display that there is not."""
    environment = {**os.environ, "DISPLAY": display}
    for name in ("QT_QPA_PLATFORM", "WAYLAND_DISPLAY"):
        environment.pop(name, None)
    return subprocess.Popen(
        [sys.executable, str(PROGRAM), *arguments],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_without_a_display_it_says_how_to_run_without_a_window():
    output, _ = (process := started()).communicate(timeout=LIMIT_S)
    said = [line for line in output.splitlines() if "QStandardPaths" not in line]
    assert process.returncode == 3 and len(said) == 1, output
    assert "ui:=false" in said[0]


def test_it_waits_for_a_display_where_the_launch_says_so():
    process = started("--wait-for-display", display=":4711")
    assert "ui:=false" in process.stdout.readline()
    process.terminate()
    output, _ = process.communicate(timeout=LIMIT_S)
    assert (process.returncode, output) == (-signal.SIGTERM, "")


@pytest.fixture
def run(monkeypatch, capsys):
    """Run the program up to the graph; return its exit status and what it has said."""
    monkeypatch.setattr(user_interface, "check_display", lambda: None)

    def run(replay=False):
        options = argparse.Namespace(replay=replay, wait_for_display=False)
        return user_interface._run(options), capsys.readouterr().err

    return run


def test_it_ends_without_a_master_or_as_a_replay_in_the_namespace_of_a_robot(run, monkeypatch):
    # Two windows of one name: the master would end that of the robot.
    asked = []
    there = SimpleNamespace(lookupNode=asked.append)
    monkeypatch.setattr(user_interface.rosgraph, "Master", lambda _name: there)
    status, said = run(replay=True)
    assert status == 2 and "a robot has the namespace" in said
    assert asked == ["/main_control"]

    def join(*_given):
        raise MasterUnavailableError(Message("no ROS master answers"))

    monkeypatch.setattr(user_interface, "join_graph", join)
    assert run()[0] == 1


def test_a_parameter_comes_before_what_was_used_last_and_must_be_allowed(monkeypatch):
    parameters = {}
    monkeypatch.setattr(user_interface.rospy, "get_param", parameters.get)
    assert user_interface._language(Language.SPANISH) is Language.SPANISH
    parameters["~language"] = "en"
    assert user_interface._language(Language.SPANISH) is Language.ENGLISH
    parameters.update({"~language": "fr", "~full_screen": "maybe"})
    with pytest.raises(InvalidValueError, match="'fr'"):
        user_interface._language(Language.SPANISH)
    with pytest.raises(InvalidValueError, match="full_screen is 'maybe'"):
        user_interface._covers_screen()
