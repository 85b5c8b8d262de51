"""A main control over a fake robot, which ends what the test left running."""

import sys
from pathlib import Path

import pytest

# The examples of surveys, and a graph without a master.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey/test/unit"))
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20/test/unit"))

from fake_robot import LIMIT_S, Bench


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.release()
    bench.control.shut_down(LIMIT_S)
