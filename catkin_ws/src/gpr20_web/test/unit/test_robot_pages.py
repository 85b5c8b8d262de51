"""NOW and SERVICE: the robot's state, and what is wrong. Nothing here moves or tests anything."""

from __future__ import annotations

from typing import Any
from unittest import mock

from view_kit import FULL, SURVEY, description, snapshot, state_of
from web_kit import ManualClock

from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import MachineReport
from gpr20_doctor.mid.node_health import HealthLevel, HealthReport, NodeHealth
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.jobs.job import Service
from gpr20_operator.robot.events import ControlState, CurrentPosition, Progress
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Call, Person, Role
from gpr20_web.mid.robot_pages import NoRequests, NowPage, ServicePage


def test_now_shows_the_survey_its_progress_and_a_fault_with_the_first_step() -> None:
    page = NowPage("north")
    page.on_event(SurveyDescribed(description(annotation={"name": "Lane-4"})))
    place, progress = CurrentPosition(120.0, 60.5, 90.0), Progress(SURVEY, 25.0, 40, 10, 60.0)
    runs = state_of(SurveyState.SURVEYING, survey_id=SURVEY)
    page.show_state(snapshot(state=runs, progress=progress, current=place))
    shown: Any = page.live(str)
    assert (shown["robot"]["name"], shown["robot"]["simulated"]) == ("north", True)
    assert (shown["band"]["level"], shown["fault"]) == ("working", None)
    job = shown["job"]
    assert (job["name"], job["percent"], job["stored"], job["planned"]) == ("Lane-4", 25, 10, 40)
    assert job["place"] == "X 120.0 mm, Y 60.5 mm, 90 deg"
    page.show_state(snapshot(state=ControlState(SurveyState.PAUSED, FULL, "another", True)))
    shown = page.live(str)
    assert (shown["job"]["name"], shown["job"]["percent"]) == ("", None)
    assert "disk is full" in shown["fault"]["text"] and shown["fault"]["first"]


SENSOR = NodeHealth("height_sensor", HealthLevel.ERROR, verbatim("broken"), {"voltage_v": 1.3})


def test_who_looks_at_service_sees_what_is_wrong_with_nodes_and_this_computer() -> None:
    page = ServicePage(lambda *_wanted: None, ManualClock())
    (route,) = page.routes
    call, answer = Call(Person("ana", Role.WATCH, "s", "")), {}  # type: Call, Any
    for _look in range(2):
        answer = route.answer(call)
        page.show_state(snapshot(SurveyState.IDLE, health=HealthReport((SENSOR,))))
        page.on_event(MachineReport((Finding.of("memory", Message("Memory: 900 MB free")),)))
    said = {one["text"]: one["wrong"] for one in answer["findings"]}
    assert said["Height sensor: broken"] and "Memory: 900 MB free" in said
    assert "voltage" not in str(answer)


def test_no_service_of_the_robot_is_called_from_here() -> None:
    for service in Service:
        asked = mock.Mock()
        NoRequests().ask(service, asked)
        asked.fail.assert_called_once()
