"""Whole files of a survey in place of others: each is right by itself, and nothing is lost unseen.

An older copy, the file of a copy that had another later history, or one that somebody made.
"""

from __future__ import annotations

import shutil
from dataclasses import replace

import pytest
from log_examples import NOW, add_marker, marker
from planned_survey import METADATA, POINTS, planned_trace
from storage_kit import Kit
from trace_examples import SURVEY

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import DAMAGED
from gpr20_survey.folder import trace_files
from gpr20_survey.folder.annotating import add_to_survey
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.markers import markers_of
from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.trace import trace_json

LOG, VIEW, SEAL = "log.jsonl", "survey.json", "manifest.json"
TRACES = [planned_trace(index) for index in range(len(POINTS))]


def make(place, outcome):
    """Make a survey with marker 1; return it and a copy from before marker 2 was added."""
    kit = Kit(place / "open", open_recordings)
    folder = kit.open(metadata_json=METADATA)
    kit.processing.add_marker(SURVEY, marker(1))
    stored = len(TRACES) if outcome == "finished" else 6
    for trace in TRACES[:stored]:
        kit.processing.store(trace)
    if outcome is not None:
        kit.processing.close_survey(SURVEY, outcome)
    shutil.copytree(str(folder), str(place / "older"))
    kit.processing.add_marker(SURVEY, marker(2))
    if outcome is None:
        kit.processing.store(TRACES[stored])  # makes the MCAP's record durable
    shutil.copytree(str(place / "open"), str(place / "data"))
    kit.processing.shut_down()
    return place / "data" / folder.name, place / "older"


@pytest.fixture(params=["finished", "stopped", None])
def survey(request, tmp_path):
    return (request.param, *make(tmp_path, request.param))


def put_back(older, folder, *names):
    for name in names:
        shutil.copy(str(older / name), str(folder / name))


def resume(folder):
    kit = Kit(folder.parent, open_recordings)
    try:
        kit.finish(TRACES, kit.processing.reopen_survey(SURVEY).stored_indices)
    finally:
        kit.processing.shut_down()


def noted(folder):
    return {one.text for one in markers_of(read_description(folder))}


def texts(*numbers):
    return {marker(number).text for number in numbers}


def test_older_copies_of_both_forms_lose_no_marker_unseen(survey):
    outcome, folder, older = survey
    put_back(older, folder, LOG, VIEW)
    resume(folder)
    # In a survey that was cut off, the MCAP has the marker.
    assert noted(folder) == (texts(1, 2) if outcome is None else texts(1))
    assert bool(verify_survey(folder).unconfirmed) == (outcome is not None)


def test_an_older_manifest_is_named_and_the_survey_can_be_resumed(survey):
    outcome, folder, older = survey
    if outcome is None:
        return  # it has none
    put_back(older, folder, SEAL)
    assert verify_survey(folder).status == DAMAGED
    resume(folder)
    found = verify_survey(folder)
    assert (found.faults, found.unconfirmed) == ([], ("log",))
    assert noted(folder) == texts(1, 2)


def test_an_older_log_beside_a_survey_json_that_is_no_json_loses_nothing(survey):
    _outcome, folder, older = survey
    put_back(older, folder, LOG)
    (folder / SEAL).unlink(missing_ok=True)
    content = (folder / VIEW).read_bytes()
    place = content.index(b'"survey_id"')
    (folder / VIEW).write_bytes(content[:place] + b"&" + content[place + 1 :])
    resume(folder)
    assert noted(folder) == texts(1, 2)
    assert verify_survey(folder).faults == []


def test_the_log_of_another_history_replaces_nothing_unseen(survey, tmp_path):
    outcome, folder, older = survey
    other = tmp_path / "other" / folder.name
    shutil.copytree(str(older), str(other))
    add_to_survey(other, add_marker(3), NOW)
    put_back(other, folder, LOG)
    assert verify_survey(folder).status == DAMAGED
    resume(folder)
    found = verify_survey(folder)
    # The manifest, or the MCAP of a survey that was cut off, names marker 2.
    assert noted(folder) == texts(1, 2), outcome
    (named,) = found.unconfirmed
    (kept,) = read_description(folder)["unconfirmed"][named]["found"]
    assert marker(3).marker_id in kept


def test_another_trace_with_a_right_checksum_is_kept_and_named(tmp_path):
    folder, _older = make(tmp_path, None)
    path = sorted((folder / "traces").iterdir())[2]
    trace = trace_files.read_trace(path, SURVEY)
    path.write_bytes(trace_json.encode(replace(trace, antennae_height_m=0.7)))
    assert verify_survey(folder).status == DAMAGED
    resume(folder)
    assert verify_survey(folder).unconfirmed == (f"traces/{path.name}",)
    assert (folder / "damaged/survey.mcap").is_file()
