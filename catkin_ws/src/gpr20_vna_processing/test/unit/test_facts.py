"""What is noted of a survey is as safe as what the robot measures: one service takes every fact.

It is stored before it is acknowledged, whether the survey is open or closed, and never hides
damage; `damage/test_damages.py` has what damage does to it."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import pytest
from annotation_examples import EXAMPLE, REFUSED, REFUSED_POSITIONS
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from log_examples import NOW, marker
from reopening_kit import TRACES
from storage_kit import OTHER_SURVEY
from trace_examples import METADATA, SURVEY

from gpr20_analysis.read.verdict import COMPLETE, DAMAGED
from gpr20_analysis.read.verification import verify_survey
from gpr20_common.errors import Gpr20Error
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.recovery import read_description, recover
from gpr20_survey.plan.annotation import EMPTY, Annotation, Wgs84Position, annotation_of
from gpr20_survey.plan.markers import MAX_MARKERS, Marker, markers_of, present_markers
from gpr20_vna_processing.mid.facts import KINDS, requested_fact

AT_START = Annotation("Ana", "El Carmen", "at the start")
WITH_ANNOTATION = json.dumps({**json.loads(METADATA), "annotation": AT_START.values()})
ONE = Marker(marker(1).marker_id, 12.5, 20.0, 80.0, "metal, junto a la raíz", "Ana")
OTHER = Marker(marker(2).marker_id, 15.0, 10.0)
GONE = {"marker_id": ONE.marker_id, "author": "Luis"}
NOTES = sorted({*KINDS} - {"annotation", "marker", "marker_removed", "report"})


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


def assert_intact(folder) -> None:
    found = verify_survey(folder)
    assert (found.status, found.faults) == (COMPLETE, []), found.verdict


def log_of(folder):
    """Return the facts that others added to a survey."""
    return [(one.kind, one.values) for one in recover(folder).found.records if one.kind in KINDS]


@pytest.mark.parametrize("name", ["", SURVEY, "folder"])
def test_the_open_survey_takes_facts_by_each_of_its_names_and_keeps_them(kit, folder, name):
    survey = folder.name if name == "folder" else name
    annotated = kit.annotate(survey, EXAMPLE)
    marked = kit.add_marker(survey, ONE)
    for answer in (annotated, marked):
        assert (answer.survey_id, answer.stored_traces) == (SURVEY, 9)
    assert kit.report(survey, '{"verdict": "old"}') == kit.report(survey, "{}") == 9
    kit.processing.close_survey(SURVEY, "finished")
    description = read_description(folder)
    assert (annotation_of(description), description["report"]) == (EXAMPLE, {})
    assert description["markers"] == list(marked.markers)
    (stored,) = markers_of(description)
    assert stored.time and stored.same_request(ONE) and not annotated.markers
    assert_intact(folder)


@pytest.mark.parametrize("by_folder", [False, True])
def test_a_closed_survey_takes_facts_and_stays_intact(kit, closed, by_folder):
    before = read_description(closed)
    name = closed.name if by_folder else SURVEY
    for wanted in (EXAMPLE, EMPTY, replace(EXAMPLE, notes="")):
        kit.annotate(name, wanted)
        assert read_description(closed) == {**before, "annotation": wanted.values()}
        assert_intact(closed)
    kit.open(OTHER_SURVEY)  # even while another one is open
    kit.add_marker(name, ONE)
    marked = kit.add_marker(name, OTHER)
    assert marked.stored_traces == 0
    with raises_fault("robot.in_use", error=SurveyRefusedError):
        kit.report(name, "{}")
    kit.processing.close_survey(OTHER_SURVEY, "stopped")
    assert read_description(closed)["markers"] == list(marked.markers)
    with raises_fault("survey.none_open", error=SurveyRefusedError):
        kit.report(name, "{}")
    for _ in range(2):  # the answer to the first call may have been lost
        kit.remove_marker(SURVEY, ONE.marker_id, "Luis")
        kit.processing.add_fact(SURVEY, "found", json.dumps({"time": NOW}))
    assert [kind for kind, _values in log_of(closed)].count("found") == 1
    removed, other = markers_of(read_description(closed))
    assert (removed.text, removed.author, removed.removed_by) == (ONE.text, "Ana", "Luis")
    assert removed.removed and not removed.is_present
    assert present_markers(read_description(closed)) == (other,)
    assert_intact(closed)


def test_a_heading_is_kept_while_its_place_stays_and_changed_by_who_knows_it(kit, closed):
    here, there = Wgs84Position(4.6, -74.0), Wgs84Position(4.7, -74.0)
    for sent, kept in (
        (Annotation("Ana", position=here, heading_deg=37.5), 37.5),
        (Annotation("Eva", position=here), 37.5),
        (Annotation("Eva", position=here, heading_deg=40.0), 40.0),
        (Annotation("Eva", position=there), None),
    ):
        kit.annotate(SURVEY, sent)
        assert annotation_of(read_description(closed)) == replace(sent, heading_deg=kept)


LATITUDE_LONGITUDE = ("latitude_deg", "longitude_deg")
REFUSED_VALUES = [
    *(("plan", {}), ("end", {}), ("resume", {}), ("unconfirmed", {}), ("", {}), ("x" * 999, {})),
    *((kind, wrong) for kind in KINDS for wrong in ([], "x", None, 1e999)),
    *((kind, {}) for kind in KINDS if kind != "report"),
    *(("annotation", {**EMPTY.values(), **wrong}) for wrong, _shown in REFUSED),
    *(
        ("annotation", {**EMPTY.values(), "position": dict(zip(LATITUDE_LONGITUDE, one))})
        for one, _shown in REFUSED_POSITIONS
    ),
    ("annotation", {**EMPTY.values(), "more": 1}),
    ("marker", asdict(ONE)),
    *(("marker", {**ONE.request(), "x_mm": wrong}) for wrong in (None, "1", True, 10_001, [])),
    *(("marker", {**ONE.request(), "depth_mm": wrong}) for wrong in (-1, "1", {})),
    *(("marker", {**ONE.request(), key: 5}) for key in ("marker_id", "text", "author")),
    *(("marker_removed", {**GONE, **wrong}) for wrong in ({"marker_id": 5}, {"author": "\x1b"})),
    ("marker_removed", {**GONE, "removed": NOW}),
    ("marker", {**ONE.request(), "x_mm": 0.0}),  # another one has this id
    ("marker_removed", {**GONE, "marker_id": OTHER.marker_id}),
    *((kind, {"time": wrong}) for kind in NOTES for wrong in ("", "now", 5, None, "2026-11-21")),
    ("report", {"a": "x" * (8 << 20)}),
    ("pause", {"time": NOW, "a": "x" * (1 << 20)}),
    ("report", json.loads("[" * 40 + "]" * 40)),
]


def test_hostile_values_of_every_kind_are_refused_with_a_reason_and_change_nothing(kit, folder):
    kit.add_marker("", ONE)
    before = (folder / "log.jsonl").read_bytes()
    for kind, values in REFUSED_VALUES:
        with pytest.raises(Gpr20Error) as refused:
            print(kind, str(values)[:99], kit.processing.add_fact("", kind, json.dumps(values)))
        said = str(refused.value)
        assert refused.value.message.fault_code and len(said.split()) > 4 and len(said) < 1000
    assert (folder / "log.jsonl").read_bytes() == before


def test_a_missing_manifest_is_not_made_again_by_a_fact(kit, closed):
    (closed / "manifest.json").unlink()
    kit.annotate(SURVEY, EXAMPLE)
    assert annotation_of(read_description(closed)) == EXAMPLE
    assert not (closed / "manifest.json").exists()
    assert verify_survey(closed).status == DAMAGED


def test_damaged_markers_are_recognized_and_their_number_is_limited():
    more = {**asdict(ONE), "more": 1}
    for wrong in (5, {}, [5], [{"x_mm": 1}], [more], [asdict(ONE)] * 2):
        with raises_fault("survey.damaged"):
            print(wrong, markers_of({"markers": wrong}))
    full = {"markers": [asdict(marker(number)) for number in range(MAX_MARKERS)]}
    _kind, add = requested_fact("marker", json.dumps(marker(MAX_MARKERS).request()), NOW)
    with raises_fault("marker.refused", MAX_MARKERS, error=SurveyRefusedError):
        add(full)
    gone = json.dumps({**GONE, "marker_id": marker(5).marker_id})
    assert requested_fact("marker_removed", gone, NOW)[1](full) is not None


@given(*3 * [st.text("ab\n", max_size=6)])
def test_notes_that_others_have_written_meanwhile_are_kept_once(before, wanted, present):
    sent = {**EXAMPLE.values(), "notes": wanted, "notes_before": before}
    change = requested_fact("annotation", json.dumps(sent), NOW)[1]
    fact = change({"annotation": {**EXAMPLE.values(), "notes": present}})
    kept = present if fact is None else fact.values["notes"]
    assert change({"annotation": {**EXAMPLE.values(), "notes": kept}}) is None  # a repetition
    added = present[len(before) :] if present.startswith(before) else present
    assert kept == wanted if present == before else wanted in kept and added.strip("\n") in kept
