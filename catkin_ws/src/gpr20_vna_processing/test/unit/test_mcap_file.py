from __future__ import annotations

import io
import json
import shutil
import struct

import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros1.decoder import DecoderFactory
from storage_kit import Kit, text_message
from trace_examples import STARTED_US, SURVEY, assert_same_numbers, make_trace

from gpr20_survey.recording.mcap_writer import McapFile

TRACES = [make_trace(index) for index in range(4)]


@pytest.fixture
def folder(tmp_path):
    kit = Kit(tmp_path / "data")
    folder = kit.open(metadata_json='{"vna": {"identity": "x"}, "simulated": true}')
    for trace in TRACES:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)
        shutil.copy(str(folder / "survey.mcap"), str(tmp_path / f"after_{trace.index}.mcap"))
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    return folder


def read_forward(content, factory=None):
    """Return the messages up to the first record that cannot be read.

    Pieces of one file may share a factory, which makes the classes of its types once.
    """
    factories = [factory or DecoderFactory()]
    reader = NonSeekingReader(io.BytesIO(content), decoder_factories=factories)
    found = []
    try:
        for _, channel, _, message in reader.iter_decoded_messages(log_time_order=False):
            found.append((channel.topic, message))
    except (McapError, EOFError, struct.error):
        return found  # what the stock reader raises at a torn record
    return found


def traces_of(found):
    return [message for topic, message in found if topic == "/trace"]


def test_the_stock_reader_finds_every_trace_with_the_same_numbers(folder):
    with open(folder / "survey.mcap", "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros1"
        found = list(reader.iter_decoded_messages(topics=["/trace"]))
        statistics = reader.get_summary().statistics
    assert len(found) == len(TRACES)
    for trace, (schema, _, record, message) in zip(TRACES, found):
        assert (schema.name, schema.encoding) == ("gpr20_msgs/Trace", "ros1msg")
        assert_same_numbers(trace, message)
        assert record.log_time > 0
    assert statistics.message_start_time > 0
    assert statistics.metadata_count == statistics.attachment_count == 1


def test_the_survey_is_described_inside_the_file(folder):
    with open(folder / "survey.mcap", "rb") as stream:
        reader = make_reader(stream)
        metadata = next(iter(reader.iter_metadata()))
        attachment = next(iter(reader.iter_attachments()))
    assert metadata.metadata["survey_id"] == SURVEY
    assert json.loads(metadata.metadata["vna"]) == {"identity": "x"}
    assert json.loads(attachment.data)["simulated"] is True
    assert attachment.log_time == STARTED_US * 1000


def test_each_trace_has_a_chunk_of_its_own(folder):
    with open(folder / "survey.mcap", "rb") as stream:
        summary = make_reader(stream).get_summary()
    names = {number: channel.topic for number, channel in summary.channels.items()}
    topics = [
        sorted(names[number] for number in chunk.message_index_offsets)
        for chunk in summary.chunk_indexes
    ]
    assert topics.count(["/trace"]) == len(TRACES)
    assert sum("/trace" in one for one in topics) == len(TRACES)


def test_a_file_cut_anywhere_behind_an_acknowledged_trace_still_has_it(folder, tmp_path):
    acknowledged = (tmp_path / "after_2.mcap").read_bytes()
    longer = (tmp_path / "after_3.mcap").read_bytes()
    assert longer.startswith(acknowledged)
    factory = DecoderFactory()
    for cut in range(len(acknowledged), len(longer) + 1):
        traces = traces_of(read_forward(longer[:cut], factory))
        assert len(traces) in (3, 4)
        for trace, message in zip(TRACES, traces):
            assert_same_numbers(trace, message)
    assert len(traces_of(read_forward(longer))) == 4


def test_a_file_is_never_overwritten(folder):
    before = (folder / "survey.mcap").read_bytes()
    with pytest.raises(FileExistsError):
        McapFile(folder / "survey.mcap", {}, b"{}", 1)
    assert (folder / "survey.mcap").read_bytes() == before
