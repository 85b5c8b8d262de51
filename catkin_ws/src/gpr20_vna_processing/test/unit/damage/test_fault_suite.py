"""The quick course of the fault suite, and that it finds what a broken storage does."""

import multiprocessing
import os
import sys

import pytest
from fault_suite import worker
from fault_suite.__main__ import main
from run_seed import SEED

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


@pytest.mark.timeout(LIMIT_S)
def test_a_storage_that_answers_before_fsync_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(worker, "new_storage", without_fsync)
    status, failures = suite(tmp_path, "--only", "calls", "--count", "40")
    assert status == LOST and "LOST" in failures
