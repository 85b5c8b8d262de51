"""The plan in tiles, the sheets of the tiles, START and RESUME, and why START is locked."""

from dataclasses import replace

from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
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
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_user_interface.widgets.keys import CLEAR, DOWN, ERASE, STEP, UP


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
    assert tile(window, Tile.AREA) == ("X 50 - 150 mm", "Y 50 - 150 mm")
    assert tile(window, Tile.SPACING) == ("10 mm", "11 x 11 points")
    assert tile(window, Tile.FREQUENCIES) == ("600 to 6000 MHz", "501 points")
    assert tile(window, Tile.VNA) == ("127.0.0.1", "as set")
    assert tile(window, Tile.SOIL) == ("Dry sand", "permittivity 4")
    assert tile(window, Tile.ANTENNAS) == ("0, 90°", "2 traces per stop")
    for name, value in (("if_bandwidth_hz", "1000"), ("averages", "4"), ("x_points", "6")):
        enter(window, name, value)
    assert tile(window, Tile.VNA) == ("127.0.0.1", "1 kHz, 4 x")
    assert tile(window, Tile.SPACING) == ("20 x 10 mm", "6 x 11 points")


def test_a_touch_fills_in_an_area_or_a_spacing(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.tiles[Tile.AREA])
    click(window.values.presets[1])
    click(window.values.done)
    assert tile(window, Tile.AREA) == ("X 175 - 475 mm", "Y 250 - 550 mm")
    click(window.control.tiles[Tile.SPACING])
    click(window.values.presets[1])
    assert window.values.presets[1].isChecked()
    click(window.values.done)
    assert tile(window, Tile.SPACING) == ("10 mm", "31 x 31 points")


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
    field = open_field(window, name)
    press(window, [UP, UP])
    assert text(window, name) == "42"
    press(window, [STEP, UP, DOWN, DOWN])
    assert text(window, name) == field.lines[0].whole == "32"
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
    for choose in (lambda: press(window, [UP]), lambda: click(window.values.presets[0])):  # AS SET
        click(window.control.tiles[Tile.VNA])
        for name in TILE_FIELDS[Tile.VNA][1:]:
            window.values.choose(name)
            choose()
        click(window.values.done)
        start(window)
    assert [lines(field) for field in window.values.fields[1:]] == [("as set on the VNA",)] * 3
    chosen, as_set = (one.sweep_settings.analyzer for one in received)
    assert chosen == AnalyzerSettings(10.0, 1, "LOW")
    assert not as_set.is_known


def test_what_is_wrong_is_named_in_sheet_and_tile_and_start_says_which_tile(window):
    received = wishes(window)
    show(window, snapshot(SurveyState.IDLE))
    for number, (name, wrong, words) in enumerate(
        (
            ("vna_address", "10.0.0.256", "four whole numbers"),
            ("stop_frequency_hz", "6GHz", "a number such as 12.5, from 0.005 to 6000"),
            ("x_points", "90000", "at least 0.01 mm apart"),
            ("permittivity", "100", "from 1 to 81"),
            ("polarizations_deg", "0, 91", "from -90 to 90"),
            ("output_power", "a b", "LOW or HIGH for the MS2026C"),
        )
    ):
        right = text(window, name)
        field = open_field(window, name)
        assert window.values.hint.property("level") in ("", None)
        QTest.keyClicks(window.values, wrong)
        assert words in window.values.hint.text()
        assert field.property("level") == "wrong"
        click(window.values.done)
        shown = window.control.tiles[tile_of(name)]
        assert words in shown.sentence.text() and shown.property("level") == "wrong"
        assert window.control.start.sentence.text() == f"Correct first: {shown.title.whole}"
        start(window)
        assert len(received) == number
        enter(window, name, right)
        assert not shown.sentence.isVisible() and not window.control.start.sentence.isVisible()
        start(window)
        assert len(received) == number + 1


def test_nothing_is_red_before_something_was_written(window):
    show(window, snapshot(SurveyState.IDLE))
    for which in VALUE_TILES:
        click(window.control.tiles[which])
        for number, name in enumerate(TILE_FIELDS[which]):
            window.values.choose(name)
            field = window.values.fields[number]
            assert field.property("level") == "chosen", name
            press(window, [CLEAR])
            click(window.values.undo)
            assert field.property("level") == "chosen", name
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
        assert window.control.start.sentence.text() == reason


def test_a_replay_offers_no_notes(window):
    replayed = snapshot(SurveyState.SURVEYING)
    for replay in (ReplayView(ReplayMark(), True, SurveyState.SURVEYING), None):
        show(window, replace(replayed, replay=replay))
        assert window.control.tiles[Tile.NAME].isEnabled() is (replay is None)


def test_parameters_of_a_survey_that_was_started_elsewhere_are_shown(window):
    theirs = replace(default_parameters(), x_points=17, vna_address="10.1.2.3")
    show(window, snapshot(SurveyState.SURVEYING, survey_parameters=theirs))
    assert tile(window, Tile.SPACING)[1] == "17 x 11 points"
    assert window.control.parameters == theirs


def test_a_sheet_that_is_open_when_a_survey_begins_elsewhere_changes_nothing(window):
    show(window, snapshot(SurveyState.IDLE))
    open_field(window, "x_start_mm")
    show(window, snapshot(SurveyState.SURVEYING, survey_parameters=default_parameters()))
    assert not window.values.isVisible()
    assert window.control.parameters == default_parameters()


def test_what_the_survey_will_be_is_shown_and_what_is_too_coarse_is_amber(window):
    window.survey.preview = preview(default_parameters(), 4.0)
    show(window, snapshot(SurveyState.IDLE))
    control = window.control
    assert lines(control.start) == ("242 traces",)
    assert lines(control.check_plan) == ("resolution 13.9 mm",)
    click(control.check_plan)
    assert control.summary.isVisible() and not control.summary.hold.isVisible()
    assert not control.summary.doubt.isVisible()
    click(control.summary.cancel)
    window.survey.preview = replace(window.survey.preview, x_spacing_mm=25.0, y_spacing_mm=25.0)
    show(window, snapshot(SurveyState.IDLE))
    assert tile(window, Tile.SPACING) == ("10 mm", "at most 11.4 mm")
    assert control.tiles[Tile.SPACING].property("level") == "doubtful"
    click(control.check_plan)
    assert "targets can be missed" in control.summary.doubt.text()


def test_the_soil_reaches_the_preview_and_the_start(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.tiles[Tile.SOIL])
    click(window.values.presets[2])
    click(window.values.done)
    assert window.survey.plan[1] == 20.0
    assert tile(window, Tile.SOIL) == ("Wet sand", "permittivity 20")
    click(window.control.start)
    assert "Wet sand, permittivity 20" in [
        str(value) for _, value in window.start_sheet.question.rows
    ]


def test_the_address_of_the_configuration_is_proposed_until_the_operator_chooses_another(window):
    configured = RobotDefaults("192.168.1.10", Site())
    show(window, snapshot(SurveyState.IDLE, defaults=None))
    assert tile(window, Tile.VNA)[0] == "no address"
    show(window, snapshot(SurveyState.IDLE, defaults=configured))
    assert tile(window, Tile.VNA)[0] == "192.168.1.10"
    enter(window, "vna_address", "10.0.0.7")
    show(window, snapshot(SurveyState.IDLE, defaults=RobotDefaults("192.168.1.11", Site())))
    assert text(window, "vna_address") == "10.0.0.7"


def test_an_address_of_another_form_in_the_configuration_is_shown_and_used(window):
    resource = "GPIB0::16::INSTR"
    show(window, snapshot(SurveyState.IDLE, defaults=RobotDefaults(resource, Site())))
    assert window.control.parameters.vna_address == resource
    assert lines(open_field(window, "vna_address")) == (resource,)
    press(window, ["10.", "1", ".", "2", ".", "3"])
    click(window.values.done)
    assert window.control.parameters.vna_address == "10.1.2.3"


def test_what_the_keys_write_is_understood_and_what_follows_from_it_is_shown(window):
    show(window, snapshot(SurveyState.IDLE))
    field = open_field(window, "x_stop_mm")
    press(window, ["6", "0", "0", ".", "1", "2", "3", "4", "5", ERASE])
    assert lines(field) == ("600.1234|",)
    click(window.values.done)
    assert tile(window, Tile.AREA)[0] == "X 50 - 600.12 mm"
    assert window.control.parameters.x_stop_mm == 600.1234
    open_field(window, "x_spacing_mm")
    press(window, "20")
    shown = dict(zip(TILE_FIELDS[Tile.SPACING], map(lines, window.values.fields)))
    assert (shown["x_points"], shown["y_spacing_mm"]) == (("29",), ("10",))


def test_a_real_keyboard_writes_erases_and_ends(window):
    show(window, snapshot(SurveyState.IDLE))
    open_field(window, "x_stop_mm")
    QTest.keyClicks(window.values, "3005")
    QTest.keyClick(window.values, Qt.Key_Backspace)
    QTest.keyClick(window.values, Qt.Key_Return)
    assert not window.values.isVisible()
    assert window.control.parameters.x_stop_mm == 300.0


def ended_early(window, **changes):
    """Show a robot at rest whose last survey ended early."""
    show(window, snapshot(SurveyState.IDLE))
    listed = past_survey(name="El Carmen 2", stored_traces=1234, planned_traces=4489, **changes)
    window.on_event(SurveysListed("", (listed,), False))
    show(window, snapshot(SurveyState.IDLE))
    return window.control


def test_the_list_of_surveys_is_asked_for_once_the_robot_is_there(window, storage):
    assert ("list", "") not in storage.asked
    for _ in range(3):
        show(window, snapshot(SurveyState.IDLE))
    assert storage.asked.count(("list", "")) == 1
    window.on_event(SurveysListed("", (), False))
    for _ in range(100):
        show(window, snapshot(SurveyState.IDLE))
    assert storage.asked.count(("list", "")) == 1


def test_a_survey_that_ended_early_is_resumed_by_a_hold_and_start_comes_second(window):
    control = ended_early(window)
    assert lines(control.resume) == ("El Carmen 2", "1234 of 4489 stored")
    assert control.resume.width() > control.start.width()
    assert control.start.isEnabled() and control.start.property("level") == "second"
    click(control.resume)
    assert wishes(window) == []
    hold(window.start_sheet.hold)
    assert wishes(window) == [f"resume {FOLDER}"]


def test_start_stays_possible_after_a_survey_that_ended_early(window):
    ended_early(window)
    start(window)
    assert [type(one).__name__ for one in wishes(window)] == ["SurveyParameters"]


def test_nothing_is_offered_to_resume_after_a_complete_survey_or_without_a_robot(window):
    assert not ended_early(window, complete=True).resume.isVisible()
    control = ended_early(window)
    assert control.resume.isVisible()
    show(window, snapshot(SurveyState.IDLE, alive=False))
    assert not control.resume.isVisible()
    show(window, snapshot(state=state_of(SurveyState.SURVEYING)))
    assert not control.resume.isVisible()


def test_a_tile_with_few_fields_opens_after_the_last_field_of_a_larger_one(window):
    sheet = window.values
    by_size = sorted(VALUE_TILES, key=lambda one: len(TILE_FIELDS[one]))
    sheet.show_tile(by_size[-1])
    sheet.choose(TILE_FIELDS[by_size[-1]][-1])
    sheet.finish()
    sheet.show_tile(by_size[0])
    assert sum(field.isVisible() for field in sheet.fields) == len(TILE_FIELDS[by_size[0]])
