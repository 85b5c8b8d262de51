"""SERVICE: when the robot may be serviced, and when it ends by itself."""

import random

from result_kit import ServiceTools
from run_seed import draws
from view_kit import snapshot

from gpr20_common.message import Message
from gpr20_doctor.mid.robot_facts import Endstop
from gpr20_operator.jobs.job import Service
from gpr20_operator.robot.events import CurrentPosition, Request
from gpr20_operator.robot.service_model import IDLE_LIMIT_S, AxisAction, ServiceModel
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import SurveyState


def at_rest(code=SurveyState.FINISHED, **other):
    return snapshot(code, **{"current": CurrentPosition(1.0, 2.0, 3.0), **other})


def test_service_ends_two_minutes_after_the_last_touch_or_motion(clock):
    tools = ServiceTools()
    model = ServiceModel(tools, tools.examine, clock)
    model.refresh(at_rest())
    model.enter()
    model.on_event(Endstop(AxisId.X, True))
    assert model.pressed(AxisId.X)
    clock.advance(IDLE_LIMIT_S - 1.0)
    assert model.pressed(AxisId.X) is None, "not known any more"
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
    tools.done(Service.MOVE, Message("homed"))
    clock.advance(IDLE_LIMIT_S - 1.0)
    model.refresh(at_rest())
    assert model.entered
    clock.advance(2.0)
    model.refresh(at_rest())
    assert not model.entered


OTHERS = {
    "alive": (True, False),
    "master_alive": (True, False),
    "pending": (frozenset(), frozenset({Request.START}), frozenset({Request.RESUME})),
    "service": (None, Message("testing the VNA")),
}


def test_nothing_is_asked_for_beside_a_survey_or_another_request(clock):
    draw, waits = random.Random(1), False
    tools = ServiceTools()
    model = ServiceModel(tools, tools.examine, clock)
    shown = at_rest()

    def answer():
        for one in (Service.MOVE, Service.HEIGHT, Service.ANALYZER, Service.DAILY):
            tools.done(one, Message("done"))

    def leave_tab():
        model.set_watched(False)

    acts = [
        *(*[model.enter] * 5, *[answer] * 3, model.leave, leave_tab, model.check_daily),
        *(lambda: model.ask(model.height), lambda: model.ask(model.analyzer)),
        lambda: model.move(AxisId.X, AxisAction.JOG, 10.0),
        lambda: clock.advance(draw.uniform(0.0, 2.0 * IDLE_LIMIT_S)),
    ]
    for _ in range(draws(2000)):
        before = len(tools.asked)
        if draw.random() < 0.1:
            others = {name: draw.choice((*one[:1] * 6, *one)) for name, one in OTHERS.items()}
            shown = at_rest(draw.choice(list(SurveyState)), **others)
        model.refresh(shown)
        possible = shown.control_alive and shown.master_alive and not shown.running
        assert (model.obstacle is None) is (possible and not shown.pending)
        assert model.obstacle is None or not model.entered
        assert model.busy is (waits or shown.service is not None)
        entered, busy = model.entered, model.busy
        act = draw.choice(acts)
        act()
        if len(tools.asked) > before:
            assert entered and possible and not shown.pending and not busy
        waits = act is not answer and (waits or len(tools.asked) > before)
        assert act is not leave_tab or not model.entered, "it ends with its tab"
    assert len(tools.asked) > 20
