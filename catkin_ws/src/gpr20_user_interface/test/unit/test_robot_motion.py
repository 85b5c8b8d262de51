"""Whatever moves the robot, every tab says so, and STOP can be pressed."""

import itertools

from case_kit import each_case
from finger import Finger, place_of
from view_kit import moving, snapshot
from window_helpers import show, wishes

from gpr20_common.message import verbatim
from gpr20_operator.robot.condition import JobLevel, condition_of
from gpr20_operator.robot.events import Request
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.top_bar import StateBand
from gpr20_user_interface.window.rail import TabName

SURVEY_MOVES = ("HOMING", "SURVEYING", "PAUSING", "STOPPING")


X_MOVES = moving(AxisId.X)
BOTH_MOVE = moving(AxisId.X, AxisId.Y)
# What a window may know of a robot, beside the state of its survey.
KNOWN = (
    *({}, {"alive": False}, {"master_alive": False}, {"axes": ()}, {"axes": X_MOVES}),
    *({"service": verbatim("homing")}, {"pending": frozenset(Request)}),
)


@each_case("code", [None, *SurveyState])
def test_motion_that_no_survey_explains_is_shown_in_every_state(code):
    job = condition_of(snapshot(code, axes=X_MOVES))
    if code is not None and code.name in SURVEY_MOVES:
        assert str(job.title) != "ROBOT MOVES"
    else:
        assert (str(job.title), str(job.message)) == ("ROBOT MOVES", "x axis")
        assert job.level in (JobLevel.ATTENTION, JobLevel.FAULT)
    assert str(condition_of(snapshot(code)).title) != "ROBOT MOVES"


@each_case(
    "code, axes, other, text",
    [
        ("IDLE", BOTH_MOVE, {}, "x axis; y axis"),
        ("PAUSED", moving(AxisId.Z, owner="/robot1/rqt_17"), {}, "z axis, by rqt_17"),
        # Another program moves an axis in the middle of a survey.
        ("SURVEYING", moving(AxisId.Y, owner="/rostopic_9"), {}, "y axis, by rostopic_9"),
        ("SURVEYING", moving(AxisId.Y, owner="/main_control"), {}, "as it is"),
        ("IDLE", BOTH_MOVE, {"service": verbatim("homing")}, "x axis; y axis; in service: homing"),
        # A main control that is silent moves nothing that anybody knows of.
        (*("SURVEYING", BOTH_MOVE, {"alive": False}), "x axis; y axis. No contact with the main"),
    ],
)
def test_who_moves_the_robot_is_said_where_it_is_known(code, axes, other, text):
    assert str(condition_of(snapshot(SurveyState[code], axes=axes, **other)).message).startswith(
        text
    )


def test_motion_is_seen_and_stop_acts_on_every_tab_over_every_dialog_and_in_every_state(opened):
    field = opened()
    show(field, snapshot(SurveyState.FINISHED, axes=X_MOVES))
    field.findChild(StateBand).touched.emit()
    assert field.notice.title.text() == "ROBOT MOVES"
    assert field.notice.reason.toPlainText() == "X axis"
    assert "STOP stops every axis" in field.notice.first.text()
    field.notice.hide()

    finger, stop, pressed = Finger(field, field.clock), field.top_bar.stop, 0
    states = itertools.cycle(itertools.product((None, *SurveyState), KNOWN))
    band = field.top_bar.band
    for tab, overlay in places_in(field):
        field.settings._dimming.dimmed = True
        show(field, snapshot(SurveyState.FINISHED, axes=X_MOVES))
        assert (band.title.whole, band.level) == ("ROBOT MOVES", JobLevel.ATTENTION), (tab, overlay)
        assert not field.settings.cover.isVisible() and is_free(field, band), (tab, overlay)
        code, known = next(states)
        show(field, snapshot(code, **known))
        for locked in (False, True):
            field.touch_binding.set_locked(locked)
            case = tab, overlay, code, known, locked
            assert stop.isEnabled() and is_free(field, stop), case
            # On the press, whatever has just opened.
            finger.press(stop)
            pressed += 1
            assert wishes(field).count("stop") == pressed, case
            finger.release(stop)
            assert wishes(field).count("stop") == pressed, case
        field.touch_binding.set_locked(False)


def places_in(window):
    """Yield every tab alone, and every dialog over one of them, while it is shown."""
    tabs = itertools.cycle(TabName)
    for tab in TabName:
        window.show_tab(tab)
        yield tab, None
    for overlay in window.findChildren(Overlay):
        tab = next(tabs)
        window.show_tab(tab)
        overlay.open()
        yield tab, type(overlay).__name__
        overlay.hide()


def is_free(window, widget):
    """Return whether a finger on a part of the window meets nothing else."""
    found = window.childAt(place_of(window, widget).center())
    return found is widget or widget.isAncestorOf(found)
