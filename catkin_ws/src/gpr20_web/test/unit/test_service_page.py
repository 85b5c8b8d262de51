"""SERVICE: what is wrong with the robot. Nothing here moves or tests anything."""

from __future__ import annotations

from typing import Any, List
from unittest import mock

from view_kit import snapshot
from web_kit import ManualClock, state_of

from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import MachineReport
from gpr20_doctor.mid.node_health import HealthLevel, HealthReport, NodeHealth
from gpr20_operator.jobs.job import Service
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_web.calls import Call, Person, Role
from gpr20_web.mid.service_page import INTEREST_S, NoRequests, ServicePage

CALL = Call(Person("ana", Role.CONTROL, "s", ""))
SENSOR = NodeHealth("height_sensor", HealthLevel.ERROR, verbatim("broken"), {"voltage_v": 1.3})


def test_the_worst_is_the_first_and_this_computer_is_looked_at_while_somebody_looks() -> None:
    clock = ManualClock()
    asked: List[Any] = []
    page = ServicePage(lambda *wanted: asked.append(wanted), clock)
    page.refresh(snapshot(state=state_of(SurveyState.IDLE), health=HealthReport((SENSOR,))))
    (route,) = page.routes
    answer: Any = route.answer(CALL)
    levels = ["fault", "warning", "unknown", "note", "ok"]
    found = [levels.index(one["level"]) for one in answer["findings"]]
    assert found == sorted(found) and answer["summary"]
    assert "Height sensor: broken" in {one["text"] for one in answer["findings"] if one["wrong"]}
    assert "voltage" not in str(answer)
    route.answer(CALL)
    assert len(asked) == 1
    page.on_event(MachineReport((Finding.of("memory", Message("Memory: 900 MB free")),)))
    after: Any = route.answer(CALL)
    assert len(after["findings"]) > len(answer["findings"])
    clock.time_s += INTEREST_S + 1.0
    page.refresh(snapshot(SurveyState.IDLE))
    # And again when somebody comes back.
    route.answer(CALL)
    assert len(asked) == 2


def test_no_service_of_the_robot_is_called_from_here() -> None:
    for service in Service:
        asked = mock.Mock()
        NoRequests().ask(service, asked)
        asked.fail.assert_called_once()
