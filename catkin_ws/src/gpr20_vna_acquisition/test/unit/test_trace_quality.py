"""What is remarkable about a trace is said with it; what is no measurement is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from driver_bench import Bench
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from gpr20_vna_acquisition.errors import VnaConnectionError, VnaDataError, VnaSweepError
from gpr20_vna_acquisition.mid.sweep import CalibrationStatus, Sweep
from gpr20_vna_acquisition.mid.trace_quality import (
    LONGEST_REMARK,
    QualityLimits,
    TraceQuality,
    duration_remarks,
    flat_remarks,
    level_remarks,
    refuse_impossible,
    repetition_remarks,
    storable,
)

LIMITS = QualityLimits()
POINTS = 101
FINITE = st.floats(allow_nan=False, allow_infinity=False, width=32)


def trace(level_db, points=POINTS, duration_s=0.1):
    """Return a noisy trace of a level."""
    random = np.random.default_rng(3)
    level = 10.0 ** (level_db / 20.0) * (1.0 + random.normal(0.0, 0.01, points))
    angle = random.uniform(-math.pi, math.pi, points)
    return Sweep(level * np.cos(angle), level * np.sin(angle), 0, round(duration_s * 1e6))


def judged(sweep, calibration=CalibrationStatus.HIGH, failures=()):
    return TraceQuality(LIMITS).remarks(sweep, calibration, failures)


@pytest.mark.parametrize("level_db", [-70.0, -35.0, -1.0])
def test_a_usual_trace_has_no_remarks(level_db):
    assert judged(trace(level_db)) == ()


@pytest.mark.parametrize(
    "level_db, words", [(-95.0, "S21 is weak: -95"), (6.0, "S21 is strong: up to 6")]
)
def test_a_level_beyond_its_limits_is_told_with_both_numbers(level_db, words):
    (remark,) = level_remarks(trace(level_db), LIMITS)
    assert remark.startswith(words) and "expected are" in remark


def test_a_single_strong_point_is_told_and_a_single_weak_one_is_usual():
    sweep = trace(-40.0)
    sweep.s21_real[50] = sweep.s21_imag[50] = 0.0
    assert level_remarks(sweep, LIMITS) == ()
    sweep.s21_real[50] = 2.0
    assert "S21 is strong" in level_remarks(sweep, LIMITS)[0]


@pytest.mark.parametrize("first, count", [(0, 8), (40, 20), (POINTS - 8, 8), (0, POINTS)])
def test_points_that_do_not_change_are_told_wherever_they_are(first, count):
    sweep = trace(-40.0)
    sweep.s21_real[first : first + count] = 0.001
    sweep.s21_imag[first : first + count] = -0.002
    (remark,) = flat_remarks(sweep, LIMITS)
    assert remark.startswith(f"{count} of {POINTS} points in a row")


def test_a_few_equal_points_are_usual():
    sweep = trace(-40.0)
    sweep.s21_real[20:27] = 0.001
    sweep.s21_imag[20:27] = -0.002
    assert flat_remarks(sweep, LIMITS) == ()


def test_one_part_that_changes_is_enough_not_to_be_flat():
    sweep = trace(-40.0)
    sweep.s21_real[:] = 0.001
    assert flat_remarks(sweep, LIMITS) == ()


@pytest.mark.parametrize(
    "duration_s, usual", [(0.6, True), (2.2, True), (0.4, False), (2.3, False)]
)
def test_a_duration_far_from_the_usual_one_is_told(duration_s, usual):
    assert (duration_remarks(duration_s, 1.0, LIMITS) == ()) is usual


def test_the_usual_duration_is_that_of_the_sweeps_so_far():
    quality = TraceQuality(LIMITS)
    for _ in range(5):
        assert quality.remarks(trace(-40.0, duration_s=0.2), CalibrationStatus.HIGH, ()) == ()
    (remark,) = quality.remarks(trace(-40.0, duration_s=0.8), CalibrationStatus.HIGH, ())
    assert "took 0.800 s, usual are 0.200 s" in remark


@pytest.mark.parametrize(
    "status, word",
    [
        (CalibrationStatus.NONE, "not calibrated"),
        (CalibrationStatus.MODERATE_POWER, "moderate"),
        (CalibrationStatus.MODERATE_TEMPERATURE, "more than 5 degrees"),
        (CalibrationStatus.LOW, "more than 10 degrees"),
    ],
)
def test_a_calibration_that_is_not_of_high_accuracy_is_told(status, word):
    (remark,) = judged(trace(-40.0), status)
    assert word in remark


def test_repetitions_are_told_with_their_number_and_last_reason():
    assert repetition_remarks([]) == ()
    (remark,) = repetition_remarks(
        [VnaDataError("cut"), VnaDataError("not\x00finite " + "x" * 300)]
    )
    assert remark.startswith("the sweep was repeated 2 times: not?finite x")
    assert len(remark) == LONGEST_REMARK


@given(st.text(max_size=400))
def test_every_remark_can_be_stored(text):
    remark = storable(text)
    assert len(remark) <= LONGEST_REMARK and remark.isprintable()


@given(
    arrays.arrays(np.float64, (2, 9), elements=FINITE),
    st.sampled_from(list(CalibrationStatus)),
    st.floats(0.0, 100.0),
)
def test_any_finite_data_can_be_judged(data, calibration, duration_s):
    quality = TraceQuality(LIMITS)
    for _ in range(6):
        sweep = Sweep(data[0], data[1], 0, round(duration_s * 1e6))
        for remark in quality.remarks(sweep, calibration, [VnaDataError("x")]):
            assert len(remark) <= LONGEST_REMARK


def test_a_trace_of_zeros_is_refused():
    with pytest.raises(VnaDataError, match="zero"):
        refuse_impossible(Sweep(np.zeros(POINTS), np.zeros(POINTS), 0, 1))


def test_an_imaginary_part_that_copies_the_real_one_is_refused():
    real = trace(-40.0).s21_real
    with pytest.raises(VnaDataError, match="copy"):
        refuse_impossible(Sweep(real, real.copy(), 0, 1))


@pytest.mark.parametrize("part", ["s21_real", "s21_imag"])
def test_a_part_that_is_zero_is_a_measurement(part):
    sweep = trace(-40.0)
    getattr(sweep, part)[:] = 0.0
    refuse_impossible(sweep)


# What the driver makes of it.


def test_a_trace_of_zeros_is_repeated_and_never_given_to_the_survey():
    bench = Bench(attempts=2).configured()
    zeros = bench.vna.block([0.0] * 22)
    bench.vna.spoil = lambda answer: zeros
    with pytest.raises(VnaSweepError, match="2 times: every number of the trace is zero"):
        bench.driver.sweep()


def test_a_repeated_sweep_says_so_and_the_next_one_no_longer():
    bench = Bench(max_level_db=60.0).configured()
    cut = [lambda answer: answer[:-9]]
    bench.vna.spoil = lambda answer: cut.pop()(answer) if cut else answer
    (remark,) = bench.driver.sweep().quality
    assert remark.startswith("the sweep was repeated once: the data block is cut")
    assert bench.driver.sweep().quality == () == bench.driver.state.last_quality


def test_the_calibration_is_that_of_the_moment_of_each_sweep():
    bench = Bench(max_level_db=60.0).configured()
    assert bench.driver.sweep().quality == ()
    bench.vna.calibration = "3"
    (remark,) = bench.driver.sweep().quality
    assert "more than 5 degrees" in remark


def test_a_calibration_that_cannot_be_read_repeats_the_sweep():
    bench = Bench().configured()
    broken = [VnaConnectionError("broken on purpose")]

    def before(message):
        if message.endswith("ACC?") and broken:
            raise broken.pop()

    bench.vna.before = before
    assert (bench.driver.sweep().s21_real == 2.0).all()


def test_a_sweep_that_takes_longer_than_its_like_says_so():
    bench = Bench(max_level_db=60.0).configured()
    for _ in range(5):
        assert bench.driver.sweep().quality == ()
    bench.vna.sweep_s = 0.5
    (remark,) = bench.driver.sweep().quality
    assert "the sweep took" in remark


def test_a_newly_configured_sweep_has_a_usual_duration_of_its_own():
    bench = Bench(max_level_db=60.0).configured()
    for _ in range(5):
        bench.driver.sweep()
    bench.vna.sweep_s = 0.5
    bench.configured()
    assert bench.driver.sweep().quality == ()
