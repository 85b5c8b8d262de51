"""A trial: the plan seals the truth, candidates are matched, and its numbers cover the truth."""

import hashlib
import json
import math
import re

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from scipy.stats import binom, poisson

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.trial.plan import Lane, Mark, MarkList, Plan, read_targets
from gpr20_analysis.trial.score import score_trial
from gpr20_analysis.trial.statistics import alarm_interval, detection_interval, shown_detection
from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_survey.results.candidates import json_text

TARGETS = """target,lane,x_m,y_m,depth_m,type,diameter_m,orientation
T1,L1,0.5,0.5,0.05,PMN,0.11,flat
T2,L1,2.5,0.5,0.10,PMN,0.11,
T3,L2,0.5,0.5,0.05,TS-50,0.09,flat
T4,L2,3.98,0.98,0.10,TS-50,,
"""
LANE_MAP = {
    name: Lane(0.0, 4.0, 0.0, 1.0, {"soil": soil})
    for name, soil in (("L1", "sand"), ("L2", "loam"))
}
PLAN = Plan(0.1, "", LANE_MAP, ("type", "soil"))
TARGET_LIST = read_targets(TARGETS.encode(), "targets.csv", PLAN)
# What no output of a trial ever calls ground, in English and Spanish.
NEVER = re.compile(
    r"\b(clear(ed|ance|s)?|free(d|ly)?|safe(ly|ty)?|libres?|segur[oa]s?|despejad[oa]s?)\b", re.I
)


def marks(places, lane="L1", method="radar", weaker=(), area_m2=4.0):
    found = [Mark(f"C{at}", *one, 20.0 - at, at in weaker) for at, one in enumerate(places)]
    return MarkList(method, lane, tuple(found), area_m2)


def score(*lists):
    return score_trial(PLAN, TARGET_LIST, lists)


def found(lane):
    return [name for name, mark in lane.found.items() if mark]


def group(result, stratum="", method="radar"):
    (own,) = [one for one in result.groups if (one.stratum, one.method) == (stratum, method)]
    return own


def test_a_candidate_counts_for_the_nearest_target_only_and_each_target_once():
    result = score(marks([(0.5, 0.5), (0.55, 0.5), (0.5, 0.41), (2.5, 0.601), (1.5, 0.5)]))
    assert (group(result).found, group(result).targets, group(result).alarms) == (1, 2, 2)
    assert found(result.lanes[0]) == ["T1"]
    near = TARGETS.replace("T2,L1,2.5", "T2,L1,0.6")
    targets = read_targets(near.encode(), "t", PLAN)
    (lane,) = score_trial(PLAN, targets, [marks([(0.54, 0.5)])]).lanes
    assert found(lane) == ["T1"] and not lane.alarms


def test_candidates_outside_the_lane_are_listed_and_count_only_in_a_halo():
    (lane,) = score(marks([(4.03, 1.0), (4.5, 0.5), (-1.0, -1.0)], "L2")).lanes
    assert found(lane) == ["T4"] and not lane.alarms
    assert [one.id for one in lane.outside] == ["C1", "C2"]


def test_weaker_echoes_count_only_in_the_curve_which_goes_from_the_most_certain_to_the_last():
    places = [(0.5, 0.5), (2.5, 0.5), (1.5, 0.1), (0.51, 0.5)]
    own = group(score(marks(places, weaker=(1, 2, 3))))
    assert (own.found, own.alarms) == (1, 0)
    assert [share for _, share in own.curve] == [0.0, 0.5, 1.0, 1.0] and own.curve[-1][0] > 0.0
    result = score(marks([(1.5, 0.1), (0.5, 0.5), (1.7, 0.1), (2.5, 0.5)]))
    alarms, shares = zip(*group(result).curve)
    assert shares == (0, 0, 0.5, 0.5, 1)
    area_m2 = result.lanes[0].area_m2
    assert [one * area_m2 for one in alarms] == pytest.approx([0, 1, 1, 2, 2])
    assert group(result).curve[-1] == (group(result).alarms_per_m2, group(result).detection)


def test_a_stratum_of_lanes_has_their_ground_and_one_of_targets_that_of_all():
    result = score(marks([(0.5, 0.5), (1.5, 0.5)]), marks([(0.5, 0.5)], "L2"))
    assert {(one.stratum, one.found, one.targets, one.alarms) for one in result.groups} == {
        ("", 2, 4, 1), ("type PMN", 1, 2, 1), ("type TS-50", 1, 2, 1),
        ("soil sand", 1, 2, 1), ("soil loam", 1, 2, 0),
    }  # fmt: skip
    lanes = [one.area_m2 for one in result.lanes]
    assert group(result, "soil sand").area_m2 == lanes[0]
    assert group(result, "type PMN").area_m2 == sum(lanes)


@each_case("other", ["L1", "L7"])
def test_a_second_list_for_one_lane_and_a_lane_of_no_plan_are_refused(other):
    with pytest.raises(AnalysisError, match=other):
        score(marks([]), marks([(1.0, 1.0)], other))


@pytest.fixture
def trial(tmp_path):
    """Return a function that scores lists in a folder by the command."""
    truth, plan = tmp_path / "targets.csv", tmp_path / "plan.yaml"
    truth.write_text(TARGETS)
    sealed = hashlib.sha256(truth.read_bytes()).hexdigest()
    lanes = {name: dict(vars(one)) for name, one in LANE_MAP.items()}
    values = {"halo_m": 0.1, "truth_sha256": sealed, "strata": ["type", "soil"], "lanes": lanes}
    plan.write_text(json.dumps(values))  # JSON is YAML
    for name, places in (("L1", "C1,0.5,0.5\nC2,1.5,0.5\n"), ("L2", "C1,0.5,0.45\n")):
        (tmp_path / f"{name}.csv").write_text("id,x_m,y_m\n" + places)

    def run(*options, lists=(("radar", "L1", "L1.csv"), ("radar", "L2", "L2.csv"))):
        given = [part for one in lists for part in ("--list", *one[:2], str(tmp_path / one[2]))]
        return main(["trial", str(plan), "--truth", str(truth), *given, *options])

    return run


def test_the_command_scores_and_refuses_a_truth_that_is_not_the_one_of_the_plan(
    trial, tmp_path, capsys, refusals
):
    report = tmp_path / "report.json"
    assert trial("-o", str(report)) == 0
    values = json.loads(report.read_text())
    first = values["groups"][0]
    assert (first["targets"], first["found"], first["alarms"]) == (4, 2, 1)
    assert first["detection_range"] == pytest.approx([0.0676, 0.9324], abs=1e-4)
    assert "2/4" in capsys.readouterr().out
    truth = tmp_path / "targets.csv"
    content = truth.read_bytes()
    for changed in (content + b"\n", content.replace(b"0.5,", b"0.50,", 1), content[:-1], b""):
        truth.write_bytes(changed)
        assert trial("-o", str(report), "--overwrite") == 3
    assert refusals == [faults.FILE_DAMAGED.code] * 4 and json.loads(report.read_text()) == values
    truth.write_bytes(content)
    for wrong in ("halo_m: 0", "halo_m: [", "1"):
        (tmp_path / "plan.yaml").write_text(wrong)
        assert trial() == 3


def test_a_list_of_gpr20_says_simulated_and_how_much_of_the_lane_it_is_of(trial, tmp_path, capsys):
    found = candidate_list([candidate(1, 500.0, 500.0), candidate(2, 2500.0, 500.0)])
    (tmp_path / "list.json").write_text(json_text(found), encoding="utf-8")
    assert trial(lists=[("radar", "L1", "list.json")]) == 0
    said = capsys.readouterr().out
    assert "SIMULATED" in said and "surveyed only 0.25 m2 of lane L1" in said
    assert not NEVER.search(said)
    (tmp_path / "mm.csv").write_text("id,x_m,y_m\nC1,50,40\n")
    assert trial(lists=[("radar", "L1", "mm.csv")]) == 0
    assert "no place of radar is in lane L1" in capsys.readouterr().out
    (tmp_path / "list.json").write_text('{"format": "other"}')
    for wrong in ("list.json", "."):
        assert trial(lists=[("radar", "L1", wrong)]) == 3


@settings(max_examples=draws(15))
@given(st.floats(-0.3, 4.3), st.floats(-0.3, 1.3), st.floats(0.01, 1.5))
def test_the_area_outside_a_halo_is_that_of_thin_slices_and_counted_once(x_m, y_m, radius_m):
    slices_m = (np.arange(20_000) + 0.5) * 4.0 / 20_000
    half_m = np.sqrt(np.maximum(radius_m**2 - (slices_m - x_m) ** 2, 0.0))
    covered_m = np.clip(y_m + half_m, 0.0, 1.0) - np.clip(y_m - half_m, 0.0, 1.0)
    area_m2 = LANE_MAP["L1"].area_outside([(x_m, y_m)], radius_m)
    assert area_m2 == pytest.approx(4.0 * (1.0 - covered_m.mean()), abs=2e-3)
    assert LANE_MAP["L1"].area_outside([(x_m, y_m)] * 2, radius_m) == area_m2


@each_case(
    "old, new, said",
    [
        ("T2,L1", "T1,L1", ("line 3", "two rows", "'T1'")),
        ("T2,L1", "T2,L9", ("T2", "L9", "L1, L2")),
        ("T2,L1,2.5", "T2,L1,4.5", ("T2", "not in its lane, L1")),
        ("T2,L1,2.5", "T2,L1,2.5.0", ("line 3", "'2.5.0'", "x_m", "a number")),
        ("0.5,0.10,PMN", "0.5,-1,PMN", ("line 3", "-1", "depth_m", "between 0 and 10")),
        ("T2,L1,2.5,0.5,0.10,PMN,0.11,", "T2,L1,2.5,0.5,0.10", ("line 3", "a cell for each")),
        ("0.11,\n", "0.11,,,\n", ("line 3", "a cell for each")),
        ("depth_m", "x_m", ("line 1", "each column once", "depth_m")),
        ("T3", '"T3', ("CSV",)),
        ("T2", "\udcd1", ("CSV in UTF-8",)),
    ],
)
def test_a_bad_cell_is_named_with_file_line_value_and_what_is_allowed(old, new, said):
    table = TARGETS.replace(old, new, 1).encode("utf-8", "surrogateescape")
    with pytest.raises(Gpr20Error, match=r"targets\.csv") as caught:
        read_targets(table, "targets.csv", PLAN)
    text = str(caught.value)
    assert all(one in text for one in said), text


def test_a_spreadsheet_with_decimal_commas_is_read_and_exchanged_ends_are_refused():
    table = TARGETS.replace(",", ";").replace(".", ",").replace("\n", "\r\n").encode("utf-8-sig")
    places = [one.place_m for one in read_targets(table, "t", PLAN)]
    assert places == [one.place_m for one in TARGET_LIST]
    with pytest.raises(InvalidValueError, match="x_max_m is 0 m; .* between 4.01 and"):
        Lane(4.0, 0.0, 0.0, 1.0)


CELLS = st.one_of(
    st.text(max_size=8),
    st.floats().map(str),
    st.sampled_from(["T1", "L1", "1e999", "-0", "=1+1", '"', "\0", "٣", "1_0", "inf", "0x1"]),
)


@settings(max_examples=draws(50))
@given(st.lists(st.lists(CELLS, min_size=1, max_size=10), max_size=5), st.sampled_from(",;\t"))
def test_any_table_is_read_or_refused_with_a_sentence(rows, comma):
    heading = TARGETS.splitlines()[0].replace(",", comma)
    content = "\n".join([heading, *(comma.join(one) for one in rows)])
    try:
        targets = read_targets(content.encode("utf-8", "replace"), "targets.csv", PLAN)
    except Gpr20Error as error:
        assert "targets.csv" in str(error)
    else:
        assert all(LANE_MAP[one.lane].contains(one.place_m) for one in targets)


OUTSIDE, EXACT = 0.025, 1e-9


@each_case(
    "found, targets, published",
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


def test_what_is_shown_is_the_one_sided_limit_of_95_percent():
    for detection, missed, needed in ((0.90, 0, 29), (0.95, 0, 59), (0.99, 1, 473)):
        for targets, shows in ((needed, True), (needed - 1, False)):
            assert (shown_detection(targets - missed, targets) >= detection) is shows
