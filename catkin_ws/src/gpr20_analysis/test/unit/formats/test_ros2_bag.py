"""A recording that is exported to ROS 2: every message equal, by readers of others."""

from __future__ import annotations

import os
import shutil
import struct
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from random_messages import TYPES, recorded
from ros2_kit import decoded, differences, exported, same
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from survey_kit import POINTS, SURVEY, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import ExportError
from gpr20_analysis.formats.conversion import export_survey
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample.sample_survey import sample_survey
from gpr20_survey.recording.bag_writer import BagFile
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.recording import RecordedMessage

SAMPLE = sample_survey()
DRAWS = int(os.environ.get("GPR20_DAMAGES", "40")) // 2


def write_mcap(path, messages):
    """Write a recording as the storage does; each message in a chunk of its own."""
    file = McapFile(path, {"survey_id": SURVEY}, b'{"simulated": true}', 1)
    for one in messages:
        file.write_alone(one)
    file.finish()
    return path


def write_bag(path, messages):
    file = BagFile(path)
    for one in messages:
        file.write_alone(one)
    file.finish()
    return path


def export(survey, output, *more):
    return main(["export", str(survey), str(output), "--format", "ros2", *more])


def metadata(bag):
    return yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]


@settings(max_examples=20)
@given(messages=st.lists(recorded(), min_size=1, max_size=6))
def test_random_messages_of_every_type_come_to_ros2_equal(messages, tmp_path_factory):
    folder = tmp_path_factory.mktemp("random")
    recording = write_mcap(folder / "r.mcap", messages)
    for source in (recording, write_bag(folder / "r.bag", messages)):
        assert export(source, folder / source.suffix[1:]) == 0
        assert differences(recording, folder / source.suffix[1:]) == []
    shutil.rmtree(str(folder))


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    bag = tmp_path_factory.mktemp("sample") / "sample"
    assert export(SAMPLE, bag) == 0
    return bag


def test_a_recorded_survey_comes_to_ros2_equal(sample):
    assert differences(SAMPLE, sample) == []
    assert sum(topic == "/trace" for topic, *_ in exported(sample)) == 2 * 21 * 21


def test_its_metadata_are_those_that_rosbag2_writes(sample):
    found = metadata(sample)
    times = [one[2] for one in exported(sample)]
    assert (found["version"], found["storage_identifier"]) == (8, "mcap")
    assert found["relative_file_paths"] == ["sample_0.mcap"]
    assert found["message_count"] == len(times)
    assert found["starting_time"] == {"nanoseconds_since_epoch": min(times)}
    assert found["duration"] == {"nanoseconds": max(times) - min(times)}
    assert found["custom_data"]["simulated"] == "true" and "lost" not in found["custom_data"]
    with AnyReader([sample]) as reader:
        assert reader.message_count == len(times)
        assert reader.topics["/trace"].msgtype == "gpr20_msgs/msg/Trace"
    with (sample / "sample_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        (own,) = reader.iter_metadata()
        assert yaml.safe_load(own.metadata["serialized_metadata"]) == found
        assert [one.name for one in reader.iter_attachments()] == ["survey.json"]


@settings(max_examples=5)
@pytest.mark.parametrize("name", ["sensor_msgs/msg/Range", "visualization_msgs/msg/MarkerArray"])
@given(drawn=st.data())
def test_a_type_that_ros2_has_too_is_its_type_there(name, drawn, tmp_path_factory):
    folder = tmp_path_factory.mktemp("types")
    bag = folder / "bag"
    assert export(write_mcap(folder / "r.mcap", [drawn.draw(recorded((name,)))]), bag) == 0
    there = get_typestore(Stores.ROS2_IRON)
    (topic,) = metadata(bag)["topics_with_message_count"]
    assert topic["topic_metadata"]["type_description_hash"] == there.hash_rihs01(name)
    with AnyReader([bag]) as reader:
        ((_connection, _time, found),) = reader.messages()
    assert bytes(there.serialize_cdr(there.deserialize_cdr(found, name), name)) == bytes(found)


def text(topic, content, time_ns, latching=False):
    definition, md5sum = TYPES.generate_msgdef("std_msgs/msg/String")
    data = struct.pack("<I", len(content)) + content
    return RecordedMessage(topic, "std_msgs/String", md5sum, definition, data, time_ns, latching)


def test_late_subscribers_get_what_was_latched_and_nothing_else(tmp_path):
    messages = [text("/latched", b"1", 1, latching=True), text("/other", b"2", 2)]
    assert export(write_mcap(tmp_path / "r.mcap", messages), tmp_path / "bag") == 0
    with AnyReader([tmp_path / "bag"]) as reader:
        qualities = {one.topic: one.ext.offered_qos_profiles for one in reader.connections}
    # By version 0.9 of the reader the text of the file, by later ones its meaning.
    assert "durability: 1\n" in str(qualities["/latched"]) or "TRANSIENT_LOCAL" in str(
        qualities["/latched"]
    )
    assert not qualities["/other"]


def test_two_types_of_one_topic_become_two_topics(tmp_path):
    first, second = text("/it", b"1", 1), text("/it", b"", 2)
    definition, md5sum = TYPES.generate_msgdef("std_msgs/msg/Empty")
    second = replace(
        second, datatype="std_msgs/Empty", md5sum=md5sum, definition=definition, data=b""
    )
    assert export(write_mcap(tmp_path / "r.mcap", [first, second]), tmp_path / "bag") == 0
    assert [one[:2] for one in exported(tmp_path / "bag")] == [
        ("/it", "std_msgs/String"),
        (f"/it_{md5sum[:8]}", "std_msgs/Empty"),
    ]


@pytest.mark.parametrize("compression", [*CompressionType])
def test_an_mcap_file_of_another_writer_comes_to_ros2_equal(compression, tmp_path):
    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, compression=compression)
        writer.start("ros1", "another")
        for number in range(9):
            one = text("/it", b"%d" % number, number)
            schema = writer.register_schema("std_msgs/String", "ros1msg", one.definition.encode())
            channel = writer.register_channel(one.topic, "ros1", schema)
            writer.add_message(channel, one.time_ns, one.data, one.time_ns)
        writer.finish()
    assert export(path, tmp_path / "bag") == 0
    assert differences(path, tmp_path / "bag") == []


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = make_survey(tmp_path_factory.mktemp("w"), len(POINTS), "finished", recorded=True)
    return folder, list(decoded(folder / "survey.mcap"))


def same_messages(one, two):
    return len(one) == len(two) and all(
        first[:3] == second[:3] and same(first[3], second[3]) for first, second in zip(one, two)
    )


def test_a_folder_gives_what_its_recording_holds_also_without_its_mcap(whole, tmp_path):
    folder, messages = whole
    assert export(folder, tmp_path / "one") == 0
    assert metadata(tmp_path / "one")["custom_data"]["made_from"] == "survey.mcap"
    assert same_messages(messages, list(exported(tmp_path / "one")))
    copy = Path(shutil.copytree(str(folder), str(tmp_path / "copy")))
    (copy / "survey.mcap").unlink()
    assert export(copy, tmp_path / "two") == 0
    assert metadata(tmp_path / "two")["custom_data"]["made_from"] == "survey.bag"
    # The bag has one more: an MCAP file has survey.json as an attachment.
    others = [one for one in exported(tmp_path / "two") if one[0] != "/survey_metadata"]
    known = [one for one in messages if one[0] != "/survey_metadata"]
    assert same_messages(known, others)


@pytest.mark.parametrize("name", ["survey.mcap", "survey.bag"])
def test_of_a_recording_cut_anywhere_what_is_whole_is_exported_and_the_cut_is_named(
    whole, name, tmp_path, capsys
):
    folder, _messages = whole
    assert export(folder / name, tmp_path / "good") == 0
    good = list(exported(tmp_path / "good"))
    content = (folder / name).read_bytes()
    path, lengths = tmp_path / name, set()
    for seed in range(DRAWS):
        path.write_bytes(content[: int(np.random.default_rng(seed).integers(len(content)))])
        capsys.readouterr()
        status = export(path, tmp_path / "bag", "--overwrite")
        if status == 3:  # no message was there yet
            continue
        found = list(exported(tmp_path / "bag"))
        assert same_messages(good[: len(found)], found), seed
        assert status == 1 and "cut off" in capsys.readouterr().err, seed
        assert "cut off" in metadata(tmp_path / "bag")["custom_data"]["lost"], seed
        lengths.add(len(found))
    assert len(lengths) > 1


def test_what_a_flipped_byte_destroys_is_named_and_the_rest_is_exported(whole, tmp_path, capsys):
    folder, good = whole
    content = (folder / "survey.mcap").read_bytes()
    path, damaged = tmp_path / "survey.mcap", 0
    keys = [(topic, time) for topic, _type, time, _value in good]
    for seed in range(DRAWS):
        rng = np.random.default_rng(seed)
        changed = bytearray(content)
        changed[int(rng.integers(len(content)))] ^= 1 << int(rng.integers(8))
        path.write_bytes(changed)
        capsys.readouterr()
        status = export(path, tmp_path / "bag", "--overwrite")
        if status == 3:  # its beginning, which says what it is
            continue
        found = list(exported(tmp_path / "bag"))
        left = iter(zip(keys, good))
        for one in found:
            original = next(that for key, that in left if key == (one[0], one[2]))
            assert same(original[3], one[3]), seed
        if len(found) < len(good):
            damaged += 1
            assert status in (1, 2) and capsys.readouterr().err, seed
            assert metadata(tmp_path / "bag")["custom_data"]["lost"], seed
    assert damaged > 0


def test_a_damaged_message_of_a_bag_is_named_by_its_topic(tmp_path, capsys):
    bad = replace(text("/bad", b"a", 2), data=b"\xff\xff\0\0")
    recording = write_bag(tmp_path / "r.bag", [text("/good", b"1", 1), bad, text("/bad", b"3", 3)])
    assert export(recording, tmp_path / "bag") == 2
    assert "1 messages of /bad are damaged" in capsys.readouterr().err
    assert [one[0] for one in exported(tmp_path / "bag")] == ["/good", "/bad"]


@pytest.mark.parametrize("name", ["survey.json", "empty.mcap", "none.mcap", "folder", "ros2.mcap"])
def test_what_has_no_messages_of_ros1_is_refused_and_leaves_nothing(name, sample, tmp_path):
    path = tmp_path / "in" / name
    path.parent.mkdir()
    if name == "folder":
        path.mkdir()
    elif name == "ros2.mcap":
        shutil.copy(str(sample / "sample_0.mcap"), str(path))
    elif name == "none.mcap":
        write_mcap(path, [])
    else:
        path.write_bytes(b"")
    assert export(path, tmp_path / "out" / "bag") == 3
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_another_folder_is_never_replaced_and_a_bag_only_on_request(whole, tmp_path):
    folder, messages = whole
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("")
    assert export(folder, tmp_path / "mine", "--overwrite") == 3
    assert export(folder, tmp_path / "bag") == 0
    assert export(folder, tmp_path / "bag") == 3
    assert export(folder, tmp_path / "bag", "--overwrite") == 0
    assert same_messages(messages, list(exported(tmp_path / "bag")))
    assert export(folder, folder / "bag") == 3


def test_a_recording_is_never_in_memory_as_a_whole(tmp_path):
    noise = np.random.default_rng(1)
    messages = (text("/it", noise.bytes(10**6), number) for number in range(60))
    recording = write_mcap(tmp_path / "r.mcap", messages)
    tracemalloc.start()
    try:
        assert export(recording, tmp_path / "bag") == 0
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert recording.stat().st_size > 60e6 and peak < 20e6


def test_a_dataset_which_has_no_messages_is_refused(whole, tmp_path):
    with pytest.raises(ExportError, match="gpr20 export"):
        export_survey(load_survey(whole[0]), tmp_path / "bag", "ros2")
    assert not list(tmp_path.iterdir())
