"""ROBOT: what a finger does there, and what it shows."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from view_kit import snapshot
from window_helpers import click, hold, show

from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.finding import Level
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, HealthReport, NodeHealth
from gpr20_operator.jobs.job import Service
from gpr20_operator.robot.events import CurrentPosition
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import CHECK_ORDER, NOT_HOMED
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.answers import Part
from gpr20_user_interface.pages.robot import LEVEL_LOOKS
from gpr20_user_interface.widgets.bars import TabName

AT_REST = replace(snapshot(SurveyState.FINISHED), current=CurrentPosition(650.0, 800.0, -90.0))


@pytest.fixture
def service(window):
    show(window, AT_REST)
    window.show_tab(TabName.ROBOT)
    window.refresh()
    window.tools.asked.clear()
    return window


def test_only_a_hold_begins_the_service_and_moves_an_axis(service):
    click(service.robot.overview.enter_button)
    assert not service.robot.in_service
    hold(service.robot.overview.enter_button)
    assert service.robot.in_service
    moves, asked = service.robot.service.moves, []
    assert [len(moves[axis]) for axis in AxisId] == [7, 7, 8]
    for axis, place, wish in (
        (AxisId.Y, 1, ("y", "JOG", -10.0)),
        (AxisId.Y, 6, ("y", "HOME", 0.0)),
        (AxisId.Z, 7, ("z", "SET_ZERO", 0.0)),
    ):
        for button in moves[axis]:
            click(button)
            QTest.mouseDClick(button, Qt.LeftButton)
        assert service.tools.asked == asked
        hold(moves[axis][place])
        asked.append(wish)
        assert service.tools.asked == asked
        # At once: a second touch sends nothing.
        assert not any(button.isEnabled() for button in moves[axis])
        service.tools.done(Service.MOVE, verbatim("The axis is at 20 mm."))
        service.refresh()
        assert service.robot.service.outcome.text() == "The axis is at 20 mm."


def test_the_daily_check_leads_through_its_parts_to_the_verdict(service):
    service.robot.overview.entered.emit()
    click(service.robot.service.switch_button)
    daily, tools = service.robot.service.daily, service.tools
    answer = service.robot.service.answers[daily]
    forgotten = Message("a step before this one is missing").with_fault(CHECK_ORDER)
    for number, instruction, end, said, shown in (
        (1, "sky", tools.done, verbatim("Swept twice."), "plate"),
        (2, "plate", tools.fail, verbatim("no connection"), "No connection"),
        (2, "plate", tools.done, verbatim("Swept twice."), "reflector"),
        (3, "reflector", tools.done, verbatim("Good."), "Good."),
        # One that the robot has given up begins again.
        (1, "sky", tools.fail, forgotten, str(CHECK_ORDER.remedy)),
    ):
        if daily.text() == "DAILY\nCHECK":
            click(daily)
        assert daily.text() == f"MEASURE\n{number}/3" and instruction in answer.toPlainText()
        click(daily)
        # At once: a second touch sends nothing.
        assert not daily.isEnabled()
        end(Service.DAILY, said)
        service.refresh()
        assert shown.lower() in answer.toPlainText().lower()
    parts = [Part.EMPTY, Part.PLATE, Part.PLATE, Part.REFLECTOR, Part.EMPTY]
    assert tools.asked == [("daily check", one) for one in parts]


def test_what_is_not_known_never_looks_good(service):
    overview = service.robot.overview
    nodes = tuple(NodeHealth(name, HealthLevel.OK, verbatim("fine"), {}) for name in EXPECTED_NODES)
    show(service, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    service.refresh()
    unknown = overview.listed
    assert unknown and all(one.level is Level.UNKNOWN for one in unknown)
    assert all(str(one.text) in overview.table.text() for one in unknown)
    assert overview.headline.text() == f"UNKNOWN: {len(unknown)}"
    assert overview.headline.property("level") == "doubtful"
    assert LEVEL_LOOKS[Level.UNKNOWN] not in (LEVEL_LOOKS[Level.OK], LEVEL_LOOKS[Level.NOTE])


def test_a_part_is_known_by_its_sign_and_colour_and_opens_its_report(service):
    levels = (HealthLevel[one] for one in ("ERROR", "OK", "WARN", "STALE", "WARN"))
    said = verbatim("no answer")
    # What the next survey does by itself is no warning, as for the doctor.
    homes = said.with_fault(NOT_HOMED.as_warning())
    nodes = tuple(NodeHealth(*one, {}) for one in zip(EXPECTED_NODES, levels, [said] * 4 + [homes]))
    show(service, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    tiles = service.robot.overview.tiles
    assert [tile.property("level") for tile in tiles] == ["bad", "good", "doubtful", "bad", "rest"]
    # One word for the worst of checks and parts.
    assert service.robot.overview.headline.text() == "FAULT: 2"
    click(tiles[0])
    assert service.notice.title.text() == "Main control: FAULT"
