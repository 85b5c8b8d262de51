"""Every trace that is stored is published once, whatever failed between storing and publishing."""

from __future__ import annotations

import contextlib
import os
import random
import shutil

import pytest
from reopening_kit import assert_whole
from storage_kit import OTHER_SURVEY, Kit, MemoryRecording
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_survey.errors import ProcessingError, StorageFailedError
from gpr20_survey.recording.recordings import open_recordings

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(6)]
DRAWS = int(os.environ.get("GPR20_PUBLICATION_DRAWS", "6"))
FAULT = OSError(5, "Input/output error")


def end(kit: Kit) -> None:
    """End the thread of a storage, whose survey may be spoiled."""
    with contextlib.suppress(StorageFailedError):
        kit.processing.shut_down()


def published(kit: Kit):
    return [trace.index for trace in kit.stored]


@pytest.fixture
def kit(tmp_path):
    kit = Kit(tmp_path / "data", open_recordings)
    yield kit
    end(kit)


@pytest.fixture
def folder(kit):
    """A survey that is open, with three traces."""
    folder = kit.open()
    for trace in TRACES[:3]:
        kit.processing.store(trace)
    return folder


def spoil(folder, name="survey.mcap"):
    """Let the next commit of a recording fail: the trace has a JSON file by then."""
    (folder / name).unlink()


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap"])
def test_a_trace_whose_recording_failed_is_published_when_the_survey_is_reopened(kit, folder, name):
    spoil(folder, name)
    with pytest.raises(StorageFailedError):
        kit.processing.store(TRACES[3])
    assert published(kit) == [0, 1, 2]
    assert kit.processing.reopen_survey(SURVEY).stored_indices == (0, 1, 2, 3)
    assert published(kit) == [0, 1, 2, 3]
    # The control stores it again, because it got no answer.
    kit.processing.store(TRACES[3])
    kit.processing.store(TRACES[4])
    assert published(kit) == [0, 1, 2, 3, 4]
    kit.processing.close_survey(SURVEY, "finished")
    assert_whole(folder, TRACES[:5])


def test_every_trace_that_failed_is_published_when_the_survey_is_reopened(kit, folder):
    spoil(folder)
    for trace in TRACES[3:]:
        with pytest.raises(StorageFailedError):
            kit.processing.store(trace)
    kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [0, 1, 2, 3, 4, 5]


def test_a_trace_is_published_when_its_folder_was_moved_and_is_back(kit, folder, tmp_path):
    spoil(folder)
    with pytest.raises(StorageFailedError):
        kit.processing.store(TRACES[3])
    folder.rename(tmp_path / "away")
    # Another survey begins; the storage gives up the first one, which is not there.
    assert kit.processing.interrupt_other(OTHER_SURVEY) == folder.name
    kit.open(OTHER_SURVEY)
    kit.processing.close_survey(OTHER_SURVEY, "stopped")
    (tmp_path / "away").rename(folder)
    kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [0, 1, 2, 3]


def test_a_trace_that_is_not_stored_any_more_is_not_published(kit, folder, tmp_path):
    spoil(folder)
    with pytest.raises(StorageFailedError):
        kit.processing.store(TRACES[3])
    next((folder / "traces").glob("000003_*")).unlink()
    (folder / "survey.bag").unlink()
    kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [0, 1, 2]


def test_the_last_trace_is_published_again_when_another_process_stored_it(tmp_path):
    first = Kit(tmp_path / "data", open_recordings)
    folder = first.open()
    for trace in TRACES[:3]:
        first.processing.store(trace)
    spoil(folder)
    with pytest.raises(StorageFailedError):
        first.processing.store(TRACES[3])
    # What a kill leaves is what is on the disk now.
    shutil.copytree(str(tmp_path / "data"), str(tmp_path / "left"))
    end(first)
    second = Kit(tmp_path / "left", open_recordings)
    second.processing.reopen_survey(SURVEY)
    assert published(second) == [3]
    second.processing.store(TRACES[3])
    second.processing.close_survey(SURVEY, "stopped")
    second.processing.reopen_survey(SURVEY)
    second.processing.store(TRACES[4])
    assert published(second) == [3, 4]
    second.processing.shut_down()


def test_the_last_trace_is_not_published_again_by_the_process_that_published_it(kit, folder):
    for _ in range(2):
        kit.processing.close_survey(SURVEY, "stopped")
        kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [0, 1, 2]


def test_a_clock_that_was_set_back_makes_no_trace_be_published_twice(kit):
    kit.open()
    for trace in (TRACES[1], make_trace(5, timestamp_us=STARTED_US + 10**6)):
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [1, 5]


def test_a_trace_is_published_by_the_commit_that_follows_a_failed_one(tmp_path):
    memory = MemoryRecording()
    kit = Kit(tmp_path / "data", lambda *_: [memory])
    kit.open()
    memory.error = FAULT
    with pytest.raises(StorageFailedError):
        kit.processing.store(TRACES[0])
    memory.error = None
    kit.processing.close_survey(SURVEY, "stopped")
    assert published(kit) == [0]
    kit.processing.shut_down()


@pytest.mark.parametrize("seed", range(DRAWS))
def test_each_trace_is_published_once_in_a_process_whatever_fails(tmp_path, seed):
    """Random faults, repetitions, interruptions and deaths of the process.

    As the control does, a trace is stored again until it is acknowledged, then the next.
    """
    random_source = random.Random(seed)
    data = tmp_path / "data"
    kit = Kit(data, open_recordings)
    folder = kit.open()
    seen, lives, acknowledged = set(), 0, 0
    for _ in range(40):
        act = random_source.choice(["store", "store", "spoil", "reopen", "close", "die"])
        try:
            if act == "store":
                index = random_source.randint(max(acknowledged - 1, 0), acknowledged)
                kit.processing.store(TRACES[min(index, len(TRACES) - 1)])
                acknowledged = max(acknowledged, index + 1)
            elif act == "spoil":
                spoil(folder, random_source.choice(["survey.bag", "survey.mcap"]))
            elif act == "reopen":
                kit.processing.reopen_survey(SURVEY)
            elif act == "close":
                kit.processing.close_survey(SURVEY, "stopped")
            elif lives < 2:
                lives += 1
                left = tmp_path / f"left{lives}"
                shutil.copytree(str(data), str(left))
                assert len(published(kit)) == len(set(published(kit))), seed
                seen |= set(published(kit))
                data, folder = left, left / folder.name
                end(kit)
                kit = Kit(data, open_recordings)
        except (ProcessingError, FileNotFoundError):
            pass  # refused while closed, or spoiled already; what counts is below
    reopened = kit.processing.reopen_survey(SURVEY)
    assert len(published(kit)) == len(set(published(kit))), seed
    seen |= set(published(kit))
    assert set(reopened.stored_indices) <= seen, seed
    kit.processing.shut_down()
