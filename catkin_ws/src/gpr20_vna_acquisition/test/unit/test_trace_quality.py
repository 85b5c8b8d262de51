"""A trace carries remarks on its quality; data that no measurement gives are refused."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from case_kit import each_case
from driver_bench import Bench
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from gpr20_common.message import Message, verbatim
from gpr20_common.sent_message import received_message
from gpr20_survey.faults import NOT_CALIBRATED, VNA_DOUBTFUL, VNA_FAILED
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import MAX_REMARK_CHARACTERS, Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaDataError
from gpr20_vna_acquisition.mid.trace_quality import (
    MOST_REASONS,
    TraceQuality,
    calibration_remarks,
    refuse_impossible,
    retry_remarks,
    stored_remarks,
)
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

LIMITS = VnaParameters()
STARTED_US = 1_800_000_000_000_000
POINTS = 101
FINITE = st.floats(allow_nan=False, allow_infinity=False, width=32)


def sweep_of(real, imag, duration_s=0.1):
    frequency_hz = np.linspace(1e9, 2e9, len(real))
    ended_us = STARTED_US + round(duration_s * 1e6)
    return Sweep(frequency_hz, real, imag, STARTED_US, ended_us, (), AnalyzerSettings())


def trace(level_db=-40.0, flat=slice(0), points=POINTS):
    """Return a noisy trace of a level, some points of which do not change."""
    random = np.random.default_rng(3)
    level = 10.0 ** (level_db / 20.0) * (1.0 + random.normal(0.0, 0.01, points))
    angle = random.uniform(-math.pi, math.pi, points)
    real, imag = level * np.cos(angle), level * np.sin(angle)
    real[flat], imag[flat] = 0.001, -0.002
    return sweep_of(real, imag)


def judged(sweep, failures=()):
    return TraceQuality(LIMITS).remarks(sweep, failures)


def test_a_usual_trace_has_no_remarks():
    weak_point = trace()
    weak_point.s21_real[50] = weak_point.s21_imag[50] = 0.0
    few_equal = trace(flat=slice(20, 27))
    for sweep in (trace(-70.0), trace(-35.0), trace(-1.0), weak_point, few_equal):
        assert judged(sweep) == ()


@each_case(
    "level_db, fault, limit_db",
    [(-95.0, VNA_DOUBTFUL, LIMITS.min_level_db), (6.0, VNA_DOUBTFUL, LIMITS.max_level_db)],
)
def test_a_level_beyond_its_limits_is_told_with_both_numbers(level_db, fault, limit_db):
    (remark,) = judged(trace(level_db))
    assert remark.fault == fault
    assert f"{level_db:g}" in str(remark) and f"{limit_db:g} dB" in str(remark)


@each_case("first, count", [(0, 8), (40, 20), (POINTS - 8, 8), (0, POINTS)])
def test_points_that_do_not_change_are_told_wherever_they_are(first, count):
    (remark,) = judged(trace(flat=slice(first, first + count)))
    assert remark.fault == VNA_FAILED.as_warning()
    assert {remark.values["same"], remark.values["points"]} == {count, POINTS}


@each_case(
    "status, fault",
    [
        (CalibrationStatus.NONE, NOT_CALIBRATED),
        (CalibrationStatus.LOW, NOT_CALIBRATED.as_warning()),
    ],
)
def test_a_calibration_that_is_not_of_high_accuracy_is_told(status, fault):
    (remark,) = calibration_remarks(status)
    assert remark.fault == fault


def test_repetitions_are_told_with_their_number_and_a_few_reasons():
    # A hundred reasons leave room for the other remarks.
    remarks = retry_remarks([VnaDataError(verbatim(str(number))) for number in range(100)])
    assert len(remarks) == MOST_REASONS and remarks[0].values["times"] == 100


@given(
    arrays.arrays(np.float64, (2, 9), elements=FINITE),
    st.sampled_from(list(CalibrationStatus)),
    st.floats(0.0, 100.0),
    st.text(max_size=400),
)
def test_any_finite_data_can_be_judged_and_every_remark_stored(data, calibration, duration_s, text):
    quality = TraceQuality(LIMITS)
    for _ in range(6):
        sweep = sweep_of(data[0], data[1], duration_s)
        remarks = quality.remarks(sweep, [VnaDataError(verbatim(text))])
        remarks += calibration_remarks(calibration)
        for remark in stored_remarks(remarks):
            assert len(remark) <= MAX_REMARK_CHARACTERS and remark.isprintable()
        for message in remarks:
            # They go to the diagnostics as JSON, which has no infinite numbers.
            assert received_message("", message.to_json()) == message
            json.loads(message.to_json(), parse_constant=pytest.fail)


def test_a_trace_of_zeros_is_refused():
    with raises_fault(VNA_FAILED):
        refuse_impossible(sweep_of(np.zeros(POINTS), np.zeros(POINTS)))
    for part in ("s21_real", "s21_imag"):
        # One part may be zero.
        sweep = trace()
        getattr(sweep, part)[:] = 0.0
        refuse_impossible(sweep)


def test_an_imaginary_part_that_copies_the_real_one_is_refused():
    real = trace().s21_real
    with raises_fault(VNA_FAILED):
        refuse_impossible(sweep_of(real, real.copy()))


# The same, through the driver.


def remarks_of(status):
    return stored_remarks(calibration_remarks(status))


def test_the_calibration_is_that_of_the_moment_of_each_sweep():
    bench = Bench(max_level_db=60.0).configured()
    assert bench.driver.get_trace().quality == ()
    bench.vna.calibration = "3"
    expected = remarks_of(CalibrationStatus.MODERATE_TEMPERATURE)
    assert bench.driver.get_trace().quality == expected
    assert bench.driver.confirm(bench.taken).remarks == expected


@pytest.mark.parametrize("status", [CalibrationStatus.NONE, CalibrationStatus.LOW])
def test_a_sweep_without_an_accepted_calibration_is_refused_and_not_repeated(status):
    bench = Bench().configured()
    bench.vna.calibration = str(int(status))
    del bench.vna.sent[:]
    with raises_fault(NOT_CALIBRATED, int(status), status.meaning):
        bench.driver.get_trace()
    assert bench.vna.sent.count(":INIT:IMM") == 1
    assert bench.driver.trouble.fault == NOT_CALIBRATED
    # A new link would set up the sweep while somebody calibrates.
    assert bench.driver.state.linked
    bench.vna.calibration = "1"
    assert (bench.driver.get_trace().s21_real == bench.vna.sweep_number).all()


def test_a_sweep_that_takes_longer_than_its_like_says_so():
    bench = Bench(max_level_db=60.0).configured()
    for _ in range(5):
        assert bench.driver.get_trace().quality == ()
    bench.vna.sweep_s = 0.5
    bench.driver.get_trace()
    (remark,) = bench.driver.state.last_quality
    assert remark.fault == VNA_DOUBTFUL
    # One that is set up anew has a usual duration of its own.
    bench.configured()
    assert bench.driver.get_trace().quality == ()


def break_link(_answer):
    raise VnaConnectionError(Message("broken on purpose"))


SPOILERS = (
    lambda answer: answer[:-9],
    lambda answer: answer[:8] + b"\x00\x00\xc0\x7f" + answer[12:],
    lambda answer: b"",
    break_link,
)


@given(st.lists(st.sampled_from(SPOILERS), min_size=1, max_size=VnaParameters.attempts - 1))
def test_a_sweep_that_failed_in_several_ways_names_each_of_them_once(failures):
    bench = Bench(max_level_db=60.0).configured()
    left = list(failures)
    bench.vna.spoil = lambda answer: left.pop(0)(answer) if left else answer
    sweep = bench.driver.get_trace()
    assert not left and (sweep.s21_real == bench.vna.sweep_number).all()
    remarks = bench.driver.state.last_quality
    assert remarks[0].values.get("times", 1) == len(failures)
    assert len(remarks) == len(sweep.quality) == len(set(failures))
