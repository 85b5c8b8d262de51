"""NetCDF files keep the conventions, and a Zarr folder from elsewhere cannot run code."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault
from random_surveys import random_survey
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.checksums import SUMS_FILE
from gpr20_analysis.formats.dataset_files import read_dataset, write_dataset
from gpr20_analysis.formats.zarr_codecs import refuse_unsafe_codecs

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
        assert survey.attrs["survey_id"] in found.attrs["title"]


class Trap:
    """Makes a folder when it is unpickled."""

    def __init__(self, path):
        self._path = path

    def __reduce__(self):
        return os.mkdir, (str(self._path),)


@pytest.fixture
def trapped(tmp_path):
    """Return a Zarr folder with an array of pickled objects, and what appears if they are read."""
    path, trace = tmp_path / "s.zarr", tmp_path / "code_ran"
    write_dataset(xr.Dataset({"a": ("x", np.arange(3.0))}), path)
    # The author of such a folder leaves our checksum out.
    (path / SUMS_FILE).unlink()
    (path / ".zmetadata").unlink()
    place = path / "a" / ".zarray"
    array = json.loads(place.read_text())
    array.update(dtype="|O", compressor=None, filters=[{"id": "pickle", "protocol": 5}])
    place.write_text(json.dumps({**array, "fill_value": None}))
    (path / "a" / "0").write_bytes(pickle.dumps([Trap(trace), None, None]))
    return path, trace


def test_pickled_objects_are_refused_unread(trapped):
    path, trace = trapped
    with raises_fault(faults.FILE_CONTENT, "needs the codec 'pickle', which is not known"):
        read_dataset(path)
    assert not trace.exists()


def test_metadata_behind_a_link_are_checked_too(trapped, tmp_path):
    path, _trace = trapped
    linked = tmp_path / "linked.zarr"
    linked.mkdir()
    (linked / "a").symlink_to(path / "a", target_is_directory=True)
    with raises_fault(faults.FILE_CONTENT):
        refuse_unsafe_codecs(linked)


def test_a_codec_that_is_not_known_is_refused_wherever_it_is_named(tmp_path):
    for metadata in (
        {"codecs": [{"name": "numcodecs.pickle"}]},
        {"metadata": {"a/.zarray": {"filters": [{"id": "pickle"}]}}},
        {"codecs": [{"name": "sharding_indexed", "configuration": {"codecs": ["python"]}}]},
        {"compressor": {"id": "of somebody"}},
        {"compressor": {}},
    ):
        (tmp_path / "zarr.json").write_text(json.dumps(metadata))
        with raises_fault(faults.FILE_CONTENT):
            refuse_unsafe_codecs(tmp_path)


def test_a_folder_that_was_written_here_is_read(tmp_path):
    data = xr.Dataset({"a": ("x", np.arange(3.0)), "text": ("x", np.array(["a", "b", "ñ"]))})
    write_dataset(data, tmp_path / "s.zarr")
    assert read_dataset(tmp_path / "s.zarr").a.values.tolist() == [0.0, 1.0, 2.0]
