"""The analyzer, its calibration and its sweeps, and the height beside them."""

import math
from dataclasses import replace

import numpy as np
from fake_robot import Bench

from gpr20_survey.plan.survey_state import SurveyState as State
from gpr20_survey.trace.sweep_settings import SweepSettings

NOT_CALIBRATED = "the VNA's calibration status is 0 (no calibration); calibrate it"


def test_a_sweep_that_fails_pauses_the_survey_and_nothing_wrong_is_stored(bench):
    bench.analyzer.failures = 1
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "the VNA did not answer" in str(status.message)
    assert bench.storage.samples == []
    # The driver alone repeats.
    assert bench.analyzer.failures == 0 and len(bench.analyzer.connections) == 1
    bench.resume_to_the_end()
    assert len(bench.analyzer.connections) == 2


def test_an_uncalibrated_instrument_is_refused_before_anything_moves(bench):
    bench.analyzer.calibration_refusal = NOT_CALIBRATED
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert NOT_CALIBRATED in str(final.message)
    assert [axis.homings for axis in bench.axes] == [0, 0, 0]
    assert bench.storage.records == []


def test_a_failed_height_pauses_the_survey(bench):
    bench.analyzer.on_sweep = lambda: setattr(bench.height, "failures", 3)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "height could not be measured" in str(status.message)


def test_a_failed_height_is_stored_as_none_where_that_is_the_policy():
    bench = Bench(on_height_failure="store_without")
    bench.height.failures = 10**6
    bench.start()
    bench.wait_for(State.FINISHED)
    sample = bench.storage.samples[0]
    assert math.isnan(sample.antennae_height_m)
    assert any("no height" in remark for remark in sample.quality)


def test_an_instrument_that_accepts_another_sweep_is_refused(bench):
    bench.analyzer.accept = lambda settings: replace(settings, points=201)
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert "the VNA accepted 201 points from 600 to 6000 MHz instead of 5 points" in str(
        final.message
    )
    assert bench.storage.records == []


def test_a_survey_never_goes_on_with_other_frequencies(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.y.fail_move = ""
    usual = bench.analyzer.frequencies_hz
    bench.analyzer.frequencies_hz = lambda: np.append(usual()[:-1], 5.9e9)
    bench.control.resume("")
    bench.wait_for_message("no longer those of this survey")
    bench.wait_for(State.PAUSED)
    assert bench.storage.samples == []


def test_a_sweep_of_other_frequencies_than_the_surveys_is_never_stored(bench):
    def set_up_another():
        if bench.analyzer.sweeps == 3:
            bench.analyzer.other_settings = SweepSettings(1.0e9, 2.0e9, 5)

    bench.analyzer.on_sweep = set_up_another
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "do not change its settings" in str(status.message)
    bench.wait_for_visited(3)
    assert len(bench.storage.samples) == 3
    bench.analyzer.on_sweep = lambda: None
    bench.analyzer.other_settings = None
    bench.resume_to_the_end()


def test_a_calibration_that_is_lost_during_the_survey_pauses_it(bench):
    def lose_it():
        if bench.analyzer.sweeps == 3:
            bench.analyzer.calibration_refusal = NOT_CALIBRATED

    bench.analyzer.on_sweep = lose_it
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert NOT_CALIBRATED in str(status.message)
    bench.wait_for_visited(3)
    assert len(bench.storage.samples) == 3
