"""Records of what was found: they come back as they were written, or are refused."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import InvalidValueError
from gpr20_survey.results.found import Found, What, found_of, present

TIME = "2026-11-27T03:00:00.000000+00:00"
EXAMPLE = Found(What.SCRAP, "C03", "a" * 64, 10.0, 20.0, "Ana", TIME)
TEXT = st.text(st.characters(blacklist_categories=["Cc", "Cs", "Zl", "Zp", "Cf"]), max_size=20)
MM = st.floats(-10_000.0, 10_000.0)
DEPTH = st.none() | st.floats(0.0, 10_000.0)


@given(st.sampled_from(What), MM, MM, TEXT.filter(bool), DEPTH, TEXT)
def test_any_record_comes_back_from_json(what, x_mm, y_mm, who, depth_mm, notes):
    one = Found(what, "C01", "b" * 64, x_mm, y_mm, who, TIME, depth_mm, "", notes)
    assert found_of(json.loads(json.dumps(one.values()))) == one


@given(st.dictionaries(st.sampled_from([*list(EXAMPLE.values())[1:], "more"]),
                       st.none() | st.booleans() | st.floats() | st.text(max_size=4)
                       | st.lists(st.integers(), max_size=1)))  # fmt: skip
def test_values_of_any_kind_are_a_record_or_refused(changes):
    try:
        one = found_of({**EXAMPLE.values(), **changes})
    except InvalidValueError:
        return
    assert one.values() == {**EXAMPLE.values(), **changes}


@pytest.mark.parametrize(
    "change",
    [
        {"who": ""}, {"who": "a\nb"}, {"who": "\u202eAna"}, {"notes": "x" * 501},
        {"x_mm": float("nan")}, {"y_mm": 1e5}, {"depth_mm": -1.0}, {"candidate": "3"},
        {"list_sha256": "A" * 64}, {"photo": "../../etc/passwd"}, {"photo": "a" * 64 + ".exe"},
        {"time": "yesterday"},
    ],
)  # fmt: skip
def test_a_value_that_is_not_allowed_is_refused(change):
    with pytest.raises(InvalidValueError):
        replace(EXAMPLE, **change)


def test_a_later_record_replaces_one_of_the_same_candidate_of_the_same_list_only():
    later = replace(EXAMPLE, what=What.DEVICE)
    other_list = replace(EXAMPLE, list_sha256="b" * 64)
    other = replace(EXAMPLE, candidate="C04")
    assert present([EXAMPLE, other_list, other, later]) == [later, other_list, other]
