"""A survey that was cut off, to be reopened, and what must be true of it in the end."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory
from rosbags.rosbag1 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from storage_kit import TYPES, Kit, text_message
from trace_examples import (
    FORMER_DEFINITIONS,
    STARTED_US,
    SURVEY,
    assert_same_numbers,
    make_trace,
    read_json,
)

from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.trace import trace_message

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(7)]
TYPES_OF = {trace_message.MD5SUM: TYPES}
for _md5sum, _definition in FORMER_DEFINITIONS.items():
    TYPES_OF[_md5sum] = get_typestore(Stores.ROS1_NOETIC)
    TYPES_OF[_md5sum].register(get_types_from_msg(_definition, "gpr20_msgs/msg/Trace"))
FIRST = 4  # traces before the survey is cut off
METADATA = '{"planned_traces": 7, "simulated": true, "parameters": {"x_points": 3}}'


def fill(kit: Kit, traces) -> None:
    for trace in traces:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)


@pytest.fixture
def data(tmp_path):
    """A data folder with a survey that was cut off after four traces."""
    kit = Kit(tmp_path / "before", open_recordings)
    folder = kit.open(metadata_json=METADATA)
    kit.processing.record(text_message("/t", "first"))
    fill(kit, TRACES[:FIRST])
    # What a kill leaves is what is on the disk now.
    shutil.copytree(str(tmp_path / "before"), str(tmp_path / "data"))
    kit.processing.shut_down()
    assert read_json(tmp_path / "data" / folder.name / "survey.json")["ended"] is None
    return tmp_path / "data"


@pytest.fixture
def folder(data):
    (folder,) = data.iterdir()
    return folder


@pytest.fixture
def kit(data):
    kit = Kit(data, open_recordings)
    yield kit
    kit.processing.shut_down()


def traces_in_bag(folder):
    with Reader(str(folder / "survey.bag")) as reader:
        return [
            TYPES_OF[connection.digest].deserialize_ros1(data, "gpr20_msgs/msg/Trace")
            for connection, _, data in reader.messages()
            if connection.topic.startswith("/trace")
        ]


def messages_in_mcap(folder, topic="/trace"):
    topics = [topic, f"{topic}_{trace_message.MD5SUM[:8]}"]
    with open(folder / "survey.mcap", "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [one.decoded_message for one in reader.iter_decoded_messages(topics=topics)]


def assert_whole(folder, traces) -> None:
    """Compare what the stock readers find in a survey that ended with what was stored."""
    files = sorted((folder / "traces").iterdir())
    for found in (map(read_json, files), traces_in_bag(folder), messages_in_mcap(folder)):
        by_index = sorted(
            found, key=lambda one: one["index"] if isinstance(one, dict) else one.index
        )
        assert len(by_index) == len(traces)
        for trace, values in zip(traces, by_index):
            assert_same_numbers(trace, values)


def finish(kit: Kit, folder: Path, reopened, traces=TRACES) -> None:
    """Store what is missing, end the survey, and check that it is whole."""
    stored = set(reopened.stored_indices)
    fill(kit, [trace for trace in traces if trace.index not in stored])
    assert kit.processing.close_survey(SURVEY, "finished").stored_traces == len(traces)
    assert_whole(folder, traces)
