"""A trace carries remarks on its quality; data that no measurement gives are refused."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from gpr20_common.message import verbatim
from gpr20_common.sent_message import received_message
from gpr20_survey.faults import VNA_DOUBTFUL, VNA_FAILED
from gpr20_survey.trace.sweep import MAX_REMARK_CHARACTERS, CalibrationStatus, SweepSettings
from gpr20_vna_acquisition.errors import VnaDataError
from gpr20_vna_acquisition.mid.trace_quality import (
    calibration_remarks,
    data_remarks,
    refuse_impossible,
    retry_remarks,
    stored_remarks,
    timed_sweep,
)
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

LIMITS = VnaParameters()
POINTS = 101
FINITE = st.floats(allow_nan=False, allow_infinity=False, width=32)


def sweep_of(real, imag):
    numbers = np.column_stack((real, imag)).ravel()
    return timed_sweep(SweepSettings(1e9, 2e9, len(real)), numbers, 1_800_000_000_000_000, 0.1)


def trace(level_db=-40.0):
    """Return a noisy trace of a level."""
    random = np.random.default_rng(3)
    level = 10.0 ** (level_db / 20.0) * (1.0 + random.normal(0.0, 0.01, POINTS))
    angle = random.uniform(-math.pi, math.pi, POINTS)
    real, imag = level * np.cos(angle), level * np.sin(angle)
    return sweep_of(real, imag)


def judged(sweep):
    return list(data_remarks(sweep, LIMITS))


def test_a_usual_trace_has_no_remarks():
    weak_point = trace()
    weak_point.s21_real[50] = weak_point.s21_imag[50] = 0.0
    for sweep in (trace(-70.0), trace(-35.0), trace(-1.0), weak_point):
        assert judged(sweep) == []


@each_case("level_db, limit_db", [(-95.0, LIMITS.min_level_db), (6.0, LIMITS.max_level_db)])
def test_a_level_beyond_its_limits_is_named_with_both_numbers(level_db, limit_db):
    (remark,) = judged(trace(level_db))
    assert remark.fault == VNA_DOUBTFUL
    assert f"{level_db:g}" in str(remark) and f"{limit_db:g} dB" in str(remark)


@given(
    arrays.arrays(np.float64, (2, 9), elements=FINITE),
    st.sampled_from(list(CalibrationStatus)),
    st.lists(st.text(max_size=400), max_size=100),
)
def test_any_finite_data_can_be_judged_and_every_remark_stored(data, calibration, texts):
    failures = [VnaDataError(verbatim(text)) for text in texts]
    remarks = [
        *judged(sweep_of(*data)),
        *retry_remarks(failures),
        *calibration_remarks(calibration),
    ]
    for remark in stored_remarks(remarks):
        assert len(remark) <= MAX_REMARK_CHARACTERS and remark.isprintable()
    for message in remarks:
        # They go to the diagnostics as JSON, which has no infinite numbers.
        assert received_message("", message.to_json()) == message
        json.loads(message.to_json(), parse_constant=pytest.fail)


def test_zeros_and_an_imaginary_part_that_copies_the_real_one_are_refused():
    real = trace().s21_real
    for parts in ((np.zeros(POINTS), np.zeros(POINTS)), (real, real.copy())):
        with raises_fault(VNA_FAILED):
            refuse_impossible(sweep_of(*parts))
    # One part may be zero.
    refuse_impossible(sweep_of(real, np.zeros(POINTS)))
    refuse_impossible(sweep_of(np.zeros(POINTS), real))
