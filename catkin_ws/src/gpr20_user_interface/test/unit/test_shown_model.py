"""A replay never looks like a robot, and never hides one."""

import itertools
import os
import random
from dataclasses import replace

import pytest

from gpr20_common.message import verbatim
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisPosition
from gpr20_operator.robot.events import Answer, AxisLimits, ControlState, Progress, Request
from gpr20_operator.robot.message_source import MessageSources, Received, SourceGone
from gpr20_operator.robot.replay import ReplayMark, ReplayPhase
from gpr20_operator.robot.service_events import AxisMeasured
from gpr20_operator.robot.shown_model import ROBOT_LIMIT_S, ShownModel
from gpr20_operator.robot.survey_model import CONTROL_SILENCE_S, SurveyModel
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import RUNNING, SurveyState

SEQUENCES = int(os.environ.get("GPR20_REPLAY_SEQUENCES", "150"))
SEED = os.environ.get("GPR20_REPLAY_SEED") or str(random.SystemRandom().randrange(10**9))
STEPS = 60

CONTROL, AXIS = "/main_control", "/x_axis/axis_driver"
# A player without a name that says so, which sends its mark at any moment.
ROSBAG, REPLAY, PLAYER = "/play_1795334095", "/replay", "/some_player"
MARK = ReplayMark("id", "2026-11-22T07:53:11.859801+00:00", "20261122T075311_58860593")


def state(code, survey_id="id"):
    return ControlState(SurveyState(code), verbatim("as it is"), survey_id, False)


def progress(survey_id="id"):
    return Progress(survey_id, 50.0, 18, 9, 30.0)


@pytest.fixture
def model(clock):
    return new_model(clock)


def new_model(clock):
    return ShownModel(clock, MessageSources(CONTROL), SurveyModel(clock))


def assert_harmless(snapshot):
    """A replay offers no request to a robot and raises no alarm."""
    assert snapshot.replay is not None
    assert snapshot.alarm is None
    offers = (snapshot.can_start, snapshot.can_pause, snapshot.can_resume)
    assert not any(offers)
    assert snapshot.fields_locked


def test_the_status_of_a_player_is_a_replay_for_as_long_as_it_is_shown(clock):
    for code, source in itertools.product(SurveyState, (ROSBAG, REPLAY)):
        model = new_model(clock)
        if source == REPLAY:
            model.handle(Received(source, MARK))
        model.handle(Received(source, state(code)))
        for _ in range(3):
            snapshot = model.snapshot()
            assert_harmless(snapshot)
            assert str(snapshot.state.title) == f"REPLAY: {code.label}"
            clock.advance(1000.0)


def test_a_replay_without_status_shows_that_its_robot_was_simulated(model):
    model.handle(Received(ROSBAG, progress()))
    assert not model.snapshot().simulated
    model.handle(Received(ROSBAG, NodeHealth("simulator", HealthLevel.OK, verbatim("works"), {})))
    assert model.snapshot().replay is not None and model.snapshot().simulated


def test_a_mark_beside_a_robot_does_not_hide_stop(clock):
    for code, marked_by in itertools.product(RUNNING, (ROSBAG, REPLAY, CONTROL)):
        model = new_model(clock)
        model.handle(Received(marked_by, MARK))
        model.handle(Received(CONTROL, state(code)))
        # Also when the main control of that survey is not heard any more.
        for _ in range(5):
            model.handle(Received(marked_by, MARK))
            snapshot = model.snapshot()
            assert snapshot.replay is None, (code, marked_by)
            clock.advance(ROBOT_LIMIT_S)


def test_a_replay_is_shown_once_a_robot_without_survey_has_left(model, clock):
    model.handle(Received(CONTROL, state(SurveyState.IDLE)))
    model.handle(Received(ROSBAG, state(SurveyState.SURVEYING)))
    assert model.snapshot().replay is None
    clock.advance(ROBOT_LIMIT_S + 0.1)
    model.handle(Received(ROSBAG, progress()))
    assert_harmless(model.snapshot())


def test_an_axis_without_main_control_is_a_robot(model):
    model.handle(Received(ROSBAG, state(SurveyState.SURVEYING)))
    axis = NodeHealth("x_axis/axis_driver", HealthLevel.OK, verbatim("homed"), {})
    model.handle(Received(AXIS, axis))
    snapshot = model.snapshot()
    assert snapshot.replay is None and snapshot.alarm is not None


def moves(axis, moving):
    return AxisMeasured(axis, AxisPosition(1.0, True, moving))


def test_a_robot_that_was_left_moving_is_not_hidden_by_a_replay(model, clock):
    model.handle(Received(ROSBAG, state(SurveyState.SURVEYING)))
    model.handle(Received(AXIS, moves(AxisId.X, True)))
    clock.advance(100.0 * ROBOT_LIMIT_S)
    assert model.snapshot().replay is None
    model.handle(Received(AXIS, moves(AxisId.X, False)))
    clock.advance(ROBOT_LIMIT_S + 0.1)
    assert_harmless(model.snapshot())


def test_only_its_own_driver_says_that_an_axis_rests(model):
    model.handle(Received(AXIS, moves(AxisId.X, True)))
    for source in (ROSBAG, PLAYER, "/y_axis/axis_driver", "/robot2/x_axis/axis_driver"):
        model.handle(Received(source, moves(AxisId.X, False)))
        assert [one.axis for one in model.snapshot().moving] == [AxisId.X], source


def test_a_player_that_is_recognized_late_leaves_nothing_in_the_robot(model, clock):
    model.handle(Received(CONTROL, state(SurveyState.IDLE, "robot")))
    model.handle(Received(PLAYER, state(SurveyState.SURVEYING, "recorded")))
    model.handle(Received(PLAYER, ReplayMark("recorded")))
    snapshot = model.snapshot()
    assert (snapshot.replay, snapshot.state.survey_id) == (None, "robot")
    clock.advance(ROBOT_LIMIT_S + 0.1)
    assert model.snapshot().state.survey_id == "recorded"


def test_the_end_of_a_replay_names_the_end_of_the_survey(clock):
    survey = f"Survey of 2026-11-22 07:53 UTC, {MARK.folder}"
    cut_off = "SURVEYING, and the recording does not contain the survey's end"
    gone = SourceGone(REPLAY)
    marked = Received(REPLAY, replace(MARK, phase=ReplayPhase.ENDED, rate=1.0))
    for code, end, text in (
        (SurveyState.SURVEYING, None, "SURVEYING"),
        *((SurveyState.FINISHED, end, "FINISHED") for end in (gone, marked)),
        *((SurveyState.SURVEYING, end, cut_off) for end in (gone, marked)),
    ):
        model = new_model(clock)
        model.handle(Received(REPLAY, MARK))
        model.handle(Received(REPLAY, state(code)))
        if end is not None:
            model.handle(end)
        snapshot = model.snapshot()
        assert_harmless(snapshot)
        assert str(snapshot.replay.title) == ("REPLAY ENDED" if end else "REPLAY")
        assert str(snapshot.replay.message) == f"{text}. {survey}"
        assert not (end and snapshot.replay.can_pause)


def test_a_player_that_begins_again_shows_nothing_of_its_former_replay(model):
    model.handle(Received(ROSBAG, state(SurveyState.FINISHED)))
    model.handle(SourceGone(ROSBAG))
    model.handle(Received(ROSBAG, progress("other")))
    snapshot = model.snapshot()
    assert snapshot.state is None and not snapshot.replay.ended


def test_a_message_in_flight_when_its_player_ended_begins_no_other_replay(model):
    model.handle(Received(REPLAY, state(SurveyState.FINISHED)))
    model.handle(SourceGone(REPLAY))
    model.handle(Received(REPLAY, MARK))
    model.handle(SourceGone(REPLAY))
    view = model.snapshot().replay
    assert (view.ended, view.state, view.mark) == (True, SurveyState.FINISHED, MARK)


class Oracle:
    """What an operator knows who sees the senders."""

    def __init__(self, clock):
        self._clock = clock
        self.marked = {ROSBAG, REPLAY}
        self.last = {}
        self.heard_s = {}
        self.asked = False

    def note(self, source, event):
        if isinstance(event, ReplayMark):
            if source != CONTROL:
                self.marked.add(source)
            return
        self.heard_s[source] = self._clock.now_s()
        if isinstance(event, ControlState):
            self.last[source] = event

    def robots(self):
        return [source for source in self.heard_s if source not in self.marked]

    def check(self, snapshot):
        now_s = self._clock.now_s()
        control = self.last.get(CONTROL)
        heard = now_s - self.heard_s.get(CONTROL, -1e9) <= CONTROL_SILENCE_S
        if heard:
            assert snapshot.replay is None
        if CONTROL in self.heard_s and snapshot.replay is None:
            assert snapshot.state == control
        replays = [source for source in self.heard_s if source in self.marked]
        if not self.robots() and not self.asked and replays:
            assert_harmless(snapshot)
        if snapshot.replay is not None:
            assert_harmless(snapshot)


def draw(numbers):
    source = numbers.choice([CONTROL, ROSBAG, REPLAY, PLAYER])
    kind = numbers.choice(["state", "progress", "mark", "axis", "gone", "master", "wait", "answer"])
    if kind == "state":
        return Received(source, state(numbers.choice(list(SurveyState)), source))
    if kind == "progress":
        return Received(source, progress(source))
    if kind == "mark":
        return Received(source, MARK)
    if kind == "axis":
        axis = NodeHealth("x_axis/axis_driver", HealthLevel.OK, verbatim("homed"), {})
        return Received(numbers.choice([AXIS, ROSBAG]), axis)
    if kind == "gone":
        return SourceGone(source)
    if kind == "master":
        return AxisLimits(None, master_alive=numbers.random() < 0.5)
    if kind == "answer":
        return Answer(Request.STOP, True, verbatim("stopping"))
    return numbers.choice([0.1, 2.0, 5.0, 30.0])


def test_stop_is_there_for_every_robot_and_for_no_replay(clock):
    for number in range(SEQUENCES):
        numbers = random.Random(f"{SEED} {number}")
        # Without a robot in every second sequence.
        alone = number % 2
        model, oracle = new_model(clock), Oracle(clock)
        for step in range(STEPS):
            event = draw(numbers)
            if isinstance(event, float):
                clock.advance(event)
            elif alone and isinstance(event, Received) and event.source in (CONTROL, AXIS):
                continue
            else:
                model.handle(event)
                if isinstance(event, Received):
                    oracle.note(event.source, event.event)
            if numbers.random() < 0.02:
                model.request_sent(Request.STOP)
                oracle.asked = True
            try:
                oracle.check(model.snapshot())
            except AssertionError as error:
                where = f"GPR20_REPLAY_SEED={SEED} sequence {number} step {step}: {event}"
                raise AssertionError(where) from error
