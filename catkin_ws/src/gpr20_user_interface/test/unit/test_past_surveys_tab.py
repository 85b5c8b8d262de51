"""The list of past surveys while surveys begin and end."""

import dataclasses

import pytest

pytest.importorskip("PyQt5")

from view_kit import SURVEY, description
from window_helpers import Storage, application, close, new_window, show, snapshot

from gpr20_common.catalogue import Language
from gpr20_common.message import verbatim
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import ControlState
from gpr20_user_interface.mid.past_surveys import PastSurvey
from gpr20_user_interface.mid.trace_events import SurveyDescribed, SurveysListed
from gpr20_user_interface.views.main_window import TabName
from gpr20_user_interface.views.translation import Languages

__all__ = ["application"]

FOLDER = "20261121T051000_7c9e6679"
RUNS = snapshot(
    SurveyState.SURVEYING, state=ControlState(SurveyState.SURVEYING, verbatim(""), SURVEY, True)
)
ENDED = snapshot(
    SurveyState.FINISHED, state=ControlState(SurveyState.FINISHED, verbatim(""), SURVEY, True)
)


@pytest.fixture
def storage():
    return Storage()


@pytest.fixture
def window(application, storage):
    languages = Languages(application, Language.ENGLISH)
    window = new_window(languages, storage=storage)
    window.show()
    window.show_tab(TabName.SURVEYS)
    survey = PastSurvey(FOLDER, SURVEY, "2026-11-21T05:10:00", "", 7, 40, None, False, True, None)
    window.on_event(SurveysListed("", (survey,), False))
    window.past.table.selectRow(0)
    storage.asked.clear()
    yield window
    close(window)


def test_a_survey_that_begins_is_told_and_cannot_be_resumed_any_more(window):
    past = window.past
    assert "The survey did not end properly." in past.details.text() and past.resume.isEnabled()
    show(window, RUNS)
    assert "Survey in progress." in past.details.text() and not past.resume.isEnabled()
    show(window, ENDED)
    assert "The survey did not end properly." in past.details.text() and past.resume.isEnabled()


def test_the_list_is_read_anew_when_a_survey_begins_is_opened_and_ends(window, storage):
    asked = []
    for act in (
        lambda: show(window, RUNS),
        lambda: window.on_event(SurveyDescribed(description())),
        lambda: show(window, RUNS),
        lambda: show(window, ENDED),
    ):
        act()
        asked.append(sum(one[0] == "list" for one in storage.asked))
    assert asked == [1, 2, 2, 3]


def test_a_list_that_nobody_sees_is_not_read(window, storage):
    window.show_tab(TabName.CONTROL)
    show(window, RUNS)
    assert storage.asked == []


def test_the_choice_stays_with_its_survey_when_a_newer_one_is_listed(window):
    chosen = window.past.chosen
    newer = dataclasses.replace(chosen, folder="20261122T051000_0f8fad5b")
    window.on_event(SurveysListed("", (newer, chosen), False))
    assert window.past.chosen == chosen
    assert FOLDER in window.past.details.text()
