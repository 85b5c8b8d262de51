import sys
from pathlib import Path

import pytest

# The example candidates of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey/test/unit"))

from imaging_kit import FakeAnalysis, FakeSticks


@pytest.fixture
def sticks(tmp_path):
    return FakeSticks(tmp_path / "media")


@pytest.fixture
def analysis(tmp_path):
    fake = FakeAnalysis(tmp_path)
    yield fake
    fake.process.close()
