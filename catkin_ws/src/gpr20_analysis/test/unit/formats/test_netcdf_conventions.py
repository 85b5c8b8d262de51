"""The CF checker of IOOS finds nothing in NetCDF files, and xarray alone reads them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from random_surveys import random_survey
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.processing.delay import to_time

CHECKER = Path(sys.executable).parent / "compliance-checker"
needs_checker = pytest.mark.skipif(
    sys.version_info < (3, 9), reason="its versions for Python 3.8 do not know CF 1.9"
)
IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")


def checked(paths, folder):
    """Return the findings of the checker, by file.

    It is a process of its own: its NetCDF library and h5py bring different HDF5 libraries.
    """
    command = [str(CHECKER), "--test=cf:1.9"]
    command += ["--criteria=strict", "--format=json_new", f"--output={folder / 'found.json'}"]
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [*command, *map(str, paths)], check=False, capture_output=True, env=environment
    )
    assert (folder / "found.json").exists(), done.stderr.decode()
    found = json.loads((folder / "found.json").read_text())
    return {
        path: [one["msgs"] for key in ("high_priorities", "medium_priorities", "low_priorities")
               for one in report["cf:1.9"][key] if one["msgs"]]
        for path, report in found.items()
    }  # fmt: skip


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Return a file of each kind: survey, A-scans, image, survey with holes."""
    folder = tmp_path_factory.mktemp("files")
    survey = make_survey(folder, len(POINTS) - 3, "stopped")
    paths = [folder / name for name in ("survey.nc", "time.nc", "image.nc", "holes.nc")]
    main(["export", str(survey), str(paths[0]), "--format", "netcdf"])
    main(["process", str(survey), "--step", "time", "-o", str(paths[1])])
    arguments = [*IMAGE, "--leave-out-missing", "-o", str(paths[2])]
    main(["image", str(survey), *arguments])
    write_dataset(random_survey(5), paths[3])
    return paths


@needs_checker
def test_the_cf_checker_finds_nothing(files, tmp_path):
    found = checked(files, tmp_path)
    assert len(found) == len(files)
    assert not any(found.values()), found


@needs_checker
def test_the_checker_would_find_something(tmp_path):
    data = xr.Dataset({"depth": ("x", np.arange(3.0), {"units": "furlong"})})
    data.to_netcdf(tmp_path / "bad.nc", engine="h5netcdf")
    assert any(checked([tmp_path / "bad.nc"], tmp_path).values())


def test_xarray_reads_numbers_flags_and_times(tmp_path):
    survey = random_survey(3)
    survey.timestamp.values[:] = np.datetime64("2026-03-05T14:07:09.123456", "ns")
    write_dataset(survey, tmp_path / "s.nc")
    with xr.open_dataset(tmp_path / "s.nc", engine="h5netcdf") as found:
        own = found.s21_real.values + 1j * found.s21_imag.values
        np.testing.assert_array_equal(own, survey.s21.values)
        np.testing.assert_array_equal(found.timestamp.values, survey.timestamp.values)
        assert found.x.attrs["units"] == found.height.attrs["units"] == "m"
        assert found.s21_real.attrs["ancillary_variables"] == "quality height timestamp"
        masks = dict(
            zip(
                found.quality.attrs["flag_meanings"].split(),
                found.quality.attrs["flag_masks"].tolist(),
            )
        )
        assert masks["missing"] == int(Quality.MISSING)
        assert found.quality.attrs["flag_masks"].dtype == found.quality.dtype
        assert ("SIMULATED" in found.attrs["title"]) is bool(survey.attrs["simulated"])


def test_a_scans_and_images_keep_their_meaning(files):
    with xr.open_dataset(files[2], engine="h5netcdf") as image:
        assert image.depth.attrs["standard_name"] == "depth" and image.depth.attrs["axis"] == "Z"
        assert image.depth.attrs["positive"] == "down"
    in_time = to_time(random_survey(5))
    with xr.open_dataset(files[1], engine="h5netcdf") as found:
        assert found.delay.attrs["units"] == "s" == in_time.delay.attrs["units"]
