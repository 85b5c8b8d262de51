"""A trace as a ROS message and as JSON: every bit comes back, and damage is refused or seen."""

import contextlib
import dataclasses
import json
import math
import random
import struct

import numpy as np
import pytest
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from log_examples import flipped
from memory_kit import peak_bytes
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from run_seed import SEED, draws
from trace_examples import MESSAGES, assert_same_numbers, make_trace

from gpr20_survey.axes import AXES, MAX_NUMBER, MAX_TIME_US, ZeroEpoch
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.folder import trace_files
from gpr20_survey.trace import trace_message, utc_time
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import TRACE_FIELDS, AuxValue

TYPE = "gpr20_msgs/msg/Trace"
TYPES = get_typestore(Stores.ROS1_NOETIC)
TYPES.register(get_types_from_msg(trace_message.DEFINITION, TYPE))
SMALL = st.floats(-1e4, 1e4)
FINITE = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=True)
PRINTABLE = st.characters(min_codepoint=32, max_codepoint=126)
REMARK = st.text(PRINTABLE, max_size=200)
MOMENT = st.integers(utc_time.EARLIEST_US, utc_time.LATEST_US - 1)
MEMORY_BYTES = 4 << 20
# What a header takes; the trace itself holds all that it says.
HEADER = 4 + 8 + 4 + len("antenna_link")


def analyzer_settings():
    known = st.builds(
        AnalyzerSettings,
        st.floats(0.0, 1e9) | st.sampled_from([10.0, 1000.0, 100_000.0]),
        st.integers(0, 1_000_000),
        st.sampled_from(["", "LOW", "HIGH"]) | st.text(PRINTABLE, max_size=32),
    )
    return st.just(AnalyzerSettings()) | known


def aux_values():
    value = st.builds(
        AuxValue,
        st.from_regex(r"[a-z][a-z0-9_]{0,63}", fullmatch=True),
        FINITE,
        st.text(PRINTABLE, max_size=32) | st.just("\N{DEGREE SIGN}C"),
        MOMENT,
    )
    return st.lists(value, max_size=32, unique_by=lambda one: one.name).map(tuple)


def zeros():
    epoch = st.builds(ZeroEpoch, st.integers(1, MAX_NUMBER), st.integers(0, MAX_TIME_US))
    return st.just(()) | st.tuples(*(AXES * [epoch]))


@st.composite
def traces(draw):
    points = draw(st.integers(2, 20))
    numbers = st.lists(FINITE, min_size=points, max_size=points)
    started, ended = sorted((draw(MOMENT), draw(MOMENT)))
    frequencies = st.floats(1.0, 1e10)
    grid = draw(st.lists(frequencies, min_size=points, max_size=points, unique=True))
    return make_trace(
        draw(st.integers(0, 999_999)),
        timestamp_us=draw(MOMENT),
        x_coord_mm=draw(SMALL),
        y_coord_mm=draw(SMALL),
        z_coord_deg=draw(SMALL),
        antennae_height_m=draw(FINITE | st.just(math.nan)),
        frequency_hz=np.array(sorted(grid)),
        s21_real=np.array(draw(numbers)),
        s21_imag=np.array(draw(numbers)),
        sweep_started_us=started,
        sweep_ended_us=ended,
        quality=tuple(draw(st.lists(REMARK, max_size=32))),
        analyzer=draw(analyzer_settings()),
        aux=draw(aux_values()),
        zeros=draw(zeros()),
    )


@given(traces(), analyzer_settings(), st.randoms())
def test_every_trace_comes_back_to_the_last_bit_and_no_flipped_byte_of_its_file(
    trace, other, chance
):
    data, content = trace_message.encode(trace), trace_files.encode(trace)
    for decoded in (trace_message.decode(data), trace_files.decode(content)):
        assert decoded.fingerprint() == trace.fingerprint()
        assert trace_message.encode(decoded) == data
        assert trace_files.encode(decoded) == content
    message = TYPES.deserialize_ros1(data, TYPE)
    assert_same_numbers(trace, message)
    assert_same_numbers(trace, json.loads(content))
    assert bytes(TYPES.serialize_ros1(message, TYPE)) == data
    with raises_fault("survey.damaged", "checksum", error=TraceRefusedError):
        trace_files.decode(flipped(chance, content))
    # Other settings make another trace.
    changed, same = dataclasses.replace(trace, analyzer=other), other == trace.analyzer
    assert (changed.fingerprint() == trace.fingerprint()) == same
    assert (trace_files.encode(changed) == content) == same


@settings(max_examples=draws(20))
@given(traces())
def test_ros_itself_reads_and_writes_the_same_bytes(trace):
    message = pytest.importorskip("gpr20_msgs.msg").Trace()
    raw_message = pytest.importorskip("gpr20_common.high.raw_message")
    data = trace_message.encode(trace)
    message.deserialize(data)
    assert_same_numbers(trace, message)
    assert raw_message.serialized(message) == data
    assert (message._md5sum, message._type) == (trace_message.MD5SUM, trace_message.DATATYPE)


def test_the_table_of_the_fields_is_that_of_definition_checksum_and_page():
    own = trace_message.DEFINITION.split("=" * 80 + "\nMSG: gpr20_msgs/")
    for name, text in zip(("Trace", "AuxValue"), own):
        found = [
            [line.split("#")[0].split() for line in one.splitlines()]
            for one in ((MESSAGES / f"{name}.msg").read_text(), text.partition("\n=")[0])
        ]
        wanted, own_fields = ([one for one in lines if len(one) == 2] for lines in found)
        assert own_fields == wanted
    assert TYPES.generate_msgdef(TYPE)[1] == trace_message.MD5SUM
    page = (MESSAGES.parents[3] / "docs/reference/formats.md").read_text(encoding="utf-8")
    rows = [
        f"| `{one.name}` | `{one.form.ros}` | {one.unit} | "
        f"{ {None: '', '': 'empty'}.get(one.unknown, one.unknown) } | {one.meaning} |\n"
        for one in TRACE_FIELDS
    ]
    assert "".join(rows) in page


def test_the_header_has_the_time_the_frame_and_the_index_of_the_trace():
    trace = make_trace(7)
    header = TYPES.deserialize_ros1(trace_message.encode(trace), TYPE).header
    stamp_us = header.stamp.sec * 10**6 + header.stamp.nanosec // 1000
    assert (stamp_us, header.frame_id, header.seq) == (trace.timestamp_us, "antenna_link", 7)


@given(st.binary(min_size=1, max_size=400), st.floats(0.0, 1.0, exclude_max=True))
def test_a_message_that_is_cut_longer_of_another_version_or_any_bytes_is_refused(rest, share):
    whole = trace_message.encode(make_trace())
    with raises_fault("survey.other_version", "0" * 32, trace_message.MD5SUM):
        trace_message.decode(whole, "0" * 32)
    for wrong in (whole[: int(share * len(whole))], whole + rest, rest):
        with pytest.raises(TraceRefusedError):
            trace_message.decode(wrong)


SIZES = [struct.pack("<I", size) for size in (1 << 20, (1 << 31) - 1, 1 << 31)]


def decode_changed(count):
    """Decode messages of which some bytes are others."""
    chance, whole = random.Random(SEED), trace_message.encode(make_trace())
    for _ in range(count):
        some = bytes(chance.choices(range(256), k=chance.randrange(1, 80)))
        data = chance.choice([some, *SIZES])
        place = chance.randrange(len(whole) - len(data))
        with contextlib.suppress(TraceRefusedError):
            decoded = trace_message.decode(whole[:place] + data + whole[place + len(data) :])
            assert decoded.survey_id != "" and np.isfinite(decoded.s21_real).all()


def test_any_bytes_in_a_message_take_no_memory_and_make_a_checked_trace_at_most():
    assert peak_bytes(decode_changed, draws(200)) < MEMORY_BYTES


def test_a_flipped_bit_is_refused_or_seen_in_the_fingerprint():
    trace, chance = make_trace(), random.Random(SEED)
    data = trace_message.encode(trace)
    same = []
    for place in chance.sample(range(HEADER, len(data)), draws(100)):
        changed = bytearray(data)
        changed[place] ^= 1 << chance.randrange(8)
        try:
            decoded = trace_message.decode(bytes(changed))
        except TraceRefusedError:
            continue
        if decoded.fingerprint() == trace.fingerprint():
            same.append(place)
        else:
            assert trace_message.encode(decoded) != data
    # Nothing but parts of a microsecond, which no form of a trace holds: 10 bits of seven times.
    assert len(same) <= 16
