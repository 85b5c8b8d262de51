"""Whatever process of a robot is killed, its surveys come whole and lose nothing acknowledged.

GPR20_GRAPH_KILLS is how many kills there are at least (5).
"""

from __future__ import annotations

import base64
import contextlib
import json
import os
import random
import signal
import subprocess
import sys
from collections import Counter

import pytest
from robot_in_process import TRACES, check_places
from robot_kit import LAUNCH, MASTER, NODES, LaunchedRobot, end
from run_seed import SEED
from storage_kit import mcap_traces
from trace_examples import assert_same_numbers

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.verdict import COMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.trace import trace_message

KILLS = int(os.environ.get("GPR20_GRAPH_KILLS", "5"))
EVERYTHING = "everything"
# A node as often as each of the others.
VICTIMS = (NODES, ["rosout"], [MASTER], [LAUNCH], [EVERYTHING])
START = "--wait=20 --x-start=10 --x-stop=20 --x-points=3 --y-start=10 --y-stop=20 --y-points=3"
# From the start of the client, most often within such a survey [s].
MOMENT_S = (0.3, 5.0)
CLIENT_LIMIT_S = 120.0
KILLS_PER_SURVEY, MOST_RESUMES = 4, 40
# Both topics are published when they are durable, so what is received was acknowledged.
MONITOR = """
import base64, sys, rospy
file = open(sys.argv[1], "ab", 0)
def note(topic):
    take = lambda one: file.write(f"{topic} {base64.b64encode(one._buff).decode()}\\n".encode())
    rospy.Subscriber(topic, rospy.AnyMsg, take, queue_size=1000)
rospy.init_node("monitor_of_kills")
note("trace")
note("survey_log")
rospy.spin()
"""


class Campaign:
    """The robot, which runs surveys and is killed meanwhile, and who hears what is published."""

    def __init__(self, place):
        # The instrument answers with the place and the rotation at which it measured.
        self.robot = LaunchedRobot(place, "time_scale:=60", "vna_medium:=position_probe")
        self.heard, self.monitor = place / "heard", None
        self.killed, self.draw = Counter(), random.Random(SEED)

    def close(self):
        end(self.monitor, signal.SIGTERM)
        self.robot.stop()

    def survey(self):
        """Begin a survey, kill and resume until it is whole, and judge it."""
        self.heard.write_bytes(b"")
        before, options = set(self.robot.data.glob("[0-9]*_*")), START.split()
        for attempt in range(MOST_RESUMES):
            if MASTER not in self.robot.processes():
                self.close()
                self.robot.start()
                self.monitor = self.robot.run([sys.executable, "-c", MONITOR, str(self.heard)])
            kills = attempt < KILLS_PER_SURVEY
            self.run_client(options, self.draw.choice(self.draw.choice(VICTIMS)) if kills else "")
            for folder in set(self.robot.data.glob("[0-9]*_*")) - before:
                with contextlib.suppress(AnalysisError):
                    if verify_survey(folder).status == COMPLETE:
                        return self.judge(folder)
                options = ["--wait=20", "--resume", folder.name]
        return pytest.fail(f"not whole after {MOST_RESUMES} resumes")

    def run_client(self, options, victim):
        """Run the client to its end, and kill meanwhile."""
        client = self.robot.client(*options)
        try:
            with contextlib.suppress(subprocess.TimeoutExpired):
                client.wait(self.draw.uniform(*MOMENT_S) if victim else CLIENT_LIMIT_S)
            if victim and client.poll() is None:
                self.killed[victim] += 1
                if victim == EVERYTHING:
                    self.robot.kill_all()
                    client.kill()
                else:
                    self.robot.kill(victim)
            client.wait(CLIENT_LIMIT_S)
        finally:
            client.kill()

    def judge(self, folder):
        stored = [json.loads(one.read_text()) for one in sorted(folder.glob("traces/*.json"))]
        assert [one["index"] for one in stored] == list(range(TRACES))
        check_places(stored, [0.0] * TRACES)
        recorded = {one.index: one for one in mcap_traces(folder / "survey.mcap")}
        for topic, coded in map(bytes.split, self.heard.read_bytes().splitlines()):
            data = base64.b64decode(coded)
            if topic == b"trace":
                trace = trace_message.decode(data, trace_message.MD5SUM)
                assert_same_numbers(trace, stored[trace.index])
                assert_same_numbers(trace, recorded[trace.index])
            else:
                # Behind the length of the text.
                logs = [one.read_bytes().splitlines() for one in folder.glob("log*.jsonl")]
                assert [one.count(data[4:]) for one in logs] == [1, 1], data[4:]


@pytest.mark.release
@pytest.mark.timeout(600 + 120 * KILLS)
def test_kills_in_the_graph_lose_double_and_misplace_nothing(tmp_path, monkeypatch):
    # The kit sets both in the environment.
    monkeypatch.setenv("ROS_MASTER_URI", "")
    monkeypatch.setenv("GPR20_STATE", "")
    campaign = Campaign(tmp_path)
    try:
        while sum(campaign.killed.values()) < KILLS:
            campaign.survey()
        print(f"killed: {dict(campaign.killed)}")
    finally:
        campaign.close()
