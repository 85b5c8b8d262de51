"""A Zarr folder from elsewhere cannot run code when it is read."""

import json
import os
import pickle

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault

from gpr20_analysis import faults
from gpr20_analysis.formats.checksums import SUMS_FILE
from gpr20_analysis.formats.dataset_files import read_dataset, write_dataset
from gpr20_analysis.formats.zarr_codecs import refuse_unsafe_codecs


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
