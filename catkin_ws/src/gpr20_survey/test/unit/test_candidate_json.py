"""Candidates, hiding maps and verdicts are taken from JSON only if every value is right."""

import json
import random

import numpy as np
import pytest
from candidate_examples import SURVEY, candidate, candidate_list, candidate_lists
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from result_examples import a_map

from gpr20_common.errors import InvalidValueError
from gpr20_survey.plan.survey_state import reported_verdict
from gpr20_survey.results.candidates import AreaPosition, Flag, json_text, list_from
from gpr20_survey.results.hiding_map import (
    ONLY_THIS,
    Target,
    Targets,
    hiding_from,
    hiding_json,
    target_of,
)

EXAMPLE = candidate_list(
    [candidate(flags=[Flag.EDGE, Flag.ONE_POLARIZATION]), candidate(2)],
    omitted=3,
    position=AreaPosition(4.6, -74.1, 30.0),
)
LIST = json.loads(json_text(EXAMPLE))
# They say again, for people and other programs, what the others say.
SAID_AGAIN = {"simulated_warning", "coordinates"}
OF_EACH_SAID_AGAIN = {"doubtful", "longitude_deg", "latitude_deg"}
NEEDED = sorted(LIST.keys() - SAID_AGAIN - {"note_faults"})
NEEDED_OF_EACH = sorted(LIST["candidates"][0].keys() - OF_EACH_SAID_AGAIN)
MAY_BE_NONE = (
    "polarization_ratio_db",
    "position",
)
WRONG = (-1e400, float("nan"), {}, ["other"], [1], True, "")


@given(candidate_lists())
def test_a_list_comes_out_of_json_as_it_went_in(found):
    assert list_from(json_text(found), found.survey_id) == found


RIGHT = {
    "simulated": [True],
    "survey_id": [""],
    "permittivity_source": [""],
    "method": [""],
    "notes": [["other"]],
}
RIGHT = {**RIGHT, "rotations_deg": [[1]], "flags": [["other"]]}


def refused(changes, of_first):
    """Expect that a list, or its first candidate, is refused with some entries; ... is none."""
    first, *others = LIST["candidates"]
    values = {**first, **changes} if of_first else {**LIST, **changes}
    values = {name: value for name, value in values.items() if value is not ...}
    with pytest.raises(InvalidValueError):
        list_from(json.dumps({**LIST, "candidates": [values, *others]} if of_first else values))


@pytest.mark.parametrize("of_first", [False, True])
def test_a_list_without_something_or_with_a_wrong_value_is_refused(of_first):
    for name in NEEDED_OF_EACH if of_first else NEEDED:
        for value in (..., *WRONG, *(() if name in MAY_BE_NONE else (None,))):
            if value not in RIGHT.get(name, []):
                refused({name: value}, of_first)


@each_case(
    "changes",
    [
        {"listed": 1},
        {"omitted": -1},
        {"format": "gpr20-candidates/2"},
        {"candidates": [LIST["candidates"][0]] * 2},
    ],
)
def test_contradictions_are_refused(changes):
    refused(changes, False)


def test_a_list_of_another_survey_or_that_was_cut_off_is_refused():
    text = json.dumps(LIST)
    assert list_from(text, SURVEY) == EXAMPLE
    with pytest.raises(InvalidValueError):
        list_from(text, "another")
    for length in random.Random(1).sample(range(len(text)), 100):
        with pytest.raises(InvalidValueError):
            list_from(text[:length], SURVEY)


def test_places_to_check_are_shown_and_weaker_echoes_counted():
    flags = (
        [[]] * 3 + [[Flag.EDGE], [Flag.BRIGHTEST]] + [[Flag.SIDELOBE], [Flag.EDGE, Flag.CLUTTER]]
    )
    found = candidate_list([candidate(n, flags=one) for n, one in enumerate(flags, 1)], omitted=4)
    assert [one.number for one in found.shown()] == [1, 2, 3, 4, 5]
    assert (found.primary, found.weaker, found.total) == (5, 6, 11)
    words = [str(candidate(level_db=level).strength) for level in (12.0, 15.0, 25.0)]
    assert words == ["weak", "clear", "strong"]


@given(
    st.integers(1, 4).flatmap(
        lambda layers: st.lists(
            st.lists(st.integers(0, 10), min_size=6, max_size=6), min_size=layers, max_size=layers
        )
    ),
    st.floats(0.05, 1.0),
)
def test_the_missed_depth_is_the_first_at_which_too_few_were_found(counts, needed):
    found = np.array(counts).reshape(len(counts), 2, 3)
    missed_m = a_map(found, np.full(found.shape, 10), needed).missed_m
    for row, column in np.ndindex(2, 3):
        depths = [0.02 * (layer + 1) for layer in range(len(counts))
                  if found[layer, row, column] < 10 * needed]  # fmt: skip
        if depths:
            assert missed_m[row, column] == pytest.approx(depths[0])
        else:
            assert np.isnan(missed_m[row, column])


def test_a_depth_at_which_too_few_targets_were_tried_says_so():
    few, enough = a_map([[[5, 5]], [[6, 0]]], [[[5, 5]], [[6, 6]]]).details[2:4]
    assert "20 mm deep: fewer than 6 targets were tried near each place" in str(few)
    assert "40 mm deep: could hide on 50 % of the map" in str(enough)


def test_the_warning_comes_first_and_never_are_there_words_of_clearance():
    found = a_map([[[6, 0]]], [[[6, 6]]])
    assert found.sentences[0] == ONLY_THIS
    text = " ".join(str(one) for one in found.sentences).lower()
    for word in ("clear", "free", "safe"):
        assert word not in text


@pytest.mark.parametrize("position", [None, AreaPosition(4.6, -74.1, 30.0)])
def test_json_gives_the_same_map(position):
    found = a_map([[[5, 0]], [[1, 2]]], [[[5, 5]], [[4, 3]]], position=position)
    again = hiding_from(hiding_json(found))
    for name, value in vars(found).items():
        assert np.array_equal(getattr(again, name), value), name


@given(st.recursive(
    st.none() | st.booleans() | st.floats() | st.text() | st.integers(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
), st.sampled_from(sorted(json.loads(hiding_json(a_map([[[6, 0]]], [[[6, 6]]]))))))  # fmt: skip
def test_a_damaged_map_is_refused_or_read_whole(value, name):
    values = json.loads(hiding_json(a_map([[[6, 0]]], [[[6, 6]]])))
    values[name] = value
    try:
        found = hiding_from(json.dumps(values))
    except InvalidValueError:
        return
    assert found.missed_m.shape == (len(found.y_m), len(found.x_m))
    assert found.sentences


def test_targets_have_names_and_sizes():
    assert target_of("pmn") == Targets.PMN.value
    assert target_of("disc:80:35:2.8") == Target("disc:80:35:2.8", 0.08, 0.035, 2.8)
    assert target_of("ball:20").is_metal and not target_of("type-72").is_metal


@each_case("text", ["", "PMN", "disc:80:35", "disc:80:35:0.5", "disc:80:500:2.8", "ball:nan"])
def test_other_targets_are_refused_with_what_is_allowed(text):
    with pytest.raises(InvalidValueError, match="must lie between|use pmn"):
        target_of(text)


@each_case("report", [None, "m", {}, {"coverage": ""}, {"coverage": ["m"]}, {"coverage": "mx"}])
def test_a_report_without_coverage_has_no_verdict(report):
    assert reported_verdict(report) is None
