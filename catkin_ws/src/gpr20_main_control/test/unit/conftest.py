"""A main control over a fake robot, which ends what the test left running."""

import contextlib
import sys
from pathlib import Path

import pytest

# The examples of surveys, and a graph without a master.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey/test/unit"))
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20/test/unit"))

from fake_robot import LIMIT_S, Bench


@pytest.fixture
def make_bench():
    """Return what makes benches, which end with the test."""
    with contextlib.ExitStack() as ending:

        def make(**given):
            bench = Bench(**given)
            ending.callback(bench.control.shut_down, LIMIT_S)
            ending.callback(bench.release)
            return bench

        yield make


@pytest.fixture
def bench(make_bench):
    return make_bench()
