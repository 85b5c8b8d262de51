"""Every page and sheet on every screen: nothing is cut off or covered, a glove hits every button.

The window itself says which pages and sheets there are, so that no new one is forgotten. With
`GPR20_PICTURES=FOLDER` a picture of each is stored there, to be looked at.
"""

import importlib
import os
import pkgutil
import warnings
from pathlib import Path

import pytest
from layout_kit import SCREENS, busiest, front, problems, settle, window_on
from layout_tour import STOPS
from pseudo_language import PSEUDO, write_pseudo_catalogue
from PyQt5.QtWidgets import QLabel, QPushButton, QStackedWidget, QWidget
from window_helpers import show

import gpr20_user_interface
from gpr20_common.low.catalogue_file import VARIABLE
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import Look, Theme
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.window.rail import TabName

PICTURES = os.environ.get("GPR20_PICTURES")


def every_problem(window):
    """Show every page and sheet; return what is wrong, and the classes that were seen.

    What is wrong is named once, with the first page that shows it.
    """
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
        seen.update(type(one) for one in (window, *window.findChildren(QWidget)) if one.isVisible())

    for name, stop in STOPS.items():
        close_sheets(window)
        stop(window)
        look(name)
    close_sheets(window)
    for tab in TabName:
        window.show_tab(tab)
        for stack in window.tabs.currentWidget().findChildren(QStackedWidget):
            look_through(stack, look)
        if isinstance(window.tabs.currentWidget(), QStackedWidget):
            look_through(window.tabs.currentWidget(), look)
        else:
            look(tab.value)
    for sheet in window.findChildren(Overlay):
        close_sheets(window)
        if not any(issubclass(one, type(sheet)) for one in seen):
            sheet.open()
            look(type(sheet).__name__)
    close_sheets(window)
    return "\n".join(f"{what}: {one}" for one, what in wrong.items()), seen


def look_through(stack, look):
    """Look at each page of a stack, and leave it as it was."""
    shown = stack.currentIndex()
    for number in range(stack.count()):
        stack.setCurrentIndex(number)
        if stack.isVisible():
            look(type(stack.currentWidget()).__name__)
    stack.setCurrentIndex(shown)


def close_sheets(window):
    for sheet in window.findChildren(Overlay):
        sheet.hide()


def own_widgets():
    """Return the classes of all widgets of pages, and of those that several pages share."""
    package = gpr20_user_interface
    found = set()
    for one in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        if any(part in one.name for part in (".pages.", ".widgets.", ".window.")):
            module = importlib.import_module(one.name)
            found |= {
                value
                for value in vars(module).values()
                if isinstance(value, type)
                and issubclass(value, QWidget)
                and value.__module__ == one.name
            }
    return found


@pytest.mark.parametrize("size,language,theme", SCREENS)
def test_every_page_and_sheet_fits(application, tmp_path, size, language, theme):
    with window_on(application, tmp_path, size, language, theme) as window:
        wrong, seen = every_problem(window)
    assert not wrong, wrong
    unseen = {one for one in own_widgets() if not any(issubclass(two, one) for two in seen)}
    assert not unseen, f"add a stop to layout_tour.py that shows {unseen}"


def test_texts_a_third_longer_than_english(application, tmp_path, monkeypatch):
    """A language of somebody else's may need other words: only a warning."""
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    write_pseudo_catalogue(tmp_path)
    with window_on(application, tmp_path, (800, 480), PSEUDO, Theme.SUN) as window:
        show(window, busiest(SurveyState.IDLE))
        wrong, _seen = every_problem(window)
        assert window.settings.title.text().startswith("Séttîñgš")
    if wrong:
        warnings.warn(wrong, stacklevel=1)


def at(widget, left, top, width, height):
    widget.setGeometry(left, top, width, height)
    return widget


WRONG = {
    "is cut off at its end": lambda part: at(QLabel("much too long", part), 10, 10, 40, 60),
    "is cut off at its top": lambda part: at(QLabel("a\nb\nc", part), 10, 10, 200, 20),
    "reaches over the edge": lambda part: at(QLabel("a", part), 350, 10, 100, 60),
    "has too few lines": lambda part: at(wrapped("one line and another one", part), 10, 10, 90, 20),
    "cuts the word": lambda part: at(wrapped("interferometrically", part), 10, 10, 60, 90),
    "is hard to touch": lambda part: at(QPushButton("OK", part), 10, 10, 200, 40),
    "lies over": lambda part: at(QLabel("a", part), 190, 190, 60, 60),
}


def wrapped(text, part):
    label = QLabel(text, part)
    label.setWordWrap(True)
    return label


@pytest.mark.parametrize("reason", WRONG)
def test_the_kit_finds_what_is_wrong(application, reason):
    window = QWidget()
    window.look = Look()
    window.resize(400, 300)
    at(QPushButton("Right", window), 200, 200, 120, 60)

    WRONG[reason](window)
    window.show()
    found = problems(window, [window])
    assert len(found) == 1 and reason in found[0]
    window.children()[-1].hide()
    assert problems(window, [window]) == []
