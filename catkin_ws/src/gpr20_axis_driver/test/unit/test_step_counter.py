"""The step count in its file."""

import errno
import mmap
from types import SimpleNamespace
from unittest import mock

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_axis_driver.faults import AxisException
from gpr20_axis_driver.low import step_counter
from gpr20_axis_driver.low.step_counter import FILE_BYTES, open_step_counter
from gpr20_common.faults import CONFIGURATION, DISK_FULL, OTHER_LAUNCH
from gpr20_survey.axes import ZeroEpoch
from gpr20_survey.faults import ZERO_UNKNOWN


@pytest.fixture
def path(tmp_path):
    return tmp_path / "folder" / "z_axis"


# The words that are used.
USED_BYTES = 80


def reopen(path, step_size=1.8):
    return open_step_counter(path, step_size, lock_limit_s=0.0)


def test_count_and_zero_of_a_resting_motor_are_there_again_for_steps_of_the_same_size(path):
    for number, steps in enumerate((0, 50, -50, 2**40), 1):
        memory, time_us = reopen(path), 1_790_000_000_000_000 + number
        memory.begin_zero(time_us)
        # A power cut here leaves a count that nobody trusts.
        assert not memory.trusted
        memory.place(steps)
        memory.close()
        again = reopen(path)
        assert (again.steps, again.trusted) == (steps, True)
        assert again.zero == ZeroEpoch(number, time_us)
        again.close()
    assert not reopen(path, step_size=0.9).trusted


def test_a_motor_that_was_turning_is_not_trusted_until_it_is_placed(path):
    memory = reopen(path)
    assert not memory.trusted
    memory.place(0)
    memory.begin()
    memory.count(-7)
    memory.close()
    again = reopen(path)
    assert not again.trusted
    again.begin()
    again.rest()
    assert (again.steps, again.trusted) == (-7, False)
    again.place(-7)
    again.begin()
    again.count(2)
    again.rest()
    assert (again.steps, again.trusted) == (-5, True)


def test_two_processes_cannot_drive_one_axis(path):
    memory = reopen(path)
    with raises_fault(OTHER_LAUNCH, path, error=AxisException):
        reopen(path)
    memory.close()
    reopen(path)


@each_case("content", [b"", b"\0" * FILE_BYTES, b"x" * 10, b"x" * 4096])
def test_a_file_that_is_something_else_is_refused_and_left_alone(path, content):
    path.parent.mkdir(exist_ok=True)
    path = path.with_name(f"{len(content)} bytes")
    path.write_bytes(content)
    with raises_fault(ZERO_UNKNOWN, path, error=AxisException):
        reopen(path)
    assert path.read_bytes() == content


@each_case("error, fault", [(errno.ENOTDIR, CONFIGURATION), (errno.ENOSPC, DISK_FULL)])
def test_a_place_that_cannot_be_written_is_an_error_that_names_it(path, error, fault):
    refused = mock.patch.object(step_counter.os, "open", side_effect=OSError(error, "refused"))
    with refused, raises_fault(fault, path, error=AxisException):
        reopen(path)


@settings(max_examples=draws(6))
@given(st.integers(-(10**6), 10**6), st.integers(-(10**6), 10**6))
def test_a_count_torn_by_a_power_cut_is_never_trusted(tmp_path_factory, before, after):
    path = tmp_path_factory.mktemp("memory") / "z"
    memory = reopen(path)
    memory.place(before)
    old = path.read_bytes()
    memory.place(after)
    new = path.read_bytes()
    memory.close()
    for cut in range(0, USED_BYTES + 1, 8):
        for torn in (old[:cut] + new[cut:], new[:cut] + old[cut:]):
            path.write_bytes(torn)
            again = reopen(path)
            assert not again.trusted or again.steps in (before, after)
            again.close()


def test_what_is_begun_is_on_the_disk_before_the_first_step(path, monkeypatch):
    memory, flushed = reopen(path), []
    memory.place(3)
    assert mmap.PAGESIZE >= FILE_BYTES
    flush = SimpleNamespace(flush=lambda: flushed.append((memory.steps, memory.trusted)))
    monkeypatch.setattr(memory, "_memory", flush)
    memory.begin()
    memory.count(1)
    memory.rest()
    assert flushed == [(3, False), (4, True)]
