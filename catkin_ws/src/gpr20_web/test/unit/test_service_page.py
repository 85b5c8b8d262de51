"""SERVICE: what is wrong with the robot; ROBOTS: what each of a master does now.

Nothing here moves or tests anything.
"""

from __future__ import annotations

from typing import Any, Dict
from unittest import mock

from view_kit import snapshot
from web_kit import SILENT, ManualClock, state_of

from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import MachineReport
from gpr20_doctor.mid.node_health import HealthLevel, HealthReport, NodeHealth
from gpr20_operator.jobs.job import Service
from gpr20_operator.robot.robots import RobotReported, Robots, RobotsFound
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Call, Person, Role
from gpr20_web.mid.robots_page import RobotsPage
from gpr20_web.mid.service_page import NoRequests, ServicePage
from gpr20_web.mid.web_page import INTEREST_S

CALL = Call(Person("ana", Role.CONTROL, "s", ""))
SENSOR = NodeHealth("height_sensor", HealthLevel.ERROR, verbatim("broken"), {"voltage_v": 1.3})
HEALTH = HealthReport((SENSOR,))


def test_the_worst_is_the_first_in_words_and_this_computer_is_looked_at_while_somebody_looks() -> (
    None
):
    clock, tickets = ManualClock(), []  # type: ManualClock, List[Any]
    page = ServicePage(lambda ticket, **_wanted: tickets.append(ticket), clock)
    page.refresh(snapshot(state=state_of(SurveyState.IDLE), health=HEALTH))
    (route,) = page.routes
    answer: Any = route.answer(CALL)
    levels = ["fault", "warning", "unknown", "note", "ok"]
    found = [levels.index(one["level"]) for one in answer["findings"]]
    assert found and found == sorted(found) and answer["summary"]
    (part,) = answer["parts"]
    assert (part["level"], part["title"]) == ("error", "Height sensor: FAULT")
    assert "voltage" not in str(answer)
    route.answer(CALL)
    (ticket,) = tickets
    ticket.done(MachineReport((Finding.of("memory", Message("Memory: 900 MB free")),)))
    after: Any = route.answer(CALL)
    assert len(after["findings"]) > len(answer["findings"])
    clock.time_s += INTEREST_S + 1.0
    page.refresh(snapshot(SurveyState.IDLE))
    # And again when somebody comes back.
    route.answer(CALL)
    assert len(tickets) == 2


def test_no_service_of_the_robot_is_called_from_here() -> None:
    for service in Service:
        asked = mock.Mock()
        NoRequests().ask(service, asked)
        asked.fail.assert_called_once()


MEASURING = state_of(SurveyState.SURVEYING, None)


class Field:
    """Two robots, of which the page shows the first."""

    def __init__(self) -> None:
        self.clock, self.watched = ManualClock(), []  # type: ManualClock, List[bool]
        self.page = RobotsPage(Robots("/a", watch=self.watched.append), self.clock)
        self.page.on_event(RobotsFound(frozenset(["/a", "/b"])))
        self.refresh()

    def refresh(self) -> None:
        self.page.refresh(snapshot(state=MEASURING, state_s=20.0))

    def rows(self) -> Dict[str, Any]:
        (route,) = self.page.routes
        assert route.right is Role.WATCH
        answer: Any = route.answer(CALL)
        return {one["name"]: one for one in answer["robots"]}


def test_each_robot_is_listed_with_what_it_does() -> None:
    field = Field()
    field.rows()
    field.page.on_event(RobotReported("/b", MEASURING))
    rows = field.rows()
    assert (rows["a"]["title"], rows["a"]["level"]) == ("SURVEYING", "working")
    assert [rows[name]["shown"] for name in "ab"] == [True, False]
    field.page.on_event(RobotReported("/b", state_of(SurveyState.FAILED, SILENT)))
    row = field.rows()["b"]
    assert (row["title"], row["level"]) == ("FAILED", "fault")
    # The robot of the page is listed also if it is away.
    field.page.on_event(RobotsFound(frozenset(["/b", "/"])))
    field.page.refresh(snapshot(alive=False, control_silent_s=None))
    row = field.rows()["a"]
    assert (row["title"], row["level"]) == ("NO CONTACT", "fault")
    assert set(field.rows()) == {"a", "b", "Robot"}


def test_what_was_heard_before_is_not_what_a_robot_does_now() -> None:
    field = Field()
    field.rows()
    for pause_s in (6.0, INTEREST_S + 0.1):
        field.page.on_event(RobotReported("/b", MEASURING))
        assert field.rows()["b"]["title"] == "SURVEYING"
        field.clock.time_s += pause_s
        field.refresh()
        assert field.rows()["b"]["title"] == "no report yet"


def test_the_others_are_listened_to_only_while_somebody_asks() -> None:
    field = Field()
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
