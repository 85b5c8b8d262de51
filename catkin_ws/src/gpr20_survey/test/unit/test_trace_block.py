"""Blocks of traces: what is sent arrives, and what contradicts itself is refused."""

from types import SimpleNamespace

import numpy as np
import pytest
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from trace_examples import SURVEY, make_trace

from gpr20_survey import faults
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace.trace_block import SAMPLE, TraceBlock, block_fields, block_from


def received(block, **changes):
    return block_from(SimpleNamespace(**{**block_fields(block), **changes}))


@given(st.lists(st.integers(0, 999_999), unique=True, max_size=5))
def test_a_block_arrives_as_it_was_sent(indices):
    traces = [
        make_trace(index, x_coord_mm=0.1 * number, antennae_height_m=float("nan"))
        for number, index in enumerate(indices)
    ]
    block = TraceBlock.of(SURVEY, traces)
    found = received(block)
    for name in ("frequency_hz", "indices", "positions", "heights_m", "s21"):
        own, other = getattr(block, name), getattr(found, name)
        assert own.dtype == other.dtype and own.shape == other.shape, name
        np.testing.assert_array_equal(own, other, name)


def test_the_samples_are_those_of_the_traces_in_single_precision():
    trace = make_trace(7)
    (samples,) = TraceBlock.of(SURVEY, [trace]).s21
    assert np.array_equal(samples, (trace.s21_real + 1j * trace.s21_imag).astype(SAMPLE))


@pytest.mark.parametrize(
    "changes",
    [
        {"indices": (1, 1)},
        {"indices": (1, 2, 3)},
        {"antennae_height_m": (0.1,)},
        {"y_coord_mm": (1.0,)},
        {"s21": bytes(79)},
        {"frequency_hz": (1e9, 2e9)},
    ],
)
def test_a_block_that_contradicts_itself_is_refused(changes):
    whole = TraceBlock.of(SURVEY, [make_trace(1), make_trace(2)])
    with raises_fault(faults.TRACE_DAMAGED, error=TraceRefusedError):
        received(whole, **changes)
