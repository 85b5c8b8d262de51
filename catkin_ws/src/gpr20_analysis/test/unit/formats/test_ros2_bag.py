"""A recording that is exported to ROS 2: every message equal, by readers of others."""

import shutil
import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from ros2_kit import decoded, differences, exported, same
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.stores.ros1_noetic import FIELDDEFS
from run_seed import draws
from survey_kit import MESSAGES, POINTS, SURVEY, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.sample.sample_survey import sample_survey
from gpr20_survey.recording.bag_writer import BagFile
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.recording import RecordedMessage

SAMPLE = sample_survey()
DRAWS = draws(6)


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


# Those of the robot, and what rosbags does not know.
OWN = get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage")
for path in sorted(MESSAGES.glob("*.msg")):
    OWN.update(get_types_from_msg(path.read_text(), f"gpr20_msgs/msg/{path.stem}"))
TYPES = get_typestore(Stores.ROS1_NOETIC)
TYPES.register(OWN)
FIELDS = {**FIELDDEFS, **OWN}
# Those of ROS that the robot records, and what is special: no field, lists of lists.
OTHERS = (
    *("actionlib_msgs/msg/GoalStatusArray", "diagnostic_msgs/msg/DiagnosticArray"),
    *("rosgraph_msgs/msg/Log", "sensor_msgs/msg/Image", "sensor_msgs/msg/JointState"),
    *("sensor_msgs/msg/Range", "sensor_msgs/msg/PointCloud2", "std_msgs/msg/Empty"),
    *("std_msgs/msg/String", "std_msgs/msg/Float64MultiArray"),
    *("visualization_msgs/msg/Marker", "visualization_msgs/msg/MarkerArray"),
)
TEXTS = st.text(st.characters(blacklist_categories=("Cs",), blacklist_characters="\0"), max_size=9)


def of_kind(kind):
    """Return the strategy for a field."""
    node, inside = kind
    if node == Nodetype.NAME:
        return of_type(inside)
    if node == Nodetype.BASE:
        return of_base(inside[0])
    (item_node, item), size = inside
    most = {"min_size": size, "max_size": size or 3}
    many = st.lists(of_kind(inside[0]), **most)
    if item_node == Nodetype.NAME or item[0] == "string":
        return many
    dtype = {"byte": "int8", "char": "uint8"}.get(item[0], item[0])
    return many.map(lambda found: np.array(found, dtype=dtype))


def of_base(name):
    if name == "string":
        return TEXTS
    if name == "bool":
        return st.booleans()
    if name.startswith("float"):
        return st.floats(width=int(name[5:]))
    if name == "byte":  # it has a sign in ROS 1 alone
        return st.integers(0, 127)
    limits = np.iinfo("uint8" if name == "char" else name)
    return st.integers(int(limits.min), int(limits.max))


def of_type(name):
    if name.startswith("builtin_interfaces/"):  # time and duration, as ROS 1 normalizes them
        make = TYPES.types[name]
        return st.builds(make, st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1))
    fields = FIELDS[name][1]
    if not fields or fields[0][0] == "structure_needs_at_least_one_member":
        return st.builds(TYPES.types[name])
    return st.builds(TYPES.types[name], *(of_kind(kind) for _field, kind in fields))


@st.composite
def recorded(draw, names=(*OWN, *OTHERS)):
    name = draw(st.sampled_from(names))
    definition, md5sum = TYPES.generate_msgdef(name)
    data = bytes(TYPES.serialize_ros1(draw(of_type(name)), name))
    datatype = name.replace("/msg/", "/")
    return RecordedMessage(
        f"/some/{name.split('/')[-1].lower()}",
        *(datatype, md5sum, definition, data, draw(st.integers(1, 2**61)), draw(st.booleans())),
    )


@settings(max_examples=draws(5))
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
    definition, md5sum = TYPES.generate_msgdef("std_msgs/msg/Empty")
    first, second = (
        text("/it", b"1", 1),
        RecordedMessage("/it", "std_msgs/Empty", md5sum, definition, b"", 2),
    )
    assert export(write_mcap(tmp_path / "r.mcap", [first, second]), tmp_path / "bag") == 0
    assert [one[:2] for one in exported(tmp_path / "bag")] == [
        ("/it", "std_msgs/String"),
        (f"/it_{md5sum[:8]}", "std_msgs/Empty"),
    ]


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


@pytest.mark.parametrize("name", ["empty.mcap", "none.mcap", "folder", "ros2.mcap"])
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
