"""Whatever moves the robot, every tab says so, and STOP can be pressed."""

import itertools

from finger import Finger, place_of
from view_kit import moving, snapshot
from window_helpers import show, wishes

from gpr20_common.message import verbatim
from gpr20_operator.robot.condition import JobLevel
from gpr20_operator.robot.events import Request
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.top_bar import StateBand
from gpr20_user_interface.window.rail import TabName

X_MOVES = moving(AxisId.X)
# What a window may know of a robot, beside the state of its survey.
KNOWN = (
    *({}, {"alive": False}, {"master_alive": False}, {"axes": ()}, {"axes": X_MOVES}),
    *({"service": verbatim("homing")}, {"pending": frozenset(Request)}),
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
