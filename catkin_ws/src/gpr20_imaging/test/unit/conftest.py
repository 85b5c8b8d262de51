import pytest
from imaging_kit import FakeCommand, FakeSticks


@pytest.fixture
def sticks(tmp_path):
    return FakeSticks(tmp_path / "media")


@pytest.fixture
def command(tmp_path):
    return FakeCommand(tmp_path)
