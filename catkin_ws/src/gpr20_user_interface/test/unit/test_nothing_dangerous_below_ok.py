"""Where a sheet has OK, CLOSE or Cancel, no other sheet and no tab has a button to hold."""

from finger import place_of
from layout_kit import screen, spoken
from PyQt5.QtWidgets import QApplication, QPushButton, QStackedWidget
from view_kit import snapshot
from window_helpers import show

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.cards import NoticeView
from gpr20_user_interface.widgets.hold_sheet import StartSheet
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.window.rail import TabName

__all__ = ["screen", "spoken"]

# How sheets call the buttons that close them.
CLOSING = (
    *("accept_button", "cancel", "close_button", "done", "drop", "load", "save", "show_button"),
    *("undo", "use"),
)


def settle():
    for _ in range(3):
        QApplication.processEvents()


def closing_buttons(overlay):
    found = [getattr(overlay, name, None) for name in CLOSING]
    return [one for one in found if isinstance(one, QPushButton)]


def test_a_touch_that_comes_twice_never_reaches_a_button_to_hold(spoken):
    window = spoken
    show(window, snapshot(SurveyState.IDLE))
    closing, held = [], {}
    for overlay in window.findChildren(Overlay):
        own = closing_buttons(overlay)
        assert own, f"{type(overlay).__name__}: how is it closed?"
        overlay.open()
        settle()
        # One that closes by a hold takes no bounce.
        taps = [one for one in own if one.isVisible() and not isinstance(one, HoldButton)]
        closing += [(overlay, button, place_of(window, button)) for button in taps]
        held.update(places(window, set(overlay.findChildren(HoldButton)) - set(own)))
        overlay.hide()
    assert {window.start_sheet.hold, window.profiles.confirm.hold} <= set(held)
    assert_apart(window, held, closing)
    # Below a tab's own sheets there is that tab, below the others any tab.
    anywhere = [one for one in closing if isinstance(one[0], (NoticeView, StartSheet))]
    for tab in TabName:
        window.show_tab(tab)
        for page in every_page(window.tabs.currentWidget()):
            settle()
            assert_apart(window, places(window, page.findChildren(HoldButton)), anywhere)


def assert_apart(window, held, closing):
    for button, place in held.items():
        assert window.rect().contains(place), button.text()
        for overlay, closer, below in closing:
            words = f"{type(overlay).__name__}: {closer.text()} lies over {button.text()}"
            assert not place.intersects(below), words


def every_page(tab):
    """Yield a tab with each of the pages that it can show."""
    yield tab
    for pages in tab.findChildren(QStackedWidget):
        for number in range(pages.count()):
            pages.setCurrentIndex(number)
            yield tab


def places(window, buttons):
    return {button: place_of(window, button) for button in buttons if button.isVisible()}


def test_the_button_to_hold_is_not_where_it_was_asked_for(spoken):
    window = spoken
    show(window, snapshot(SurveyState.IDLE))
    sheet = window.start_sheet
    sheet.ask_resume_with("Anritsu,MS2026C/2,62011033,1.23")
    window.profiles.confirm.open()
    window.profiles.open()
    settle()
    hold = place_of(window, window.profiles.confirm.hold)
    assert not hold.intersects(place_of(window, window.profiles.delete))
    window.question.open()
    settle()
    assert not place_of(window, sheet.hold).intersects(
        place_of(window, window.question.accept_button)
    )
