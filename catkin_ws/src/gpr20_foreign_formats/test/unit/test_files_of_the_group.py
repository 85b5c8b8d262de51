"""Files of the group are recognized, written as theirs, and refused when they are damaged."""

import ast
import json

import h5py
import numpy as np
import pandas as pd
import pytest
from fault_kit import raises_fault
from foreign_formats_kit import PACKAGE, added
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.entry_points import additions
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.conversion import EXPORTS, export_survey
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.formats.format import IMAGE_FORMATS, IMPORTS
from gpr20_analysis.imaging.methods import METHODS
from gpr20_analysis.read.load import load_survey
from gpr20_foreign_formats import group_csv, merged_hdf5
from gpr20_foreign_formats.migrated_hdf5 import read_migrated

ALL = len(POINTS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    more = {"simulated": True}
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished", more=more)


@pytest.fixture(scope="module")
def survey(folder):
    return load_survey(folder)


def test_files_of_the_group_have_its_names_and_header(survey, tmp_path):
    group_csv.write_group_csv(survey, tmp_path / "csv")
    path = tmp_path / "csv" / "VNA_SIMULATED_X15_Y20_OrY_Fs600M_Fe6000M_Qf5_H300.csv"
    table = pd.read_csv(path, usecols=["S21_real", "S21_imag"], float_precision="round_trip")
    own = survey.s21.sel(polarization=90.0, x=0.015, y=0.02).values
    np.testing.assert_array_equal(table.S21_real.values + 1j * table.S21_imag.values, own)


def test_the_merged_file_is_laid_out_as_the_group_reads_it(survey, tmp_path):
    merged_hdf5.write_merged(survey, tmp_path / "m.h5", "title")
    with h5py.File(tmp_path / "m.h5", "r") as file:
        assert file.attrs["Total Amount of A-Scans"] == ALL
        assert dict(file["Frequency"].attrs) == {"f0": 6e8, "ff": 6e9, "df": 1.35e9, "q": 5}
        assert file["Position"].attrs["dx"] == pytest.approx(0.005)
        scans = file["A-Scan/Re{S21 x-pol}"]
        assert (scans.dtype, scans.compression_opts) == (np.float32, 4)
        # The second scan is the one next along y: their names sort by x first.
        own = survey.s21.sel(polarization=0.0, x=0.01, y=0.015).values
        np.testing.assert_array_equal(scans[1], own.real.astype(np.float32))


def test_samples_of_the_original_project_keep_its_keys(folder, tmp_path):
    export_survey(load_survey(folder), tmp_path / "o", "original-json")
    sample = json.loads((tmp_path / "o" / "X010.00_Y010.00_Z000.00.json").read_text())
    assert set(sample) == {
        "x_coord", "y_coord", "z_coord", "antennae_height", "timestamp", "survey_id", "sample_id",
        "data", "simulated",
    }  # fmt: skip
    assert set(sample["data"][0]) == {"freq_value", "real_value", "imaginary_value"}


def test_heights_that_are_not_known_cannot_be_said_in_the_groups_names(survey, tmp_path):
    with raises_fault(faults.INPUT):
        group_csv.write_group_csv(survey.assign(height=survey.height * np.nan), tmp_path / "c")


def test_files_of_the_group_with_mixed_sweeps_are_refused(survey, tmp_path):
    group_csv.write_group_csv(survey, tmp_path)
    group_csv.write_group_csv(survey.isel(frequency=slice(0, 3)), tmp_path)
    with raises_fault(faults.INPUT) as caught:
        group_csv.read_group_csv(tmp_path)
    assert "sweeps" in caught.value.message.values


@pytest.mark.parametrize(
    "damage",
    [
        lambda file: file["Frequency"].attrs.update(df=1e6),
        lambda file: file["Position"].attrs.update(dx=0.004),
        lambda file: file["A-Scan"].pop("Im{S21 x-pol}"),
        lambda file: file["Position/h x-pol"].write_direct(np.full((9, 1), -0.2, np.float32)),
    ],
)
def test_a_merged_file_that_contradicts_itself_is_refused(survey, tmp_path, damage):
    path = tmp_path / "m.h5"
    merged_hdf5.write_merged(survey, path, "t")
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0x10
    path.write_bytes(content)
    with raises_fault(faults.FILE_DAMAGED):
        merged_hdf5.read_merged(path)
    content[len(content) // 2] ^= 0x10
    path.write_bytes(content[:-80])  # as the group's own files, which have no checksum
    with h5py.File(path, "r+") as file:
        damage(file)
    with raises_fault(faults.INPUT):
        merged_hdf5.read_merged(path)


IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")


def test_migrated_images_are_written_and_read_again(folder, tmp_path, capsys):
    command = ["image", str(folder), *IMAGE, "-o", str(tmp_path / "i.nc")]
    assert main(command) == 0
    image = read_dataset(tmp_path / "i.nc")
    for turn, name in enumerate(("i_000.h5", "i_090.h5")):
        part = image.isel(polarization=[turn])
        IMAGE_FORMATS.find("h5").write(part, tmp_path / name, name[:-3])
        own = np.abs(image.image.values[turn])
        with h5py.File(tmp_path / name, "r") as file:
            assert file.attrs["Title"] == f"{name[:-3]} (SIMULATED)"
            assert file.attrs["Relative permittivity"] == 4.0
            place, stored = file["Position"].attrs, file["MigratedImage/Image"]
            assert [place[f"q{axis}"] for axis in "xyz"] == [3, 3, 5]
            assert (place["zf"], place["h_ant_mig"]) == pytest.approx((0.02, 0.03))
            assert (stored.dtype, stored.compression) == (np.float32, "gzip")
            np.testing.assert_allclose(stored[()], own.transpose(2, 1, 0), rtol=1e-6)
        found = load_survey(tmp_path / name)
        for axis in ("x", "y", "depth"):
            np.testing.assert_allclose(found[axis].values, image[axis].values, atol=1e-12)
        np.testing.assert_allclose(found.image.values[0], own, rtol=1e-6)
        assert found.attrs["simulated"] == 1
    capsys.readouterr()
    path = tmp_path / "i_000.h5"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)
    with pytest.raises(UnreadableFileError):
        read_migrated(path)


def test_a_migrated_image_of_the_group_is_read_with_its_doubts(tmp_path):
    magnitude = np.random.default_rng(1).random((4, 3, 5)).astype("f4")
    path = tmp_path / "migration_er2.58.h5"
    with h5py.File(path, "w") as file:
        file.attrs["Title"], file.attrs["Relative permittivity"] = "migration", 2.58
        place = file.create_group("/Position")
        for name, value in zip(
            ("x0", "y0", "z0", "xf", "yf", "zf", "qx", "qy", "qz", "h_ant_mig"),
            (0.0, 0.1, 0.0, 0.3, 0.3, 0.4, 4, 3, 5, 0.25),
        ):
            place.attrs[name] = value
        file.create_dataset("/MigratedImage/Image", data=magnitude, compression="gzip")
    found = load_survey(path)
    assert found.image.dims == ("polarization", "depth", "y", "x")
    np.testing.assert_array_equal(found.image.values[0], magnitude.transpose(2, 1, 0))
    assert "simulated" not in found.attrs and found.attrs["permittivity"] == 2.58
    assert any("up to 100.0 mm smaller" in one for one in found.attrs["notes"])


@pytest.mark.parametrize(
    ("form", "name", "inside"),
    [
        ("group-csv", "o", "VNA_SIMULATED_*.csv"),
        ("original-json", "o", "*.json"),
        ("merged-hdf5", "o.h5", None),
    ],
)
def test_simulated_survives_every_format(survey, tmp_path, form, name, inside):
    written = export_survey(survey, tmp_path / name, form)
    with raises_fault(faults.INPUT, f"--format {form}"):
        load_survey(tmp_path / name)
    for path in written:
        for one in sorted(path.glob(inside)) if inside else [path]:
            content = one.read_bytes() + one.name.encode()
            assert b"SIMULATED" in content or b'"simulated": true' in content
    # Without the file beside it too.
    for sums in tmp_path.glob("*.sha256"):
        sums.unlink()
    back = ["import", str(tmp_path / name), str(tmp_path / "back.nc"), "--format", form]
    assert main(back) == 0
    assert load_survey(tmp_path / "back.nc").attrs["simulated"] == 1


GROUPS = {one.group: one for one in (EXPORTS, IMPORTS, IMAGE_FORMATS, METHODS)}


def test_pip_and_catkin_install_the_same_entry_points():
    (call,) = (
        node
        for node in ast.walk(ast.parse((PACKAGE / "setup.py").read_text()))
        if isinstance(node, ast.keyword) and node.arg == "entry_points"
    )
    of_catkin = {
        group: dict(line.split(" = ") for line in lines)
        for group, lines in ast.literal_eval(call.value).items()
    }
    assert of_catkin == added()


@pytest.mark.parametrize(
    ("group", "name"), [(one, name) for one in added() for name in added()[one]]
)
def test_each_addition_can_be_loaded(group, name):
    assert name in GROUPS[group].names()
    assert GROUPS[group].wings[name] == PACKAGE.name
    found = [one for one in additions(group) if one.name == name]
    assert len(found) == 1
    assert GROUPS[group].find(name) is found[0].load()
