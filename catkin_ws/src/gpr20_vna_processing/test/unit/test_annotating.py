"""The annotation of a survey: stored at its start, changed while it is open and afterwards."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace

import pytest
from annotation_examples import EXAMPLE, annotations
from fault_kit import raises_fault
from hypothesis import HealthCheck, given, settings
from log_examples import NOW, make_former
from planned_survey import METADATA, POINTS, planned_trace
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import SURVEY, read_json

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import DAMAGED
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.annotating import add_to_survey, annotate
from gpr20_survey.folder.recovery import read_description
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
    before = read_description(closed)
    for annotation in (EXAMPLE, EMPTY, replace(EXAMPLE, notes="")):
        annotated = kit.processing.annotate(closed.name if name == "folder" else name, annotation)
        assert (annotated.survey_id, annotated.folder) == (SURVEY, closed)
        assert read_description(closed) == {**before, "annotation": annotation.values()}
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


@pytest.mark.parametrize("name", ["survey.json", "log.jsonl"])
def test_a_lost_form_of_the_log_is_written_again_with_the_last_annotation(kit, closed, name):
    kit.processing.annotate(SURVEY, EXAMPLE)
    (closed / name).write_bytes(b"")
    shutil.rmtree(str(closed / "traces"))
    kit.processing.reopen_survey(closed.name)
    assert stored(closed) == EXAMPLE


def test_what_is_no_survey_cannot_be_annotated(kit, closed):
    for name in ("", OTHER_SURVEY, "../x", "/etc", "20260921T141320_ffffffff"):
        with pytest.raises(SurveyRefusedError):
            print(kit.processing.annotate(name, EXAMPLE))
    assert stored(closed) == AT_START


CHANGES = [
    (b'"y_stop_mm": 20.0', b'"y_stop_mm": 10.0'),
    (b'"stored_traces": 9', b'"stored_traces": 8'),
]


@pytest.mark.parametrize(("right", "wrong"), CHANGES)
def test_annotating_corrects_a_damaged_description_and_keeps_it(kit, closed, right, wrong):
    path = closed / "survey.json"
    before = read_description(closed)
    damaged = path.read_bytes().replace(right, wrong)
    assert damaged != path.read_bytes()
    path.write_bytes(damaged)
    assert verify_survey(closed).status == DAMAGED
    kit.processing.annotate(SURVEY, EXAMPLE)
    assert read_description(closed) == {**before, "annotation": EXAMPLE.values()}
    assert (closed / "damaged" / "survey.json").read_bytes() == damaged
    assert_intact(closed)


@pytest.mark.parametrize(("right", "wrong"), CHANGES)
def test_annotating_does_not_hide_a_damaged_description_of_an_earlier_version(
    kit, closed, right, wrong
):
    make_former(closed)
    path = closed / "survey.json"
    damaged = path.read_bytes().replace(right, wrong)
    path.write_bytes(damaged)
    with raises_fault("survey.description_damaged", error=SurveyRefusedError):
        kit.processing.annotate(SURVEY, EXAMPLE)
    assert path.read_bytes() == damaged
    assert verify_survey(closed).status == DAMAGED


def test_a_closed_survey_of_an_earlier_version_is_annotated_and_stays_intact(kit, closed):
    before = make_former(closed)
    kit.processing.annotate(SURVEY, EXAMPLE)
    assert read_description(closed) == {**before, "annotation": EXAMPLE.values()}
    assert_intact(closed)


def test_a_missing_manifest_is_not_made_again_by_an_annotation(kit, closed):
    (closed / "manifest.json").unlink()
    kit.processing.annotate(SURVEY, EXAMPLE)
    assert stored(closed) == EXAMPLE
    assert not (closed / "manifest.json").exists()
    assert verify_survey(closed).status == DAMAGED


def test_metadata_with_a_wrong_annotation_are_refused(kit):
    wrong = json.dumps({"annotation": {"operator": "a\nb"}})
    with raises_fault("value.not_allowed", error=SurveyRefusedError):
        kit.open(metadata_json=wrong)


@given(annotations)
@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_annotation_is_stored_as_it_is(closed, annotation):
    add_to_survey(closed, annotate(annotation), NOW)
    assert repr(stored(closed)) == repr(annotation)
