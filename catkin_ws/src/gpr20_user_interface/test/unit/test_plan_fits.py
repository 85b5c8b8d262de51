"""CONTROL and the sheets: nothing is cut off or overlaps, on any screen and in each language."""

import random

import pytest
from layout_kit import SMALLEST_TOUCH_PX, assert_fits, busiest, screen, spoken
from PyQt5.QtTest import QTest
from view_kit import past_survey
from window_helpers import click, open_field, show

from gpr20_operator.ground.trace_events import SurveysListed
from gpr20_operator.plan.fields import PLAN, TILE_FIELDS, VALUE_TILES, default_parameters
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_survey.plan.survey_state import SurveyState

__all__ = ["screen", "spoken"]

LONGEST = {
    "vna_address": "192.168.100.100",
    "start_frequency_hz": "999.999",
    "stop_frequency_hz": "6000",
    "frequency_points": "4000",
    "x_start_mm": "123.45",
    "x_stop_mm": "649.99",
    "y_start_mm": "123.45",
    "y_stop_mm": "799.99",
    "x_points": "500",
    "y_points": "500",
    "polarizations_deg": "-90, -45, 0, 45",
    "if_bandwidth_hz": "100000",
    "averages": "1000",
    "output_power": "HIGH",
    "permittivity": "12.345",
}
# Characters of a number that are always seen.
LONGEST_SEEN = 14
PEOPLE = Annotation("Wim " * 15, "Wim " * 15, "W " * 2000, Wgs84Position(-89.123456, -179.123456))
IDENTITY = "Rohde&Schwarz,ZNB20-4Port,1311601062100123,3.40.0.1 with options K2, K4 and B16"


def plan(window):
    """Let CONTROL show the plan."""
    show(window, busiest(SurveyState.IDLE))
    return window.control


def uncut(tile):
    return not any(line.is_cut for line in tile.lines if line.isVisible()) and not tile.title.is_cut


def test_the_tiles_show_the_longest_values(spoken):
    control = plan(spoken)
    control.form.set_texts(LONGEST)
    control.show_plan()
    assert_fits(spoken, control)
    for tile in VALUE_TILES:
        assert uncut(control.tiles[tile]), tile
    assert all(map(uncut, (control.saved, control.check_plan, control.start)))


def test_a_survey_to_resume_fits_beside_start(spoken):
    control = plan(spoken)
    survey = past_survey(name="W" * 60, stored_traces=999999, planned_traces=1000000)
    spoken.on_event(SurveysListed("", (survey,), False))
    control = plan(spoken)
    assert control.resume.isVisible()
    assert_fits(spoken, control)
    assert not control.resume.lines[1].is_cut and not control.start.title.is_cut
    spoken.on_event(SurveysListed("", (), False))


def test_what_is_wrong_fits_its_tile_and_start(spoken):
    control = plan(spoken)
    for spec in PLAN:
        right = control.form.texts[spec.name]
        for wrong in ("-7 x5", "-7,5"):
            control.form.set_text(spec.name, wrong)
            control.show_plan()
            assert_fits(spoken, control)
            for tile in (control.tiles[spec.tile], control.start):
                reason = tile.sentence
                assert reason.isVisible() and not reason.is_cut, reason.whole
        control.form.set_text(spec.name, right)


def test_the_sheets_of_the_tiles_fit_with_right_and_wrong_values(spoken):
    values = spoken.values
    plan(spoken).form.set_texts(LONGEST)
    values.last_area = {"x_start_mm": "1", "x_stop_mm": "2"}
    for tile in VALUE_TILES:
        values.show_tile(tile)
        for name in TILE_FIELDS[tile]:
            values.choose(name)
            assert_fits(spoken, values)
            assert all(uncut(field) for field in values.fields if field.isVisible()), name
            values.write("7")
            assert_fits(spoken, values)
            values.write(" x")
            assert_fits(spoken, values)


def test_everything_about_the_plan_fits_before_the_start_and_on_its_own(spoken):
    control = plan(spoken)
    for texts in (LONGEST, {"x_spacing_mm": "25", "polarizations_deg": "0"}):
        control.form.set_texts(texts)
        control.next_annotation.value = PEOPLE
        control.show_plan()
        for tile, sheet in (
            (control.start, spoken.start_sheet),
            (control.check_plan, control.summary),
        ):
            tile.click()
            assert sheet.doubt.isVisible()
            assert_fits(spoken, sheet)
            sheet.hide()


def test_the_sheets_to_hold_for_fit(spoken):
    sheet = spoken.start_sheet
    for ask in (
        lambda: sheet.ask_start(default_parameters(), 4.0, PEOPLE),
        lambda: sheet.ask_resume_past("20261121T051000_7c9e6679"),
        lambda: sheet.ask_resume_with(IDENTITY),
    ):
        plan(spoken)
        ask()
        assert_fits(spoken, sheet)


def test_the_records_and_their_keys_fit(spoken):
    sheet = spoken.annotation
    plan(spoken)
    for survey in ("", "20261121T051000_7c9e6679"):
        sheet.show_annotation(survey, PEOPLE)
        assert_fits(spoken, sheet)
    pad = sheet.pad
    for name, tile in sheet.tiles.items():
        tile.click()
        assert_fits(spoken, pad)
        for change in (pad.letters.shift, pad.letters.others):
            if change.isVisible():
                change.click()
                assert_fits(spoken, pad)
        block = pad.letters if pad.letters.isVisible() else pad.digits
        shortest = min(min(key.height(), key.width()) for key in block.keys)
        assert shortest >= spoken.look.px(SMALLEST_TOUCH_PX), name
        pad.hide()
    sheet.texts.update(notes="", name="N")
    sheet._on_save()
    assert_fits(spoken, spoken.annotation.confirm)


@pytest.mark.parametrize("text", ["1", "91,0", "4.6,1-"])
def test_what_is_wrong_with_a_position_fits(spoken, text):
    plan(spoken)
    spoken.annotation.show_annotation("", PEOPLE)
    spoken.annotation.tiles["position"].click()
    spoken.annotation.pad.press(text)
    assert not spoken.annotation.pad.accept_button.isEnabled()
    assert_fits(spoken, spoken.annotation.pad)


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
        profiles.pad.press(key)
        assert_fits(spoken, profiles.pad)


def test_random_numbers_are_whole_or_show_their_beginning(spoken):
    """600.1234 must not read as 500.1234 or 00.1234."""
    draw = random.Random(5)
    plan(spoken)
    for spec in PLAN:
        field = open_field(spoken, spec.name)
        QTest.qWait(1)
        for _ in range(10):
            text = f"{draw.uniform(-1e4, 1e4):.{draw.randint(0, 30)}f}"
            spoken.values.choose(spec.name)
            spoken.values.write(text)
            (line,) = field.lines
            shown = line.text()
            assert shown == f"{text}|" or (shown.endswith("…") and text.startswith(shown[:-1]))
            assert not line.is_cut or len(text) > LONGEST_SEEN
        click(spoken.values.done)
