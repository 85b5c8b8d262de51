"""The annotation of a survey: stored at its start, changed while it is open and afterwards."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import pytest
from annotation_examples import EXAMPLE, annotations
from fault_kit import raises_fault
from hypothesis import HealthCheck, given, settings
from planned_survey import METADATA, POINTS, planned_trace
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import SURVEY, read_json

from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.annotating import annotate_folder
from gpr20_survey.plan.annotation import EMPTY, Annotation, annotation_of
from gpr20_survey.recording.recordings import open_recordings

AT_START = Annotation("Ana", "El Carmen", "at the start")


WITH_ANNOTATION = json.dumps({**json.loads(METADATA), "annotation": AT_START.values()})


@pytest.fixture
def folder(kit):
    """A survey that is open, with every trace."""
    folder = kit.open(metadata_json=WITH_ANNOTATION)
    for index in range(len(POINTS)):
        kit.processing.store(planned_trace(index))
    return folder


@pytest.fixture
def closed(kit, folder):
    """A survey that is finished."""
    kit.processing.close_survey(SURVEY, "finished")
    return folder


def stored(folder) -> Annotation:
    return annotation_of(read_json(folder / "survey.json"))


def assert_intact(folder) -> None:
    found = verify_survey(folder)
    assert found.status == 0, (found.verdict, found.faults)


@pytest.mark.parametrize("name", ["", SURVEY, "folder"])
def test_the_annotation_of_the_open_survey_is_changed(kit, folder, name):
    assert stored(folder) == AT_START
    annotated = kit.processing.annotate(folder.name if name == "folder" else name, EXAMPLE)
    assert (annotated.survey_id, annotated.folder) == (SURVEY, folder)
    assert stored(folder) == EXAMPLE
    kit.processing.report(SURVEY, "{}")
    kit.processing.close_survey(SURVEY, "finished")
    assert stored(folder) == EXAMPLE
    assert_intact(folder)


@pytest.mark.parametrize("name", [SURVEY, "folder"])
def test_the_annotation_of_a_closed_survey_is_changed_and_it_stays_intact(kit, closed, name):
    before = read_json(closed / "survey.json")
    for annotation in (EXAMPLE, EMPTY, replace(EXAMPLE, notes="")):
        annotated = kit.processing.annotate(closed.name if name == "folder" else name, annotation)
        assert (annotated.survey_id, annotated.folder) == (SURVEY, closed)
        assert read_json(closed / "survey.json") == {**before, "annotation": annotation.values()}
        assert_intact(closed)


def test_an_annotation_survives_interruption_resumption_and_another_process(tmp_path):
    first = Kit(tmp_path / "data", open_recordings)
    folder = first.open(metadata_json=WITH_ANNOTATION)
    first.processing.store(planned_trace(0))
    first.processing.shut_down()
    second = Kit(tmp_path / "data", open_recordings)
    second.processing.annotate(SURVEY, EXAMPLE)
    reopened = second.processing.reopen_survey(SURVEY)
    assert annotation_of(json.loads(reopened.metadata_json)) == EXAMPLE
    for index in range(1, len(POINTS)):
        second.processing.store(planned_trace(index))
    second.processing.close_survey(SURVEY, "finished")
    second.processing.shut_down()
    assert stored(folder) == EXAMPLE
    assert_intact(folder)


def test_a_lost_survey_json_is_written_again_with_the_annotation_of_the_start(kit, closed):
    (closed / "survey.json").write_bytes(b"")
    shutil.rmtree(str(closed / "traces"))
    kit.processing.reopen_survey(closed.name)
    assert stored(closed) == AT_START


def test_what_is_no_survey_cannot_be_annotated(kit, closed):
    for name in ("", OTHER_SURVEY, "../x", "/etc", "20260921T141320_ffffffff"):
        with pytest.raises(SurveyRefusedError):
            print(kit.processing.annotate(name, EXAMPLE))
    assert stored(closed) == AT_START


@pytest.mark.parametrize("manifest", [True, False])
def test_annotating_does_not_hide_a_damaged_description(kit, closed, manifest):
    if not manifest:
        (closed / "manifest.json").unlink()
    path = closed / "survey.json"
    damaged = path.read_bytes().replace(b'"y_stop_mm": 20.0', b'"y_stop_mm": 10.0')
    path.write_bytes(damaged)
    with raises_fault("survey.description_damaged", error=SurveyRefusedError):
        kit.processing.annotate(SURVEY, EXAMPLE)
    assert path.read_bytes() == damaged
    assert verify_survey(closed).status != 0


def test_annotating_does_not_hide_a_changed_end(kit, closed):
    path = closed / "survey.json"
    damaged = path.read_bytes().replace(b'"stored_traces": 9', b'"stored_traces": 8')
    assert damaged != path.read_bytes()
    path.write_bytes(damaged)
    with raises_fault("survey.description_damaged", error=SurveyRefusedError):
        kit.processing.annotate(SURVEY, EXAMPLE)
    assert path.read_bytes() == damaged


def test_metadata_with_a_wrong_annotation_are_refused(kit):
    wrong = json.dumps({"annotation": {"operator": "a\nb"}})
    with raises_fault("value.not_allowed", error=SurveyRefusedError):
        kit.open(metadata_json=wrong)


@given(annotations)
@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_annotation_is_stored_as_it_is(closed, annotation):
    annotate_folder(closed, annotation)
    assert repr(stored(closed)) == repr(annotation)
