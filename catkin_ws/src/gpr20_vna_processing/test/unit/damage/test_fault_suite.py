"""The quick course of the fault suite, and that it finds what a broken storage does."""

import multiprocessing
import os
import sys
from dataclasses import replace

import pytest
from fault_suite import worker
from fault_suite.__main__ import main
from run_seed import SEED

from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_log import SurveyLog

LIMIT_S = 600.0
NOTHING_LOST, LOST = 0, 1


def suite(folder, *options):
    """Return the exit status, and the failures; in a process of its own, which may hide mounts."""
    arguments = ["--data", str(folder), "--seed", SEED, *options]
    process = multiprocessing.get_context("fork").Process(target=lambda: sys.exit(main(arguments)))
    process.start()
    process.join(LIMIT_S)
    return process.exitcode, "".join(one.read_text() for one in folder.glob("*/failures.txt"))


@pytest.mark.timeout(LIMIT_S)
@pytest.mark.parametrize("count", ["3", pytest.param("20", marks=pytest.mark.release)])
def test_nothing_is_lost_doubled_moved_or_laundered_by(count, tmp_path):
    assert suite(tmp_path, "--count", count) == (NOTHING_LOST, "")
    assert list(tmp_path.iterdir()) == []


def without_fsync(data, make=worker.new_storage):
    # The disk that fails knows what is durable by the function that is replaced.
    os.fsync = os.fdatasync = lambda _descriptor: None
    return make(data)


def with_other_numbers(data, make=worker.new_storage):
    kit = make(data)
    store = kit.processing.store
    kit.processing.store = lambda trace: store(replace(trace, s21_real=-trace.s21_real))
    return kit


def add_twice(log, record, add=SurveyLog.add):
    add(log, record)
    return add(log, log.next(Kind(record.kind), record.values, record.time))


@pytest.mark.timeout(LIMIT_S)
@pytest.mark.parametrize(
    ("module", "name", "broken", "options", "found"),
    [
        (worker, "new_storage", without_fsync, "calls --count 40", ["LOST"]),
        (worker, "new_storage", with_other_numbers, "calls --count 4", ["CHANGED", "LAUNDERED"]),
        (worker, "add_fact", lambda _processing, _fact: None, "kills --count 6", ["LOST"]),
        (SurveyLog, "add", add_twice, "calls --count 12", ["DOUBLED"]),
    ],
)
def test_a_planted_fault_is_found(module, name, broken, options, found, tmp_path, monkeypatch):
    monkeypatch.setattr(module, name, broken)
    status, failures = suite(tmp_path, "--only", *options.split())
    assert status == LOST
    assert all(one in failures for one in found)
