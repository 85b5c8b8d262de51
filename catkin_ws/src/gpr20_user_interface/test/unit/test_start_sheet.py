"""The sheets to hold for, as they are seen."""

import itertools

import pytest

pytest.importorskip("PyQt5")

from finger import place_of
from PyQt5.QtWidgets import QApplication, QLabel, QPushButton
from window_helpers import (
    application,
    click,
    close,
    hold,
    new_window,
    show,
    snapshot,
    window,
    wishes,
)

from gpr20_common.low.catalogue_file import languages
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_cost import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import Request
from gpr20_user_interface.mid.parameter_form import default_parameters
from gpr20_user_interface.mid.survey_preview import SurveyPreview
from gpr20_user_interface.views.translation import Languages

__all__ = ["application", "window"]

SIZES = [(480, 320), (800, 480), (1280, 800)]
LONG = Annotation(
    operator="María Fernanda de los Ángeles " * 6, site="Finca El Dorado, lote 3, " * 7
)
IDENTITY = "Rohde&Schwarz,ZNB20-4Port,1311601062100123,3.40.0.1 with options K2, K4 and B16"


def texts(sheet):
    return [label.text() for label in sheet.findChildren(QLabel) if label.isVisible()]


@pytest.fixture(scope="module", params=itertools.product(SIZES, languages()), ids=str)
def screen(request, application):
    size, language = request.param
    window = new_window(Languages(application, language))
    window.resize(*size)
    window.show()
    yield window
    close(window)


@pytest.mark.parametrize(
    "ask",
    [
        lambda sheet: sheet.ask_start(default_parameters(), LONG),
        lambda sheet: sheet.ask_resume_past("20261121T051000_7c9e6679"),
        lambda sheet: sheet.ask_resume_with(IDENTITY),
    ],
    ids=["start", "resume", "other VNA"],
)
def test_nothing_of_the_sheet_is_cut_off(screen, ask):
    window, sheet = screen, screen.start_sheet
    ask(sheet)
    for _ in range(3):
        QApplication.processEvents()
    for label in sheet.findChildren(QLabel):
        if label.isVisible() and label.text():
            assert window.rect().contains(place_of(window, label)), label.text()
            assert label.heightForWidth(label.width()) <= label.height(), label.text()
    for button in (sheet.hold, sheet.cancel):
        assert window.rect().contains(place_of(window, button))
        widest = max(map(button.fontMetrics().horizontalAdvance, button.text().split("\n")))
        assert widest < button.width()


def test_what_is_learned_while_the_sheet_is_open_is_shown_and_does_not_end_the_hold(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.start)
    assert "not known yet" in texts(window.start_sheet)
    figures = SurveyPreview(25, 50, 25.0, 25.0, 1.0, 1.0, 1.0, 1.0, SurveyCost(1080.0, 1))
    window.survey.preview = figures
    show(window, snapshot(SurveyState.IDLE))
    assert "about 18 min" in texts(window.start_sheet)
    assert window.start_sheet.isVisible()


def test_cancel_asks_for_nothing(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.start)
    click(window.start_sheet.cancel)
    assert not window.start_sheet.isVisible()
    assert wishes(window) == []


@pytest.mark.parametrize(
    ("ask", "before", "after"),
    [
        ("start", snapshot(SurveyState.IDLE), snapshot(SurveyState.SURVEYING)),
        ("start", snapshot(SurveyState.IDLE), snapshot(SurveyState.IDLE, alive=False)),
        ("resume", snapshot(SurveyState.PAUSED), snapshot(SurveyState.SURVEYING)),
        (
            "resume",
            snapshot(SurveyState.PAUSED),
            snapshot(SurveyState.PAUSED, pending=frozenset([Request.RESUME])),
        ),
        ("past", snapshot(SurveyState.IDLE), snapshot(SurveyState.CHECKING)),
    ],
)
def test_the_sheet_closes_when_it_is_too_late(window, ask, before, after):
    sheet = window.start_sheet
    show(window, before)
    {
        "start": lambda: sheet.ask_start(default_parameters(), Annotation()),
        "resume": sheet.ask_resume,
        "past": lambda: sheet.ask_resume_past("20261121T051000_7c9e6679"),
    }[ask]()
    show(window, before)
    assert sheet.isVisible()
    show(window, after)
    assert not sheet.isVisible()


def test_the_sheet_leaves_stop_free(window):
    show(window, snapshot(SurveyState.PAUSED))
    window.start_sheet.ask_resume()
    assert not window.start_sheet.geometry().intersects(window.top_bar.geometry())
    click(window.top_bar.stop)
    assert wishes(window) == ["stop"]


def test_each_question_is_answered_once(window):
    show(window, snapshot(SurveyState.PAUSED))
    window.start_sheet.ask_resume()
    hold(window.start_sheet.hold)
    hold(window.start_sheet.hold)
    assert wishes(window) == ["resume"]
    buttons = window.start_sheet.findChildren(QPushButton)
    assert not any(one.isVisible() for one in buttons)
