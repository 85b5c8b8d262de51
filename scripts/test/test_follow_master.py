"""The robot's launch follows the ROS master: deploy/follow_master.py."""

from __future__ import annotations

import threading

import pytest
from user_shell import imported

follow_master = imported("follow_master")

# Writes a line when it starts and one when Ctrl-C ends it.
COMMAND = """
trap 'echo end >>"$0"; exit 0' INT
echo start >>"$0"
while true; do sleep 0.01; done
"""


@pytest.fixture
def started(tmp_path, monkeypatch):
    """The log of a follower that runs, what it said, and the master's run to set."""
    monkeypatch.setattr(follow_master, "POLL_S", 0.02)
    log, said, run = tmp_path / "log", [], {"id": None}
    log.touch()
    follower = follow_master.Follower(
        ["bash", "-c", COMMAND, str(log)], lambda: run["id"], said.append
    )
    thread = threading.Thread(target=follower.follow)
    thread.start()
    yield log, said, run
    # As Ctrl-C does: what was started has written that it ends.
    follower.stop()
    thread.join(20.0)
    assert not thread.is_alive()
    assert log.read_text().count("start") == log.read_text().count("end")


def wait_for_lines(log, count):
    for _ in range(2000):
        if len(log.read_text().splitlines()) >= count:
            break
        threading.Event().wait(0.01)
    return log.read_text().split()


def test_it_waits_for_a_master_and_says_so_once(started):
    log, said, run = started
    threading.Event().wait(0.2)
    assert log.read_text() == ""
    run["id"] = "a"
    assert wait_for_lines(log, 1) == ["start"]
    assert len(said) == 1 and "waiting for the ROS master" in said[0]


def test_a_new_master_restarts_the_command_and_a_silent_one_does_not(started):
    log, said, run = started
    run["id"] = "a"
    wait_for_lines(log, 1)
    run["id"] = None
    threading.Event().wait(0.2)
    run["id"] = "a"
    threading.Event().wait(0.1)
    assert log.read_text().split() == ["start"]
    run["id"] = "b"
    assert wait_for_lines(log, 3) == ["start", "end", "start"]
    assert "restarted" in said[-1]


def test_it_ends_with_the_status_of_a_command_that_ends_by_itself():
    follower = follow_master.Follower(["bash", "-c", "exit 7"], lambda: "a", print)
    assert follower.follow() == 7


def test_a_master_that_is_not_there_has_no_run():
    assert follow_master.read_run_id("http://127.0.0.1:9") is None
