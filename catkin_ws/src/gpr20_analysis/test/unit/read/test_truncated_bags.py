"""Bags that were cut off are read without `rosbag reindex`, also those of other programs."""

from __future__ import annotations

import bz2

import numpy as np
import pytest
from run_seed import draws
from survey_kit import POINTS, SURVEY, make_survey, planned_trace

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.recordings import open_recording
from gpr20_analysis.read.unindexed_bag import complete_messages
from gpr20_survey.recording import bag_format

ALL = len(POINTS)
DRAWS = draws(10)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished", recorded=True)


@pytest.fixture(scope="module")
def content(folder):
    return (folder / "survey.bag").read_bytes()


@pytest.fixture(scope="module")
def messages(folder):
    with (folder / "survey.bag").open("rb") as stream:
        return list(complete_messages(stream))


def indices(path):
    """Return the index of each trace that is read, in order of the file."""
    survey = load_survey(path, accept_damaged=True)
    return sorted(survey["index"].values[survey["index"].values >= 0].tolist())


@pytest.mark.parametrize("name", ["survey.bag", "survey.bag.active"])
def test_whole_messages_of_a_bag_cut_anywhere_are_read(folder, content, messages, tmp_path, name):
    traces = [one for one in messages if one.datatype == "gpr20_msgs/Trace"]
    good = load_survey(folder)
    path = tmp_path / name
    for seed in range(DRAWS):
        rng = np.random.default_rng(seed)
        size = int(rng.integers(bag_format.DATA_START, len(content)))
        path.write_bytes(content[:size])
        whole = sum(content.find(one.data) + len(one.data) <= size for one in traces)
        opened = open_recording(path)
        found = list(opened.traces)
        assert [one.data for one in found] == [one.data for one in traces[:whole]], size
        assert "cut off" in str(opened.notes[0]), size
        if whole:
            survey = load_survey(path, accept_damaged=True)
            present = survey["index"].values >= 0
            assert present.sum() == whole, size
            np.testing.assert_array_equal(survey.s21.values[present], good.s21.values[present])


def foreign(messages, compression, torn):
    """Return a bag as `rosbag record` writes it: many messages in a chunk, no index."""
    connections, records = {}, b""
    for one in messages:
        number = connections.setdefault(one.topic, len(connections))
        if number == len(connections) - 1:
            records += bag_format.connection_record(
                bag_format.Connection(
                    number, one.topic, one.datatype, one.md5sum, one.definition, False
                )
            )
        records += bag_format.message_record(number, one)
    packed = bz2.compress(records) if compression == b"bz2" else records
    # Fields in another order than the storage's.
    fields = {"size": len(records).to_bytes(4, "little"), "compression": compression}
    chunk = bag_format.record(bag_format.CHUNK, fields, packed)
    if torn:  # a killed recorder has not yet written the length of its chunk
        empty = {"size": bytes(4), "compression": compression}
        chunk = bag_format.record(bag_format.CHUNK, empty, b"") + records[: len(records) * 2 // 3]
    return bag_format.MAGIC + bag_format.file_header(0, 0, 0) + chunk


@pytest.mark.parametrize("compression", [b"none", b"bz2"])
def test_bags_of_another_recorder_are_read_without_an_index(messages, tmp_path, compression):
    path = tmp_path / "record.bag.active"
    path.write_bytes(foreign(messages, compression, torn=False))
    assert indices(path) == list(range(ALL))
    survey = load_survey(path)
    assert survey.attrs["survey_id"] == SURVEY


def test_what_a_killed_recorder_has_written_of_its_last_chunk_is_read(messages, tmp_path):
    path = tmp_path / "record.bag.active"
    path.write_bytes(foreign(messages, b"none", torn=True))
    found = indices(path)
    assert found == list(range(len(found))) and ALL // 2 < len(found) < ALL
    survey = load_survey(path)
    own = planned_trace(3)
    place = np.argwhere(survey["index"].values == 3)[0]
    values = survey.s21.values[tuple(place)]
    np.testing.assert_array_equal(values, own.s21_real + 1j * own.s21_imag)


def test_a_compressed_chunk_that_is_damaged_gives_no_message(messages, tmp_path):
    path = tmp_path / "record.bag"
    damaged = bytearray(foreign(messages, b"bz2", torn=False))
    damaged[len(damaged) // 2] ^= 255
    path.write_bytes(damaged)
    with pytest.raises(AnalysisError):
        load_survey(path)
