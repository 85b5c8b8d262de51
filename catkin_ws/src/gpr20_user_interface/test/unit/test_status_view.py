from fake_clock import FakeClock
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QLabel
from view_kit import snapshot
from window_helpers import click, show

from gpr20_common.message import verbatim
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth
from gpr20_operator.robot.events import CurrentPosition, Progress, TargetPosition
from gpr20_operator.robot.health import SIMULATOR, HealthReport, HealthTracker
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_user_interface.look.look import TOUCH_PX
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.window.rail import TabName


def test_progress_is_shown_and_never_full_before_the_end(window):
    progress = Progress("id", 99.999, 20000, 19999, 1128.0)
    show(window, snapshot(SurveyState.SURVEYING, progress=progress))
    assert window.status.progress.thousandths == 999
    assert window.status.progress.text == "19999 of 20000 traces, 19 min left (measured)"
    show(window, snapshot(SurveyState.SURVEYING, progress=Progress("id", 0.0, 18, 0, 60.0)))
    assert window.status.progress.text == "0 of 18 traces, 1 min left (by the plan)"


def test_no_time_is_left_when_none_passes(window):
    for code in (SurveyState.PAUSED, SurveyState.STOPPED, SurveyState.FAILED, SurveyState.IDLE):
        show(window, snapshot(code, progress=Progress("id", 50.0, 18, 9, 1128.0)))
        assert window.status.progress.text == "9 of 18 traces"
        for label in window.findChildren(QLabel):
            assert "left" not in label.text() and "remaining" not in label.text()


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
    assert health.texts("vna_acquisition") == "FAULT: No answer"
    assert health.texts("vna_processing") == "GOOD: Storing"
    assert health.texts("y_axis/axis_driver") == "WARNING: Not homed"
    assert health.texts("main_control") == "OFFLINE: No report"
    facts = window.status.facts
    assert (facts.disk, facts.calibration) == (
        "12.3 GB",
        shown_text(CalibrationStatus.HIGH.meaning),
    )


def test_unknown_disk_and_calibration_are_said_to_be_unknown(window):
    show(window, snapshot(SurveyState.IDLE))
    assert (window.status.facts.disk, window.status.facts.calibration) == ("—", "—")


def test_other_sensors_have_tiles_below_the_nodes(window):
    clock = FakeClock()
    tracker = HealthTracker(clock)
    for name in ("sensors/soil", "somebody_else", *(f"sensors/s{n:02}" for n in range(40))):
        tracker.note(
            NodeHealth(name, HealthLevel.OK, verbatim("0.25 m3/m3, received 0.2 s ago"), {})
        )
    names = [node.name for node in tracker.report().nodes]
    assert names[: len(EXPECTED_NODES)] == list(EXPECTED_NODES)
    assert len(names) == len(EXPECTED_NODES) + 32
    assert "somebody_else" not in names
    show(window, snapshot(SurveyState.IDLE, health=tracker.report()))
    tile = window.status.health.tile("sensors/soil")
    assert tile.name.whole == "Sensor soil"
    assert window.status.health.texts("sensors/soil") == "GOOD: 0.25 m3/m3, received 0.2 s ago"
    assert window.minimumSizeHint().height() <= 480
    clock.advance(5.0)
    assert tracker.report().node("sensors/soil").level is HealthLevel.STALE


def test_every_part_is_a_tile_for_a_gloved_finger(window):
    nodes = tuple(
        NodeHealth(name, HealthLevel.OK, verbatim("fine"), {})
        for name in (*EXPECTED_NODES, SIMULATOR)
    )
    window.show_tab(TabName.STATUS)
    click(window.status.parts_button)
    show(window, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    QTest.qWait(1)
    tiles = [window.status.health.tile(node.name) for node in nodes]
    for tile in tiles:
        assert tile.isVisible() and tile.height() >= TOUCH_PX
    opened = []
    window.status.health.node_touched.connect(opened.append)
    click(tiles[-1])
    assert opened == [nodes[-1]]
