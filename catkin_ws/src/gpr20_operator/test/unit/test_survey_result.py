"""The result of a survey without its widgets: order, counts, one permittivity, records."""

import dataclasses
import re

import pytest
from candidate_examples import candidate, candidate_list, candidate_lists
from hypothesis import given
from hypothesis import strategies as st
from result_examples import a_map
from result_kit import (
    ELEVEN,
    PLANNED,
    TIME_US,
    Requests,
    begin_search,
    image_of,
    new_result,
    noted,
    search,
    stored,
)
from view_kit import PAST, SURVEY

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import verbatim
from gpr20_operator.jobs.result import BESIDE_MM, OTHER_SURVEY, PLACES_SHOWN, list_sum
from gpr20_operator.jobs.result_texts import headline, measured, notices, soil_lines
from gpr20_survey.folder.log_record import Kind, soil_values
from gpr20_survey.plan.markers import FOUND_FORMAT as FOUND
from gpr20_survey.plan.markers import What, found_of
from gpr20_survey.results.candidates import json_text, list_from
from gpr20_survey.results.hiding_map import Targets


@pytest.fixture
def result(node):
    return new_result(node)


@given(candidate_lists())
def test_places_to_check_come_first_then_the_weaker_echoes_and_all_are_counted(found):
    node = Requests()
    result = new_result(node)
    found = dataclasses.replace(found, survey_id=SURVEY)
    search(result, node, found.candidates, omitted=found.omitted)
    shown = []
    while not shown or result.first:
        page = result.shown
        assert len({one.is_doubtful for one in page}) <= 1 and len(page) <= PLACES_SHOWN
        shown += page
        result.turn_page()
        if not page:
            break
    assert tuple(shown) == found.candidates and result.first == 0
    said = [int(one) for one in re.findall("[0-9]+", str(headline(found)))]
    assert said == [one for one in (found.primary, found.weaker) if one]
    assert found.primary or "No place stands out" in str(headline(found))


PERMITTIVITY = st.one_of(st.none(), st.floats(1.0, 81.0))


@given(PERMITTIVITY, PERMITTIVITY, st.booleans())
def test_another_permittivity_is_used_once_it_is_in_the_log_and_else_its_loss_is_said(
    planned, entered, is_stored
):
    node = Requests()
    result = new_result(node)
    log = [noted("decision", soil_values(planned, TIME_US))] if planned is not None else []
    search(result, node, record=stored(log=log))
    result.set_permittivity(entered)
    result.set_permittivity(entered)
    if entered == planned:
        assert node.of("fact") == []
        return
    ((survey, kind, values),) = node.of("fact")
    assert (survey, kind, result.permittivity) == (SURVEY, Kind.DECISION, planned)
    if not is_stored:
        node.ticket("fact").fail(verbatim("the disk is full"))
        assert "the disk is full" in str(notices(result)[0])
        assert result.permittivity == planned and result.image is not None
        return
    node.ticket("fact").done(None)
    assert result.image is None
    begin_search(result, node, stored(log=[*log, noted(kind, values)]))
    assert result.permittivity == entered
    assert node.of("focus") == [(SURVEY,)] * 2
    assert (str(soil_lines(result)[1]) == "ASSUMED") is (entered is None)


def test_while_a_survey_runs_only_what_is_known_is_shown_and_late_answers_change_nothing(
    result, node
):
    result.latest_id = SURVEY
    result.note_running(True)
    result.open(SURVEY)
    result.keep()
    assert node.asked == [] and result.waits
    result.latest_id = PAST
    begin_search(result, node)
    assert node.of("focus") == [(SURVEY, True)] and result.waits
    known = image_of(candidate_list(ELEVEN, survey_id=SURVEY))
    node.ticket("focus").done(known)
    assert result.image is known and not result.waits
    result.choose_target(Targets.PMN)
    assert not node.of("hide")
    result.try_again()
    begin_search(result, node)
    node.ticket("focus").fail(verbatim("not searched yet"))
    assert result.waits
    result.note_running(False)
    begin_search(result, node)
    late = node.ticket("focus")
    assert node.of("focus")[-1] == (SURVEY,)
    result.note_running(True)
    assert node.cancelled == [late.request_id]
    late.done(known)
    assert result.image is None and result.places == ()


def test_the_answer_for_another_survey_is_refused(result, node):
    begin_search(result, node)
    node.ticket("focus").done(image_of(candidate_list(ELEVEN, survey_id=PAST)))
    assert result.search.problem == OTHER_SURVEY and result.places == ()
    search(new := new_result(node), node)
    new.choose_target(Targets.PMN)
    node.ticket("hide").done(a_map([[[6]]], [[[6]]], survey_id=PAST))
    assert new.hiding.problem == OTHER_SURVEY


def test_where_a_mine_could_hide_is_kept_for_all_pages_until_the_permittivity_changes(result, node):
    search(result, node)
    result.choose_target(Targets.FRAGMENT)
    found = a_map([[[6, 0]]], [[[6, 6]]], survey_id=SURVEY)
    node.ticket("hide").done(found)
    assert result._imaging.pictures.hiding(SURVEY) is found is result.hiding.result
    result.set_permittivity(8.0)
    node.ticket("fact").done(None)
    assert result.hiding.result is None and result._imaging.pictures.hiding(SURVEY) is None


def test_how_much_was_measured_is_said_unless_it_is_all(node):
    for count, outcome, text in (
        *((7, "stopped", "STOPPED: 7 of 40 traces"), (39, "finished", "INCOMPLETE: 39")),
        (40, "", None),
    ):
        search(result := new_result(node), node, record=stored(count, outcome=outcome))
        said = measured(result)
        assert said is text is None or text in str(said)
    # And what of it cannot be read.
    begin_search(another := new_result(node), node)
    found = candidate_list(ELEVEN, survey_id=SURVEY)
    node.ticket("focus").done(image_of(found, traces=PLANNED - 3))
    assert "3 of 40" in str(measured(another))


def test_an_entry_that_cannot_be_read_is_counted_and_hides_no_place(result, node):
    search(result, node, record=stored(log=[noted("found", {"format": FOUND})]))
    assert result.record.unreadable == 1 and len(result.places) == len(ELEVEN)
    assert "1 entries" in str(notices(result)[0])


def test_what_was_found_is_stored_with_the_sum_of_its_list_and_said_of_no_neighbour(result, node):
    places = [(140.0, 90.0), (150.0, 90.0), (140.0, 90.0, 110.0)]
    places = [candidate(number, *place) for number, place in enumerate(places, 1)]
    found = search(result, node, places)
    assert result.find_at(places[0]) is None
    with pytest.raises(InvalidValueError):
        result.note_found(places[0], What.DEVICE, -1.0, "Ana")
    result.note_found(places[0], What.SCRAP, 35.0, "Ana")
    ((survey, kind, values),) = node.of("fact")
    assert (survey, kind) == (SURVEY, Kind.FOUND)
    node.ticket("fact").done(None)
    node.ticket("read").done(stored(log=[noted("found", values)]))
    record = found_of(values)
    assert (record.what, record.candidate, record.depth_mm) == (What.SCRAP, "C01", 35.0)
    assert record.list_sha256 == list_sum(found) == list_sum(list_from(json_text(found)))
    assert [result.find_at(one) for one in places] == [record, None, None]
    assert len(node.of("focus")) == 1
    # In another list it is seen beside its place.
    result.set_permittivity(8.0)
    node.ticket("fact").done(None)
    log = [noted("found", record.values()), noted("decision", soil_values(8.0, TIME_US))]
    begin_search(result, node, stored(log=log))
    moved = [candidate(1, 300.0, 300.0), candidate(2, 140.0, 90.0 + BESIDE_MM)]
    found = candidate_list(moved, survey_id=SURVEY, permittivity=8.0)
    node.ticket("focus").done(image_of(found))
    assert result.find_at(moved[0]) is None
    assert result.find_at(moved[1]) == record
