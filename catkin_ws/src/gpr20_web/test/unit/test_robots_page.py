"""Every robot of the master: what it does now, never what it did when nobody listened."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Dict

import pytest
from robot_views import SILENT, ManualClock, state_of, view

from gpr20_operator.robot.robots import RobotReported, Robots, RobotsFound
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Call, Person
from gpr20_web.mid.interest import INTEREST_S
from gpr20_web.mid.robots_page import RobotsPage
from gpr20_web.roles import Role

CALL = Call(Person("ana", Role.VIEW, "s", ""))
MEASURING = state_of(SurveyState.SURVEYING, None)


class Field:
    """Two robots, of which the page shows the first."""

    def __init__(self) -> None:
        self.clock, self.watched = ManualClock(), []  # type: ManualClock, List[bool]
        self.page = RobotsPage(Robots("/a", watch=self.watched.append), self.clock)
        self.page.on_event(RobotsFound(frozenset(["/a", "/b"])))
        self.refresh()

    def refresh(self) -> None:
        self.page.refresh(view(MEASURING, state_s=20.0))

    def rows(self) -> Dict[str, Any]:
        (route,) = self.page.routes
        assert route.right is Role.VIEW
        answer: Any = route.answer(CALL)
        return {one["name"]: one for one in answer["robots"]}


@pytest.fixture
def field() -> Field:
    return Field()


def test_each_robot_is_listed_with_what_it_does(field: Field) -> None:
    field.rows()
    field.page.on_event(RobotReported("/b", state_of(SurveyState.FAILED, SILENT)))
    rows = field.rows()
    assert (rows["a"]["title"], rows["a"]["level"]) == ("SURVEYING", "working")
    assert (rows["b"]["title"], rows["b"]["level"]) == ("FAILED", "fault")
    assert [rows[name]["shown"] for name in "ab"] == [True, False]


def test_the_others_are_listened_to_only_while_somebody_asks(field: Field) -> None:
    assert field.watched == []
    for _ in range(5):
        field.rows()
        field.clock.time_s += INTEREST_S
        field.refresh()
    assert field.watched == [True]
    field.clock.time_s += INTEREST_S + 0.1
    field.refresh()
    field.refresh()
    assert field.watched == [True, False]


def test_what_was_heard_before_is_not_what_a_robot_does_now(field: Field) -> None:
    field.rows()
    field.page.on_event(RobotReported("/b", MEASURING))
    assert field.rows()["b"]["title"] == "SURVEYING"
    field.clock.time_s += 6.0
    assert field.rows()["b"]["title"] == "no report yet"
    field.page.on_event(RobotReported("/b", MEASURING))
    field.clock.time_s += INTEREST_S + 0.1
    field.refresh()
    assert field.rows()["b"]["title"] == "no report yet"


def test_since_when_is_said_only_where_it_is_known(field: Field) -> None:
    field.rows()
    field.page.on_event(RobotReported("/b", MEASURING))
    rows = field.rows()
    assert rows["a"]["since"].startswith("2027-")
    assert rows["b"]["since"] == ""
    field.page.on_event(RobotReported("/b", state_of(SurveyState.PAUSED)))
    since = field.rows()["b"]["since"]
    assert since > rows["a"]["since"]
    field.clock.time_s += 3.0
    field.page.on_event(RobotReported("/b", state_of(SurveyState.PAUSED)))
    assert field.rows()["b"]["since"] == since


def test_the_robot_of_the_page_is_listed_also_if_it_is_away(field: Field) -> None:
    field.page.on_event(RobotsFound(frozenset(["/b"])))
    field.page.refresh(replace(view(None), control_alive=False, control_silent_s=None))
    row = field.rows()["a"]
    assert (row["title"], row["level"], row["since"]) == ("NO CONTACT", "fault", "")
