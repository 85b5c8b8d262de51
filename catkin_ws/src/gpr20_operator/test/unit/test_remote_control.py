"""START and RESUME from the web page: allowed by one hold, ended by everything else."""

import math
from dataclasses import replace

import pytest

pytest.importorskip("rospy")

from annotation_examples import annotations
from case_kit import each_case
from fake_clock import FakeClock
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from topics_kit import Graph
from view_kit import snapshot, state_of

from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.message import verbatim
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.high import control_client as topics
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.texts import remote_question
from gpr20_operator.robot.events import Replay, StartPlan
from gpr20_operator.robot.remote_control import (
    REMOTE_LIMIT_S,
    SILENCE_S,
    Arming,
    RemoteAllowance,
    RemoteArmed,
    WebStatusReported,
    remote_obstacle,
)
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.survey_state import SurveyState

PLAN = StartPlan(default_parameters(), EMPTY, "", 4.0)
WEB = WebStatusReported("192.168.1.10", 8443, "AB12 CD34", 3, "Ana")
WELL = snapshot(SurveyState.CONFIGURED)
FAULT = snapshot(SurveyState.PAUSED, state=state_of(SurveyState.PAUSED, "the VNA is silent"))
OTHER_FAULT = snapshot(SurveyState.FAILED, state=state_of(SurveyState.FAILED, "the disk is full"))
FORBIDDING = {
    "no contact": snapshot(SurveyState.IDLE, alive=False),
    "no master": snapshot(SurveyState.IDLE, master_alive=False),
    "control restarted": snapshot(SurveyState.IDLE, interrupted=True),
    "foreign motion": snapshot(
        SurveyState.IDLE, axes=(AxisReport(AxisId.X, 0.0, True, True, "/other", 0.0),)
    ),
    "service": snapshot(SurveyState.IDLE, service=verbatim("moving the X axis")),
    "replay": snapshot(SurveyState.IDLE, replay=Replay()),
}
ENDING = {"fault": FAULT, "other fault": OTHER_FAULT, **FORBIDDING}


class Window:
    """The window's side, with what it sends."""

    def __init__(self):
        self.clock, self.sent = FakeClock(), []
        self.arming = Arming(self.clock, self.sent.append)
        self.note(WELL)

    def note(self, shown, plan=PLAN):
        self.arming.note(shown, plan)


def test_a_hold_allows_it_for_ten_minutes_and_says_so_every_second():
    window = Window()
    assert window.sent == [RemoteArmed(False, 0.0, PLAN)]
    window.arming.arm(WELL)
    assert window.sent[-1] == RemoteArmed(True, REMOTE_LIMIT_S, PLAN)
    # As the window's refreshes do.
    for _ in range(round(REMOTE_LIMIT_S / 0.2) + 20):
        window.clock.advance(0.2)
        window.note(WELL)
    said = [one.armed for one in window.sent]
    assert said.count(True) == pytest.approx(600, rel=0.01) and said.count(False) == 2
    # A touch ends it at once.
    window.arming.arm(WELL)
    window.arming.touched()
    assert not window.arming.armed and [one.armed for one in window.sent[-2:]] == [True, False]
    window.sent.clear()
    # Another plan is sent at once.
    plan = replace(PLAN, permittivity=9.0)
    for shown_plan in (plan, plan, None):
        window.note(WELL, shown_plan)
    assert [one.plan for one in window.sent] == [plan, None]


@each_case("reason", ENDING)
def test_a_hold_is_not_offered_where_something_forbids_it_and_is_ended_by_that(reason):
    window, shown = Window(), ENDING[reason]
    window.arming.arm(WELL)
    for now in (shown, WELL):
        window.note(now)
        assert not window.arming.armed
    # Whoever holds it now has seen the fault: so a survey that it has paused is resumed.
    window.note(shown)
    for act in (window.arming.arm, window.note):
        act(shown)
        assert window.arming.armed is (reason not in FORBIDDING)
    assert reason not in FORBIDDING or remote_question(WEB, remote_obstacle(shown)).hold is None


def test_the_page_believes_only_what_is_fresh(clock):
    web = RemoteAllowance(clock)
    web.on_event(RemoteArmed(True, REMOTE_LIMIT_S, PLAN))
    assert not web.armed, "of a robot that it knows nothing of"
    web.note(WELL)
    assert web.armed and web.obstacle is None and web.plan == PLAN
    clock.advance(SILENCE_S)
    assert web.armed and web.remaining_s == REMOTE_LIMIT_S - SILENCE_S
    clock.advance(0.1)
    assert not web.armed and web.remaining_s == 0.0
    # A fault ends it until the next hold, whatever the window still says.
    web.note(FAULT)
    web.on_event(RemoteArmed(True, 500.0, PLAN))
    web.note(WELL)
    assert not web.armed
    for message in (RemoteArmed(False), RemoteArmed(True, REMOTE_LIMIT_S, PLAN)):
        web.on_event(message)
        assert web.armed is message.armed


ACTIONS = st.one_of(
    st.sampled_from(["hold", "touch", "lost", "well", "surveying", *ENDING]),
    st.floats(0.0, 700.0),
)


@settings(max_examples=draws(100))
@given(st.lists(ACTIONS, max_size=60))
def test_the_page_never_allows_what_the_window_does_not(actions):
    """Messages may be lost, time passes as it likes: the page lags by the silence at most."""
    window = Window()
    page = RemoteAllowance(window.clock)
    shown, lost, held_s, ended = WELL, False, -math.inf, True
    page.note(shown)
    for action in actions:
        window.sent.clear()
        if isinstance(action, float):
            window.clock.advance(action)
            lost = False
        elif action == "lost":
            lost = True
        elif action == "hold":
            window.arming.arm(shown)
            held_s, ended = window.clock.now_s(), remote_obstacle(shown) is not None
        elif action == "touch":
            window.arming.touched()
            ended = True
        else:
            before = shown
            shown = {"well": WELL, "surveying": snapshot(SurveyState.SURVEYING), **ENDING}[action]
            changed = shown.state != before.state and shown.state.is_fault
            ended = ended or changed or remote_obstacle(shown) is not None
        window.note(shown)
        page.note(shown)
        if not lost:
            for message in window.sent:
                page.on_event(message)
        over = window.clock.now_s() - held_s >= REMOTE_LIMIT_S
        assert window.arming.armed is not (ended or over)
        if page.armed:
            assert remote_obstacle(shown) is None
            assert lost or window.arming.armed
            assert window.clock.now_s() - held_s <= REMOTE_LIMIT_S + SILENCE_S


@given(annotations, st.booleans())
def test_the_message_of_the_window_arrives_as_it_was_sent(annotation, armed):
    plan = StartPlan(default_parameters(), replace(annotation, heading_deg=None), "an id", 4.5)
    for event in (RemoteArmed(armed, 12.25, plan), RemoteArmed(armed, 0.0, None)):
        message = topics.remote_message(event)
        assert topics.remote_armed(deserialized(type(message), serialized(message))) == event


def test_the_page_takes_no_message_of_another_node(monkeypatch):
    graph, events = Graph(), []
    monkeypatch.setattr(topics.rospy, "Subscriber", graph.subscriber)
    monkeypatch.setattr(topics.rospy, "logwarn", print)
    topics.RemoteControlClient(events.append, "/").listen()
    message = topics.RemoteControl(armed=True, remaining=topics.rospy.Duration(600))
    for sender in ("/main_control", "/web", "/robot1/user_interface", "/user_interface"):
        graph.send(sender, "remote_control", message)
    assert [one for one in events if isinstance(one, RemoteArmed)] == [RemoteArmed(True, 600.0)]
