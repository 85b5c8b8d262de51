"""Surveys that their control left open, and answers to a close that were lost."""

import os

import pytest
from fault_kit import raises_fault
from storage_kit import Kit
from trace_examples import SURVEY, make_trace

from gpr20_common.message import verbatim
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.recording.recordings import open_recordings

METADATA = '{"planned_traces": 2}'


@pytest.fixture
def kits(tmp_path):
    """Makes storages over the same data folder, one after another."""
    made = []

    def make():
        for kit in made:
            kit.processing.shut_down()
        made[:] = [Kit(tmp_path / "data", open_recordings)]
        return made[0]

    yield make
    for kit in made:
        kit.processing.shut_down()


def finished(kit):
    folder = kit.open(metadata_json=METADATA)
    for index in range(2):
        kit.processing.store(make_trace(index))
    return folder, kit.processing.close_survey(SURVEY, "finished", verbatim("complete"))


def test_a_close_that_a_dead_process_did_not_answer_is_answered_by_the_next_one(kits):
    folder, closed = finished(kits())
    content = (folder / "survey.json").read_bytes()
    assert kits().processing.close_survey(SURVEY, "finished", verbatim("complete")) == closed
    assert (folder / "survey.json").read_bytes() == content


def test_a_survey_that_ended_otherwise_is_not_open_to_be_closed(kits):
    finished(kits())
    with raises_fault("survey.none_open", error=SurveyRefusedError):
        kits().processing.close_survey(SURVEY, "stopped")


def test_a_survey_whose_close_was_cut_off_has_to_be_opened_again(kits):
    folder, _closed = finished(kits())
    (folder / "manifest.json").unlink()
    with raises_fault("survey.none_open", error=SurveyRefusedError):
        kits().processing.close_survey(SURVEY, "finished")


def test_a_survey_that_another_process_writes_is_not_reopened(tmp_path):
    """As by a second robot with the same data folder and its own ROS master."""
    writer, other = (Kit(tmp_path / "data", open_recordings) for _ in range(2))
    folder = writer.open(metadata_json=METADATA)
    writer.processing.store(make_trace(0))
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with raises_fault("survey.locked", os.getpid(), error=SurveyRefusedError):
        other.processing.reopen_survey(SURVEY)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    assert other.processing.state().survey_id == ""
    writer.processing.store(make_trace(1))
    writer.processing.close_survey(SURVEY, "interrupted")
    assert other.processing.reopen_survey(SURVEY).stored_indices == (0, 1)
    with raises_fault("survey.locked", error=SurveyRefusedError):
        writer.processing.reopen_survey(SURVEY)
    for kit in (writer, other):
        kit.processing.shut_down()


def test_a_survey_that_could_not_be_reopened_can_be_reopened_by_another_process(tmp_path):
    first, second = (Kit(tmp_path / "data", open_recordings) for _ in range(2))
    folder = first.open(metadata_json=METADATA)
    first.processing.close_survey(SURVEY, "interrupted")
    whole = (folder / "survey.mcap").read_bytes()
    (folder / "survey.mcap").unlink()
    (folder / "survey.mcap").mkdir()
    with pytest.raises((SurveyRefusedError, StorageFailedError)):
        first.processing.reopen_survey(SURVEY)
    (folder / "survey.mcap").rmdir()
    (folder / "survey.mcap").write_bytes(whole)
    assert second.processing.reopen_survey(SURVEY).stored_indices == ()
    for kit in (first, second):
        kit.processing.shut_down()
