"""The view from above: the coverage of a plan, marks, moving and zooming by a finger."""

import numpy as np
import pytest
from candidate_examples import candidate
from case_kit import each_case
from finger import colours, drag, pixel_of, touch
from hiding_kit import a_map
from hypothesis import given
from hypothesis import strategies as st
from map_kit import MARKER
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtGui import QColor
from PyQt5.QtTest import QTest
from view_kit import make_grid

from gpr20_common.message import verbatim
from gpr20_operator.ground.coverage import (
    Cell,
    CoverageRuns,
    MapModel,
    StopState,
)
from gpr20_operator.ground.echoes import LevelScale
from gpr20_operator.ground.sources import Axis, Picture
from gpr20_operator.ground.texts import GroundMark
from gpr20_operator.palette import LAST_SHADE, TILES, shade_colours
from gpr20_survey.results.candidates import Flag
from gpr20_user_interface.look.look import Look, Mark
from gpr20_user_interface.widgets.ground_picture import GroundPicture, SectionPlot


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


def test_each_state_has_its_own_pattern_without_any_colour():
    drawn = [frozenset(zip(*np.nonzero(TILES[one] != TILES[one][1, 1]))) for one in Cell]
    plain = [one for one in Cell if not drawn[one]]
    assert plain == [Cell.DONE, Cell.BLANK]
    assert len(set(drawn)) == len(Cell) - 1


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


def test_marks_that_lie_together_are_touched_one_after_the_other_and_then_the_place(picture):
    chosen = [None]
    picture.mark_touched.connect(chosen.append)
    for expected in ([None, 1], [None, 1, 2], [None, 1, 2]):
        last = chosen[-1]
        marks = [GroundMark(125.0, 90.0, str(one), chosen=one == last, about=one) for one in (2, 1)]
        picture.set_marks(marks)
        touch(picture, 125.0, 90.0)
        assert chosen == expected
    assert np.round(picture.touched).tolist() == [[125, 90]]


def test_marks_and_frames_are_seen_over_the_states(picture, grid):
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
    picture.set_marks([GroundMark(MARKER.x_mm, MARKER.y_mm, "", is_flag=True)])
    at = pixel_of(picture, MARKER.x_mm, MARKER.y_mm)
    flag = picture.to_data(QPointF(at.x() + 4, at.y() - 20))
    assert colour(Mark.MARKER) in colours(picture, *flag, reach=2)
    model = model_of(grid)
    model.set_target((150.0, 90.0))  # the stop that is visited
    assert colour(Mark.CURRENT) not in colours(picture, 137.5, 95.0, reach=2)
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


def test_a_finger_moves_what_was_zoomed_and_never_beyond_its_edge(picture):
    at = QPointF(200.0, 165.0)
    below = picture.to_data(at)
    picture.zoom_by(4.0, at)
    assert picture.to_data(at) == pytest.approx(below, abs=0.01)
    under = picture.to_screen(150.0, 80.0)
    drag(picture, (150.0, 80.0), (155.0, 82.0))
    moved = picture.to_screen(150.0, 80.0) - under
    assert moved.x() == pytest.approx(5.0 * picture.area.width() / 31.25, rel=0.1)
    assert moved.y() < 0
    for _ in range(20):
        drag(picture, (150.0, 80.0), (190.0, 110.0))
    left, low = picture.to_data(QPointF(0.0, 330.0))
    assert (left, low) >= (picture.extent.left() - 0.01, picture.extent.top() - 0.01)
    assert not picture.touched


def test_the_crosshair_ends_with_what_can_be_measured(picture, grid):
    picture.set_crosshair(150.0, 90.0)
    line = colour(Mark.SELECTED)
    (left, right), low = np.sort(grid.xs_mm)[[0, -1]], float(np.min(grid.ys_mm))
    mm_per_px = picture.extent.width() / picture.area.width()
    half_mm = grid.spacing_mm[0] / 2.0
    for outside_mm, seen in ((-5.0 * mm_per_px, True), (5.0 * mm_per_px, False)):
        for x_mm in (left - half_mm - outside_mm, right + half_mm + outside_mm):
            assert (line in colours(picture, x_mm, 90.0, reach=2)) is seen, x_mm
    assert line in colours(picture, 150.0, low, reach=2)


@each_case("size", [(110, 110), (400, 90)])
def test_a_notice_is_never_cut_off(application, size):
    picture = GroundPicture()
    picture.resize(*size)
    picture.set_notice("Nothing above the noise at this depth. No echo does not mean no mine.")
    image = picture.grab().toImage()
    edge = {image.pixel(x, y) for x in range(size[0]) for y in (0, size[1] - 1)}
    assert len(edge) == 1, "the notice reaches the edge"
