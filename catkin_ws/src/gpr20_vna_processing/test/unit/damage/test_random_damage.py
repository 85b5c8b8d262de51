"""Random damage to a survey's files: nothing is lost that an intact form holds, nothing is wrong,
and nothing is called complete that is not.

GPR20_DAMAGES sets how many damages are tried, GPR20_SEED repeats those of a run.
"""

from __future__ import annotations

import os
import random
import shutil

import pytest
from annotation_examples import EXAMPLE
from log_examples import marker
from planned_survey import METADATA, POINTS, planned_trace
from reopening_kit import assert_whole
from run_seed import SEED
from storage_kit import Kit, text_message
from trace_examples import SURVEY, assert_same_numbers, read_json

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import markers_of
from gpr20_survey.recording.recordings import open_recordings

DAMAGES = int(os.environ.get("GPR20_DAMAGES", "60"))
TRACES = [planned_trace(index) for index in range(len(POINTS))]
STORED = {"finished": len(POINTS), "stopped": 6, "cut off": 6}
FORMS = ("json", "bag", "mcap", "survey.json", "log", "manifest")
SINGLE = {
    "bag": "survey.bag",
    "mcap": "survey.mcap",
    "survey.json": "survey.json",
    "log": "log.jsonl",
    "manifest": "manifest.json",
}


@pytest.fixture(scope="module")
def surveys(tmp_path_factory):
    """A data folder for each way in which a survey ends."""
    made = {}
    for ending, count in STORED.items():
        place = tmp_path_factory.mktemp("whole")
        kit = Kit(place / "open", open_recordings)
        folder = kit.open(metadata_json=METADATA)
        kit.processing.add_marker(SURVEY, marker(1))
        kit.processing.annotate(SURVEY, EXAMPLE)
        for trace in TRACES[:count]:
            kit.processing.record(text_message("/control_status", f"measuring {trace.index}"))
            kit.processing.store(trace)
        if ending != "cut off":
            kit.processing.close_survey(SURVEY, ending)
        kit.processing.add_marker(SURVEY, marker(2))
        kit.processing.remove_marker(SURVEY, marker(1).marker_id, "Luis")
        shutil.copytree(str(place / "open"), str(place / "data"))
        kit.processing.shut_down()
        made[ending] = place / "data" / folder.name
    return made


def damage_file(rng, path) -> None:
    """Flip bits, cut, overwrite, delete, insert or remove."""
    content = bytearray(path.read_bytes())
    start = rng.randrange(len(content))
    end = min(len(content), start + rng.choice([1, 4, 50, 1000, 10_000]))
    action = rng.choice(["flip", "flip", "flips", "cut", "overwrite", "zero", "delete", "insert"])
    if action == "flip":
        content[start] ^= 1 << rng.randrange(8)
    elif action == "flips":
        for _ in range(rng.randrange(2, 30)):
            content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    elif action == "cut":
        del content[start:]
    elif action == "overwrite":
        content[start:end] = bytes(rng.randrange(256) for _ in range(end - start))
    elif action == "zero":
        content[start:end] = bytes(end - start)
    elif action == "delete":
        del content[start:end]
    else:
        content[start:start] = bytes(rng.randrange(256) for _ in range(end - start))
    path.write_bytes(content)


def damage(rng, folder) -> None:
    for form in rng.sample(FORMS, rng.choice([1, 1, 1, 1, 2, 2, 3])):
        if form == "json":
            files = sorted((folder / "traces").iterdir())
            paths = rng.sample(files, rng.choice([1, 1, 2, len(files)]))
        else:
            paths = [folder / SINGLE[form]]
        for path in paths:
            if rng.random() < 0.15:
                path.unlink(missing_ok=True)
            elif path.exists():
                damage_file(rng, path)


def tree(folder):
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def data_of(files):
    """Return all but the manifest, which also says what changes nothing: when it was written."""
    return {name: content for name, content in files.items() if name != "manifest.json"}


def intact_forms(before, after, index):
    """Return the files that hold a trace and were not damaged."""
    name = next(one for one in before if one.startswith(f"traces/{index:06d}_"))
    return [one for one in (name, "survey.mcap") if after.get(one) == before[one]]


def is_noted(before, after) -> bool:
    """Return whether a form of the log was not damaged."""
    return any(after.get(one) == before[one] for one in ("survey.json", "log.jsonl"))


def check_facts(folder, before, after) -> None:
    """What was noted is all there, or what is missing is named; none of it is another."""
    description = read_description(folder)
    found = {one.marker_id: one for one in markers_of(description)}
    for number in (1, 2):
        one = found.pop(marker(number).marker_id, None)
        assert one is not None or description["unconfirmed"]
        if one is not None:
            assert one.same_request(marker(number))
            assert one.is_present is (number == 2) or description["unconfirmed"]
    assert not found
    assert annotation_of(description) == EXAMPLE or description["unconfirmed"]
    if is_noted(before, after):
        assert "unconfirmed" not in description


def reopen(kit, folder, before, after):
    """Return the reopened survey; None if nobody can say which survey it is."""
    try:
        return kit.processing.reopen_survey(folder.name)
    except SurveyRefusedError as error:
        assert tree(folder) == after, "a survey that is refused was changed"
        if data_of(before) == data_of(after):
            assert error.message.fault_code == "survey.complete"
            return None
        for name in ("survey.json", "log.jsonl", "survey.mcap"):
            assert after.get(name) != before[name], str(error)
        return None


def check(number, whole, place) -> None:
    rng = random.Random(f"{SEED} {number}")
    ending = rng.choice(list(STORED))
    folder = place / "data" / whole[ending].name
    shutil.copytree(str(whole[ending]), str(folder))
    before = tree(folder)
    damage(rng, folder)
    after = tree(folder)
    if ending != "finished" or data_of(after) != data_of(before):
        assert verify_survey(folder).status != COMPLETE
    kit = Kit(place / "data", open_recordings)
    try:
        reopened = reopen(kit, folder, before, after)
        if reopened is None:
            return
        check_reopened(folder, before, after, STORED[ending], reopened.stored_indices)
        kit.finish(TRACES, reopened.stored_indices)
    finally:
        kit.processing.shut_down()
    assert_whole(folder, TRACES)
    check_facts(folder, before, after)
    found = verify_survey(folder)
    assert found.status == COMPLETE or (not found.faults and found.unconfirmed), found.faults
    assert found.status == COMPLETE or not is_noted(before, after), found.unconfirmed


def check_reopened(folder, before, after, count, stored) -> None:
    for index in range(count):
        assert index in stored or not intact_forms(before, after, index)
    for path in (folder / "traces").iterdir():
        values = read_json(path)
        assert_same_numbers(TRACES[values["index"]], values)


def test_no_damage_loses_a_trace_or_makes_a_wrong_one(surveys, tmp_path):
    for number in range(DAMAGES):
        print(f"{number}: repeat with GPR20_SEED={SEED}")
        check(number, surveys, tmp_path / str(number))
        shutil.rmtree(str(tmp_path / str(number)))
