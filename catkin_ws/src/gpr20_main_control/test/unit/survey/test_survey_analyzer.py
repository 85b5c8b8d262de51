"""The analyzer, its calibration and its sweeps, and the height at each point."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from cut_off_surveys import SURVEY_ID, reopened_survey
from fake_robot import Bench, reports
from survey_examples import AXES, PARAMETERS

from gpr20_common.message import Message
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.survey.survey_plan import plan_survey
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState as State
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

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


def test_the_calibration_is_recorded_as_it_is_after_the_setup(bench):
    def accept(settings):
        bench.analyzer.calibration_status = CalibrationStatus.MODERATE_POWER
        return settings

    bench.analyzer.accept = accept
    bench.start()
    bench.wait_for(State.FINISHED)
    instrument = json.loads(bench.storage.records[0].metadata_json)["instrument"]
    assert instrument["calibration_status"] == 2


def test_a_failed_height_pauses_the_survey(bench):
    bench.analyzer.on_sweep = lambda: setattr(bench.height, "failures", 3)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert faults.HEIGHT_NOT_MEASURED in status.message.faults


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
    assert reports(final.message, faults.VNA_SETTINGS_REFUSED, 201, 5, 600.0, 6000.0)
    assert bench.storage.records == []


def test_a_survey_never_goes_on_with_other_frequencies(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.y.fail_move = ""
    usual = bench.analyzer.frequencies_hz
    bench.analyzer.frequencies_hz = lambda: np.append(usual()[:-1], 5.9e9)
    bench.control.resume("")
    bench.wait_for_fault(faults.FREQUENCIES_CHANGED)
    bench.wait_for(State.PAUSED)
    assert bench.storage.samples == []


@pytest.mark.parametrize(
    ("changes", "value"),
    [
        ({"start_frequency_hz": 1.0e9, "stop_frequency_hz": 2.0e9}, 2000.0),
        ({"analyzer": AnalyzerSettings(1000.0, 1, "LOW")}, "LOW"),
    ],
)
def test_a_sweep_with_other_settings_than_the_surveys_is_never_stored(bench, changes, value):
    own = AnalyzerSettings(1000.0, 1, "HIGH")
    bench.analyzer.accept = lambda settings: replace(settings, analyzer=own)

    def set_up_another():
        if bench.analyzer.sweeps == 3:
            bench.analyzer.other_settings = replace(bench.analyzer.requested[-1], **changes)

    bench.analyzer.on_sweep = set_up_another
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, faults.VNA_SETTINGS_CHANGED, value)
    bench.wait_for_visited(3)
    assert len(bench.storage.samples) == 3
    bench.analyzer.on_sweep = lambda: None
    bench.analyzer.other_settings = None
    bench.resume_to_the_end()


def with_own_settings(bench):
    """Let the analyzer have values where the survey requests none."""

    def accept(settings):
        wanted = settings.analyzer
        own = AnalyzerSettings(
            wanted.if_bandwidth_hz or 10_000.0, wanted.averages or 1, wanted.output_power or "HIGH"
        )
        return replace(settings, analyzer=own)

    bench.analyzer.accept = accept


def test_the_settings_of_a_survey_are_requested_and_what_was_accepted_is_recorded(bench):
    with_own_settings(bench)
    bench.analyzer.sweep_duration_s = 0.35
    bench.start(if_bandwidth_hz=100.0, averages=2)
    bench.complete()
    assert bench.analyzer.requested[0].analyzer == AnalyzerSettings(100.0, 2, "")
    sweep = json.loads(bench.storage.records[0].metadata_json)["instrument"]["sweep"]
    assert sweep == {
        "start_frequency_hz": 600.0e6,
        "stop_frequency_hz": 6.0e9,
        "points": 5,
        "if_bandwidth_hz": 100.0,
        "averages": 2,
        "output_power": "HIGH",
        "sweep_duration_s": 0.35,
    }
    assert bench.storage.samples[0].analyzer == AnalyzerSettings(100.0, 2, "HIGH")


def test_what_was_left_to_the_analyzer_stays_the_same_to_the_end_of_the_survey(bench):
    with_own_settings(bench)
    bench.analyzer.failures = 1
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.resume_to_the_end()
    former, later = (one.analyzer for one in bench.analyzer.requested)
    assert former == AnalyzerSettings()
    assert later == AnalyzerSettings(10_000.0, 1, "HIGH")


def test_a_survey_from_its_folder_requests_the_settings_that_it_began_with(bench):
    recorded = {"if_bandwidth_hz": 500.0, "averages": 4, "output_power": "LOW"}
    bench.storage.reopened = reopened_survey(instrument={"sweep": recorded})
    bench.control.resume(SURVEY_ID)
    bench.wait_for(State.FINISHED)
    assert [one.analyzer for one in bench.analyzer.requested] == [AnalyzerSettings(500.0, 4, "LOW")]


def test_an_analyzer_that_accepts_other_settings_is_refused(bench):
    bench.analyzer.accept = lambda settings: replace(
        settings, analyzer=replace(settings.analyzer, if_bandwidth_hz=1000.0)
    )
    bench.start(if_bandwidth_hz=100.0)
    final = bench.wait_for(State.FAILED)
    assert reports(final.message, faults.VNA_SETTINGS_REFUSED, 5, 100.0, 1000.0)


def test_the_estimate_of_a_running_survey_uses_the_measured_duration_of_a_sweep():
    config = RobotConfig(AXES, simulated=True, time_scale=10.0)
    plan = plan_survey(PARAMETERS, config, SurveySettings())
    assert plan.pending_durations_with_s(0.0) == plan.pending_durations_s
    # Planned are 350 us for each of five frequencies, on a robot ten times as fast.
    longer_s = 35.0 - 5 * 350e-6 / 10.0
    assert plan.pending_durations_with_s(35.0) == [
        pytest.approx(one + longer_s) for one in plan.pending_durations_s
    ]


def test_the_analyzer_is_released_when_the_survey_has_ended_and_not_while_it_is_paused(bench):
    bench.analyzer.failures = 1
    bench.start()
    bench.wait_for(State.PAUSED)
    assert bench.analyzer.releases == 0
    bench.resume_to_the_end()
    bench.control.set_parameters(PARAMETERS)
    assert bench.analyzer.releases == 1


@pytest.mark.parametrize("end", ["stop", "refuse"])
def test_the_analyzer_is_released_however_the_survey_ends(bench, end):
    if end == "refuse":
        bench.analyzer.calibration_refusal = NOT_CALIBRATED
    else:
        bench.analyzer.on_sweep = lambda: bench.analyzer.sweeps == 3 and bench.control.stop()
    bench.start()
    bench.wait_for(State.STOPPED, State.FAILED)
    bench.control.set_parameters(PARAMETERS)
    assert bench.analyzer.releases == 1


def test_an_analyzer_that_cannot_be_released_does_not_disturb_the_next_survey(bench):
    def fail():
        raise DeviceError(Message("the VNA driver did not answer"))

    bench.analyzer.release = fail
    bench.start()
    bench.wait_for(State.FINISHED)
    bench.start()
    bench.wait_for(State.FINISHED)
    assert len(bench.storage.samples) == 48
