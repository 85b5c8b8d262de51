"""Reading surveys back: lists, thumbnails, surveys that still run or were imported."""

import json
import os

import numpy as np
import pytest
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from imported_kit import imported_folder
from log_examples import make_former
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_analysis.read.verification import verify_survey
from gpr20_common.message import Fault, Message
from gpr20_survey.errors import ProcessingError, SurveyRefusedError
from gpr20_survey.folder.soil_note import soil_of_survey, soil_values
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import RobotTravel, SurveyParameters, Travel
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.results.survey_summary import NO_THUMBNAIL, summary_fields
from gpr20_vna_processing import faults
from gpr20_vna_processing.mid.recent_summaries import SETTLED_NS, RecentSummaries
from gpr20_vna_processing.mid.survey_archive import SurveyArchive
from gpr20_vna_processing.mid.survey_thumbnail import MOST_CELLS, thumbnail_of

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


@pytest.mark.parametrize("count", [0, 1001])
def test_requests_are_bounded(kit, archive, count):
    fill(kit, [0])
    with raises_fault("storage.request_refused", count, 1, 1000, error=SurveyRefusedError):
        archive.traces(SURVEY, range(count))
    if count:
        with raises_fault("storage.request_refused", count, 1, 50, error=SurveyRefusedError):
            archive.list("", count)


def contents(folder):
    return {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()}


def test_it_is_listed_as_imported_with_its_source_and_its_area(tmp_path):
    folder = imported_folder(tmp_path, 6, 3)
    (survey,), _ = SurveyArchive(tmp_path).list("", 10)
    assert (survey.folder, survey.outcome, survey.problem) == (folder.name, "imported", None)
    assert (survey.stored_traces, survey.planned_traces) == (18, 0)
    assert not survey.complete and not survey.simulated
    assert str(survey.verdict) == "imported from line 7.dzt (dzt)"
    area = survey.thumbnail
    assert (area.width_mm, area.height_mm, area.columns, area.rows) == (100.0, 200.0, 6, 3)
    assert set(area.percent) == {100}
    assert summary_fields(survey)["outcome"] == "imported"


def test_its_traces_are_read(tmp_path):
    archive = SurveyArchive(tmp_path)
    folder = imported_folder(tmp_path, 6, 3)
    assert archive.survey(folder.name).stored_indices == tuple(range(18))
    found = archive.traces(folder.name, range(4, 11))
    assert found.block.indices.tolist() == list(range(4, 11)) and not found.unreadable


def test_it_is_not_continued_and_nothing_in_it_changes(kit, tmp_path):
    folder = imported_folder(tmp_path)
    (folder / "traces" / "000003_X0060.00_Y0000.00_Z+000.00.json").unlink()
    before = contents(folder)
    with raises_fault(faults.IMPORTED, "was imported; it has no plan"):
        kit.processing.reopen_survey(folder.name)
    assert contents(folder) == before


def test_a_note_can_be_added_to_it(kit, tmp_path):
    folder = imported_folder(tmp_path)
    kit.processing.annotate(folder.name, Annotation(name="Line 7"))
    (survey,), _ = SurveyArchive(tmp_path).list("", 10)
    assert survey.name == "Line 7"
    assert verify_survey(folder).faults == []


TRAVEL = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))


def parameters(generator):
    x_mm, y_mm = (generator.choice([10.0, 310.0], 2, replace=False) for _ in range(2))
    points = generator.integers(3, 60, 2)
    return {
        **{"vna_address": "", "start_frequency_hz": 6e8, "stop_frequency_hz": 6e9},
        **{"frequency_points": 5, "x_points": int(points[0]), "y_points": int(points[1])},
        **{"x_start_mm": float(x_mm[0]), "x_stop_mm": float(x_mm[1])},
        **{"y_start_mm": float(y_mm[0]), "y_stop_mm": float(y_mm[1])},
        "polarizations_deg": [0.0, 90.0][: int(generator.integers(1, 3))],
    }


def test_every_stored_trace_counts_where_it_was_measured():
    for seed in range(12):
        check_thumbnail(seed)


def check_thumbnail(seed):
    generator = np.random.default_rng(seed)
    values = parameters(generator)
    points = survey_points(SurveyParameters(**values), TRAVEL)
    stored = sorted(generator.choice(len(points), generator.integers(0, len(points) + 1), False))
    found = thumbnail_of(values, [int(one) for one in stored])
    assert (found.width_mm, found.height_mm) == (300.0, 300.0)
    assert (found.columns, found.rows) == tuple(
        min(values[f"{axis}_points"], MOST_CELLS) for axis in "xy"
    )
    kept, planned = (np.zeros((found.rows, found.columns)) for _ in range(2))
    for point in points:
        row, column = (
            round((at_mm - 10.0) / 300.0 * (count - 1)) * cells // count
            for at_mm, count, cells in (
                (point.y_mm, values["y_points"], found.rows),
                (point.x_mm, values["x_points"], found.columns),
            )
        )
        planned[row, column] += 1
        kept[row, column] += point.index in stored
    percent = np.frombuffer(found.percent, np.uint8).reshape(found.rows, found.columns)
    assert np.array_equal(percent == 100, kept == planned)
    assert np.array_equal(percent == 0, kept == 0)
    assert np.all(np.abs(percent - 100.0 * kept / planned) < 1.0 + (kept > 0))


def test_impossible_counts_make_no_map():
    for wrong in (
        *({"x_points": 10**9}, {"y_points": "3"}, {"polarizations_deg": 2}, {"x_points": True}),
    ):
        found = thumbnail_of({**parameters(np.random.default_rng(0)), **wrong}, [0])
        assert (found.columns, found.percent) == (0, b""), wrong


def test_unreadable_parameters_make_no_thumbnail():
    whole = parameters(np.random.default_rng(0))
    for wrong in (None, [], {}, {**whole, "x_start_mm": float("nan")}):
        assert thumbnail_of(wrong, [0]) == NO_THUMBNAIL, wrong


def test_a_summary_is_made_again_only_after_a_change(tmp_path):
    folder = tmp_path / "survey"
    (folder / "traces").mkdir(parents=True)
    (folder / "survey.json").write_text("{}")
    made = []
    now = [os.stat(str(folder)).st_mtime_ns]

    def make(path):
        made.append(path)
        return len(made)

    summaries = RecentSummaries(make, lambda: now[0])
    # Just changed: another change might not show.
    assert [summaries.of(folder), summaries.of(folder)] == [1, 2]
    now[0] += 2 * SETTLED_NS
    assert [summaries.of(folder) for _ in range(3)] == [3, 3, 3]
    (folder / "traces" / "000000.json").write_text("{}")
    os.utime(str(folder / "traces"), ns=(0, now[0]))
    assert summaries.of(folder) == 4
    (folder / "survey.json").unlink()
    assert [summaries.of(folder), summaries.of(folder)] == [5, 6]
