import sys
from pathlib import Path

import pytest
from fake_clock import FakeClock

# The example annotations of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey" / "test" / "unit"))


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()
