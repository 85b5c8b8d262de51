"""ROBOT: what a finger does there, and what it shows."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QTextDocumentFragment
from PyQt5.QtTest import QTest
from view_kit import snapshot
from window_helpers import click, hold, show

from gpr20_common.faults import OVERLOADED
from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import MachineReport
from gpr20_doctor.mid.node_health import (
    EXPECTED_NODES,
    HealthLevel,
    HealthReport,
    NodeHealth,
)
from gpr20_doctor.mid.robot_facts import AxisReport, Endstop
from gpr20_operator.jobs.job import Service
from gpr20_operator.robot.events import CurrentPosition
from gpr20_operator.robot.service_model import HeightTested
from gpr20_survey.axes import AxisId
from gpr20_survey.faults import CHECK_ORDER, NOT_HOMED
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.answers import AnalyzerTest, Part
from gpr20_user_interface.look.look import TOUCH_PX
from gpr20_user_interface.widgets.bars import TabName

AT_REST = replace(snapshot(SurveyState.FINISHED), current=CurrentPosition(650.0, 800.0, -90.0))


@pytest.fixture
def service(window):
    show(window, AT_REST)
    window.show_tab(TabName.ROBOT)
    window.refresh()
    window.tools.asked.clear()
    return window


def listed(window):
    """Return the findings that are shown."""
    shown = QTextDocumentFragment.fromHtml(window.robot.overview.table.text()).toPlainText()
    found = window.robot.overview.listed
    assert all(str(one.text) in shown for one in found)
    return [f"{one.level.title}: {one.text}" for one in found]


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


def test_endstops_and_positions_are_shown(service):
    service.robot.overview.entered.emit()
    service.on_event(Endstop(AxisId.X, True))
    service.on_event(Endstop(AxisId.Y, False))
    known = (
        AxisReport(AxisId.X, 650.0, True, False),
        *(AxisReport(AxisId.Y, 0.0, False, False), AxisReport(AxisId.Z, -90.0, True, False)),
    )
    show(service, replace(AT_REST, axes=known))
    page = service.robot.service
    places = [one.text() for one in page.places.values()]
    assert places == ["X 650.00 mm", "Y not homed", "Z -90.0°"]
    assert [one.text() for one in page.lamps.values()] == ["● closed", "○ open"]


def test_instruments_are_tested_and_faults_have_their_reason(service):
    service.robot.overview.entered.emit()
    click(service.robot.service.switch_button)
    tools = service.robot.service
    click(tools.measure)
    stuck = Message("the height sensor is stuck; check its plug and supply")
    failed = HeightTested(float("nan"), float("nan"), 3.297, stuck)
    service.tools.done(Service.HEIGHT, failed)
    service.refresh()
    assert tools.answers[tools.measure].toPlainText() == f"Sensor 3.297 V\n{stuck}"
    click(tools.analyzer)
    assert service.tools.asked == ["height", "analyzer"]
    tested = AnalyzerTest("10.0.0.1", "Anritsu,MS2026C", "HIGH", 51, 0.02, -40.0)
    service.tools.done(Service.ANALYZER, tested)
    service.refresh()
    lines = tools.answers[tools.analyzer].toPlainText().splitlines()
    assert lines[1] == "Anritsu,MS2026C"
    assert lines[2:] == [
        "Calibration: calibrated, accuracy high",
        "Sweep of 51 points: 0.020 s, -40 dB",
    ]


def test_the_daily_check_leads_through_its_parts_to_the_verdict(service):
    service.robot.overview.entered.emit()
    click(service.robot.service.switch_button)
    daily = service.robot.service.daily
    answer, tools = service.robot.service.answers[daily], service.tools
    click(daily)
    assert tools.asked == []
    failed = verbatim("no connection to the VNA")
    forgotten = Message("a step before this one is missing").with_fault(CHECK_ORDER)
    for number, instruction, end, shown in (
        (1, "sky", lambda: tools.done(Service.DAILY, verbatim("Swept twice.")), "plate"),
        (2, "plate", lambda: tools.fail(Service.DAILY, failed), "no connection"),
        (2, "plate", lambda: tools.done(Service.DAILY, verbatim("Swept twice.")), "reflector"),
        (3, "reflector", lambda: tools.done(Service.DAILY, verbatim("Good.")), "Good."),
        # One that the robot has given up begins again.
        (1, "sky", lambda: tools.fail(Service.DAILY, forgotten), str(CHECK_ORDER.remedy)),
    ):
        if daily.text().split() == ["DAILY", "CHECK"]:
            click(daily)
        assert daily.text().split() == ["MEASURE", f"{number}/3"]
        assert instruction in answer.toPlainText()
        click(daily)
        # At once: a second touch sends nothing.
        assert not daily.isEnabled() and answer.toPlainText() == "Measuring"
        end()
        service.refresh()
        assert shown in answer.toPlainText()
    assert daily.text().split() == ["DAILY", "CHECK"]
    parts = [Part.EMPTY, Part.PLATE, Part.PLATE, Part.REFLECTOR, Part.EMPTY]
    assert tools.asked == [("daily check", one) for one in parts]


def test_a_touch_checks_everything_and_the_findings_are_listed(service):
    click(service.robot.overview.check_button)
    assert service.tools.asked == [("examine", True), "height", "analyzer"]
    assert not service.robot.overview.check_button.isEnabled()
    click(service.robot.overview.check_button)
    hot = Finding.of("memory", Message("Memory: 9 MB free"), OVERLOADED)
    service.on_event(MachineReport((hot,)))
    service.tools.done(Service.HEIGHT, HeightTested(0.2, 0.001, 1.2))
    lost = Message("no connection to the VNA")
    service.tools.done(Service.ANALYZER, AnalyzerTest("10.0.0.1", failure=lost))
    service.refresh()
    service.draw()
    assert len(service.tools.asked) == 3
    assert service.robot.overview.check_button.isEnabled()
    texts = "\n".join(listed(service))
    assert "FAULT: Memory: 9 MB free" in texts
    assert "FAULT: Test of the VNA: no connection" in texts


def test_what_is_not_known_is_listed_and_what_is_good_is_not(service):
    overview = service.robot.overview
    nodes = tuple(NodeHealth(name, HealthLevel.OK, verbatim("fine"), {}) for name in EXPECTED_NODES)
    show(service, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    service.draw()
    unknown = listed(service)
    assert unknown and all(text.startswith("UNKNOWN") for text in unknown)
    assert overview.headline.text() == f"UNKNOWN: {len(unknown)}"
    assert overview.headline.property("level") == "doubtful"
    # During a survey too.
    stuck = NodeHealth("height_sensor", HealthLevel.ERROR, verbatim("stuck"), {})
    for reports in ((stuck,), ()):
        show(service, snapshot(SurveyState.SURVEYING, health=HealthReport(reports)))
        service.draw()
        said = listed(service)[0].startswith("FAULT: Height sensor: stuck")
        assert said is bool(reports)


def test_a_part_is_known_by_its_sign_and_colour_and_opens_its_report(service):
    levels = (HealthLevel[one] for one in ("ERROR", "OK", "WARN", "STALE", "WARN"))
    said = verbatim("no answer")
    # What the next survey does by itself is no warning, as for the doctor.
    homes = said.with_fault(NOT_HOMED.as_warning())
    nodes = tuple(NodeHealth(*one, {}) for one in zip(EXPECTED_NODES, levels, [said] * 4 + [homes]))
    for _ in range(2):  # its colour has its size with the next refresh
        show(service, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    tiles = service.robot.overview.tiles
    assert [tile.property("level") for tile in tiles] == ["bad", "good", "doubtful", "bad", "rest"]
    for tile in tiles:
        assert tile.isVisible() and tile.height() >= TOUCH_PX
    # One word for the worst of checks and parts.
    assert service.robot.overview.headline.text() == "FAULT: 2"
    click(tiles[0])
    assert service.notice.title.text() == "Main control: FAULT"
    # Other sensors have tiles below the nodes.
    soil = NodeHealth("sensors/soil", HealthLevel.OK, verbatim("0.25 m3/m3"), {})
    show(service, snapshot(SurveyState.IDLE, health=HealthReport((*nodes, soil))))
    assert "soil" in service.robot.overview.tiles[len(nodes)].sentence.text()
    assert service.minimumSizeHint().height() <= 480
