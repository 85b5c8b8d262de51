from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.scpi import short_form
from gpr20_simulator.mid.analyzer.trace_reader import (
    INTEGER_STEPS_PER_UNIT,
    block_header,
    display_data,
    interleaved,
    payload,
)
from gpr20_simulator.mid.analyzer.vna_settings import GRAPH_TYPES, DataFormat

STYLE = InstrumentScene()
FLOATS = st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=1)


@given(FLOATS)
def test_ascii_keeps_every_float32(numbers):
    values = np.array(numbers, dtype=np.float32)
    text = payload(values, DataFormat.ASCII, STYLE, STYLE.ascii_digits).decode()
    assert text.endswith(",")
    read = np.array([float(one) for one in text[:-1].split(",")], dtype=np.float32)
    assert read.tobytes() == values.tobytes()


@given(FLOATS)
def test_real_is_little_endian_float32(numbers):
    values = np.array(numbers, dtype=np.float32)
    data = payload(values, DataFormat.REAL_32, STYLE, 8)
    assert np.frombuffer(data, "<f4").tobytes() == values.tobytes()


def test_integers_are_little_endian_steps():
    data = payload(np.array([0.5, -1.0, 1e9]), DataFormat.INTEGER_32, STYLE, 8)
    assert list(np.frombuffer(data, "<i4")) == [
        INTEGER_STEPS_PER_UNIT // 2,
        -INTEGER_STEPS_PER_UNIT,
        2**31 - 1,
    ]


def test_trailing_comma_can_be_left_out():
    style = InstrumentScene(trailing_comma=False)
    assert payload(np.array([1.0, 2.0]), DataFormat.ASCII, style, 1) == b"1.0E+00,2.0E+00"


@each_case(
    "length, digits, header",
    [(2204, 0, b"#42204"), (78, 4, b"#40078"), (5, 0, b"#15"), (123456, 4, b"#6123456")],
)
def test_header_tells_the_length(length, digits, header):
    assert block_header(length, InstrumentScene(header_digits=digits)) == header


def test_real_and_imaginary_parts_come_in_turns():
    assert list(interleaved(np.array([1 + 2j, 3 + 4j]))) == [1, 2, 3, 4]


FREQUENCY_HZ = np.linspace(1e9, 2e9, 11)
DELAY_S = 0.2e-9
VALUES = 0.5 * np.exp(-2j * np.pi * FREQUENCY_HZ * DELAY_S)


@each_case("graph_type", [short_form(one) for one in GRAPH_TYPES])
def test_every_graph_type_shows_finite_numbers(graph_type):
    for values in (VALUES, np.zeros(11), np.ones(11), -np.ones(11)):
        shown = display_data(FREQUENCY_HZ, values.astype(np.complex64), graph_type)
        assert len(shown) in (11, 22)
        assert np.all(np.isfinite(shown))


def test_displays_show_what_they_are_named_after():
    assert display_data(FREQUENCY_HZ, VALUES, "LMAG") == pytest.approx(-6.0206, abs=1e-3)
    assert display_data(FREQUENCY_HZ, VALUES, "SWR") == pytest.approx(3.0)
    assert display_data(FREQUENCY_HZ, VALUES, "GDEL") == pytest.approx(DELAY_S)
    assert list(display_data(FREQUENCY_HZ, VALUES, "REAL")) == list(VALUES.real)
    assert display_data(FREQUENCY_HZ, np.full(11, 1j / 3), "SMIT")[:2] == pytest.approx(
        [40.0, 30.0]
    )
