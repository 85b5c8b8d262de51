import sys
from pathlib import Path

import pytest

# The example candidates of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey/test/unit"))

from imaging_kit import FakeCommand, FakeSticks


@pytest.fixture
def sticks(tmp_path):
    return FakeSticks(tmp_path / "media")


@pytest.fixture
def command(tmp_path):
    return FakeCommand(tmp_path)
