import itertools

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from PyQt5 import sip
from PyQt5.QtCore import QEvent, QPointF, Qt
from PyQt5.QtGui import QColor, QMouseEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QWidget
from test_radar_presenter import image_of
from view_kit import PAST, make_grid, trace_at
from window_helpers import click

from gpr20_common.message import Message
from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.records import Axis, Colours, Source
from gpr20_survey.plan.markers import Marker
from gpr20_survey.radar.soils import Soils
from gpr20_survey.results.candidates import Flag
from gpr20_user_interface.look.shade_colours import LAST_SHADE, NOT_MEASURED
from gpr20_user_interface.pages.ground.radar_sheet import RadarSheet
from gpr20_user_interface.pages.ground.radar_view import RadarView

NOISE = 1e-4


@pytest.fixture
def model():
    model = RadarModel()
    model.begin(make_grid())
    return model


@pytest.fixture
def view(application, model):
    view = RadarView(model)
    view.resize(800, 348)
    view.show()
    yield view
    delete(view)


@pytest.fixture
def sheet(view):
    window = QWidget()
    window.resize(800, 480)
    window.show()
    sheet = RadarSheet(window, view.presenter)
    sheet.changed.connect(view.refresh)
    sheet.fit_wanted.connect(view.begin_fit)
    yield sheet
    delete(window)


def delete(widget):
    """Let nothing of a widget stay that could be painted while Python collects it."""
    widget.close()
    sip.delete(widget)


def add(view, model, *indices, **changes):
    for index in indices:
        model.add(trace_at(model.grid, index, **changes))
    view.refresh()


def add_noise(view, model):
    rng = np.random.default_rng(1)
    for index in range(model.grid.planned):
        s21 = NOISE * (rng.standard_normal(501) + 1j * rng.standard_normal(501))
        model.add(trace_at(model.grid, index, s21))
    view.refresh()


def touch(plot, across, second):
    QTest.mouseClick(plot, Qt.LeftButton, pos=plot.to_screen(across, second).toPoint())


def drag(plot, start, end):
    first, last = plot.to_screen(*start).toPoint(), plot.to_screen(*end).toPoint()
    QTest.mousePress(plot, Qt.LeftButton, pos=first)
    # QTest moves the mouse without a button.
    held = (Qt.NoButton, Qt.LeftButton, Qt.NoModifier)
    QApplication.sendEvent(plot, QMouseEvent(QEvent.MouseMove, QPointF(last), *held))
    QTest.mouseRelease(plot, Qt.LeftButton, pos=last)


def measured(plot):
    return plot.colour_numbers != NOT_MEASURED


def test_the_line_and_the_slice_grow_trace_by_trace(view, model):
    for count, index in enumerate((0, 3, 4, 7, 8), 1):  # of polarization 0
        add(view, model, index)
        levels, places = view.trace_plot.points
        assert places[np.argmax(levels)] == pytest.approx(100.0, abs=7)
        assert measured(view.line_plot).any(axis=0).tolist() == [True] * count + [False] * (
            5 - count
        )
        assert measured(view.slice_plot).sum() == count
    add(view, model, 11)
    # The next line has begun.
    assert measured(view.line_plot).any(axis=0).tolist() == [False] * 4 + [True]
    model.begin(make_grid(survey_id=PAST))
    view.refresh()
    assert not len(view.trace_plot.points[0])
    assert view.slice_plot.colour_numbers is None


def test_a_slice_of_noise_is_dark_and_says_so(view, model):
    add_noise(view, model)
    for _ in range(30):
        click(view.deeper)
        assert view.slice_plot.colour_numbers.max() < 0.1 * LAST_SHADE
        assert "Nothing above the noise at this depth." in view.slice_plot.notice
        assert "No echo does not mean no mine." in view.slice_plot.notice
    assert view.line_plot.colour_numbers.max() < 0.1 * LAST_SHADE
    assert "Nothing above the noise in this line." in view.line_plot.notice
    assert view.readout.endswith("noise")


def test_the_settings_change_the_picture_and_not_the_data(view, model, sheet):
    add(view, model, *range(40))
    data = [model.echoes(number).copy() for number in (0, 1)]
    click(sheet.background)
    for button in (
        *(sheet.scale, sheet.axis, sheet.gain.more, sheet.permittivity.less),
        *(sheet.polarization, sheet.colours[Colours.GREY], sheet.soils[Soils.WET_SAND]),
    ):
        before = view.grab().toImage()
        click(button)
        assert view.grab().toImage() != before
    for number in (0, 1):
        assert (model.echoes(number) == data[number]).all()


def test_permittivity_and_gain_stop_at_their_ends(view, sheet):
    for _ in range(60):
        click(sheet.permittivity.less)
        click(sheet.gain.more)
    assert view.presenter.settings.permittivity == 1.0
    assert not sheet.permittivity.less.isEnabled()
    assert view.presenter.settings.gain_db_per_ns == 10.0


def test_a_soil_sets_the_permittivity_and_your_own_is_kept(view, sheet):
    click(sheet.soils[Soils.CLAY])
    assert view.presenter.settings.permittivity == Soils.CLAY.value.permittivity
    assert sheet.soils[Soils.CLAY].isChecked()
    click(sheet.permittivity.more)
    assert view.presenter.settings.permittivity == 16.0
    assert sheet.soils[None].isChecked()
    click(sheet.soils[Soils.DRY_SAND])
    assert [soil for soil, key in sheet.soils.items() if key.isChecked()] == [Soils.DRY_SAND]
    click(sheet.soils[None])
    assert view.presenter.settings.permittivity == 16.0


def test_keys_and_slider_choose_the_depth(view, model):
    add(view, model, *range(40))
    view.depth_slider.setValue(20)
    view.refresh()
    assert view.presenter.settings.depth_m == pytest.approx(0.1)
    assert "100 mm" in view.slice_key.text()
    click(view.deeper)
    assert "105 mm" in view.slice_key.text()
    assert view.depth_slider.value() == 21
    click(view.shallower)
    QTest.mouseClick(view.depth_slider, Qt.LeftButton)  # the middle
    view.refresh()
    assert view.depth_slider.value() == pytest.approx(view.depth_slider.maximum() / 2, abs=1)


def test_a_touch_on_the_slice_chooses_the_line(view, model):
    add(view, model, *range(40))
    touch(view.slice_plot, 150.0, 90.0)
    view.refresh()
    assert "Line at Y 90" in view.line_key.text()
    assert view.slice_plot.crosshair == (150.0, 90.0)
    assert view.line_plot.crosshair == (150.0, 50.0)
    assert view.trace_plot.crosshair == (None, 50.0)
    click(view.along)
    assert "Line at X 150" in view.line_key.text()
    touch(view.line_plot, 110.0, 200.0)
    view.refresh()
    assert view.slice_plot.crosshair == (150.0, 110.0)
    assert view.readout.startswith("X 150 Y 110 depth 200 mm:")
    touch(view.trace_plot, 0.5, 100.0)
    view.refresh()
    assert view.line_plot.crosshair[1] == pytest.approx(100.0, abs=5)
    assert view.slice_key.text().endswith("100 mm")


def test_one_picture_fills_the_tab_and_shrinks_again(view, model):
    add(view, model, *range(40))
    plots = {
        view.trace_key: view.trace_plot,
        view.line_key: view.line_plot,
        view.slice_key: view.slice_plot,
    }
    for key, plot in plots.items():
        width = plot.width()
        click(key)
        QTest.qWait(1)
        assert [one for one in plots.values() if one.isVisible()] == [plot]
        assert plot.width() > 2 * width
        assert view.readout in key.text()
        assert view.note.isVisible()
        click(key)
        QTest.qWait(1)
        assert all(one.isVisible() for one in plots.values())


def test_a_hyperbola_is_dragged_and_its_permittivity_taken_over(view, model, sheet):
    add(view, model, *range(40))
    touch(view.slice_plot, 150.0, 90.0)
    sheet.open()
    click(sheet.fit)
    assert not sheet.isVisible()
    QTest.qWait(1)
    assert view.line_plot.isVisible()
    assert not view.slice_plot.isVisible()
    drag(view.line_plot, view.line_plot.grip, (125.0, 150.0))
    view.refresh()
    assert view.line_plot.grip == pytest.approx((125.0, 150.0), abs=4)
    assert view.presenter.hyperbola.permittivity == pytest.approx(4.0)
    drag(view.line_plot, (200.0, 250.0), (200.0, 200.0))
    fitted = view.presenter.hyperbola.permittivity
    view.refresh()
    assert fitted != pytest.approx(4.0, abs=0.5)
    assert f"{fitted:.1f}" in view.fit_text.text()
    click(view.use)
    assert view.presenter.settings.permittivity == round(fitted, 1)
    assert view.presenter.hyperbola is None
    assert view.slice_plot.isVisible()
    assert not view.use.isVisible()


def test_a_hyperbola_is_dropped_by_a_key_or_by_another_survey(view, model):
    add(view, model, *range(40))
    for end in (
        lambda: click(view.drop),
        lambda: model.begin(make_grid(rotations_deg=(45.0,), survey_id=PAST)),
    ):
        view.begin_fit()
        assert view.use.isVisible()
        end()
        view.refresh()
        assert not view.use.isVisible()
        assert view.presenter.settings.permittivity == 4.0
        assert view.slice_plot.isVisible()
    # One rotation is enough.
    add(view, model, 0)
    view.presenter.next_polarization()
    view.refresh()
    assert view.presenter.settings.polarization == 0
    assert "45°" in view.trace_key.text()


def test_a_marker_is_asked_for_at_the_crosshair_and_drawn(view, model):
    view.set_markers([], can_mark=False)
    add(view, model, *range(40))
    assert not view.marker.isEnabled()
    view.set_markers([], can_mark=True)
    view.refresh()
    wanted = []
    view.marker_wanted.connect(lambda *place: wanted.append(place))
    touch(view.slice_plot, 150.0, 90.0)
    click(view.marker)
    assert wanted == [(150.0, 90.0, 50.0)]
    view.set_markers([Marker(PAST, 150.0, 90.0, 50.0), Marker(PAST, 100.0, 50.0)], True)
    view.refresh()
    assert [one.is_near for one in view.slice_plot.spots] == [True, True]
    assert [(one.across, one.second) for one in view.line_plot.spots] == [(150.0, 50.0)]
    view.depth_slider.setValue(40)
    view.refresh()
    assert [one.is_near for one in view.slice_plot.spots] == [False, True]


def test_the_focused_image_and_its_candidates_are_drawn(view, model):
    add(view, model, *range(40))
    click(view.source)
    assert "not focused yet" in view.slice_plot.notice
    view.set_image(None, Message("The imaging node does not answer"))
    view.refresh()
    assert view.slice_plot.notice.startswith("The imaging node does not answer. ")
    view.set_image(image_of(model.grid), None)
    touch(view.slice_plot, 150.0, 90.0)
    view.depth_slider.setValue(12)
    view.refresh()
    assert view.slice_plot.colour_numbers.shape == (13, 21)
    assert view.slice_plot.notice == ""
    assert view.readout.endswith(": 40 dB")
    assert view.trace_key.text().endswith("40 dB")
    assert "Focused with permittivity 4." in view.note.text()
    assert [one.text for one in view.slice_plot.spots] == ["1"]
    assert [(one.text, one.second) for one in view.line_plot.spots] == [("1", 60.0)]
    view.depth_slider.setValue(40)
    view.refresh()
    assert "Nothing above the clutter at this depth." in view.slice_plot.notice
    click(view.source)
    assert view.presenter.settings.source is Source.ECHOES
    assert view.slice_plot.colour_numbers.shape == (4, 5)


def test_a_focused_image_begins_at_its_first_candidate(view, model):
    add(view, model, 0)
    click(view.source)
    view.set_image(image_of(model.grid), None)
    view.refresh()
    assert (view.presenter.place.x_mm, view.presenter.place.y_mm) == (150.0, 90.0)
    assert view.line_plot.colour_numbers is not None


def test_doubtful_candidates_have_numbers_where_there_is_room(view, model):
    add(view, model, *range(40))
    click(view.source)
    sure = candidate(1, 150.0, 90.0, 50.0, 40.0)
    doubtful = candidate(2, 100.0, 50.0, 50.0, 20.0, [Flag.SIDELOBE])
    found = candidate_list([sure, doubtful], survey_id=model.grid.survey_id)
    view.set_image(image_of(model.grid, found=found), None)
    view.refresh()
    assert [(one.text, one.doubtful) for one in view.slice_plot.spots] == [
        ("1", False),
        ("", True),
    ]
    click(view.slice_key)
    view.refresh()
    assert [one.text for one in view.slice_plot.spots] == ["1", "2"]


def test_what_was_not_measured_is_hatched_in_every_colour(view, model):
    add(view, model, 0)
    area = view.slice_plot.area()
    left, top = int(area.right() - area.width() / 5 + 4), int(area.top() + 4)
    for colours in Colours:
        view.presenter.change(colours=colours, remove_background=False)
        view.refresh()
        picture = view.slice_plot.grab().toImage()
        cell = itertools.product(range(left, left + 10), range(top, top + 10))
        found = {picture.pixel(x, y) for x, y in cell}
        assert QColor("#ffffff").rgb() in found
        assert len(found) > 1


def test_it_never_says_that_there_is_nothing(view, model):
    add(view, model, *range(40), s21=np.zeros(501))
    for plot in (view.trace_plot, view.line_plot, view.slice_plot):
        view.enlarge(plot)
        assert "No echo does not mean no mine" in view.note.text()
        assert view.note.isVisible()
    assert "clear" not in view.note.text().lower()


def test_it_says_what_is_missing_in_the_picture(view, model):
    add(view, model, 0, height_m=float("nan"))
    assert "SIMULATED" in view.note.text()
    assert "No height was measured" in view.slice_plot.notice
    assert view.line_plot.axis is Axis.DELAY_NS
    assert not view.deeper.isEnabled()
    assert "The background is not removed from fewer than 8 traces" in view.note.text()
    model.give_up(5, "torn")
    view.refresh()
    assert "Cannot be shown: 1" in view.note.text()


def test_without_a_survey_it_says_so(view):
    view.show_model(RadarModel())
    assert "No survey yet" in view.slice_plot.notice
    assert not view.marker.isEnabled()
    assert not view.presenter.can_fit


def test_nothing_is_drawn_while_nobody_can_see_it(view, model):
    view.hide()
    add(view, model, 0)
    assert not len(view.trace_plot.points[0])
    view.show()
    assert len(view.trace_plot.points[0])
