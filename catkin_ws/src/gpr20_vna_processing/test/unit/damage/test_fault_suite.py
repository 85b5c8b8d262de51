"""The short form of the fault suite; docs/evidence/reliability.md has figures of the long one."""

import json
import os
import random
import subprocess
import sys

import pytest
from fault_suite.facts import Facts, Fault, Found
from fault_suite.script import TRACES, Call, Step, new_marker
from run_seed import SEED

from gpr20_survey.trace import trace_json

LIMIT_S = 600.0
NOTHING_LOST, LOST, NOT_POSSIBLE = 0, 1, 77
WRONG = ("lost", "doubled", "wrong", "laundered", "unseen", "stuck")
KINDS = ("--kills", "--power-cuts", "--faults", "--torn", "--flips", "--writers")


def suite(tmp_path, *options):
    """Return the exit status of the suite and its results."""
    output = tmp_path / "results"
    command = [sys.executable, "-m", "fault_suite", "--data", str(tmp_path), "--seed", SEED]
    ended = subprocess.run(
        [*command, "--json", str(output), *map(str, options)],
        timeout=LIMIT_S,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    if ended.returncode == NOT_POSSIBLE:
        pytest.skip(json.loads(output.read_text())["remark"])
    return ended.returncode, [json.loads(line) for line in output.read_text().splitlines()]


@pytest.mark.timeout(LIMIT_S)
@pytest.mark.parametrize(
    "counts",
    [(1, 1, 3, 3, 8, 1), pytest.param((8, 8, 12, 12, 32, 3), marks=pytest.mark.release)],
)
def test_nothing_acknowledged_is_lost_doubled_changed_or_laundered_by(counts, tmp_path):
    asked = [one for pair in zip(KINDS, counts) for one in pair]
    status, results = suite(tmp_path, *asked)
    assert status == NOTHING_LOST
    assert len(results) == len(KINDS)
    for count, result in zip(counts, results):
        if "remark" in result and not result["times"]:
            continue  # as a power cut without root
        assert result["times"] >= count
        assert sum(result["acknowledged"].values()) >= count
        assert not any(result["found"].get(name) for name in WRONG)
    assert list(tmp_path.iterdir()) == [tmp_path / "results"]


@pytest.mark.timeout(LIMIT_S)
@pytest.mark.parametrize(
    ("broken", "option", "count"),
    [
        ("no-markers", "--kills", 2),
        pytest.param("no-fsync", "--power-cuts", 8, marks=pytest.mark.release),
        pytest.param("no-fsync", "--torn", 8, marks=pytest.mark.release),
    ],
)
def test_the_suite_finds_what_a_broken_storage_loses(broken, option, count, tmp_path):
    status, (result,) = suite(tmp_path, option, str(count), "--broken", broken)
    assert status == LOST
    assert result["found"]["lost"] > 0


def test_the_evidence_finds_each_kind_of_difference():
    facts, marker = Facts(), new_marker(random.Random(1))
    for step in (Step(Call.STORE, 0), Step(Call.MARK, marker)):
        facts.ask(step)
        facts.acknowledge(step)
    trace = json.loads(trace_json.encode(TRACES[0]))
    made = {**marker, "time": "2026-11-21T05:10:00.000000Z"}
    removed = {**made, "removed": "2026-11-21T05:11:00.000000Z"}
    for traces, markers, fault in (
        ([trace], [made], None),
        ([], [made], Fault.LOST),
        ([trace, trace], [made], Fault.DOUBLED),
        ([{**trace, "x_coord_mm": 11.0}], [made], Fault.WRONG),
        ([trace], [], Fault.LOST),
        ([trace], [removed], Fault.LOST),
        ([trace], [made, made], Fault.DOUBLED),
        ([trace], [made, new_marker(random.Random(2))], Fault.WRONG),
    ):
        found = Found({"JSON": traces}, markers=markers)
        differences = {one.fault for one in facts.differences(found, every_trace=False)}
        assert differences == ({fault} if fault else set())
