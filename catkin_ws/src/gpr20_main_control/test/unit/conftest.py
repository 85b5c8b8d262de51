"""A control over a fake robot, which ends whatever the test left behind."""

import pytest
from fake_robot import LIMIT_S, Bench


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.release()
    bench.control.shut_down(LIMIT_S)
