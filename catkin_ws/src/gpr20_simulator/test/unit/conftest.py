"""What several test files of this package use."""

import pytest
from vna_bench import Bench


@pytest.fixture
def bench():
    one = Bench()
    yield one
    one.stop()
