"""Markers of a survey: stored before they are acknowledged, and removed ones remembered."""

from __future__ import annotations

import json
import os
import random
import shutil

import pytest
from fault_kit import raises_fault
from log_examples import NOW, add_marker, make_former, marker
from planned_survey import METADATA, POINTS, planned_trace
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import SURVEY, read_json

from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.folder.annotating import add_to_survey
from gpr20_survey.folder.recovery import read_description
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

ONE = Marker(marker(1).marker_id, 12.5, 20.0, 80.0, "metal, junto a la raíz", "Ana")
OTHER = Marker(marker(2).marker_id, 15.0, 10.0)
SEEDS = int(os.environ.get("GPR20_MARKER_DRAWS", "15"))


@pytest.fixture
def folder(kit):
    """A survey that is open, with every trace."""
    folder = kit.open(metadata_json=METADATA)
    for index in range(len(POINTS)):
        kit.processing.store(planned_trace(index))
    return folder


@pytest.fixture
def closed(kit, folder):
    """A survey that is finished."""
    kit.processing.close_survey(SURVEY, "finished")
    return folder


def stored(folder):
    return markers_of(read_json(folder / "survey.json"))


def assert_intact(folder):
    found = verify_survey(folder)
    assert found.status == 0, (found.verdict, found.faults)


@pytest.mark.parametrize("name", ["", SURVEY, "folder"])
def test_the_open_survey_is_marked_and_stays_so(kit, folder, name):
    marked = kit.processing.add_marker(folder.name if name == "folder" else name, ONE)
    assert (marked.survey_id, marked.folder) == (SURVEY, folder)
    (found,) = stored(folder)
    assert found == marked.markers[0]
    assert found.time and found.same_request(ONE)
    kit.processing.report(SURVEY, "{}")
    kit.processing.close_survey(SURVEY, "finished")
    assert stored(folder) == marked.markers
    assert_intact(folder)


def test_a_closed_survey_is_marked_and_stays_intact(kit, closed):
    before = read_description(closed)
    kit.processing.add_marker(SURVEY, ONE)
    assert_intact(closed)
    marked = kit.processing.add_marker(closed.name, OTHER)
    assert_intact(closed)
    after = read_description(closed)
    assert after == {**before, "markers": values_of(marked.markers)}
    assert [one.marker_id for one in stored(closed)] == [ONE.marker_id, OTHER.marker_id]


def test_a_past_survey_is_marked_while_another_one_is_open(kit, closed):
    kit.open(OTHER_SURVEY)
    kit.processing.add_marker(SURVEY, ONE)
    assert len(stored(closed)) == 1
    kit.processing.close_survey(OTHER_SURVEY, "stopped")


@pytest.mark.parametrize("is_open", [True, False])
def test_a_removed_marker_remains_in_the_history(kit, folder, is_open):
    kit.processing.add_marker(SURVEY, ONE)
    kit.processing.add_marker(SURVEY, OTHER)
    if not is_open:
        kit.processing.close_survey(SURVEY, "finished")
    for _ in range(2):  # the answer to the first call may have been lost
        kit.processing.remove_marker(SURVEY, ONE.marker_id, "Luis")
    removed, other = stored(folder)
    assert (removed.text, removed.author, removed.removed_by) == (ONE.text, "Ana", "Luis")
    assert removed.removed and not removed.is_present and other.is_present
    assert present_markers(read_json(folder / "survey.json")) == (other,)


def test_a_repeated_request_adds_nothing_and_another_one_of_its_id_is_refused(kit, folder):
    kit.processing.add_marker(SURVEY, ONE)
    kit.processing.add_marker(SURVEY, ONE)
    assert len(stored(folder)) == 1
    with raises_fault("marker.refused", error=SurveyRefusedError):
        kit.processing.add_marker(SURVEY, Marker(ONE.marker_id, 0.0, 0.0))
    with raises_fault("marker.refused", error=SurveyRefusedError):
        kit.processing.remove_marker(SURVEY, OTHER.marker_id, "")
    assert len(stored(folder)) == 1


def test_a_survey_has_a_limited_number_of_markers():
    full = {"markers": values_of(tuple(marker(number) for number in range(MAX_MARKERS)))}
    with raises_fault("marker.too_many", error=SurveyRefusedError):
        new_marker(full, marker(MAX_MARKERS), NOW)
    assert removed_marker(full, marker(5).marker_id, "", NOW) is not None


def test_markers_survive_interruption_resumption_and_another_process(tmp_path):
    first = Kit(tmp_path / "data", open_recordings)
    folder = first.open(metadata_json=METADATA)
    first.processing.store(planned_trace(0))
    first.processing.add_marker("", ONE)
    first.processing.shut_down()
    second = Kit(tmp_path / "data", open_recordings)
    second.processing.add_marker(SURVEY, OTHER)
    reopened = second.processing.reopen_survey(SURVEY)
    assert "markers" not in json.loads(reopened.metadata_json)
    for index in range(1, len(POINTS)):
        second.processing.store(planned_trace(index))
    second.processing.close_survey(SURVEY, "finished")
    second.processing.shut_down()
    assert [one.text for one in stored(folder)] == [ONE.text, OTHER.text]
    assert_intact(folder)


def test_a_survey_with_damaged_markers_can_be_resumed(tmp_path):
    first = Kit(tmp_path / "data", open_recordings)
    folder = first.open(metadata_json=METADATA)
    first.processing.store(planned_trace(0))
    first.processing.shut_down()
    path = folder / "survey.json"
    path.write_text(json.dumps({**make_former(folder), "markers": [5]}))
    (folder / "manifest.json").unlink()
    second = Kit(tmp_path / "data", open_recordings)
    with raises_fault("marker.damaged", error=SurveyRefusedError):
        second.processing.add_marker(SURVEY, ONE)
    second.processing.reopen_survey(SURVEY)
    second.processing.add_marker(SURVEY, ONE)
    second.processing.shut_down()
    assert len(stored(folder)) == 1
    assert "5" in str(read_json(folder / "survey.json")["unconfirmed"]["markers"])


def test_what_is_no_survey_cannot_be_marked(kit, closed):
    for name in ("", OTHER_SURVEY, "../x", "/etc", "20260921T141320_ffffffff"):
        with pytest.raises(SurveyRefusedError):
            print(kit.processing.add_marker(name, ONE))


def test_metadata_cannot_bring_markers(kit):
    with raises_fault("storage.request_refused", error=SurveyRefusedError):
        kit.open(metadata_json=json.dumps({"markers": []}))


def test_a_disk_that_refuses_leaves_the_former_markers(kit, closed, monkeypatch):
    def refuse(*_arguments):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", refuse)
        with raises_fault("disk.full", error=StorageFailedError):
            kit.processing.add_marker(SURVEY, ONE)
    assert stored(closed) == ()
    assert_intact(closed)


class PowerCutError(Exception):
    """Nothing reaches the disk any more."""


@pytest.mark.parametrize("former", [False, True])
def test_a_cut_at_any_step_leaves_the_former_markers_or_the_new_ones(
    closed, tmp_path, monkeypatch, former
):
    """Each call of the disk is the last one in turn."""
    if former:
        make_former(closed)
    counts, calls, ended = set(), 0, False
    while not ended:
        copy = tmp_path / str(calls) / closed.name
        shutil.copytree(str(closed), str(copy))
        with monkeypatch.context() as patch:
            die_after(patch, calls)
            try:
                add_to_survey(copy, add_marker(1), NOW)
                ended = True
            except PowerCutError:
                pass
        counts.add(len(stored(copy)))
        found = verify_survey(copy)
        assert found.status == 0, (calls, found.faults)
        add_to_survey(copy, add_marker(1), NOW)
        add_to_survey(copy, add_marker(2), NOW)
        assert len(stored(copy)) == 2
        found = verify_survey(copy)
        assert found.status == 0, (calls, found.faults)
        calls += 1
    assert counts == {0, 1} and calls > 10


def die_after(patch, calls):
    """Let nothing reach the disk after so many calls."""
    left = calls

    def cut(real):
        def call(*arguments, **named):
            nonlocal left
            if left == 0:
                raise PowerCutError
            left -= 1
            return real(*arguments, **named)

        return call

    for name in ("write", "pwrite", "fsync", "replace", "link", "unlink", "mkdir"):
        patch.setattr(os, name, cut(getattr(os, name)))


@pytest.mark.parametrize("former", [False, True])
def test_a_flipped_bit_is_never_covered_by_a_new_checksum(closed, former):
    add_to_survey(closed, add_marker(1), NOW)
    if former:
        make_former(closed)
    before = {path: path.read_bytes() for path in closed.rglob("*") if path.is_file()}
    names = ["survey.json", "manifest.json", *([] if former else ["log.jsonl"])]
    for seed in range(SEEDS):
        chance = random.Random(seed)
        path = closed / chance.choice(names)
        content = bytearray(before[path])
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        path.write_bytes(content)
        assert verify_survey(closed).status == 2, seed
        if former or path.name == "manifest.json":
            with pytest.raises(SurveyRefusedError):
                add_to_survey(closed, add_marker(2), NOW)
            assert path.read_bytes() == content, seed
            assert verify_survey(closed).status == 2, seed
        else:
            add_to_survey(closed, add_marker(2), NOW)
            assert [one.text for one in stored(closed)] == ["ñ 1", "ñ 2"], seed
            assert stored(closed)[0].same_request(marker(1)), seed
            assert_intact(closed)
        shutil.rmtree(str(closed))
        for path, whole in before.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(whole)


def test_a_marker_that_is_not_allowed_is_refused():
    for wrong, shown in [
        ({"marker_id": "1"}, ()),
        ({"marker_id": 5}, (5,)),
        ({"x_mm": float("nan")}, ("X", "nan")),
        ({"y_mm": 10_001.0}, ("Y", 10001)),
        ({"y_mm": True}, ("Y", "bool")),
        ({"depth_mm": -1.0}, ("depth", -1)),
        ({"text": "a\nb"}, ("U+000A",)),
        ({"text": "a" * 501}, (501,)),
        ({"author": "\x1b"}, ("U+001B",)),
        ({"author": None}, ("NoneType",)),
    ]:
        with raises_fault("value.not_allowed", *shown):
            print(Marker(**{"marker_id": ONE.marker_id, "x_mm": 1.0, "y_mm": 2.0, **wrong}))


def test_damaged_markers_are_recognized():
    more = {**values_of((ONE,))[0], "more": 1}
    for markers in (5, {}, [5], [{"x_mm": 1}], [more], values_of((ONE, ONE))):
        with raises_fault("marker.damaged"):
            print(markers, markers_of({"markers": markers}))


def test_an_older_survey_has_no_markers():
    assert markers_of(json.loads(METADATA)) == ()
