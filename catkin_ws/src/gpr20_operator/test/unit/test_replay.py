"""A replay never looks like a robot, and never hides one."""

import contextlib

import pytest

pytest.importorskip("rospy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from fake_clock import FakeClock
from hypothesis import given
from hypothesis import strategies as some
from topics_kit import Graph

from gpr20_common.faults import MAY_MOVE
from gpr20_common.message import verbatim
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_msgs.msg import ControlStatus, Coordinates, CurrentCoordinate, SurveyData
from gpr20_msgs.msg import Replay as ReplayMessage
from gpr20_operator.high import ros_events
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.high.storage_client import NO_ROBOT, StorageClient
from gpr20_operator.jobs.job import Service
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.robot.condition import JobLevel, condition_of, left_of
from gpr20_operator.robot.events import ControlState, Progress, Senders
from gpr20_operator.robot.notices import CardWatch
from gpr20_operator.robot.remote_control import remote_obstacle
from gpr20_operator.robot.snapshot import SurveyModel
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import SurveyState

# `rosbag play`, replay.launch, a window, and nodes of other robots.
OTHERS = (
    *("/play_1795334095431", "/replay/replay", "/user_interface", "/some_player"),
    *("/robot2/main_control", "/replay/main_control", "/main_control_", "main_control"),
)


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
        "mark": ("replay", ReplayMessage(state=number % 3)),
        "health": ("/diagnostics", report(EXPECTED_NODES[number % 3], number % 3)),
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
            shown, without = model.state(), model_without.state()
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
            for kind in ("state", "progress", "place", "axis", "health"):
                graph.send(f"/{node}", *message(kind, 1))
        assert events == []
        graph.send("/play_1", *message("state", 4))
        assert events.pop().survey_id == "survey 1"
        model = SurveyModel(FakeClock(), replay=True)
        for phase, title in enumerate(("REPLAY", "REPLAY PAUSED", "REPLAY ENDED")):
            graph.send("/play_1", "replay", ReplayMessage(state=phase))
            model.handle(events.pop())
            assert str(condition_of(model.state()).title) == title


@given(some.sampled_from(SurveyState), some.floats(0.0, 100.0), some.booleans())
def test_a_window_of_a_replay_is_one_in_every_state_and_asks_a_robot_for_nothing(
    code, passed_s, failed
):
    clock = FakeClock()
    model = SurveyModel(clock, replay=True)
    said = MAY_MOVE.remedy.with_fault(MAY_MOVE) if failed else verbatim("as it is")
    for event in (
        NodeHealth("main_control", HealthLevel.ERROR, verbatim("it burns"), {}),
        ControlState(SurveyState.SURVEYING, verbatim("on"), "id", False),
        ControlState(code, said, "id", False),
        AxisReport(AxisId.X, 1.0, True, True),
        Progress("id", 50.0, 18, 9, 30.0),
    ):
        model.handle(event)
    clock.advance(passed_s)
    shown = model.state()
    condition = condition_of(shown)
    assert (condition.level, str(condition.title)) == (JobLevel.REPLAY, "REPLAY")
    assert code.name in str(condition.message)
    assert not (shown.can_start or shown.can_pause or shown.can_resume) and shown.fields_locked
    assert CardWatch().note(shown) is left_of(shown) is None
    assert remote_obstacle(shown) is not None and shown.health.trouble is None


def test_a_window_of_a_replay_asks_no_storage(services, events):
    client = StorageClient(events.put, Senders("/", replay=True))
    job = Imaging(client, lambda: 0.0).job(Service.READ)
    job.ask(survey="id")
    events.get_nowait().deliver()
    assert job.problem == NO_ROBOT and services.asked.empty()
