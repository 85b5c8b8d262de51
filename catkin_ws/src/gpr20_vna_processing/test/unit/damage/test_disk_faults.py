"""Disks that are full, read-only or slow: nothing lost, nothing half, and a message."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import threading
import time

import pytest
from fault_kit import raises_fault
from reopening_kit import messages_in_mcap, traces_in_bag
from storage_kit import Kit, wait_until
from trace_examples import SURVEY, assert_same_numbers, make_trace, read_json

from gpr20_survey.errors import StorageFailedError
from gpr20_survey.files.durable_files import is_temporary
from gpr20_survey.recording.recordings import open_recordings
from gpr20_vna_processing.mid.processing_records import Limits

LIMITS = Limits(timeout_s=20.0, period_s=0.05, disk_reserve_bytes=0)


@pytest.fixture
def small_disk(tmp_path):
    """A file system of one megabyte."""
    place = tmp_path / "disk"
    place.mkdir()
    options = ["-t", "tmpfs", "-o", "size=1m,nr_inodes=400"]
    subprocess.run(["mount", *options, "gpr20-test", str(place)], check=True)
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


def kit_on(place) -> Kit:
    return Kit(place / "data", open_recordings, limits=LIMITS)


def fill_until_refused(kit: Kit) -> int:
    """Store until the disk refuses; return the index that was not stored."""
    for index in range(10_000):
        try:
            kit.processing.store(make_trace(index))
        except StorageFailedError as error:
            assert error.message.fault_code in ("disk.full", "disk.refuses")
            return index
    raise AssertionError("the disk takes everything")


def filled_by_killed_process(place) -> int:
    """Fill a disk in a process that is then killed; return the index that was not stored."""
    context = multiprocessing.get_context("fork")
    answers = context.SimpleQueue()

    def fill() -> None:
        kit = kit_on(place)
        kit.open()
        (place / "ballast").write_bytes(b"\0" * 500_000)
        answers.put(fill_until_refused(kit))
        threading.Event().wait()

    child = context.Process(target=fill, daemon=True)
    child.start()
    refused = answers.get()
    child.kill()
    child.join()
    return refused


def assert_stored(folder, count: int) -> None:
    files = sorted((folder / "traces").iterdir())
    assert len(files) == count
    # The trace that was refused last may be in its file only, and is then added with its own time.
    bag, mcap = (
        sorted(found, key=lambda one: one.index)
        for found in (traces_in_bag(folder), messages_in_mcap(folder))
    )
    assert len(bag) == len(mcap) == count
    for index, found in enumerate(zip(map(read_json, files), bag, mcap)):
        for values in found:
            assert_same_numbers(make_trace(index), values)


@pytest.mark.needs("mounts")
def test_a_survey_goes_on_after_space_was_made_on_a_full_disk(small_disk):
    kit = kit_on(small_disk)
    folder = kit.open()
    ballast = small_disk / "ballast"
    ballast.write_bytes(b"\0" * 500_000)
    refused = fill_until_refused(kit)
    assert refused > 10
    for _ in range(3):
        with raises_fault("disk.full", error=StorageFailedError):
            kit.processing.store(make_trace(refused))
    assert [trace.index for trace in kit.stored] == list(range(refused))
    # Data are only whole files; at most the refused trace is beyond what was acknowledged.
    for path in (folder / "traces").iterdir():
        assert not is_temporary(path.name)
        assert read_json(path)["index"] <= refused
    ballast.unlink()
    for index in range(refused, refused + 10):
        kit.processing.store(make_trace(index))
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    assert_stored(folder, refused + 10)


@pytest.mark.needs("mounts")
def test_a_survey_on_a_full_disk_is_reopened_after_a_kill(small_disk):
    refused = filled_by_killed_process(small_disk)
    later = kit_on(small_disk)
    folder = next((small_disk / "data").iterdir())
    with raises_fault("disk.full", error=StorageFailedError):
        later.processing.reopen_survey(SURVEY)
    (small_disk / "ballast").unlink()
    reopened = later.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices[:refused] == tuple(range(refused))
    for index in range(len(reopened.stored_indices), refused + 5):
        later.processing.store(make_trace(index))
    later.processing.close_survey(SURVEY, "finished")
    later.processing.shut_down()
    assert_stored(folder, refused + 5)


@pytest.mark.needs("mounts")
def test_a_disk_that_became_read_only_is_told_and_the_survey_goes_on_when_it_is_not(small_disk):
    kit = kit_on(small_disk)
    folder = kit.open()
    for index in range(3):
        kit.processing.store(make_trace(index))

    def remount(mode: str) -> None:
        # By force: the recordings are open for writing, as they are when a disk fails.
        subprocess.run(
            ["mount", "-o", f"remount,{mode}", str(small_disk)], check=True, capture_output=True
        )

    kit.processing.close_survey(SURVEY, "stopped")
    remount("ro")
    try:
        with raises_fault("disk.refuses", error=StorageFailedError):
            kit.processing.reopen_survey(SURVEY)
    finally:
        remount("rw")
    assert kit.processing.reopen_survey(SURVEY).stored_indices == (0, 1, 2)
    kit.processing.store(make_trace(3))
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    assert_stored(folder, 4)


def test_a_slow_disk_makes_the_callers_wait_and_loses_nothing(tmp_path, monkeypatch):
    kit = kit_on(tmp_path)
    folder = kit.open()
    real_fsync = os.fsync

    def slow(descriptor):
        time.sleep(0.01)  # this is the slow disk, not a wait for something
        real_fsync(descriptor)

    monkeypatch.setattr(os, "fsync", slow)
    callers = [
        threading.Thread(target=kit.processing.store, args=(make_trace(index),))
        for index in range(12)
    ]
    for caller in callers:
        caller.start()
    waiting = []
    wait_until(
        lambda: waiting.append(kit.processing.state().queues.jobs) or len(kit.stored) == 12, 20.0
    )
    for caller in callers:
        caller.join(10.0)
    assert max(waiting) <= LIMITS.queues.jobs
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    by_index = sorted(map(read_json, (folder / "traces").iterdir()), key=lambda one: one["index"])
    for index, values in enumerate(by_index):
        assert_same_numbers(make_trace(index), values)
    assert len(by_index) == len(traces_in_bag(folder)) == len(messages_in_mcap(folder)) == 12
