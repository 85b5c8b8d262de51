"""SERVICE: what is wrong with the robot, and the bundle; ROBOTS: what each of a master does now.

Nothing here moves or tests anything.
"""

from __future__ import annotations

import os
from typing import Any, Callable, Dict, List
from unittest import mock

import pytest
from case_kit import each_case
from view_kit import snapshot
from web_kit import SILENT, ManualClock, state_of

from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import MachineReport
from gpr20_doctor.mid.node_health import HealthLevel, HealthReport, NodeHealth
from gpr20_operator.jobs.job import Service, Ticket
from gpr20_operator.robot.robots import RobotReported, Robots, RobotsFound
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Body, Call, Person, Role
from gpr20_web.errors import BundleError, NotFoundError, NotNowError
from gpr20_web.low import doctor_program
from gpr20_web.mid.robots_page import RobotsPage
from gpr20_web.mid.service_page import NoRequests, ServicePage
from gpr20_web.mid.web_page import INTEREST_S

CALL = Call(Person("ana", Role.CONTROL, "s", ""))
LIMIT_S = 20.0
HEALTH = HealthReport((NodeHealth("height_sensor", HealthLevel.ERROR, verbatim("broken"), {}),))


class Robot:
    """A robot whose parts are looked at."""

    def __init__(self, make: Callable[[], bytes] = lambda: b"zip") -> None:
        self.clock = ManualClock()
        self.tickets: List[Any] = []
        self.page = ServicePage(self._examine, make, self.clock)
        self.page.refresh(snapshot(state=state_of(SurveyState.IDLE), health=HEALTH))
        self.listed, self.made, self.given = (one.answer for one in self.page.routes)

    def _examine(self, ticket: Ticket[Any], **wanted: Any) -> None:
        assert wanted["thorough"] is False
        self.tickets.append(ticket)


def test_the_worst_is_the_first_and_each_part_has_its_health() -> None:
    robot = Robot()
    answer: Any = robot.listed(CALL)
    levels = ["fault", "warning", "unknown", "note", "ok"]
    found = [levels.index(one["level"]) for one in answer["findings"]]
    assert found and found == sorted(found)
    (part,) = answer["parts"]
    assert (part["level"], part["title"]) == ("error", "Height sensor: FAULT")
    assert answer["summary"]


def test_this_computer_is_looked_at_once_while_somebody_looks() -> None:
    robot = Robot()
    before: Any = robot.listed(CALL)
    robot.listed(CALL)
    (ticket,) = robot.tickets
    ticket.done(MachineReport((Finding.of("memory", Message("Memory: 900 MB free")),)))
    after: Any = robot.listed(CALL)
    assert len(after["findings"]) > len(before["findings"])
    # And again when somebody comes back.
    robot.clock.time_s += INTEREST_S + 1.0
    robot.page.refresh(snapshot(SurveyState.IDLE))
    robot.listed(CALL)
    assert len(robot.tickets) == 2


@each_case("service", Service)
def test_no_service_of_the_robot_is_called_from_here(service: Service) -> None:
    asked = mock.Mock()
    NoRequests().ask(service, asked)
    asked.fail.assert_called_once()


def test_a_bundle_is_made_alone_then_given_once() -> None:
    def make() -> bytes:
        answer: Any = robot.listed(CALL)
        assert answer["making"]
        with pytest.raises(NotNowError):
            robot.made(CALL)
        return results.pop()

    robot, results = Robot(make), [b"zip"]
    with pytest.raises(NotFoundError):
        robot.given(CALL)
    assert robot.made(CALL) == {"bytes": 3}
    body: Any = robot.given(CALL)
    assert body == Body(b"zip", "application/zip", "gpr20_bundle.zip")
    with pytest.raises(NotFoundError):
        robot.given(CALL)
    # After one that failed, another one can be made.
    with pytest.raises(IndexError):
        robot.made(CALL)
    results.append(b"zip")
    assert robot.made(CALL) == {"bytes": 3}


def test_the_doctor_makes_the_bundle_in_a_process_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # The doctor itself takes half a minute: its test is elsewhere. It takes these arguments.
    monkeypatch.setattr(
        doctor_program,
        "PROGRAM",
        "import argparse, os\n"
        "from gpr20_doctor.mid.arguments import add_arguments\n"
        "parser = argparse.ArgumentParser()\n"
        "add_arguments(parser)\n"
        "given = parser.parse_args()\n"
        "given.bundle.write_text(f'{given.ns} {given.quick} {os.getpid()}')\n",
    )
    namespace, quick, process = doctor_program.make_bundle("/robot1").decode().split()
    assert (namespace, quick) == ("/robot1", "True")
    assert int(process) != os.getpid()


def test_a_doctor_that_does_not_work_is_an_error_that_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(doctor_program, "PROGRAM", "import sys; sys.exit('no doctor here')")
    with pytest.raises(BundleError, match="FileNotFound"):
        doctor_program.make_bundle("/")
    monkeypatch.setattr(doctor_program, "PROGRAM", "import threading; threading.Event().wait()")
    monkeypatch.setattr(doctor_program, "LIMIT_S", 0.05)
    with pytest.raises(BundleError, match="TimeoutExpired"):
        doctor_program.make_bundle("/")


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


def test_each_robot_is_listed_with_what_it_does_and_since_when_if_that_is_known() -> None:
    field = Field()
    field.rows()
    field.page.on_event(RobotReported("/b", MEASURING))
    rows = field.rows()
    assert (rows["a"]["title"], rows["a"]["level"]) == ("SURVEYING", "working")
    assert [rows[name]["shown"] for name in "ab"] == [True, False]
    assert rows["a"]["since"].startswith("2027-") and rows["b"]["since"] == ""
    field.page.on_event(RobotReported("/b", state_of(SurveyState.FAILED, SILENT)))
    row = field.rows()["b"]
    assert (row["title"], row["level"]) == ("FAILED", "fault")
    assert row["since"] > rows["a"]["since"]
    field.clock.time_s += 3.0
    field.page.on_event(RobotReported("/b", state_of(SurveyState.FAILED, SILENT)))
    assert field.rows()["b"]["since"] == row["since"]
    # The robot of the page is listed also if it is away.
    field.page.on_event(RobotsFound(frozenset(["/b"])))
    field.page.refresh(snapshot(alive=False, control_silent_s=None))
    row = field.rows()["a"]
    assert (row["title"], row["level"], row["since"]) == ("NO CONTACT", "fault", "")


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
