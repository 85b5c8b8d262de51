"""The plan in tiles, sheets and profiles; START and RESUME; how many touches a survey takes."""

import random
from dataclasses import replace

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QLabel
from view_kit import FOLDER, configured, past_survey, snapshot
from window_helpers import click, enter, hold, hold_to_start, open_field, show, start, wishes

from gpr20_common.message import verbatim
from gpr20_operator.ground.traces import SurveysListed
from gpr20_operator.plan.fields import TILE_FIELDS, VALUE_TILES, Tile, default_parameters
from gpr20_operator.plan.form import preview
from gpr20_operator.robot.events import Answer, Replay, Request
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.widgets.keys import ERASE


def lines(tile):
    return tuple(line.whole for line in tile.lines if line.whole)


def tile(window, which):
    return lines(window.control.tiles[which])


def press(window, keys):
    for key in keys:
        window.values.keys.press(key)


IDLE = snapshot(SurveyState.IDLE)


@pytest.fixture
def idle(window):
    show(window, IDLE)
    return window


def test_the_tiles_show_the_plan_of_a_new_robot_and_start_carries_what_was_entered(idle):
    assert {which: tile(idle, which) for which in VALUE_TILES} == {
        Tile.AREA: ("X 50 - 150 mm", "Y 50 - 150 mm"),
        Tile.SPACING: ("10 mm", "11 x 11 points"),
        Tile.FREQUENCIES: ("600 to 6000 MHz", "501 points"),
        Tile.VNA: ("127.0.0.1", "as set"),
        Tile.SOIL: ("Dry sand", "permittivity 4"),
        Tile.ANTENNAS: ("0, 90°", "2 traces per stop"),
    }
    for name, value in (("x_points", "6"), ("vna_address", "10.0.7.23")):
        enter(idle, name, value)
    assert tile(idle, Tile.SPACING) == ("20 x 10 mm", "6 x 11 points")
    click(idle.control.tiles[Tile.SOIL])
    click(idle.values.presets[2])
    click(idle.values.done)
    start(idle)
    (asked,) = wishes(idle)
    assert asked == idle.control.parameters
    assert (asked.vna_address, asked.x_points, idle.survey.plan[1]) == ("10.0.7.23", 6, 20.0)


def test_a_touch_fills_in_an_area_and_undo_brings_back_what_there_was(idle):
    values = idle.values
    click(idle.control.tiles[Tile.AREA])
    click(values.presets[1])
    click(values.done)
    assert tile(idle, Tile.AREA) == ("X 175 - 475 mm", "Y 250 - 550 mm")
    before = idle.control.parameters
    open_field(idle, "x_start_mm")
    press(idle, "999")
    click(values.presets[0])
    click(values.undo)
    click(values.done)
    assert idle.control.parameters == before


def test_what_is_wrong_is_named_in_sheet_and_tile_and_start_says_which_tile(idle):
    words = "at least 0.01 mm apart"
    field = open_field(idle, "x_points")
    QTest.keyClicks(idle.values, "90000")
    assert words in idle.values.hint.text() and field.property("level") == "wrong"
    click(idle.values.done)
    shown, locked = idle.control.tiles[Tile.SPACING], idle.control.start
    assert words in shown.sentence.text() and shown.property("level") == "wrong"
    assert locked.sentence.text() == f"Correct first: {shown.title.whole}"
    start(idle)
    assert wishes(idle) == []
    enter(idle, "x_points", "11")
    assert not shown.sentence.isVisible()
    start(idle)
    assert len(wishes(idle)) == 1


def test_start_says_why_it_is_locked_and_a_replay_offers_no_notes(window):
    replay = Replay(state=SurveyState.SURVEYING)
    control = window.control
    for shown, reason in (
        (IDLE, ""),
        (replace(IDLE, control_alive=False), "No contact with the robot"),
        (snapshot(SurveyState.SURVEYING), "A survey is running"),
        (replace(IDLE, pending=frozenset([Request.START])), "The survey is starting"),
        (snapshot(replay=replay), "A replay is shown"),
    ):
        show(window, shown)
        assert control.start.isEnabled() is (shown is IDLE)
        assert control.start.sentence.text() == reason
    assert not control.tiles[Tile.NAME].isEnabled()


def test_a_survey_that_begins_elsewhere_closes_what_is_open_and_shows_its_parameters(idle):
    theirs = replace(default_parameters(), x_points=17, vna_address="10.1.2.3")
    open_field(idle, "x_start_mm")
    click(idle.profiles.save)
    show(idle, snapshot(SurveyState.SURVEYING, job_parameters=theirs))
    for sheet in (idle.values, idle.profiles, idle.profiles.pad):
        assert not sheet.isVisible()
    assert tile(idle, Tile.SPACING)[1] == "17 x 11 points"
    assert idle.control.parameters == theirs
    assert not idle.control.saved.isEnabled()


def test_what_the_survey_will_be_is_shown_and_what_is_too_coarse_is_amber(window):
    known, control = preview(default_parameters(), 4.0), window.control
    for spacing_mm, shown, doubt in ((10.0, "11 x 11 points", False), (25.0, "at most", True)):
        window.survey.preview = replace(known, x_spacing_mm=spacing_mm, y_spacing_mm=spacing_mm)
        show(window, IDLE)
        assert lines(control.start) == ("242 traces",)
        assert shown in tile(window, Tile.SPACING)[1]
        assert (control.tiles[Tile.SPACING].property("level") == "doubtful") is doubt
        click(control.check_plan)
        assert control.summary.isVisible() and not control.summary.hold.isVisible()
        assert control.summary.doubt.isVisible() is doubt
        click(control.summary.cancel)


def test_the_address_of_the_configuration_is_proposed_until_the_operator_chooses_another(window):
    other_form = "GPIB0::16::INSTR"
    for address in ("192.168.1.10", other_form):
        show(window, snapshot(SurveyState.IDLE, robot=configured(address)))
        assert tile(window, Tile.VNA)[0] == window.control.parameters.vna_address == address
    enter(window, "vna_address", "10.1.2.3")
    show(window, snapshot(SurveyState.IDLE, robot=configured("192.168.1.11")))
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


def test_a_survey_that_ended_early_is_resumed_by_a_hold_and_start_comes_second(window):
    show(window, IDLE)
    listed = past_survey(name="El Carmen 2", stored_traces=1234, planned_traces=4489)
    window.on_event(SurveysListed("", (listed,), False))
    for now in (snapshot(SurveyState.IDLE, alive=False), snapshot(SurveyState.SURVEYING)):
        show(window, now)
        assert not window.control.resume.isVisible()
    show(window, IDLE)
    control = window.control
    assert lines(control.resume) == ("El Carmen 2", "1234 of 4489 stored")
    assert control.resume.width() > control.start.width()
    assert control.start.isEnabled() and control.start.property("level") == "second"
    click(control.resume)
    assert wishes(window) == []
    hold(window.start_sheet.hold)
    start(window)
    assert wishes(window) == [f"resume {FOLDER}", control.parameters]


def names(idle):
    return [idle.profiles.names.item(row).text() for row in range(idle.profiles.names.count())]


def test_a_profile_is_saved_loaded_and_deleted_by_a_hold(idle):
    profiles, confirm = idle.profiles, idle.profiles.confirm
    enter(idle, "x_points", "9")
    click(idle.control.saved)
    click(profiles.save)
    profiles.pad.press("a")
    click(profiles.pad.accept_button)
    enter(idle, "x_points", "4")
    profiles.names.setCurrentRow(0)
    click(profiles.load)
    assert not profiles.isVisible() and idle.control.parameters.x_points == 9
    click(idle.control.saved)
    profiles.names.setCurrentRow(0)
    click(profiles.delete)
    assert "a" in [label.text() for label in confirm.findChildren(QLabel)]
    hold(confirm.hold, 0.9)
    click(confirm.hold)
    assert names(idle) == ["a"]
    hold(confirm.hold)
    assert names(idle) == []
    assert not confirm.isVisible() and profiles.isVisible()


FROM_MEMORY, FROM_FACTORY = 10, 20
PREFIXES = ("192.168.", "10.", "172.")


class Finger:
    """Touches what is seen, and counts."""

    def __init__(self):
        self.touches = 0

    def touch(self, widget):
        assert widget.isVisible() and widget.isEnabled()
        self.touches += 1
        QTest.mouseClick(widget, Qt.LeftButton)

    def start(self, window):
        """START opens a summary; holding its button begins the survey."""
        self.touch(window.control.start)
        self.touches += 1
        hold_to_start(window)


def begun(window):
    window.control.begin()
    show(window, snapshot(SurveyState.IDLE, robot=configured("")))
    return window


def plan(window, finger, address):
    """Enter an address and an area of 300 x 300 mm with a finger."""
    control, values = window.control, window.values
    finger.touch(control.tiles[Tile.VNA])
    prefix = next((one for one in PREFIXES if address.startswith(one)), "")
    for key in [*([prefix] if prefix else []), *address[len(prefix) :]]:
        finger.touch(next(one for one in values.keys.keys if one.property("character") == key))
    finger.touch(values.done)
    finger.touch(control.tiles[Tile.AREA])
    finger.touch(values.presets[1])
    finger.touch(values.done)
    finger.start(window)


def test_an_address_and_an_area_from_factory_values(opened):
    draw = random.Random(1)
    networks = (["192", "168"], ["10"], ["172", str(draw.randint(16, 31))])
    for network in networks:
        last = [str(draw.randint(0, 255)) for _ in range(4 - len(network))]
        address = ".".join(network + last)
        window, finger = begun(opened()), Finger()
        plan(window, finger, address)
        (started,) = window.survey.asked
        assert started.vna_address == address
        assert (started.x_start_mm, started.x_stop_mm) == (175.0, 475.0)
        assert (started.y_start_mm, started.y_stop_mm) == (250.0, 550.0)
        assert finger.touches <= FROM_FACTORY, address


def test_what_was_measured_last_takes_fewer_touches_as_it_was_or_with_changes(opened):
    window, finger = begun(opened()), Finger()
    plan(window, finger, "192.168.1.10")
    before = window.survey.asked[0]
    window.on_event(Answer(Request.START, True, verbatim("Survey started"), "id"))
    window.control.form.set_text("x_stop_mm", "200")
    window.refresh()
    assert window.plans.wait(30.0)
    # The plan that is not finished, and the last area.
    window, finger = begun(opened()), Finger()
    finger.touch(window.control.tiles[Tile.AREA])
    finger.touch(window.values.presets[3])
    finger.touch(window.values.done)
    finger.start(window)
    assert window.survey.asked == [before] and finger.touches <= FROM_MEMORY
    for tile, preset in ((Tile.SPACING, 1), (Tile.SOIL, 1)):
        finger.touch(window.control.tiles[tile])
        finger.touch(window.values.presets[preset])
        finger.touch(window.values.done)
    finger.start(window)
    assert window.survey.asked[1].x_points == 31
    assert finger.touches <= 2 * FROM_MEMORY
