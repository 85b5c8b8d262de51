"""The manifest of a survey that is reopened: it decides what is damaged, and is removed last."""

from __future__ import annotations

import json
import shutil

import pytest
from fault_kit import raises_fault
from log_examples import make_former
from planned_survey import METADATA, POINTS, planned_trace
from reopening_kit import assert_whole, messages_in_mcap
from storage_kit import OTHER_SURVEY, Kit, text_message
from trace_examples import SURVEY

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE, INCOMPLETE
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.files import file_sums
from gpr20_survey.folder import manifest
from gpr20_survey.folder.recovery import recover
from gpr20_survey.recording.recordings import open_recordings

TRACES = [planned_trace(index) for index in range(len(POINTS))]
STORED = 6


def make(place, ending):
    kit = Kit(place / "open", open_recordings)
    folder = kit.open(metadata_json=METADATA)
    for trace in TRACES[:STORED]:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)
    if ending == "stopped":
        kit.processing.close_survey(SURVEY, "stopped")
    elif ending == "interrupted":
        kit.processing.interrupt_other(OTHER_SURVEY)
    shutil.copytree(str(place / "open"), str(place / "data"))
    kit.processing.shut_down()
    return place / "data" / folder.name


@pytest.fixture
def stopped(tmp_path):
    return make(tmp_path, "stopped")


@pytest.fixture
def cut_off(tmp_path):
    return make(tmp_path, "cut off")


def reopen_and_finish(kit, folder):
    """Return the values that the repairs name, with their codes."""
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == tuple(range(STORED))
    for trace in TRACES[STORED:]:
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "finished")
    assert_whole(folder, TRACES)
    assert verify_survey(folder).status == COMPLETE
    found = {one.fault_code for one in reopened.repairs}
    for inner in (inner for one in reopened.repairs for inner in one.nested()):
        found.update(value for value in inner.values.values() if isinstance(value, (str, int)))
    return found


def change(path, wanted=None):
    content = bytearray(path.read_bytes())
    place = content.index(wanted) + len(wanted) - 1 if wanted else len(content) // 2
    content[place] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize("ending", ["stopped", "interrupted"])
def test_every_closed_survey_is_sealed(tmp_path, ending):
    folder = make(tmp_path, ending)
    sealed = manifest.read_manifest(folder)
    assert len(sealed.files) == STORED + 2
    assert sealed.covers(recover(folder).found.records)
    for name in sealed.files:
        assert sealed.matches(name, file_sums.sum_of_file(folder / name))
    assert verify_survey(folder).status == INCOMPLETE and verify_survey(folder).sealed


def test_a_trace_that_changed_before_the_close_is_found(tmp_path):
    """The manifest holds what was acknowledged, not what is on the disk at the end."""
    kit = Kit(tmp_path / "data", open_recordings)
    folder = kit.open(metadata_json=METADATA)
    kit.processing.store(TRACES[0])
    change(next((folder / "traces").iterdir()), b'"s21_imag": [')
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    faults = " ".join(map(str, verify_survey(folder).faults))
    assert "000000_X0010.00_Y0010.00_Z+000.00.json" in faults


def test_nothing_is_repaired_in_a_sealed_survey_that_is_whole(kit, stopped):
    assert reopen_and_finish(kit, stopped) == set()
    assert not (stopped / "damaged").exists()


def test_a_message_changed_in_the_bag_is_taken_from_the_mcap(kit, stopped):
    change(stopped / "survey.bag", b"before 3")
    assert "survey.bag" in reopen_and_finish(kit, stopped)
    assert b"before 3" in (stopped / "survey.bag").read_bytes()


def test_a_chunk_damaged_in_the_mcap_keeps_both_recordings_and_every_trace(kit, stopped):
    content = (stopped / "survey.mcap").read_bytes()
    place = content.index(b"zstd", len(content) // 2) + 40
    (stopped / "survey.mcap").write_bytes(
        content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]
    )
    bag = (stopped / "survey.bag").read_bytes()
    assert "survey.mcap" in reopen_and_finish(kit, stopped)
    texts = [one.data for one in messages_in_mcap(stopped, "/t")]
    assert len(texts) >= STORED - 1
    # What other topics said in the damaged chunk is in the kept bag.
    assert (stopped / "damaged" / "survey.bag").read_bytes() == bag
    assert (stopped / "damaged" / "survey.mcap").exists()


def test_a_space_changed_in_a_trace_file_is_repaired(kit, stopped):
    path = sorted((stopped / "traces").iterdir())[2]
    path.write_bytes(path.read_bytes().replace(b": ", b":  ", 1))
    repairs = reopen_and_finish(kit, stopped)
    assert {path.name, "damaged", "survey.repaired"} <= repairs


def test_a_damaged_manifest_is_kept_and_named(kit, stopped):
    change(stopped / "manifest.json")
    repairs = reopen_and_finish(kit, stopped)
    assert {"manifest.json", "damaged", "survey.repaired"} <= repairs
    assert (stopped / "damaged" / "manifest.json").exists()


def test_another_file_that_changed_is_named(kit, stopped):
    (stopped / "notes.txt").write_text("not there at the close")
    assert "notes.txt" in reopen_and_finish(kit, stopped)


def flip_plan(folder):
    """Change the area in survey.json, as one flipped bit can."""
    path = folder / "survey.json"
    path.write_bytes(path.read_bytes().replace(b'"y_stop_mm": 20.0', b'"y_stop_mm": 30.0'))


def test_a_changed_plan_is_corrected_and_the_key_is_named(kit, cut_off):
    flip_plan(cut_off)
    named = [str(one) for one in verify_survey(cut_off).faults]
    assert any("parameters/y_stop_mm" in one and "30.0" in one for one in named)
    repairs = reopen_and_finish(kit, cut_off)
    assert {"survey.json", "survey.repaired"} <= repairs
    assert b'"y_stop_mm": 30.0' in (cut_off / "damaged" / "survey.json").read_bytes()


def test_without_the_mcap_the_log_still_has_the_plan(kit, cut_off):
    flip_plan(cut_off)
    (cut_off / "survey.mcap").unlink()
    assert {"survey.json", "survey.mcap", "survey.repaired"} <= reopen_and_finish(kit, cut_off)


def test_without_any_copy_traces_that_do_not_fit_the_plan_are_refused_by_name(kit, cut_off):
    make_former(cut_off)
    flip_plan(cut_off)
    (cut_off / "survey.mcap").unlink()
    before = {one: one.read_bytes() for one in cut_off.rglob("*") if one.is_file()}
    with raises_fault("survey.traces_not_planned", 3, "y", 15, 20, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)
    assert before == {one: one.read_bytes() for one in cut_off.rglob("*") if one.is_file()}


def test_without_any_copy_a_plan_that_fits_is_used_with_a_warning(kit, cut_off):
    make_former(cut_off)
    (cut_off / "survey.mcap").unlink()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == tuple(range(STORED))
    assert "survey.unconfirmed" in {one.fault_code for one in reopened.repairs}
    for trace in TRACES[STORED:]:
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "finished")
    found = verify_survey(cut_off)
    # It is never called intact again.
    assert (found.status, found.faults) == (INCOMPLETE, [])
    assert "plan" in found.unconfirmed


@pytest.mark.parametrize("entry", [{"frequency_points": 6}, {"stop_frequency_hz": 5e9}])
def test_frequencies_are_part_of_the_plan(kit, cut_off, entry):
    values = make_former(cut_off)
    values["parameters"].update(entry)
    (cut_off / "survey.json").write_text(json.dumps(values, indent=2) + "\n")
    (cut_off / "survey.mcap").unlink()
    with raises_fault("survey.traces_not_planned", 5, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)
