"""CONTROL: the plan in tiles, the sheets of the tiles, and why START is locked."""

from dataclasses import replace

from PyQt5.QtTest import QTest
from view_kit import snapshot
from window_helpers import click, enter, open_field, show, start, tile_of, wishes

from gpr20_operator.plan.form import PERMITTIVITY, X_SPACING, Y_SPACING
from gpr20_operator.plan.fields import ANALYZER_FIELDS, default_parameters
from gpr20_operator.plan.preview import preview
from gpr20_operator.plan.fields import TILE_FIELDS, VALUE_TILES
from gpr20_operator.plan.spec import Tile
from gpr20_operator.robot.events import Request, RobotDefaults
from gpr20_operator.robot.replay import ReplayMark, ReplayView
from gpr20_survey.plan.site import Site
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_user_interface.widgets.keys import CLEAR, DOWN, ERASE, STEP, UP


def text(window, name):
    return window.control.form.texts[name]


def lines(window, tile):
    return tuple(line.whole for line in window.control.tiles[tile].lines if line.whole)


def press(window, keys):
    """Touch keys of the open sheet, one after the other."""
    for key in keys:
        window.values.keys.press(key)


def test_start_carries_what_the_operator_entered(window):
    received = wishes(window)
    show(window, snapshot(SurveyState.IDLE))
    enter(window, "x_points", "7")
    enter(window, "start_frequency_hz", "700,5")
    enter(window, "vna_address", "10.0.7.23")
    start(window)
    assert received[0].vna_address == "10.0.7.23"
    assert (received[0].x_points, received[0].start_frequency_hz) == (7, 700.5e6)


def test_the_tiles_show_todays_values(window):
    show(window, snapshot(SurveyState.IDLE))
    assert lines(window, Tile.AREA) == ("X 50 - 150", "Y 50 - 150")
    assert lines(window, Tile.SPACING) == ("25 mm", "5 x 5 points")
    assert lines(window, Tile.FREQUENCIES) == ("600 to 6000 MHz", "501 points")
    assert lines(window, Tile.VNA) == ("127.0.0.1", "as set")
    assert lines(window, Tile.SOIL) == ("Dry sand", "permittivity 4")
    assert lines(window, Tile.ANTENNAS) == ("0, 90°", "2 traces per stop")
    for name, value in (("if_bandwidth_hz", "1000"), ("averages", "4"), ("x_points", "11")):
        enter(window, name, value)
    assert lines(window, Tile.VNA) == ("127.0.0.1", "1000 Hz", "4 x")
    assert lines(window, Tile.SPACING) == ("10 x 25 mm", "11 x 5 points")


def test_a_touch_fills_in_an_area_or_a_spacing(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.tiles[Tile.AREA])
    click(window.values.presets[1])
    click(window.values.done)
    assert lines(window, Tile.AREA) == ("X 175 - 475", "Y 250 - 550")
    click(window.control.tiles[Tile.SPACING])
    click(window.values.presets[1])
    assert window.values.presets[1].isChecked()
    click(window.values.done)
    assert lines(window, Tile.SPACING) == ("10 mm", "31 x 31 points")


def test_undo_brings_back_what_there_was(window):
    show(window, snapshot(SurveyState.IDLE))
    open_field(window, "x_start_mm")
    press(window, "999")
    click(window.values.presets[0])
    click(window.values.undo)
    click(window.values.done)
    assert window.control.parameters == replace(default_parameters(), vna_address="127.0.0.1")


def test_arrows_change_a_field_by_the_chosen_step(window):
    show(window, snapshot(SurveyState.IDLE))
    name = "frequency_points"
    window.control.form.set_text(name, "40")
    open_field(window, name)
    press(window, [UP, UP])
    assert text(window, name) == "42"
    press(window, [STEP, UP, DOWN, DOWN])
    assert text(window, name) == "32"
    assert window.values.fields[name].text() == "32"
    click(window.values.done)
    open_field(window, name)
    press(window, [UP])
    assert text(window, name) == "42"  # the step is remembered
    open_field(window, "x_stop_mm")
    press(window, [STEP] + [UP] * 8)
    assert text(window, "x_stop_mm") == "650"
    press(window, [DOWN] * 8)
    assert text(window, "x_stop_mm") == "0"


def test_settings_of_the_vna_are_chosen_with_the_arrows_and_reach_the_survey(window):
    received = wishes(window)
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.tiles[Tile.VNA])
    fields = window.values.fields
    assert [fields[name].placeholderText() for name in ANALYZER_FIELDS] == ["as set"] * 3
    for choose in (lambda: press(window, [UP]), lambda: click(window.values.presets[0])):  # AS SET
        click(window.control.tiles[Tile.VNA])
        for name in ANALYZER_FIELDS:
            window.values.choose(name)
            choose()
        click(window.values.done)
        start(window)
    chosen, as_set = (one.sweep_settings.analyzer for one in received)
    assert chosen == AnalyzerSettings(10.0, 1, "LOW")
    assert not as_set.is_known


def test_what_is_wrong_is_named_in_sheet_tile_and_start_which_is_locked(window):
    received = wishes(window)
    show(window, snapshot(SurveyState.IDLE))
    for number, (name, wrong, words) in enumerate(
        (
            ("vna_address", "10.0.0.256", "four whole numbers"),
            ("stop_frequency_hz", "6GHz", "a number such as 12.5, from 0.005 to 6000"),
            ("x_points", "90000", "at least 0.01 mm apart"),
            (PERMITTIVITY, "100", "from 1 to 81"),
            ("polarizations_deg", "0, 91", "from -90 to 90"),
            ("output_power", "a b", "the MS2026C has LOW and HIGH"),
        )
    ):
        right = text(window, name)
        edit = open_field(window, name)
        assert window.values.hint.property("level") in ("", None)
        edit.clear()
        QTest.keyClicks(edit, wrong)
        assert words in window.values.hint.text()
        assert words in edit.toolTip() and edit.parent().property("wrong") is True
        click(window.values.done)
        tile = window.control.tiles[tile_of(name)]
        assert words in tile.problem.text() and tile.property("level") == "wrong"
        assert words in window.control.start.problem.text()
        start(window)
        assert len(received) == number
        enter(window, name, right)
        assert not tile.problem.isVisible() and not window.control.start.problem.isVisible()
        start(window)
        assert len(received) == number + 1


def test_nothing_is_red_before_something_was_written(window):
    show(window, snapshot(SurveyState.IDLE))
    for tile in VALUE_TILES:
        click(window.control.tiles[tile])
        for name in list(window.values.fields):
            window.values.choose(name)
            box = window.values.fields[name].parent()
            assert box.property("wrong") is not True, name
            press(window, [CLEAR])
            click(window.values.undo)
            assert box.property("wrong") is not True, name
        click(window.values.done)


def test_limits_that_become_known_are_applied_to_what_is_planned(window):
    enter(window, "x_stop_mm", "700")
    show(window, snapshot(SurveyState.IDLE, travel=None))
    assert window.control.start.isEnabled()
    show(window, snapshot(SurveyState.IDLE))
    assert not window.control.start.isEnabled()


def test_start_says_why_it_is_locked(window):
    idle = snapshot(SurveyState.IDLE)
    replay = ReplayView(ReplayMark(), True, SurveyState.SURVEYING)
    for shown, reason in (
        (replace(idle, control_alive=False), "No contact with the robot"),
        (snapshot(SurveyState.SURVEYING), "A survey is running"),
        (replace(idle, pending=frozenset([Request.START])), "The survey is starting"),
        (snapshot(replay=replay), "A replay is shown"),
    ):
        show(window, idle)
        assert window.control.start.isEnabled()
        show(window, shown)
        assert not window.control.start.isEnabled()
        assert window.control.start.problem.text() == reason


def test_a_replay_offers_no_notes(window):
    replayed = snapshot(SurveyState.SURVEYING)
    for replay in (ReplayView(ReplayMark(), True, SurveyState.SURVEYING), None):
        show(window, replace(replayed, replay=replay))
        assert window.control.tiles[Tile.NAME].isEnabled() is (replay is None)


def test_parameters_of_a_survey_that_was_started_elsewhere_are_shown(window):
    theirs = replace(default_parameters(), x_points=17, vna_address="10.1.2.3")
    show(window, snapshot(SurveyState.SURVEYING, survey_parameters=theirs))
    assert lines(window, Tile.SPACING)[1] == "17 x 5 points"
    assert window.control.parameters == theirs


def test_a_sheet_that_is_open_when_a_survey_begins_elsewhere_changes_nothing(window):
    show(window, snapshot(SurveyState.IDLE))
    open_field(window, "x_start_mm")
    show(window, snapshot(SurveyState.SURVEYING, survey_parameters=default_parameters()))
    assert not window.values.isVisible()
    assert window.control.parameters == default_parameters()


def test_what_the_survey_will_be_is_shown(window):
    window.survey.preview = preview(default_parameters(), 4.0)
    show(window, snapshot(SurveyState.IDLE))
    tile = window.control.figures
    assert tile.lines[0].whole == "50 traces"
    assert tile.lines[1].whole == "Spacing 25 mm > λ/4 11.4 mm"
    assert tile.property("level") == "doubtful"
    click(tile)
    sheet = window.control.figures
    assert sheet.figures[4:] == ("25, 25 mm", "11.4 mm", "6.94 m", "13.9 mm", "10.8 MHz", "2")
    assert "more than λ/4" in sheet.warning.text()
    window.survey.preview = replace(window.survey.preview, x_spacing_mm=10.0, y_spacing_mm=10.0)
    window.refresh()
    assert not sheet.warning.isVisible()
    assert tile.lines[1].whole == "Depth 6.94 m, resolution 13.9 mm"


def test_the_soil_reaches_the_preview(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.tiles[Tile.SOIL])
    click(window.values.presets[2])
    click(window.values.done)
    assert window.survey.plan[1] == 20.0
    assert lines(window, Tile.SOIL) == ("Wet sand", "permittivity 20")


def test_the_address_of_the_configuration_is_proposed_until_the_operator_chooses_another(window):
    configured = RobotDefaults("192.168.1.10", Site())
    show(window, snapshot(SurveyState.IDLE, defaults=None))
    assert lines(window, Tile.VNA)[0] == "no address"
    show(window, snapshot(SurveyState.IDLE, defaults=configured))
    assert lines(window, Tile.VNA)[0] == "192.168.1.10"
    enter(window, "vna_address", "10.0.0.7")
    show(window, snapshot(SurveyState.IDLE, defaults=RobotDefaults("192.168.1.11", Site())))
    assert text(window, "vna_address") == "10.0.0.7"


def test_an_address_of_another_form_in_the_configuration_is_shown_and_used(window):
    resource = "GPIB0::16::INSTR"
    show(window, snapshot(SurveyState.IDLE, defaults=RobotDefaults(resource, Site())))
    assert window.control.parameters.vna_address == resource
    edit = open_field(window, "vna_address")
    assert edit.text() == resource
    press(window, ["10.", "1", ".", "2", ".", "3"])
    click(window.values.done)
    assert window.control.parameters.vna_address == "10.1.2.3"


def test_what_the_keys_write_is_understood_and_what_follows_from_it_is_shown(window):
    show(window, snapshot(SurveyState.IDLE))
    edit = open_field(window, "x_stop_mm")
    press(window, ["6", "0", "0", ".", "1", "2", "3", "4", "5", ERASE])
    assert (edit.text(), text(window, "x_stop_mm")) == ("600.1234", "600.1234")
    click(window.values.done)
    assert lines(window, Tile.AREA)[0] == "X 50 - 600.12"
    assert window.control.parameters.x_stop_mm == 600.1234
    open_field(window, X_SPACING)
    press(window, "10")
    assert window.values.fields["x_points"].text() == "57"
    assert window.values.fields[Y_SPACING].text() == "25"


def test_a_tile_with_few_fields_opens_after_the_last_field_of_a_larger_one(window):
    sheet = window.values
    by_size = sorted(VALUE_TILES, key=lambda tile: len(TILE_FIELDS[tile]))
    sheet.show_tile(by_size[-1])
    sheet.choose(TILE_FIELDS[by_size[-1]][-1])
    sheet.finish()
    sheet.show_tile(by_size[0])
    assert list(sheet.fields) == list(TILE_FIELDS[by_size[0]])
