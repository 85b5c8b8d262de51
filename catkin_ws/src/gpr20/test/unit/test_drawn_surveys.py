"""Surveys with a drawn course: whatever happens, no acknowledged trace is lost or wrong."""

from __future__ import annotations

import random

import pytest
from robot_in_process import RobotInProcess
from run_seed import SEED
from simulated_world import World
from stored_surveys import check_acknowledged, check_complete

from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.survey.engine import Accepted
from gpr20_survey.plan.survey_state import SurveyState

# How often a survey is begun and continued with events ahead; then nothing disturbs it any more.
STRETCHES = 5
# The calls before which something happens, and how many of them are made in a short time.
CALLS = {"sweep": 4, "confirm": 4, "height": 4, "store": 4, "move": 6, "home": 2, "configure": 1}
FAULTS = (
    *(("vna", one) for one in ("DROP", "HANG", "SILENT", "LATE", "TRUNCATE", "NAN", "GARBAGE")),
    *(("vna", one) for one in ("STALE", "LATE_BIT", "LATE_MEMORY", "SLOW_POINTS", "LINK_GONE")),
    *(("vna", one) for one in ("HAND_BANDWIDTH", "HAND_START", "UNANSWERED_QUERY")),
    *(("adc", "STUCK"), ("endstop_x", "STUCK_CLOSED"), ("endstop_y", "STUCK_OPEN")),
)


class Course:
    """A survey to its end, through drawn events."""

    def __init__(self, world, draw):
        self.world, self.draw = world, draw
        self.robot = RobotInProcess(world)
        self.events = []

    def plan(self):
        """Let two things happen to the survey that is about to begin or to continue."""
        for _event in range(2):
            call = self.draw.choice(list(CALLS))
            number = self.draw.randint(1, CALLS[call])
            event = self.draw.choice([self.fault, self.pause, self.robot.die])
            self.events.append(f"{event.__name__} before {call} {number}")
            self.robot.calls.at(call, number, event)

    def fault(self):
        device, fault = self.draw.choice(FAULTS)
        count = self.draw.randint(0, 2) if device == "vna" else 0
        self.events.append(f"{device} {fault} {count}")
        self.world.fault(fault, device=device, count=count)

    def pause(self):
        try:
            self.robot.control.pause()
        except RequestRefusedError:
            self.events.append("refused")

    def run(self):
        self.plan()
        survey_id = self.robot.begin()
        for stretch in range(STRETCHES):
            if self.await_end() is SurveyState.FINISHED:
                return
            self.mend()
            if stretch < STRETCHES - 1:
                self.plan()
            if any(self.world.data.glob(f"*_{survey_id[:8]}/survey.json")):
                self.robot.go_on(Accepted(zeros=True), survey_id)
            else:
                # It ended before it was opened.
                assert not self.world.acknowledged
                survey_id = self.robot.begin()
        assert self.await_end() is SurveyState.FINISHED, self.robot.status.status.message

    def await_end(self):
        """Return the state in which the survey ends or pauses; of a killed robot, None."""
        robot = self.robot
        robot.wait(lambda: robot.calls.killed.is_set() or robot.ended)
        return None if robot.calls.killed.is_set() else robot.status.status.state

    def mend(self):
        """Switch every fault off, and replace a robot that was killed."""
        self.robot.calls.forget_plans()
        for device in ("vna", "adc", "endstop_x", "endstop_y"):
            self.world.fault("NONE", device=device)
        if self.robot.calls.killed.is_set():
            self.events.append(f"killed with {len(self.world.acknowledged)} traces")
            self.robot = self.robot.kill()


@pytest.mark.parametrize("number", range(12))
def test_no_acknowledged_trace_of_a_drawn_survey_is_lost_doubled_or_misplaced(tmp_path, number):
    world = World(tmp_path)
    course = Course(world, random.Random(f"{SEED} {number}"))
    try:
        course.run()
        check_complete(course.robot)
        check_acknowledged(course.robot, world.acknowledged)
    finally:
        print(*course.events, sep="\n")
        course.robot.close()
        world.close()
