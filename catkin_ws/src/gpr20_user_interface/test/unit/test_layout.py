"""Every page and sheet on every screen: nothing is cut off or covered, a glove hits every button.

The window itself says which pages and sheets there are, so that no new one is forgotten. With
`GPR20_PICTURES=FOLDER` a picture of each is stored there, to be looked at.
"""

import os
from pathlib import Path

import pytest
from finger import place_of
from layout_kit import (
    SCREENS,
    busiest,
    front,
    problems,
    screen,
    settle,
    spoken,
    window_on,
)
from layout_tour import IDENTITY, STOPS
from PyQt5.QtWidgets import QPushButton, QStackedWidget
from view_kit import snapshot
from window_helpers import click, open_field, show

from gpr20_operator.plan.fields import PLAN
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.touch.hold_button import HoldButton
from gpr20_user_interface.widgets.cards import NoticeView
from gpr20_user_interface.widgets.hold_sheet import StartSheet
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.window.rail import TabName

__all__ = ["screen", "spoken"]

PICTURES = os.environ.get("GPR20_PICTURES")
# How sheets call the buttons that close them or open the one with a button to hold.
CLOSING = (
    *("accept_button", "cancel", "close_button", "delete", "done", "drop", "load", "save"),
    *("show_button", "undo", "use"),
)


def every_problem(window):
    """Show every page and sheet; return what is wrong, each with the first that shows it."""
    wrong, seen = {}, set()

    def look(what):
        settle()
        for one in problems(window, front(window)):
            wrong.setdefault(one, what)
        if PICTURES:
            language, theme = window.languages.language.value, window.look.theme.value
            folder = Path(PICTURES) / f"{window.width()}x{window.height()}_{language}_{theme}"
            folder.mkdir(parents=True, exist_ok=True)
            assert window.grab().save(str(folder / f"{what.replace(' ', '_')}.png"))
        seen.update(type(one) for one in window.findChildren(Overlay) if one.isVisible())

    for name, stop in STOPS.items():
        close_sheets(window)
        stop(window)
        look(name)
    close_sheets(window)
    for tab in TabName:
        for page in every_page(window, tab):
            look(page)
    for sheet in window.findChildren(Overlay):
        close_sheets(window)
        if not any(issubclass(one, type(sheet)) for one in seen):
            sheet.open()
            look(type(sheet).__name__)
    return wrong


def every_page(window, tab):
    """Show a tab with each of the pages that it can show, and yield the name of each."""
    window.show_tab(tab)
    page = window.tabs.currentWidget()
    if not isinstance(page, QStackedWidget):
        yield tab.value
    own = [page] if isinstance(page, QStackedWidget) else []
    for stack in (*own, *page.findChildren(QStackedWidget)):
        shown = stack.currentIndex()
        for number in range(stack.count()):
            stack.setCurrentIndex(number)
            if stack.isVisible():
                yield type(stack.currentWidget()).__name__
        stack.setCurrentIndex(shown)


def close_sheets(window):
    for sheet in window.findChildren(Overlay):
        sheet.hide()


@pytest.mark.parametrize("screen_shown", SCREENS)
def test_every_page_and_sheet_fits(application, tmp_path, screen_shown):
    with window_on(application, tmp_path, *screen_shown) as window:
        wrong = every_problem(window)
    assert not wrong, "\n".join(f"{what}: {one}" for one, what in wrong.items())


def places(window, part, closing=()):
    """Return where the buttons to hold of a part are, but for those that close it."""
    held = [one for one in part.findChildren(HoldButton) if one.isVisible()]
    return [(one, place_of(window, one)) for one in held if one not in closing]


def assert_apart(window, held, closing):
    for button, place in held:
        assert window.rect().contains(place), button.text()
        for overlay, closer, below in closing:
            words = f"{type(overlay).__name__}: {closer.text()} lies over {button.text()}"
            assert not place.intersects(below), words


def test_a_touch_that_comes_twice_never_reaches_a_button_to_hold(spoken):
    window = spoken
    show(window, snapshot(SurveyState.IDLE))
    closing, held = [], []
    for overlay in window.findChildren(Overlay):
        named = [getattr(overlay, name, None) for name in CLOSING]
        own = [one for one in named if isinstance(one, QPushButton)]
        assert own, f"{type(overlay).__name__}: how is it closed?"
        overlay.open()
        settle()
        # One that closes by a hold takes no bounce.
        taps = [one for one in own if one.isVisible() and not isinstance(one, HoldButton)]
        closing += [(overlay, button, place_of(window, button)) for button in taps]
        held += places(window, overlay, own)
        overlay.hide()
    assert {window.start_sheet.hold, window.profiles.confirm.hold} <= {one for one, _ in held}
    assert_apart(window, held, closing)
    # Below a tab's own sheets there is that tab, below the others any tab.
    anywhere = [one for one in closing if isinstance(one[0], (NoticeView, StartSheet))]
    for tab in TabName:
        for _page in every_page(window, tab):
            settle()
            assert_apart(window, places(window, window.tabs.currentWidget()), anywhere)


def test_the_button_to_hold_is_not_where_another_analyzer_was_accepted(spoken):
    show(spoken, snapshot(SurveyState.IDLE))
    spoken.start_sheet.ask_resume_with(IDENTITY)
    spoken.question.open()
    settle()
    accepted = place_of(spoken, spoken.question.accept_button)
    assert not place_of(spoken, spoken.start_sheet.hold).intersects(accepted)


def test_a_number_is_whole_or_shows_its_beginning(spoken):
    """600.1234 must not read as 500.1234 or 00.1234."""
    show(spoken, busiest(SurveyState.IDLE))
    for spec in PLAN:
        for text in ("-9876.123456789", "1" * 40):
            field = open_field(spoken, spec.name)
            spoken.values.write(text)
            settle()
            (line,) = field.lines
            shown = line.text()
            assert shown == f"{text}|" or (shown.endswith("…") and text.startswith(shown[:-1]))
            # Fourteen characters are always seen.
            assert not line.is_cut or len(shown) > 14
            click(spoken.values.done)
