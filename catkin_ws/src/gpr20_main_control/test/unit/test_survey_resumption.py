"""Interrupted surveys continue with exactly the points that are missing."""

import json
from dataclasses import asdict

import numpy as np
import pytest
from fake_robot import FIRST_SWEEP_US
from fault_kit import raises_fault
from survey_examples import AXES, PARAMETERS

from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError, RequestRefusedError, SurveyError
from gpr20_survey.plan.survey_state import SurveyState as State
from gpr20_survey.results.reopened_survey import ReopenedSurvey
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace


def test_after_an_axis_was_homed_again_the_last_point_is_measured_as_a_control(bench):
    def lose_zero():
        if bench.analyzer.sweeps == 5:
            bench.x.homed = False
            bench.analyzer.on_sweep = lambda: None

    bench.analyzer.on_sweep = lose_zero
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    report = bench.storage.reports[-1]
    (control,) = report["controls"]
    # The fifth point was measured twice; the repeat measurement is not among the traces.
    assert control["index"] == bench.storage.samples[4].index
    assert report["coverage"].count("r") == 1
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def cut_off_survey(bench, stored, report="", **changes):
    """Put a survey that was cut off on the disk of the bench: these samples are stored."""
    metadata = {
        "simulated": True,
        "parameters": asdict(PARAMETERS),
        "axes": {axis_id.value: asdict(one) for axis_id, one in AXES.items()},
        **changes,
    }
    last = stored_trace(max(stored)) if stored else None
    bench.storage.reopened = ReopenedSurvey(
        "5ec1a5d2-0000-4000-8000-000000000000",
        "/data/survey",
        json.dumps(metadata),
        report,
        tuple(sorted(stored)),
        last,
    )


def stored_trace(index):
    return Trace(
        frequency_hz=np.linspace(600.0e6, 6.0e9, 5),
        s21_real=np.ones(5),
        s21_imag=np.ones(5),
        sweep_started_us=FIRST_SWEEP_US,
        sweep_ended_us=FIRST_SWEEP_US,
        quality=(),
        analyzer=AnalyzerSettings(),
        survey_id="5ec1a5d2-0000-4000-8000-000000000000",
        sample_id="1",
        index=index,
        timestamp_us=FIRST_SWEEP_US,
        x_coord_mm=0.0,
        y_coord_mm=0.0,
        z_coord_deg=0.0,
        antennae_height_m=0.2,
    )


@pytest.mark.parametrize("stored", [[], [0, 2, 5, 23]])
def test_a_survey_that_was_cut_off_goes_on_with_exactly_what_is_missing(bench, stored):
    cut_off_survey(bench, stored)
    bench.x.homed = bench.y.homed = bench.z.homed = True
    message = bench.control.resume("20260101T000000_5ec1a5d2")
    assert f"{24 - len(stored)} of 24 traces remain" in str(message)
    status = bench.wait_for(State.FINISHED)
    assert status.survey_id == "5ec1a5d2-0000-4000-8000-000000000000"
    missing = [index for index in range(24) if index not in stored]
    assert [sample.index for sample in bench.storage.samples] == missing
    assert [axis.homings for axis in bench.axes] == [1, 1, 1]
    controls = bench.storage.reports[-1]["controls"]
    assert [control["index"] for control in controls] == ([max(stored)] if stored else [])
    assert bench.storage.records == []


def test_the_control_measurement_tells_how_far_it_is_from_the_stored_trace(bench):
    cut_off_survey(bench, [0, 1])
    bench.control.resume("survey")
    bench.wait_for(State.FINISHED)
    (control,) = bench.storage.reports[-1]["controls"]
    # The first sweep of this analyzer is 1 + 1j everywhere, which is what is stored.
    assert control["difference_db"] is None
    assert control["height_difference_m"] == 0.0
    messages = [str(status.message) for status in bench.history]
    assert any(
        "point 1 was measured again and differs by -inf dB" in message for message in messages
    )


@pytest.mark.parametrize(
    "changes, fault",
    [
        ({"simulated": False}, faults.OTHER_ROBOT),
        ({"parameters": {}}, faults.RECORD_DAMAGED),
        ({"axes": {}}, faults.OTHER_AXES),
    ],
)
def test_a_survey_that_this_robot_cannot_go_on_with_is_refused_and_closed(bench, changes, fault):
    cut_off_survey(bench, [0, 1], **changes)
    with raises_fault(fault, "/data/survey", error=RequestRefusedError):
        bench.control.resume("survey")
    assert bench.board.status.state is State.IDLE
    assert bench.storage.closed[-1][1] == "failed"
    assert bench.storage.ends[-1].status.state is State.FAILED


def test_a_survey_that_is_not_there_is_refused(bench):
    with pytest.raises(DeviceError, match="there is no survey nowhere"):
        bench.control.resume("nowhere")
    assert bench.board.status.state is State.IDLE


@pytest.mark.parametrize(
    "stored, report",
    [([0, 30], ""), ([0], '{"controls": [{"index": 30}]}'), ([0], '{"controls": [{"index": -1}]}')],
)
def test_a_survey_that_holds_more_than_its_plan_is_refused_and_closed(bench, stored, report):
    cut_off_survey(bench, stored, report)
    with raises_fault(faults.RECORD_DAMAGED, error=SurveyError):
        bench.control.resume("survey")
    assert bench.board.status.state is State.IDLE
    assert bench.storage.closed[-1][1] == "failed"
