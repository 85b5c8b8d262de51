"""Nothing of RADAR is cut off: both languages, every size of screen, every state of the tab."""

import itertools

import pytest

pytest.importorskip("PyQt5")

import numpy as np
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QLabel, QPushButton
from view_kit import depth_echo, make_grid, trace_at
from window_helpers import application, close, new_window

from gpr20_common.low.catalogue_file import languages
from gpr20_common.message import Message
from gpr20_user_interface.mid.radar_records import RadarSettings
from gpr20_user_interface.mid.shown_band import ShownBand
from gpr20_user_interface.views.look import BORDER_PX, TOUCH_PX
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.translation import Languages

__all__ = ["application"]

SIZES = ((480, 320), (800, 480), (1280, 800))
PADDING_PX = 4


BAND = ShownBand(Message("PAST SURVEY: {name}", name="2026-11-21 05:10:00 UTC"), True)


@pytest.fixture(scope="module", params=itertools.product(languages(), SIZES), ids=str)
def screen(request, application):
    """One window for all tests on a screen, with a survey of some traces."""
    language, size = request.param
    window = new_window(Languages(application, language))
    window.show()
    window.resize(*size)
    grid = make_grid(x_stop_mm=583.33, x_start_mm=416.67, y_start_mm=683.33, y_stop_mm=783.33)
    live = window.traces.live
    live.begin(grid)
    rng = np.random.default_rng(1)
    for index in range(10):
        noise = 1e-4 * (rng.standard_normal(501) + 1j * rng.standard_normal(501))
        live.take_trace(trace_at(grid, index, depth_echo(0.1, level=0.05) + noise))
    window.show_tab(TabName.RADAR)
    yield window
    close(window)


@pytest.fixture(params=(None, BAND), ids=("live", "past"))
def window(request, screen):
    screen.radar_binding.sheet.hide()
    screen.radar_page.band.show_band(request.param)
    screen.radar.presenter.settings = RadarSettings(depth_m=0.455)
    screen.radar.presenter.end_hyperbola()
    screen.radar.enlarge(None)
    screen.radar.refresh()
    QTest.qWait(1)
    return screen


def assert_fits(window, part):
    # What is laid out again for a text, and then for its height, takes two rounds.
    for _ in range(3):
        QTest.qWait(1)
    touch_px = window.look.px(TOUCH_PX)
    frame_px = 2 * window.look.px(BORDER_PX + PADDING_PX)
    for kind in (QLabel, QPushButton):
        for widget in part.findChildren(kind):
            if not widget.isVisible() or not widget.text():
                continue
            text = widget.text()
            corner = widget.mapTo(window, widget.rect().bottomRight())
            assert corner.x() < window.width() and corner.y() < window.height(), text
            if kind is QLabel and widget.wordWrap():
                assert widget.heightForWidth(widget.width()) <= widget.height(), text
                continue
            lines = text.split("\n")
            metrics = widget.fontMetrics()
            widest = max(metrics.horizontalAdvance(line) for line in lines)
            assert widest <= widget.width() - (frame_px if kind is QPushButton else 0), text
            assert metrics.height() * len(lines) <= widget.height(), text
            if kind is QPushButton:
                assert min(widget.height(), widget.width()) >= touch_px, text


def assert_apart(widgets):
    shown = [one for one in widgets if one.isVisible()]
    for number, one in enumerate(shown):
        for other in shown[number + 1 :]:
            assert not one.geometry().intersects(other.geometry()), (one, other)


def test_nothing_of_the_three_pictures_is_cut_off(window):
    view = window.radar
    assert_fits(window, view)
    assert_apart([view.trace_plot, view.line_plot, view.slice_plot, view.bar, view.note])
    for plot in (view.line_plot, view.slice_plot):
        assert plot.area().height() >= 0.15 * window.height()
    assert view.slice_plot.notice


def test_nothing_of_an_enlarged_picture_is_cut_off(window):
    view = window.radar
    view.presenter.set_depth(0.1)
    for plot in (view.trace_plot, view.line_plot, view.slice_plot):
        view.enlarge(plot)
        assert_fits(window, view)
        assert view.readout.endswith(" dB")
        assert_apart([plot, view.top_bar, view.note])
        assert plot.area().height() > 0.2 * window.height()


def test_nothing_of_the_hyperbola_is_cut_off(window):
    window.radar.presenter.change(permittivity=80.5)
    window.radar.begin_fit()
    assert window.radar.use.isVisible()
    assert_fits(window, window.radar)


def test_nothing_of_the_settings_is_cut_off(window):
    window.radar.presenter.change(permittivity=39.5, gain_db_per_ns=10.0)
    window.radar.settings.click()
    for _ in range(2):
        assert_fits(window, window.radar_binding.sheet)
        for key in ("polarization", "axis", "scale", "background", "follow"):
            getattr(window.radar_binding.sheet, key).click()
