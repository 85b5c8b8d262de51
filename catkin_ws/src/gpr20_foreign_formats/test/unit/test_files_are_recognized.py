"""Files of other formats are recognized, and migrated images of the group read and written."""

from __future__ import annotations

import re
import shlex

import h5py
import numpy as np
import pytest
from fault_kit import raises_fault
from random_surveys import random_survey
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import UnreadableFileError
from gpr20_analysis.formats.conversion import export_survey
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.read.load import load_survey
from gpr20_foreign_formats.migrated_hdf5 import read_migrated

IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")


@pytest.fixture(scope="module")
def survey_folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("s"), len(POINTS), "finished",
                       more={"simulated": True})  # fmt: skip


@pytest.mark.parametrize("command", ["info", "image", "plot coverage", "process", "report"])
@pytest.mark.parametrize(
    ("form", "name", "given"),
    [
        ("group-csv", "a folder", "a folder"),
        ("group-csv", "folder", "folder/*.csv"),
        ("original-json", "folder", "folder"),
        ("original-json", "folder", "folder/X*.json"),
        ("merged-hdf5", "file.h5", "file.h5"),
    ],
)
def test_the_command_that_imports_it_is_given_and_works(
    tmp_path, monkeypatch, capsys, command, form, name, given
):
    monkeypatch.chdir(tmp_path)
    export_survey(random_survey(11), tmp_path / name, form)
    path = sorted(tmp_path.glob(given))[0]
    word, *more = command.split()
    options = [] if word == "info" else ["-o", "x.png" if word == "plot" else "x.nc"]
    options = ["-o", "x.html"] if word == "report" else options
    steps = ["--step", "background"] if word == "process" else []
    assert main([word, *more, str(path), *steps, *options]) == 3
    error = capsys.readouterr().err
    found = re.search(r"(gpr20 import .*)", error)
    assert found, error
    _program, *arguments = shlex.split(found.group(1).strip())
    assert main(arguments) in (0, 1)
    assert load_survey("survey.nc").attrs["survey_id"] == "survey-11"


def test_a_folder_over_time_is_recognized(tmp_path):
    export_survey(to_time(random_survey(1)), tmp_path / "t", "group-csv")
    with raises_fault(faults.IMPORT_FIRST, "--format group-csv"):
        load_survey(tmp_path / "t")


@pytest.mark.parametrize("ending", [".out", ".h5"])
def test_simulations_of_gprmax_are_recognized(tmp_path, ending):
    folder = tmp_path / "simulation"
    folder.mkdir()
    with h5py.File(folder / f"scan1{ending}", "w") as file:
        file.create_group("rxs")
    for path in (folder, folder / f"scan1{ending}"):
        with raises_fault(faults.IMPORT_FIRST, "--format gprmax"):
            load_survey(path)


def test_migrated_images_are_written_and_read_again(survey_folder, tmp_path, capsys):
    command = ["image", str(survey_folder), *IMAGE, "-o", str(tmp_path / "i.nc")]
    assert main([*command, "-o", str(tmp_path / "i.h5")]) == 0
    image = read_dataset(tmp_path / "i.nc")
    for turn, name in enumerate(("i_000.h5", "i_090.h5")):
        with h5py.File(tmp_path / name, "r") as file:
            assert file.attrs["Title"] == f"{name[:-3]} (SIMULATED)"
            assert file.attrs["Relative permittivity"] == 4.0
            place = file["Position"].attrs
            assert [place[f"q{axis}"] for axis in "xyz"] == [3, 3, 5]
            assert place["zf"] == pytest.approx(0.02)
            assert place["h_ant_mig"] == pytest.approx(0.03)
            stored = file["MigratedImage/Image"]
            assert (stored.dtype, stored.compression) == (np.float32, "gzip")
            own = np.abs(image.image.values[turn]).transpose(2, 1, 0)
            np.testing.assert_allclose(stored[()], own, rtol=1e-6)
        found = load_survey(tmp_path / name)
        for axis in ("x", "y", "depth"):
            np.testing.assert_allclose(found[axis].values, image[axis].values, atol=1e-12)
        np.testing.assert_allclose(
            found.image.values[0], np.abs(image.image.values[turn]), rtol=1e-6
        )
        assert found.attrs["simulated"] == 1
    capsys.readouterr()
    assert main(["info", str(tmp_path / "i_090.h5")]) == 0
    assert "SIMULATED" in capsys.readouterr().out
    figure = tmp_path / "p.png"
    assert (
        main(["plot", "c-scan", str(tmp_path / "i_090.h5"), "--depth", "10", "-o", str(figure)])
        == 0
    )
    assert main([*command, "-o", str(tmp_path / "i.h5")]) == 3
    assert "i.nc" in capsys.readouterr().err
    (tmp_path / "i.nc").unlink()
    assert main([*command, "-o", str(tmp_path / "i.h5")]) == 3
    assert "i_000.h5" in capsys.readouterr().err


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


def test_a_damaged_migrated_image_is_refused(survey_folder, tmp_path):
    main(["image", str(survey_folder), *IMAGE, "-o", str(tmp_path / "i.h5")])
    path = tmp_path / "i_000.h5"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)
    with pytest.raises(UnreadableFileError):
        read_migrated(path)


@pytest.mark.parametrize(
    ("form", "name", "inside"),
    [
        ("group-csv", "o", "VNA_SIMULATED_*.csv"),
        ("original-json", "o", "*.json"),
        ("merged-hdf5", "o.h5", None),
    ],
)
def test_simulated_survives_every_format(survey_folder, tmp_path, form, name, inside):
    survey = load_survey(survey_folder)
    written = export_survey(survey, tmp_path / name, form)
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
