"""A command that is stopped in the midst of its work leaves nothing, and says so in one line."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

from gpr20_analysis.atomic_output import BESIDE
from gpr20_analysis.dataset import S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.formats.dataset_files import write_dataset

TIME_LIMIT_S = 120.0
STOPS = 100
COMMAND = "import sys; from gpr20_analysis.commands.main import main; sys.exit(main())"


@pytest.fixture(scope="module")
def survey_file(tmp_path_factory):
    """Return a survey that takes long to write file by file."""
    shape, points = (2, STOPS, STOPS), 51
    none = np.zeros(shape)
    survey = xr.Dataset(
        {
            "s21": (S21_DIMS, np.ones((*shape, points), complex)),
            "height": (SAMPLE_DIMS, none + 0.2),
            "quality": (SAMPLE_DIMS, none.astype(np.uint8)),
            "index": (SAMPLE_DIMS, np.arange(none.size).reshape(shape)),
            "timestamp": (SAMPLE_DIMS, np.full(shape, "NaT", "datetime64[ns]")),
            "sample_id": (SAMPLE_DIMS, np.full(shape, "a")),
        },
        {
            "polarization": [0.0, 90.0],
            "y": np.arange(STOPS) / 100.0,
            "x": np.arange(STOPS) / 100.0,
            "frequency": np.linspace(6e8, 6e9, points),
        },
    )
    path = tmp_path_factory.mktemp("survey") / "s.nc"
    write_dataset(survey, path)
    return path


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_is_interrupted_leaves_nothing_behind(survey_file, tmp_path, number):
    call = ["export", str(survey_file), str(tmp_path / "out"), "--format", "touchstone"]
    process = subprocess.Popen(
        [sys.executable, "-c", COMMAND, *call], stderr=subprocess.PIPE, text=True
    )
    try:
        end_s = time.monotonic() + TIME_LIMIT_S
        while not list(tmp_path.glob(f"{BESIDE}*/out/*.s2p")):
            assert process.poll() is None and time.monotonic() < end_s
            time.sleep(0.01)
        process.send_signal(number)
        _, error = process.communicate(timeout=TIME_LIMIT_S)
    finally:
        process.kill()
    assert process.returncode == 3
    assert error.splitlines()[-1] == "gpr20 export: interrupted; no partial output is left"
    assert "Traceback" not in error
    assert list(tmp_path.iterdir()) == []
