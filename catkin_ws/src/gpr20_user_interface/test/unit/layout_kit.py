"""What is wrong on a screen: text that is cut off, widgets over each other, too small to touch.

`assert_fits` looks at a window, or at parts of it. test_layout.py shows every page and sheet,
and the plan with the longest values.
"""

import contextlib
import itertools
from dataclasses import replace

import pytest

pytest.importorskip("PyQt5")

from finger import place_of
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractScrollArea,
    QGraphicsView,
    QLabel,
    QLineEdit,
    QPlainTextEdit,
    QProgressBar,
    QScrollArea,
    QTextEdit,
    QToolButton,
    QWidget,
)
from view_kit import snapshot
from window_helpers import close, opened_window, show

from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import languages
from gpr20_common.message import verbatim
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth
from gpr20_operator.plan.fields import default_parameters, texts_of
from gpr20_operator.plan.preview import SurveyPreview
from gpr20_operator.robot.events import ControlState, CurrentPosition, Progress, TargetPosition
from gpr20_operator.robot.health import HealthReport
from gpr20_survey.plan.survey_cost import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import BORDER_PX, Theme
from gpr20_user_interface.widgets.labels import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.window.rail import TabName

LONG = "the VNA at 192.168.100.100 does not answer; check its cable and its address. " * 8
LARGEST = SurveyPreview(
    stops=500000,
    traces=1000000,
    x_spacing_mm=12.34,
    y_spacing_mm=23.45,
    depth_m=110.98,
    resolution_m=0.02776,
    quarter_wavelength_mm=1.234,
    cost=SurveyCost(99 * 86400.0 + 86399.0, 123456 * 10**6),
)
# These leave out what has no room, and say so.
CUT = (ElidedLabel, LinesLabel)
# A finger in a glove, on a screen of 800x480.
SMALLEST_TOUCH_PX = 48
SMALLEST_TEXT_PX = 16
# What a rounding at each end of a column adds up to.
ROUNDING_PX = 2
CONTENT = (
    *(QLabel, QAbstractButton, QLineEdit, QPlainTextEdit, QTextEdit, QProgressBar, QGraphicsView),
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


@contextlib.contextmanager
def window_on(application, folder, size, language, theme):
    window = opened_window(application, language, profiles=folder)
    window.resize(*size)
    QTest.qWait(1)
    window.use_look(replace(window.look, theme=theme))
    yield window
    close(window)


@pytest.fixture(scope="module", params=SCREENS)
def screen(request, application, tmp_path_factory):
    """One window for all tests on a screen."""
    folder = tmp_path_factory.mktemp("profiles")
    with window_on(application, folder, *request.param) as window:
        yield window


@pytest.fixture
def spoken(screen):
    """The window of a screen, with nothing over its tabs and as much to say as possible."""
    for overlay in screen.findChildren(Overlay):
        overlay.hide()
    screen.survey.preview = LARGEST
    screen.control.form.set_texts(texts_of(default_parameters()))
    screen.show_tab(TabName.SURVEY)
    show(screen, busiest())
    # The changes of language, size and theme are events.
    QTest.qWait(1)
    return screen


def busiest(code=SurveyState.SURVEYING, **other):
    values = {"calibration": "MODERATE_POWER"}
    levels = itertools.cycle([HealthLevel.STALE, *HealthLevel])
    nodes = tuple(
        NodeHealth(name, level, verbatim(LONG), values)
        for name, level in zip((*EXPECTED_NODES, "simulator"), levels)
    )
    values = {
        "state": ControlState(code, verbatim(LONG), "id", True),
        "progress": Progress("id", 99.99, 1000000, 999999, 10**7),
        "current": CurrentPosition(650.0, 800.0, -90.0),
        "target": TargetPosition(650.0, 800.0, -90.0),
        "height_m": 0.123,
        "health": HealthReport(nodes),
        **other,
    }
    return snapshot(code, **values)


def seen(part, *kinds):
    return [one for kind in kinds for one in part.findChildren(kind) if one.isVisible()]


def assert_fits(window, *parts):
    """Check everything that is seen on parts of a window; without parts, on the whole window."""
    settle()
    wrong = problems(window, parts or front(window))
    assert not wrong, "\n".join(wrong)


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
    owner = widget
    while owner.parentWidget() is not None and not type(owner).__module__.startswith("gpr20"):
        owner = owner.parentWidget()
    return f"{type(owner).__name__}: {type(widget).__name__} {widget.objectName()} {text!r}"


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
