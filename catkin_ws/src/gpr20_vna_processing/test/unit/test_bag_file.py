"""The bag of a survey, by the stock tools of ROS; also when it was cut off."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path

import pytest
from run_seed import SEED, draws
from storage_kit import Kit, text_message
from trace_examples import SURVEY, assert_same_numbers, make_trace

from gpr20_survey.recording.bag_writer import BagFile

rosbag = pytest.importorskip("rosbag")  # part of ROS; all else here runs without it
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


def reindexed(path: Path, content: bytes):
    """Return the traces that a bag holds after the stock repair; each is as it was stored."""
    path.write_bytes(content)
    with rosbag.Bag(str(path), "a", allow_unindexed=True) as bag:
        for _ in bag.reindex():
            pass
    with rosbag.Bag(str(path)) as bag:
        messages = [message for _, message, _ in bag.read_messages(topics=["/trace"])]
    for trace, message in zip(TRACES, messages):
        assert_same_numbers(trace, message)
    return messages


def test_the_stock_reader_finds_every_message_and_which_topics_are_latched(folder):
    with rosbag.Bag(str(folder / "survey.bag")) as bag:
        found = list(bag.read_messages())
        connections = bag._connections.values()
        latching = {one.topic: one.header["latching"] for one in connections}
    texts = [message.data for topic, message, _ in found if topic == "/t"]
    assert texts == [f"before {index}" for index in range(4)]
    assert all(time.to_nsec() > 0 for _, _, time in found)
    # So that a replay latches it.
    assert latching["/status"] == latching["/survey_metadata"] == b"1"
    assert latching["/t"] == latching["/trace"] == b"0"


def test_reindexing_a_bag_cut_anywhere_keeps_every_acknowledged_trace(folder, tmp_path):
    acknowledged = (tmp_path / "after_2.bag").read_bytes()
    longer = (tmp_path / "after_3.bag").read_bytes()
    shared = next(place for place, (a, b) in enumerate(zip(acknowledged, longer)) if a != b)
    cuts = random.Random(SEED).sample(range(shared, len(longer)), draws(25))
    for cut in [shared, *cuts]:
        # A torn write leaves the former bytes behind the cut.
        assert len(reindexed(tmp_path / "cut.bag", longer[:cut] + acknowledged[cut:])) in (3, 4)
    for content in (longer, (folder / "survey.bag").read_bytes()):
        assert len(reindexed(tmp_path / "cut.bag", content)) == 4


def test_reindexing_a_bag_cut_while_it_was_finished_keeps_every_trace(tmp_path, monkeypatch):
    kit = Kit(tmp_path / "data", open_bag)
    folder = kit.open()
    for trace in TRACES:
        kit.processing.store(trace)
    content = (folder / "survey.bag").read_bytes()
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
    chance = random.Random(SEED)
    for offset, data in index_writes:
        for length in [*(chance.randrange(len(data)) for _ in range(draws(8))), len(data)]:
            torn = bytearray(content)
            torn[offset : offset + length] = data[:length]
            assert len(reindexed(tmp_path / "cut.bag", bytes(torn))) == 4
        content = torn
