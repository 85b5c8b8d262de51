"""A trace as a value, a JSON file and in a block: what is damaged or not allowed is refused."""

from __future__ import annotations

import datetime
import hashlib
import json
import math
from types import SimpleNamespace

import numpy as np
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from trace_examples import STARTED_US, SURVEY, assert_same_numbers, make_trace

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.folder import trace_files
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import TRACE_FIELDS, AuxValue, TraceBlock, block_fields, block_from


@given(st.floats(6e9 - 1e-3, 6e9))
def test_neighbouring_frequencies_stay_apart(frequency_hz):
    grid = np.array([1.0, 2.0, 3.0, np.nextafter(frequency_hz, 0.0), frequency_hz])
    trace = make_trace(frequency_hz=grid)
    assert_same_numbers(trace, json.loads(trace_files.encode(trace)))


def test_the_keys_are_those_of_every_trace_and_null_is_what_is_not_known():
    keys = [*(one.name for one in TRACE_FIELDS), "sha256"]
    unknown = make_trace(analyzer=AnalyzerSettings(), aux=(), zeros=(), antennae_height_m=math.nan)
    values = json.loads(trace_files.encode(unknown))
    assert list(json.loads(trace_files.encode(make_trace()))) == list(values) == keys
    assert {name for name, one in values.items() if one is None} == MAY_BE_UNKNOWN
    assert values["aux"] == []


ABSENT = object()
SETTINGS = ("if_bandwidth_hz", "averages", "output_power")
MAY_BE_UNKNOWN = {"antennae_height_m", *SETTINGS, "zero_epochs", "zero_times"}
AUX = {"name": "t", "value": 1.5, "unit": "", "stamp": utc_time.iso_text(STARTED_US)}
VALUES = json.loads(trace_files.encode(make_trace()))
del VALUES["sha256"]


def decoded(values):
    return trace_files.decode(trace_files.sealed(json.dumps(values).encode()))


@each_case(
    "changes, key",
    [
        *(({name: ABSENT}, name) for name in VALUES),
        *(({name: {}}, name) for name in VALUES),
        *(({name: None}, name) for name in VALUES if name not in MAY_BE_UNKNOWN),
        *(({"zero_epochs": one}, "zero_epochs") for one in ([1, 2], [1, 2, 3, 4])),
        *(({"zero_epochs": one}, "zeros") for one in ([0] * 3, [0, 1, 2], [1, 2, 1 << 32], None)),
        *(({"zero_epochs": one}, "zero_epochs[0]") for one in ([1.0, 2, 3], [True, 2, 3])),
        *(
            ({"zero_times": one}, key)
            for one, key in ((["today"] * 3, "today"), ([0, 1, 2], "[0]"))
        ),
        *(({"averages": one}, "averages") for one in (1.0, True, 1 << 40)),
        *(({"if_bandwidth_hz": one}, "if_bandwidth_hz") for one in ("1000", -0.0, math.nan)),
        *(({"s21_real": one}, "s21_real") for one in ([1], [math.nan] * 5, ["1"], "x")),
        ({"aux": [AUX, AUX]}, "none of them twice"),
        ({"aux": [AUX, []]}, "aux[1]"),
        *(({"aux": [{**AUX, "more": one}]}, "aux[0]/more") for one in (1, None)),
        *(({"aux": [{**AUX, "name": name}]}, "") for name in ("T", "", "t" * 65, "1t", "t\n")),
        *(
            ({"aux": [{**AUX, "value": one}]}, "aux[0]/value")
            for one in (None, "1", math.inf, math.nan)
        ),
        *(
            ({"aux": [{**AUX, "stamp": one}]}, key)
            for one, key in (("today", "today"), (0, "stamp"))
        ),
        ({"aux": [{**AUX, "stamp": utc_time.iso_text(0)}]}, "1970"),
        ({"aux": [{**AUX, "name": f"t{number}"} for number in range(33)]}, "at most 32 values"),
        ({"more": 1}, "more"),
    ],
)
def test_what_no_trace_has_is_refused_by_its_entry_though_its_checksum_is_right(changes, key):
    values = {name: one for name, one in {**VALUES, **changes}.items() if one is not ABSENT}
    with raises_fault(("survey.damaged", "survey.other_version"), key, error=TraceRefusedError):
        trace_files.decode(trace_files.sealed(json.dumps(values).encode()))


def test_another_format_is_refused_with_the_one_that_is_read_whatever_it_holds():
    for values in ({**VALUES, "more": 1}, {}):
        other = json.dumps({**values, "format": "gpr20-trace/2"}).encode()
        with raises_fault("survey.other_version", "gpr20-trace/2", "gpr20-trace/1"):
            trace_files.decode(trace_files.sealed(other))


@given(st.integers(utc_time.EARLIEST_US, utc_time.LATEST_US - 1))
def test_times_are_iso_8601_in_utc_to_the_microsecond(time_us):
    text = utc_time.iso_text(time_us)
    moment = datetime.datetime.fromisoformat(text)
    epoch = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)
    assert (moment - epoch) // datetime.timedelta(microseconds=1) == time_us
    assert len(text) == len("2026-01-01T00:00:00.000000+00:00")


def test_the_three_times_are_not_mixed_up():
    values = json.loads(trace_files.encode(make_trace()))
    expected = [STARTED_US + 1_000_003, STARTED_US + 1, STARTED_US + 1_000_001]
    assert [values[key] for key in ("timestamp", "sweep_started", "sweep_ended")] == [
        utc_time.iso_text(time_us) for time_us in expected
    ]


def test_a_file_ends_with_the_checksum_of_all_bytes_before_it():
    content = trace_files.encode(make_trace())
    covered = content[: content.rindex(b', "sha256"')]
    assert json.loads(content)["sha256"] == hashlib.sha256(covered).hexdigest()
    for wrong in (covered + b"}\n", content[:-1], content[:-9], content + b"\n", b"", b"}"):
        with raises_fault("survey.damaged", "checksum", error=TraceRefusedError):
            trace_files.decode(wrong)


@each_case("text", [b"{}}", b"[" * 100_000, b'"\xff"}', b"[]", b"3}", b"}"])
def test_what_is_no_json_object_is_refused_however_right_its_checksum(text):
    for start in (b"", b'{"format": "gpr20-trace/1", '):
        with raises_fault(("survey.damaged", "survey.other_version"), error=TraceRefusedError):
            trace_files.decode(trace_files.sealed(start + text))


NAN, INF = math.nan, math.inf


def with_value(value: float) -> np.ndarray:
    return np.array([1.0, 2.0, value, 4.0, 5.0])


POINTS = ("frequency_hz", "s21_real", "s21_imag")
NOT_ALLOWED = {
    "survey_id": ["", "0F8FAD5B-D9CB-469F-A165-70867728950E"],
    "sample_id": ["", "../../etc/passwd", "a/b", "a\n", "a" * 129],
    "index": [-1, 1_000_000],
    "x_coord_mm": [NAN],
    "y_coord_mm": [INF],
    "z_coord_deg": [-10_000.1],
}
ANALYZERS = [
    ((NAN,), "if_bandwidth_hz"),
    ((-1.0,), "if_bandwidth_hz"),
    ((2e9,), "if_bandwidth_hz"),
    ((0.0, -1), "averages"),
    ((0.0, 0, "A\n"), ""),
]
SWEEPS = [
    ("frequency_hz", with_value(2.0), ()),
    ("frequency_hz", with_value(NAN), ("frequency_hz", 1)),
    ("frequency_hz", np.linspace(1, 2, 6), ("s21_real", 5, 6)),
    ("s21_real", with_value(NAN), ("s21_real", 1)),
    ("s21_imag", with_value(-INF), ("s21_imag", 1)),
    ("s21_imag", np.ones(5, np.float32), ("s21_imag",)),
]


@each_case(
    "changes, expected",
    [
        *(
            ({name: value}, ("robot.internal_error", name))
            for name, values in NOT_ALLOWED.items()
            for value in values
        ),
        *(({"quality": one}, ("robot.internal_error",)) for one in (("a\x00",), ("\ud800",))),
        *(({"quality": one}, ("robot.internal_error",)) for one in (("a" * 201,), ("a",) * 33)),
        ({"antennae_height_m": -INF}, ("sensor.failed",)),
        *(({"aux": (AuxValue("soil", one, "", STARTED_US),)}, ("sensor.failed", "soil", one))
          for one in (NAN, INF, -INF)),
        *((dict.fromkeys(POINTS, np.arange(1.0, count + 1.0)), ("vna.failed", count))
          for count in (0, 1, 4002)),
        *(({name: one}, ("vna.failed", *shown)) for name, one, shown in SWEEPS),
        *(({f"{name}_us": 0}, ("clock.wrong", name, 1970))
          for name in ("timestamp", "sweep_started", "sweep_ended")),
        ({"sweep_ended_us": STARTED_US}, ("clock.wrong",)),
        *(({"analyzer": AnalyzerSettings(*one)}, ("vna.failed", name))
          for one, name in ANALYZERS),
    ],
)  # fmt: skip
def test_a_wrong_value_is_refused_by_name(changes, expected):
    with raises_fault(*expected, error=TraceRefusedError):
        make_trace(**changes)


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
