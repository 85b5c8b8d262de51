"""Whatever happens to surveys, no acknowledged trace is lost, doubled, misplaced or unmarked."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
import threading
from pathlib import Path

import pytest
from hypothesis import seed, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, rule, run_state_machine_as_test
from robot_in_process import (
    ENDS,
    TRACES,
    RobotInProcess,
    check_acknowledged,
    check_places,
    json_traces,
)
from run_seed import SEED, draws
from simulated_world import LIMIT_S, World

from gpr20_analysis.read.verdict import COMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_axis_driver.faults import AxisException
from gpr20_main_control.errors import SurveyError
from gpr20_main_control.mid.survey.survey import Accepted
from gpr20_survey.axes import AxisId
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.survey_state import SurveyState

# Calls of the control to the parts, before which a survey is held while something happens.
CALLS = ("configure", "home", "move", "height", "sweep", "confirm", "store", "stored", "step x")
OTHER = "/rostopic_7"
LEASE_LIMIT_S = 2.0
FAULTS = [
    *(("vna", one) for one in ("DROP", "HANG", "SILENT", "LATE", "TRUNCATE", "NAN", "GARBAGE")),
    *(("vna", one) for one in ("STALE", "LATE_BIT", "LATE_MEMORY", "SLOW_POINTS", "LINK_GONE")),
    *(("vna", one) for one in ("HAND_BANDWIDTH", "HAND_START")),
    *(("adc", "STUCK"), ("endstop_x", "STUCK_CLOSED"), ("endstop_y", "STUCK_OPEN")),
]
# The n-th of such calls from now on.
MOMENTS = {"call": st.sampled_from(CALLS), "number": st.integers(1, 5)}


class AnyCourse(RuleBasedStateMachine):
    """Surveys of one robot; a rule may come at any moment, and may be refused."""

    def __init__(self):
        super().__init__()
        self.folder = Path(tempfile.mkdtemp())
        self.world = World(self.folder)
        self.robot = RobotInProcess(self.world)
        self.surveys = []
        # How far the zero of z is from the mark of the antennas [deg], since which number of it.
        self.turned_deg = {}
        self.held, self.free = False, threading.Event()
        self.request = threading.Thread()
        self.note_zero()

    # What people and programs do, each at some moment of the survey.

    @rule(accept=st.booleans(), another=st.booleans(), **MOMENTS)
    def begin_or_go_on(self, accept, another, call, number):
        for device in ("vna", "adc", "endstop_x", "endstop_y"):
            self.world.fault("NONE", device=device)
        self.run_to(call, number, accept, another)

    @rule(**MOMENTS)
    def pause(self, call, number):
        self.run_to(call, number)
        with contextlib.suppress(SurveyError):
            self.robot.control.pause()

    @rule(**MOMENTS)
    def stop(self, call, number):
        self.run_to(call, number)
        with contextlib.suppress(SurveyError):
            self.robot.control.stop()

    @rule(chosen=st.sampled_from(FAULTS), count=st.integers(0, 2), **MOMENTS)
    def fail(self, chosen, count, call, number):
        self.run_to(call, number)
        device, fault = chosen
        self.world.fault(fault, device=device, count=count if device == "vna" else 0)

    @rule(**MOMENTS)
    def crash(self, call, number):
        self.run_to(call, number)
        self.robot.die()
        self.let_go()
        self.robot = self.robot.kill()

    @rule(
        axis=st.sampled_from(list(AxisId)),
        action=st.sampled_from(["home", "zero", "zero", "move"]),
        frozen=st.booleans(),
        **MOMENTS,
    )
    def let_another_node_move(self, axis, action, frozen, call, number):
        """Ask an axis as another node does, perhaps while the control is frozen."""
        self.run_to(call, number)
        if frozen:
            self.robot.calls.frozen_s += LEASE_LIMIT_S + 1.0
        part = self.robot.axes[axis]
        with contextlib.suppress(AxisException), part.ownership.use(OTHER):
            if action == "zero":
                part.driver.set_zero()
                self.note_zero()
            elif action == "home":
                part.driver.homing()
            else:
                part.driver.move_to_coordinate(1.8)

    @property
    def unfinished(self):
        """The survey that was begun last, if it is on the disk and has not finished."""
        last = self.surveys[-1] if self.surveys else ""
        folder = self.find(last)
        if folder is None or read_description(folder)["outcome"] == "finished":
            return ""
        return last

    def find(self, survey_id):
        found = list(self.world.data.glob(f"*_{survey_id[:8]}/log.jsonl")) if survey_id else []
        return found[0].parent if found else None

    def note_zero(self):
        number = self.robot.axes[AxisId.Z].driver.position.zero.number
        self.turned_deg[number] = self.world.position().rotation_deg

    def turn_of_zero_deg(self, number):
        # A homing of z turns it to the zero that was set last.
        return self.turned_deg[max(one for one in self.turned_deg if one <= number)]

    # How the survey is held.

    def run_to(self, call, number, accept=False, another=False):
        """Let the survey run to a moment; begin one, or continue it, if none runs."""
        self.robot.calls.forget_plans()
        # A thread that is not held may come to the moment as soon as it is planned.
        free, self.free, self.held = self.free, threading.Event(), False
        self.robot.calls.at(call, 20 * number if call == "step x" else number, self.hold)
        free.set()
        if not self.status.state.running or self.status.state is SurveyState.PAUSED:
            self.request = threading.Thread(target=self.ask, args=(accept, another))
            self.request.start()
        self.wait()

    def ask(self, accept, another):
        control, accepted = self.robot.control, Accepted(zeros=accept)
        with contextlib.suppress(SurveyError):
            if self.status.state is SurveyState.PAUSED:
                control.resume("", accepted)
            elif self.unfinished and not another:
                control.resume(self.unfinished, accepted)
            elif self.status.state is not SurveyState.FINISHED or another:
                self.surveys.append(self.robot.begin())
        self.robot.look()

    @property
    def status(self):
        return self.robot.status.status

    def hold(self):
        free, self.held = self.free, True
        self.robot.look()
        # That of this moment: who sees that it is held replaces it.
        assert free.wait(LIMIT_S)

    def let_go(self):
        free, self.free, self.held = self.free, threading.Event(), False
        free.set()

    def wait(self):
        """Wait until the survey is held, or rests."""
        states = (*ENDS, SurveyState.IDLE)
        self.robot.wait(
            lambda: self.held or (not self.request.is_alive() and self.status.state in states)
        )

    # What must be true in the end.

    def teardown(self):
        try:
            self.finish()
            for survey_id in self.surveys:
                self.check(survey_id)
        finally:
            self.let_go()
            self.robot.close()
            shutil.rmtree(str(self.folder))

    def finish(self):
        for _attempt in range(4):
            self.begin_or_go_on(True, False, "never", 1)
            if self.status.state is SurveyState.FINISHED:
                return
        pytest.fail(f"the survey does not end: {self.status.message}")

    def check(self, survey_id):
        acknowledged = [one for one in self.world.acknowledged if one.survey_id == survey_id]
        folder = self.find(survey_id)
        if folder is None:
            assert not acknowledged
            return
        stored = json_traces(self.robot, survey_id)
        if survey_id == self.surveys[-1]:
            assert [one["index"] for one in stored] == list(range(TRACES))
        found = verify_survey(folder)
        unproven = [one for one in stored if "not proven" in " ".join(one["quality"])]
        assert not found.faults and found.unproven == len(unproven)
        assert found.status == COMPLETE or unproven or len(stored) < TRACES
        turned_deg = [self.turn_of_zero_deg(one["zero_epochs"][2]) for one in stored]
        check_places(stored, turned_deg)
        for one, angle_deg in zip(stored, turned_deg):
            assert angle_deg == turned_deg[0] or one in unproven, "not marked"
        check_acknowledged(self.robot, acknowledged, survey_id)


@pytest.mark.parametrize("number", range(draws(10)))
def test_no_acknowledged_trace_is_lost_doubled_misplaced_or_unmarked(number):
    # Of one run with many examples most would be variations of few.
    seed(f"{SEED} {number}")(AnyCourse)
    run_state_machine_as_test(AnyCourse, settings=settings(max_examples=3, stateful_step_count=7))
