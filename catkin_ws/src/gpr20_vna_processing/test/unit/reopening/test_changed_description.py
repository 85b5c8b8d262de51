"""Every key of survey.json changed in turn: it is noticed, and the log corrects it.

GPR20_DAMAGES sets how many random bits are flipped, and that every key is changed with every way
in which a survey ends; GPR20_SEED repeats those of a run.
"""

from __future__ import annotations

import copy
import itertools
import json
import os
import random
import shutil

import pytest
from annotation_examples import EXAMPLE
from log_examples import marker
from planned_survey import METADATA, POINTS, planned_trace
from reopening_kit import assert_whole
from run_seed import SEED
from storage_kit import OTHER_SURVEY, Kit, text_message
from trace_examples import SURVEY

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE, DAMAGED
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_metadata
from gpr20_survey.folder.description_differences import differences
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.recording.recordings import open_recordings

FLIPS = int(os.environ.get("GPR20_DAMAGES", "20"))
EVERY_ENDING = "GPR20_DAMAGES" in os.environ
TRACES = [planned_trace(index) for index in range(len(POINTS))]
STORED = {"finished": len(POINTS), "stopped": 6, "interrupted": 6, "cut off": 6}
INSTRUMENT = {"identity": "Anritsu,MS2026C,SIMULATED,1.0", "calibration_status": 1}
NODES = [{"name": "/x_axis/axis_driver", "simulated": True, "hardware": "pins"}]
DESCRIBED = json.dumps({**json.loads(METADATA), "instrument": INSTRUMENT, "nodes": NODES})
REPORT = {"verdict": "6 of 9", "coverage": "mmmmmm---", "failed": [], "controls": []}


@pytest.fixture(scope="module")
def surveys(tmp_path_factory):
    """A survey for each way in which one ends; the first two were resumed once."""
    made = {}
    for ending, count in STORED.items():
        place = tmp_path_factory.mktemp("whole")
        kit = Kit(place / "open", open_recordings)
        folder = kit.open(metadata_json=DESCRIBED)
        kit.processing.report(SURVEY, json.dumps(REPORT))
        kit.processing.add_marker(SURVEY, marker(1))
        kit.processing.annotate(SURVEY, EXAMPLE)
        for trace in TRACES[:count]:
            kit.processing.record(text_message("/control_status", f"measuring {trace.index}"))
            kit.processing.store(trace)
            if trace.index == 3:
                kit.processing.close_survey(SURVEY, "stopped")
                kit.processing.reopen_survey(SURVEY)
        if ending == "interrupted":
            kit.processing.interrupt_other(OTHER_SURVEY)
        elif ending != "cut off":
            kit.processing.close_survey(SURVEY, ending)
        shutil.copytree(str(place / "open"), str(place / "data"))
        kit.processing.shut_down()
        made[ending] = place / "data" / folder.name
    return made


def places(value, place=()):
    """Yield the path of every entry, nested ones too."""
    if place:
        yield place
    if isinstance(value, (dict, list)):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from places(inner, (*place, key))


def similar(value):
    """Return another value of the same type."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, (int, float)):
        return value + type(value)(1)
    if isinstance(value, str):
        return value[:-1] + chr(ord(value[-1]) ^ 1) if value else "x"
    return type(value)() if value else ({"a": 1} if isinstance(value, dict) else [1])


def unlike(value):
    """Return a value of another type."""
    return 7 if value is None or isinstance(value, (str, dict, list)) else str(value)


def changed(description, place, change):
    values = copy.deepcopy(description)
    inner = values
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = change(inner[place[-1]]) if inner[place[-1]] is not None else 7
    return values


def resume_and_finish(folder):
    """Return whether the survey could be resumed; then its plan and its traces are the former."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    kit = Kit(folder.parent, open_recordings)
    try:
        try:
            reopened = kit.processing.reopen_survey(folder.name)
        except SurveyRefusedError as error:
            after = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
            assert before == after
            return str(error)
        kit.finish(TRACES, reopened.stored_indices)
    finally:
        kit.processing.shut_down()
    return reopened


def check(whole, folder, content, ending):
    """Put other content into survey.json: verify notices it, and no other plan is finished."""
    shutil.rmtree(str(folder.parent), ignore_errors=True)
    shutil.copytree(str(whole), str(folder))
    original = json.loads((folder / "survey.json").read_text())
    (folder / "survey.json").write_bytes(content)
    found = verify_survey(folder)
    assert found.status == DAMAGED
    assert "survey.json" in " ".join(map(str, found.faults))
    resumed = resume_and_finish(folder)
    assert not isinstance(resumed, str), resumed
    assert "survey.json" in " ".join(map(str, resumed.repairs))
    kept = [path.read_bytes() for path in (folder / "damaged").glob("survey.json*")]
    assert content in kept
    final = read_description(folder)
    assert differences(final, original) == []
    assert (final["report"], final["markers"]) == (original["report"], original["markers"])
    assert final["annotation"] == original["annotation"]
    assert_whole(folder, TRACES)
    assert verify_survey(folder).status == COMPLETE, verify_survey(folder).faults


def test_no_key_can_be_changed_unseen(surveys, tmp_path):
    print(f"repeat with GPR20_SEED={SEED}")
    rng = random.Random(SEED)
    for ending, whole in surveys.items():
        original = json.loads((whole / "survey.json").read_text())
        for place, change in itertools.product(places(original), (similar, unlike)):
            values = changed(original, place, change)
            # In the suite about every key with one change and ending, by hand with all of them.
            if values != original and (EVERY_ENDING or rng.randrange(2 * len(surveys)) == 0):
                content = survey_metadata.encode(values)
                check(whole, tmp_path / "data" / whole.name, content, ending)


def test_no_bit_can_be_flipped_unseen(surveys, tmp_path):
    for number in range(FLIPS):
        print(f"{number}: repeat with GPR20_SEED={SEED}")
        rng = random.Random(f"{SEED} {number}")
        ending = rng.choice(list(STORED))
        content = bytearray((surveys[ending] / "survey.json").read_bytes())
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
        check(surveys[ending], tmp_path / "data" / surveys[ending].name, bytes(content), ending)
