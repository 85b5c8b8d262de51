"""Surveys that an earlier version of the storage wrote: read, verified and gone on with."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from annotation_examples import EXAMPLE
from planned_survey import POINTS, planned_trace
from reopening_kit import assert_whole
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import SURVEY, read_json

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE, INCOMPLETE
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.recording.recordings import open_recordings

# One that was finished, and one whose storage was killed behind its fourth trace.
OLD = Path(__file__).resolve().parent / "old_surveys"
CUT_OFF_AFTER = 4


@pytest.fixture
def data(tmp_path):
    shutil.copytree(str(OLD), str(tmp_path / "data"))
    return tmp_path / "data"


@pytest.fixture
def kit(data):
    kit = Kit(data, open_recordings)
    yield kit
    kit.processing.shut_down()


def folder_of(data, survey_id):
    return next(data.glob(f"*_{survey_id[:8]}"))


def test_a_finished_survey_is_complete_and_there_is_nothing_to_go_on_with(kit, data):
    folder = folder_of(data, SURVEY)
    assert verify_survey(folder).status == COMPLETE
    assert_whole(folder, [planned_trace(index) for index in range(len(POINTS))])
    with pytest.raises(SurveyRefusedError, match="finished and complete with 9 traces"):
        kit.processing.reopen_survey(SURVEY)


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap", "traces"])
def test_a_finished_survey_that_lost_a_form_is_made_whole_again(kit, data, name):
    folder = folder_of(data, SURVEY)
    if name == "traces":
        shutil.rmtree(str(folder / name))
    else:
        (folder / name).unlink()
    assert kit.processing.reopen_survey(SURVEY).stored_indices == list(range(len(POINTS)))
    kit.processing.close_survey(SURVEY, "finished", "")
    assert_whole(folder, [planned_trace(index) for index in range(len(POINTS))])
    assert verify_survey(folder).status == COMPLETE


def test_a_survey_that_was_cut_off_goes_on_to_its_end(kit, data):
    folder = folder_of(data, OTHER_SURVEY)
    assert verify_survey(folder).status == INCOMPLETE
    reopened = kit.processing.reopen_survey(OTHER_SURVEY)
    assert reopened.stored_indices == list(range(CUT_OFF_AFTER))
    assert reopened.repairs == ()
    traces = [planned_trace(index, OTHER_SURVEY) for index in range(len(POINTS))]
    for trace in traces[CUT_OFF_AFTER:]:
        kit.processing.store(trace)
    kit.processing.close_survey(OTHER_SURVEY, "finished", "")
    assert_whole(folder, traces)
    assert verify_survey(folder).status == COMPLETE


@pytest.mark.parametrize(("survey_id", "status"), [(SURVEY, COMPLETE), (OTHER_SURVEY, INCOMPLETE)])
def test_surveys_without_an_annotation_are_given_one(kit, data, survey_id, status):
    folder = folder_of(data, survey_id)
    kit.processing.annotate(survey_id, EXAMPLE)
    assert annotation_of(read_json(folder / "survey.json")) == EXAMPLE
    found = verify_survey(folder)
    assert (found.status, found.faults) == (status, [])
