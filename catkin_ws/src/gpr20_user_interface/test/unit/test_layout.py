"""Every page and sheet on every screen: nothing is cut off or covered, a glove hits every button.

The window itself says which pages and sheets there are, so that no new one is forgotten. With
`GPR20_PICTURES=FOLDER` a picture of each is stored there, to be looked at. In Spanish, no English
word of ours is seen on any of them.
"""

import itertools
import os
from dataclasses import replace
from pathlib import Path

import pytest
from layout_tour import LARGEST, STOPS, busiest, results
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractScrollArea,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QProgressBar,
    QScrollArea,
    QStackedWidget,
    QTextEdit,
    QToolButton,
    QWidget,
)
from translation_kit import english_words
from window_helpers import close, opened_window, place_of, show

from gpr20_common.catalogue import Language, languages
from gpr20_operator.plan.fields import default_parameters, texts_of
from gpr20_user_interface.look.look import BORDER_PX, Theme
from gpr20_user_interface.widgets.bars import TabName
from gpr20_user_interface.widgets.plot import Plot
from gpr20_user_interface.widgets.tile import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.widgets import Overlay

PICTURES = os.environ.get("GPR20_PICTURES")
# These leave out what has no room, and say so.
CUT = (ElidedLabel, LinesLabel)
# A finger in a glove, on a screen of 800x480.
SMALLEST_TOUCH_PX = 48
SMALLEST_TEXT_PX = 16
# What a rounding at each end of a column adds up to.
ROUNDING_PX = 2
CONTENT = (
    *(QLabel, QAbstractButton, QLineEdit, QPlainTextEdit, QTextEdit, QProgressBar, Plot),
    *(QAbstractItemView, QScrollArea),
)
# For a change each size once, mostly with the longer language; the others for a release.
FIRST = (
    ((480, 320), Language.SPANISH, Theme.NIGHT),
    ((800, 480), Language.ENGLISH, Theme.SUN),
    ((1280, 800), Language.SPANISH, Theme.NIGHT),
)
SCREENS = [
    pytest.param(one, marks=() if one in FIRST else pytest.mark.release)
    for one in itertools.product([one[0] for one in FIRST], languages(), Theme)
]


@pytest.fixture(params=SCREENS)
def window(request, application, tmp_path):
    """A window of each size, with as much to say as possible."""
    size, language, theme = request.param
    window = opened_window(application, Language.ENGLISH, folder=tmp_path)
    window.resize(*size)
    QTest.qWait(1)
    window.use_look(replace(window.look, theme=theme))
    window.survey.preview = LARGEST
    window.control.form.set_texts(texts_of(default_parameters()))
    show(window, busiest())
    # As in the settings: nothing may stay in the language before.
    window.languages.use(language)
    # The changes of language, size and theme are events.
    QTest.qWait(1)
    yield window
    close(window)


def settle():
    """Let everything be laid out: for a text, and again for its height."""
    for _ in range(3):
        QTest.qWait(1)


def front(window):
    """Return what is not covered: the band, and below it the sheet that is open or the page."""
    sheets = [one for one in window.children() if isinstance(one, Overlay) and one.isVisible()]
    # The last one lies over the others.
    below = [sheets[-1]] if sheets else [window.rail, window.tabs.currentWidget()]
    return [window.top_bar, *below]


def problems(window, parts):
    """Return what is wrong with what is seen on parts of a window."""
    content = [one for part in parts for one in content_of(part)]
    wrong = [f"{name_of(one)} {reason}" for one in content for reason in misfits(window, one)]
    for one, other in itertools.combinations(content, 2):
        if not (one.isAncestorOf(other) or other.isAncestorOf(one)):
            both = place_of(window, one).intersected(place_of(window, other))
            if min(both.width(), both.height()) > ROUNDING_PX:
                wrong.append(f"{name_of(one)} lies over {name_of(other)}")
    return wrong


def content_of(part):
    """Return what is seen in a part, but for what is inside of a text or list that scrolls."""
    found = [part] if isinstance(part, CONTENT) else []
    for one in part.findChildren(QWidget):
        if one.isVisible() and isinstance(one, CONTENT) and not is_empty(one):
            found.append(one)
    areas = [one for one in found if isinstance(one, QAbstractScrollArea)]
    return [one for one in found if not any(area.isAncestorOf(one) for area in areas)]


def is_empty(widget):
    return isinstance(widget, QLabel) and not widget.text() and widget.pixmap() is None


def name_of(widget):
    text = widget.text()[:40] if hasattr(widget, "text") else ""
    return f"{type(widget).__name__} {widget.objectName()} {text!r}"


def misfits(window, widget):
    place = place_of(window, widget)
    if not window.rect().contains(place):
        yield "reaches over the edge"
    if isinstance(widget, QLabel):
        yield from label_misfits(window, widget)
    elif isinstance(widget, QAbstractButton):
        yield from button_misfits(window, widget)
    elif isinstance(widget, QLineEdit):
        yield from line_misfits(widget, widget.text() or widget.placeholderText(), 0)


def label_misfits(window, label):
    if label.text() and label.fontInfo().pixelSize() < window.look.px(SMALLEST_TEXT_PX) - 1:
        yield "is written too small"
    if label.text() and label.height() < label.fontMetrics().height() - ROUNDING_PX:
        yield "is cut off at its top"
    if isinstance(label, CUT) or not label.text():
        return
    if not label.wordWrap():
        yield from line_misfits(label, label.text(), 0)
    elif label.heightForWidth(label.width()) > label.height() + ROUNDING_PX:
        yield "has too few lines"
    else:
        longest = max(label.text().split(), key=len)
        if label.fontMetrics().horizontalAdvance(longest) > label.contentsRect().width():
            yield f"cuts the word {longest}"


def button_misfits(window, button):
    frame_px = 2 * window.look.px(BORDER_PX)
    if isinstance(button, QToolButton):
        # Its sign is above the text.
        frame_px = 0
    elif not button.icon().isNull():
        frame_px += button.iconSize().width()
    if button.text():
        yield from line_misfits(button, button.text().replace("&", ""), frame_px)
    least_px = window.look.px(SMALLEST_TOUCH_PX) - ROUNDING_PX
    if window.look.touchable and min(button.width(), button.height()) < least_px:
        yield f"is hard to touch: {button.width()}x{button.height()}"


def line_misfits(widget, text, frame_px):
    metrics, lines = widget.fontMetrics(), text.split("\n")
    if max(map(metrics.horizontalAdvance, lines)) + frame_px > widget.contentsRect().width():
        yield "is cut off at its end"
    if len(lines) * metrics.height() > widget.height() + ROUNDING_PX:
        yield "is cut off at its top"


def every_problem(window):
    """Show every page and sheet; return what is wrong, each with the first that shows it."""
    wrong, seen = {}, set()
    spanish = window.languages.language == Language.SPANISH

    def look(what):
        settle()
        for one in problems(window, front(window)):
            wrong.setdefault(one, what)
        for one in english_words(texts_on(window)) if spanish else ():
            wrong.setdefault(f"says {one}", what)
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
    for name in results(window):
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


def texts_on(window):
    """Return what is seen, but for the details, which are technical, and the sticks."""
    for one in window.findChildren(QWidget):
        if one.isVisible() and one.objectName() not in ("details", "choice"):
            names = ("text", "toPlainText", "placeholderText")
            found = [getattr(one, name, "") for name in names]
            said = [text() if callable(text) else text for text in found]
            yield from (text for text in said if isinstance(text, str))


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


def test_every_page_and_sheet_fits(window):
    wrong = every_problem(window)
    assert not wrong, "\n".join(f"{what}: {one}" for one, what in wrong.items())
