"""A replay never looks like a robot, and never hides one."""

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
    SenderIgnored,
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


@pytest.fixture
def patched(monkeypatch):
    """Replace what needs a graph; return the clock of the clients."""
    clock = FakeClock()
    monkeypatch.setattr(ros_events, "Clock", lambda: clock)
    return monkeypatch, clock


def listening(patched, replay=False, namespace="/"):
    """Return a client that listens, its graph, and the events that it passes on."""
    monkeypatch, _clock = patched
    graph, events = Graph(), []
    monkeypatch.setattr(ros_events.rospy, "Subscriber", graph.subscriber)
    monkeypatch.setattr(ros_events, "in_background", lambda work: work())
    client = ControlClient(events.append, Senders(namespace, replay))
    client.listen()
    client.set_watched(True)
    return client, graph, events


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
    with pytest.MonkeyPatch.context() as monkeypatch:
        clock = FakeClock()
        monkeypatch.setattr(ros_events, "Clock", lambda: clock)
        _, graph, events = listening((monkeypatch, clock))
        _, graph_without, events_without = listening((monkeypatch, clock))
        model, model_without = SurveyModel(clock), SurveyModel(clock)
        heard = []
        for sender, kind, number, pause_s in steps:
            clock.advance(pause_s)
            graph.send(sender, *message(kind, number))
            if sender not in OTHERS:
                graph_without.send(sender, *message(kind, number))
            else:
                heard.append((clock.now_s(), sender))
            for one, queue in ((model, events), (model_without, events_without)):
                while queue:
                    one.handle(queue.pop(0))
            shown, without = model.snapshot(), model_without.snapshot()
            assert shown.replay is None
            assert replace(shown, ignored_sender="") == without
            # Reports on /diagnostics about other things are usual.
            recent = {by for at, by in heard if clock.now_s() - at <= 4.0}
            assert shown.ignored_sender in {"", *recent}


def test_a_player_on_the_topics_of_a_robot_is_named_in_the_band_and_logged_once(patched, caplog):
    _, graph, events = listening(patched)
    clock, model = patched[1], SurveyModel(patched[1])
    for _ in range(30):
        graph.send("/main_control", *message("state", int(SurveyState.SURVEYING)))
        graph.send("/play_1", *message("state", int(SurveyState.PAUSED)))
        clock.advance(0.1)
    ignored = [one for one in events if isinstance(one, SenderIgnored)]
    # Not one event for each message.
    assert 2 <= len(ignored) <= 4 and set(ignored) == {SenderIgnored("/play_1")}
    for event in events:
        model.handle(event)
    shown = model.snapshot()
    condition = condition_of(shown)
    assert condition.level is JobLevel.ATTENTION and str(condition.title) == "SURVEYING"
    assert condition.message.fault_code == "window.replay"
    assert shown.can_pause
    clock.advance(3.5)
    graph.send("/main_control", *message("state", int(SurveyState.SURVEYING)))
    model.handle(events[-1])
    assert condition_of(model.snapshot()).message.fault_code != "window.replay"
    logged = [one for one in caplog.records if "/play_1" in one.getMessage()]
    assert len(logged) == 1


def test_on_the_topic_of_all_robots_only_who_speaks_for_this_one_is_reported(patched):
    _, graph, events = listening(patched, namespace="/robot1/")
    graph.send("/user_interface", "/diagnostics", report("/user_interface"))
    graph.send("/robot2/main_control", "/diagnostics", report("/robot2/main_control"))
    graph.send("/robot1/user_interface", "/diagnostics", report("/robot1/user_interface"))
    assert events == []
    graph.send("/robot1/main_control", "/diagnostics", report("/robot1/main_control"))
    graph.send("/robot1/main_control", "/diagnostics", report("/robot1/sensors/soil"))
    assert [one.name for one in events] == ["main_control", "sensors/soil"]
    graph.send("/play_1", "/diagnostics", report("/robot1/main_control"))
    assert len(events) == 2


def test_a_window_of_a_replay_shows_nothing_of_a_robot_on_the_same_topics(patched):
    _, graph, events = listening(patched, replay=True)
    robot = [f"/{node}" for node in (*EXPECTED_NODES, "simulator")]
    for sender in robot:
        for kind in ("state", "progress", "place", "axis", "mark"):
            graph.send(sender, *message(kind, 1))
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
        # The player of `rosbag play` takes no requests.
        assert not model.snapshot().replay.can_pause
        model.handle(replace(MARK, phase=ReplayPhase.PAUSED, rate=2.0))
        view = model.snapshot().replay
        assert view.paused and view.can_pause
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
        assert not view.can_pause


def test_another_survey_shows_nothing_of_the_one_before():
    model = played(MARK, state(SurveyState.FINISHED), progress("other"))
    assert model.snapshot().state is None
    assert model.snapshot().replay == Replay("other")
