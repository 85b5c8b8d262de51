"""Random requests, failures and measurements: every transition is legal, nothing is lost."""

import threading
import time
from dataclasses import replace

import pytest
from fake_robot import LIMIT_S, NODES, Bench, FakeAnalyzer, folder_of, reports
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from run_seed import draws
from survey_examples import PARAMETERS, TRAVEL

from gpr20_common.message import Message
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.plan.survey_state import ENDED, RUNNING, TRANSITIONS
from gpr20_survey.plan.survey_state import SurveyState as State

SMALL = replace(PARAMETERS, y_points=3, polarizations_deg=(0.0,))
PLAN = survey_points(SMALL, TRAVEL)
# A pause on request, one for a fault that was fixed meanwhile, and one more.
MOST_PAUSES = 4
MEASURING = (State.SURVEYING, State.PAUSING)


class GatedAnalyzer(FakeAnalyzer):
    """An analyzer whose sweeps end when the test lets them."""

    def __init__(self):
        super().__init__()
        self.changed = threading.Condition()
        self.waiting = None
        self.granted = None

    def sweep(self):
        if not self.failures:
            ticket = object()
            with self.changed:
                self.waiting = ticket
                assert self.changed.wait_for(
                    lambda: self.granted is ticket or self.waiting is not ticket, LIMIT_S
                )
                if self.granted is not ticket:
                    raise DeviceError(Message("this sweep was given up"))
        return super().sweep()

    def grant(self):
        """Let the sweep that waits end."""
        with self.changed:
            self.granted, self.waiting = self.waiting, None
            self.changed.notify_all()

    def abandon(self):
        """Let a sweep that was given up fail."""
        with self.changed:
            self.waiting = None
            self.changed.notify_all()


class SurveyMachine(RuleBasedStateMachine):
    """Steps on a main control over a fake robot; after each, it is at rest or waits for a sweep.

    The drawn values never depend on the state; a step that the state does not allow does nothing.
    """

    def __init__(self):
        super().__init__()
        self.analyzer = GatedAnalyzer()
        self.bench = Bench(analyzer=self.analyzer, return_limit_s=3600.0)
        self.storage = self.bench.storage
        self.control, self.nodes = self.bench.control, self.bench.nodes
        self.configured = False
        # STOP at rest: what was set before it is not started after it.
        self.stopped_since = False
        self.process = 1
        self.stored_before = {}

    def teardown(self):
        self.storage.broken = False
        if self.state.running:
            self.control.stop()
        self.analyzer.abandon()
        self.control.shut_down(LIMIT_S)

    @property
    def state(self):
        return self.bench.board.status.state

    def settle(self):
        """Wait until only a request or the end of a sweep can change anything."""
        deadline_s = time.monotonic() + LIMIT_S
        while not self.has_settled():
            assert time.monotonic() < deadline_s, f"still {self.bench.board.status}"
            time.sleep(0.0005)
        if self.state not in MEASURING:
            self.analyzer.abandon()

    def has_settled(self):
        state = self.state
        if state in MEASURING:
            return self.analyzer.waiting is not None and (self.storage.broken or self.all_stored())
        if state is State.CHECKING:
            return bool(self.nodes.missing()) and reports(
                self.bench.board.status.message, faults.WAITING_FOR_PART
            )
        return state is State.PAUSED or not state.running

    def all_stored(self):
        """Whether nothing waits for the disk, or it waits for the operator after a failure."""
        status = self.bench.board.status
        queue = self.control._engine._archive.queue
        if queue.waiting and queue._failure is None:
            return False
        return status.visited_points == len(self.storage.stored(status.survey_id))

    def request(self, call, allowed):
        """Make a request, which must be refused with a reason and no effect unless allowed."""
        if allowed:
            call()
        else:
            before, content = self.shown(), self.content()
            with pytest.raises((RequestRefusedError, DeviceError)) as refusal:
                call()
            assert refusal.value.message.cause.remedy is not None
            assert self.shown() == before
            assert self.content() == content
        self.settle()

    def shown(self):
        """The status, without what only says how long a sweep takes that the test holds."""
        return replace(self.bench.board.status, waiting=None)

    def content(self):
        return {one: set(self.storage.stored(one)) for one in self.surveys}

    @property
    def surveys(self):
        return list(dict.fromkeys(one.survey_id for one in self.storage.records))

    @initialize(points=st.integers(-2, 8))
    def begin(self, points):
        """Most examples begin with a survey that measures."""
        if points >= -1:
            self.set_parameters()
        if points >= 0:
            self.start()
            self.measure(points)

    @rule()
    def set_parameters(self):
        allowed = not self.state.running
        self.request(lambda: self.control.set_parameters(SMALL), allowed)
        self.configured = self.configured or allowed
        self.stopped_since = self.stopped_since and not allowed

    @rule()
    def start(self):
        allowed = not self.state.running and self.configured and not self.stopped_since
        self.request(self.control.start, allowed)

    @rule()
    def pause(self):
        self.request(self.control.pause, self.state is State.SURVEYING)

    @rule()
    def stop(self):
        allowed = self.state in RUNNING
        self.request(self.stop_and_wait, allowed)
        self.stopped_since = not allowed

    def stop_and_wait(self):
        self.control.stop()
        self.bench.wait_for(*ENDED)

    @rule()
    def resume(self):
        self.request(lambda: self.control.resume(""), self.state is State.PAUSED)

    @rule(which=st.integers(0, 9), by_folder=st.booleans())
    def resume_by_name(self, which, by_folder):
        if not self.surveys:
            return
        survey_id = self.surveys[which % len(self.surveys)]
        name = folder_of(survey_id) if by_folder else survey_id
        if self.state is State.PAUSED:
            allowed = survey_id == self.bench.board.status.survey_id
        else:
            finished = self.storage.outcomes.get(survey_id) == "finished"
            allowed = not self.state.running and not finished and not self.storage.broken
            self.configured = self.configured or allowed
            self.stopped_since = self.stopped_since and not allowed
        self.request(lambda: self.control.resume(name), allowed)

    @rule()
    def resume_what_does_not_exist(self):
        self.request(lambda: self.control.resume("20200101T000000_01234567"), False)

    @rule(points=st.sampled_from([1, 2, 3, 20]))
    def measure(self, points):
        for _ in range(points):
            if self.state in MEASURING:
                self.analyzer.grant()
                self.settle()

    @rule()
    def repair_and_continue(self):
        """Do what an operator does until the survey measures again, which it must."""
        self.repair()
        if self.state is State.PAUSED:
            self.resume()
        elif not self.state.running and self.configured:
            self.set_parameters()
            self.start()
        assert self.state in (*MEASURING, State.FINISHED) or not self.configured

    @rule()
    def repair_and_measure_to_the_end(self):
        """A survey that is not stopped ends with everything, whatever it has met."""
        for _ in range(MOST_PAUSES):
            self.repair()
            self.measure(len(PLAN) + 1)
            if not self.state.running:
                break
            if self.state is State.PAUSED:
                self.resume()
        assert not self.state.running
        if self.bench.states[-2:-1] in (["SURVEYING"], ["PAUSING"]):
            assert self.state is State.FINISHED

    def repair(self):
        self.storage.broken, self.bench.y.fail_move = False, ""
        if self.state not in MEASURING:
            self.analyzer.failures = 0
        self.nodes_return()

    @rule(failing=st.sampled_from([0, 1, 10**6]))
    def change_analyzer(self, failing):
        if self.state not in MEASURING:
            self.analyzer.failures = failing

    @rule(broken=st.booleans())
    def change_disk(self, broken):
        self.storage.broken = broken
        self.settle()

    @rule(failing=st.booleans())
    def change_y_axis(self, failing):
        self.bench.y.fail_move = "the endstop was pressed" if failing else ""

    @rule()
    def lose_zero(self):
        self.bench.x.homed = False

    @rule(node=st.sampled_from(list(NODES)))
    def node_dies(self, node):
        self.nodes.note_silent(node)
        if node == "vna_processing":
            self.storage.opened = ""
        if node == "x_axis/axis_driver":
            self.bench.x.homed = False
        self.wait_for_hold()
        shown = self.bench.board.status.full_message
        assert reports(shown.values["warning"], faults.NODE_LOST, NODES[node])
        assert node in shown.all_details

    def wait_for_hold(self):
        deadline_s = time.monotonic() + LIMIT_S
        while self.state in MEASURING:
            assert time.monotonic() < deadline_s, f"still {self.bench.board.status}"
            time.sleep(0.0005)
        self.settle()

    @rule()
    def nodes_return(self):
        self.process += 1
        for node in self.nodes.missing():
            self.nodes.note_alive(node, self.process)
        self.settle()

    @invariant()
    def every_step_was_legal(self):
        states = [State.IDLE, *(status.state for status in self.bench.history)]
        for before, after in zip(states, states[1:]):
            assert before is after or after in TRANSITIONS[before]

    @invariant()
    def nothing_is_lost_or_measured_twice(self):
        for survey_id in self.surveys:
            samples = self.storage.stored(survey_id)
            assert self.stored_before.get(survey_id, set()) <= set(samples)
            sweeps = [sample.s21_real[0] for sample in samples.values()]
            assert len(set(sweeps)) == len(sweeps)
            for index, sample in samples.items():
                point = PLAN[index]
                assert (sample.x_coord_mm, sample.y_coord_mm) == (point.x_mm, point.y_mm)
        self.stored_before = self.content()

    @invariant()
    def finished_means_that_everything_is_stored(self):
        status = self.bench.board.status
        if status.state is State.FINISHED:
            assert set(self.storage.stored(status.survey_id)) == set(range(len(PLAN)))
            assert self.storage.outcomes[status.survey_id] == "finished"
        elif status.state in (State.STOPPED, State.PAUSED, State.FAILED):
            assert "complete:" not in str(status.message)

    @invariant()
    def what_is_shown_as_visited_is_stored(self):
        status = self.bench.board.status
        assert status.visited_points <= len(self.storage.stored(status.survey_id))


SurveyMachine.TestCase.settings = settings(max_examples=draws(15), stateful_step_count=30)
TestSurveyMachine = SurveyMachine.TestCase
