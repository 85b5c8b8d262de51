"""Makes the example traces of gpr20_survey's tests available to these, and a storage."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey" / "test" / "unit"))

from storage_kit import Kit

from gpr20_survey.recording.recordings import open_recordings


@pytest.fixture
def kit(tmp_path):
    """Yield a storage over an empty folder, with a bag and an MCAP."""
    kit = Kit(tmp_path / "data", open_recordings)
    yield kit
    kit.processing.shut_down()
