"""Surveys that an earlier version of the storage wrote: read, verified and gone on with."""

import shutil
from pathlib import Path

import pytest
from fault_kit import raises_fault
from planned_survey import POINTS, planned_trace
from reopening_kit import assert_whole
from storage_kit import OTHER_SURVEY, bag_messages
from trace_examples import SURVEY

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE, INCOMPLETE
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import trace_files
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_vna_processing.mid.trace_reader import TraceReader

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


def traces_of(version, survey_id):
    """Return the traces of a survey; those behind the cut are of the present version."""
    old = {"analyzer": VERSIONS[version][1], "aux": (), "zeros": ()}
    count = CUT_OFF_AFTER if survey_id == OTHER_SURVEY else len(POINTS)
    return [
        planned_trace(index, survey_id, **(old if index < count else {}))
        for index in range(len(POINTS))
    ]


def folder_of(data, survey_id):
    return next(data.glob(f"*_{survey_id[:8]}"))


def finish(kit, data, version, survey_id):
    """Store what is missing, and check that the survey is whole; return what verify says of it."""
    traces, folder = traces_of(version, survey_id), folder_of(data, survey_id)
    for trace in traces:
        kit.processing.store(trace)
    kit.processing.close_survey(survey_id, "finished")
    assert_whole(folder, traces)
    return verify_survey(folder)


def test_a_finished_survey_is_complete_and_there_is_nothing_to_go_on_with(
    kit, data, version, monkeypatch
):
    folder = folder_of(data, SURVEY)
    assert verify_survey(folder).status == COMPLETE
    assert_whole(folder, traces_of(version, SURVEY))
    monkeypatch.setattr(trace_files, "read_trace", None)  # every trace comes from the MCAP
    found = TraceReader().read(folder, SURVEY, range(len(POINTS)))
    assert found.block.indices.tolist() == list(range(len(POINTS)))
    monkeypatch.undo()
    with raises_fault("survey.complete", 9, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)


def test_a_survey_that_was_cut_off_goes_on_to_its_end(kit, data, version):
    folder = folder_of(data, OTHER_SURVEY)
    assert verify_survey(folder).status == INCOMPLETE
    reopened = kit.processing.reopen_survey(OTHER_SURVEY)
    assert (reopened.stored_indices, reopened.repairs) == (tuple(range(CUT_OFF_AFTER)), ())
    assert finish(kit, data, version, OTHER_SURVEY).status == COMPLETE
    # Each topic has one type of trace.
    for messages in (
        bag_messages(folder / "survey.bag"),
        StoredMcap(folder / "survey.mcap").messages(),
    ):
        types = {
            (one.topic, one.md5sum) for one in messages if one.datatype == trace_message.DATATYPE
        }
        assert types == {
            ("/trace", VERSIONS[version][0]),
            (f"/trace_{trace_message.MD5SUM[:8]}", trace_message.MD5SUM),
        }
    # The recordings agree without a manifest, too.
    (folder / "manifest.json").unlink()
    (fault,) = verify_survey(folder).faults
    assert fault.fault_code == "analysis.manifest"


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap", "traces"])
def test_a_resumed_survey_that_lost_a_form_is_made_whole_and_resumed_again(
    kit, data, version, name
):
    kit.processing.reopen_survey(OTHER_SURVEY)
    for trace in traces_of(version, OTHER_SURVEY)[CUT_OFF_AFTER:-1]:
        kit.processing.store(trace)
    kit.processing.close_survey(OTHER_SURVEY, "stopped")
    path = folder_of(data, OTHER_SURVEY) / name
    shutil.rmtree(str(path)) if path.is_dir() else path.unlink()
    kit.processing.reopen_survey(OTHER_SURVEY)
    assert finish(kit, data, version, OTHER_SURVEY).status == COMPLETE
