"""What people note of a survey is as safe as what the robot measures: annotation, markers, report.

It is stored before it is acknowledged, whether the survey is open or closed, and never hides
damage; `damage/test_damages.py` has what damage does to it."""

from __future__ import annotations

import json
import os
from dataclasses import replace

import pytest
from annotation_examples import EXAMPLE
from case_kit import each_case
from fault_kit import raises_fault
from log_examples import FILES, NOW, add_marker, marker
from planned_survey import METADATA
from reopening_kit import TRACES, noted, texts, tree
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import SURVEY

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE, DAMAGED, INCOMPLETE
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import annotating
from gpr20_survey.folder.annotating import add_to_survey
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.annotation import EMPTY, Annotation, annotation_of
from gpr20_survey.plan.markers import (
    MAX_MARKERS,
    Marker,
    markers_of,
    new_marker,
    present_markers,
    removed_marker,
    values_of,
)
from gpr20_survey.recording.recordings import open_recordings

AT_START = Annotation("Ana", "El Carmen", "at the start")
WITH_ANNOTATION = json.dumps({**json.loads(METADATA), "annotation": AT_START.values()})
ONE = Marker(marker(1).marker_id, 12.5, 20.0, 80.0, "metal, junto a la raíz", "Ana")
OTHER = Marker(marker(2).marker_id, 15.0, 10.0)


@pytest.fixture
def folder(kit):
    """A survey that is open, with every trace."""
    folder = kit.open(metadata_json=WITH_ANNOTATION)
    for trace in TRACES:
        kit.processing.store(trace)
    return folder


@pytest.fixture
def closed(kit, folder):
    """A survey that is finished."""
    kit.processing.close_survey(SURVEY, "finished")
    return folder


def annotation(folder) -> Annotation:
    return annotation_of(read_description(folder))


def markers(folder):
    return markers_of(read_description(folder))


def assert_intact(folder) -> None:
    found = verify_survey(folder)
    assert (found.status, found.faults) == (COMPLETE, []), found.verdict


@pytest.mark.parametrize("name", ["", SURVEY, "folder"])
def test_the_open_survey_is_annotated_and_marked_and_stays_so(kit, folder, name):
    assert annotation(folder) == AT_START
    survey = folder.name if name == "folder" else name
    annotated = kit.processing.annotate(survey, EXAMPLE)
    marked = kit.processing.add_marker(survey, ONE)
    for answer in (annotated, marked):
        assert (answer.survey_id, answer.folder) == (SURVEY, folder)
    for closing in (False, True):
        if closing:
            kit.processing.report(SURVEY, "{}")
            kit.processing.close_survey(SURVEY, "finished")
        assert annotation(folder) == EXAMPLE
        assert markers(folder) == marked.markers
    assert marked.markers[0].time and marked.markers[0].same_request(ONE)
    assert_intact(folder)


@pytest.mark.parametrize("by_folder", [False, True])
def test_a_closed_survey_is_annotated_and_marked_and_stays_intact(kit, closed, by_folder):
    before, files = read_description(closed), tree(closed)
    name = closed.name if by_folder else SURVEY
    for wanted in (EXAMPLE, EMPTY, replace(EXAMPLE, notes="")):
        kit.processing.annotate(name, wanted)
        assert read_description(closed) == {**before, "annotation": wanted.values()}
        assert_intact(closed)
    kit.open(OTHER_SURVEY)  # even while another one is open
    kit.processing.add_marker(name, ONE)
    marked = kit.processing.add_marker(name, OTHER)
    kit.processing.close_survey(OTHER_SURVEY, "stopped")
    assert read_description(closed)["markers"] == values_of(marked.markers)
    assert [one.marker_id for one in markers(closed)] == [ONE.marker_id, OTHER.marker_id]
    assert_intact(closed)
    # Nothing is written again.
    for name, content in tree(closed).items():
        assert content.startswith(files[name]) and (name in FILES or content == files[name])


@pytest.mark.parametrize("is_open", [True, False])
def test_a_removed_marker_remains_in_the_history(kit, folder, is_open):
    kit.processing.add_marker(SURVEY, ONE)
    kit.processing.add_marker(SURVEY, OTHER)
    if not is_open:
        kit.processing.close_survey(SURVEY, "finished")
    for _ in range(2):  # the answer to the first call may have been lost
        kit.processing.remove_marker(SURVEY, ONE.marker_id, "Luis")
    removed, other = markers(folder)
    assert (removed.text, removed.author, removed.removed_by) == (ONE.text, "Ana", "Luis")
    assert removed.removed and not removed.is_present and other.is_present
    assert present_markers(read_description(folder)) == (other,)


def test_a_repeated_request_adds_nothing_and_another_one_of_its_id_is_refused(kit, folder):
    for _ in range(2):
        kit.processing.add_marker(SURVEY, ONE)
    for action in (
        lambda: kit.processing.add_marker(SURVEY, Marker(ONE.marker_id, 0.0, 0.0)),
        lambda: kit.processing.remove_marker(SURVEY, OTHER.marker_id, ""),
    ):
        with raises_fault("marker.refused", error=SurveyRefusedError):
            action()
    assert len(markers(folder)) == 1


@each_case(
    "metadata, code",
    [
        ({"annotation": {"operator": "a\nb"}}, "value.not_allowed"),
        ({"markers": []}, "storage.request_refused"),
    ],
)
def test_metadata_bring_no_markers_and_no_wrong_annotation(kit, metadata, code):
    with raises_fault(code, error=SurveyRefusedError):
        kit.open(metadata_json=json.dumps(metadata))


def test_a_missing_manifest_is_not_made_again_by_an_addition(kit, closed):
    (closed / "manifest.json").unlink()
    kit.processing.annotate(SURVEY, EXAMPLE)
    assert annotation(closed) == EXAMPLE
    assert not (closed / "manifest.json").exists()
    assert verify_survey(closed).status == DAMAGED


@each_case(
    "wrong, shown",
    [
        ({"marker_id": 5}, (5,)),
        ({"x_mm": float("nan")}, ("X", "nan")),
        ({"y_mm": 10_001.0}, ("Y", 10001)),
        ({"depth_mm": -1.0}, ("depth", -1)),
        ({"text": "a" * 501}, (501,)),
        ({"author": "\x1b"}, ("U+001B",)),
    ],
)
def test_a_marker_that_is_not_allowed_is_refused(wrong, shown):
    with raises_fault("value.not_allowed", *shown):
        Marker(**{"marker_id": ONE.marker_id, "x_mm": 1.0, "y_mm": 2.0, **wrong})


def test_damaged_markers_are_recognized_and_their_number_is_limited():
    assert markers_of(json.loads(METADATA)) == ()  # an older survey
    more = {**values_of((ONE,))[0], "more": 1}
    for wrong in (5, {}, [5], [{"x_mm": 1}], [more], values_of((ONE, ONE))):
        with raises_fault("marker.damaged"):
            print(wrong, markers_of({"markers": wrong}))
    full = {"markers": values_of(tuple(marker(number) for number in range(MAX_MARKERS)))}
    with raises_fault("marker.too_many", error=SurveyRefusedError):
        new_marker(full, marker(MAX_MARKERS), NOW)
    assert removed_marker(full, marker(5).marker_id, "", NOW) is not None


def test_a_survey_that_is_open_takes_facts_from_its_storage_alone(copies, monkeypatch):
    monkeypatch.setattr(annotating, "SHORT_WAIT_S", 0.05)
    folder = copies("stopped")
    kit = Kit(folder.parent, open_recordings)
    kit.processing.reopen_survey(SURVEY)
    with raises_fault("survey.locked", os.getpid(), error=SurveyRefusedError):
        add_to_survey(folder, add_marker(3), NOW)
    kit.processing.add_marker("", marker(3))
    found = verify_survey(folder)
    assert (found.writer, found.status, found.faults) == (str(os.getpid()), INCOMPLETE, [])
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    add_to_survey(folder, add_marker(4), NOW)
    assert noted(folder) == texts(1, 2, 3, 4)
