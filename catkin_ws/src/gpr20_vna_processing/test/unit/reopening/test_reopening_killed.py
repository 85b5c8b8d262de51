"""A storage that is killed at any of its calls of the disk while it reopens a survey."""

from __future__ import annotations

import importlib.util
import os
import shutil

import pytest
from planned_survey import METADATA, POINTS, planned_trace
from reopening_kit import assert_whole, messages_in_mcap
from storage_kit import Kit, text_message
from trace_examples import SURVEY

from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.recording.bag_format import MAGIC, chunk_record, file_header
from gpr20_survey.recording.bag_writer import EMPTY_CHUNK
from gpr20_survey.recording.recordings import open_recordings

TRACES = [planned_trace(index) for index in range(len(POINTS))]
STORED = 4
CALLS = ("pwrite", "fsync", "ftruncate", "link", "unlink", "replace", "mkdir")
KILLED, DONE = 9, 0
STOCK_TOOLS = importlib.util.find_spec("rosbag") is not None  # part of ROS


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """A survey that was stopped: its recordings have their index."""
    data = tmp_path_factory.mktemp("stopped") / "data"
    kit = Kit(data, open_recordings)
    kit.open(metadata_json=METADATA)
    kit.processing.record(text_message("/t", "early"))
    for trace in TRACES[:STORED]:
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    return data


def damage(folder) -> None:
    """Remove a trace's file and change a number of another in the bag."""
    sorted((folder / "traces").iterdir())[1].unlink()
    bag = bytearray((folder / "survey.bag").read_bytes())
    bag[bag.index(TRACES[2].s21_real.tobytes()) + 3] ^= 1
    (folder / "survey.bag").write_bytes(bag)


def tear(folder) -> None:
    """Leave a bag as a kill in the middle of a commit leaves it."""
    content = (folder / "survey.bag").read_bytes()
    end = content.rindex(EMPTY_CHUNK)
    head = MAGIC + file_header(0, 0, 0)
    torn = chunk_record(bytes(3000))[:600]
    (folder / "survey.bag").write_bytes(head + content[len(head) : end] + torn)


def die_at(number: int) -> None:
    """Let this process die in its n-th call of the disk; a write is torn in its middle."""
    calls = []
    real_pwrite = os.pwrite

    def dying(name, real):
        def call(*arguments, **options):
            calls.append(name)
            if len(calls) < number:
                return real(*arguments, **options)
            if name == "pwrite":
                descriptor, data, offset = arguments
                real_pwrite(descriptor, bytes(data)[: len(data) // 2], offset)
            os._exit(KILLED)

        return call

    for name in CALLS:
        setattr(os, name, dying(name, getattr(os, name)))


def reopen_and_store_until(data, number: int) -> int:
    """Reopen and store one trace in a process of its own; return how it ended."""
    child = os.fork()
    if child:
        return os.WEXITSTATUS(os.waitpid(child, 0)[1])
    try:
        die_at(number)
        kit = Kit(data, open_recordings)
        kit.processing.reopen_survey(SURVEY)
        kit.processing.store(TRACES[STORED])
        os._exit(DONE)
    finally:
        os._exit(1)


def indices_after_stock_repair(folder, place):
    """Return which traces `rosbag reindex` makes readable in a copy of the bag."""
    import rosbag

    path = str(shutil.copy(str(folder / "survey.bag"), str(place / "copy.bag")))
    with rosbag.Bag(path, "a", allow_unindexed=True) as bag:
        for _ in bag.reindex():
            pass
    with rosbag.Bag(path) as bag:
        return [message.index for _, message, _ in bag.read_messages(topics=["/trace"])]


def damage_log(folder) -> None:
    """Change a byte of log.jsonl, and one of the MCAP, which is rebuilt."""
    for name in ("log.jsonl", "survey.mcap"):
        content = bytearray((folder / name).read_bytes())
        content[len(content) // 2] ^= 1
        (folder / name).write_bytes(content)


@pytest.mark.parametrize("change", [tear, damage, damage_log])
def test_a_survey_survives_a_kill_at_any_instant_of_its_reopening(stopped, tmp_path, change):
    number, ending = 0, KILLED
    while ending == KILLED:
        number += 1
        data = tmp_path / str(number)
        shutil.copytree(str(stopped), str(data))
        (folder,) = data.iterdir()
        change(folder)
        ending = reopen_and_store_until(data, number)
        assert ending in (KILLED, DONE)
        if change is tear and STOCK_TOOLS:
            assert indices_after_stock_repair(folder, tmp_path)[:STORED] == list(range(STORED))
        kit = Kit(data, open_recordings)
        reopened = kit.processing.reopen_survey(SURVEY)
        assert reopened.stored_indices[:STORED] == tuple(range(STORED))
        for trace in TRACES[len(reopened.stored_indices) :]:
            kit.processing.store(trace)
        kit.processing.close_survey(SURVEY, "finished")
        kit.processing.shut_down()
        assert_whole(folder, TRACES)
        if change is not damage_log:
            assert [one.data for one in messages_in_mcap(folder, "/t")] == ["early"]
        assert verify_survey(folder).faults == []
        shutil.rmtree(str(data))
    assert number > 20
