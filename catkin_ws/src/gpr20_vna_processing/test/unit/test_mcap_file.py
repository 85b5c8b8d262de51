"""The MCAP of a survey by its stock readers; cut or changed anywhere, it invents no trace.

So does the bag.
"""

import io
import json
import random
import shutil
import struct

import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros1.decoder import DecoderFactory
from run_seed import SEED, draws
from storage_kit import Kit, bag_messages, text_message
from trace_examples import STARTED_US, SURVEY, assert_same_numbers, make_trace

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.recording.survey_topics import recorded_trace

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(4)]
PRINTS = {trace.index: trace.fingerprint() for trace in TRACES}
DECODERS = DecoderFactory()


@pytest.fixture(scope="module")
def snapshots(tmp_path_factory):
    """Copies of a survey's folder after each trace, and after its end."""
    place = tmp_path_factory.mktemp("torn")
    kit = Kit(place / "data", open_recordings)
    folder = kit.open(metadata_json='{"vna": {"identity": "x"}, "simulated": true}')
    for trace in TRACES:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)
        shutil.copytree(str(folder), str(place / str(trace.index)))
    kit.processing.close_survey(SURVEY, "finished")
    shutil.copytree(str(folder), str(place / "end"))
    kit.processing.shut_down()
    return place


def read_forward(content):
    """Return the traces up to the first record that the stock reader cannot read."""
    reader = NonSeekingReader(io.BytesIO(content), decoder_factories=[DECODERS])
    found = []
    try:
        for _, channel, _, message in reader.iter_decoded_messages(log_time_order=False):
            if channel.topic == "/trace":
                found.append(message)
    except (McapError, EOFError, struct.error):
        return found  # what the stock reader raises at a torn record
    return found


def read(kind, path):
    """Return the prints of the traces that a file holds, and what is wrong in it.

    Nobody says of a bag whether it is whole to its end.
    """
    mcap = StoredMcap(path)
    prints, wrong = {}, 0
    for message in bag_messages(path) if kind == "bag" else mcap.messages():
        try:
            trace = recorded_trace(message)
        except TraceRefusedError:
            wrong += 1
            continue
        if trace is None and message.topic == "/trace":
            wrong += 1  # its type is damaged
        elif trace is not None and trace.index in prints:
            wrong += 1
        elif trace is not None:
            prints[trace.index] = trace.fingerprint()
    return prints, [*mcap.faults, *["damaged trace"] * wrong]


def drawn(first, last, count=12):
    """Return places from the first to before the last, that one and others."""
    return [first, *random.Random(SEED).sample(range(first, last), draws(count))]


def test_the_survey_is_described_inside_the_file(snapshots):
    with open(snapshots / "end" / "survey.mcap", "rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros1"
        metadata = next(iter(reader.iter_metadata()))
        attachment = next(iter(reader.iter_attachments()))
    assert metadata.metadata["survey_id"] == SURVEY
    assert json.loads(metadata.metadata["vna"]) == {"identity": "x"}
    assert json.loads(attachment.data)["simulated"] is True
    assert attachment.log_time == STARTED_US * 1000


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_recording_cut_in_its_last_records_holds_what_was_acknowledged(kind, snapshots, tmp_path):
    acknowledged, longer = ((snapshots / n / f"survey.{kind}").read_bytes() for n in "23")
    shared = next(place for place, (a, b) in enumerate(zip(acknowledged + b"\0", longer)) if a != b)
    path = tmp_path / "cut"
    for cut in [*drawn(shared, len(longer), 25), len(longer)]:
        # The empty chunk that ends a bag is still there until it is written over.
        path.write_bytes(longer[:cut] + (acknowledged[cut:] if kind == "bag" else b""))
        prints, faults = read(kind, path)
        assert faults == []
        assert {index: PRINTS[index] for index in range(3)}.items() <= prints.items()
        assert prints.items() <= PRINTS.items()
        if kind == "mcap":
            traces = read_forward(path.read_bytes())
            assert len(traces) == len(prints)
            for trace, message in zip(TRACES, traces):
                assert_same_numbers(trace, message)
    assert prints == PRINTS


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_recording_cut_while_it_was_finished_is_whole_but_for_its_index(
    kind, snapshots, tmp_path
):
    stored, ended = ((snapshots / n / f"survey.{kind}").read_bytes() for n in ("3", "end"))
    for cut in [*drawn(len(stored), len(ended)), len(ended)]:
        (tmp_path / "cut").write_bytes(stored[:100] + ended[100:cut])
        assert read(kind, tmp_path / "cut") == (PRINTS, [])


def test_two_damaged_traces_are_passed_over_and_the_next_is_read(snapshots, tmp_path):
    changed = bytearray((snapshots / "end" / "survey.mcap").read_bytes())
    lengths = [len((snapshots / f"{index}" / "survey.mcap").read_bytes()) for index in range(4)]
    for middle in ((lengths[0] + lengths[1]) // 2, (lengths[1] + lengths[2]) // 2):
        changed[middle : middle + 40] = bytes(40)
    (tmp_path / "changed").write_bytes(changed)
    prints, faults = read("mcap", tmp_path / "changed")
    assert faults
    assert prints == {index: PRINTS[index] for index in prints}
    assert {0, 3} <= prints.keys()
    assert not {1, 2} <= prints.keys()
