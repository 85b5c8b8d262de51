import sys
from pathlib import Path

import pytest

# The example candidates of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey/test/unit"))

from imaging_kit import FakeAnalysis, FakeSticks

from gpr20_imaging.low.worker_process import WorkerProcess


@pytest.fixture
def sticks(tmp_path):
    return FakeSticks(tmp_path)


@pytest.fixture
def analysis(tmp_path, sticks):
    return FakeAnalysis(tmp_path)


@pytest.fixture
def worker(tmp_path, analysis):
    """The worker process with the fake analysis and the fake sticks."""
    process = WorkerProcess(analysis.command)
    yield process
    process.close()
