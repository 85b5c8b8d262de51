from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

rosbag = pytest.importorskip("rosbag")  # part of ROS; all else here runs without it

from rosbags.rosbag1 import Reader  # noqa: E402
from storage_kit import TYPES, Kit, text_message  # noqa: E402
from trace_examples import SURVEY, assert_same_numbers, make_trace  # noqa: E402

from gpr20_survey.recording.bag_writer import BagFile  # noqa: E402

HEADER_BYTES = 13 + 4096
TRACES = [make_trace(index) for index in range(4)]


def open_bag(folder, *_arguments):
    return [BagFile(folder / "survey.bag")]


@pytest.fixture
def folder(tmp_path):
    kit = Kit(tmp_path / "data", open_bag)
    kit.processing.record(text_message("/status", "idle", latching=True))
    folder = kit.open()
    for trace in TRACES:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)
        shutil.copy(str(folder / "survey.bag"), str(tmp_path / f"after_{trace.index}.bag"))
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    return folder


def read_bag(path):
    with rosbag.Bag(str(path)) as bag:
        return [(topic, message, time) for topic, message, time in bag.read_messages()]


def reindexed(path: Path, content: bytes):
    """Return what a bag holds after the stock repair."""
    path.write_bytes(content)
    with rosbag.Bag(str(path), "a", allow_unindexed=True) as bag:
        for _ in bag.reindex():
            pass
    return [message for topic, message, _ in read_bag(path) if topic == "/trace"]


def assert_traces(messages, least):
    assert len(messages) >= least
    for trace, message in zip(TRACES, messages):
        assert_same_numbers(trace, message)


def test_the_stock_reader_finds_every_trace_with_the_same_numbers(folder):
    found = read_bag(folder / "survey.bag")
    assert_traces([message for topic, message, _ in found if topic == "/trace"], 4)
    texts = [message.data for topic, message, _ in found if topic == "/t"]
    assert texts == [f"before {index}" for index in range(4)]
    assert all(time.to_nsec() > 0 for _, _, time in found)


def test_another_reader_finds_the_same(folder):
    with Reader(folder / "survey.bag") as reader:
        traces = [
            TYPES.deserialize_ros1(data, "gpr20_msgs/msg/Trace")
            for connection, _, data in reader.messages()
            if connection.topic == "/trace"
        ]
    assert len(traces) == 4
    assert_traces(traces, 4)


def test_a_latched_topic_is_marked_so_that_a_replay_latches_it(folder):
    with rosbag.Bag(str(folder / "survey.bag")) as bag:
        latching = {
            connection.topic: connection.header["latching"]
            for connection in bag._connections.values()
        }
    assert latching["/status"] == latching["/survey_metadata"] == b"1"
    assert latching["/t"] == latching["/trace"] == b"0"


def test_reindexing_a_bag_cut_anywhere_keeps_every_acknowledged_trace(folder, tmp_path):
    acknowledged = (tmp_path / "after_2.bag").read_bytes()
    longer = (tmp_path / "after_3.bag").read_bytes()
    shared = next(place for place, (a, b) in enumerate(zip(acknowledged, longer)) if a != b)
    for cut in range(shared, len(longer) + 1):
        # A torn write leaves the former bytes behind the cut.
        content = longer[:cut] + acknowledged[cut:]
        traces = reindexed(tmp_path / "cut.bag", content)
        assert_traces(traces, 3)
        assert len(traces) <= 4
    assert len(reindexed(tmp_path / "cut.bag", longer)) == 4


def torn_states(content, writes, step):
    """Yield the file as it is when its writer dies within any of its writes."""
    for offset, data in writes:
        for length in [*range(0, len(data), step), len(data)]:
            torn = bytearray(content)
            torn[offset : offset + length] = data[:length]
            yield bytes(torn)
        content = torn


def test_reindexing_a_bag_cut_while_it_was_finished_keeps_every_trace(tmp_path, monkeypatch):
    kit = Kit(tmp_path / "data", open_bag)
    folder = kit.open()
    for trace in TRACES:
        kit.processing.store(trace)
    acknowledged = (folder / "survey.bag").read_bytes()
    writes = []
    real_pwrite = os.pwrite

    def pwrite(descriptor, data, offset):
        writes.append((offset, bytes(data)))
        return real_pwrite(descriptor, data, offset)

    with monkeypatch.context() as patch:
        patch.setattr(os, "pwrite", pwrite)
        kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    # The header comes last; its fields lie in one sector, which a disk writes whole.
    index_writes = [write for write in writes if write[0] > HEADER_BYTES]
    assert index_writes == writes[: len(index_writes)]
    # The last status in a chunk of its own, then the index.
    assert len(index_writes) == 3
    for content in torn_states(acknowledged, index_writes, step=13):
        assert_traces(reindexed(tmp_path / "cut.bag", content), 4)


def test_reindexing_a_whole_bag_keeps_every_trace(folder, tmp_path):
    content = (folder / "survey.bag").read_bytes()
    assert_traces(reindexed(tmp_path / "whole.bag", content), 4)


def test_a_file_is_never_overwritten(folder):
    before = (folder / "survey.bag").read_bytes()
    with pytest.raises(FileExistsError):
        BagFile(folder / "survey.bag")
    assert (folder / "survey.bag").read_bytes() == before
