"""SURVEYS: a finger finds, scrolls and chooses; and the list follows surveys that begin and end."""

import dataclasses

import pytest
from candidate_examples import candidate
from hypothesis import given
from hypothesis import strategies as st
from map_kit import focused
from PyQt5.QtCore import QPoint
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QScroller
from view_kit import FOLDER, SURVEY, description, past_survey, snapshot, state_of
from window_helpers import AFTER_S, click, show, take_list

from gpr20_common.message import verbatim
from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.words import local_time
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.answers import SurveySummary
from gpr20_survey.results.candidates import Flag
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.bars import TabName

RUNS, ENDED = (
    snapshot(state=state_of(code, survey_id=SURVEY))
    for code in (SurveyState.SURVEYING, SurveyState.FINISHED)
)


SIZES = {"width_mm": 300.0, "height_mm": 200.0, "map_columns": 2, "map_rows": 2}
PART = SurveySummary("a", **SIZES, stored_traces=9, map_percent=bytes((100, 50, 0, 0)))
STARTED = "2026-11-21T05:10:00.000000+00:00"
PLACES = (candidate(1, 15.0, 14.0), candidate(2, 18.0, 12.0, flags=[Flag.CLUTTER]))


def many(count, **changes):
    """Return surveys with names of their own, the newest first."""
    base = past_survey(**changes)
    return tuple(
        dataclasses.replace(base, folder=f"20261121T{one:06d}_7c9e6679", name=f"Lane {one}")
        for one in reversed(range(count))
    )


@pytest.fixture
def listed(window, storage):
    """One survey that was cut off, chosen."""
    window.show_tab(TabName.SURVEYS)
    survey = past_survey(survey_id=SURVEY, outcome="", verdict=None)
    take_list(window, (survey,))
    window.past.choose(survey)
    storage.asked.clear()
    return window.past


def test_only_a_survey_that_can_be_read_and_is_not_finished_is_resumed(window, listed):
    found = []
    for changes in ({}, {"outcome": "finished", "complete": True}, {"problem": verbatim("torn")}):
        survey = past_survey(**changes)
        take_list(window, (survey,))
        listed.choose(survey)
        found.append((listed.resume.isVisible(), listed.open.isVisible()))
    assert found == [(True, True), (False, True), (False, False)]


def test_a_survey_that_begins_is_not_resumed_and_the_list_is_read_again(window, listed, storage):
    assert listed.resume.isVisible()
    for act, count in (
        (lambda: show(window, RUNS), 1),
        (lambda: window.on_event(SurveyDescribed(description())), 2),
        (lambda: show(window, RUNS), 2),
        (lambda: show(window, ENDED), 3),
    ):
        act()
        assert sum(one[0] == "list" for one in storage.asked) == count
        assert listed.resume.isVisible() is (count == 3)
        words = "33 of 40 traces missing" if count == 3 else "Running"
        assert words in listed.details.text()


def test_the_choice_stays_with_its_survey_while_it_is_listed(window, listed):
    chosen = listed.chosen
    newer = dataclasses.replace(chosen, folder="20261122T051000_0f8fad5b", name="Salado")
    take_list(window, (newer, chosen))
    assert listed.chosen == chosen
    listed.search_for("salado")
    assert listed.chosen == newer and listed.resume.isVisible()
    listed.search_for("nothing is called so")
    assert listed.chosen is None and not listed.resume.isVisible()


def test_the_newest_survey_is_chosen_with_its_date_and_answer(window, node):
    window.show_tab(TabName.SURVEYS)
    survey = dataclasses.replace(PART, folder=FOLDER, name="Lane 9", started=STARTED)
    take_list(window, (survey, *many(2)))
    listed = window.past
    assert listed.chosen == survey and node.of("focus") == [(FOLDER, True)]
    assert shown_text(local_time(STARTED)) in listed.details.text()
    node.ticket("focus").done(focused(PLACES, SURVEY))
    assert listed.details.text().startswith("1 place to check; 1 weaker echo")
    listed.choose(many(1)[0])
    node.ticket("focus").fail(verbatim("this survey was not searched yet"))
    assert listed.details.text().startswith("This survey was not searched yet")


def test_what_is_wrong_with_an_incomplete_survey_is_said():
    """Never "INCOMPLETE" of a survey whose traces are all stored."""
    surveys = PastSurveys()
    whole = past_survey(stored_traces=25000, planned_traces=25000)
    endings = {
        dataclasses.replace(whole, complete=True): "complete",
        dataclasses.replace(whole, outcome="stopped"): "not confirmed; all traces stored",
        dataclasses.replace(whole, outcome="finished"): "not confirmed; all traces stored",
        dataclasses.replace(whole, stored_traces=24999): "1 of 25000 traces missing",
        dataclasses.replace(whole, planned_traces=0): "its plan cannot be read",
        dataclasses.replace(whole, outcome="imported"): "imported",
        dataclasses.replace(whole, problem=verbatim("damaged")): "cannot be read",
    }
    assert {one: shown_text(surveys.ending(one)) for one in endings} == endings


def pull(window, finger, start, moves):
    """Touch a list at rest: press, move by steps and release."""
    QScroller.scroller(window.past.list.viewport()).stop()
    place = QPoint(start)
    finger.press(place)
    for dx, dy in moves:
        place += QPoint(dx, dy)
        finger.move(place)
        QTest.qWait(0)
    finger.release(place)


SHAKES = st.tuples(st.integers(-4, 4), st.integers(-4, 4))
STEPS = st.lists(st.tuples(st.integers(-40, 40), st.integers(-90, 90)), min_size=1, max_size=12)


def test_a_shaking_tap_chooses_the_survey_below_it_and_a_pull_none(window, finger):
    window.show_tab(TabName.SURVEYS)
    take_list(window, many(300))
    QTest.qWait(1)
    finger.wait(AFTER_S)
    page, viewport = window.past, window.past.list.viewport()

    @given(st.integers(2, 90), st.integers(2, 98), SHAKES, STEPS)
    def check(x, y, shake, moves):
        page.choose(None)
        QTest.qWait(1)
        at = QPoint(x * viewport.width() // 100, y * viewport.height() // 100)
        row, place = page.list.indexAt(at + QPoint(*shake)).row(), viewport.mapTo(window, at)
        pull(window, finger, place, [shake])
        assert page.chosen == page.model.surveys[row]
        page.choose(None)
        # Farther than a finger that shakes, even if it comes back; and aside.
        for steps in ([(0, 60), (0, -60), *moves], [(40, 0), (-20, 0)]):
            pull(window, finger, place, steps)
            QTest.qWait(1)
            assert page.chosen is None

    check()


def test_each_action_names_the_chosen_survey(window, listed):
    asked = []
    show(window, ENDED)
    for name in ("open", "notes", "resume"):
        getattr(listed, f"{name}_requested").connect(asked.append)
        click(getattr(listed, name))
        for sheet in (window.start_sheet, window.annotation):
            sheet.hide()
    assert asked == [FOLDER] * 3
