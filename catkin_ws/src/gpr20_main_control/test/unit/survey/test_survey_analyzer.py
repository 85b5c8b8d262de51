"""The analyzer, its calibration and its sweeps, and the height at each point."""

import json
import math
from dataclasses import replace

import pytest
from cut_off_surveys import SURVEY_ID, reopened_survey
from fake_robot import Bench, reports
from survey_examples import PARAMETERS

from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.robot import AnalyzerCalibration
from gpr20_survey.faults import VNA_SETTINGS
from gpr20_survey.plan.survey_parameters import HeightPolicy
from gpr20_survey.plan.survey_state import SurveyState as State
from gpr20_survey.trace.sweep import AnalyzerSettings, CalibrationStatus

NOT_CALIBRATED = "the VNA's calibration status is 0 (no calibration); calibrate it"
OWN = AnalyzerSettings(10_000.0, 1, "HIGH")


def with_own_settings(settings):
    """The analyzer has values where the survey requests none."""
    asked = {name: value for name, value in vars(settings.analyzer).items() if value}
    return replace(settings, analyzer=replace(OWN, **asked))


def test_a_failed_height_is_stored_as_none_with_its_reason_where_that_is_the_policy():
    def fail():
        raise DeviceError(Message("no answer:\nthe node died"))

    bench = Bench(on_height_failure=HeightPolicy.STORE_WITHOUT)
    bench.height.height_m = fail
    bench.start()
    bench.complete()
    sample = bench.storage.samples[0]
    assert math.isnan(sample.antennae_height_m)
    assert sample.quality == ("no height: no answer:?the node died",)


@pytest.mark.parametrize(
    "changes, value",
    [
        ({"start_frequency_hz": 1.0e9, "stop_frequency_hz": 2.0e9}, 2000.0),
        ({"analyzer": replace(OWN, output_power="LOW")}, "LOW"),
    ],
)
def test_a_sweep_with_other_settings_than_the_surveys_is_never_stored(bench, changes, value):
    bench.analyzer.accept = with_own_settings

    def set_up_another():
        if bench.analyzer.sweeps == 3:
            accepted = with_own_settings(bench.analyzer.requested[-1])
            bench.analyzer.settings = replace(accepted, **changes)

    bench.analyzer.on_sweep = set_up_another
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, VNA_SETTINGS, value)
    bench.wait_for_visited(3)
    assert len(bench.storage.samples) == 3
    bench.analyzer.on_sweep = lambda: None
    bench.resume_to_the_end()


def test_the_settings_of_a_survey_are_requested_and_what_was_accepted_is_recorded(bench):
    details = {"parameters": ["S21"], "type": "TRFP"}

    def accept(settings):
        after = AnalyzerCalibration(CalibrationStatus.MODERATE_POWER, details)
        bench.analyzer.calibration = lambda: after
        return with_own_settings(settings)

    bench.analyzer.accept = accept
    bench.analyzer.sweep_duration_s = 0.35
    bench.start(if_bandwidth_hz=100.0, averages=2)
    bench.complete()
    assert bench.analyzer.requested[0].analyzer == AnalyzerSettings(100.0, 2, "")
    instrument = json.loads(bench.storage.records[0].metadata_json)["instrument"]
    # The calibration is that after the setup.
    assert (instrument["calibration_status"], instrument["calibration_details"]) == (2, details)
    accepted = AnalyzerSettings(100.0, 2, "HIGH")
    assert instrument["sweep"] == {
        "start_frequency_hz": 600.0e6,
        "stop_frequency_hz": 6.0e9,
        "points": 5,
        **vars(accepted),
        "sweep_duration_s": 0.35,
    }
    assert bench.storage.samples[0].analyzer == accepted


def test_a_survey_from_its_folder_requests_the_settings_that_it_began_with(bench):
    recorded = AnalyzerSettings(500.0, 4, "LOW")
    bench.storage.reopened = reopened_survey(instrument={"sweep": vars(recorded)})
    bench.control.resume(SURVEY_ID)
    bench.wait_for(State.FINISHED)
    assert [one.analyzer for one in bench.analyzer.requested] == [recorded]


@pytest.mark.parametrize("end", [State.FINISHED, State.STOPPED, State.FAILED])
def test_the_analyzer_is_released_however_the_survey_ends(bench, end):
    if end is State.FAILED:
        bench.analyzer.calibration_refusal = NOT_CALIBRATED
    elif end is State.STOPPED:
        bench.analyzer.on_sweep = lambda: bench.analyzer.sweeps == 3 and bench.control.stop()
    bench.start()
    bench.wait_for(end)
    bench.control.set_parameters(PARAMETERS)
    # The release is not waited for.
    bench.robot.analyzer_calls.call(lambda: None, lambda: None)
    assert bench.analyzer.releases == 1
