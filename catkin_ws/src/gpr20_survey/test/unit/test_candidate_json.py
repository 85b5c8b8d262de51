"""A list of candidates is taken from JSON or a message only if every value of it is right."""

import json
import random

import pytest
from candidate_examples import SURVEY, candidate, candidate_list, candidate_lists
from case_kit import each_case
from hypothesis import given

from gpr20_common.errors import InvalidValueError
from gpr20_survey.results.area_position import AreaPosition
from gpr20_survey.results.candidate_json import json_text, list_from
from gpr20_survey.results.candidates import Flag, UnknownFlag

EXAMPLE = candidate_list(
    [candidate(flags=[Flag.EDGE, Flag.ONE_POLARIZATION]), candidate(2)],
    omitted=3,
    omitted_primary=1,
    position=AreaPosition(4.6, -74.1, 30.0),
)
LIST = json.loads(json_text(EXAMPLE))
# They say again, for people and other programs, what the others say.
SAID_AGAIN = {"simulated_warning", "coordinates"}
OF_EACH_SAID_AGAIN = {"doubtful", "longitude_deg", "latitude_deg"}
# Lists of earlier versions are without it.
LATER = "permittivity_source"
NEEDED = sorted(LIST.keys() - SAID_AGAIN - {LATER})
NEEDED_OF_EACH = sorted(LIST["candidates"][0].keys() - OF_EACH_SAID_AGAIN)
MAY_BE_NONE = (
    "false_alarms_per_m2",
    "false_alarms_lowest",
    "false_alarms_highest",
    "polarization_ratio_db",
    "position",
)
WRONG = (-1e400, float("nan"), {}, ["other"], [1], True, "")
RIGHT = {"simulated": [True], "survey_id": [""], "method": [""], "notes": [["other"]]}
RIGHT_OF_EACH = {"rotations_deg": [[1]], "flags": [["other"]]}


@given(candidate_lists())
def test_a_list_comes_out_of_json_as_it_went_in(found):
    # By its text, because NaN is not equal to itself.
    assert repr(list_from(json_text(found), found.survey_id)) == repr(found)


@each_case("name", NEEDED)
def test_a_list_without_something_is_refused(name):
    with pytest.raises(InvalidValueError):
        list_from(json.dumps({key: value for key, value in LIST.items() if key != name}))


def test_a_list_of_an_earlier_version_does_not_say_where_its_permittivity_is_from():
    former = {key: value for key, value in LIST.items() if key != LATER}
    assert list_from(json.dumps(former)).permittivity_source == ""
    with pytest.raises(InvalidValueError):
        list_from(json.dumps({**LIST, LATER: 4}))


@each_case("name", NEEDED_OF_EACH)
def test_a_candidate_without_something_is_refused(name):
    first = {key: value for key, value in LIST["candidates"][0].items() if key != name}
    with pytest.raises(InvalidValueError):
        list_from(json.dumps({**LIST, "candidates": [first, LIST["candidates"][1]]}))


@each_case("name", NEEDED)
def test_a_wrong_value_is_refused(name):
    for value in (*WRONG, *(() if name in MAY_BE_NONE else (None,))):
        if value not in RIGHT.get(name, []):
            with pytest.raises(InvalidValueError, match="not complete or not valid"):
                list_from(json.dumps({**LIST, name: value}))


@each_case("name", NEEDED_OF_EACH)
def test_a_wrong_value_of_a_candidate_is_refused(name):
    for value in (*WRONG, *(() if name in MAY_BE_NONE else (None,))):
        if value not in RIGHT_OF_EACH.get(name, []):
            first = {**LIST["candidates"][0], name: value}
            with pytest.raises(InvalidValueError):
                list_from(json.dumps({**LIST, "candidates": [first, LIST["candidates"][1]]}))


@each_case(
    "changes",
    [
        {"listed": 1},
        {"omitted": 0},
        {"format": "gpr20-candidates/1"},
        {"candidates": [LIST["candidates"][0]] * 2},
    ],
)
def test_contradictions_are_refused(changes):
    with pytest.raises(InvalidValueError):
        list_from(json.dumps({**LIST, **changes}))


def test_the_list_of_another_survey_is_refused():
    assert list_from(json.dumps(LIST), SURVEY) == EXAMPLE
    with pytest.raises(InvalidValueError):
        list_from(json.dumps(LIST), "another")


def test_a_list_that_was_cut_off_is_refused():
    text = json.dumps(LIST)
    for length in random.Random(1).sample(range(len(text)), 100):
        with pytest.raises(InvalidValueError):
            list_from(text[:length], SURVEY)


def test_a_candidate_with_a_flag_of_a_later_version_is_kept_and_not_doubtful():
    first = {**LIST["candidates"][0], "flags": ["edge", "buried-twice"], "doubtful": True}
    found = list_from(json.dumps({**LIST, "candidates": [first, LIST["candidates"][1]]}))
    one = found.shown()[0]
    assert one.flags == (Flag.EDGE, UnknownFlag("buried-twice")) and not one.is_doubtful
    assert [str(label) for label in one.labels] == ["edge", "buried-twice"]


def test_all_that_are_not_doubtful_are_shown_and_ten_of_the_others():
    flags = [[]] * 15 + [[Flag.EDGE]] + [[Flag.SIDELOBE]] * 8 + [[Flag.EDGE, Flag.CLUTTER]] * 26
    found = candidate_list([candidate(n, flags=one) for n, one in enumerate(flags, 1)], omitted=4)
    assert [one.number for one in found.shown()] == list(range(1, 27))
    assert (found.primary, found.total) == (16, 54)
    assert found.shown(None) == found.candidates


def test_none_that_is_not_doubtful_is_hidden_whatever_the_order():
    found = [candidate(n, flags=[Flag.CLUTTER]) for n in range(1, 31)] + [candidate(31)]
    assert candidate_list(found).shown()[-1].number == 31
