"""The plan in tiles and sheets; START and RESUME; how many touches a survey takes."""

from dataclasses import replace

import pytest
from candidate_examples import candidate, candidate_list
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from result_kit import BLUE, image_of, plug_in, stored
from view_kit import FOLDER, SURVEY, configured, past_survey, snapshot, state_of
from window_helpers import (
    click,
    hold,
    hold_to_start,
    open_field,
    show,
    start,
    take_list,
    wishes,
)

from gpr20_common.message import verbatim
from gpr20_operator.plan.fields import Tile, default_parameters
from gpr20_operator.robot.events import Answer, Replay, Request
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import Mark
from gpr20_user_interface.widgets.bars import TabName


def lines(tile):
    return tuple(line.text() for line in tile.lines if line.text())


def enter(window, name, text):
    open_field(window, name)
    QTest.keyClick(window.values, Qt.Key_Delete)
    QTest.keyClicks(window.values, text)
    click(window.values.done)


IDLE = snapshot(SurveyState.IDLE)


@pytest.fixture
def idle(window):
    show(window, IDLE)
    return window


def test_the_tiles_show_the_plan_and_start_carries_what_was_entered(idle):
    tiles = idle.control.tiles
    assert lines(tiles[Tile.AREA]) == ("X 50 - 200 mm", "Y 50 - 200 mm")
    assert lines(tiles[Tile.SOIL]) == ("Dry sand", "permittivity 4")
    for name, value in (("x_spacing_mm", "20"), ("vna_address", "10.0.7.23")):
        enter(idle, name, value)
    assert lines(tiles[Tile.SPACING]) == ("20 x 10 mm", "9 x 16 points")
    click(tiles[Tile.SOIL])
    click(idle.values.presets[2])
    click(idle.values.done)
    start(idle)
    (asked,) = wishes(idle)
    assert asked == idle.control.parameters
    assert (asked.vna_address, asked.x_points, idle.survey.plan[1]) == ("10.0.7.23", 9, 20.0)


def test_what_is_wrong_is_named_in_sheet_and_tile_and_start_says_which_tile(idle):
    words = "above 0"
    field = open_field(idle, "x_spacing_mm")
    QTest.keyClicks(idle.values, "0")
    assert words in idle.values.hint.text() and field.property("level") == "wrong"
    click(idle.values.done)
    shown, locked = idle.control.tiles[Tile.SPACING], idle.control.start
    assert words in shown.sentence.text() and shown.property("level") == "wrong"
    assert locked.sentence.text() == f"Correct first: {shown.title.text()}"
    start(idle)
    assert wishes(idle) == []
    enter(idle, "x_spacing_mm", "10")
    assert not shown.sentence.isVisible()
    start(idle)
    assert len(wishes(idle)) == 1


def test_start_says_why_it_is_locked_and_a_replay_offers_no_notes(window):
    control = window.control
    for shown, reason in (
        (IDLE, ""),
        (replace(IDLE, control_alive=False), "No contact with the robot"),
        (snapshot(SurveyState.SURVEYING), "A survey is running"),
        (replace(IDLE, pending=frozenset([Request.START])), "The survey is starting"),
        (snapshot(SurveyState.SURVEYING, replay=Replay()), "A replay is shown"),
    ):
        show(window, shown)
        assert control.start.isEnabled() is (shown is IDLE)
        assert control.start.sentence.text() == reason
    assert not control.tiles[Tile.NAME].isEnabled()


def test_a_survey_that_begins_elsewhere_closes_what_is_open_and_shows_its_parameters(idle):
    theirs = replace(default_parameters(), x_points=17, vna_address="10.1.2.3")
    open_field(idle, "x_start_mm")
    show(idle, snapshot(SurveyState.SURVEYING, job_parameters=theirs))
    assert not idle.values.isVisible()
    assert lines(idle.control.tiles[Tile.SPACING])[1] == "17 x 16 points"
    assert idle.control.parameters == theirs
    # An address equal to the configured one follows the configuration.
    own = replace(theirs, vna_address="192.168.1.10")
    robot = configured(own.vna_address)
    show(idle, snapshot(SurveyState.SURVEYING, job_parameters=own, robot=robot))
    assert idle.control.parameters == replace(theirs, vna_address="")


def test_the_area_is_drawn_within_the_reach_of_the_robot_with_y_upwards(idle):
    reach, dark = idle.control.reach, idle.look.colour(Mark.STOP_DONE)
    idle.control.form.set_texts({"x_start_mm": "0", "x_stop_mm": "650"})
    for y_stop in ("150", "800"):
        idle.control.form.set_text("y_stop_mm", y_stop)
        idle.control.show_plan()
        picture, x = reach.grab().toImage(), round(reach.to_screen(300.0, 0.0).x())
        inked = [y for y in range(reach.height()) if picture.pixelColor(x, y).name() == dark]
        ends = [reach.to_screen(0.0, float(one)).y() for one in (y_stop, "50")]
        assert [inked[0], inked[-1]] == pytest.approx(ends, abs=2.0)


def test_a_survey_that_ended_early_is_resumed_by_a_hold_and_start_comes_second(window):
    show(window, IDLE)
    listed = past_survey(name="El Carmen 2", stored_traces=1234, planned_traces=4489)
    take_list(window, (listed,))
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


class Walk:
    """Touches what is seen in a window just opened, and counts."""

    def __init__(self, opened, **parts):
        self.touches, self.window = 0, opened(**parts)
        self.window.control.begin()
        show(self.window, snapshot(SurveyState.IDLE, robot=configured("")))

    def touch(self, *widgets):
        for widget in widgets:
            assert widget.isVisible() and widget.isEnabled()
            self.touches += 1
            click(widget)

    def start(self):
        """START opens a summary; holding its button begins the survey."""
        self.touch(self.window.control.start)
        self.touches += 1
        hold_to_start(self.window)
        return self.window.survey.asked


def test_a_survey_takes_two_touches_and_with_another_area_five_and_is_remembered(opened):
    walk = Walk(opened)
    assert walk.start() == [default_parameters()] and walk.touches == 2
    walk = Walk(opened)
    window = walk.window
    walk.touch(window.control.area, window.values.presets[1], window.values.done)
    (started,) = walk.start()
    assert (started.x_start_mm, started.x_stop_mm) == (175.0, 475.0)
    assert (started.y_start_mm, started.y_stop_mm) == (250.0, 550.0)
    assert walk.touches == 5
    window.on_event(Answer(Request.START, True, verbatim("Survey started"), "id"))
    window.refresh()
    assert window.plans.wait(30.0)
    walk = Walk(opened)
    assert walk.start() == [started] and walk.touches == 2


def test_the_answer_takes_no_touch_or_of_a_stored_survey_two_and_a_report_two_more(opened, node):
    ended = snapshot(state=state_of(SurveyState.FINISHED, survey_id=SURVEY))
    listed = past_survey(stored_traces=40, complete=True, outcome="finished")
    for touches in (0, 2):
        walk = Walk(opened, imaging=node)
        window, page = walk.window, walk.window.result
        show(window, ended)
        if touches:
            walk.touch(window.rail.tabs[TabName.SURVEYS])
            take_list(window, (listed,))
            walk.touch(window.past.result)
            show(window, ended)
            assert node.of("read")[-1] == (listed.folder,)
        node.ticket("read").done(stored())
        show(window, ended)
        found = candidate_list([candidate()], survey_id=SURVEY)
        node.ticket("focus").done(image_of(found))
        show(window, ended)
        assert page.rows[0].isVisible() and walk.touches == touches
        walk.touch(page.stick)
        plug_in(node, BLUE)
        show(window, ended)
        walk.touch(page.stick_sheet.sticks[0])
        assert len(node.of("export")) == 1 and walk.touches == touches + 2
        node.asked.clear()
