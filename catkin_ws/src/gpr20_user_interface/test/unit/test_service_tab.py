"""The SERVICE tab: what a finger does there, and what it shows."""

from dataclasses import replace

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from view_kit import snapshot
from window_helpers import click, hold, show

from gpr20_common.message import Message, verbatim
from gpr20_common.mid.node_software import NodeSoftware
from gpr20_doctor.mid.finding import Unknown
from gpr20_doctor.mid.machine_facts import HardwareUse, MachineFacts
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_doctor.mid.robot_facts import AxisPosition
from gpr20_operator.robot.events import CurrentPosition
from gpr20_operator.robot.health import HealthReport
from gpr20_operator.robot.service_events import (
    AxisMeasured,
    AxisMoved,
    CheckStepTaken,
    EndstopState,
    HeightTested,
    MachineExamined,
)
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.analyzer_test import AnalyzerTest
from gpr20_survey.results.daily_check import Part
from gpr20_user_interface.window.rail import TabName

AT_REST = replace(snapshot(SurveyState.FINISHED), current=CurrentPosition(650.0, 800.0, -90.0))


@pytest.fixture
def service(window):
    show(window, AT_REST)
    window.show_tab(TabName.SERVICE)
    window.refresh()
    window.tools.asked.clear()
    return window


def begin(window):
    window.service.entered.emit()


def test_a_tap_does_not_begin_the_service_but_a_hold_does(service):
    click(service.service.enter_button)
    assert not service.service.in_service
    hold(service.service.enter_button)
    assert service.service.in_service


def test_only_a_hold_moves_an_axis(service):
    begin(service)
    row = service.service.axes.row(AxisId.Y)
    for button in row.buttons:
        click(button)
        QTest.mouseDClick(button, Qt.LeftButton)
    assert service.tools.asked == []
    hold(row.jogs[1])
    assert service.tools.asked == [("y", "JOG", -10.0)]
    # At once: a second touch sends nothing.
    assert not any(button.isEnabled() for button in row.buttons)
    service.on_event(AxisMoved(True, verbatim("The y axis is at 20 mm.")))
    service.refresh()
    assert service.service.outcome.text() == "The y axis is at 20 mm."
    hold(row.home)
    assert service.tools.asked[1:] == [("y", "HOME", 0.0)]
    service.on_event(AxisMoved(True, verbatim("The y axis is at 0 mm.")))
    service.refresh()
    zeros = [row.set_zero for row in service.service.axes.rows]
    assert zeros[:2] == [None, None]
    click(zeros[2])
    assert len(service.tools.asked) == 2
    hold(zeros[2])
    assert service.tools.asked[2:] == [("z", "SET_ZERO", 0.0)]


def test_a_survey_or_a_lost_contact_ends_the_service(service):
    for shown in (snapshot(SurveyState.SURVEYING), snapshot(alive=False)):
        show(service, AT_REST)
        begin(service)
        assert service.service.in_service
        show(service, shown)
        assert not service.service.in_service
        assert not service.service.enter_button.isEnabled()
        assert service.service.hint.text()
        hold(service.service.enter_button)
        assert not service.service.in_service


def test_another_tab_ends_the_service_and_its_subscriptions(service):
    begin(service)
    service.show_tab(TabName.MAP)
    service.refresh()
    assert service.tools.asked == [("watch", False)]
    service.show_tab(TabName.SERVICE)
    service.refresh()
    assert not service.service.in_service


def test_endstops_and_positions_are_shown(service):
    begin(service)
    service.on_event(EndstopState(AxisId.X, True))
    service.on_event(EndstopState(AxisId.Y, False))
    service.on_event(AxisMeasured(AxisId.Y, AxisPosition(0.0, False, False)))
    show(service, AT_REST)
    x, y, z = service.service.axes.rows
    assert [row.place.text() for row in (x, y, z)] == ["X 650.00", "Y not homed", "Z -90.0"]
    assert "closed" in x.lamp.text() and "open" in y.lamp.text()


def test_instruments_are_tested_and_faults_have_their_reason(service):
    begin(service)
    click(service.service.switch_button)
    tools = service.service.tools
    click(tools.measure)
    stuck = Message("the height sensor is stuck; check its plug and supply")
    service.on_event(HeightTested(float("nan"), float("nan"), 3.297, stuck))
    service.refresh()
    assert tools.height_found.toPlainText() == f"Sensor 3.297 V\n{stuck}"
    click(tools.test)
    assert service.tools.asked == ["height", "analyzer"]
    service.on_event(AnalyzerTest("10.0.0.1", "Anritsu,MS2026C", "HIGH", 51, 0.02, -40.0))
    service.refresh()
    lines = tools.analyzer_found.toPlainText().splitlines()
    assert lines[1] == "Anritsu,MS2026C"
    assert lines[2:] == [
        "Calibration: calibrated, accuracy high",
        "Sweep of 51 points: 0.020 s, -40 dB",
    ]


def test_the_daily_check_leads_through_its_parts_to_the_verdict(service):
    begin(service)
    click(service.service.switch_button)
    tools = service.service.tools

    def answered(answer):
        service.on_event(answer)
        service.refresh()

    click(tools.daily)
    assert service.tools.asked == []
    swept = CheckStepTaken(True, verbatim("Swept twice."))
    for number, instruction in ((1, "sky"), (2, "plate"), (3, "reflector")):
        assert tools.daily.text() == f"MEASURE {number}/3"
        assert instruction in tools.daily_found.toPlainText()
        click(tools.daily)
        # At once: a second touch sends nothing.
        assert not tools.daily.isEnabled()
        assert tools.daily_found.toPlainText() == "Measuring"
        if number == 2:
            answered(CheckStepTaken(False, verbatim("no connection to the VNA")))
            assert "no connection" in tools.daily_found.toPlainText()
            assert "plate" in tools.daily_found.toPlainText()
            click(tools.daily)
        if number < 3:
            answered(swept)
    answered(CheckStepTaken(True, verbatim("Good: every figure agrees."), True))
    assert tools.daily_found.toPlainText() == "Good: every figure agrees."
    assert tools.daily.text() == "DAILY CHECK"
    parts = [Part.EMPTY, Part.PLATE, Part.PLATE, Part.REFLECTOR]
    assert service.tools.asked == [("daily check", one) for one in parts]


def test_a_daily_check_that_the_robot_has_given_up_begins_again(service):
    begin(service)
    click(service.service.switch_button)
    tools = service.service.tools
    click(tools.daily)
    click(tools.daily)
    forgotten = Message("a step before this one is missing").with_fault(CHECK_ORDER)
    service.on_event(CheckStepTaken(False, forgotten))
    service.refresh()
    assert tools.daily.text() == "DAILY CHECK"
    assert str(CHECK_ORDER.remedy) in tools.daily_found.toPlainText()


def test_the_findings_are_listed_without_service_and_during_a_survey(service):
    report = NodeHealth("height_sensor", HealthLevel.ERROR, verbatim("stuck"), {})
    show(service, snapshot(SurveyState.SURVEYING, health=HealthReport((report,))))
    service.draw()
    assert service.service.doctor.texts[0].startswith("FAULT: Height sensor: stuck\n")
    show(service, snapshot(SurveyState.SURVEYING))
    service.draw()
    assert not any("Height" in text for text in service.service.doctor.texts)


def test_a_touch_checks_everything_and_the_findings_are_listed(service):
    click(service.service.check_button)
    assert service.tools.asked == [("examine", True), "height", "analyzer"]
    assert not service.service.check_button.isEnabled()
    click(service.service.check_button)
    facts = MachineFacts(HardwareUse.NO_PI, Unknown(verbatim("x")), NodeSoftware(), 85.0)
    service.on_event(MachineExamined(facts))
    service.on_event(HeightTested(0.2, 0.001, 1.2))
    lost = Message("no connection to the VNA")
    service.on_event(AnalyzerTest("10.0.0.1", failure=lost))
    service.refresh()
    service.draw()
    assert len(service.tools.asked) == 3
    assert service.service.check_button.isEnabled()
    listed = "\n".join(service.service.doctor.texts)
    assert "FAULT: Temperature of the processor: 85 °C" in listed
    assert "FAULT: Test of the VNA: no connection" in listed


def test_instruments_are_not_tested_beside_a_survey(service):
    show(service, snapshot(SurveyState.SURVEYING))
    click(service.service.check_button)
    assert service.tools.asked == [("examine", True)]
