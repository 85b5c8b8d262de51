"""GROUND in the window: touches, layers, candidates, markers, finer surveys, what it says."""

import dataclasses
import itertools

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from finger import colours, touch
from imported_kit import imported_folder
from map_kit import DOUBTED, MARKER, SURE, focused, marked
from PyQt5.QtTest import QTest
from test_ground_model import cover, image_of
from view_kit import SURVEY, make_grid, noise, past_survey, snapshot, state_of, trace_at
from window_helpers import click, hold, press_keys, show, take_list

from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.coverage import StopState
from gpr20_operator.ground.sources import Layer
from gpr20_operator.jobs.pictures import StoredSurvey, TracesRead
from gpr20_operator.robot.events import Answer, Request
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.trace_files import read_trace
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace_block import TraceBlock
from gpr20_user_interface.window.rail import TabName

NO_MINE = "No echo does not mean no mine."


def fill(window, stored=40, **changes):
    """Let a window show a survey of which the first traces are stored and here."""
    grid, live = make_grid(), window.traces.live
    live.begin(grid)
    cover(window.ground.model, stored)
    live.take_traces([trace_at(grid, index, **changes) for index in range(stored)])
    window.show_tab(TabName.GROUND)
    window.refresh()
    window.draw()


@pytest.fixture
def view(window):
    return window.ground.view


@pytest.fixture
def filled(window):
    fill(window)
    window.node.ticket("read").done(marked(MARKER))
    window.additions.pictures.add_image(focused())
    window.draw()
    return window


def refreshed(view):
    view.refresh()
    return view


def said(view):
    return refreshed(view).text.text().splitlines()


def test_a_place_that_is_touched_or_shown_from_another_page_is_on_every_picture(filled, view):
    touch(view.above, 149.0, 91.0)
    assert said(view)[0] == "X 150, Y 90, depth 50 mm"
    assert view.above.crosshair == (150.0, 90.0)
    assert view.section.labels == ("X mm", "Depth mm, at Y 90 mm")
    filled.ground.show_place(150.0, 70.0, 120.0)
    filled.draw()
    assert view.above.crosshair == (150.0, 70.0)
    assert filled.ground.model.settings.depth_m == pytest.approx(0.12)


def test_candidates_and_markers_are_counted_visited_and_described(filled, view):
    filled.ground.model.follow(True)
    assert "2 places to check" in "\n".join(said(view))
    click(view.next)
    assert said(view) == ["Candidate 1", "X 125, Y 90, depth 85 mm", "21 dB above the clutter"]
    touch(view.above, SURE.x_mm, SURE.y_mm)
    assert filled.ground.model.mark == DOUBTED
    assert said(view)[0] == "Candidate 2" and said(view)[-1] == "Edge"
    touch(view.above, MARKER.x_mm, MARKER.y_mm)
    marker = ["Marker: raíz", "X 175, Y 70, depth 60 mm", "2026-11-21 05:10 UTC Ana"]
    assert said(view) == marker


def test_the_settings_change_what_is_drawn_and_never_the_data(filled, view):
    sheet, model = filled.ground.layers, filled.ground.model
    echoes, before = filled.traces.live.radar.echoes.copy(), model.settings
    sheet.open()
    for name in ("along", "polarization", "follow"):
        click(getattr(sheet, name))
    now = dataclasses.asdict(model.settings).items()
    same = {name for name, value in now if getattr(before, name) == value}
    assert same == {"depth_m", "permittivity", "layer"}
    assert view.section.labels[0] == "Y mm" and not model.follows
    assert (filled.traces.live.radar.echoes == echoes).all()


def test_nothing_above_the_noise_is_never_said_while_a_part_is_not_here(window, view):
    fill(window, 0)
    draw, model = np.random.default_rng(1), window.ground.model
    traces = [trace_at(make_grid(), index, noise(draw)) for index in range(40)]
    window.traces.live.take_traces(traces[:25])
    cover(model, 40)
    model.set_depth(0.3)
    model.choose_place(150.0, 110.0)
    section = refreshed(view).section
    assert "loading 25/40" in view.note.text()
    assert all(one.notice == "" for one in (view.above, view.section))
    # Of the uppermost line nothing has come: its section is patterned as loading.
    loading = colours(section, 150.0, 200.0, reach=8)
    cover(model, 25)
    assert colours(refreshed(view).section, 150.0, 200.0, reach=8) != loading
    cover(model, 40)
    window.traces.live.take_traces(traces[25:])
    refreshed(view)
    assert view.above.notice == f"Nothing above the noise at this depth. {NO_MINE}"
    assert section.notice == f"Nothing above the noise in this section. {NO_MINE}"
    cover(model, 30)
    assert "A part is not measured." in refreshed(view).above.notice


def test_the_safety_notice_is_whole_beside_any_picture_and_band(filled, view):
    name = Message("PAST SURVEY: {name}", name="2026-11-21 05:10, " + "El Carmen " * 9)
    plots = (None, view.above, view.section)
    for size, band, plot in itertools.product([(480, 320), (800, 480)], (None, name), plots):
        filled.resize(*size)
        view.show_band(band)
        view.enlarge(plot)
        refreshed(view)
        QTest.qWait(1)
        text = view.note.text()
        assert NO_MINE in text and view.note.isVisible()
        assert view.note.fontMetrics().horizontalAdvance(text) <= view.note.width()
        assert view.note.geometry().right() < view.width()
        texts = (text, view.text.text(), view.above.notice, view.section.notice)
        words = " ".join(texts).lower().replace(".", "").split()
        assert not {"clear", "free", "safe"} & set(words)
        if plot is not None:
            view.enlarge(None)  # shares the room again


def test_what_is_missing_is_said(window, view):
    window.show_tab(TabName.GROUND)
    window.draw()
    # Without a survey there is one thing to do, and no key that does nothing.
    assert view.empty.isVisible() and not view.next.isVisible()
    show(window, snapshot(SurveyState.CHECKING))
    view.refresh()
    assert not view.empty.button.isVisible()
    show(window, snapshot(SurveyState.IDLE))
    view.refresh()
    click(view.empty.button)
    assert window.past.isVisible()
    fill(window, 1, height_m=float("nan"))
    assert view.note.text().startswith(f"SIMULATED. {NO_MINE}")
    assert "No height was measured" in view.above.notice
    assert view.section.extent is None and not view.deeper.isEnabled()
    assert "The background is not removed from fewer than 8 traces" in view.note.text()
    window.traces.live.radar.give_up(5, verbatim("torn"))
    assert "Cannot be shown: 1" in refreshed(view).note.text()


def test_over_a_candidate_nothing_is_said_to_be_nothing(window, view):
    fill(window)
    faint = candidate_list([candidate(level_db=7.0)], survey_id=SURVEY)
    window.additions.pictures.add_image(image_of(window.traces.live.map.grid, 7.0, faint))
    model = window.ground.model
    model.change(layer=Layer.FOCUSED)
    model.choose_mark(faint.candidates[0])
    refreshed(view)
    assert not model.pictures().above.above_noise
    plots = (view.above, view.section)
    assert not any("Nothing above" in plot.notice for plot in plots)
    model.choose_place(200.0, 50.0, 250.0)
    refreshed(view)
    assert all("Nothing above the clutter" in plot.notice for plot in plots)


def test_a_finer_survey_goes_to_the_plan_and_starts_only_there(filled, view):
    show(filled, snapshot(state=state_of(SurveyState.SURVEYING, survey_id=SURVEY)))
    filled.show_tab(TabName.GROUND)
    click(view.next)
    # While a survey runs none can be planned; the button says so.
    assert not view.finer.isEnabled() and view.finer.text() == "Finer:\nafterwards"
    show(filled, snapshot(state=state_of(SurveyState.FINISHED, survey_id=SURVEY)))
    view.refresh()
    click(view.finer)
    assert filled.control.isVisible()
    # The address is that of the configuration, which the plan follows.
    planned = dataclasses.replace(filled.survey.finer.parameters, vna_address="")
    assert filled.control.parameters == planned
    assert filled.survey.asked == []
    filled.on_event(Answer(Request.START, True, verbatim("Survey started")))
    assert filled.survey.finer is None


def test_a_marker_is_written_on_the_pad_and_removed_only_by_holding(filled, view):
    node, confirm = filled.node, filled.ground.confirm
    click(view.next)
    click(view.set_marker)
    press_keys(filled.ground.note_pad, "metal")
    click(filled.ground.note_pad.accept_button)
    ((survey, kind, values),) = node.of("fact")
    assert (survey, kind, values["text"].lower()) == (SURVEY, Kind.MARKER, "metal")
    assert tuple(values[name] for name in ("x_mm", "y_mm", "depth_mm")) == (
        SURE.x_mm,
        SURE.y_mm,
        SURE.depth_mm,
    )
    touch(view.above, MARKER.x_mm, MARKER.y_mm)
    view.refresh()
    click(view.set_marker)
    assert confirm.isVisible() and len(node.of("fact")) == 1
    hold(confirm.hold)
    survey, kind, values = node.of("fact")[-1]
    assert (survey, kind) == (SURVEY, Kind.MARKER_REMOVED)
    assert values["marker_id"] == MARKER.marker_id
    node.ticket("fact").fail(verbatim("the disk is full"))
    assert filled.notice.isVisible()


@pytest.mark.parametrize("columns,rows", [(1, 5), (6, 4)])
def test_an_imported_survey_opens_without_a_fault_and_is_not_resumed(
    window, storage, tmp_path, columns, rows
):
    folder, count = imported_folder(tmp_path / "imported", columns, rows), columns * rows
    counts = {"stored_traces": count, "planned_traces": 0, "verdict": None, "simulated": False}
    imported = past_survey(folder=folder.name, outcome="imported", **counts)
    window.show_tab(TabName.SURVEYS)
    take_list(window, (imported,))
    window.past.choose(imported)
    assert not window.past.resume.isVisible()
    click(window.past.open)
    text = (folder / "survey.json").read_text("ascii")
    storage.answer(StoredSurvey(text, tuple(range(count))))
    for _ in range(2):
        window.draw()
    shown = window.traces.shown
    traces = tuple(map(read_trace, sorted((folder / "traces").iterdir())))
    storage.answer(TracesRead(TraceBlock.of(shown.map.grid.survey_id, traces), {}))
    window.refresh()
    assert shown.map.counts()[StopState.DONE] == shown.radar.count == count
    assert shown.map.grid.simulated is False and shown.map.grid.plan is None
    window.show_tab(TabName.GROUND)
    window.grab()
    assert not window.ground.view.finer.isEnabled()
    assert window.traces.past.problem is None
    assert str(window.traces.band).startswith("IMPORTED SURVEY: ")
