"""Tables of a trial, matching of candidates, area outside halos, strata, and intervals."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from run_seed import draws
from scipy.stats import binom, poisson
from trial_kit import HALO_M, LANES, TARGETS

from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_analysis.report.trial_report import warnings_of
from gpr20_analysis.trial import ground
from gpr20_analysis.trial.documents import Mark, Plan, Seal
from gpr20_analysis.trial.ground import Lane, Target, read_lanes, read_targets
from gpr20_analysis.trial.score import score_trial
from gpr20_analysis.trial.statistics import (
    alarm_interval,
    detection_interval,
    mcnemar,
    shown_detection,
    targets_needed,
)
from gpr20_common.errors import InvalidValueError

LANE_MAP = read_lanes(LANES.encode(), "lanes.csv")
TARGET_LIST = read_targets(TARGETS.encode(), "targets.csv", LANE_MAP)
RECTANGLE = Lane({}, "L", 0.0, 4.0, 0.0, 1.0)


def plan(strata=("type", "soil")):
    return Plan(HALO_M, strata, LANE_MAP, sha256="p")


def seal(places, lane="L1", method="radar", doubtful=(), area_m2=4.0, own=None):
    own = own or f"{method} {lane}"
    marks = [Mark(f"C{at}", *one, 20.0 - at, at in doubtful) for at, one in enumerate(places)]
    return Seal(tuple(marks), own, area_m2=area_m2, plan_sha256="p", lane=lane, method=method)


def score(*seals):
    return score_trial(plan(), TARGET_LIST, seals)


def found(lane):
    return [name for name, mark in lane.found.items() if mark]


def group(result, stratum="", method="radar"):
    (own,) = [one for one in result.groups if (one.stratum, one.method) == (stratum, method)]
    return own


def test_a_target_is_found_once_by_any_number_of_candidates_in_its_halo():
    result = score(seal([(0.5, 0.5), (0.55, 0.5), (0.5, 0.41), (2.5, 0.601), (1.5, 0.5)]))
    assert (group(result).found, group(result).targets, group(result).alarms) == (1, 2, 2)
    assert found(result.lanes[0]) == ["T1"]


def test_a_candidate_counts_for_the_nearest_target_only():
    near = TARGETS.replace("T2,L1,2.5", "T2,L1,0.6")
    targets = read_targets(near.encode(), "t", LANE_MAP)
    (lane,) = score_trial(plan(), targets, [seal([(0.54, 0.5)])]).lanes
    assert found(lane) == ["T1"] and not lane.alarms


def test_candidates_outside_the_lane_are_listed_and_count_only_in_a_halo():
    (lane,) = score(seal([(4.03, 1.0), (4.5, 0.5), (-1.0, -1.0)], "L2")).lanes
    assert found(lane) == ["T4"] and not lane.alarms
    assert [one.id for one in lane.outside] == ["C1", "C2"]


def test_doubtful_candidates_count_only_in_the_curve():
    doubtful = seal([(0.5, 0.5), (2.5, 0.5), (1.5, 0.1)], doubtful=(1, 2))
    own = group(score(doubtful))
    assert (own.found, own.alarms) == (1, 0)
    assert [share for _, share in own.curve] == [0.0, 0.5, 1.0, 1.0] and own.curve[-1][0] > 0.0


def test_the_curve_goes_from_the_most_certain_candidate_to_the_last():
    (lane,) = (result := score(seal([(1.5, 0.1), (0.5, 0.5), (1.7, 0.1), (2.5, 0.5)]))).lanes
    area_m2 = lane.area_m2
    alarms, shares = zip(*group(result).curve)
    assert shares == (0, 0, 0.5, 0.5, 1)
    assert [one * area_m2 for one in alarms] == pytest.approx([0, 1, 1, 2, 2])
    assert group(result).curve[-1] == (group(result).alarms_per_m2, group(result).detection)


def test_a_stratum_of_lanes_has_their_ground_and_one_of_targets_that_of_all():
    result = score(seal([(0.5, 0.5), (1.5, 0.5)]), seal([(0.5, 0.5)], "L2"))
    assert {(one.stratum, one.found, one.targets, one.alarms) for one in result.groups} == {
        ("", 2, 4, 1), ("type PMN", 1, 2, 1), ("type TS-50", 1, 2, 1),
        ("soil sand", 1, 2, 1), ("soil loam", 1, 2, 0),
    }  # fmt: skip
    lanes = [one.area_m2 for one in result.lanes]
    assert group(result, "soil sand").area_m2 == lanes[0]
    assert group(result, "type PMN").area_m2 == sum(lanes)
    blank = Lane({"soil": "gravel"}, "L3", 0.0, 2.0, 0.0, 1.0)
    of_three = Plan(HALO_M, ("soil",), {**LANE_MAP, "L3": blank}, sha256="p")
    result = score_trial(of_three, TARGET_LIST, [seal([]), seal([(0.5, 0.5)], "L3")])
    own = group(result, "soil gravel")
    assert (own.targets, own.detection, own.alarms, own.alarms_per_m2) == (0, None, 1, 0.5)


def test_methods_are_compared_on_the_targets_of_both():
    result = score(
        seal([(0.5, 0.5)]), seal([(0.5, 0.5)], "L2"),
        seal([(0.5, 0.5), (2.5, 0.5)], method="detector"),
    )  # fmt: skip
    (one,) = result.comparisons
    assert (one.targets, one.only_first, one.only_second, one.p_value) == (2, 0, 1, 1.0)
    both = [seal([], lane, method) for lane in ("L1", "L2") for method in ("a", "b")]
    assert warnings_of(plan(), score(*both)) == []
    parts = warnings_of(plan(), score(seal([], area_m2=1.0), seal([], "L2", area_m2=3.9)))
    assert [one.values["lane"] for one in parts] == ["L1"]
    (warning,) = warnings_of(plan(), result)
    assert "Simpson" in warning.template
    assert (warning.values["method"], warning.values["lane"]) == ("detector", "L2")


@pytest.mark.parametrize("other", ["p2", "same"])
def test_lists_of_another_plan_and_two_for_one_lane_are_refused(other):
    second = seal([(1.0, 1.0)])
    if other != "same":
        second = Seal((), "", plan_sha256=other, lane="L1", method="detector")
    with pytest.raises(AnalysisError, match="L1"):
        score(seal([]), second)


def test_one_list_for_two_methods_is_refused_unless_nothing_was_found():
    for place in ([], [(1.0, 0.5)]):
        both = [seal(place, method=one, own="abc") for one in ("radar", "detector")]
        if place:
            with pytest.raises(AnalysisError, match="radar, L1 and .*detector, L1"):
                score(*both)
        else:
            assert len(score(*both).lanes) == 2


@settings(max_examples=draws(15))
@given(st.lists(st.tuples(st.floats(-0.3, 4.3), st.floats(-0.3, 1.3)), max_size=12),
       st.floats(0.01, 1.5))  # fmt: skip
def test_the_area_outside_halos_is_that_of_a_fine_grid(places, radius_m):
    step_m = 0.004
    x_m, y_m = np.meshgrid(np.arange(step_m / 2, 4, step_m), np.arange(step_m / 2, 1, step_m))
    covered = np.zeros(x_m.shape, bool)
    for place in places:
        covered |= np.hypot(x_m - place[0], y_m - place[1]) <= radius_m
    expected = step_m**2 * np.count_nonzero(~covered)
    # A grid errs by a part of a cell along each circle.
    border_m = 2.0 * math.pi * radius_m * len(places)
    assert RECTANGLE.area_outside(places, radius_m) == pytest.approx(
        expected, abs=border_m * step_m / 4 + 1e-5
    )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("T2,L1", "T1,L1", ("line 3", "two rows", "'T1'")),
        ("T2,L1", "T2,L9", ("T2", "L9", "L1, L2")),
        ("T2,L1,2.5", "T2,L1,4.5", ("T2", "not in its lane, L1")),
        ("T2,L1,2.5", "T2,L1,2.5.0", ("line 3", "'2.5.0'", "column x_m", "-1000 ... 1000")),
        ("0.5,0.10,PMN", "0.5,-1,PMN", ("line 3", "'-1'", "column depth_m", "0 ... 10")),
        ("T2,L1,2.5,0.5", "T2,L1,2.5", ("line 3", "as many cells")),
        ("depth_m", "x_m", ("line 1", "each column once", "depth_m")),
        ("T3", '"T3', ("CSV",)),
    ],
)
def test_a_bad_cell_is_named_with_file_line_value_and_what_is_allowed(old, new, said):
    with pytest.raises(UnreadableFileError, match=r"targets\.csv") as caught:
        read_targets(TARGETS.replace(old, new, 1).encode(), "targets.csv", LANE_MAP)
    text = str(caught.value)
    assert all(one in text for one in said), text


def test_a_lane_whose_ends_are_exchanged_and_an_empty_table_are_refused():
    with pytest.raises(InvalidValueError, match="L1: x_max_m is 0 m; .* between 4.01 and"):
        read_lanes(LANES.replace("0,4", "4,0", 1).encode(), "lanes.csv")
    with pytest.raises(UnreadableFileError, match="heading"):
        read_lanes(b"", "lanes.csv")
    # Of a spreadsheet with decimal commas.
    table = TARGETS.replace(",", ";").replace(".", ",").replace("\n", "\r\n").encode("utf-8-sig")
    places = [one.place_m for one in read_targets(table, "t", LANE_MAP)]
    assert places == [one.place_m for one in TARGET_LIST]
    with pytest.raises(UnreadableFileError, match=r"t.csv as CSV in UTF-8"):
        read_targets(TARGETS.replace("T2", "Ñ").encode("latin-1"), "t.csv", LANE_MAP)


CELLS = st.one_of(
    st.text(max_size=8),
    st.floats().map(str),
    st.sampled_from(["T1", "L1", "1e999", "-0", "=1+1", '"', "\0", "٣", "1_0", "inf", "0x1"]),
)


@settings(max_examples=draws(75))
@given(st.lists(st.lists(CELLS, min_size=1, max_size=10), max_size=5), st.sampled_from(",;\t"))
@example([["T1", "L1", "1", "٣", "0", "a", "", "", ""]], ",")
def test_any_table_is_read_or_refused_with_a_sentence(rows, comma):
    heading = TARGETS.splitlines()[0].replace(",", comma)
    content = "\n".join([heading, *(comma.join(one) for one in rows)])
    try:
        targets = read_targets(content.encode("utf-8", "replace"), "targets.csv", LANE_MAP)
    except UnreadableFileError as error:
        assert "targets.csv" in str(error)
    else:
        assert all(LANE_MAP[one.lane].contains(one.place_m) for one in targets)


OUTSIDE, EXACT = 0.025, 1e-9
TRIALS = 10_000


@pytest.mark.parametrize(
    ("found", "targets", "published"),
    [(50, 50, (0.929, 1.0)), (45, 48, (0.828, 0.987)), (0, 7, (0.0, 0.410)), (0, 0, (0.0, 1.0))],
)
def test_at_the_ends_of_an_interval_of_a_share_what_was_found_is_as_unlikely_as_asked(
    found, targets, published
):
    low, high = detection_interval(found, targets)
    assert (low, high) == pytest.approx(published, abs=6e-4)
    assert not found or binom.sf(found - 1, targets, low) == pytest.approx(OUTSIDE, abs=EXACT)
    assert found == targets or binom.cdf(found, targets, high) == pytest.approx(OUTSIDE, abs=EXACT)


def test_at_the_ends_of_an_interval_of_a_density_the_alarms_are_as_unlikely_as_asked():
    for count, area_m2, published in ((12, 200.0, (0.031, 0.105)), (0, 500.0, (0.0, 0.0074))):
        low, high = alarm_interval(count, area_m2)
        assert (low, high) == pytest.approx(published, abs=6e-4)
        assert not count or poisson.sf(count - 1, low * area_m2) == pytest.approx(
            OUTSIDE, abs=EXACT
        )
        assert poisson.cdf(count, high * area_m2) == pytest.approx(OUTSIDE, abs=EXACT)
    assert alarm_interval(3, 0.0) == (0.0, math.inf)


@pytest.mark.parametrize(
    ("detection", "missed", "needed"),
    [(0.90, 0, 29), (0.95, 0, 59), (0.99, 0, 299), (0.99, 1, 473), (0.996, 0, 748)],
)
def test_the_fewest_targets_that_show_a_detection_are_the_reference_numbers(
    detection, missed, needed
):
    assert targets_needed(detection, missed) == needed
    for targets, shows in ((needed, True), (needed - 1, False)):
        chance = binom.sf(targets - missed - 1, targets, detection)
        assert (chance <= 0.05) == shows
        assert (shown_detection(targets - missed, targets) >= detection) is shows


@pytest.mark.parametrize(("first", "second"), [(0, 0), (5, 0), (1, 9), (8, 8), (3, 17)])
def test_mcnemar_is_the_two_sided_binomial_test(first, second):
    tail = binom.cdf(min(first, second), first + second, 0.5)
    assert mcnemar(first, second) == pytest.approx(min(1.0, 2.0 * tail), abs=1e-12)


@pytest.mark.release
def test_intervals_of_the_scorer_cover_the_truth_in_95_of_100_trials(monkeypatch):
    chance, halo_m = np.random.default_rng(29), 0.1
    lane = Lane({}, "L", 0.0, 10.0, 0.0, 2.0)
    places = [(0.5 + at, 0.5) for at in range(10)]
    targets = [Target(f"T{at}", "L", one, {}) for at, one in enumerate(places)]
    trial_plan = Plan(halo_m, (), {"L": lane}, sha256="p")
    area_m2 = lane.area_outside(places, halo_m)
    assert area_m2 == pytest.approx(20.0 - 10 * math.pi * halo_m**2, abs=1e-4)
    # The targets of all trials are the same, so it is computed once.
    monkeypatch.setattr(ground.Lane, "area_outside", lambda *_: area_m2)
    hits = {"share": 0, "density": 0}
    for share, density in zip(chance.uniform(0.3, 1.0, TRIALS), chance.uniform(0.0, 0.5, TRIALS)):
        seen = [one for one in places if chance.random() < share]
        false = [(one, 1.5) for one in chance.uniform(0.0, 10.0, chance.poisson(density * area_m2))]
        marks = tuple(Mark(f"C{at}", *one, -at) for at, one in enumerate([*seen, *false]))
        (scored,) = score_trial(
            trial_plan, targets, [Seal(marks, "", plan_sha256="p", lane="L")]
        ).groups
        assert (scored.found, scored.alarms) == (len(seen), len(false))
        for name, truth, ends in (("share", share, scored.detection_range),
                                  ("density", density, scored.alarms_range)):  # fmt: skip
            hits[name] += ends[0] <= truth <= ends[1]
    assert min(hits.values()) >= 0.95 * TRIALS, hits
