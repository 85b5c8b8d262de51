"""survey.json gone or damaged: the log or survey.mcap says what it was, or it is refused."""

from __future__ import annotations

import json

import pytest
from annotation_examples import EXAMPLE
from fault_kit import raises_fault
from log_examples import make_former, marker
from reopening_kit import assert_whole
from trace_examples import STARTED_US, SURVEY, make_trace, read_json

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.description_copies import sealed_description
from gpr20_survey.folder.recovery import LATER, read_description
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import markers_of

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(4)]
METADATA = {"simulated": True, "parameters": {"x_points": 2}, "planned_traces": 4}


@pytest.fixture
def folder(kit):
    """A survey of which three of four traces are stored and that was stopped."""
    folder = kit.open(metadata_json=json.dumps(METADATA))
    for trace in TRACES[:3]:
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "stopped")
    return folder


def empty(path):
    path.write_bytes(b"")


def cut(path):
    path.write_bytes(path.read_bytes()[:200])


def flip(path):
    content = bytearray(path.read_bytes())
    content[0] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize("damage", [empty, cut, flip, lambda path: path.unlink()])
@pytest.mark.parametrize("by_folder", [False, True])
def test_a_survey_goes_on_with_what_its_log_says(kit, folder, damage, by_folder):
    path = folder / "survey.json"
    damage(path)
    left = path.read_bytes() if path.exists() else None
    reopened = kit.processing.reopen_survey(folder.name if by_folder else SURVEY)
    assert reopened.stored_indices == (0, 1, 2)
    assert json.loads(reopened.metadata_json) == METADATA
    assert "survey.repaired" in {one.fault_code for one in reopened.repairs}
    kept = folder / "damaged" / "survey.json"
    assert (kept.read_bytes() if kept.exists() else None) == left
    kit.processing.store(TRACES[3])
    kit.processing.close_survey(SURVEY, "finished")
    assert json.loads(path.read_text())["outcome"] == "finished"
    assert_whole(folder, TRACES)


def damage_sealed_copy(folder):
    content = (folder / "survey.mcap").read_bytes()
    place = content.index(b'"x_points"', content.index(b"application/json"))
    (folder / "survey.mcap").write_bytes(content[:place] + b'"y' + content[place + 2 :])


def test_the_log_replaces_a_sealed_copy_that_is_damaged(kit, folder):
    empty(folder / "survey.json")
    damage_sealed_copy(folder)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2)
    assert json.loads(reopened.metadata_json) == METADATA


@pytest.mark.parametrize("attachment", [True, False])
def test_without_the_log_the_mcap_holds_what_was_noted_while_it_was_recorded(
    kit, folder, attachment
):
    """Only how the survey ended at last is lost, and named for ever."""
    kit.processing.reopen_survey(SURVEY)
    kit.processing.annotate(SURVEY, EXAMPLE)
    kit.processing.add_marker(SURVEY, marker(1))
    kit.processing.report(SURVEY, '{"verdict": "some"}')
    kit.processing.close_survey(SURVEY, "stopped")
    log = read_json(folder / "survey.json")["log"]
    ends = [one["number"] for one in log if one["kind"] == "end"]
    assert len(ends) == 2
    empty(folder / "survey.json")
    (folder / "log.jsonl").unlink()
    if not attachment:
        damage_sealed_copy(folder)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2)
    assert json.loads(reopened.report_json) == {"verdict": "some"}
    for _ in range(2):
        description = read_description(folder)
        assert annotation_of(description) == EXAMPLE
        (found,) = markers_of(description)
        assert found.same_request(marker(1))
        assert set(description["unconfirmed"]) == {f"record {ends[-1]}"}
        kit.processing.close_survey(SURVEY, "stopped")
        kit.processing.reopen_survey(SURVEY)


def test_a_copy_that_is_damaged_too_is_not_believed(kit, folder):
    empty(folder / "survey.json")
    (folder / "log.jsonl").unlink()
    empty(folder / "survey.mcap")
    with raises_fault("survey.description_lost", "survey.json", error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)


@pytest.mark.parametrize("with_bag", [True, False])
def test_without_any_copy_the_survey_is_refused(kit, folder, with_bag):
    empty(folder / "survey.json")
    (folder / "log.jsonl").unlink()
    (folder / "survey.mcap").unlink()
    if not with_bag:
        (folder / "survey.bag").unlink()
    with raises_fault("survey.description_lost", "survey.json", error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)


def test_a_survey_of_an_earlier_version_goes_on_with_the_copy_in_the_mcap(kit, folder):
    make_former(folder)
    empty(folder / "survey.json")
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2)
    assert json.loads(reopened.metadata_json) == METADATA
    assert list(read_description(folder)["unconfirmed"]) == [LATER]


def test_the_description_of_another_survey_is_not_taken_for_this_ones(kit, folder):
    empty(folder / "survey.json")
    other = folder.with_name(folder.name[:-8] + "01234567")
    folder.rename(other)
    with raises_fault("survey.unknown", SURVEY, error=SurveyRefusedError):
        kit.processing.reopen_survey(other.name)


def test_a_description_that_was_changed_is_corrected_and_kept(kit, folder):
    path = folder / "survey.json"
    changed = path.read_bytes().replace(b'"x_points": 2', b'"x_points": 3')
    path.write_bytes(changed)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert json.loads(reopened.metadata_json) == METADATA
    assert "survey.repaired" in {one.fault_code for one in reopened.repairs}
    assert (folder / "damaged" / "survey.json").read_bytes() == changed


def with_another_id(folder):
    path = folder / "survey.json"
    other = SURVEY[:-1] + "f"
    path.write_bytes(path.read_bytes().replace(SURVEY.encode(), other.encode()))


def test_a_description_with_another_id_is_corrected(kit, folder):
    with_another_id(folder)
    assert kit.processing.reopen_survey(SURVEY).stored_indices == (0, 1, 2)


def test_without_a_copy_a_description_with_another_id_does_not_cost_the_traces(kit, folder):
    make_former(folder)
    with_another_id(folder)
    (folder / "survey.mcap").unlink()
    before = {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()}
    with raises_fault("survey.other_description", error=SurveyRefusedError):
        kit.processing.reopen_survey(folder.name)
    assert {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()} == before


def test_the_copy_stays_as_it_was_at_the_start_when_the_recording_is_written_again(kit, folder):
    for outcome in ("stopped", "finished"):
        kit.processing.reopen_survey(SURVEY)
        kit.processing.close_survey(SURVEY, outcome)
    copy = sealed_description(folder)
    assert (copy["outcome"], "resumed" in copy) == (None, False)
