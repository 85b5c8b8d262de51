"""The plan in tiles, their sheets and the profiles, START and RESUME, why START is locked."""

from dataclasses import replace

import pytest
from finger import place_of
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QLabel
from view_kit import FOLDER, past_survey, snapshot, state_of
from window_helpers import click, enter, hold, open_field, show, start, tile_of, wishes

from gpr20_operator.ground.trace_events import SurveysListed
from gpr20_operator.plan.fields import TILE_FIELDS, VALUE_TILES, default_parameters
from gpr20_operator.plan.preview import preview
from gpr20_operator.plan.spec import Tile
from gpr20_operator.robot.events import Request, RobotDefaults
from gpr20_operator.robot.replay import ReplayMark, ReplayView
from gpr20_survey.plan.site import Site
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.widgets.keys import ERASE


def text(window, name):
    return window.control.form.texts[name]


def lines(tile):
    return tuple(line.whole for line in tile.lines if line.whole)


def tile(window, which):
    return lines(window.control.tiles[which])


def press(window, keys):
    """Touch keys of the open sheet, one after the other."""
    for key in keys:
        window.values.keys.press(key)


IDLE = snapshot(SurveyState.IDLE)


@pytest.fixture
def idle(window):
    show(window, IDLE)
    return window


def test_the_tiles_show_the_plan_of_a_new_robot_and_start_carries_what_was_entered(idle):
    control = idle.control
    assert {which: tile(idle, which) for which in VALUE_TILES} == {
        Tile.AREA: ("X 50 - 150 mm", "Y 50 - 150 mm"),
        Tile.SPACING: ("10 mm", "11 x 11 points"),
        Tile.FREQUENCIES: ("600 to 6000 MHz", "501 points"),
        Tile.VNA: ("127.0.0.1", "as set"),
        Tile.SOIL: ("Dry sand", "permittivity 4"),
        Tile.ANTENNAS: ("0, 90°", "2 traces per stop"),
    }
    for name, value in (
        *(("if_bandwidth_hz", "1000"), ("averages", "4"), ("x_points", "6")),
        *(("start_frequency_hz", "700,5"), ("vna_address", "10.0.7.23")),
    ):
        enter(idle, name, value)
    assert tile(idle, Tile.VNA) == ("10.0.7.23", "1 kHz, 4 x")
    assert tile(idle, Tile.SPACING) == ("20 x 10 mm", "6 x 11 points")
    start(idle)
    (asked,) = wishes(idle)
    assert asked == control.parameters
    assert (asked.vna_address, asked.x_points) == ("10.0.7.23", 6)
    assert asked.start_frequency_hz == 700.5e6


def test_a_touch_fills_in_an_area_or_a_spacing_and_undo_brings_back_what_there_was(idle):
    values = idle.values
    for which, shown in (
        (Tile.AREA, ("X 175 - 475 mm", "Y 250 - 550 mm")),
        (Tile.SPACING, ("10 mm", "31 x 31 points")),
    ):
        click(idle.control.tiles[which])
        click(values.presets[1])
        click(values.done)
        assert tile(idle, which) == shown
    before = idle.control.parameters
    open_field(idle, "x_start_mm")
    press(idle, "999")
    click(values.presets[0])
    click(values.undo)
    click(values.done)
    assert idle.control.parameters == before


def test_what_is_wrong_is_named_in_sheet_and_tile_and_start_says_which_tile(idle):
    for number, (name, wrong, words) in enumerate(
        (
            ("stop_frequency_hz", "6GHz", "a number such as 12.5, from 0.005 to 6000"),
            ("x_points", "90000", "at least 0.01 mm apart"),
        )
    ):
        right = text(idle, name)
        field = open_field(idle, name)
        assert idle.values.hint.property("level") in ("", None)
        QTest.keyClicks(idle.values, wrong)
        assert words in idle.values.hint.text()
        assert field.property("level") == "wrong"
        click(idle.values.done)
        shown, locked = idle.control.tiles[tile_of(name)], idle.control.start
        assert words in shown.sentence.text() and shown.property("level") == "wrong"
        assert locked.sentence.text() == f"Correct first: {shown.title.whole}"
        start(idle)
        assert len(wishes(idle)) == number
        enter(idle, name, right)
        assert not shown.sentence.isVisible() and not locked.sentence.isVisible()
        start(idle)
        assert len(wishes(idle)) == number + 1


def test_start_says_why_it_is_locked_and_a_replay_offers_no_notes(window):
    replay = ReplayView(ReplayMark(), True, SurveyState.SURVEYING)
    for shown, reason in (
        (replace(IDLE, control_alive=False), "No contact with the robot"),
        (snapshot(SurveyState.SURVEYING), "A survey is running"),
        (replace(IDLE, pending=frozenset([Request.START])), "The survey is starting"),
        (snapshot(replay=replay), "A replay is shown"),
    ):
        show(window, IDLE)
        control = window.control
        assert control.start.isEnabled() and control.tiles[Tile.NAME].isEnabled()
        show(window, shown)
        assert not control.start.isEnabled()
        assert control.start.sentence.text() == reason
    assert not window.control.tiles[Tile.NAME].isEnabled()


def test_a_survey_that_begins_elsewhere_closes_what_is_open_and_shows_its_parameters(idle):
    theirs = replace(default_parameters(), x_points=17, vna_address="10.1.2.3")
    open_field(idle, "x_start_mm")
    show(idle, snapshot(SurveyState.SURVEYING, survey_parameters=theirs))
    assert not idle.values.isVisible()
    assert tile(idle, Tile.SPACING)[1] == "17 x 11 points"
    assert idle.control.parameters == theirs
    show(idle, IDLE)
    click(idle.control.saved)
    click(idle.profiles.save)
    show(idle, snapshot(SurveyState.CHECKING))
    assert not idle.profiles.isVisible() and not idle.profiles.pad.isVisible()
    assert not idle.control.saved.isEnabled()


def test_what_the_survey_will_be_is_shown_and_what_is_too_coarse_is_amber(window):
    window.survey.preview = preview(default_parameters(), 4.0)
    show(window, IDLE)
    control = window.control
    assert lines(control.start) == ("242 traces",)
    assert lines(control.check_plan) == ("resolution 13.9 mm",)
    click(control.check_plan)
    assert control.summary.isVisible() and not control.summary.hold.isVisible()
    assert not control.summary.doubt.isVisible()
    click(control.summary.cancel)
    window.survey.preview = replace(window.survey.preview, x_spacing_mm=25.0, y_spacing_mm=25.0)
    show(window, IDLE)
    assert tile(window, Tile.SPACING) == ("10 mm", "at most 11.4 mm")
    assert control.tiles[Tile.SPACING].property("level") == "doubtful"
    click(control.check_plan)
    assert "targets can be missed" in control.summary.doubt.text()


def test_the_soil_reaches_the_preview_and_the_start(idle):
    click(idle.control.tiles[Tile.SOIL])
    click(idle.values.presets[2])
    click(idle.values.done)
    assert idle.survey.plan[1] == 20.0
    assert tile(idle, Tile.SOIL) == ("Wet sand", "permittivity 20")
    click(idle.control.start)
    rows = [str(value) for _, value in idle.start_sheet.question.rows]
    assert "Wet sand, permittivity 20" in rows


def test_the_address_of_the_configuration_is_proposed_until_the_operator_chooses_another(window):
    for configured, shown in (
        *((None, "no address"), ("192.168.1.10", "192.168.1.10")),
        ("GPIB0::16::INSTR", "GPIB0::16::INSTR"),  # of another form
    ):
        defaults = None if configured is None else RobotDefaults(configured, Site())
        show(window, snapshot(SurveyState.IDLE, defaults=defaults))
        assert tile(window, Tile.VNA)[0] == shown
    assert window.control.parameters.vna_address == "GPIB0::16::INSTR"
    open_field(window, "vna_address")
    press(window, ["10.", "1", ".", "2", ".", "3"])
    click(window.values.done)
    show(window, snapshot(SurveyState.IDLE, defaults=RobotDefaults("192.168.1.11", Site())))
    assert window.control.parameters.vna_address == "10.1.2.3"


def test_what_the_keys_write_is_understood_and_what_follows_from_it_is_shown(idle):
    field = open_field(idle, "x_stop_mm")
    press(idle, ["6", "0", "0", ".", "1", "2", "3", "4", "5", ERASE])
    assert lines(field) == ("600.1234|",)
    click(idle.values.done)
    assert tile(idle, Tile.AREA)[0] == "X 50 - 600.12 mm"
    assert idle.control.parameters.x_stop_mm == 600.1234
    open_field(idle, "x_spacing_mm")
    press(idle, "20")
    shown = dict(zip(TILE_FIELDS[Tile.SPACING], map(lines, idle.values.fields)))
    assert (shown["x_points"], shown["y_spacing_mm"]) == (("29",), ("10",))
    click(idle.values.done)
    # A real keyboard.
    open_field(idle, "x_stop_mm")
    QTest.keyClicks(idle.values, "3005")
    QTest.keyClick(idle.values, Qt.Key_Backspace)
    QTest.keyClick(idle.values, Qt.Key_Return)
    assert not idle.values.isVisible()
    assert idle.control.parameters.x_stop_mm == 300.0


def ended_early(window, **changes):
    """Show a robot at rest whose last survey ended early."""
    show(window, IDLE)
    listed = past_survey(name="El Carmen 2", stored_traces=1234, planned_traces=4489, **changes)
    window.on_event(SurveysListed("", (listed,), False))
    show(window, IDLE)
    return window.control


def test_a_survey_that_ended_early_is_resumed_by_a_hold_and_start_comes_second(window):
    control = ended_early(window)
    assert lines(control.resume) == ("El Carmen 2", "1234 of 4489 stored")
    assert control.resume.width() > control.start.width()
    assert control.start.isEnabled() and control.start.property("level") == "second"
    click(control.resume)
    assert wishes(window) == []
    hold(window.start_sheet.hold)
    start(window)
    resumed, started = wishes(window)
    assert resumed == f"resume {FOLDER}" and started == window.control.parameters


def test_nothing_is_offered_to_resume_after_a_complete_survey_or_without_a_robot(window):
    assert not ended_early(window, complete=True).resume.isVisible()
    control = ended_early(window)
    assert control.resume.isVisible()
    show(window, snapshot(SurveyState.IDLE, alive=False))
    assert not control.resume.isVisible()
    show(window, snapshot(state=state_of(SurveyState.SURVEYING)))
    assert not control.resume.isVisible()


def save(idle, name):
    click(idle.control.saved)
    click(idle.profiles.save)
    for character in name:
        idle.profiles.pad.press(character)
    click(idle.profiles.pad.accept_button)


def names(idle):
    return [idle.profiles.names.item(row).text() for row in range(idle.profiles.names.count())]


def test_fields_are_saved_and_loaded_with_fingers_alone(idle):
    enter(idle, "x_points", "9")
    save(idle, "field-1")
    assert names(idle) == ["field-1"]
    enter(idle, "x_points", "4")
    idle.profiles.names.setCurrentRow(0)
    click(idle.profiles.load)
    assert not idle.profiles.isVisible()
    assert idle.control.parameters.x_points == 9


def test_deleting_is_asked_elsewhere_and_takes_a_hold(idle):
    save(idle, "a")
    idle.profiles.names.setCurrentRow(0)
    click(idle.profiles.delete)
    confirm = idle.profiles.confirm
    assert confirm.isVisible()
    assert "a" in [label.text() for label in confirm.findChildren(QLabel)]
    places = [place_of(idle, button) for button in (confirm.hold, idle.profiles.delete)]
    assert not places[0].intersects(places[1])
    hold(confirm.hold, 0.9)
    click(confirm.hold)
    click(confirm.cancel)
    click(idle.profiles.delete)
    assert names(idle) == ["a"]
    hold(confirm.hold)
    assert names(idle) == []
    assert not confirm.isVisible() and idle.profiles.isVisible()
