"""The view from above: states, marks, moving and zooming by a finger."""

import itertools

import numpy as np
import pytest
from hiding_kit import a_map
from hypothesis import given, settings
from hypothesis import strategies as st
from map_kit import MARKER, SURE
from picture_kit import colours, drag, pixel_of, touch
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from test_ground_model import image_of
from view_kit import make_grid

from gpr20_common.message import verbatim
from gpr20_operator.ground.cells import TILES, Cell
from gpr20_operator.ground.coverage import CoverageRuns, MapModel, StopState
from gpr20_operator.ground.geometry import Area
from gpr20_operator.ground.marks import GroundMark
from gpr20_operator.ground.records import Colours, RadarSettings
from gpr20_operator.ground.shade_colours import NOT_MEASURED
from gpr20_operator.ground.sources import FocusedSource
from gpr20_user_interface.look.look import Look, Mark
from gpr20_user_interface.widgets.ground_picture import (
    Frame,
    GroundPicture,
)
from gpr20_user_interface.widgets.ink import round_ticks
from gpr20_user_interface.widgets.plot import MOST_ZOOM


def colour(mark):
    return Look().colour(mark)


def model_of(grid):
    """Return a model in which the first row is done, one stop failed, one is partly done."""
    model = MapModel()
    model.set_grid(grid)
    runs = (0, 10, 12, 13), (1, 3, 1, 0)
    model.set_coverage(CoverageRuns(grid.survey_id, 40, *runs, {10: verbatim("no answer")}))
    return model


@pytest.fixture
def grid():
    return make_grid()


@pytest.fixture
def picture(application, grid):
    picture = GroundPicture()
    picture.resize(400, 330)
    picture.show_coverage(model_of(grid))
    picture.show()
    yield picture
    picture.close()


def test_each_state_has_its_own_pattern_without_any_colour():
    drawn = [frozenset(zip(*np.nonzero(TILES[one] != TILES[one][1, 1]))) for one in Cell]
    plain = [one for one in Cell if not drawn[one]]
    assert plain == [Cell.DONE, Cell.BLANK]
    assert len(set(drawn)) == len(Cell) - 1


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize("down", [False, True])
def test_each_stop_is_drawn_where_it_is_measured(application, left, down):
    xs, ys = (100.0, 200.0)[:: -1 if left else 1], (50.0, 110.0)[:: -1 if down else 1]
    grid = make_grid(x_start_mm=xs[0], x_stop_mm=xs[1], y_start_mm=ys[0], y_stop_mm=ys[1])
    picture = GroundPicture()
    picture.resize(400, 330)
    model = model_of(grid)
    picture.show_coverage(model)
    inks = {
        StopState.DONE: {colour(Mark.STOP_DONE)},
        StopState.PARTLY: {colour(Mark.STOP_DONE), colour(Mark.STOP_PARTLY)},
        StopState.FAILED: {colour(Mark.STOP_FAILED), colour(Mark.PAPER)},
        StopState.MISSING: {colour(Mark.STOP_MISSING), colour(Mark.PAPER)},
    }
    for row, column in itertools.product(range(4), range(5)):
        place = float(grid.xs_mm[column]) + 6.0, float(grid.ys_mm[row]) + 5.0
        state = StopState(int(model.stop_states[row, column]))
        found = colours(picture, *place, reach=5)
        assert inks[state] <= found, (row, column, state)
    across = picture.to_screen(200.0, 50.0) - picture.to_screen(100.0, 50.0)
    up = picture.to_screen(100.0, 50.0) - picture.to_screen(100.0, 110.0)
    assert across.x() / up.y() == pytest.approx(100.0 / 60.0)


def test_what_is_loading_differs_from_what_is_missing_and_from_what_is_there(picture, grid):
    loading = np.zeros(grid.shape, bool)
    loading[0, 1] = True
    before = colours(picture, 125.0, 50.0, reach=6)
    picture.show_coverage(model_of(grid), loading)
    assert colours(picture, 125.0, 50.0, reach=6) > before
    assert colours(picture, 150.0, 50.0, reach=6) == before


def test_without_the_layer_of_states_what_is_not_there_is_still_patterned(picture, grid):
    picture.show_coverage(model_of(grid), states=False)
    assert colours(picture, 125.0, 55.0, reach=5) == {colour(Mark.PAPER)}
    assert colour(Mark.STOP_MISSING) in colours(picture, 126.0, 95.0, reach=6)


def test_an_image_covers_the_states_and_leaves_what_it_lacks(picture, grid):
    image = image_of(grid)
    image.levels_db[:, 6:] = np.nan
    slice_ = FocusedSource(image).slice(RadarSettings(depth_m=0.2))
    picture.show_picture(slice_, Colours.ENVELOPE)
    assert (picture.numbers[6:] == NOT_MEASURED).all()
    assert colours(picture, 126.0, 95.0, reach=6) >= {colour(Mark.STOP_MISSING)}
    assert colours(picture, 110.0, 58.0) == {"#440154"}
    picture.show_picture(None, Colours.ENVELOPE)
    assert picture.numbers is None


@settings(max_examples=60, deadline=None)
@given(
    st.integers(2, 12), st.integers(2, 12), st.integers(60, 500), st.integers(60, 500),
    st.floats(1.0, 6.0), st.data(),
)  # fmt: skip
def test_a_touch_is_where_the_finger_is(application, columns, rows, width, height, zoom, data):
    picture = GroundPicture()
    picture.resize(width, height)
    model = MapModel()
    model.set_grid(make_grid(columns, rows))
    picture.show_coverage(model)
    touched = []
    picture.place_touched.connect(lambda *place: touched.append(place))
    picture.zoom_by(zoom, QPointF(width / 3.0, height / 3.0))
    area = picture.area
    x = data.draw(st.integers(int(area.left()) + 1, int(area.right()) - 1))
    y = data.draw(st.integers(int(area.top()) + 1, int(area.bottom()) - 1))
    QTest.mouseClick(picture.viewport(), Qt.LeftButton, pos=QPoint(x, y))
    ((x_mm, y_mm),) = touched
    # A pixel of the extent of 125 x 80 mm at least, in both directions the same.
    px_mm = 1.5 * picture.extent.width() / area.width()
    back = picture.to_screen(x_mm, y_mm)
    assert (round(back.x()), round(back.y())) == (x, y)
    assert picture.extent.left() - px_mm <= x_mm <= picture.extent.right() + px_mm
    assert picture.extent.top() - px_mm <= y_mm <= picture.extent.bottom() + px_mm


def test_marks_that_lie_together_are_touched_one_after_the_other_and_then_the_place(picture):
    marks = [GroundMark(125.0, 90.0, str(one), about=one) for one in (2, 1)]
    touched = []
    picture.mark_touched.connect(touched.append)
    picture.place_touched.connect(lambda x, y: touched.append((round(x), round(y))))
    chosen = None
    for _ in range(3):
        picture.set_marks(
            [GroundMark(*(one.across_mm, one.second_mm, one.text), chosen=one.about == chosen,
                        about=one.about) for one in marks]
        )  # fmt: skip
        touch(picture, 125.0, 90.0)
        chosen = touched[-1]
    assert touched[:2] == [1, 2]
    assert touched[2] == (125, 90)
    touch(picture, 125.0, 50.0)
    assert touched[-1] == (125, 50)


def test_a_candidate_is_painted_over_the_carriage(picture):
    picture.set_carriage((150.0, 80.0))
    assert colour(Mark.CARRIAGE) in colours(picture, 150.0, 80.0)
    picture.set_marks([GroundMark(150.0, 80.0, "")])
    assert colours(picture, 150.0, 80.0, reach=6) == {colour(Mark.PAPER)}
    assert colour(Mark.CANDIDATE) in colours(picture, 150.0, 80.0, reach=16)


def test_a_ring_on_unmeasured_ground_is_grey(picture):
    for measured, own in ((True, Mark.CANDIDATE), (False, Mark.NOT_MEASURED)):
        picture.set_marks([GroundMark(150.0, 80.0, "7", measured=measured)])
        found = colours(picture, 150.0, 80.0, reach=16)
        assert colour(own) in found
        assert (colour(Mark.CANDIDATE) in found) == measured


def test_flags_frames_and_the_stop_that_is_visited_are_seen(picture, grid):
    picture.set_marks([GroundMark(MARKER.x_mm, MARKER.y_mm, "", is_flag=True)])
    at = pixel_of(picture, MARKER.x_mm, MARKER.y_mm)
    flag = picture.to_data(QPointF(at.x() + 4, at.y() - 20))
    assert colour(Mark.MARKER) in colours(picture, *flag, reach=2)
    picture.set_frames([Frame(Area(130.0, 170.0, 60.0, 100.0))])
    assert colour(Mark.INK) in colours(picture, 150.0, 100.0, reach=1)
    model = model_of(grid)
    model.set_target((150.0, 90.0))
    picture.show_coverage(model)
    assert colour(Mark.CURRENT) in colours(picture, 137.5, 95.0, reach=2)
    model.set_target(None)
    picture.show_coverage(model)
    assert colour(Mark.CURRENT) not in colours(picture, 137.5, 95.0, reach=2)


def test_where_a_mine_could_hide_is_hatched(picture, grid):
    x_m, y_m = np.sort(grid.xs_mm) / 1e3, np.sort(grid.ys_mm) / 1e3
    shape = (1, len(y_m), len(x_m))
    tried, found = np.full(shape, 10), np.full(shape, 10)
    found[0, :, :2] = 0
    before = colours(picture, 125.0, 55.0, reach=5)
    picture.set_hiding(a_map(found, tried, x_m=x_m, y_m=y_m, survey_id=grid.survey_id))
    assert colours(picture, 125.0, 55.0, reach=8) > before
    assert colours(picture, 180.0, 55.0, reach=5) == before
    picture.set_hiding(None)
    assert colours(picture, 125.0, 55.0, reach=5) == before


def test_a_finger_moves_what_was_zoomed_and_never_beyond_its_edge(picture):
    touched = []
    picture.place_touched.connect(lambda *place: touched.append(place))
    drag(picture, (150.0, 80.0), (170.0, 80.0))
    assert picture.area.width() == pytest.approx(400.0, abs=1)
    picture.zoom_by(4.0, QPointF(200.0, 165.0))
    under = picture.to_screen(150.0, 80.0)
    drag(picture, (150.0, 80.0), (155.0, 82.0))
    moved = picture.to_screen(150.0, 80.0) - under
    assert moved.x() == pytest.approx(5.0 * picture.area.width() / 31.25, rel=0.1)
    assert moved.y() < 0
    for _ in range(20):
        drag(picture, (150.0, 80.0), (190.0, 110.0))
    left, low = picture.to_data(QPointF(0.0, 330.0))
    assert (left, low) >= (picture.extent.left() - 0.01, picture.extent.top() - 0.01)
    assert not touched
    picture.zoom_by(1e9, QPointF(10.0, 10.0))
    assert picture._zoom == MOST_ZOOM
    picture.show_all()
    assert picture.area.width() == pytest.approx(400.0, abs=1)


def test_what_is_below_a_pixel_stays_there_while_it_is_zoomed(picture):
    at = QPointF(130.0, 200.0)
    before = picture.to_data(at)
    picture.zoom_by(3.0, at)
    assert picture.to_data(at) == pytest.approx(before, abs=0.01)


@pytest.mark.parametrize(("between_ms", "count"), [(20, 0), (150, 1)])
def test_a_double_tap_is_no_bounced_touch(picture, between_ms, count):
    tapped = []
    picture.double_tapped.connect(lambda: tapped.append(True))
    kinds = QEvent.MouseButtonPress, QEvent.MouseButtonRelease, QEvent.MouseButtonDblClick
    for kind, at_ms in zip(kinds, (1000, 1010, 1000 + between_ms)):
        button = Qt.LeftButton if kind != QEvent.MouseButtonRelease else Qt.NoButton
        event = QMouseEvent(kind, QPointF(100, 100), Qt.LeftButton, button, Qt.NoModifier)
        event.setTimestamp(at_ms)
        QApplication.sendEvent(picture.viewport(), event)
    assert len(tapped) == count


def test_a_touch_that_the_filter_takes_away_chooses_nothing(picture):
    touched = []
    picture.place_touched.connect(lambda *place: touched.append(place))
    QTest.mousePress(picture.viewport(), Qt.LeftButton, pos=QPoint(100, 100))
    QTest.mouseRelease(picture.viewport(), Qt.LeftButton, pos=QPoint(-9000, -9000))
    assert touched == []


@pytest.mark.parametrize("size", [(110, 110), (120, 300), (400, 90), (660, 320)])
def test_a_notice_is_never_cut_off(application, size):
    picture = GroundPicture()
    picture.resize(*size)
    sentence = "Nothing above the noise at this depth. No echo does not mean no mine."
    picture.set_notice(sentence)
    image = picture.grab().toImage()
    edge = {image.pixel(x, y) for x in range(size[0]) for y in (0, size[1] - 1)}
    assert len(edge) == 1, "the notice reaches the edge"


def test_a_touch_beside_every_mark_of_a_survey_without_a_plan_does_nothing(application):
    picture = GroundPicture()
    picture.resize(300, 300)
    touched = []
    picture.place_touched.connect(lambda *place: touched.append(place))
    QTest.mouseClick(picture.viewport(), Qt.LeftButton, pos=QPoint(100, 100))
    assert touched == []
    picture.show_picture(FocusedSource(image_of(make_grid())).from_above(), Colours.ENVELOPE)
    touch(picture, SURE.x_mm, SURE.y_mm)
    assert touched[0] == pytest.approx((SURE.x_mm, SURE.y_mm), abs=1.0)


@given(st.floats(-1000.0, 1000.0), st.floats(0.1, 5000.0), st.integers(2, 12))
def test_ticks_are_round_few_and_within_the_axis(low, span, most):
    ticks = round_ticks(low, low + span, most)
    assert len(ticks) <= most
    assert ((ticks >= low - 1e-6 * span) & (ticks <= low + span * (1 + 1e-6))).all()
    if len(ticks) > 1:
        step = ticks[1] - ticks[0]
        leading = step / 10.0 ** np.floor(np.log10(step * (1 + 1e-9)))
        assert min(abs(leading - one) for one in (1.0, 2.0, 5.0, 10.0)) < 1e-6


@pytest.mark.parametrize("axis", [(0.0, 0.0), (5.0, 1.0), (0.0, float("nan"))])
def test_an_axis_without_length_has_no_ticks(axis):
    assert not round_ticks(*axis, 5).size


def test_a_depth_axis_reads_in_hundreds():
    assert round_ticks(-50.0, 350.0, 6).tolist() == [0.0, 100.0, 200.0, 300.0]
