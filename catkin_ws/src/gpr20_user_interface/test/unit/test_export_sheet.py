"""The export of a stored survey in the window: what, where, progress, end."""

import dataclasses

import pytest
from view_kit import FOLDER, SURVEY, past_survey, snapshot
from window_helpers import click, show

from gpr20_common.message import verbatim
from gpr20_operator.ground.trace_events import SurveysListed
from gpr20_operator.jobs.export import ExportPart, ExportState
from gpr20_operator.jobs.imaging import (
    ExportDone,
    RequestFailed,
    RequestProgress,
    VolumesFailed,
    VolumesListed,
)
from gpr20_operator.robot.events import ControlState
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.volume import Volume
from gpr20_user_interface.window.rail import TabName

LISTED = past_survey(survey_id=SURVEY, outcome="", stored_traces=40, complete=True)
BLUE = Volume("/media/gpr/BLUE", "BLUE", 7_900_000_000, True)
RED = Volume("/media/gpr/RED", "RED STICK WITH A LONG NAME", 123_000_000, True)
LOCKED = Volume("/media/gpr/LOCKED", "LOCKED", 10**9, False)
RUNS = ControlState(SurveyState.SURVEYING, verbatim(""), "other", True)


@pytest.fixture(autouse=True)
def opened(window):
    show(window, snapshot())
    window.show_tab(TabName.SURVEYS)
    window.on_event(SurveysListed("", (LISTED,), False))
    window.past.table.selectRow(0)
    click(window.past.export)


@pytest.fixture
def sheet(window):
    return window.export


def plug_in(window, *volumes):
    window.on_event(VolumesListed("gpr20-server", volumes))


def request_of(node):
    return node.of("export")[-1]


def test_the_sheet_asks_for_sticks_and_names_the_computer(window, node, sheet):
    assert node.of("volumes")
    assert not sheet.export_button.isEnabled()
    plug_in(window)
    assert "gpr20-server" in sheet.place.text() and not sheet.export_button.isEnabled()
    plug_in(window, BLUE)
    assert "gpr20-server" in sheet.place.text()
    assert "BLUE" in sheet.sticks[0].text() and "7.9 GB" in sheet.sticks[0].text()
    assert sheet.simulated.isVisible()


def test_the_only_stick_is_chosen_and_several_must_be(window, sheet):
    plug_in(window, BLUE)
    assert sheet.export_button.isEnabled()
    plug_in(window, RED, BLUE)
    # The one that was chosen is still there.
    assert sheet.model.volume == BLUE.path
    plug_in(window, RED, LOCKED)
    assert sheet.model.volume == RED.path and not sheet.sticks[1].isEnabled()
    plug_in(window)
    assert sheet.model.volume == "" and not sheet.export_button.isEnabled()
    plug_in(window, RED, BLUE, LOCKED)
    assert not sheet.export_button.isEnabled()
    click(sheet.sticks[1])
    assert sheet.model.volume == BLUE.path and sheet.export_button.isEnabled()


def test_what_is_chosen_is_exported_and_only_then_the_stick_can_be_removed(window, node, sheet):
    plug_in(window, BLUE)
    click(sheet.parts[ExportPart.SURVEY_ZIP])
    sheet.permittivity.setText("4,5")
    click(sheet.export_button)
    request_id, survey, kinds, permittivity, language, volume = request_of(node)
    assert (survey, permittivity, volume) == (FOLDER, 4.5, BLUE.path)
    assert kinds == ["report-pdf", "survey-zip"]
    assert language == window.languages.language.value
    assert sheet.progress.isVisible() and not sheet.export_button.isEnabled()
    window.on_event(RequestProgress(request_id, verbatim("copying to the USB stick")))
    assert "copying to the USB stick" in sheet.details.text()
    before = sheet.details.text()
    window.on_event(ExportDone(request_id, ("GPR20/a.pdf", "GPR20/b.zip")))
    assert sheet.details.text() != before and "GPR20" in sheet.details.text()
    assert "2" in sheet.details.text()


def test_a_failure_is_shown_and_the_export_can_be_repeated(window, node, sheet):
    plug_in(window, BLUE)
    click(sheet.export_button)
    window.on_event(RequestFailed(request_of(node)[0], verbatim("full")))
    assert sheet.model.state is ExportState.FAILED
    assert "full" in sheet.details.text()
    click(sheet.export_button)
    assert len(node.of("export")) == 2


def test_cancelling_ends_the_export_and_its_late_end_changes_nothing(window, node, sheet):
    plug_in(window, BLUE)
    click(sheet.export_button)
    click(sheet.cancel)
    assert node.cancelled == [request_of(node)[0]]
    window.on_event(ExportDone(node.cancelled[0], ("GPR20/a.pdf",)))
    assert sheet.model.state is ExportState.READY


def test_no_export_begins_during_a_survey(window, node, sheet):
    plug_in(window, BLUE)
    show(window, snapshot(state=RUNS))
    assert not sheet.export_button.isEnabled() and not window.past.export.isEnabled()
    show(window, snapshot())
    assert sheet.export_button.isEnabled()


def test_why_there_is_no_list_of_sticks_is_shown(window, sheet):
    window.on_event(VolumesFailed(verbatim("the imaging node does not answer")))
    assert sheet.details.text() == "the imaging node does not answer"


def test_another_survey_is_not_chosen_while_one_is_exported(window, node, sheet):
    plug_in(window, BLUE)
    click(sheet.export_button)
    sheet.show_survey(dataclasses.replace(LISTED, folder="20260101T000000_00000000"))
    assert sheet.model.survey == LISTED


def test_a_wrong_permittivity_locks_the_export(window, sheet):
    plug_in(window, BLUE)
    for text in ("0.5", "x", "nan", "101"):
        sheet.permittivity.setText(text)
        assert not sheet.export_button.isEnabled()
