"""GROUND in the window: its pictures, and what a finger does there."""

import dataclasses
import itertools

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from map_kit import MARKER, SURE, focused, marked
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QColor
from PyQt5.QtTest import QTest
from result_examples import a_map
from test_ground_model import cover, image_of
from view_kit import FOLDER, PAST, SURVEY, make_grid, noise, snapshot, state_of, trace_at
from window_helpers import (
    click,
    colours,
    hold,
    pixel_of,
    press_keys,
    show,
    touch,
)

from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.coverage import CoverageRuns, MapModel, StopState
from gpr20_operator.ground.echoes import LevelScale
from gpr20_operator.ground.sources import Axis, Layer, Picture
from gpr20_operator.ground.texts import GroundMark
from gpr20_operator.palette import LAST_SHADE, shade_colours
from gpr20_operator.robot.events import Answer, Replay, Request
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.candidates import Flag
from gpr20_user_interface.look.look import Look, Mark
from gpr20_user_interface.widgets.bars import TabName
from gpr20_user_interface.widgets.ground_picture import GroundPicture, SectionPlot

NO_MINE = "No echo does not mean no mine."


def fill(window, stored=40, **changes):
    """Let a window show a survey of which the first traces are stored and here."""
    grid, live = make_grid(), window.traces.live
    live.begin(grid)
    cover(window.ground.model, stored)
    live.take_traces([trace_at(grid, index, **changes) for index in range(stored)])
    window.show_tab(TabName.GROUND)
    window.refresh()


@pytest.fixture
def view(window):
    return window.ground.view


@pytest.fixture
def filled(window):
    fill(window)
    window.node.ticket("read").done(marked(MARKER))
    window.additions.pictures.add_image(focused())
    window.refresh()
    return window


def refreshed(view):
    view.refresh()
    return view


def test_a_place_that_is_touched_or_shown_from_another_page_is_on_every_picture(filled, view):
    touch(view.above, 149.0, 91.0)
    assert refreshed(view).text.text().startswith("X 150, Y 90, depth 50 mm\n")
    assert view.above.crosshair == (150.0, 90.0)
    assert view.section.labels == ("X mm", "Depth mm, at Y 90 mm")
    filled.ground.show_place(150.0, 70.0, 120.0)
    filled.refresh()
    assert view.above.crosshair == (150.0, 70.0)
    assert filled.ground.model.settings.depth_m == pytest.approx(0.12)
    # One of another survey waits until that survey is here.
    filled.ground.show_place_of(PAST, FOLDER, 110.0, 60.0, 90.0)
    filled.refresh()
    assert view.above.crosshair == (150.0, 70.0)


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
    assert view.above.notice == f"Nothing above the noise here. {NO_MINE}"
    assert section.notice == f"Nothing above the noise here. {NO_MINE}"
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
        if plot is not None:
            view.enlarge(None)  # shares the room again


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
    # While a survey runs none can be planned.
    assert not view.finer.isEnabled()
    show(filled, snapshot(state=state_of(SurveyState.FINISHED, survey_id=SURVEY)))
    click(refreshed(view).finer)
    # The address is that of the configuration, which the plan follows.
    planned = dataclasses.replace(filled.survey.finer.parameters, vna_address="")
    assert filled.control.isVisible() and filled.control.parameters == planned
    assert filled.survey.asked == []
    filled.on_event(Answer(Request.START, True, verbatim("Survey started")))
    assert filled.survey.finer is None
    filled.show_tab(TabName.GROUND)
    show(filled, snapshot(replay=Replay()))
    view.refresh()
    for button in (view.set_marker, view.finer):
        assert not button.isEnabled() and button.text() == "Not in\na replay"


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


def colour(mark):
    return Look().colour(mark)


def model_of(grid):
    """Return a model in which the first row is done, one stop failed, one is partly done."""
    model = MapModel()
    model.set_grid(grid)
    runs = (0, 10, 12, 13), (1, 3, 1, 0)
    model.set_coverage(CoverageRuns(grid.survey_id, 40, *runs, {10: verbatim("no answer")}))
    return model


def new_picture(model, width=400, height=330):
    picture = GroundPicture()
    picture.resize(width, height)
    picture.show_coverage(model)
    picture.touched = []
    picture.place_touched.connect(lambda *place: picture.touched.append(place))
    return picture


@pytest.fixture
def grid():
    return make_grid()


@pytest.fixture
def picture(application, grid):
    picture = new_picture(model_of(grid))
    picture.show()
    yield picture
    picture.close()


@each_case("left,down", [(False, False), (True, True)])
def test_each_stop_is_drawn_where_it_is_measured(application, left, down):
    xs, ys = (100.0, 200.0)[:: -1 if left else 1], (50.0, 110.0)[:: -1 if down else 1]
    grid = make_grid(x_start_mm=xs[0], x_stop_mm=xs[1], y_start_mm=ys[0], y_stop_mm=ys[1])
    model = model_of(grid)
    picture = new_picture(model)
    inks = {
        StopState.DONE: {colour(Mark.STOP_DONE)},
        StopState.PARTLY: {colour(Mark.STOP_DONE), colour(Mark.STOP_PARTLY)},
        StopState.FAILED: {colour(Mark.STOP_FAILED), colour(Mark.PAPER)},
        StopState.MISSING: {colour(Mark.STOP_MISSING), colour(Mark.PAPER)},
    }
    # A stop of each state, and the last one.
    for row, column in ((0, 0), (0, 4), (1, 0), (1, 1), (1, 2), (3, 4)):
        place = float(grid.xs_mm[column]) + 6.0, float(grid.ys_mm[row]) + 5.0
        state = StopState(int(model.stop_states[row, column]))
        assert inks[state] <= colours(picture, *place, reach=5), (row, column, state)


@given(st.integers(0, 2), st.integers(0, 3), st.booleans())
def test_an_echo_is_drawn_where_it_was_measured(application, row, column, is_section):
    """A picture that is turned over would send people to the wrong place."""
    levels_db = np.full((3, 4), -1.0)
    levels_db[row, column] = 10.0
    axis = Axis.DEPTH_MM if is_section else Axis.Y_MM
    shown = Picture(levels_db, (0.0, 400.0), (30.0, 330.0), axis, LevelScale(1.0, 0.0, 10.0))
    plot = SectionPlot() if is_section else GroundPicture()
    plot.resize(400, 300)
    if is_section:
        plot.show_section(shown, np.zeros(4, bool))
    else:
        plot.show_picture(shown)
    strong = QColor(*shade_colours()[LAST_SHADE].tolist()).name()
    for one, other in np.ndindex(3, 4):
        found = colours(plot, 100.0 * other + 50.0, 100.0 * one + 80.0, reach=6)
        assert (strong in found) == ((one, other) == (row, column)), (one, other)
    # Depth grows downwards, Y upwards.
    low, high = plot.to_screen(0.0, 30.0), plot.to_screen(0.0, 330.0)
    assert (low.y() < high.y()) == is_section


def test_what_is_loading_is_not_shown_as_done(picture, grid):
    loading = np.zeros(grid.shape, bool)
    loading[0, 1] = True
    picture.show_coverage(model_of(grid), loading)
    found = colours(picture, 125.0, 50.0, reach=8)
    assert colour(Mark.INK) in found and colour(Mark.STOP_DONE) not in found


@given(st.integers(2, 12), st.integers(2, 12), st.floats(1.0, 6.0), st.data())
def test_a_touch_is_where_the_finger_is(application, columns, rows, zoom, data):
    model = MapModel()
    model.set_grid(make_grid(columns, rows))
    picture = new_picture(model, data.draw(st.integers(60, 500)), data.draw(st.integers(60, 500)))
    picture.zoom_by(zoom, QPointF(picture.width() / 3.0, picture.height() / 3.0))
    area = picture.area
    x = data.draw(st.integers(int(area.left()) + 1, int(area.right()) - 1))
    y = data.draw(st.integers(int(area.top()) + 1, int(area.bottom()) - 1))
    QTest.mouseClick(picture, Qt.LeftButton, pos=QPoint(x, y))
    ((x_mm, y_mm),) = picture.touched
    back = picture.to_screen(x_mm, y_mm)
    assert (round(back.x()), round(back.y())) == (x, y)
    px_mm = 1.5 * picture.extent.width() / area.width()
    assert picture.extent.left() - px_mm <= x_mm <= picture.extent.right() + px_mm


def test_the_carriage_the_stop_visited_and_places_are_seen_over_the_states(picture, grid):
    picture.set_carriage((150.0, 80.0))
    assert colour(Mark.CARRIAGE) in colours(picture, 150.0, 80.0)
    # A candidate is painted over the carriage; on unmeasured ground it is grey.
    for measured, own in ((True, Mark.CANDIDATE), (False, Mark.NOT_MEASURED)):
        picture.set_marks([GroundMark(150.0, 80.0, "", measured=measured)])
        found = colours(picture, 150.0, 80.0, reach=16)
        assert colour(own) in found and (colour(Mark.CANDIDATE) in found) == measured
    # A candidate that nothing makes doubtful is filled.
    for flags in ((), (Flag.EDGE,)):
        picture.set_marks([GroundMark(150.0, 80.0, "1", about=candidate(flags=flags))])
        at = pixel_of(picture, 150.0, 80.0)
        beside = picture.to_data(QPointF(at.x() - 9, at.y()))
        assert colours(picture, *beside) == {colour(Mark.PAPER if flags else Mark.CANDIDATE)}
    model = model_of(grid)
    model.set_target((150.0, 90.0))
    picture.show_coverage(model)
    assert colour(Mark.CURRENT) in colours(picture, 137.5, 95.0, reach=2)


def test_where_a_mine_could_hide_is_hatched(picture, grid):
    x_m, y_m = np.sort(grid.xs_mm) / 1e3, np.sort(grid.ys_mm) / 1e3
    tried = np.full((1, len(y_m), len(x_m)), 10)
    found = tried.copy()
    found[0, :, :2] = 0
    before = colours(picture, 125.0, 55.0, reach=8)
    picture.set_hiding(a_map(found, tried, x_m=x_m, y_m=y_m, survey_id=grid.survey_id))
    assert colours(picture, 125.0, 55.0, reach=8) > before
    assert colours(picture, 180.0, 55.0, reach=5) <= before
