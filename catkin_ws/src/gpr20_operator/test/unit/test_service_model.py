"""SERVICE: when the robot may be serviced, and when it ends by itself."""

import random
from dataclasses import replace

import pytest
from result_kit import ServiceTools
from run_seed import draws
from view_kit import snapshot, state_of

from gpr20_common.message import Message
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_doctor.mid.robot_facts import Endstop
from gpr20_operator.jobs.job import Service
from gpr20_operator.robot.events import CurrentPosition, Replay, Request
from gpr20_operator.robot.service_model import (
    IDLE_LIMIT_S,
    LAMP_S,
    AxisAction,
    ServiceModel,
)
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import RUNNING, SurveyState


def at_rest(code=SurveyState.FINISHED, **other):
    return snapshot(code, **{"current": CurrentPosition(1.0, 2.0, 3.0), **other})


@pytest.fixture
def requests():
    return ServiceTools()


@pytest.fixture
def model(clock, requests):
    model = ServiceModel(requests, requests.examine, clock)
    model.refresh(at_rest())
    model.enter()
    return model


def jog(model, distance=10.0):
    model.move(AxisId.X, AxisAction.JOG, distance)


def test_service_ends_and_does_not_begin_while_it_is_not_possible(model, requests):
    for shown in (
        *(at_rest(code) for code in sorted(RUNNING)),
        *(at_rest(pending=frozenset([one])) for one in (Request.START, Request.RESUME)),
        at_rest(alive=False),
        at_rest(master_alive=False),
    ):
        model.enter()
        assert model.entered
        model.refresh(shown)
        assert not model.entered
        assert model.obstacle is not None
        model.enter()
        jog(model)
        assert requests.asked == [], shown
        model.refresh(at_rest())
        assert not model.entered


def test_service_ends_two_minutes_after_the_last_touch_or_motion(model, clock, requests):
    clock.advance(IDLE_LIMIT_S - 1.0)
    model.touch()
    clock.advance(IDLE_LIMIT_S - 1.0)
    model.refresh(at_rest())
    assert model.entered
    # Not during a long motion.
    model.move(AxisId.X, AxisAction.HOME)
    for _minute in range(10):
        clock.advance(60.0)
        model.refresh(at_rest(service=Message("homing the {axis} axis", axis="x")))
        assert model.entered
    requests.done(Service.MOVE, Message("homed"))
    clock.advance(IDLE_LIMIT_S - 1.0)
    model.refresh(at_rest())
    assert model.entered
    clock.advance(2.0)
    model.refresh(at_rest())
    assert not model.entered


def test_service_ends_with_its_tab(model, requests):
    model.set_watched(True)
    model.set_watched(False)
    assert requests.asked == [("examine", False)]
    assert not model.entered


def test_one_request_at_a_time(model, requests):
    jog(model)
    jog(model)
    model.test_analyzer()
    assert requests.asked == [("x", "JOG", 10.0)]
    assert model.busy
    requests.fail(Service.MOVE, Message("the axis is not homed"))
    assert (model.busy, model.failed) == (False, True)
    assert str(model.outcome) == "Not done: the axis is not homed"
    # What another window asked for.
    model.refresh(at_rest(service=Message("testing the VNA")))
    jog(model)
    assert len(requests.asked) == 1
    assert "testing the VNA" in str(model.outcome)


def test_the_lamp_shows_a_short_touch_and_no_old_state(model, clock):
    def lamp():
        return model.pressed(AxisId.X)

    assert lamp() is None
    model.on_event(Endstop(AxisId.X, True))
    model.on_event(Endstop(AxisId.X, False))
    assert lamp() is True
    clock.advance(LAMP_S)
    assert lamp() is False
    clock.advance(1.0)
    assert lamp() is None


def test_the_smallest_offset_of_a_clock_counts(model, clock):
    def found(*reports):
        survey = SurveyModel(clock)
        survey.handle(state_of(SurveyState.IDLE))
        for name, offset_s in reports:
            survey.handle(NodeHealth(name, HealthLevel.OK, Message("fine"), {}, offset_s))
        model.refresh(survey.snapshot())
        return any("differs" in str(one.text) for one in model.findings())

    late = [("height_sensor", offset_s) for offset_s in (8.0, 0.2, 3.0)]
    assert not found(*late)
    assert found(*late, ("vna_acquisition", 8.0))
    # Nothing is found wrong with the robot of a replay.
    model.refresh(replace(at_rest(), replay=Replay()))
    assert model.findings() == () and model.obstacle is not None


def test_no_sequence_asks_for_a_motion_beside_a_survey(clock):
    """Whatever is touched and heard in any order."""
    draw = random.Random(1)
    tools = ServiceTools()
    model = ServiceModel(tools, tools.examine, clock)
    shown = at_rest()
    acts = [
        model.enter,
        model.leave,
        lambda: jog(model),
        model.measure_height,
        model.test_analyzer,
        model.check_daily,
        lambda: tools.done(Service.MOVE, Message("done")),
        lambda: clock.advance(draw.uniform(0.0, 2.0 * IDLE_LIMIT_S)),
    ]
    for _ in range(draws(2000)):
        before = len(tools.asked)
        if draw.random() < 0.2:
            shown = at_rest(draw.choice(list(SurveyState)), alive=draw.random() < 0.9)
        model.refresh(shown)
        entered = model.entered
        draw.choice(acts)()
        if len(tools.asked) > before:
            assert entered and shown.control_alive and not shown.running
