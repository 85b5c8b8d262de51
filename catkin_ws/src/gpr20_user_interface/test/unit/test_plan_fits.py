"""CONTROL and the sheets: nothing is cut off or overlaps, on any screen and in each language."""

import random

from layout_kit import assert_fits, assert_touchable, busiest, screen, spoken
from PyQt5.QtTest import QTest
from window_helpers import click, open_field, show

from gpr20_operator.plan.fields import VALUE_TILES, default_parameters
from gpr20_operator.plan.form import PLAN_FIELDS
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import TEXT_PX, TOUCH_PX
from gpr20_user_interface.look.style_sheet import FITS

__all__ = ["screen", "spoken"]

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
PEOPLE = Annotation("W" * 60, "W" * 60, "W " * 2000, Wgs84Position(-89.123456, -179.123456))
IDENTITY = "Rohde&Schwarz,ZNB20-4Port,1311601062100123,3.40.0.1 with options K2, K4 and B16"


def plan(window):
    """Let CONTROL show the plan."""
    show(window, busiest(SurveyState.IDLE))
    return window.control


def assert_plan_fits(window, *parts):
    assert_fits(window, *parts)
    assert_touchable(window, *parts)


def uncut(tile):
    return not any(line.is_cut for line in tile.lines if line.isVisible()) and not tile.title.is_cut


def test_the_tiles_show_the_longest_values(spoken):
    control = plan(spoken)
    control.form.set_texts(LONGEST)
    control.show_plan()
    assert_plan_fits(spoken, control)
    for tile in VALUE_TILES[:-2]:
        assert uncut(control.tiles[tile]), tile
    assert uncut(control.figures) and uncut(control.start)


def test_what_is_wrong_fits_its_tile_and_start(spoken):
    control = plan(spoken)
    for name in PLAN_FIELDS:
        right = control.form.texts[name]
        for wrong in ("-7 x5", "-7,5"):
            control.form.set_text(name, wrong)
            control.show_plan()
            assert_plan_fits(spoken, control)
            reason = control.start.problem
            assert reason.isVisible() and not reason._lines()[-1].endswith("…")
        control.form.set_text(name, right)


def test_the_sheets_of_the_tiles_fit_with_right_and_wrong_values(spoken):
    values = spoken.values
    plan(spoken).form.set_texts(LONGEST)
    values.last_area = {"x_start_mm": "1", "x_stop_mm": "2"}
    for tile in VALUE_TILES:
        values.show_tile(tile)
        for name in list(values.fields):
            values.choose(name)
            assert_plan_fits(spoken, values)
            values.keys.press("7")
            assert_fits(spoken, values)
            values.fields[name].setText("7 x")
            values._on_edited(values._active)
            assert_plan_fits(spoken, values)


def test_the_figures_fit(spoken):
    plan(spoken).figures.click()
    assert_plan_fits(spoken, spoken.control.figures)


def test_the_sheets_to_hold_for_fit(spoken):
    sheet = spoken.start_sheet
    for ask in (
        lambda: sheet.ask_start(default_parameters(), PEOPLE),
        lambda: sheet.ask_resume_past("20261121T051000_7c9e6679"),
        lambda: sheet.ask_resume_with(IDENTITY),
    ):
        plan(spoken)
        ask()
        assert_plan_fits(spoken, sheet)


def test_the_notes_and_their_keys_fit(spoken):
    sheet = spoken.annotation
    plan(spoken)
    for survey in ("", "20261121T051000_7c9e6679"):
        sheet.show_annotation(survey, PEOPLE)
        assert_plan_fits(spoken, sheet)
    sheet.fields["latitude"].setText("-100.123456")
    assert sheet.problem.text()
    assert_plan_fits(spoken, sheet)
    for name, field in sheet.fields.items():
        field.tapped.emit()
        pad = sheet.number_pad if sheet.number_pad.isVisible() else sheet.text_pad
        assert_plan_fits(spoken, pad)
        if pad is sheet.text_pad:
            for change in (pad.shift, pad.others):
                change.click()
                assert_plan_fits(spoken, pad)
                shortest = min(min(key.height(), key.width()) for key in pad.keys)
                assert shortest >= spoken.look.px(TOUCH_PX), name
        pad.hide()


def test_the_profiles_and_their_keys_fit(spoken):
    profiles = spoken.profiles
    plan(spoken)
    for number in range(20):
        profiles._save(f"{'a' * 30}{number:02d}")
    profiles.show_profiles(default_parameters())
    profiles.names.setCurrentRow(0)
    assert_fits(spoken, profiles)
    profiles.delete.click()
    assert_fits(spoken, profiles.confirm)
    profiles.save.click()
    for key in ("", "-"):
        profiles.name_pad.press(key)
        assert_plan_fits(spoken, profiles.name_pad)


def beginning_is_seen(edit):
    """Return whether the first character is at the left end of the field."""
    edit.setCursorPosition(0)
    # Qt adds 5 pixels at the left of the cursor.
    return edit.cursorRect().left() + 5 >= 0


def test_random_numbers_are_whole_or_show_their_beginning(spoken):
    """600.1234 must not read as 500.1234 or 00.1234."""
    draw = random.Random(5)
    plan(spoken)
    for name in PLAN_FIELDS:
        edit = open_field(spoken, name)
        QTest.qWait(1)
        for _ in range(10):
            text = f"{draw.uniform(-1e4, 1e4):.{draw.randint(0, 30)}f}"
            edit.setText(text)
            edit.select_all()
            needed_px = edit.fontMetrics().horizontalAdvance(text)
            assert needed_px <= edit.room_px or edit.property("fit") == list(FITS)[-1]
            assert edit.cursorPosition() == 0 or needed_px <= edit.room_px
            assert beginning_is_seen(edit)
        click(spoken.values.done)


def test_no_coordinate_needs_smaller_letters_than_18_px(spoken):
    plan(spoken)
    edit = open_field(spoken, "x_stop_mm")
    QTest.qWait(1)
    for text in ("600.1234", "500.1234", "123.456789", "0.00001"):
        edit.setText(text)
        assert edit.fontMetrics().horizontalAdvance(text) <= edit.room_px
        assert edit.fontInfo().pixelSize() >= round(TEXT_PX * spoken.look.scale) - 1
    edit.setText("192.168.100.100")
    assert edit.fontMetrics().horizontalAdvance("192.168.100.100") <= edit.room_px
