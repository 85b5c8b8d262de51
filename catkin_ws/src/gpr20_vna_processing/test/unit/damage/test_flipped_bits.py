"""One bit of a recording flipped while the survey was closed: it continues and is readable."""

from __future__ import annotations

import shutil

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from reopening_kit import assert_whole
from storage_kit import Kit, text_message
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_survey.recording.recordings import open_recordings

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(4)]
EXAMPLES = 10


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """A survey of which three of four traces are stored."""
    data = tmp_path_factory.mktemp("stopped") / "data"
    kit = Kit(data, open_recordings)
    kit.open(metadata_json='{"simulated": true, "planned_traces": 4}')
    for trace in TRACES[:3]:
        kit.processing.record(text_message("/control_status", "measuring"))
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    return data


def go_on_with_a_flipped_bit(stopped, data, name, place, bit):
    shutil.rmtree(str(data), ignore_errors=True)
    shutil.copytree(str(stopped), str(data))
    (folder,) = data.iterdir()
    content = bytearray((folder / name).read_bytes())
    content[place % len(content)] ^= 1 << bit
    (folder / name).write_bytes(content)
    kit = Kit(data, open_recordings)
    try:
        assert kit.processing.reopen_survey(SURVEY).stored_indices == (0, 1, 2)
        kit.processing.store(TRACES[3])
        kit.processing.close_survey(SURVEY, "finished")
    finally:
        kit.processing.shut_down()
    assert_whole(folder, TRACES)


@settings(
    max_examples=EXAMPLES,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(place=st.integers(0, 1 << 16), bit=st.integers(0, 7))
@example(place=69, bit=7)  # the metadata record, which is read again when the file is finished
@example(place=161, bit=0)
def test_an_mcap_with_a_flipped_bit_goes_on(stopped, tmp_path, place, bit):
    go_on_with_a_flipped_bit(stopped, tmp_path / "data", "survey.mcap", place, bit)


@settings(
    max_examples=EXAMPLES,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(place=st.integers(0, 1 << 16), bit=st.integers(0, 7))
@example(place=4140, bit=0)  # the header of the first chunk: "compression=none"
def test_a_bag_with_a_flipped_bit_goes_on(stopped, tmp_path, place, bit):
    go_on_with_a_flipped_bit(stopped, tmp_path / "data", "survey.bag", place, bit)


def test_an_mcap_with_a_damaged_head_goes_on(stopped, tmp_path):
    (folder,) = stopped.iterdir()
    head_end = (folder / "survey.mcap").read_bytes().index(b"zstd") - 41
    for place in range(0, head_end, 47):
        data = tmp_path / str(place)
        go_on_with_a_flipped_bit(stopped, data, "survey.mcap", place, 7)
        shutil.rmtree(str(data))
