"""Two machines behind the firewall of docs/install.md, over a link that fails for a while."""

from __future__ import annotations

import json
import random
import re
import signal
import time
from collections import Counter

import pytest
from network_namespaces import (
    ROBOT,
    ROBOT_STRANGER,
    SERVER,
    SERVER_STRANGER,
    firewall_commands,
    launched,
    two_machines,
)
from run_seed import SEED
from user_shell import has_bag
from wait_kit import wait_until

from gpr20_analysis.read.verdict import COMPLETE
from gpr20_analysis.read.verification import verify_survey

pytestmark = [
    *(pytest.mark.release, pytest.mark.timeout(1200)),
    pytest.mark.needs("network namespaces", "firewall"),
]
# Longer than a client waits: 35 s of silence, which it notices after 5 s.
CUT_S, LOSS_PERCENT = 45.0, 5
TRACES = 3 * 3 * 2
CONTACT_LOST, STOPPED_BY_CTRL_C = 3, 130
SURVEY = "rosrun gpr20_user_interface run_survey --wait 60 --x-points 3 --y-points 3"
MASTER = "11311"
# Nodes of each machine; each of them has a server for calls and one for topics.
NODES_ON_SERVER, NODES_ON_ROBOT = 4, 5


def test_a_survey_continues_when_the_link_was_down_and_a_third_machine_reaches_no_port(tmp_path):
    draw = random.Random(SEED)

    def statuses():
        text = (tmp_path / "printed.log").read_text(errors="replace")
        return re.findall(r"\[INFO\] \[[\d.]+\]: ([A-Z]+): ", text)

    def stored():
        return [int(one.name.split("_")[0]) for one in tmp_path.glob("surveys/*/traces/*.json")]

    with two_machines() as machines, launched(*machines, tmp_path) as start:
        server, robot = machines
        # Without the rules, everybody reaches them.
        assert robot.reached(ROBOT_STRANGER, SERVER, [MASTER])
        for machine in machines:
            machine.run("bash", "-ec", "\n".join(firewall_commands()))
            machine.lose(LOSS_PERCENT)
        client, cut_at = start(SURVEY), draw.randrange(2, TRACES - 2)
        wait_until(lambda: len(stored()) >= cut_at, alive=[client])
        before_cut = len(statuses())
        # At rest, nodes that are still starting are named. Late answers are no lost nodes: a state
        # may say what it waits for, but it stays.
        changes = changes_of(["IDLE", *(one for one in statuses() if one != "IDLE")])
        assert changes == ["CONFIGURED", "CHECKING", "HOMING", "SURVEYING"], statuses()
        time.sleep(draw.uniform(0.0, 2.0))
        for percent in (100, LOSS_PERCENT):
            for machine in machines:
                machine.lose(percent)
            time.sleep(CUT_S if percent == 100 else 0.0)
        # The client has given up; the survey has not.
        assert client.wait(60.0) == CONTACT_LOST
        wait_until(lambda: statuses()[-1] == "FINISHED")
        # The survey has waited once, and nobody has resumed it.
        changes = changes_of(["SURVEYING", *statuses()[before_cut:]])
        assert changes == ["CHECKING", "HOMING", "SURVEYING", "FINISHED"], statuses()
        (survey,) = (one.parent for one in tmp_path.glob("surveys/*/survey.json"))
        assert json.loads((survey / "survey.json").read_text())["outcome"] == "finished"
        assert Counter(stored()) == Counter(range(TRACES))
        wait_until(lambda: has_bag(survey))
        assert verify_survey(survey).status == COMPLETE
        # A survey is stopped by Ctrl-C at its client.
        client = start(SURVEY)
        wait_until(lambda: statuses()[-1] == "SURVEYING", alive=[client])
        client.send_signal(signal.SIGINT)
        assert client.wait(60.0) == STOPPED_BY_CTRL_C
        assert statuses()[-1] == "STOPPED"
        for machine in machines:
            machine.lose(0)
        # The master, and two servers of every node.
        open_ports = closed_to_strangers(server, SERVER, robot, ROBOT, ROBOT_STRANGER)
        assert MASTER in open_ports and len(open_ports) > 2 * NODES_ON_SERVER
        open_ports = closed_to_strangers(robot, ROBOT, server, SERVER, SERVER_STRANGER)
        assert len(open_ports) >= 2 * NODES_ON_ROBOT


def changes_of(states):
    return [new for old, new in zip(states, states[1:]) if new != old]


def closed_to_strangers(machine, address, other, friend, stranger):
    """Return the ports of a machine; of the addresses of the other one only a friend's reaches."""
    ports = {port for local, port in machine.listening() if not local.startswith("127.")}
    assert other.reached(friend, address, ports) == ports
    assert other.reached(stranger, address, ports) == set()
    return ports
