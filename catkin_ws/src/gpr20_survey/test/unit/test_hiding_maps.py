"""The map of where a target could hide, as data and as JSON; targets by their names."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hiding_kit import a_map
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import InvalidValueError
from gpr20_survey.results.area_position import AreaPosition
from gpr20_survey.results.hidden_target import Target, Targets, target_of
from gpr20_survey.results.hiding_map import ONLY_THIS, hiding_from, hiding_json


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


def test_where_none_was_tried_one_could_hide():
    found = a_map([[[6, 0]]], [[[6, 0]]])
    assert np.isnan(found.missed_m[0, 0]) and found.missed_m[0, 1] == 0.02
    assert "found down to 20 mm" in str(found.at(0.0, 0.0))
    assert "could hide from 20 mm on" in str(found.at(0.2, 0.0))


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


@given(st.text())
def test_any_text_is_a_map_or_refused(text):
    with pytest.raises(InvalidValueError):
        hiding_from(text)


def test_targets_have_names_and_sizes():
    assert target_of("pmn") == Targets.PMN.value
    assert target_of("disc:80:35:2.8") == Target("disc:80:35:2.8", 0.08, 0.035, 2.8)
    assert target_of("ball:20").is_metal and not target_of("type-72").is_metal


@pytest.mark.parametrize(
    "text",
    ["", "PMN", "disc", "disc:80:35", "disc:80:35:0.5", "disc:0:35:2.8", "disc:80:500:2.8",
     "ball:nan", "ball:-5", "ball:1:2", "disc:80:35:x", "disc:80:35:101"],
)  # fmt: skip
def test_other_targets_are_refused_with_what_is_allowed(text):
    with pytest.raises(InvalidValueError, match="allowed|use pmn"):
        target_of(text)
