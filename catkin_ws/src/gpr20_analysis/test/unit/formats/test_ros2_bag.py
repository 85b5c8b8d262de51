"""A recording that is exported to ROS 2: every message equal, by readers of others."""

import shutil
import struct
import sys
from itertools import zip_longest
from pathlib import Path

import mcap_ros1.decoder
import mcap_ros2.decoder
import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from run_seed import draws
from storage_kit import with_bag
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.sample import sample_survey
from gpr20_survey.recording.mcap_writer import McapFile, RecordedMessage

pytestmark = pytest.mark.skipif(sys.version_info < (3, 10), reason="rosbags 0.10 needs Python 3.10")
SAMPLE = sample_survey()
DRAWS = draws(6)


def decoded(path):
    """Yield topic, type, time and value of each message of an MCAP file, in its order."""
    factories = [mcap_ros1.decoder.DecoderFactory(), mcap_ros2.decoder.DecoderFactory()]
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=factories)
        messages = reader.iter_decoded_messages(log_time_order=False)
        for schema, channel, message, value in messages:
            assert schema is not None and message.publish_time == message.log_time
            yield channel.topic, schema.name.replace("/msg/", "/"), message.log_time, value


def exported(bag):
    """Yield the messages of a bag of ROS 2."""
    (path,) = bag.glob("*.mcap")
    return decoded(path)


def differences(recording, bag):
    """Return what differs between an MCAP file of ROS 1 and a bag of ROS 2, in order of time."""
    found = []
    both = (
        sorted(one, key=lambda it: (it[2], it[0])) for one in (decoded(recording), exported(bag))
    )
    for number, (one, two) in enumerate(zip_longest(*both)):
        if one is None or two is None:
            return [*found, f"only one has message {number}"]
        if one[:3] != two[:3] or not same(one[3], two[3]):
            found.append(f"message {number}: {one} {two}")
    return found


def same(one, two):
    """Return whether a value of ROS 1 is that of ROS 2, bit for bit; a Header has no `seq`."""
    if hasattr(one, "nsecs"):
        return bool((one.secs, one.nsecs) == (two.sec, two.nanosec))
    if hasattr(one, "__slots__"):
        kind = getattr(one, "_type", "")
        names = [name for name in one.__slots__ if (kind, name) != ("std_msgs/Header", "seq")]
        return all(same(getattr(one, name), getattr(two, name)) for name in names)
    if isinstance(one, float):
        return struct.pack("<d", one) == struct.pack("<d", two)
    if isinstance(one, (list, tuple, bytes)):
        return len(one) == len(two) and all(map(same, one, two))
    return bool(one == two)


def write_mcap(path, messages):
    """Write a recording as the storage does; each message in a chunk of its own."""
    file = McapFile(path)
    for one in messages:
        file.write_alone(one)
    file.finish()
    return path


def export(survey, output, *more):
    return main(["export", str(survey), str(output), "--format", "ros2", *more])


TYPES = get_typestore(Stores.ROS1_NOETIC)


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    bag = tmp_path_factory.mktemp("sample") / "sample"
    assert export(SAMPLE, bag) == 0
    return bag


def test_a_recorded_survey_comes_to_ros2_equal(sample):
    assert differences(SAMPLE, sample) == []
    assert sum(topic == "/trace" for topic, *_ in exported(sample)) == 2 * 21 * 21


def test_others_read_its_metadata(sample):
    with AnyReader([sample]) as reader:
        assert reader.message_count == len(list(exported(sample)))
        assert reader.topics["/trace"].msgtype == "gpr20_msgs/msg/Trace"


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


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    place = tmp_path_factory.mktemp("w")
    folder = with_bag(make_survey(place, len(POINTS), "finished", recorded=True))
    return folder, list(decoded(folder / "survey.mcap"))


def in_order(messages):
    return sorted(map(repr, messages))  # rosbags has no order of equal times


def test_a_folder_gives_what_its_recording_holds_also_without_its_mcap(whole, tmp_path):
    folder, messages = whole
    assert export(folder, tmp_path / "one") == 0
    assert len(messages) == len(list(exported(tmp_path / "one")))
    copy = Path(shutil.copytree(str(folder), str(tmp_path / "copy")))
    (copy / "survey.mcap").unlink()
    assert export(copy, tmp_path / "two") == 0
    of_mcap, of_bag = (in_order(exported(tmp_path / name)) for name in ("one", "two"))
    assert of_mcap == of_bag


@pytest.mark.parametrize("is_cut", [True, False])
def test_of_a_damaged_recording_what_is_whole_is_exported_and_the_damage_is_named(
    whole, tmp_path, capsys, is_cut
):
    folder, _messages = whole
    assert export(folder, tmp_path / "good") == 0
    good = in_order(exported(tmp_path / "good"))
    content = (folder / "survey.mcap").read_bytes()
    path, lengths = tmp_path / "survey.mcap", set()
    for seed in range(DRAWS):
        rng = np.random.default_rng(seed)
        changed, place = bytearray(content), int(rng.integers(len(content)))
        changed[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(changed[:place] if is_cut else changed)
        capsys.readouterr()
        status = export(path, tmp_path / str(seed))
        if status == 3:  # its beginning, which says what it is
            continue
        found = in_order(exported(tmp_path / str(seed)))
        assert set(good).issuperset(found), seed
        lengths.add(len(found))
        if is_cut or len(found) < len(good):
            assert status in (1, 2) and capsys.readouterr().err, seed
    assert min(lengths) < len(good)


@pytest.mark.parametrize("name", ["empty.mcap", "none.mcap", "folder", "ros2.mcap"])
def test_what_has_no_messages_of_ros1_is_refused_and_leaves_nothing(name, sample, tmp_path):
    path = tmp_path / "in" / name
    path.parent.mkdir()
    if name == "folder":
        path.mkdir()
    elif name == "ros2.mcap":
        shutil.copy(str(next(sample.glob("*.mcap"))), str(path))
    elif name == "none.mcap":
        write_mcap(path, [])
    else:
        path.write_bytes(b"")
    assert export(path, tmp_path / "out" / "bag") == 3
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())
