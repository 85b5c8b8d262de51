"""A list of candidates is taken only if every value of it is right."""

import copy
import json
import random

import pytest
from view_kit import SURVEY

from gpr20_common.errors import InvalidValueError
from gpr20_user_interface.mid.candidate_list import candidates_from

CANDIDATE = {
    "id": "C01",
    "x_m": 0.174,
    "y_m": 0.182,
    "depth_m": 0.113,
    "x_uncertainty_m": 0.004,
    "y_uncertainty_m": 0.004,
    "depth_uncertainty_m": 0.006,
    "above_noise_db": 31.0,
    "false_alarm_probability": 1e-9,
    "rotations_deg": [0.0, 90.0],
    "polarization_ratio_db": -0.1,
    "flags": ["edge", "one-polarization"],
    "confidence": 1.0,
}
LIST = {
    "format": "gpr20-candidates/1",
    "warning": "no clearance",
    "simulated": True,
    "survey_id": SURVEY,
    "method": "phase-shift",
    "permittivity": 5.0,
    "listed": 2,
    "omitted": 3,
    "omitted_primary": 1,
    "candidates": [CANDIDATE, {**CANDIDATE, "id": "C02", "flags": [], "above_noise_db": None}],
}
NEEDED = (
    *("format", "warning", "simulated", "survey_id", "permittivity", "listed", "omitted"),
    *("omitted_primary", "candidates"),
)
OMITTED = ("omitted", "omitted_primary")
NEEDED_OF_EACH = (
    *("id", "x_m", "y_m", "depth_m", "x_uncertainty_m", "y_uncertainty_m", "depth_uncertainty_m"),
    *("above_noise_db", "false_alarm_probability", "flags"),
)
WRONG = (None, "", "x", -1, -1.0, 7, 1e400, float("nan"), [], {}, ["other"], [1], True)


def changed(name, value, of_each=False):
    values = copy.deepcopy(LIST)
    (values["candidates"][0] if of_each else values)[name] = value
    return json.dumps(values)


def test_a_list_is_taken():
    found = candidates_from(json.dumps(LIST), SURVEY)
    assert found.simulated and found.omitted == 3 and found.permittivity == 5.0
    first, second = found.candidates
    assert (first.id, first.x_m, first.depth_uncertainty_m) == ("C01", 0.174, 0.006)
    assert [str(one) for one in first.flags] == ["edge", "one polarization"]
    assert second.above_noise_db is None and not second.flags


def test_all_that_are_not_doubtful_are_shown_and_ten_of_the_others():
    flags = [[]] * 15 + [["edge"]] + [["sidelobe"]] * 8 + [["edge", "clutter"]] * 26
    candidates = [{**CANDIDATE, "id": str(n), "flags": one} for n, one in enumerate(flags)]
    values = {**LIST, "listed": 50, "omitted": 4, "omitted_primary": 0, "candidates": candidates}
    found = candidates_from(json.dumps(values), SURVEY)
    assert [one.id for one in found.shown] == [str(number) for number in range(26)]
    assert (found.primary, found.total) == (16, 54)


@pytest.mark.parametrize("name", NEEDED)
def test_a_list_without_something_is_refused(name):
    values = {key: value for key, value in LIST.items() if key != name}
    with pytest.raises(InvalidValueError):
        candidates_from(json.dumps(values), SURVEY)


@pytest.mark.parametrize("name", NEEDED_OF_EACH)
def test_a_candidate_without_something_is_refused(name):
    values = copy.deepcopy(LIST)
    del values["candidates"][1][name]
    with pytest.raises(InvalidValueError):
        candidates_from(json.dumps(values), SURVEY)


@pytest.mark.parametrize(
    "name, right",
    [
        *((name, ()) for name in NEEDED if name not in ("warning", "permittivity", *OMITTED)),
        ("warning", ("x",)),
        ("permittivity", (7,)),
        *((name, (7,)) for name in OMITTED),
    ],
)
def test_a_wrong_value_is_refused(name, right):
    for value in WRONG:
        if value in right or value is LIST[name]:
            continue
        with pytest.raises(InvalidValueError):
            candidates_from(changed(name, value), SURVEY)


@pytest.mark.parametrize("name", NEEDED_OF_EACH)
def test_a_wrong_value_of_a_candidate_is_refused(name):
    for value in ("", -1e400, float("nan"), {}, ["other"], True):
        with pytest.raises(InvalidValueError):
            candidates_from(changed(name, value, of_each=True), SURVEY)


def test_the_list_of_another_survey_is_refused():
    with pytest.raises(InvalidValueError):
        candidates_from(json.dumps(LIST), "another")


def test_a_list_that_was_cut_off_is_refused():
    text = json.dumps(LIST)
    for length in random.Random(1).sample(range(len(text)), 100):
        with pytest.raises(InvalidValueError):
            candidates_from(text[:length], SURVEY)
