import pytest
from map_kit import MARKER, SURE, focused
from view_kit import SURVEY, description, make_grid, snapshot, trace_at
from window_helpers import click, hold, show

from gpr20_common.message import verbatim
from gpr20_operator.ground.additions import (
    AdditionsRead,
    MarkersStored,
    MarkingFailed,
)
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.grid import Cell, Stop
from gpr20_operator.ground.trace_events import SurveyDescribed
from gpr20_operator.jobs.imaging import ImageFocused
from gpr20_operator.robot.events import Answer, ControlState, Request
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.window.rail import TabName


def fill(window):
    """Let a window show a survey with candidates and a marker on MAP."""
    grid = make_grid()
    window.on_event(SurveyDescribed(description()))
    window.on_event(CoverageRuns(SURVEY, 40, (0, 10, 11, 12), (1, 3, 1, 0), {}))
    window.on_event(trace_at(grid, 0))
    window.show_tab(TabName.MAP)
    window.refresh()
    window.on_event(AdditionsRead(SURVEY, (MARKER,), ()))
    window.on_event(ImageFocused(focused()))
    window.draw()


@pytest.fixture
def filled(window):
    fill(window)
    return window


def in_state(code):
    """Return what is known while the survey that is shown is in a state."""
    return snapshot(code, state=ControlState(code, verbatim("as it is"), SURVEY, True))


def asked(window, kind):
    return [one for one in window.traces.source.asked if one[0] == kind]


def choose_place(window):
    window.map.next_candidate.click()
    assert window.map.selected.mark == SURE


def test_a_finer_survey_goes_to_control_and_starts_only_there(filled):
    choose_place(filled)
    click(filled.map.finer)
    sheet = filled.map_binding.finer
    assert sheet.isVisible()
    assert "2 x" not in sheet.figures.text()
    click(sheet.sizes[1])
    click(sheet.use)
    assert filled.tabs.currentWidget() is filled.survey_tab
    p = filled.control.parameters
    assert (p.x_start_mm, p.x_stop_mm, p.x_points) == (50.0, 200.0, 16)
    assert (p.y_start_mm, p.y_stop_mm, p.y_points) == (15.0, 165.0, 16)
    assert p.polarizations_deg == (0.0, 90.0)
    assert filled.survey.asked == []
    assert filled.survey.finer == filled.additions.plan == sheet.plan
    filled.on_event(Answer(Request.START, True, verbatim("Survey started")))
    assert filled.survey.finer is filled.additions.plan is None


def test_the_trace_of_a_stop_is_shown_and_that_of_its_other_polarization(filled):
    sheet = filled.map_binding.trace
    filled.map.trace_wanted.emit(Cell(Stop(0, 0), 0))
    assert sheet.isVisible() and sheet.plot.has_numbers
    assert "100" in sheet.title.text() and sheet.polarization.text() == "Antenna 0°"
    click(sheet.polarization)
    # Only the first polarization has a trace.
    assert sheet.polarization.text() == "Antenna 90°" and not sheet.plot.has_numbers
    click(sheet.polarization)
    assert sheet.cell == Cell(Stop(0, 0), 0) and sheet.plot.has_numbers


def test_a_plan_made_while_a_survey_runs_is_kept_and_found_again(filled):
    before = filled.control.parameters
    show(filled, in_state(SurveyState.SURVEYING))
    choose_place(filled)
    click(filled.map.finer)
    assert "running" in filled.map_binding.finer.note.text()
    click(filled.map_binding.finer.use)
    assert filled.tabs.currentWidget() is filled.map_page
    assert filled.control.parameters == before
    assert filled.survey.finer is None
    plan = filled.additions.plan
    show(filled, in_state(SurveyState.FINISHED))
    filled.map.select(None)
    assert filled.map.finer.text() == "Finer\nplan"
    click(filled.map.finer)
    assert filled.map_binding.finer.plan == plan
    assert not filled.control.isVisible()
    click(filled.map_binding.finer.use)
    assert filled.control.isVisible()
    assert filled.survey.finer == plan


def test_a_plan_is_dropped(filled):
    choose_place(filled)
    click(filled.map.finer)
    click(filled.map_binding.finer.use)
    filled.show_tab(TabName.MAP)
    filled.map.select(None)
    click(filled.map.finer)
    click(filled.map_binding.finer.drop)
    assert filled.additions.plan is filled.survey.finer is None


def test_spacing_is_changed_by_touch_and_never_below_a_millimetre(filled):
    choose_place(filled)
    click(filled.map.finer)
    sheet = filled.map_binding.finer
    for _ in range(20):
        click(sheet.closer)
    assert sheet.spacing.text() == "1 mm"
    assert "101 x 101 stops, 20402 traces" in sheet.figures.text()
    click(sheet.wider)
    assert sheet.spacing.text() == "2 mm"


def test_a_marker_is_written_on_the_pad_and_sent_to_the_storage(filled):
    choose_place(filled)
    click(filled.map.set_marker)
    pad = filled.map_binding.note_pad
    assert pad.isVisible()
    pad.press("metal")
    pad.accept_button.click()
    ((_kind, survey, marker),) = asked(filled, "add marker")
    assert survey == SURVEY
    place = (marker.x_mm, marker.y_mm, marker.depth_mm)
    assert place == (SURE.x_mm, SURE.y_mm, SURE.depth_mm)
    assert marker.text == "metal"
    filled.on_event(MarkersStored(SURVEY, (MARKER, marker)))
    filled.draw()
    assert filled.map.markers.text() == "Markers\n2"


def test_a_marker_that_was_not_stored_opens_a_dialog(filled):
    filled.on_event(MarkingFailed(SURVEY, MARKER.marker_id, verbatim("the disk is full")))
    assert filled.notice.isVisible()


def test_a_marker_is_removed_only_by_holding(filled):
    click(filled.map.markers)
    sheet = filled.map_binding.markers
    sheet.list.setCurrentRow(0)
    click(sheet.remove)
    assert asked(filled, "remove marker") == []
    hold(sheet.confirm.hold)
    ((_kind, survey, marker_id, _author),) = asked(filled, "remove marker")
    assert (survey, marker_id) == (SURVEY, MARKER.marker_id)
    filled.on_event(MarkersStored(SURVEY, ()))
    filled.refresh()
    assert sheet.list.count() == 0


def test_a_trace_opens_over_the_tabs_and_changes_its_antenna(filled):
    click(filled.map.next_problem)
    click(filled.map.trace)
    sheet = filled.map_binding.trace
    assert sheet.isVisible()
    assert sheet.cell.polarization == 0
    click(sheet.polarization)
    assert sheet.cell.polarization == 1
    click(sheet.close_button)
    assert not sheet.isVisible()


def test_what_belongs_to_a_survey_is_read_when_it_is_shown_and_when_one_ends(window):
    window.on_event(SurveyDescribed(description()))
    window.refresh()
    assert asked(window, "additions") == [("additions", SURVEY)]
    show(window, in_state(SurveyState.SURVEYING))
    show(window, in_state(SurveyState.FINISHED))
    assert len(asked(window, "additions")) == 3
