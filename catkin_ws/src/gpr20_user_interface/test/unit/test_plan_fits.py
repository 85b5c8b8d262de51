"""CONTROL and its sheets: nothing is cut off or overlaps, on any screen and in each language."""

import pytest
from PyQt5.QtCore import QPoint, QRect
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QAbstractButton, QLabel, QLineEdit
from window_helpers import application, close, new_window, show, snapshot

from gpr20_common.low.catalogue_file import languages
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_cost import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.parameter_form import default_parameters, texts_of
from gpr20_user_interface.mid.plan_form import PLAN_FIELDS
from gpr20_user_interface.mid.plan_tiles import VALUE_TILES
from gpr20_user_interface.mid.survey_preview import SurveyPreview
from gpr20_user_interface.views.elided_label import ElidedLabel
from gpr20_user_interface.views.field_box import FieldBox
from gpr20_user_interface.views.lines_label import LinesLabel
from gpr20_user_interface.views.look import GAP_PX, TEXT_PX, TOUCH_PX
from gpr20_user_interface.views.overlay import Overlay
from gpr20_user_interface.views.translation import Languages

__all__ = ["application"]

SIZES = ((480, 320), (800, 480), (1280, 800))
LARGEST = SurveyPreview(
    stops=500000,
    traces=1000000,
    x_spacing_mm=12.34,
    y_spacing_mm=23.45,
    frequency_step_hz=1.350675e6,
    depth_m=110.98,
    resolution_m=0.02776,
    quarter_wavelength_mm=1.234,
    cost=SurveyCost(99 * 86400.0 + 86399.0, 123456 * 10**6),
)
LONGEST = {
    "vna_address": "192.168.100.100",
    "start_frequency_hz": "5999.999",
    "stop_frequency_hz": "6000",
    "frequency_points": "4000",
    "x_start_mm": "123.45",
    "x_stop_mm": "649.99",
    "y_start_mm": "123.45",
    "y_stop_mm": "799.99",
    "x_points": "1000",
    "y_points": "1000",
    "polarizations_deg": "-90, -45, 0, 45",
    "if_bandwidth_hz": "100000",
    "averages": "65535",
    "output_power": "HIGH",
    "permittivity": "12.345",
}


@pytest.fixture(
    scope="module", params=[(one, size) for one in languages() for size in SIZES], ids=str
)
def screen(request, application, tmp_path_factory):
    """One window for all tests on a screen."""
    language, size = request.param
    window = new_window(
        Languages(application, language), profiles=tmp_path_factory.mktemp("profiles")
    )
    window.resize(*size)
    window.show()
    window.survey.preview = LARGEST
    yield window
    close(window)


@pytest.fixture
def shown(screen):
    for overlay in screen.findChildren(Overlay):
        overlay.hide()
    screen.control.form.set_texts(texts_of(default_parameters()))
    show(screen, snapshot(SurveyState.IDLE))
    return screen


def parts(page, kind):
    return [one for one in page.findChildren(kind) if one.isVisible()]


def assert_fits(window, page):
    """Check everything that is seen on a tab or sheet."""
    QTest.qWait(1)
    look = window.look
    edge = QRect(QPoint(0, 0), window.size())
    for label in parts(page, QLabel):
        if isinstance(label, LinesLabel):
            assert label.height() >= label.fontMetrics().height()
            continue
        assert edge.contains(place(window, label)), label.text()
        assert label.fontInfo().pixelSize() >= look.px(TEXT_PX), label.text()
        if label.wordWrap():
            assert label.heightForWidth(label.width()) <= label.height(), label.text()
        elif not isinstance(label, ElidedLabel):
            assert label.sizeHint().width() <= label.width(), label.text()
        assert label.fontMetrics().height() <= label.height() + 1, label.text()
    for button in parts(page, QAbstractButton):
        assert edge.contains(place(window, button)), button.text()
        wide_px = max(map(button.fontMetrics().horizontalAdvance, button.text().split("\n")))
        assert wide_px <= button.contentsRect().width() - 2, button.text()
        # A pixel of rounding at the small scale.
        assert button.height() >= look.px(TOUCH_PX) - 3, button.text()
    for edit in parts(page, QLineEdit):
        text = edit.text() or edit.placeholderText()
        fits = edit.fontMetrics().horizontalAdvance(text) <= edit.room_px
        assert fits or edit.property("fit") == "small", text
    for box in parts(page, FieldBox):
        assert box.height() >= look.px(TOUCH_PX), box.title.text()
    touched = parts(page, QAbstractButton) + parts(page, FieldBox)
    for number, one in enumerate(touched):
        for other in touched[number + 1 :]:
            assert apart(window, one, other) >= look.px(GAP_PX) - 1, (
                one.text() if isinstance(one, QAbstractButton) else one,
                place(window, one),
                place(window, other),
            )


def place(window, widget):
    return QRect(widget.mapTo(window, QPoint(0, 0)), widget.size())


def apart(window, one, other):
    """Return how far two places are apart [px]; negative if they overlap."""
    first, second = place(window, one), place(window, other)
    across = max(first.left() - second.right(), second.left() - first.right())
    down = max(first.top() - second.bottom(), second.top() - first.bottom())
    return max(across, down) - 1


def uncut(tile):
    return not any(line.is_cut for line in tile.lines if line.isVisible()) and not tile.title.is_cut


def test_the_tiles_show_the_longest_values(shown):
    shown.control.form.set_texts(LONGEST)
    shown.control.show_plan()
    assert_fits(shown, shown.control)
    for tile in VALUE_TILES[:-2]:
        assert uncut(shown.control.tiles[tile]), tile
    assert uncut(shown.control.figures) and uncut(shown.control.start)


def test_what_is_wrong_fits_its_tile_and_start(shown):
    for name in PLAN_FIELDS:
        right = shown.control.form.texts[name]
        shown.control.form.set_text(name, "-7 x5")
        shown.control.show_plan()
        assert_fits(shown, shown.control)
        reason = shown.control.start.problem
        assert reason.isVisible() and not reason._lines()[-1].endswith("…")
        shown.control.form.set_text(name, right)


def test_the_sheets_fit_with_right_and_wrong_values(shown):
    shown.values.last_area = {"x_start_mm": "1", "x_stop_mm": "2"}
    shown.control.form.set_texts(LONGEST)
    for tile in VALUE_TILES:
        shown.values.show_tile(tile)
        for name in list(shown.values.fields):
            shown.values.choose(name)
            assert_fits(shown, shown.values)
            shown.values.fields[name].setText("7 x")
            shown.values._on_edited(shown.values._active)
            assert_fits(shown, shown.values)


def test_figures_fit(shown):
    shown.control.figures.click()
    assert_fits(shown, shown.control_binding.figures)


def test_notes_and_their_keys_fit(shown):
    sheet = shown.annotation
    position = Wgs84Position(-89.123456, -179.123456)
    longest = Annotation("W" * 60, "W" * 60, "W " * 2000, position, name="W" * 60)
    for survey in ("", "20261121T051000_7c9e6679"):
        sheet.show_annotation(survey, longest)
        assert_fits(shown, sheet)
    sheet.fields["latitude"].setText("-100.123456")
    assert_fits(shown, sheet)
    for name, field in sheet.fields.items():
        field.tapped.emit()
        pad = sheet.number_pad if name in ("latitude", "longitude") else sheet.text_pad
        assert_fits(shown, pad)
        pad.hide()
    sheet.fields["notes"].tapped.emit()
    for change in (sheet.text_pad.shift, sheet.text_pad.others):
        change.click()
        assert_fits(shown, sheet.text_pad)
    assert min(key.width() for key in sheet.text_pad.keys) >= shown.look.px(TOUCH_PX)


def test_the_keys_of_a_profile_fit(shown):
    shown.profiles.show_profiles(None)
    shown.profiles._ask_name()
    assert_fits(shown, shown.profiles.name_pad)
    shown.profiles.name_pad.press("-")
    assert_fits(shown, shown.profiles.name_pad)
