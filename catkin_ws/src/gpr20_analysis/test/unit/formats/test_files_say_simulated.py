"""Whatever simulated data are written to says that they are simulated."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.conversion import export_survey
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.read.load import load_survey

IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")


@pytest.fixture(scope="module")
def survey_folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("s"), len(POINTS), "finished",
                       more={"simulated": True})  # fmt: skip


@pytest.mark.parametrize(
    ("form", "name", "inside"),
    [
        ("netcdf", "o.nc", None),
        ("touchstone", "o", "*.s2p"),
        ("csv", "o.csv", None),
        ("segy", "o.sgy", None),
    ],
)
def test_simulated_survives_every_format(survey_folder, tmp_path, form, name, inside):
    survey = load_survey(survey_folder)
    written = export_survey(survey, tmp_path / name, form)
    for path in written:
        for one in sorted(path.glob(inside)) if inside else [path]:
            content = one.read_bytes() + one.name.encode()
            text = content[:3200].decode("cp500") if form == "segy" else content.decode("latin-1")
            assert "SIMULATED" in text or ",simulated," in text
            if form == "csv":
                assert text.splitlines()[1].split(",")[7] == "1"


def read_vtr(path):
    """Return the arrays of a VTK file by name, from its XML alone."""
    head, _, data = path.read_bytes().partition(b'<AppendedData encoding="raw">')
    data = data[data.index(b"_") + 1 :]
    root = ElementTree.fromstring(head + b"</VTKFile>")
    assert (root.get("type"), root.get("byte_order")) == ("RectilinearGrid", "LittleEndian")
    size_type = {"UInt32": "<u4", "UInt64": "<u8", None: "<u4"}[root.get("header_type")]
    found = {}
    for one in root.iter("DataArray"):
        start = int(one.get("offset"))
        (size,) = np.frombuffer(data, size_type, 1, start)
        start += np.dtype(size_type).itemsize
        kind = {"Float64": "<f8", "Float32": "<f4", "Int64": "<i8"}[one.get("type")]
        found[one.get("Name")] = np.frombuffer(data[start : start + int(size)], kind)
    return found


def test_vtk_files_hold_the_image_and_say_that_it_is_simulated(survey_folder, tmp_path):
    paths = [tmp_path / name for name in ("i.vtr", "i.nc")]
    outputs = [word for path in paths for word in ("-o", str(path))]
    assert main(["image", str(survey_folder), *IMAGE, *outputs]) == 0
    found, image = read_vtr(paths[0]), read_dataset(paths[1])
    own = np.abs(image.image.values[1])[::-1].reshape(-1)  # x fastest, z upwards
    np.testing.assert_array_equal(found["magnitude_90deg"], own)
    np.testing.assert_allclose(found["z_coordinates"], -image.depth.values[::-1], atol=1e-12)
    assert found["simulated"].tolist() == [1]
