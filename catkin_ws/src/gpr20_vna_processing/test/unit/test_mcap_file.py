"""The MCAP of a survey by its stock readers; cut or changed anywhere, it invents no trace."""

import random
import shutil

import pytest
from run_seed import SEED, draws
from storage_kit import Kit, text_message, torn_mcap_traces
from trace_examples import STARTED_US, SURVEY, assert_same_numbers, make_trace

from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import McapFile, RecordedMessage
from gpr20_vna_processing.mid.stored_traces import RecordedTraces

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(4)]
PRINTS = {trace.index: trace.fingerprint() for trace in TRACES}


@pytest.fixture(scope="module")
def snapshots(tmp_path_factory):
    """Copies of a survey's folder after each trace, and after its end."""
    place = tmp_path_factory.mktemp("torn")
    kit = Kit(place / "data")
    folder = kit.open(metadata_json='{"vna": {"identity": "x"}, "simulated": true}')
    for trace in TRACES:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)
        shutil.copytree(str(folder), str(place / str(trace.index)))
    kit.processing.close_survey(SURVEY, "finished")
    shutil.copytree(str(folder), str(place / "end"))
    kit.processing.shut_down()
    return place


def read(path):
    """Return the prints of the traces that a file holds, and what is wrong in it."""
    found = RecordedTraces(path, SURVEY, lambda _trace: None)
    return found.prints, found.faults


def drawn(first, last, count=12):
    """Return places from the first to before the last, that one and others."""
    return [first, *random.Random(SEED).sample(range(first, last), draws(count))]


def test_a_recording_cut_in_its_last_records_holds_what_was_acknowledged(snapshots, tmp_path):
    acknowledged, longer = ((snapshots / n / "survey.mcap").read_bytes() for n in "23")
    path = tmp_path / "cut"
    for cut in [*drawn(len(acknowledged), len(longer), 25), len(longer)]:
        path.write_bytes(longer[:cut])
        prints, faults = read(path)
        assert faults == []
        assert {index: PRINTS[index] for index in range(3)}.items() <= prints.items()
        assert prints.items() <= PRINTS.items()
        traces = list(torn_mcap_traces(path))
        assert len(traces) == len(prints)
        for trace, message in zip(TRACES, traces):
            assert_same_numbers(trace, message)
    assert prints == PRINTS


def test_a_recording_cut_while_it_was_finished_is_whole_but_for_its_index(snapshots, tmp_path):
    stored, ended = ((snapshots / n / "survey.mcap").read_bytes() for n in ("3", "end"))
    for cut in [*drawn(len(stored), len(ended)), len(ended)]:
        (tmp_path / "cut").write_bytes(ended[:cut])
        assert read(tmp_path / "cut") == (PRINTS, [])
    for cut in range(40):
        (tmp_path / "cut").write_bytes(ended[:cut])
        assert read(tmp_path / "cut") == ({}, [])


OLD, NEW = "7b530785257ca423f317a80d75c5dad5", "0123456789abcdef0123456789abcdef"


def test_the_first_type_of_a_topic_has_its_name_and_others_have_their_own(tmp_path):
    file = McapFile(tmp_path / "a.mcap")
    for md5sum in (OLD, NEW, OLD, NEW):
        file.write(RecordedMessage("/status", "a/Status", md5sum, "", b"", 1))
    # A copy of it, as when the survey is resumed, goes on with the names.
    file.commit()
    copy = McapFile(tmp_path / "b.mcap")
    for one in StoredMcap(tmp_path / "a.mcap").messages():
        copy.write(one)
    copy.write(RecordedMessage("/status", "a/Status", NEW, "", b"", 1))
    copy.commit()
    names = [one.topic for one in StoredMcap(tmp_path / "b.mcap").messages()]
    assert names == ["/status", "/status_01234567"] * 2 + ["/status_01234567"]
