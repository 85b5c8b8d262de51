"""Surveys that an earlier version of the storage wrote: read, verified and gone on with."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from annotation_examples import EXAMPLE
from fault_kit import raises_fault
from planned_survey import POINTS, planned_trace
from reopening_kit import assert_whole
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import SURVEY, read_json

from gpr20_analysis.read.unindexed_bag import complete_messages
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE, INCOMPLETE
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

# Of each former version of the message of a trace: a survey that was finished, and one whose
# storage was killed behind its fourth trace.
OLD = Path(__file__).resolve().parents[1] / "old_surveys"
VERSIONS = {
    "without_settings": (trace_message.WITHOUT_SETTINGS_MD5SUM, AnalyzerSettings()),
    "without_header": (trace_message.WITHOUT_HEADER_MD5SUM, AnalyzerSettings(1000.0, 4, "HIGH")),
}
CUT_OFF_AFTER = 4


@pytest.fixture(params=VERSIONS)
def version(request):
    return request.param


@pytest.fixture
def data(tmp_path, version):
    shutil.copytree(str(OLD / version), str(tmp_path / "data"))
    return tmp_path / "data"


@pytest.fixture
def kit(data):
    kit = Kit(data, open_recordings)
    yield kit
    kit.processing.shut_down()


@pytest.fixture
def finished(version):
    """The traces of the survey that was finished."""
    return [old_trace(version, index) for index in range(len(POINTS))]


@pytest.fixture
def traces(version):
    """The traces of the survey that was cut off; the later ones are of the present version."""
    return [
        old_trace(version, index, OTHER_SURVEY)
        if index < CUT_OFF_AFTER
        else planned_trace(index, OTHER_SURVEY)
        for index in range(len(POINTS))
    ]


def old_trace(version, index, survey_id=SURVEY):
    return planned_trace(index, survey_id, analyzer=VERSIONS[version][1], aux=(), zeros=())


def mcap_messages(folder):
    return StoredMcap(folder / "survey.mcap").messages()


def store_the_rest(kit, traces):
    for trace in traces[CUT_OFF_AFTER:]:
        kit.processing.store(trace)


def folder_of(data, survey_id):
    return next(data.glob(f"*_{survey_id[:8]}"))


def test_a_finished_survey_is_complete_and_there_is_nothing_to_go_on_with(kit, data, finished):
    folder = folder_of(data, SURVEY)
    assert verify_survey(folder).status == COMPLETE
    assert_whole(folder, finished)
    with raises_fault("survey.complete", 9, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap", "traces"])
def test_a_finished_survey_that_lost_a_form_is_made_whole_again(kit, data, finished, name):
    folder = folder_of(data, SURVEY)
    if name == "traces":
        shutil.rmtree(str(folder / name))
    else:
        (folder / name).unlink()
    assert kit.processing.reopen_survey(SURVEY).stored_indices == tuple(range(len(POINTS)))
    kit.processing.close_survey(SURVEY, "finished")
    assert_whole(folder, finished)
    assert verify_survey(folder).status == COMPLETE


def test_a_survey_that_was_cut_off_goes_on_to_its_end(kit, data, traces):
    folder = folder_of(data, OTHER_SURVEY)
    assert verify_survey(folder).status == INCOMPLETE
    reopened = kit.processing.reopen_survey(OTHER_SURVEY)
    assert reopened.stored_indices == tuple(range(CUT_OFF_AFTER))
    assert reopened.repairs == ()
    store_the_rest(kit, traces)
    kit.processing.close_survey(OTHER_SURVEY, "finished")
    assert_whole(folder, traces)
    assert verify_survey(folder).status == COMPLETE


def test_each_topic_of_a_resumed_survey_has_one_type_of_trace(kit, data, traces, version):
    folder = folder_of(data, OTHER_SURVEY)
    kit.processing.reopen_survey(OTHER_SURVEY)
    store_the_rest(kit, traces)
    kit.processing.close_survey(OTHER_SURVEY, "finished")
    expected = {
        "/trace": {VERSIONS[version][0]},
        f"/trace_{trace_message.MD5SUM[:8]}": {trace_message.MD5SUM},
    }
    for messages in (complete_messages(folder / "survey.bag"), mcap_messages(folder)):
        types = {}
        for message in messages:
            if message.datatype == trace_message.DATATYPE:
                types.setdefault(message.topic, set()).add(message.md5sum)
        assert types == expected


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap", "traces"])
def test_a_resumed_survey_that_lost_a_form_is_made_whole_and_resumed_again(kit, data, traces, name):
    folder = folder_of(data, OTHER_SURVEY)
    kit.processing.reopen_survey(OTHER_SURVEY)
    for trace in traces[CUT_OFF_AFTER:-1]:
        kit.processing.store(trace)
    kit.processing.close_survey(OTHER_SURVEY, "stopped")
    if name == "traces":
        shutil.rmtree(str(folder / name))
    else:
        (folder / name).unlink()
    kit.processing.reopen_survey(OTHER_SURVEY)
    kit.processing.store(traces[-1])
    kit.processing.close_survey(OTHER_SURVEY, "finished")
    assert_whole(folder, traces)
    assert verify_survey(folder).status == COMPLETE


def test_the_recordings_of_a_resumed_survey_agree_without_a_manifest(kit, data, traces):
    folder = folder_of(data, OTHER_SURVEY)
    kit.processing.reopen_survey(OTHER_SURVEY)
    store_the_rest(kit, traces)
    kit.processing.close_survey(OTHER_SURVEY, "finished")
    (folder / "manifest.json").unlink()
    (fault,) = verify_survey(folder).faults
    assert fault.fault_code == "analysis.manifest"


@pytest.mark.parametrize("ended", [True, False])
def test_a_survey_whose_description_is_lost_goes_on_with_the_copy_of_its_start(
    kit, data, finished, traces, ended
):
    survey_id = SURVEY if ended else OTHER_SURVEY
    folder = folder_of(data, survey_id)
    kit.processing.annotate(survey_id, EXAMPLE)
    for name in ("survey.json", "log.jsonl"):
        (folder / name).unlink()
    stored = kit.processing.reopen_survey(survey_id).stored_indices
    assert stored == tuple(range(len(POINTS) if ended else CUT_OFF_AFTER))
    if not ended:
        store_the_rest(kit, traces)
    kit.processing.close_survey(survey_id, "finished")
    assert_whole(folder, finished if ended else traces)
    # Whatever was noted of it is lost, and it is never called intact again.
    found = verify_survey(folder)
    assert (found.status, found.faults) == (INCOMPLETE, [])
    assert found.unconfirmed


@pytest.mark.parametrize(("survey_id", "status"), [(SURVEY, COMPLETE), (OTHER_SURVEY, INCOMPLETE)])
def test_surveys_without_an_annotation_are_given_one(kit, data, survey_id, status):
    folder = folder_of(data, survey_id)
    kit.processing.annotate(survey_id, EXAMPLE)
    assert annotation_of(read_json(folder / "survey.json")) == EXAMPLE
    found = verify_survey(folder)
    assert (found.status, found.faults) == (status, [])
