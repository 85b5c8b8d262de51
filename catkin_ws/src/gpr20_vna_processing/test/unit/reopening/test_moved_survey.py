"""A survey whose files are moved, removed or replaced while it is open: nothing is acknowledged
that is not in its folder, and neither it nor another survey is blocked by that."""

from __future__ import annotations

import os
import shutil

import pytest
from fault_kit import raises_fault
from reopening_kit import assert_whole
from storage_kit import OTHER_SURVEY
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_survey.errors import StorageFailedError, SurveyRefusedError

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(4)]


@pytest.fixture
def folder(kit):
    """A survey that is open, with three traces."""
    folder = kit.open()
    for trace in TRACES[:3]:
        kit.processing.store(trace)
    return folder


def store_refused(kit, *shown):
    with raises_fault("storage.folder_moved", *shown, error=StorageFailedError):
        kit.processing.store(TRACES[3])


def go_on_to_the_end(kit, folder):
    """What the control does when the survey is resumed: reopen, store again, close."""
    assert kit.processing.reopen_survey(folder.name).stored_indices[:3] == (0, 1, 2)
    kit.processing.store(TRACES[3])
    kit.processing.close_survey(SURVEY, "finished")
    assert_whole(folder, TRACES)


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap"])
@pytest.mark.parametrize("replaced", [False, True])
def test_no_trace_is_acknowledged_into_a_recording_that_is_gone(kit, folder, name, replaced):
    if replaced:
        shutil.copy(str(folder / name), str(folder / "copy"))
        os.replace(str(folder / "copy"), str(folder / name))
    else:
        (folder / name).unlink()
    store_refused(kit, name)
    assert [trace.index for trace in kit.stored] == [0, 1, 2]
    go_on_to_the_end(kit, folder)


@pytest.mark.parametrize("by_copy", [False, True])
def test_a_survey_that_was_moved_away_goes_on_when_it_is_back(kit, folder, tmp_path, by_copy):
    folder.rename(tmp_path / "away")
    store_refused(kit)
    with raises_fault("survey.unknown", error=SurveyRefusedError):
        kit.processing.reopen_survey(folder.name)
    if by_copy:  # as from another disk
        shutil.copytree(str(tmp_path / "away"), str(folder))
    else:
        (tmp_path / "away").rename(folder)
    go_on_to_the_end(kit, folder)


def test_a_copy_that_was_put_back_unnoticed_takes_no_trace_in_json_alone(kit, folder, tmp_path):
    folder.rename(tmp_path / "away")
    shutil.copytree(str(tmp_path / "away"), str(folder))
    store_refused(kit, "it was moved, removed or replaced")
    go_on_to_the_end(kit, folder)


def test_the_traces_folder_is_made_again_when_the_survey_is_resumed(kit, folder):
    shutil.rmtree(str(folder / "traces"))
    store_refused(kit, "no such file or folder")
    go_on_to_the_end(kit, folder)


@pytest.mark.parametrize("remove", [shutil.rmtree, lambda path: os.rename(path, path + ".away")])
def test_a_survey_that_is_gone_does_not_keep_the_next_one_from_beginning(kit, folder, remove):
    remove(str(folder))
    with pytest.raises(StorageFailedError):
        kit.processing.close_survey(SURVEY, "stopped")
    assert kit.processing.interrupt_other(OTHER_SURVEY) == folder.name
    kit.open(OTHER_SURVEY)


def test_a_recording_that_is_gone_is_not_finished(kit, folder):
    (folder / "survey.bag").unlink()
    with raises_fault("storage.folder_moved", error=StorageFailedError):
        kit.processing.close_survey(SURVEY, "finished")
    assert not (folder / "manifest.json").exists()
    go_on_to_the_end(kit, folder)
