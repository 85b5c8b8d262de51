"""The list of past surveys while surveys begin and end."""

import dataclasses
import datetime

import pytest
from PyQt5.QtTest import QTest
from view_kit import FOLDER, SURVEY, description, past_survey, snapshot, state_of
from window_helpers import show

from gpr20_operator.ground.trace_events import SurveyDescribed, SurveysListed
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.survey_summary import Thumbnail
from gpr20_user_interface.pages.surveys.view import AREA, MAP, WHAT
from gpr20_user_interface.window.rail import TabName

RUNS, ENDED = (
    snapshot(state=state_of(code, survey_id=SURVEY))
    for code in (SurveyState.SURVEYING, SurveyState.FINISHED)
)


@pytest.fixture(autouse=True)
def listed(window, storage):
    window.show_tab(TabName.SURVEYS)
    survey = past_survey(survey_id=SURVEY, outcome="", verdict=None)
    window.on_event(SurveysListed("", (survey,), False))
    window.past.table.selectRow(0)
    storage.asked.clear()


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
    window.show_tab(TabName.SURVEY)
    show(window, RUNS)
    assert storage.asked == []


def test_the_choice_stays_with_its_survey_when_a_newer_one_is_listed(window):
    chosen = window.past.chosen
    newer = dataclasses.replace(chosen, folder="20261122T051000_0f8fad5b")
    window.on_event(SurveysListed("", (newer, chosen), False))
    assert window.past.chosen == chosen
    assert FOLDER in window.past.details.text()


def test_times_are_local(window):
    bogota = datetime.timezone(datetime.timedelta(hours=-5))
    assert window.past.chosen.local_time(bogota) == "2026-11-21 00:10"
    unknown = dataclasses.replace(window.past.chosen, started="")
    assert unknown.local_time(bogota) == "2026-11-21 00:10"
    assert dataclasses.replace(unknown, folder="odd").local_time(bogota) == "odd"


def test_name_area_and_map_are_listed(window):
    named = dataclasses.replace(
        window.past.chosen,
        name="Field 7, north",
        thumbnail=Thumbnail(300.0, 200.0, 2, 2, bytes((100, 50, 0, 0))),
    )
    window.on_event(SurveysListed("", (named,), False))
    table = window.past.table
    assert table.item(0, WHAT).text().startswith("Field 7, north\n")
    assert table.item(0, AREA).text() == "300 x 200 mm\n7 / 40"
    picture = table.item(0, MAP).icon().pixmap(56, 56).toImage()
    empty = dataclasses.replace(named, thumbnail=Thumbnail(300.0, 200.0, 2, 2, bytes(4)))
    window.on_event(SurveysListed("", (empty,), False))
    assert table.item(0, MAP).icon().pixmap(56, 56).toImage() != picture
    # Y points upwards.
    assert picture.pixelColor(14, 38) != picture.pixelColor(14, 18)
    assert table.rowHeight(0) >= 60


def test_hundreds_of_surveys_are_read_as_the_list_is_scrolled(window, storage):
    chosen = window.past.chosen
    pages = [
        tuple(
            dataclasses.replace(chosen, folder=f"2026{12 - page:02d}{28 - day:02d}T051000_7c9e6679")
            for day in range(20)
        )
        for page in range(3)
    ]
    window.on_event(SurveysListed("", pages[0], True))
    table = window.past.table
    for page in (1, 2):
        QTest.qWait(1)
        storage.asked.clear()
        before = pages[page - 1][-1].folder
        table.verticalScrollBar().setValue(table.verticalScrollBar().maximum())
        assert storage.asked in ([("list", before)], [])
        window.on_event(SurveysListed(before, pages[page], page < 2))
    assert table.rowCount() == 60
