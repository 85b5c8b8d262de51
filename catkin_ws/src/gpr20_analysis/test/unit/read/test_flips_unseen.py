"""One changed byte anywhere in a survey's folder: what verify says covers what it has checked.

GPR20_SEED repeats those of a run.
"""

import json
import random
from contextlib import contextmanager

import pytest
from run_seed import SEED, draws
from survey_kit import POINTS, SURVEY, add_marker, make_survey, planned_trace

from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.read.verification_result import COMPLETE, DAMAGED, INCOMPLETE
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.folder import trace_files
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.markers import Marker, markers_of

FLIPS = draws(10)
SEALED = {"finished": len(POINTS), "stopped": 7, "interrupted": 7}
UNSEALED = {"cut off": 7, "not sealed": 7}


DURING = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae7", 110.0, 20.0, 80.0, "metal", "Ana")
AFTER = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae8", 15.0, 10.0)


def mark(processing):
    processing.add_marker("", DURING)
    processing.report(SURVEY, json.dumps({"complete": False}))


def stored(place, ending, count):
    outcome = {"cut off": None, "not sealed": "stopped"}.get(ending, ending)
    folder = make_survey(place, count, outcome, recorded=True, at_end=mark)
    if ending not in UNSEALED:
        add_marker(folder, AFTER, "2026-11-21T05:10:00.000000Z")
    if ending == "not sealed":
        (folder / "manifest.json").unlink()  # the power was cut before it was written
    return folder


@pytest.fixture(scope="module")
def surveys(tmp_path_factory):
    made = {
        ending: stored(tmp_path_factory.mktemp("survey"), ending, count)
        for ending, count in {**SEALED, **UNSEALED}.items()
    }
    for ending, folder in made.items():
        assert len(verify_survey(folder).faults) == (ending == "not sealed")
    return made


@contextmanager
def changed(surveys, endings, number):
    """Change one byte of one file, of every file with the same probability, until the end."""
    rng = random.Random(f"{SEED} {number}")
    ending = rng.choice(list(endings))
    folder = surveys[ending]
    kinds = [*(one for one in folder.iterdir() if one.is_file()), folder / "traces"]
    path = rng.choice(sorted(kinds))
    if path.is_dir():
        path = rng.choice(sorted(path.iterdir()))
    whole = path.read_bytes()
    content = bytearray(whole)
    place = rng.randrange(len(content))
    content[place] ^= rng.choice([1 << rng.randrange(8), rng.randrange(1, 256)])
    path.write_bytes(content)
    try:
        yield ending, folder, f"{ending}, {path.name} byte {place}, GPR20_SEED={SEED}"
    finally:
        path.write_bytes(whole)


def test_no_byte_of_a_sealed_survey_is_changed_unseen(surveys):
    for number in range(FLIPS):
        with changed(surveys, SEALED, number) as (_ending, folder, where):
            found = verify_survey(folder)
            assert found.status == DAMAGED, where
            assert "intact" not in str(found.verdict), where


def test_an_unsealed_survey_is_never_called_intact(surveys):
    for number in range(FLIPS):
        with changed(surveys, UNSEALED, number) as (ending, folder, where):
            found = verify_survey(folder)
            unseen = not found.faults or (
                ending == "not sealed"
                and all("manifest.json is missing" in str(one) for one in found.faults)
            )
            assert found.status != COMPLETE, where
            assert "intact" not in str(found.verdict), where
            if found.status == INCOMPLETE:
                assert "without a manifest, changes to" in str(found.verdict), where
            if unseen:
                assert_traces_are_those_stored(folder, where)
                (marker,) = markers_of(read_description(folder))
                assert marker.same_request(DURING), where


def assert_traces_are_those_stored(folder, where):
    for path in (folder / "traces").iterdir():
        try:
            trace = trace_files.read_trace(path, SURVEY)
        except TraceRefusedError:
            pytest.fail(f"{where}: {path.name} is damaged and passes")
        assert trace.fingerprint() == planned_trace(trace.index).fingerprint(), where
