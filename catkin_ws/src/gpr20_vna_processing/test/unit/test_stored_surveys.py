"""Reading surveys back: lists, thumbnails, surveys that still run or were imported."""

import json
import os
import shutil

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from log_examples import FILES, NOW, marker
from reopening_kit import tree
from result_examples import imported_folder
from run_seed import draws
from storage_kit import OTHER_SURVEY
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import ProcessingError
from gpr20_survey.faults import COMPLETE
from gpr20_survey.folder.log_record import Kind, LogRecord, soil_of_survey, soil_values
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.annotation import Annotation
from gpr20_vna_processing.mid import stored_surveys
from gpr20_vna_processing.mid.stored_surveys import MOST_CELLS, StoredSurveys, map_of, summary_of

PLAN = {"x_points": 3, "y_points": 3, "polarizations_deg": [0.0, 90.0]}
METADATA = json.dumps({"simulated": True, "parameters": PLAN})
NAME = "20260921T141320_0f8fad5b"


@pytest.fixture
def data(tmp_path):
    return tmp_path


@pytest.fixture
def archive(data):
    return StoredSurveys(data)


def fill(kit, indices=(0, 1, 2, 3, 4)):
    folder = kit.open(metadata_json=METADATA)
    for index in indices:
        kit.processing.store(make_trace(index))
    return folder


def only(archive):
    (survey,), more = archive.list("", 10)
    assert not more
    return survey


def test_what_was_planned_stored_found_and_decided_is_told_without_the_report(kit, archive):
    folder = fill(kit, [0, 3])
    kit.report(SURVEY, '{"verdict": "so far"}')
    kit.processing.add_fact("", "decision", json.dumps(soil_values(4.0, STARTED_US)))
    kit.processing.add_fact(SURVEY, "pause", json.dumps({"time": NOW}))
    survey = archive.survey(folder.name)
    assert survey.stored_indices == (0, 3)
    assert survey.description["parameters"]["x_points"] == 3
    assert "report" not in survey.description
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.add_fact(SURVEY, "found", json.dumps({"what": "scrap", "time": NOW}))
    log = archive.survey(folder.name).description["log"]
    assert [one["kind"] for one in log] == ["decision", "found"]
    assert log[1]["values"] == {"what": "scrap", "time": NOW}
    assert soil_of_survey({"log": log}) == (4.0, "entered later")


def test_an_id_that_two_folders_hold_is_refused_with_their_names(kit, archive):
    folder = fill(kit)
    kit.processing.close_survey(SURVEY, "stopped")
    copy = folder.with_name(f"20200101T000000_{SURVEY[:8]}")
    shutil.copytree(str(folder), str(copy))
    for request in (
        lambda: archive.survey(SURVEY),
        lambda: archive.traces(SURVEY, [0]),
        lambda: kit.add_marker(SURVEY, marker(1)),
        lambda: kit.processing.reopen_survey(SURVEY),
    ):
        with raises_fault("survey.unknown", f"{copy.name}, {folder.name}"):
            request()
    kit.add_marker(folder.name, marker(1))
    assert archive.survey(folder.name).description["markers"]
    assert not archive.traces(copy.name, [0]).unreadable
    assert kit.processing.reopen_survey(folder.name).path == str(folder)


def test_the_list_tells_the_verdict_and_what_is_missing(kit, archive):
    fill(kit)
    running = only(archive)
    assert (running.outcome, running.stored_traces, running.planned_traces) == ("", 5, 18)
    kit.report(SURVEY, json.dumps({"coverage": "mmmmm" + "f" + 12 * "-"}))
    # A report may be older than the last traces.
    assert only(archive).verdict is None
    kit.processing.close_survey(SURVEY, "failed")
    ended = only(archive)
    assert ended.outcome == "failed"
    assert ended.verdict.values == {"stored": 5, "planned": 18, "failed": 1, "missing": 12}
    assert ended.simulated and not ended.complete


def test_a_survey_is_complete_only_if_every_planned_trace_has_its_file(kit, archive):
    folder = fill(kit, range(18))
    kit.processing.close_survey(SURVEY, "finished")
    assert only(archive).complete
    (folder / "manifest.json").rename(folder / "away")
    assert not only(archive).complete
    (folder / "away").rename(folder / "manifest.json")
    os.remove(next(iter((folder / "traces").glob("000007_*"))))
    assert not only(archive).complete


def test_the_list_has_pages_the_newest_first(kit, archive):
    for survey_id, started_us in ((SURVEY, STARTED_US), (OTHER_SURVEY, STARTED_US + 60_000_000)):
        kit.open(survey_id, started_us=started_us)
        kit.processing.close_survey(survey_id, "stopped")
    (newest,), more = archive.list("", 1)
    assert (newest.survey_id, more) == (OTHER_SURVEY, True)
    (oldest,), more = archive.list(newest.folder, 1)
    assert (oldest.survey_id, more) == (SURVEY, False)


def test_a_folder_that_cannot_be_read_is_listed_with_its_problem(tmp_path, archive):
    assert StoredSurveys(tmp_path / "later").list("", 10) == ([], False)
    (tmp_path / NAME).mkdir()
    (tmp_path / NAME / "survey.json").write_text("{")
    (tmp_path / "notes").mkdir()
    assert only(archive).folder == NAME
    assert only(archive).problem.fault_code == "survey.log_lost"


@settings(max_examples=draws(12))
@given(
    st.text(max_size=80)
    | st.sampled_from(["../x", "/etc", f"{NAME}/..", SURVEY, SURVEY[:8] + OTHER_SURVEY[8:]])
)
def test_only_ids_and_folder_names_are_looked_up(tmp_path_factory, text):
    archive = StoredSurveys(tmp_path_factory.getbasetemp())
    for action in (lambda: archive.traces(text, [0]), lambda: archive.survey(text)):
        with pytest.raises(ProcessingError):
            action()


@each_case("count", [0, 1001])
def test_requests_are_bounded(archive, count):
    with raises_fault("value.not_allowed", count, 1, 1000):
        archive.traces(SURVEY, range(count))
    if count:
        with raises_fault("value.not_allowed", count, 1, 50):
            archive.list("", count)


def test_an_imported_survey_is_listed_with_its_source_and_area_and_read_and_annotated(
    kit, tmp_path, archive
):
    folder = imported_folder(tmp_path, 6, 3)
    survey = only(archive)
    assert (survey.folder, survey.outcome, survey.problem) == (folder.name, "imported", None)
    assert (survey.stored_traces, survey.planned_traces) == (18, 0)
    assert not survey.complete and not survey.simulated
    assert "line 7.dzt" in str(survey.verdict)
    assert (survey.width_mm, survey.height_mm) == (100.0, 200.0)
    assert (survey.map_columns, survey.map_rows, set(survey.map_percent)) == (6, 3, {100})
    assert archive.survey(folder.name).stored_indices == tuple(range(18))
    found = archive.traces(folder.name, range(4, 11))
    assert found.block.indices.tolist() == list(range(4, 11)) and not found.unreadable
    kit.annotate(folder.name, Annotation(name="Line 7"))
    assert only(archive).name == "Line 7"
    assert verify_survey(folder).faults == []
    before = tree(folder)
    with raises_fault(COMPLETE):
        kit.processing.reopen_survey(folder.name)
    assert tree(folder) == before


AREA = {
    **{"vna_address": "", "start_frequency_hz": 6e8, "stop_frequency_hz": 6e9},
    **{"frequency_points": 5, "polarizations_deg": [0.0, 90.0], "y_points": 3},
}


@each_case("ends, sign", [((10.0, 310.0), 1), ((310.0, 10.0), -1)])
def test_every_stored_trace_counts_where_it_was_measured(ends, sign):
    """Twice as many places in x as there are cells, with two rotations: four traces in a cell."""
    first, last = ends
    area = {**AREA, "x_points": 2 * MOST_CELLS, "x_start_mm": first, "x_stop_mm": last}
    area.update(y_start_mm=first, y_stop_mm=last)
    # The first and the last stop of the first row; the second one is measured backwards.
    found = map_of(area, [0, 1, 4 * MOST_CELLS - 1, 4 * MOST_CELLS])
    assert (found["width_mm"], found["height_mm"]) == (300.0, 300.0)
    assert (found["map_rows"], found["map_columns"]) == (3, MOST_CELLS)
    cells = np.frombuffer(bytes(found["map_percent"]), np.uint8).reshape(3, -1)[::sign, ::sign]
    assert (cells[0, 0], cells[0, -1], cells[1, -1]) == (50, 25, 25)
    assert np.count_nonzero(cells) == 3
    assert set(map_of(area, range(12 * MOST_CELLS))["map_percent"]) == {100}


def test_parameters_that_are_none_make_no_map():
    ends = dict.fromkeys(("x_start_mm", "x_stop_mm", "y_start_mm", "y_stop_mm"), 10.0)
    whole = {**AREA, **ends, "x_points": 3}
    ends_mm = [{**whole, "x_start_mm": one} for one in (float("nan"), 10**400, True, "1")]
    for wrong in (None, [], {}, *ends_mm):
        assert map_of(wrong, [0]) == {}, wrong
    for wrong in ({"x_points": 10**9}, {"y_points": "3"}, {"polarizations_deg": 2}):
        assert set(map_of({**whole, **wrong}, [0])) == {"width_mm", "height_mm"}, wrong


def test_a_summary_is_made_again_only_after_a_change(kit, archive, monkeypatch):
    folder, made = fill(kit), []
    kit.processing.close_survey(SURVEY, "stopped")
    counted = lambda one: made.append(one) or summary_of(one)  # noqa: E731
    monkeypatch.setattr(stored_surveys, "summary_of", counted)
    # Just changed: another change might not show.
    assert only(archive) == only(archive) and len(made) == 2
    for path in (*folder.iterdir(), folder):
        os.utime(str(path), (0, 0))
    assert only(archive) == only(archive) == only(archive) and len(made) == 3
    kit.annotate(SURVEY, Annotation(name="Line 7"))
    assert (only(archive).name, len(made)) == ("Line 7", 4)


def test_half_of_a_character_hides_no_survey(kit, archive):
    folder = fill(kit)
    kit.processing.close_survey(SURVEY, "stopped")
    values = {**read_description(folder), "outcome": "\udcff"}
    plan = LogRecord.after(None, Kind.PLAN, values, "2026")
    for name in FILES:
        (folder / name).write_bytes(plan.line())
    (survey,), _more = archive.list("", 10)
    assert (survey.problem, survey.outcome) == (None, "\\udcff")
