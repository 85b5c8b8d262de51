"""What people note of a survey is as safe as what the robot measures, and damage is named."""

from __future__ import annotations

import multiprocessing
import os
import random
import shutil
from dataclasses import replace

import pytest
from annotation_examples import EXAMPLE
from failing_disk import FailingDisk, Failure
from fault_kit import raises_fault
from log_examples import NOW, add_marker, change_digit, entries, make_former, marker
from planned_survey import METADATA, POINTS, planned_trace
from run_seed import SEED
from storage_kit import Kit
from trace_examples import STARTED_US, SURVEY

from gpr20_analysis.read.manifest_repair import repair_manifest
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE, DAMAGED, INCOMPLETE
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.files import durable_files
from gpr20_survey.folder import annotating, manifest
from gpr20_survey.folder.annotating import add_to_survey, annotate
from gpr20_survey.folder.recovery import LATER, read_description, recover
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import markers_of
from gpr20_survey.recording.recordings import open_recordings
from gpr20_vna_processing.mid.new_survey import describe

FORMS = ("survey.json", "log.jsonl")
FLIPS = int(os.environ.get("GPR20_DAMAGES", "40"))
TRACES = [planned_trace(index) for index in range(len(POINTS))]
STORED = {"finished": len(POINTS), "stopped": 6, "interrupted": 6, "cut off": 6}
WRITERS, MARKERS_EACH = 3, 8


def make(place, ending):
    """Make a survey with two markers and an annotation, of which one marker came after its end."""
    kit = Kit(place / "open", open_recordings)
    folder = kit.open(metadata_json=METADATA)
    kit.processing.add_marker(SURVEY, marker(1))
    kit.processing.annotate(SURVEY, EXAMPLE)
    for trace in TRACES[: STORED[ending]]:
        kit.processing.store(trace)
    if ending != "cut off":
        kit.processing.close_survey(SURVEY, ending)
    kit.processing.add_marker(SURVEY, marker(2))
    shutil.copytree(str(place / "open"), str(place / "data"))
    kit.processing.shut_down()
    return place / "data" / folder.name


@pytest.fixture(scope="module")
def surveys(tmp_path_factory):
    """A survey for each way in which one ends."""
    return {ending: make(tmp_path_factory.mktemp("whole"), ending) for ending in STORED}


@pytest.fixture
def copies(surveys, tmp_path):
    """Gives copies of these surveys, each alone in a data folder."""

    def copy(ending):
        place = tmp_path / str(len(list(tmp_path.iterdir()))) / "data"
        shutil.copytree(str(surveys[ending].parent), str(place))
        return place / surveys[ending].name

    return copy


def resume(folder, outcome=None):
    """Resume a survey and close it again, finished unless another outcome is given."""
    kit = Kit(folder.parent, open_recordings)
    try:
        reopened = kit.processing.reopen_survey(SURVEY)
        if outcome is None:
            kit.finish(TRACES, reopened.stored_indices)
        else:
            kit.processing.close_survey(SURVEY, outcome)
    finally:
        kit.processing.shut_down()


def noted(folder):
    return [one.text for one in markers_of(read_description(folder)) if one.is_present]


REPAIRS = {
    "resume": resume,
    "annotate": lambda folder: add_to_survey(folder, annotate(EXAMPLE), NOW),
    "gpr20 repair": lambda folder: repair_manifest(folder, "1.2.3", NOW),
}


@pytest.mark.parametrize("repair", REPAIRS)
@pytest.mark.parametrize("name", FORMS)
def test_a_changed_place_of_a_marker_is_found_and_never_sealed(copies, repair, name):
    folder = copies("stopped")
    change_digit(folder, name, 1)
    assert verify_survey(folder).status == DAMAGED
    REPAIRS[repair](folder)
    first, second = markers_of(read_description(folder))
    assert first.same_request(marker(1)) and second.same_request(marker(2))
    found = verify_survey(folder)
    assert (found.status, found.faults) == (COMPLETE if repair == "resume" else INCOMPLETE, [])
    assert found.unconfirmed == ()
    assert (folder / "damaged" / name).is_file()


@pytest.mark.parametrize("ending", STORED)
@pytest.mark.parametrize("name", FORMS)
def test_a_file_that_one_bit_broke_loses_nothing_that_was_noted(copies, ending, name):
    folder = copies(ending)
    content = bytearray((folder / name).read_bytes())
    content[0] ^= 1
    (folder / name).write_bytes(content)
    resume(folder)
    assert noted(folder) == [marker(1).text, marker(2).text]
    assert annotation_of(read_description(folder)) == EXAMPLE
    assert verify_survey(folder).status == COMPLETE


@pytest.mark.parametrize("ending", [one for one in STORED if one != "finished"])
def test_a_marker_damaged_in_both_files_is_named_for_ever(copies, ending):
    folder = copies(ending)
    number = next(one["number"] for one in entries(folder) if one["kind"] == "marker")
    if ending == "cut off":
        (folder / "survey.mcap").unlink()  # which holds it too
    else:
        shutil.copy(str(folder / "survey.bag"), str(folder / "survey.mcap"))
    for name in FORMS:
        change_digit(folder, name, 1)
    assert verify_survey(folder).status == DAMAGED
    with raises_fault("survey.description_damaged", error=SurveyRefusedError):
        add_to_survey(folder, annotate(EXAMPLE), NOW)
    resume(folder, "stopped")
    resume(folder)
    assert noted(folder) == [marker(2).text]
    found = verify_survey(folder)
    assert (found.status, found.faults) == (INCOMPLETE, [])
    name = f"record {number}"
    assert found.unconfirmed == (name,)
    assert manifest.read_manifest(folder).unconfirmed == (name,)
    assert len(read_description(folder)["unconfirmed"][name]["found"]) == 2


def test_a_marker_damaged_in_both_files_is_taken_from_the_recording(copies):
    folder = copies("stopped")
    for name in FORMS:
        change_digit(folder, name, 1)
    resume(folder)
    first, second = markers_of(read_description(folder))
    assert first.same_request(marker(1)) and second.same_request(marker(2))
    assert verify_survey(folder).status == COMPLETE


def test_every_flip_of_a_sealed_folder_is_found_and_nothing_is_lost_by_it(surveys, copies):
    for number in range(FLIPS):
        chance = random.Random(f"{SEED} {number}")
        shown = f"{number}: repeat with GPR20_SEED={SEED}"
        ending = chance.choice(list(STORED))
        folder = copies(ending)
        files = sorted(one for one in folder.rglob("*") if one.is_file())
        path = chance.choice([*files, *(folder / one for one in FORMS * 3)])
        content = bytearray(path.read_bytes())
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        path.write_bytes(content)
        if ending != "cut off" or path.name in FORMS:
            assert verify_survey(folder).status == DAMAGED, shown
        resume(folder)
        assert noted(folder) == [marker(1).text, marker(2).text], shown
        assert annotation_of(read_description(folder)) == EXAMPLE, shown
        found = verify_survey(folder)
        assert (found.status, found.faults) == (COMPLETE, []), shown
        shutil.rmtree(str(folder.parent))


@pytest.mark.parametrize("name", FORMS)
def test_a_form_that_lacks_the_last_entry_of_a_sealed_survey_is_a_fault(copies, name):
    folder = copies("finished")
    before = (folder / name).read_bytes()
    add_to_survey(folder, add_marker(3), NOW)
    assert verify_survey(folder).status == COMPLETE
    (folder / name).write_bytes(before)
    assert verify_survey(folder).status == DAMAGED
    add_to_survey(folder, add_marker(4), NOW)
    assert len(noted(folder)) == 4
    assert verify_survey(folder).status == COMPLETE


def write_markers(folder, writer, answers):
    for number in range(MARKERS_EACH):
        add_to_survey(folder, add_marker(100 * writer + number), NOW)
        answers.put(100 * writer + number)


def test_processes_that_add_at_once_lose_nothing_and_leave_it_intact(copies):
    folder = copies("finished")
    context = multiprocessing.get_context("fork")
    answers = context.Queue()
    children = [
        context.Process(target=write_markers, args=(folder, writer, answers))
        for writer in range(1, WRITERS + 1)
    ]
    for child in children:
        child.start()
    acknowledged = [answers.get(timeout=120) for _ in range(WRITERS * MARKERS_EACH)]
    for child in children:
        child.join(60)
        assert child.exitcode == 0
    found = noted(folder)[2:]
    assert sorted(found) == sorted(marker(number).text for number in acknowledged)
    for writer in range(1, WRITERS + 1):
        own = [marker(100 * writer + number).text for number in range(MARKERS_EACH)]
        assert [text for text in found if text in own] == own
    assert verify_survey(folder).status == COMPLETE


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
    assert noted(folder) == [marker(number).text for number in (1, 2, 3, 4)]


def cut_power(folder, place, calls, share, seed, work):
    """Do some work on a disk that loses its power; return whether it was done before that."""
    disk = FailingDisk(folder)
    try:
        with disk.failing(Failure(calls, True, share, seed), place):
            try:
                work()
            except StorageFailedError:
                return False
            return not disk.has_failed
    finally:
        disk.release()


@pytest.mark.parametrize("former", [False, True])
@pytest.mark.parametrize("damaged", ["", *FORMS])
def test_a_power_cut_at_any_call_adds_a_fact_whole_or_not_and_leaves_it_intact(
    copies, tmp_path, former, damaged
):
    """Even where the disk loses all that was not made durable, or a part of it."""
    if former and damaged:
        pytest.skip("a survey of an earlier version has one form")
    whole = copies("finished")
    if former:
        make_former(whole)
    seen, calls, done = set(), 0, False
    while not done:
        folder, after = tmp_path / f"{calls} before", tmp_path / f"{calls} after"
        shutil.copytree(str(whole), str(folder / whole.name))
        if damaged:
            change_digit(folder / whole.name, damaged, 1)
        chance = random.Random(f"{SEED} {calls}")
        share = chance.choice([0.0, 0.5, 1.0])
        done = cut_power(
            folder, after, calls, share, chance.randrange(100),
            lambda folder=folder: add_to_survey(folder / whole.name, add_marker(3), NOW),
        )  # fmt: skip
        left = after / whole.name
        count = len(noted(left))
        seen.add(count)
        assert count in (2, 3), (SEED, calls)
        if done:
            assert count == 3, (SEED, calls)
        found = verify_survey(left)
        if not damaged:
            assert (found.status, found.faults) == (COMPLETE, []), (SEED, calls)
        add_to_survey(left, add_marker(3), NOW)
        add_to_survey(left, add_marker(4), NOW)
        assert noted(left) == [marker(number).text for number in (1, 2, 3, 4)]
        found = verify_survey(left)
        assert (found.status, found.faults) == (COMPLETE, []), (SEED, calls)
        calls += 1
    assert seen == {2, 3} and calls > 8


def test_an_entry_that_was_torn_while_it_was_added_leaves_a_sealed_survey_intact(copies):
    folder = copies("finished")
    before, former = (folder / "log.jsonl").read_bytes(), (folder / "survey.json").read_bytes()
    sealed = manifest.read_manifest(folder)
    add_to_survey(folder, add_marker(3), NOW)
    line = (folder / "log.jsonl").read_bytes()[len(before) :]
    adding = replace(sealed, next_log=manifest.read_manifest(folder).log)
    # Of a line on two sectors the second one alone may be on the disk.
    halves = (line[:1], line[: len(line) // 2], line[:-2], bytes(200) + line[200:])
    for size, torn in enumerate(halves):
        (folder / "log.jsonl").write_bytes(before + torn)
        (folder / "survey.json").write_bytes(former)
        (folder / "manifest.json").write_bytes(adding.encode())
        found = verify_survey(folder)
        assert (found.status, found.faults) == (COMPLETE, []), size
        add_to_survey(folder, add_marker(4), NOW)
        assert noted(folder) == [marker(number).text for number in (1, 2, 4)]
        assert verify_survey(folder).status == COMPLETE


def test_an_opening_that_failed_half_way_is_repeated_with_the_same_id(tmp_path, monkeypatch):
    calls, failed, opened = 0, 0, False
    while not opened:
        data = tmp_path / str(calls)
        data.mkdir()
        kit = Kit(data, open_recordings, check_data=lambda: None)
        left = [calls]

        def failing(real, left=left):
            def call(*arguments, **named):
                left[0] -= 1
                if left[0] < 0:
                    raise OSError(28, "No space left on device")
                return real(*arguments, **named)

            return call

        with monkeypatch.context() as patch:
            for name in ("write", "pwrite", "fsync", "replace", "link", "mkdir"):
                patch.setattr(os, name, failing(getattr(os, name)))
            try:
                kit.open(metadata_json=METADATA)
                opened = True
            except StorageFailedError as error:
                assert error.message.fault_code == "disk.full"
                failed += 1
        if calls % 2 and not opened:  # the process ends
            kit.processing.shut_down()
            kit = Kit(data, open_recordings, check_data=lambda: None)
        folder = kit.open(metadata_json=METADATA)
        assert not any(map(durable_files.is_temporary, os.listdir(folder)))
        kit.finish(TRACES, ())
        kit.processing.shut_down()
        assert verify_survey(folder).status == COMPLETE, calls
        calls += 1
    assert failed > 8


@pytest.mark.parametrize("recorded", [True, False])
def test_a_survey_whose_opening_was_cut_off_is_resumed_and_nothing_of_it_is_lost(
    tmp_path, recorded
):
    kit = Kit(tmp_path / "open", open_recordings)
    if not recorded:
        opened = tmp_path / "open" / "20260921T141320_0f8fad5b"
        opened.mkdir(parents=True)
        for recording in open_recordings(opened, describe(SURVEY, STARTED_US, METADATA, "1.2.3")):
            recording.commit()  # as a write that was torn behind what a recording begins with
    else:
        opened = kit.open(metadata_json=METADATA)
    shutil.copytree(str(tmp_path / "open"), str(tmp_path / "data"))
    kit.processing.shut_down()
    folder = tmp_path / "data" / opened.name
    for name in FORMS:  # the last that an opening makes
        (folder / name).unlink(missing_ok=True)
    resume(folder)
    found = verify_survey(folder)
    assert (found.status, found.faults, found.unconfirmed) == (COMPLETE, [], ())


def test_a_survey_both_forms_of_whose_log_are_gone_is_never_called_intact(copies):
    """What came while it was recorded is there, but perhaps not all: nothing says it."""
    folder = copies("stopped")
    for name in (*FORMS, "manifest.json"):
        (folder / name).unlink()
    resume(folder)
    assert noted(folder) == [marker(1).text]
    found = verify_survey(folder)
    assert (found.status, found.faults, found.unconfirmed) == (INCOMPLETE, [], (LATER,))


def test_a_folder_that_holds_anything_else_is_not_emptied_by_an_opening(tmp_path):
    kit = Kit(tmp_path, open_recordings)
    folder = kit.open(metadata_json=METADATA)
    kit.processing.store(TRACES[0])
    kit.processing.close_survey(SURVEY, "stopped")
    for name in ("survey.json", "manifest.json"):
        (folder / name).unlink()
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with raises_fault("survey.folder_exists", error=SurveyRefusedError):
        kit.open(metadata_json=METADATA)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    kit.processing.shut_down()


def test_the_last_trace_is_that_of_the_largest_index_whatever_the_clock_said(tmp_path):
    kit = Kit(tmp_path, open_recordings)
    kit.open(metadata_json=METADATA)
    for index in range(3):
        kit.processing.store(planned_trace(index))
    kit.processing.store(planned_trace(3, timestamp_us=TRACES[0].timestamp_us - 10**6))
    kit.processing.shut_down()
    again = Kit(tmp_path, open_recordings)
    reopened = again.processing.reopen_survey(SURVEY)
    assert reopened.recent[-1].index == 3
    assert [one.index for one in again.stored] == [3]
    again.processing.shut_down()


def test_a_trace_waits_for_its_file_and_the_mcap_alone(tmp_path, monkeypatch):
    kit = Kit(tmp_path, open_recordings)
    folder = kit.open(metadata_json=METADATA)
    synced = []
    real = os.fsync

    def fsync(descriptor):
        synced.append(os.readlink(f"/proc/self/fd/{descriptor}"))
        real(descriptor)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", fsync)
        kit.processing.store(TRACES[0])
    kit.processing.shut_down()
    assert str(folder / "survey.mcap") in synced and str(folder / "survey.bag") not in synced
    assert len(synced) == 3  # the file, its name, the MCAP


def test_what_resuming_repaired_is_in_the_log_and_in_the_recording(copies):
    folder = copies("cut off")
    resume(folder, "stopped")
    kinds = [one.kind for one in recover(folder).found.records]
    assert kinds == ["plan", "marker", "annotation", "marker", "resume", "end"]
