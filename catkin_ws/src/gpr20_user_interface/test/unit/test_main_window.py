from view_kit import snapshot
from window_helpers import click, show, wishes

from gpr20_common.faults import DISK_FULL
from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_operator.robot.condition import JobLevel
from gpr20_operator.robot.events import ControlState, Progress
from gpr20_operator.robot.health import HealthReport
from gpr20_operator.robot.notices import Refused, refusal_notice
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.window.rail import TabName


def test_state_and_progress_are_seen_from_every_tab(window):
    show(window, snapshot(SurveyState.SURVEYING, progress=Progress("id", 99.99, 90, 89, 61.0)))
    assert window.top_bar.band.title.whole == "SURVEYING 99 %"
    assert window.top_bar.band.message.whole == "2 min left"
    assert window.top_bar.band.simulated.isVisible()


def test_trouble_cannot_be_overlooked_and_goes_when_its_cause_goes(window):
    failed = NodeHealth("vna_acquisition", HealthLevel.ERROR, verbatim("no answer"), {})
    for known, title, words in (
        ({"master_alive": False}, "NO CONTACT", "ROS master does not answer: the robot may"),
        ({"alive": False}, "NO CONTACT", "No contact with the main control for 7 s: the robot may"),
        ({"health": HealthReport((failed,))}, "SURVEYING", "VNA driver: no answer"),
    ):
        show(window, snapshot(SurveyState.SURVEYING, **known))
        band = window.top_bar.band
        assert band.level in (JobLevel.FAULT, JobLevel.ATTENTION)
        assert words in band.message.whole
        assert band.title.whole == title
        show(window, snapshot(SurveyState.SURVEYING))
        assert band.level is JobLevel.WORKING
        assert words not in band.message.whole


def test_refusal_is_a_dialog_with_reason_and_next_step_that_leaves_stop_free(window):
    received = wishes(window)
    show(window, snapshot(SurveyState.SURVEYING))
    reason = verbatim("<b>the reason</b>")
    for number, refused in enumerate(Refused, 1):
        window.notice.show_notice(refusal_notice(refused, reason))
        assert window.notice.isVisible()
        assert window.notice.reason.toPlainText() == "<b>the reason</b>"
        assert window.notice.first.isVisible() and window.notice.first.text()
        assert not window.notice.geometry().intersects(window.top_bar.geometry())
        click(window.top_bar.stop)
        assert received == ["stop"] * number
        click(window.notice.close_button)
        assert not window.notice.isVisible()


NO_SPACE = Message(
    "the disk is full", details="[Errno 28] No space left on device: '/data/traces/7.json'"
).with_fault(DISK_FULL)
DETAILS = f"{DISK_FULL.code}\n{NO_SPACE.details}"


def test_details_of_a_refusal_are_behind_a_button(window):
    notice = window.notice
    notice.show_notice(refusal_notice(Refused.START, NO_SPACE))
    assert notice.reason.toPlainText() == "The disk is full"
    assert not notice.details.isVisible()
    click(notice.details_button)
    assert notice.details.isVisible()
    assert notice.details.toPlainText() == DETAILS
    click(notice.details_button)
    assert notice.reason.isVisible() and not notice.details.isVisible()
    notice.show_notice(refusal_notice(Refused.START, verbatim("no details")))
    assert not notice.details_button.isVisible()


def test_touch_on_the_band_opens_the_fault_with_its_details(window):
    received = wishes(window)
    status = Message("Paused: {reason}", reason=NO_SPACE)
    state = ControlState(SurveyState.PAUSED, status, "id", True)
    show(window, snapshot(SurveyState.PAUSED, state=state))
    window.notice.hide()
    click(window.top_bar.band.message)
    assert window.notice.isVisible()
    assert window.notice.title.text() == "The survey is PAUSED by a fault."
    assert window.notice.reason.toPlainText() == "The disk is full"
    assert window.notice.details.toPlainText() == DETAILS
    assert window.notice.first.text() == str(DISK_FULL.remedy)
    click(window.top_bar.stop)
    assert received == ["stop"]


def test_touch_on_a_node_opens_its_message_details_and_values(window):
    window.show_tab(TabName.ROBOT)
    nodes = (
        NodeHealth("main_control", HealthLevel.OK, verbatim("measuring"), {}),
        NodeHealth("vna_processing", HealthLevel.ERROR, NO_SPACE, {"free disk [MB]": "0.0"}),
    )
    show(window, snapshot(SurveyState.IDLE, health=HealthReport(nodes)))
    show(window, window.survey.snapshot)
    click(window.robot.overview.parts.tile("vna_processing"))
    assert window.notice.title.text() == "Storage: FAULT"
    assert window.notice.reason.toPlainText() == "The disk is full"
    assert window.notice.first.text() == str(DISK_FULL.remedy)
    assert window.notice.details.toPlainText().splitlines() == [
        *DETAILS.splitlines(),
        "node: vna_processing",
        "free disk [MB]: 0.0",
    ]
