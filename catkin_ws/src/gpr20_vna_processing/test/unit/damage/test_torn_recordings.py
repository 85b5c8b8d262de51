"""Files cut or changed at every byte: reading them never fails and never invents a trace."""

from __future__ import annotations

import shutil

import pytest
from storage_kit import Kit, text_message
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_analysis.read.unindexed_bag import complete_messages
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.folder import trace_files
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.recording.survey_topics import recorded_trace
from gpr20_survey.trace import trace_json

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(4)]
PRINTS = {trace.index: trace.fingerprint() for trace in TRACES}


@pytest.fixture(scope="module")
def snapshots(tmp_path_factory):
    """Copies of a survey's folder after its third and its fourth trace, and after its end."""
    place = tmp_path_factory.mktemp("torn")
    kit = Kit(place / "data", open_recordings)
    folder = kit.open()
    for trace in TRACES:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)
        shutil.copytree(str(folder), str(place / str(trace.index)))
    kit.processing.close_survey(SURVEY, "finished")
    shutil.copytree(str(folder), str(place / "end"))
    kit.processing.shut_down()
    return place


def read(kind, path):
    """Return the prints of the traces that a file holds, and what is wrong in it.

    Nobody says of a bag whether it is whole to its end.
    """
    mcap = StoredMcap(path)
    prints, wrong = {}, 0
    for message in complete_messages(path) if kind == "bag" else mcap.messages():
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


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_recording_cut_at_any_byte_of_its_last_records_holds_what_was_acknowledged(
    kind, snapshots, tmp_path
):
    acknowledged = (snapshots / "2" / f"survey.{kind}").read_bytes()
    longer = (snapshots / "3" / f"survey.{kind}").read_bytes()
    shared = next(place for place, (a, b) in enumerate(zip(acknowledged + b"\0", longer)) if a != b)
    path = tmp_path / "cut"
    for cut in range(shared, len(longer) + 1):
        # The empty chunk that ends a bag is still there until it is written over.
        path.write_bytes(longer[:cut] + (acknowledged[cut:] if kind == "bag" else b""))
        prints, faults = read(kind, path)
        assert faults == []
        assert prints.items() >= {index: PRINTS[index] for index in range(3)}.items()
        assert prints.items() <= PRINTS.items()
    assert prints == PRINTS


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_recording_cut_while_it_was_finished_is_whole_but_for_its_index(
    kind, snapshots, tmp_path
):
    stored = (snapshots / "3" / f"survey.{kind}").read_bytes()
    ended = (snapshots / "end" / f"survey.{kind}").read_bytes()
    for cut in [*range(len(stored), len(ended), 11), len(ended)]:
        (tmp_path / "cut").write_bytes(stored[:100] + ended[100:cut])
        assert read(kind, tmp_path / "cut") == (PRINTS, [])


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_recording_cut_anywhere_at_all_is_read_without_a_wrong_trace(kind, snapshots, tmp_path):
    content = (snapshots / "3" / f"survey.{kind}").read_bytes()
    for cut in range(0, len(content), 23):
        (tmp_path / "cut").write_bytes(content[:cut])
        prints, _ = read(kind, tmp_path / "cut")
        assert prints.items() <= PRINTS.items()


@pytest.mark.parametrize("when", ["3", "end"])
def test_an_mcap_changed_in_any_byte_holds_no_wrong_trace(snapshots, tmp_path, when):
    content = (snapshots / when / "survey.mcap").read_bytes()
    for place in range(0, len(content), 11):
        changed = bytearray(content)
        changed[place] ^= 1 << (place % 8)
        (tmp_path / "changed").write_bytes(changed)
        prints, _ = read("mcap", tmp_path / "changed")
        assert prints.items() <= PRINTS.items()


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


def test_a_json_file_cut_at_any_byte_is_no_trace(tmp_path):
    content = trace_json.encode(TRACES[0])
    path = tmp_path / "000000_X0050.00_Y0012.35_Z+090.00.json"
    for cut in range(len(content)):
        path.write_bytes(content[:cut])
        with pytest.raises(TraceRefusedError):
            trace_files.read_trace(path, SURVEY)
    path.write_bytes(content)
    assert trace_files.read_trace(path, SURVEY).fingerprint() == PRINTS[0]
