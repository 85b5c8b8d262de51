"""Who may command the robot from a distance, and when."""

from __future__ import annotations

import contextlib
import json
import random
import uuid
from dataclasses import replace
from typing import Any, Dict, List, Optional, Tuple

import pytest
from case_kit import each_case
from run_seed import SEED, draws
from survey_examples import PARAMETERS
from web_kit import ManualClock, route_of

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Fault, Message, Severity
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.robot.events import Answer, AxisStopAnswer, ControlState, Request, StartPlan
from gpr20_operator.robot.remote_control import RemoteAllowance, RemoteArmed
from gpr20_operator.robot.snapshot import SurveyModel
from gpr20_survey.axes import AxisId
from gpr20_survey.folder.survey_metadata import parse_object
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Call, Person, Role
from gpr20_web.faults import BadRequestError, NotAllowedError, NotNowError
from gpr20_web.mid.commands import Commands, plan_id
from gpr20_web.mid.presses import Lease

SURVEY, ANOTHER = (f"c0ffee00-0000-4000-8000-00000000000{number}" for number in (1, 2))
PLAN = StartPlan(PARAMETERS, EMPTY, "", 4.0)
ON_REQUEST = Message("paused").with_fault(Fault("test.asked", None, Severity.NOTE))
ANA = Person("ana", Role.CONTROL, "secret 1", "10.0.0.5")
BEN = Person("ben", Role.CONTROL, "secret 2", "10.0.0.6")
EVA = Person("eva", Role.WATCH, "secret 3", "")


# That a survey is paused, START is allowed, that was long ago, a STOP is open, another plan or
# survey is asked for.
ODDS = (0.5, 0.8, 0.2, 0.2, 0.2)


class Control:
    """Remembers what was asked of the robot."""

    def __init__(self) -> None:
        self.asked: List[Any] = []
        self.withdrawals = 0

    def withdraw_start(self) -> None:
        self.withdrawals += 1

    def stop(self) -> None:
        self.asked.append("stop")

    def pause_survey(self) -> None:
        self.asked.append("pause")

    def resume_survey(self, survey_id: str) -> None:
        self.asked.append(("resume", survey_id))

    def start_survey(self, plan: StartPlan) -> None:
        self.asked.append(("start", plan))


class Desk:
    """The commands, a robot in a state, and what was noted."""

    def __init__(self) -> None:
        self.time = ManualClock()
        self.model, self.control = SurveyModel(self.time), Control()
        self.allowance = RemoteAllowance(self.time)
        self.noted: List[Tuple[str, Dict[str, Any]]] = []
        self.lease = Lease(self.time, lambda _session: True)
        self.commands = Commands(
            *(self.model, self.control, self.allowance, self.time, self.lease),
            lambda *entry: self.noted.append(entry),
        )
        self.be(SurveyState.CONFIGURED)

    def be(self, code: SurveyState, message: Optional[Message] = None) -> None:
        self.model.handle(ControlState(code, message or Message("so it is"), SURVEY, True))
        self.commands.show_state(self.model.state())

    def rest(self) -> None:
        """Every axis answers STOP, and reports later that it rests."""
        for axis in AxisId:
            self.commands.on_event(AxisStopAnswer(axis, True))
        self.time.time_s += 1.0
        for axis in AxisId:
            self.model.handle(AxisReport(axis, 0.0, True, False))
        self.commands.show_state(self.model.state())

    def allow(self, plan: StartPlan = PLAN) -> None:
        self.commands.on_event(RemoteArmed(True, 600.0, plan))

    def ask(self, name: str, person: Person = ANA, press: str = "", **values: Any) -> Any:
        route, _parts = route_of(self.commands.routes, "POST", f"/api/{name}")
        if person.role < route.right:
            raise NotAllowedError(Message("no right"))
        sent = {"press": press or uuid.uuid4().hex, "pressed_ms": 1e3 * self.time.time_s}
        return route.answer(Call(person, person.address, {**sent, **values}))

    def start(self, person: Person = ANA, **values: Any) -> Any:
        return self.ask("start", person, **{"plan": plan_id(PLAN), **values})

    @property
    def shown(self) -> Any:
        return self.commands.live(str)

    @property
    def said(self) -> List[str]:
        """What stands in the logs: who, what, and what became of it."""
        return [f"{one['user']} {one['command']} {one['outcome']}" for _survey, one in self.noted]


def armed() -> Desk:
    desk = Desk()
    desk.allow()
    desk.ask("control/take")
    return desk


def test_silence_and_a_fault_end_the_permission_and_what_has_not_begun() -> None:
    desk = armed()
    before = desk.control.withdrawals
    desk.be(SurveyState.CONFIGURED)
    assert desk.control.withdrawals == before
    desk.time.time_s += 4.0
    desk.be(SurveyState.CONFIGURED)
    assert desk.control.withdrawals == before + 1
    desk = armed()
    desk.be(SurveyState.SURVEYING)
    desk.be(SurveyState.PAUSED, Message("unknown fault of another version"))
    assert not desk.shown["remote"]["armed"]
    with pytest.raises(NotNowError):
        desk.ask("resume", survey=SURVEY)


@each_case("code", SurveyState)
def test_stop_and_pause_need_neither_permission_nor_control_and_stop_no_state(
    code: SurveyState,
) -> None:
    desk = Desk()
    desk.be(code)
    desk.ask("stop", EVA)
    assert desk.control.asked == ["stop"]
    desk = Desk()
    desk.be(SurveyState.SURVEYING)
    desk.ask("pause", EVA)
    assert desk.control.asked == ["pause"]


@each_case(
    "values", [{"press": "../" * 8}, {"press": 7}, {"pressed_ms": None}, {"pressed_ms": [1e6]}]
)
def test_press_without_a_proper_mark_or_time_is_refused_but_for_stop(
    values: Dict[str, Any],
) -> None:
    desk = armed()
    with pytest.raises(BadRequestError):
        desk.start(**values)
    assert desk.ask("stop", **values) == {"confirmed": False}
    assert desk.control.asked == ["stop"] and desk.shown["command"]["name"] == "ana"


def test_start_and_resume_wait_until_each_stop_is_answered_and_confirmed() -> None:
    desk = armed()
    pressed_ms = 1e3 * desk.time.time_s
    desk.time.time_s += 1.0
    desk.ask("stop", EVA)
    silent = Answer(Request.STOP, False, Message("silent"), contact=False)
    for answer in (silent, Answer(Request.STOP, True, Message("stopping"))):
        desk.allow()
        with pytest.raises(NotNowError, match="STOP is not confirmed"):
            desk.start()
        desk.be(SurveyState.PAUSED, ON_REQUEST)
        with pytest.raises(NotNowError, match="STOP is not confirmed"):
            desk.ask("resume", survey=SURVEY)
        desk.commands.on_event(answer)
    desk.be(SurveyState.STOPPED, ON_REQUEST)
    desk.rest()
    desk.allow()
    with pytest.raises(NotNowError, match="STOP was pressed since"):
        desk.start(pressed_ms=pressed_ms)
    assert desk.control.asked == ["stop"]
    desk.start()


def test_stop_that_is_sent_again_says_whether_it_is_confirmed_and_is_noted_once() -> None:
    desk, press = Desk(), uuid.uuid4().hex
    desk.be(SurveyState.SURVEYING)
    assert desk.shown["stop_open"] is False
    assert desk.ask("stop", press=press) == {"confirmed": False}
    desk.time.time_s += 6.0
    desk.be(SurveyState.SURVEYING)
    assert desk.shown["command"]["outcome"] == "unknown"  # a late answer
    desk.commands.on_event(Answer(Request.STOP, False, Message("silent"), contact=False))
    assert desk.shown["command"]["outcome"] == "unknown"
    assert desk.ask("stop", press=press) == {"confirmed": False}
    desk.commands.on_event(Answer(Request.STOP, True, Message("stopping")))
    assert desk.shown["command"]["outcome"] == "done"
    # An axis may still move.
    assert desk.shown["stop_open"] is True
    assert desk.ask("stop", press=press) == {"confirmed": False}
    # Who is asked repeats it until it is answered: many more calls would wait for what hangs.
    assert desk.control.asked == ["stop"]
    desk.be(SurveyState.STOPPED, ON_REQUEST)
    desk.rest()
    assert desk.shown["stop_open"] is False
    assert desk.ask("stop", press=press) == {"confirmed": True}
    # Should somebody use one mark for two presses: no STOP is ignored.
    assert desk.control.asked == ["stop"] * 2
    outcomes = ("sent", "unknown: silent", "done: stopping")
    assert desk.said == [f"ana stop {one}" for one in outcomes]


def test_who_did_what_stands_in_the_log_in_a_form_that_the_storage_takes() -> None:
    desk = armed()
    desk.be(SurveyState.SURVEYING)
    desk.ask("pause", EVA)
    desk.commands.on_event(Answer(Request.PAUSE, False, Message("no " * 200)))
    with pytest.raises(NotAllowedError):
        desk.ask("resume", BEN, survey=SURVEY)
    expected = ("eva pause sent", "eva pause refused: no no", "ben resume refused: another page")
    assert len(desk.said) == len(expected)
    assert all(one.startswith(begin) for one, begin in zip(desk.said, expected))
    for survey, entry in desk.noted:
        assert survey == SURVEY and parse_object(json.dumps(entry), "values_json") == entry
        assert entry["time"].endswith("+00:00") and len(entry["outcome"]) <= 200
    assert (entry["role"], entry["address"]) == ("control", BEN.address)
    assert "secret" not in json.dumps([desk.noted, desk.shown])


@each_case("described_first", [False, True])
def test_start_measures_the_plan_that_is_shown_and_is_noted_in_the_log_of_its_survey(
    described_first: bool,
) -> None:
    desk = armed()
    plan = desk.shown["remote"]["plan"]
    assert plan["id"] == plan_id(PLAN) and "Hands clear" in plan["warning"]
    assert ["Where", "X 10 - 30 mm, Y 5 - 35 mm"] in plan["rows"]
    desk.start()
    assert desk.control.asked == [("start", PLAN)]
    assert desk.shown["command"]["outcome"] == "sent"
    started = Answer(Request.START, True, Message("started"), survey_id=SURVEY)
    described = SurveyDescribed(json.dumps({"survey_id": SURVEY}))
    first, second = (described, started) if described_first else (started, described)
    desk.commands.on_event(first)
    assert desk.said == []
    for event in (second, described):
        desk.commands.on_event(event)
    assert desk.shown["command"]["outcome"] == "done"
    assert [survey for survey, entry in desk.noted if entry["outcome"] == "begun"] == [SURVEY]


def test_nothing_moves_without_permission_control_and_right_and_with_all_of_them_it_does() -> None:
    draw = random.Random(SEED)
    for _number in range(draws(500)):
        desk, press, is_young = Desk(), uuid.uuid4().hex, draw.random() < 0.7
        is_paused, is_allowed, is_silent, is_stopped, is_other = (
            draw.random() < one for one in ODDS
        )
        taker, person = draw.choice([ANA, ANA, BEN, None]), draw.choice([ANA, ANA, BEN, EVA])
        if is_stopped:
            desk.ask("stop", EVA)
        if is_paused:
            desk.be(SurveyState.SURVEYING)
            desk.be(SurveyState.PAUSED, ON_REQUEST)
        if is_allowed:
            desk.allow(replace(PLAN, permittivity=9.0) if is_other else PLAN)
        if taker is not None:
            desk.ask("control/take", taker)
        desk.time.time_s += 4.0 if is_silent else 1.0
        age_s = draw.choice([5.9, 0.0, -1.9] if is_young else [6.1, -2.1, float("inf")])
        values = {
            "plan": plan_id(PLAN),
            "survey": ANOTHER if is_other else SURVEY,
            "pressed_ms": 1e3 * (desk.time.time_s - age_s),
        }
        name, expected = ("resume", SURVEY) if is_paused else ("start", PLAN)
        may_move = is_allowed and is_young and person is taker
        may_move &= not (is_silent or is_stopped or is_other)
        # What is sent twice is carried out once.
        for _ in range(2):
            with contextlib.suppress(Gpr20Error):
                desk.ask(name, person, press, **values)
        moved = [one for one in desk.control.asked if one != "stop"]
        assert moved == ([(name, expected)] if may_move else [])
