"""SERVICE: when the robot may be serviced, and when it ends by itself."""

import random

import pytest
from result_kit import ServiceTools
from run_seed import draws
from view_kit import snapshot

from gpr20_common.message import Message
from gpr20_doctor.mid.robot_facts import Endstop
from gpr20_operator.jobs.job import Service
from gpr20_operator.robot.events import CurrentPosition, Request
from gpr20_operator.robot.service_model import (
    IDLE_LIMIT_S,
    LAMP_S,
    AxisAction,
    ServiceModel,
)
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import SurveyState


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


def test_one_request_at_a_time(model, requests):
    jog(model)
    jog(model)
    model.ask(model.analyzer)
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


OTHERS = {
    "alive": (True, False),
    "master_alive": (True, False),
    "pending": (frozenset(), frozenset({Request.START}), frozenset({Request.RESUME})),
    "service": (None, Message("testing the VNA")),
}


def test_nothing_is_asked_for_beside_a_survey_or_another_request(clock):
    """Whatever is touched and heard in any order."""
    draw = random.Random(1)
    tools = ServiceTools()
    model = ServiceModel(tools, tools.examine, clock)
    shown = at_rest()
    acts = [
        *(model.enter, model.leave, lambda: model.ask(model.height)),
        *(lambda: model.ask(model.analyzer), model.check_daily),
        lambda: jog(model),
        lambda: model.set_watched(False),
        lambda: tools.done(Service.MOVE, Message("done")),
        lambda: clock.advance(draw.uniform(0.0, 2.0 * IDLE_LIMIT_S)),
    ]
    for _ in range(draws(2000)):
        before = len(tools.asked)
        if draw.random() < 0.2:
            others = {name: draw.choice(values) for name, values in OTHERS.items()}
            shown = at_rest(draw.choice(list(SurveyState)), **others)
        model.refresh(shown)
        possible = shown.control_alive and shown.master_alive and not shown.running
        assert (model.obstacle is None) is (possible and not shown.pending)
        assert model.obstacle is None or not model.entered
        entered, busy = model.entered, model.busy
        act = draw.choice(acts)
        act()
        if len(tools.asked) > before:
            assert entered and possible and not shown.pending and not busy
        assert act is not acts[6] or not model.entered, "it ends with its tab"
