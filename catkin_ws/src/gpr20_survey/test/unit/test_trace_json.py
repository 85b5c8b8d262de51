from __future__ import annotations

import datetime
import hashlib
import json
import math
import random

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from log_examples import without_checksum
from trace_examples import STARTED_US, assert_same_numbers, make_trace, read_json

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace import trace_json, utc_time
from gpr20_survey.trace.aux_value import AuxValue
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

KEYS = [
    "format", "survey_id", "sample_id", "index", "timestamp", "x_coord_mm", "y_coord_mm",
    "z_coord_deg", "antennae_height_m", "frequency_hz", "s21_real", "s21_imag",
    "sweep_started", "sweep_ended", "quality",
]  # fmt: skip
ANALYZER_KEYS = ["if_bandwidth_hz", "averages", "output_power"]
FINITE = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=True)


@given(st.floats(6e9 - 1e-3, 6e9))
def test_neighbouring_frequencies_stay_apart(frequency_hz):
    grid = np.array([1.0, 2.0, 3.0, np.nextafter(frequency_hz, 0.0), frequency_hz])
    trace = make_trace(frequency_hz=grid)
    assert_same_numbers(trace, json.loads(trace_json.encode(trace)))


def test_the_keys_are_those_of_the_format():
    assert list(json.loads(trace_json.encode(make_trace()))) == [
        *(*KEYS, *ANALYZER_KEYS, "aux", "zero_epochs", "zero_times", "sha256")
    ]


def test_a_trace_without_known_settings_sensors_and_zeros_has_the_form_of_early_versions():
    unknown = make_trace(analyzer=AnalyzerSettings(), aux=(), zeros=())
    assert list(json.loads(trace_json.encode(unknown))) == [*KEYS, "sha256"]


@each_case(
    "changes",
    [
        {"zero_epochs": None},
        {"zero_times": None},
        {"zero_epochs": [], "zero_times": []},
        {"zero_epochs": [1, 2]},
        {"zero_epochs": [1, 2, 3, 4]},
        {"zero_epochs": [0, 1, 2]},
        {"zero_epochs": [1, 2, 1 << 32]},
        {"zero_epochs": [1.0, 2, 3]},
        {"zero_epochs": [True, 2, 3]},
        {"zero_times": ["yesterday"] * 3},
        {"zero_times": [0, 1, 2]},
    ],
)
def test_zeros_that_are_not_three_numbers_with_three_times_are_refused(changes):
    values = {**json.loads(trace_json.encode(make_trace())), **changes}
    kept = {name: value for name, value in values.items() if value is not None}
    with pytest.raises(TraceRefusedError):
        trace_json.from_values(kept)


@each_case(
    "changes",
    [
        {"if_bandwidth_hz": None},
        {"averages": None},
        {"output_power": None},
        {"if_bandwidth_hz": 1000},
        {"averages": 1.0},
        {"averages": True},
        {"output_power": 1},
        {"if_bandwidth_hz": -0.0},
        {"if_bandwidth_hz": 0.0, "averages": 0, "output_power": ""},
        {"rf_power": 1.0},
    ],
)
def test_settings_that_are_not_all_three_with_their_types_are_refused(changes):
    values = {**json.loads(trace_json.encode(make_trace())), **changes}
    kept = {name: value for name, value in values.items() if value is not None}
    with pytest.raises(TraceRefusedError):
        trace_json.from_values(kept)


AUX = {"name": "t", "value": 1.5, "unit": "", "stamp": utc_time.iso_text(STARTED_US)}


def test_a_value_of_another_sensor_has_a_name_a_value_a_unit_and_a_time():
    values = {**json.loads(trace_json.encode(make_trace())), "aux": [AUX]}
    assert trace_json.from_values(values).aux == (AuxValue("t", 1.5, "", STARTED_US),)


@each_case(
    "aux",
    [
        [],
        {},
        None,
        [[]],
        [{}],
        [{**AUX, "more": 1}],
        *[[{**AUX, "name": name}] for name in ("T", "", "t" * 65, "1t", "t\n")],
        *[[{**AUX, "value": value}] for value in (1, None, "1", 1e999)],
        *[[{**AUX, "unit": unit}] for unit in ("u" * 33, "\n", None)],
        *[[{**AUX, "stamp": stamp}] for stamp in ("today", 0, "1970-01-01T00:00:00.000000+00:00")],
        [AUX, AUX],
        [{**AUX, "name": f"t{number}"} for number in range(33)],
    ],
)
def test_values_of_other_sensors_that_are_not_allowed_are_refused(aux):
    values = {**json.loads(trace_json.encode(make_trace())), "aux": aux}
    with pytest.raises(TraceRefusedError):
        trace_json.from_values(values)


@each_case("value", [math.nan, math.inf, -math.inf])
def test_a_value_of_another_sensor_is_finite(value):
    with raises_fault("sensor.not_finite", "soil", value, error=TraceRefusedError):
        make_trace(aux=(AuxValue("soil", value, "", STARTED_US),))


def test_a_missing_height_is_null_in_strict_json(tmp_path):
    path = tmp_path / "trace.json"
    path.write_bytes(trace_json.encode(make_trace(antennae_height_m=math.nan)))
    assert read_json(path)["antennae_height_m"] is None


@given(st.integers(utc_time.EARLIEST_US, utc_time.LATEST_US - 1))
def test_times_are_iso_8601_in_utc_to_the_microsecond(time_us):
    text = utc_time.iso_text(time_us)
    moment = datetime.datetime.fromisoformat(text)
    epoch = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)
    assert (moment - epoch) // datetime.timedelta(microseconds=1) == time_us
    assert len(text) == len("2026-01-01T00:00:00.000000+00:00")


def test_the_three_times_are_not_mixed_up():
    values = json.loads(trace_json.encode(make_trace()))
    expected = [STARTED_US + 1_000_003, STARTED_US + 1, STARTED_US + 1_000_001]
    assert [values[key] for key in ("timestamp", "sweep_started", "sweep_ended")] == [
        utc_time.iso_text(time_us) for time_us in expected
    ]


def test_a_file_ends_with_the_checksum_of_all_bytes_before_it():
    content = trace_json.encode(make_trace())
    covered = content[: content.rindex(b', "sha256"')]
    assert json.loads(content)["sha256"] == hashlib.sha256(covered).hexdigest()
    assert trace_json.is_proven(content)


def test_no_byte_of_a_file_can_change_unseen():
    content = trace_json.encode(make_trace())
    chance = random.Random(7)
    for place in range(len(content)):
        changed = bytearray(content)
        changed[place] ^= 1 << chance.randrange(8)
        with pytest.raises(TraceRefusedError):
            print(place, trace_json.decode(bytes(changed)))
    for cut in range(len(content)):
        with pytest.raises(TraceRefusedError):
            print(cut, trace_json.decode(content[:cut]))


def test_a_file_of_an_earlier_version_is_read_but_proves_nothing():
    former = without_checksum(trace_json.encode(make_trace()))
    assert trace_json.decode(former).fingerprint() == make_trace().fingerprint()
    assert not trace_json.is_proven(former)
