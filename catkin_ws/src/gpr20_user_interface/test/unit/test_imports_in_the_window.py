"""The window lists and opens surveys that were imported, lines too, and offers no RESUME."""

import pytest
from imported_kit import imported_folder
from view_kit import past_survey
from window_helpers import click

from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.grid import Stop, grid_from_description
from gpr20_operator.ground.past_surveys import Ending, PastSurveys
from gpr20_operator.ground.trace_events import SurveyRead, SurveysListed, TracesRead
from gpr20_survey.folder.trace_files import read_trace
from gpr20_survey.trace.trace_block import TraceBlock
from gpr20_user_interface.window.rail import TabName


def listed(folder, traces):
    return past_survey(
        folder=folder.name,
        outcome="imported",
        stored_traces=traces,
        planned_traces=0,
        verdict=None,
        simulated=False,
    )


def opened(window, folder):
    """Open an imported survey in the window, and give it all traces."""
    paths = sorted((folder / "traces").iterdir())
    window.show_tab(TabName.SURVEYS)
    window.on_event(SurveysListed("", (listed(folder, len(paths)),), False))
    window.past.choose(listed(folder, len(paths)))
    click(window.past.open)
    text = (folder / "survey.json").read_text("ascii")
    window.on_event(SurveyRead(folder.name, text, tuple(range(len(paths)))))
    grid = window.traces.shown.map.grid
    traces = tuple(map(read_trace, paths))
    window.on_event(TracesRead(0, TraceBlock.of(grid.survey_id, traces), {}))
    window.refresh()
    return window.traces.shown


def test_it_is_listed_as_imported_and_resume_is_not_offered(window, tmp_path):
    window.show_tab(TabName.SURVEYS)
    survey = listed(imported_folder(tmp_path), 5)
    window.on_event(SurveysListed("", (survey,), False))
    window.past.choose(survey)
    assert window.past.open.isEnabled()
    assert not window.past.resume.isEnabled()
    surveys = PastSurveys()
    surveys.take("", (survey,), False)
    assert surveys.ending_of(survey) is Ending.IMPORTED
    assert surveys.can_open(survey) and not surveys.can_resume(survey)


@pytest.mark.parametrize("size", [(5, 1), (1, 5), (6, 4), (1, 1)])
def test_it_opens_on_ground_without_a_fault(window, tmp_path, size):
    shown = opened(window, imported_folder(tmp_path, *size))
    count = size[0] * size[1]
    assert shown.map.counts()[StopState.DONE] == count and shown.radar.count == count
    assert shown.map.grid.simulated is False and shown.map.grid.plan is None
    window.show_tab(TabName.GROUND)
    window.grab()
    window.ground.show_place(0.0, 0.0)
    assert window.ground.model.stop == Stop(0, 0)
    assert not window.ground.view.finer.isEnabled()
    assert window.traces.past.problem is None
    assert str(window.traces.band).startswith("IMPORTED SURVEY: ")


def test_a_touch_beside_a_line_selects_its_nearest_stop(tmp_path):
    text = (imported_folder(tmp_path) / "survey.json").read_text("ascii")
    grid = grid_from_description(text)
    assert grid.nearest_stop(41.0, 700.0) == Stop(0, 2)
    assert grid.nearest_stop(120.0, 0.0) is None
