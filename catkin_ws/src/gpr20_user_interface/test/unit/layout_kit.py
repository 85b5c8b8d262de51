"""What fits on a screen: no text is cut off, and a gloved finger hits every button."""

import itertools
from dataclasses import replace

import pytest

pytest.importorskip("PyQt5")

from finger import place_of
from pseudo_language import PSEUDO, write_pseudo_catalogue
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QAbstractButton, QLabel, QLineEdit
from result_kit import Requests
from view_kit import snapshot
from window_helpers import close, new_window, show

from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import VARIABLE
from gpr20_common.message import verbatim
from gpr20_doctor.mid.node_health import EXPECTED_NODES, HealthLevel, NodeHealth
from gpr20_operator.plan.fields import default_parameters, texts_of
from gpr20_operator.plan.preview import SurveyPreview
from gpr20_operator.robot.events import ControlState, CurrentPosition, Progress, TargetPosition
from gpr20_operator.robot.health import HealthReport
from gpr20_survey.plan.survey_cost import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.look.look import BORDER_PX, GAP_PX, TEXT_PX, TOUCH_PX, Theme
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.widgets.labels import ElidedLabel, LinesLabel
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.window.rail import TabName

LONG = "the VNA at 192.168.100.100 does not answer; check its cable and its address. " * 8
LARGEST = SurveyPreview(
    stops=500000,
    traces=1000000,
    x_spacing_mm=12.34,
    y_spacing_mm=23.45,
    frequency_step_hz=1.350675e6,
    depth_m=110.98,
    resolution_m=0.02776,
    quarter_wavelength_mm=1.234,
    cost=SurveyCost(99 * 86400.0 + 86399.0, 123456 * 10**6),
)
# These leave out what has no room, and say so.
CUT = (ElidedLabel, LinesLabel)
SIZES = ((480, 320), (800, 480), (1280, 800))
# The colours change no size: each theme once with each size.
SCREENS = [
    (size, language, theme)
    for size in SIZES
    for language, theme in ((Language.ENGLISH, Theme.SUN), (Language.SPANISH, Theme.NIGHT))
]
# A language of somebody else's, on the robot's screen.
SCREENS.append(((800, 480), PSEUDO, Theme.SUN))


@pytest.fixture(scope="module", params=SCREENS, ids=lambda screen: f"{screen[0]}-{screen[1].value}")
def screen(request, application, tmp_path_factory):
    """One window for all tests on a screen."""
    size, language, theme = request.param
    own_folder = tmp_path_factory.mktemp("translations")
    if language == PSEUDO:
        write_pseudo_catalogue(own_folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, str(own_folder))
        window = new_window(
            Languages(application, language),
            profiles=tmp_path_factory.mktemp("profiles"),
            imaging=Requests(),
        )
        window.use_look(replace(window.look, theme=theme))
        window.show()
        window.resize(*size)
        yield window
        close(window)


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
    """Return what is known of a robot that has much to say."""
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


def assert_fits(window, *parts, padding_px=0):
    """Check every text that is seen on parts of a window, or on all of it."""
    # What is laid out again for a text, and then for its height, takes two rounds.
    for _ in range(2):
        QTest.qWait(1)
    wrong = [
        f"{type(part).__name__}: {widget.text()!r} {reason}"
        for part in parts or [window]
        for widget in seen(part, QLabel, QAbstractButton, QLineEdit)
        if not isinstance(widget, CUT)
        for reason in misfits(window, widget, padding_px)
    ]
    assert not wrong, "\n".join(wrong)


def misfits(window, widget, padding_px):
    """Yield what is wrong with the place of a text."""
    metrics, is_label = widget.fontMetrics(), isinstance(widget, QLabel)
    if not window.rect().contains(place_of(window, widget)):
        yield "reaches over the edge"
    if is_label and widget.text() and widget.fontInfo().pixelSize() < window.look.px(TEXT_PX):
        yield "is written too small"
    if is_label and widget.wordWrap():
        if widget.heightForWidth(widget.width()) > widget.height():
            yield "has too few lines"
        return
    text = widget.text().replace("&", "")
    if isinstance(widget, QLineEdit):
        text = text or widget.placeholderText()
    lines = text.split("\n")
    frame_px = 0 if is_label else 2 * window.look.px(BORDER_PX + padding_px)
    if max(map(metrics.horizontalAdvance, lines)) + frame_px > widget.contentsRect().width():
        yield "is cut off at its end"
    if len(lines) * metrics.height() > widget.height():
        yield "is cut off at its top"


def assert_touchable(window, *parts):
    """Check that a gloved finger hits each button and field, and no two at once."""
    # A pixel of rounding at the small scale, for each of the three parts of a column.
    least_px, gap_px = window.look.px(TOUCH_PX) - 3, window.look.px(GAP_PX) - 1
    for part in parts:
        touched = seen(part, QAbstractButton)
        places = {one: place_of(window, one) for one in touched}
        assert min(place.height() for place in places.values()) >= least_px
        close_by = [
            (places[one], places[other])
            for one, other in itertools.combinations(touched, 2)
            if apart(places[one], places[other]) < gap_px
        ]
        assert not close_by, close_by


def apart(one, other):
    """Return how far two places are apart [px]; negative if they overlap."""
    across = max(one.left() - other.right(), other.left() - one.right())
    down = max(one.top() - other.bottom(), other.top() - one.bottom())
    return max(across, down) - 1
