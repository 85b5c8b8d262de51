import pytest

pytest.importorskip("PyQt5")

from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QTextEdit
from window_helpers import application, show, snapshot, window

from gpr20_common.message import verbatim
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import (
    CurrentPosition,
    HealthLevel,
    NodeHealth,
    Progress,
    TargetPosition,
)
from gpr20_user_interface.mid.robot_health import HealthReport
from gpr20_user_interface.views.main_window import TabName

__all__ = ["application", "window"]


@pytest.mark.parametrize("code", list(SurveyState))
def test_title_is_what_main_control_says(window, code):
    show(window, snapshot(code))
    assert window.status.message.title == code.name
    assert window.status.message.message == "as it is"


def test_progress_is_shown_and_never_full_before_the_end(window):
    progress = Progress("id", 99.999, 20000, 19999, 1128.0)
    show(window, snapshot(SurveyState.SURVEYING, progress=progress))
    assert window.status.progress.thousandths == 999
    assert window.status.progress.texts == (
        "19999 of 20000 traces, 1 to go\n0d:0h:18m:48s remaining (measured)"
    )
    show(window, snapshot(SurveyState.SURVEYING, progress=Progress("id", 0.0, 18, 0, 60.0)))
    assert "0d:0h:1m:0s remaining (by the plan)" in window.status.progress.texts


def test_positions_are_shown_or_said_to_be_unknown(window):
    show(
        window,
        snapshot(
            SurveyState.SURVEYING,
            current=CurrentPosition(1.0, 2.5, -90.0),
            target=TargetPosition(650.0, 800.0, 90.0),
            height_m=0.3121,
        ),
    )
    positions = window.status.positions
    cells = [positions.cell("current", column) for column in range(1, 5)]
    assert cells == ["1.00", "2.50", "-90.00", "0.312"]
    assert positions.cell("target", 1) == "650.00"
    show(window, snapshot(SurveyState.IDLE))
    assert positions.cell("current", 1) == positions.cell("current", 4) == "—"


def test_health_of_every_node_is_shown_in_its_own_words(window):
    nodes = (
        NodeHealth(
            "vna_acquisition", HealthLevel.ERROR, verbatim("no answer"), {"calibration": "HIGH"}
        ),
        NodeHealth(
            "vna_processing", HealthLevel.OK, verbatim("storing"), {"free disk [MB]": "12345.6"}
        ),
        NodeHealth("y_axis/axis_driver", HealthLevel.WARN, verbatim("not homed"), {}),
        NodeHealth("main_control", HealthLevel.STALE, verbatim("was fine"), {}),
    )
    show(window, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    health = window.status.health
    assert health.texts("vna_acquisition") == "FAULT: no answer"
    assert health.texts("vna_processing") == "GOOD: storing"
    assert health.texts("y_axis/axis_driver") == "WARNING: not homed"
    assert health.texts("main_control") == "OFFLINE: no report"
    # The line of a node that is gone has no more text; the room is for those with reasons.
    assert health.details == "VNA driver: no answer\nY axis: not homed"
    assert (health.disk, health.calibration) == ("12.3 GB", "high accuracy")


def test_unknown_disk_and_calibration_are_said_to_be_unknown(window):
    show(window, snapshot(SurveyState.IDLE))
    assert (window.status.health.disk, window.status.health.calibration) == ("—", "—")


def test_line_of_a_node_that_is_cut_is_read_to_its_end_below(window):
    identity = "Anritsu,MS2026C/2,SIMULATED,1.23" + "X" * 60
    words = f"connected to {identity}"
    nodes = (
        NodeHealth("vna_acquisition", HealthLevel.OK, verbatim(words), {}),
        NodeHealth("height_sensor", HealthLevel.OK, verbatim("height 0.200 m"), {}),
    )
    show(window, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    show(window, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    assert window.status.health.details == f"VNA driver: {words}"


def test_faults_are_read_before_warnings(window):
    nodes = (
        NodeHealth("main_control", HealthLevel.WARN, verbatim("paused"), {}),
        NodeHealth("height_sensor", HealthLevel.ERROR, verbatim("stuck"), {}),
    )
    show(window, snapshot(SurveyState.PAUSED, health=HealthReport(nodes)))
    assert window.status.health.details == "Height sensor: stuck\nMain control: paused"


def test_scroll_bar_goes_when_a_long_text_gives_way_to_a_short_one(window):
    window.show_tab(TabName.STATUS)
    bar = window.status.health.findChild(QTextEdit).verticalScrollBar()
    for count, needed in ((40, True), (1, False)):
        words = "the height sensor reads nothing; check it. " * count
        nodes = (NodeHealth("height_sensor", HealthLevel.ERROR, verbatim(words), {}),)
        show(window, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
        QTest.qWait(1)
        assert bar.isVisible() == needed
