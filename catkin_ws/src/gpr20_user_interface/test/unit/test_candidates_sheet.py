"""Candidates of a stored survey in the window: search, cancel, list, and what they are not."""

import dataclasses
import math

import pytest
from candidate_examples import candidate, candidate_list
from hiding_kit import a_map
from PyQt5.QtTest import QTest
from view_kit import FOLDER, SURVEY, past_survey, snapshot
from window_helpers import show

from gpr20_common.catalogue import Language
from gpr20_common.message import verbatim
from gpr20_operator.ground.trace_events import SurveysListed
from gpr20_operator.jobs.imaging import CandidatesFound, HidingMapped, RequestFailed
from gpr20_operator.jobs.search import OTHER_SURVEY, SearchState
from gpr20_operator.robot.events import ControlState
from gpr20_survey.no_clearance import NO_CLEARANCE
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.candidates import Flag
from gpr20_survey.results.hiding_map import ONLY_THIS
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.window.rail import TabName

LISTED = past_survey(survey_id=SURVEY, outcome="", stored_traces=40, complete=True)
RUNS = ControlState(SurveyState.SURVEYING, verbatim(""), "other", True)
LIST = candidate_list(
    [
        candidate(x_mm=174.0, y_mm=182.0, depth_mm=113.0, flags=[Flag.EDGE]),
        candidate(2, level_db=math.nan),
    ],
    survey_id=SURVEY,
    omitted=3,
    omitted_primary=1,
)
MANY = candidate_list(
    [candidate(number, flags=list(Flag)[: (number - 1) // 8]) for number in range(1, 51)],
    survey_id=SURVEY,
    omitted=12345,
)


@pytest.fixture(autouse=True)
def listed(window):
    show(window, snapshot())
    window.show_tab(TabName.SURVEYS)
    window.on_event(SurveysListed("", (LISTED,), False))
    window.past.table.selectRow(0)


def last_request(window):
    return window.node.of("find")[-1]


def ended(window, found=LIST, remarks="", request_id=None):
    window.on_event(CandidatesFound(request_id or last_request(window)[0], found, remarks))


def failed(window, reason):
    window.on_event(RequestFailed(last_request(window)[0], verbatim(reason)))


def search(window):
    window.past.candidates.click()
    window.candidates.find_button.click()
    return window.candidates


def cells(table):
    return [
        [table.item(row, column).text() for column in range(table.columnCount())]
        for row in range(table.rowCount())
    ]


def test_where_a_mine_could_hide_is_asked_after_the_list_and_shown_on_the_map(window, node):
    sheet = search(window)
    assert not sheet.hiding_button.isEnabled()
    ended(window)
    sheet.hiding_button.click()
    request_id, survey, permittivity, target = node.of("hide")[-1]
    assert (survey, permittivity, target) == (FOLDER, 0.0, "type-72")
    assert sheet.progress.isVisible() and sheet.cancel.isEnabled()
    found = a_map([[[6, 0]]], [[[6, 6]]], survey_id=SURVEY)
    window.on_event(HidingMapped(request_id, found))
    assert shown_text(ONLY_THIS) in sheet.details.text()
    assert cells(sheet.table)[0][0] == "C01"
    window.additions.follow(SURVEY, True)
    assert window.additions.hiding is found
    window.additions.follow("another", True)
    assert window.additions.hiding is None


def test_a_map_that_fails_or_is_cancelled_says_so(window, node):
    sheet = search(window)
    ended(window)
    sheet.hiding_button.click()
    window.on_event(RequestFailed(node.of("hide")[-1][0], verbatim("no surface echo")))
    assert "no surface echo" in sheet.details.text() and not sheet.hiding_button.isEnabled()
    sheet.find_button.click()
    ended(window)
    sheet.hiding_button.click()
    sheet.cancel.click()
    assert node.cancelled == [node.of("hide")[-1][0]]
    window.on_event(HidingMapped(node.of("hide")[-1][0], a_map([[[5]]], [[[5]]], survey_id=SURVEY)))
    assert sheet.search.hiding is None


def test_the_list_is_shown_with_what_it_is_not(window, node):
    sheet = search(window)
    ((_request_id, survey, permittivity, language),) = node.of("find")
    assert (survey, permittivity) == (FOLDER, 0.0)
    assert language == window.languages.language.value
    assert sheet.progress.isVisible() and sheet.cancel.isEnabled()
    ended(window, remarks="a remark\n")
    assert not sheet.progress.isVisible()
    first, second = cells(sheet.table)
    assert first[:4] == ["C01", "174 ±4", "182 ±4", "113 ±6"]
    assert second[-1] == "—"
    assert "a remark" in sheet.details.text() and "3" in sheet.details.text()
    for seen in (sheet.no_clearance, sheet.simulated):
        assert seen.isVisible()
    assert sheet.no_clearance.text() == shown_text(NO_CLEARANCE)


def test_the_sentence_is_visible_in_every_state(window):
    window.past.candidates.click()
    sheet = window.candidates
    for act in (
        lambda: None,
        sheet.find_button.click,
        sheet.cancel.click,
        sheet.find_button.click,
        lambda: failed(window, "refused"),
    ):
        act()
        assert sheet.no_clearance.isVisible() and sheet.no_clearance.text()


def test_a_permittivity_is_passed_on_and_a_wrong_one_locks_the_search(window, node):
    window.past.candidates.click()
    sheet = window.candidates
    for text in ("0.5", "x", "nan", "101"):
        sheet.permittivity.setText(text)
        assert not sheet.find_button.isEnabled()
    sheet.permittivity.setText("4,5")
    sheet.find_button.click()
    assert last_request(window)[2] == 4.5


def test_cancelling_ends_the_search_and_its_late_end_changes_nothing(window, node):
    sheet = search(window)
    sheet.cancel.click()
    assert node.cancelled == [last_request(window)[0]]
    ended(window)
    assert sheet.search.state is SearchState.READY and sheet.table.rowCount() == 0
    sheet.find_button.click()
    ended(window, request_id=node.cancelled[0])
    assert sheet.search.state is SearchState.RUNNING


def test_never_during_a_survey(window, node):
    sheet = search(window)
    show(window, snapshot(state=RUNS))
    assert len(node.cancelled) == 1 and not sheet.find_button.isEnabled()
    assert not window.past.candidates.isEnabled()
    ended(window)
    assert sheet.table.rowCount() == 0
    sheet.find_button.click()
    assert len(node.of("find")) == 1
    show(window, snapshot())
    assert sheet.find_button.isEnabled() and window.past.candidates.isEnabled()


def test_the_list_of_another_survey_is_said_and_not_shown(window):
    sheet = search(window)
    ended(window, dataclasses.replace(LIST, survey_id="another"))
    assert not sheet.table.isVisible() and not sheet.table.rowCount()
    assert sheet.details.text() == shown_text(OTHER_SURVEY)
    assert sheet.find_button.isEnabled()


def test_a_failure_shows_all_of_its_reason_and_no_list(window):
    reason = "the echoes agree with every permittivity. " + "word " * 60 + "give the permittivity"
    sheet = search(window)
    failed(window, reason)
    assert sheet.search.state is SearchState.FAILED and sheet.table.rowCount() == 0
    assert sheet.details.text() == reason


def test_what_was_found_in_another_survey_is_forgotten(window):
    search(window)
    ended(window)
    assert window.candidates.table.rowCount() == 2
    other = dataclasses.replace(LISTED, folder="20260101T000000_00000000", survey_id="other")
    window.candidates.show_survey(other)
    assert window.candidates.table.rowCount() == 0


def test_the_language_changes_at_once(window):
    sheet = search(window)
    ended(window, MANY)
    assert sheet.table.rowCount() == 32 + 10 and "12353" in sheet.details.text()
    before = (cells(sheet.table)[20][-1], sheet.no_clearance.text())
    window.languages.use(Language.SPANISH)
    QTest.qWait(1)
    after = (cells(sheet.table)[20][-1], sheet.no_clearance.text())
    assert after[1] != before[1] and after[0] != before[0]


def test_closing_the_window_ends_a_search(window, node):
    search(window)
    window.end()
    assert len(node.cancelled) == 1
