"""Reading traces by their places: each is as it was stored, or is unreadable with its reason."""

from __future__ import annotations

import os
import random
import shutil

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from reopening_kit import trace_file
from run_seed import draws
from storage_kit import OTHER_SURVEY, Kit, text_message
from trace_examples import SURVEY, make_trace

from gpr20_survey.folder.trace_files import MAX_FILE_BYTES
from gpr20_survey.trace.trace import SAMPLE, TraceBlock
from gpr20_vna_processing.mid import stored_surveys
from gpr20_vna_processing.mid.stored_surveys import StoredSurveys

PLANNED = range(40)


def trace_of(index, **changes):
    """Return a trace whose every number is another than that of the others."""
    place = {"x_coord_mm": 10.0 + index, "y_coord_mm": 0.1 * index, "z_coord_deg": index % 2 * 90.0}
    return make_trace(index, antennae_height_m=0.2 + 0.001 * index, **{**place, **changes})


def stored_survey(data, indices, end=True, **changes):
    """Return the folder of a survey, whose storage is killed if it has no end."""
    kit = Kit(data)
    folder = kit.open()
    for index in indices:
        kit.processing.record(text_message("/t", f"before {index}"))
        kit.processing.store(trace_of(index, **changes))
    if end:
        kit.processing.close_survey(SURVEY, "stopped")
    copy = data / "copy" / folder.name
    shutil.copytree(str(folder), str(copy))
    kit.processing.shut_down()
    return copy


def assert_as_stored(block: TraceBlock):
    wanted = TraceBlock.of(SURVEY, [trace_of(index) for index in block.indices])
    for name in ("frequency_hz", "indices", "positions", "heights_m", "s21"):
        assert np.array_equal(getattr(block, name), getattr(wanted, name)), name
    assert block.s21.dtype == SAMPLE


@settings(max_examples=draws(10))
@given(
    stored=st.sets(st.sampled_from(PLANNED), min_size=1),
    wanted=st.sets(st.sampled_from(PLANNED), min_size=1),
    later=st.integers(0, 5),
    end=st.booleans(),
    seed=st.integers(0, 1000),
)
def test_what_is_stored_is_read_and_what_is_not_is_named(
    tmp_path_factory, stored, wanted, later, end, seed
):
    last = random.Random(seed).sample(sorted(stored), min(later, len(stored)))
    order = [*sorted(stored.difference(last)), *last]
    folder = stored_survey(tmp_path_factory.mktemp("data"), order, end)
    found = StoredSurveys(folder.parent).traces(SURVEY, sorted(wanted))
    assert set(found.block.indices.tolist()) == stored & wanted
    assert set(found.unreadable) == wanted - stored
    assert_as_stored(found.block)


def test_a_trace_of_which_nothing_is_whole_is_named_and_the_others_are_read(tmp_path):
    folder = stored_survey(tmp_path, PLANNED)
    trace_file(folder, 6).write_bytes(b"{")
    assert StoredSurveys(folder.parent).traces(SURVEY, [6]).block.indices.tolist() == [6]
    (folder / "survey.mcap").unlink()
    torn, unreadable = trace_file(folder, 2), trace_file(folder, 3)
    torn.write_bytes(torn.read_bytes()[:-20])
    unreadable.unlink()
    unreadable.mkdir()
    foreign = trace_file(folder, 4)
    foreign.write_bytes(foreign.read_bytes().replace(SURVEY.encode(), OTHER_SURVEY.encode()))
    os.truncate(str(trace_file(folder, 5)), MAX_FILE_BYTES + 1)
    found = StoredSurveys(folder.parent).traces(SURVEY, [1, 2, 3, 4, 5, 6])
    assert found.block.indices.tolist() == [1]
    assert list(found.unreadable) == [2, 3, 4, 5, 6]
    assert str(MAX_FILE_BYTES) in str(found.unreadable[5])
    assert found.unreadable[2].fault_code == "survey.damaged"
    assert all(map(str, found.unreadable.values()))


def test_a_survey_is_read_while_it_is_measured(tmp_path):
    kit, surveys = Kit(tmp_path), StoredSurveys(tmp_path)
    kit.open()
    for index in range(30):
        kit.processing.store(trace_of(index))
        found = surveys.traces(SURVEY, range(index + 1))
        assert found.block.indices.tolist() == list(range(index + 1)), index
    kit.processing.close_survey(SURVEY, "finished")
    assert_as_stored(surveys.traces(SURVEY, range(30)).block)
    kit.processing.shut_down()


def test_an_answer_is_bounded_by_its_points_and_by_its_time(tmp_path, monkeypatch):
    folder = stored_survey(tmp_path, PLANNED)
    monkeypatch.setattr(stored_surveys, "MAX_POINTS", 23)
    found = StoredSurveys(folder.parent).traces(SURVEY, PLANNED)
    assert found.block.indices.tolist() == [*range(5)]
    monkeypatch.setattr(stored_surveys, "MAX_READING_S", -1.0)
    assert StoredSurveys(folder.parent).traces(SURVEY, [7, 8]).block.indices.tolist() == [7]


def test_traces_with_other_frequencies_are_left_to_another_request(tmp_path):
    kit = Kit(tmp_path)
    kit.open()
    for index in range(6):
        kit.processing.store(
            trace_of(index, frequency_hz=np.linspace(6e8, 6e9 + 1e6 * (index % 3 == 1), 5))
        )
    surveys = StoredSurveys(tmp_path)
    assert surveys.traces(SURVEY, range(6)).block.indices.tolist() == [0, 2, 3, 5]
    assert surveys.traces(SURVEY, [1, 2, 4]).block.indices.tolist() == [1, 4]
    kit.processing.shut_down()
