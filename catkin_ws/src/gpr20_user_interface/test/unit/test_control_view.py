from dataclasses import replace

import pytest
from PyQt5.QtWidgets import QLabel
from window_helpers import (
    application,
    click,
    enter,
    hold_to_start,
    show,
    snapshot,
    start,
    window,
    wishes,
)

from gpr20_survey.plan.site import Site
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_user_interface.mid.events import Request, RobotDefaults
from gpr20_user_interface.mid.parameter_form import (
    ANALYZER_FIELDS,
    FIELDS,
    default_parameters,
)
from gpr20_user_interface.mid.replay import ReplayMark, ReplayView
from gpr20_user_interface.mid.survey_preview import preview

__all__ = ["application", "window"]

ARROW_FIELDS = [
    field.name
    for field in FIELDS
    if field.name not in ("vna_address", "polarizations_deg") and not field.choices
]


def text(window, name):
    return window.control.form.edit(name).text()


def test_start_carries_what_the_operator_entered(window):
    received = wishes(window)
    show(window, snapshot(SurveyState.IDLE))
    enter(window, "x_points", "7")
    enter(window, "start_frequency_hz", "700.5")
    for number, part in enumerate(("10", "0", "7", "23")):
        window.control.form.octet(number).setText(part)
    start(window)
    assert received[0].vna_address == "10.0.7.23"
    assert (received[0].x_points, received[0].start_frequency_hz) == (7, 700.5e6)


def test_a_replay_offers_no_notes(window):
    replayed = snapshot(SurveyState.SURVEYING)
    for replay in (ReplayView(ReplayMark(), True, SurveyState.SURVEYING), None):
        show(window, replace(replayed, replay=replay))
        assert window.control.notes.isEnabled() is (replay is None)


@pytest.mark.parametrize("name", ARROW_FIELDS)
@pytest.mark.parametrize("step", [1, 10])
def test_arrows_change_a_field_by_the_chosen_step(window, name, step):
    show(window, snapshot(SurveyState.IDLE))
    window.control.form.show_text(name, "40")
    click(window.control.step_button(step))
    field = window.control.form.field(name)
    click(field.up)
    click(field.up)
    assert text(window, name) == str(40 + 2 * step)
    click(field.down)
    assert text(window, name) == str(40 + step)


def test_settings_of_the_vna_are_chosen_with_the_arrows_and_reach_the_survey(window):
    received = wishes(window)
    show(window, snapshot(SurveyState.IDLE))
    form = window.control.form
    assert [form.edit(name).placeholderText() for name in ANALYZER_FIELDS] == ["as set"] * 3
    for _ in range(3):
        click(form.field("if_bandwidth_hz").up)
    click(form.field("averages").up)
    click(form.field("output_power").up)
    start(window)
    assert received[0].sweep_settings.analyzer == AnalyzerSettings(50.0, 1, "LOW")
    for name in ANALYZER_FIELDS:
        for _ in range(3):
            click(form.field(name).down)
    start(window)
    assert not received[1].sweep_settings.analyzer.is_known


def test_arrows_end_where_the_axis_ends(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.step_button(100))
    for _ in range(8):
        click(window.control.form.field("x_stop_mm").up)
    assert text(window, "x_stop_mm") == "650"
    for _ in range(8):
        click(window.control.form.field("x_stop_mm").down)
    assert text(window, "x_stop_mm") == "0"


@pytest.mark.parametrize(
    ("name", "wrong", "words"),
    [
        ("start_frequency_hz", "0", "from 0.005 to 6000"),
        ("start_frequency_hz", "6000", "below the stop frequency"),
        ("stop_frequency_hz", "6000.1", "from 0.005 to 6000"),
        ("frequency_points", "0", "from 2 to 4000"),
        ("frequency_points", "4001", "from 2 to 4000"),
        ("x_start_mm", "-1", "from 0 to 650"),
        ("x_stop_mm", "651", "from 0 to 650"),
        ("y_start_mm", "nan", "from 0 to 800"),
        ("y_stop_mm", "800.1", "from 0 to 800"),
        ("x_points", "2", "3 or more"),
        ("y_points", "x", "3 or more"),
        ("x_stop_mm", "49,5", "a number such as 12.5, from 0 to 650"),
        ("stop_frequency_hz", "6GHz", "a number such as 12.5, from 0.005 to 6000"),
        ("x_points", "90000", "at least 0.01 mm apart"),
        ("polarizations_deg", "0, 91", "from -90 to 90"),
        ("if_bandwidth_hz", "0.1", "as set on the VNA; the MS2026C has 10, 20"),
        ("averages", "70000", "a whole number from 1 to 65535"),
        ("output_power", "a b", "the MS2026C has LOW and HIGH"),
    ],
)
def test_wrong_field_turns_says_what_is_allowed_and_locks_start(window, name, wrong, words):
    received = wishes(window)
    show(window, snapshot(SurveyState.IDLE))
    edit = window.control.form.edit(name)
    right, before = edit.text(), edit.grab().toImage().pixelColor(10, 10)
    enter(window, name, wrong)
    assert edit.grab().toImage().pixelColor(10, 10) != before
    assert words in window.control.problems.toPlainText()
    assert words in edit.toolTip()
    assert window.control.problems.isVisible() and not window.control.preview.isVisible()
    start(window)
    assert received == []
    enter(window, name, right)
    assert window.control.problems.toPlainText() == ""
    start(window)
    assert len(received) == 1


def test_too_many_points_in_all_turn_the_fields_of_both_axes(window):
    show(window, snapshot(SurveyState.IDLE))
    for name in ("x_points", "y_points"):
        enter(window, name, "1000")
    for name in ("x_points", "y_points"):
        said = window.control.form.edit(name).toolTip()
        assert "at most 1000000 traces per survey" in said
    assert not window.control.start.isEnabled()


@pytest.mark.parametrize("octet", range(4))
@pytest.mark.parametrize("wrong", ["256", "", "x", "01"])
def test_each_number_of_the_address_is_checked(window, octet, wrong):
    show(window, snapshot(SurveyState.IDLE))
    window.control.form.octet(octet).setText(wrong)
    assert "four whole numbers" in window.control.problems.toPlainText()
    assert not window.control.start.isEnabled()


def test_limits_that_become_known_are_applied_to_what_stands_there(window):
    enter(window, "x_stop_mm", "700")
    show(window, snapshot(SurveyState.IDLE, travel=None))
    assert window.control.start.isEnabled()
    show(window, snapshot(SurveyState.IDLE))
    assert not window.control.start.isEnabled()


@pytest.mark.parametrize("code", list(SurveyState))
def test_fields_are_locked_while_a_survey_runs_and_only_then(window, code):
    show(window, snapshot(code))
    assert window.control.form.isEnabled() is not code.running
    assert window.control.start.isEnabled() is not code.running
    assert window.control.pause.isEnabled() is (code in (SurveyState.SURVEYING, SurveyState.PAUSED))


def test_parameters_of_a_survey_that_was_started_elsewhere_are_shown(window):
    theirs = default_parameters()
    theirs = type(theirs)(**{**theirs.__dict__, "x_points": 17, "vna_address": "10.1.2.3"})
    show(window, snapshot(SurveyState.SURVEYING, survey_parameters=theirs))
    assert text(window, "x_points") == "17"
    assert window.control.parameters == theirs


def test_keys_that_are_open_when_a_survey_begins_elsewhere_change_nothing(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.form.edit("x_start_mm"))
    show(window, snapshot(SurveyState.SURVEYING, survey_parameters=default_parameters()))
    assert not window.number_pad.isVisible()
    assert window.control.parameters == default_parameters()


def test_pause_becomes_resume(window):
    received = wishes(window)
    show(window, snapshot(SurveyState.SURVEYING))
    assert window.control.pause.text() == "PAUSE"
    click(window.control.pause)
    show(window, snapshot(SurveyState.SURVEYING, pending=frozenset([Request.PAUSE])))
    assert not window.control.pause.isEnabled()
    show(window, snapshot(SurveyState.PAUSED))
    assert window.control.pause.text() == "RESUME"
    click(window.control.pause)
    assert received == ["pause"]
    hold_to_start(window)
    assert received == ["pause", "resume"]


def test_what_the_survey_will_be_is_shown(window):
    window.control.preview.show_preview(preview(default_parameters()))
    assert window.control.preview.figures[:3] == ("50", "25, 25 mm", "10.8 MHz")
    assert window.control.preview.figures[5:] == ("27.76 mm", "13.88 m", "25")


def test_number_pad_writes_a_field_and_judges_while_it_does(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.form.edit("x_stop_mm"))
    pad = window.number_pad
    assert pad.isVisible() and pad.edit.text() == "150"
    assert pad.hint.text() == "from 0 to 650"
    for character in "700":
        pad.press(character)
    assert pad.edit.property("wrong") is True
    click(pad.erase)
    pad.press("5")
    assert (pad.edit.text(), pad.edit.property("wrong")) == ("705", True)
    pad.press(",")
    assert pad.hint.text() == "a number such as 12.5, from 0 to 650"
    click(pad.clear)
    for character in "600.5":
        pad.press(character)
    assert pad.edit.property("wrong") is False
    assert pad.hint.text() == "from 0 to 650"
    click(pad.accept_button)
    assert not pad.isVisible()
    assert text(window, "x_stop_mm") == "600.5"


def test_number_pad_that_is_cancelled_changes_nothing(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.form.octet(2))
    window.number_pad.press("9")
    click(window.number_pad.cancel)
    assert window.control.form.octet(2).text() == "0"
    assert not window.number_pad.isVisible()


def test_the_address_of_the_configuration_is_proposed_until_the_operator_chooses_another(window):
    configured = RobotDefaults("192.168.1.10", Site())
    show(window, snapshot(SurveyState.IDLE, defaults=None))
    assert window.control.form.texts()["vna_address"] == ""
    show(window, snapshot(SurveyState.IDLE, defaults=configured))
    assert window.control.form.texts()["vna_address"] == "192.168.1.10"
    window.control.form.show_text("vna_address", "10.0.0.7")
    show(window, snapshot(SurveyState.IDLE, defaults=RobotDefaults("192.168.1.11", Site())))
    assert window.control.form.texts()["vna_address"] == "10.0.0.7"


def test_a_visa_resource_of_the_configuration_is_shown_and_used(window):
    resource = "GPIB0::16::INSTR"
    show(window, snapshot(SurveyState.IDLE, defaults=RobotDefaults(resource, Site())))
    form = window.control.form
    assert form.texts()["vna_address"] == resource
    assert not form.octet(0).isVisible()
    assert resource in [label.text() for label in form.findChildren(QLabel) if label.isVisible()]
    assert window.control.parameters.vna_address == resource
    # Parameters of a survey of a robot with an MS2026C.
    form.show_text("vna_address", "10.0.0.7")
    assert form.texts()["vna_address"] == "10.0.0.7" and form.octet(0).isVisible()
