"""Reading surveys back: lists, surveys that still run, and nothing outside the data folder."""

import json
import os

import pytest
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from log_examples import make_former
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_common.message import Fault, Message
from gpr20_survey.errors import ProcessingError, SurveyRefusedError
from gpr20_survey.folder.soil_note import soil_of_survey, soil_values
from gpr20_vna_processing.mid.survey_archive import SurveyArchive

METADATA = json.dumps(
    {
        "simulated": True,
        "parameters": {"x_points": 3, "y_points": 3, "polarizations_deg": [0.0, 90.0]},
    }
)


@pytest.fixture
def kit(tmp_path):
    kit = Kit(tmp_path)
    yield kit
    kit.processing.shut_down()


@pytest.fixture
def archive(tmp_path):
    return SurveyArchive(tmp_path)


def fill(kit, indices=(0, 1, 2, 3, 4), **changes):
    folder = kit.open(metadata_json=METADATA, **changes)
    for index in indices:
        kit.processing.store(make_trace(index))
    return folder


def test_what_was_planned_and_stored_is_told_without_the_report(kit, archive):
    folder = fill(kit, [0, 3])
    kit.processing.report(SURVEY, '{"verdict": "so far"}')
    survey = archive.survey(folder.name)
    assert survey.survey_id == SURVEY
    assert survey.stored_indices == (0, 3)
    assert survey.description["parameters"]["x_points"] == 3
    assert "report" not in survey.description


def test_what_was_found_and_decided_is_told_of_the_log_before_and_after_the_end(kit, archive):
    folder = fill(kit, [0, 3])
    soil = soil_values(4.0, STARTED_US)
    kit.processing.note("", "decision", json.dumps(soil))
    kit.processing.note(SURVEY, "pause", json.dumps({"text": "", "time": "t"}))
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.note(SURVEY, "found", json.dumps({"what": "scrap"}))
    log = archive.survey(folder.name).description["log"]
    assert [one["kind"] for one in log] == ["decision", "found"]
    assert log[1]["values"] == {"what": "scrap"}
    assert soil_of_survey({"log": log}) == (4.0, "entered later")


def test_the_list_tells_the_verdict_and_what_is_missing(kit, archive):
    fill(kit)
    (running,), more = archive.list("", 10)
    assert (running.outcome, running.stored_traces, running.planned_traces) == ("", 5, 18)
    kit.processing.report(SURVEY, json.dumps({"coverage": "mmrmm" + "f" + 12 * "-"}))
    kit.processing.close_survey(SURVEY, "stopped")
    (ended,), more = archive.list("", 10)
    assert ended.outcome == "stopped"
    assert ended.verdict.values == {"stored": 5, "planned": 18, "failed": 1, "missing": 12}
    assert not ended.complete
    assert not more
    assert ended.simulated


def test_the_list_has_the_fault_that_ended_a_survey(kit, archive):
    folder = fill(kit)
    assert archive.list("", 10)[0][0].fault_code == ""
    reason = Message("lost").with_fault(Fault("axis.lost_zero"))
    kit.processing.close_survey(SURVEY, "failed", reason)
    assert archive.list("", 10)[0][0].fault_code == "axis.lost_zero"
    values = make_former(folder)
    del values["fault_code"]
    (folder / "survey.json").write_text(json.dumps(values))
    assert archive.list("", 10)[0][0].fault_code == ""


def test_a_report_that_may_be_older_than_the_last_traces_gives_no_verdict(kit, archive):
    fill(kit)
    kit.processing.report(SURVEY, json.dumps({"coverage": "mmm" + 15 * "-"}))
    (running,), _more = archive.list("", 10)
    kit.processing.interrupt_other(OTHER_SURVEY)
    (cut_off,), _more = archive.list("", 10)
    assert (running.verdict, cut_off.verdict, cut_off.outcome) == (None, None, "interrupted")


@pytest.mark.parametrize("coverage", [None, "", "mmx", ["m"], "\ud800"])
def test_a_report_that_was_changed_gives_no_verdict(kit, archive, coverage):
    fill(kit)
    kit.processing.report(SURVEY, json.dumps({"coverage": coverage, "verdict": "complete"}))
    kit.processing.close_survey(SURVEY, "stopped")
    (ended,), _more = archive.list("", 10)
    assert (ended.verdict, ended.outcome) == (None, "stopped")


def test_half_of_a_character_hides_no_survey(kit, archive):
    folder = fill(kit)
    kit.processing.close_survey(SURVEY, "stopped")
    values = {**make_former(folder), "started": "\udcff"}
    (folder / "survey.json").write_text(json.dumps(values))
    (folder / "survey.mcap").unlink()  # its copy would take the place of the damaged start
    (survey,), _more = archive.list("", 10)
    assert survey.started == "\\udcff"


@pytest.mark.parametrize("former", [False, True])
def test_a_damaged_plan_is_shown_as_it_was_at_the_start(kit, archive, former):
    folder = fill(kit, range(6))
    kit.processing.close_survey(SURVEY, "finished")
    if former:
        make_former(folder)
    path = folder / "survey.json"
    values = json.loads(path.read_text())
    original = values["parameters"]["y_points"]
    values["parameters"]["y_points"] = 1  # as many as are stored
    path.write_text(json.dumps(values))
    (survey,), _more = archive.list("", 10)
    assert (survey.planned_traces, survey.complete) == (18, False)
    assert archive.survey(SURVEY).description["parameters"]["y_points"] == original


def test_a_survey_is_complete_only_if_every_planned_trace_has_its_file(kit, archive):
    folder = fill(kit, range(18))
    kit.processing.close_survey(SURVEY, "finished")
    assert archive.list("", 1)[0][0].complete
    (folder / "manifest.json").rename(folder / "away")
    assert not archive.list("", 1)[0][0].complete
    (folder / "away").rename(folder / "manifest.json")
    os.remove(next(iter((folder / "traces").glob("000007_*"))))
    assert not archive.list("", 1)[0][0].complete


def test_the_list_has_pages_the_newest_first(kit, archive):
    for survey_id, started_us in ((SURVEY, STARTED_US), (OTHER_SURVEY, STARTED_US + 60_000_000)):
        kit.open(survey_id, started_us=started_us)
        kit.processing.close_survey(survey_id, "stopped")
    (newest,), more = archive.list("", 1)
    assert (newest.survey_id, more) == (OTHER_SURVEY, True)
    (oldest,), more = archive.list(newest.folder, 1)
    assert (oldest.survey_id, more) == (SURVEY, False)


def test_a_folder_that_cannot_be_read_is_listed_with_its_problem(tmp_path, archive):
    (tmp_path / "20260921T141320_0f8fad5b").mkdir()
    (tmp_path / "20260921T141320_0f8fad5b" / "survey.json").write_text("{")
    (tmp_path / "notes").mkdir()
    (one,), _more = archive.list("", 10)
    assert one.folder == "20260921T141320_0f8fad5b"
    assert "survey.json" in str(one.problem)
    assert one.problem.fault_code == "survey.description_lost"


def test_a_data_folder_that_was_not_made_yet_holds_no_surveys(tmp_path):
    assert SurveyArchive(tmp_path / "later").list("", 10) == ([], False)


@pytest.mark.parametrize("name", ["survey.json", "traces"])
def test_links_out_of_the_data_folder_are_not_followed(kit, archive, tmp_path, name):
    folder = fill(kit)
    outside = tmp_path / "outside"
    (folder / name).rename(outside)
    (folder / name).symlink_to(outside)
    with raises_fault("storage.not_a_file", name, error=SurveyRefusedError):
        archive.traces(SURVEY, [0])
    assert archive.list("", 1)[0][0].problem.fault_code == "storage.not_a_file"


def test_a_linked_trace_is_no_trace(kit, archive, tmp_path):
    folder = fill(kit)
    stored = next(iter((folder / "traces").glob("000002_*")))
    stored.rename(tmp_path / "elsewhere.json")
    stored.symlink_to(tmp_path / "elsewhere.json")
    assert archive.survey(SURVEY).stored_indices == (0, 1, 3, 4)


@settings(max_examples=50)
@given(st.text(max_size=80))
def test_only_ids_and_folder_names_are_looked_up(tmp_path_factory, text):
    archive = SurveyArchive(tmp_path_factory.getbasetemp())
    with pytest.raises(ProcessingError):
        archive.traces(text, [0])
    with pytest.raises(ProcessingError):
        archive.survey(text)
    if text:
        with pytest.raises(ProcessingError):
            archive.list(text, 1)


def test_what_is_not_there_is_refused(archive):
    for name in ("../x", "/etc", "20260921T141320_0f8fad5b/..", SURVEY):
        with pytest.raises(SurveyRefusedError):
            print(archive.survey(name))


@pytest.mark.parametrize("count", [0, 1001])
def test_requests_are_bounded(kit, archive, count):
    fill(kit, [0])
    with raises_fault("storage.request_refused", count, 1, 1000, error=SurveyRefusedError):
        archive.traces(SURVEY, range(count))
    if count:
        with raises_fault("storage.request_refused", count, 1, 50, error=SurveyRefusedError):
            archive.list("", count)
