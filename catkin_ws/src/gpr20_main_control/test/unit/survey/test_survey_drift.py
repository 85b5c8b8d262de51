"""A survey returns to its first stop to see how it drifts, and pauses if it drifts too far."""

from __future__ import annotations

import json
import math
import threading
from dataclasses import replace

import numpy as np
import pytest
from cut_off_surveys import reopened_survey, stored_trace
from survey_examples import AXES, PARAMETERS

from gpr20_main_control import faults
from gpr20_main_control.mid.survey.repeats import MAX_FREQUENCIES, DriftLimits, Repeated
from gpr20_main_control.mid.survey.survey_plan import plan_survey
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.robot_description import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState as State

INTERVAL_S = 12.0
CONFIG = RobotConfig(AXES, simulated=True)
PLAN = plan_survey(PARAMETERS, CONFIG, SurveySettings(0.0, reference_interval_s=INTERVAL_S))
# The sweeps of a visit: two at each of two rotations.
SWEEPS = 4


@pytest.fixture
def visiting(make_bench):
    return make_bench(reference_interval_s=INTERVAL_S)


def louder(bench, factor=1.5):
    return lambda: setattr(bench.analyzer, "level", bench.analyzer.level * factor)


def visits(bench):
    return [one.values for one in bench.storage.notes if one.kind is Kind.DRIFT]


def marks(bench):
    return [(one["next_index"], one["exceeded"], one["accepted"]) for one in visits(bench)]


def test_a_survey_visits_its_first_stop_at_the_interval_and_at_its_end(visiting):
    assert len(PLAN.visits) > 2 and PLAN.visits[-1] == 24
    places = []
    visiting.analyzer.on_sweep = lambda: places.append(
        tuple(axis.coordinate for axis in visiting.axes)
    )
    visiting.start()
    visiting.complete()
    assert [one["next_index"] for one in visits(visiting)] == list(PLAN.visits)
    assert visiting.analyzer.sweeps == 24 + SWEEPS * len(PLAN.visits)
    for point in PLAN.points[:2]:
        place = (point.x_mm, point.y_mm, point.z_deg)
        assert places.count(place) == 1 + SWEEPS // 2 * len(PLAN.visits)
    for visit in visits(visiting):
        assert [one["index"] for one in visit["rotations"]] == [0, 1]
        for rotation in visit["rotations"]:
            assert rotation["amplitude_rms_db"] < 0.001 and rotation["phase_rms_deg"] < 1.0
            assert len(rotation["amplitude_db"]) == len(rotation["phase_deg"]) == 5
            # Each of these sweeps differs from the one before by 1, of 10,000.
            assert rotation["noise_db"] == pytest.approx(-83.0, abs=0.1)
            assert rotation["height_difference_m"] == 0.0
        assert len(visit["frequency_hz"]) == 5


@pytest.mark.parametrize("interval_s", [3600.0, 0.0])
def test_a_survey_shorter_than_the_interval_visits_nothing(interval_s):
    settings = SurveySettings(0.0, reference_interval_s=interval_s)
    assert not plan_survey(PARAMETERS, CONFIG, settings).visits


def test_each_drift_that_is_too_large_pauses_and_is_accepted_as_it_is_after_resuming(visiting):
    first, second, *rest = PLAN.visits
    visiting.at_sweep(first - 1, louder(visiting))
    visiting.start()
    visiting.wait_for_fault(faults.DRIFTED)
    assert visiting.wait_for(State.PAUSED).remaining_s > 0.0
    visiting.wait_for_visited(first)
    visiting.at_sweep(second + 2 * SWEEPS - 1, louder(visiting, 0.5))
    visiting.control.resume("")
    visiting.wait_for_visited(second)
    visiting.wait_for(State.PAUSED)
    visiting.control.resume("")
    visiting.complete()
    paused = [(one, *mark) for one in (first, second) for mark in ((True, False), (False, True))]
    assert marks(visiting) == paused + [(one, False, False) for one in rest]
    # What is stored is the drift since the start, whatever was accepted.
    gains_db = [one["rotations"][1]["gain_db"] for one in visits(visiting)]
    expected_db = [20.0 * math.log10(gain) for gain in (1.5, 1.5, *[0.75] * (len(rest) + 2))]
    assert gains_db == pytest.approx(expected_db, abs=0.01)


def test_a_drift_at_the_end_warns_but_keeps_nobody_waiting(visiting):
    visiting.at_sweep(23 + SWEEPS * (len(PLAN.visits) - 1), louder(visiting))
    visiting.start()
    visiting.complete()
    assert visiting.board.status.remaining_s == 0.0
    assert marks(visiting)[-1] == (24, True, False)
    assert visiting.board.status.warning.fault_code == faults.DRIFTED.code
    # A warning is not why a survey ended.
    assert visiting.storage.ends[-1].reason.fault_code == ""
    warnings = visiting.storage.reports[-1]["warnings"]
    assert [one["fault_code"] for one in warnings] == [faults.DRIFTED.code]


@pytest.mark.parametrize("index", [PLAN.visits[0], PLAN.total_points])
def test_a_visit_that_fails_is_repeated_after_resuming(visiting, index):
    sweep = index + 1 + SWEEPS * PLAN.visits.index(index)
    visiting.at_sweep(sweep, lambda: setattr(visiting.analyzer, "failures", 1))
    visiting.start()
    visiting.wait_for(State.PAUSED)
    visiting.control.resume("")
    visiting.complete()
    assert [one["next_index"] for one in visits(visiting)] == list(PLAN.visits)


def test_after_a_pause_as_long_as_the_interval_the_drift_is_looked_at_first(visiting):
    visiting.at_sweep(4, visiting.control.pause)
    visiting.start()
    visiting.wait_for(State.PAUSED)
    visiting.clock.wait_s(threading.Event(), 2.0 * INTERVAL_S)
    measured = visiting.board.status.visited_points
    visiting.control.resume("")
    visiting.complete()
    assert [one["next_index"] for one in visits(visiting)] == [measured, *PLAN.visits]


def test_a_survey_from_the_disk_compares_with_the_first_stop_that_is_stored(visiting):
    reopened = reopened_survey(range(13), json.dumps({"controls": []}))
    # As the storage answers: the first traces too, beside the latest.
    recent = (stored_trace(0), stored_trace(1), *reopened.recent)
    visiting.storage.reopened = replace(reopened, recent=recent)
    visiting.analyzer.level *= 1.05
    visiting.control.resume("survey")
    visiting.wait_for(State.FINISHED)
    rest = [one for one in PLAN.visits if one > 13]
    assert [one["next_index"] for one in visits(visiting)] == [13, *rest]
    gain_db = visits(visiting)[-1]["rotations"][0]["gain_db"]
    assert gain_db == pytest.approx(20.0 * math.log10(1.05), abs=0.001)


def test_what_is_stored_of_a_visit_is_bounded():
    values = {"s21_real": np.ones(1000), "s21_imag": np.zeros(1000)}
    trace = stored_trace(0, frequency_hz=np.linspace(6.0e8, 6.0e9, 1000), **values)
    limits = DriftLimits(SurveySettings())
    visits = [
        limits.visit([Repeated(trace, (trace, trace))], index, "").values for index in range(9)
    ]
    assert len(visits[-1]["frequency_hz"]) == MAX_FREQUENCIES
    assert len(visits[-1]["rotations"][0]["phase_deg"]) == MAX_FREQUENCIES
    assert all(one["rotations"][0]["phase_rms_deg"] == 0.0 for one in visits)
    # However many there were before.
    sizes = {len(json.dumps(one, allow_nan=False)) for one in visits}
    assert len(sizes) == 1 and max(sizes) < 12_000
