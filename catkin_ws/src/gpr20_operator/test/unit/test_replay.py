"""A replay never looks like a robot, and never hides one."""

import contextlib
from dataclasses import replace

import pytest

pytest.importorskip("rospy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as some
from topics_kit import Graph

from gpr20_common.message import verbatim
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth
from gpr20_msgs.msg import ControlStatus, Coordinates, CurrentCoordinate, SurveyData
from gpr20_msgs.msg import Replay as ReplayMessage
from gpr20_operator.high import ros_events
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.events import (
    ControlState,
    Progress,
    Replay,
    ReplayPhase,
    Request,
    Senders,
)
from gpr20_operator.robot.survey_model import ReplayModel, SurveyModel
from gpr20_survey.plan.survey_state import SurveyState

# `rosbag play`, replay.launch, a window, and nodes of other robots.
OTHERS = (
    *("/play_1795334095431", "/replay/replay", "/user_interface", "/some_player"),
    *("/robot2/main_control", "/replay/main_control", "/main_control_", "main_control"),
)
MARK = Replay("id", "2026-11-22T07:53:11.859801+00:00", "20261122T075311_58860593")
SURVEY = f"Survey of 2026-11-22 07:53 UTC, {MARK.folder}"


@contextlib.contextmanager
def listening(replay=False, namespace="/", count=1):
    """Give clients that listen as (graph, events that it passes on), and their clock."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        clock = FakeClock()
        monkeypatch.setattr(ros_events, "Clock", lambda: clock)
        monkeypatch.setattr(ros_events, "in_background", lambda work: work())
        found = []
        for _ in range(count):
            graph, events = Graph(), []
            monkeypatch.setattr(ros_events.rospy, "Subscriber", graph.subscriber)
            client = ControlClient(events.append, Senders(namespace, replay))
            client.listen()
            client.set_watched(True)
            found.append((graph, events))
        yield (*found, clock)


def report(name, level=DiagnosticStatus.OK):
    return DiagnosticArray(status=[DiagnosticStatus(name=f"{name}: state", level=level)])


def message(kind, number):
    """Return the topic and a message of a survey that anybody could send."""
    survey = f"survey {number % 3}"
    return {
        "state": (
            "control_status",
            ControlStatus(code=number % len(SurveyState), survey_id=survey),
        ),
        "progress": ("control_survey_data", SurveyData(survey_id=survey, visited_points=number)),
        "place": ("control_current_coordinate", Coordinates(x_mm=number)),
        "axis": ("x_axis/current_coord", CurrentCoordinate(moving=bool(number % 2))),
        "health": ("/diagnostics", report(EXPECTED_NODES[number % 3], number % 3)),
        "mark": ("replay", ReplayMessage(survey_id=survey)),
    }[kind]


KINDS = some.sampled_from(("state", "progress", "place", "axis", "health", "mark"))
SENDERS = some.sampled_from(("/main_control", "/x_axis/axis_driver", "/simulator", *OTHERS))
STEPS = some.lists(
    some.tuples(SENDERS, KINDS, some.integers(0, 50), some.sampled_from((0.0, 0.1, 1.0, 4.0))),
    max_size=40,
)


@given(steps=STEPS)
def test_nothing_that_a_player_sends_changes_what_is_shown_of_a_robot(steps):
    with listening(count=2) as ((graph, events), (graph_without, events_without), clock):
        model, model_without = SurveyModel(clock), SurveyModel(clock)
        for sender, kind, number, pause_s in steps:
            clock.advance(pause_s)
            graph.send(sender, *message(kind, number))
            if sender not in OTHERS:
                graph_without.send(sender, *message(kind, number))
            for one, queue in ((model, events), (model_without, events_without)):
                while queue:
                    one.handle(queue.pop(0))
            shown, without = model.snapshot(), model_without.snapshot()
            assert shown.replay is None
            assert shown == without


def test_on_the_topic_of_all_robots_only_who_speaks_for_this_one_is_reported():
    with listening(namespace="/robot1/") as ((graph, events), _clock):
        for sender, node in (
            *(("/user_interface",) * 2, ("/robot2/main_control",) * 2),
            *(("/robot1/user_interface",) * 2, ("/play_1", "/robot1/main_control")),
            ("/robot1/main_control", "/robot1/main_control"),
            ("/robot1/main_control", "/robot1/sensors/soil"),
        ):
            graph.send(sender, "/diagnostics", report(node))
        assert [one.name for one in events] == ["main_control", "sensors/soil"]


def test_a_window_of_a_replay_shows_nothing_of_a_robot_on_the_same_topics():
    with listening(replay=True) as ((graph, events), _clock):
        for node in (*EXPECTED_NODES, "simulator"):
            for kind in ("state", "progress", "place", "axis", "mark"):
                graph.send(f"/{node}", *message(kind, 1))
        assert events == []
        graph.send("/play_1", *message("state", 4))
        assert [one.survey_id for one in events] == ["survey 1"]


def state(code, survey_id="id"):
    return ControlState(SurveyState(code), verbatim("as it is"), survey_id, False)


def progress(survey_id="id"):
    return Progress(survey_id, 50.0, 18, 9, 30.0)


def assert_harmless(snapshot):
    """A replay offers no request to a robot and raises no alarm."""
    assert snapshot.replay is not None
    assert condition_of(snapshot).level is JobLevel.REPLAY
    assert not (snapshot.can_start or snapshot.can_pause or snapshot.can_resume)
    assert snapshot.fields_locked


def played(*events):
    model = ReplayModel()
    for event in events:
        model.handle(event)
    return model


def test_a_window_of_a_replay_is_one_before_anything_is_played_and_in_every_state():
    model = played(NodeHealth("main_control", HealthLevel.ERROR, verbatim("it burns"), {}))
    model.request_sent(Request.STOP)
    snapshot = model.snapshot()
    assert_harmless(snapshot)
    assert snapshot.replay.message and not snapshot.pending and not snapshot.simulated
    for code in SurveyState:
        model = played(MARK, state(code), progress())
        assert_harmless(model.snapshot())
        model.handle(replace(MARK, phase=ReplayPhase.PAUSED, rate=2.0))
        assert str(model.snapshot().replay.title) == "REPLAY PAUSED"
        assert_harmless(model.snapshot())


def test_the_end_of_a_replay_names_the_end_of_the_survey():
    cut_off = "SURVEYING, and the recording does not contain the survey's end"
    ended = replace(MARK, phase=ReplayPhase.ENDED, rate=1.0)
    for code, mark, title, text in (
        (SurveyState.SURVEYING, MARK, "REPLAY", "SURVEYING"),
        (SurveyState.SURVEYING, ended, "REPLAY ENDED", cut_off),
        (SurveyState.FINISHED, ended, "REPLAY ENDED", "FINISHED"),
        # The player of `rosbag play` does not report.
        (SurveyState.FINISHED, MARK, "REPLAY ENDED", "FINISHED"),
    ):
        view = played(mark, state(code)).snapshot().replay
        assert (str(view.title), str(view.message)) == (title, f"{text}. {SURVEY}")


def test_another_survey_shows_nothing_of_the_one_before():
    model = played(MARK, state(SurveyState.FINISHED), progress("other"))
    assert model.snapshot().state is None
    assert model.snapshot().replay == Replay("other")
