"""The list of past surveys while surveys begin and end."""

import pytest

pytest.importorskip("PyQt5")

from view_kit import SURVEY, description
from window_helpers import application, snapshot

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import ControlState
from gpr20_user_interface.mid.past_surveys import PastSurvey
from gpr20_user_interface.mid.trace_events import SurveyDescribed, SurveysListed
from gpr20_user_interface.mid.trace_presenter import TracePresenter

__all__ = ["application"]

FOLDER = "20261121T051000_7c9e6679"
RUNS = snapshot(SurveyState.SURVEYING, state=ControlState(SurveyState.SURVEYING, "", SURVEY, True))
ENDED = snapshot(SurveyState.FINISHED, state=ControlState(SurveyState.FINISHED, "", SURVEY, True))


class Storage:
    """Counts how often it was asked for the list."""

    def __init__(self):
        self.lists = 0

    def list_surveys(self, before):
        self.lists += 1

    def read_survey(self, folder):
        raise AssertionError("nobody opens a survey here")


@pytest.fixture
def storage():
    return Storage()


@pytest.fixture
def presenter(application, storage):
    presenter = TracePresenter(storage)
    presenter.views.past.show()
    survey = PastSurvey(FOLDER, SURVEY, "2026-11-21T05:10:00", "", 7, 40, "", False, True, "")
    presenter.on_event(SurveysListed("", (survey,), False))
    presenter.views.past.table.selectRow(0)
    storage.lists = 0
    yield presenter
    presenter.views.past.close()


def test_a_survey_that_begins_is_told_and_cannot_be_resumed_any_more(presenter):
    past = presenter.views.past
    assert "It has not ended properly." in past.details.text() and past.resume.isEnabled()
    presenter.show_state(RUNS)
    assert "It is on its way." in past.details.text() and not past.resume.isEnabled()
    presenter.show_state(ENDED)
    assert "It has not ended properly." in past.details.text() and past.resume.isEnabled()


def test_the_list_is_read_anew_when_a_survey_begins_is_opened_and_ends(presenter, storage):
    asked = []
    for act in (
        lambda: presenter.show_state(RUNS),
        lambda: presenter.on_event(SurveyDescribed(description())),
        lambda: presenter.show_state(RUNS),
        lambda: presenter.show_state(ENDED),
    ):
        act()
        asked.append(storage.lists)
    assert asked == [1, 2, 2, 3]


def test_a_list_that_nobody_sees_is_not_read(presenter, storage):
    presenter.views.past.hide()
    presenter.show_state(RUNS)
    assert storage.lists == 0
