"""gpr20 process, image and plot as a user calls them."""

from __future__ import annotations

import json
import subprocess
import sys

import h5py
import numpy as np
import pytest
import yaml
from ground_kit import point, scene, survey_of

from gpr20_analysis.commands.command import DONE, NOT_COMPLETE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.dataset_files import read_dataset, write_dataset

PLACES_MM = np.linspace(140.0, 340.0, 11)
TARGET = point(243.7, 236.2, 0.083)


@pytest.fixture(scope="module")
def survey_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("survey") / "survey.nc"
    write_dataset(survey_of(scene([TARGET]), PLACES_MM, PLACES_MM), path)
    return path


def printed(capsys, *arguments, status=DONE):
    assert main([str(one) for one in arguments]) == status
    return capsys.readouterr().out


def refused(capsys, *arguments):
    assert main([str(one) for one in arguments]) == REFUSED
    return capsys.readouterr().err


def test_image_names_the_candidate_and_how_it_was_made(survey_file, capsys):
    answer = json.loads(printed(capsys, "image", survey_file, "--permittivity", 4, "--json"))
    echo = answer["candidates"][0]
    assert abs(echo["x_m"] * 1e3 - TARGET.x_mm) < 3.0
    assert abs(echo["depth_m"] - TARGET.depth_m) < 3e-3
    assert answer["processing"][0]["step"] == "background"


def test_a_band_too_narrow_to_tell_depths_apart_is_refused(survey_file, capsys):
    narrow = ["--step", "background", "--step", "band:start_hz=1e9,stop_hz=1.1e9"]
    told_why = refused(capsys, "image", survey_file, "--permittivity", 4, *narrow)
    assert "use a wider band" in told_why


@pytest.mark.usefixtures("blank_figures")
def test_image_writes_netcdf_and_vtk_and_pictures(survey_file, tmp_path, capsys):
    netcdf, vtk, pictures = tmp_path / "i.nc", tmp_path / "i.vtr", tmp_path / "pictures"
    printed(
        capsys, "image", survey_file, "--permittivity", 4, "--depth", 0, 0.2, 0.05,
        "-o", netcdf, "-o", vtk, "--figures", pictures,
    )  # fmt: skip
    image = read_dataset(netcdf)
    assert image.image.dims == ("polarization", "depth", "y", "x")
    assert image.image.dtype.kind == "c" and image.sizes["depth"] == 5
    with h5py.File(netcdf) as stored:
        assert stored["image_real"].shape == image.image.shape
    assert b"RectilinearGrid" in vtk.read_bytes()[:400]
    names = sorted(path.name for path in pictures.iterdir())
    assert {"projections_0deg.png", "projections_90deg.png"} < set(names)


def test_processed_data_go_through_the_chain_and_keep_their_recipe(survey_file, tmp_path, capsys):
    result, recipe = tmp_path / "clean.nc", tmp_path / "recipe.yaml"
    printed(
        capsys, "process", survey_file, "--step", "background:method=median", "-o", result,
        "--save-recipe", recipe,
    )  # fmt: skip
    assert yaml.safe_load(recipe.read_text())[0]["method"] == "median"
    answer = json.loads(printed(capsys, "image", result, "--permittivity", 4, "--json"))
    assert [one["method"] for one in answer["processing"]] == ["median"]
    again = tmp_path / "again.nc"
    printed(capsys, "process", survey_file, "--recipe", recipe, "-o", again)
    np.testing.assert_array_equal(read_dataset(result).s21, read_dataset(again).s21)


@pytest.mark.usefixtures("blank_figures")
def test_a_combination_is_imaged_under_a_name_of_its_own(survey_file, tmp_path, capsys):
    text = printed(
        capsys, "image", survey_file, "--step", "background", "--step", "combine",
        "--permittivity", 4, "--depth", 0, 0.2, 0.01, "--figures", tmp_path / "pictures", "--json",
    )  # fmt: skip
    answer = json.loads(text)
    assert answer["candidates"][0]["rotations_deg"] == [None]
    assert (tmp_path / "pictures" / "projections_combined.png").exists()


def test_missing_samples_are_refused_then_left_out_aloud(survey_file, tmp_path, capsys):
    survey = read_dataset(survey_file)
    survey.s21[0, 4, 4] = np.nan
    survey.quality[0, 4, 4] = int(Quality.MISSING)
    survey.attrs["missing"] = ["missing: x 220 mm, y 220 mm, 0 deg"]
    holed_file = tmp_path / "holed.nc"
    write_dataset(survey, holed_file)
    assert "1 samples have no data" in refused(capsys, "image", holed_file, "--permittivity", 4)
    options = ("--permittivity", 4, "--leave-out-missing")
    text = printed(capsys, "image", holed_file, *options, status=NOT_COMPLETE)
    assert "note: 1 of 242 samples were left out" in text


@pytest.mark.usefixtures("blank_figures")
def test_plots_of_a_survey_are_written(survey_file, tmp_path, capsys):
    for kind, *options in (
        ("a-scan", "--x", "240", "--y", "240", "--until", "6"),
        ("b-scan", "--along", "y", "--x", "240", "--value", "real"),
        ("c-scan", "--delay", "2.4"),
        ("coverage",),
        ("height",),
    ):
        picture = tmp_path / f"{kind}.svg"
        printed(capsys, "plot", kind, survey_file, *options, "-o", picture)
        assert picture.exists(), kind


def test_plots_of_an_image_are_written(survey_file, tmp_path, capsys):
    image = tmp_path / "image.nc"
    printed(capsys, "image", survey_file, "--permittivity", 4, "-o", image)
    for kind, options in (("c-scan", ("--depth", 83)), ("projection", ("--rotation", 90))):
        picture = tmp_path / f"{kind}.png"
        printed(capsys, "plot", kind, image, *options, "-o", picture)
        assert picture.stat().st_size > 10_000
    reason = refused(capsys, "plot", "c-scan", image, "--delay", 2, "-o", tmp_path / "x.png")
    assert "--delay is for surveys" in reason


WRONG_ARGUMENTS = (
    (
        ("image", "SURVEY", "--permittivity", "0.2"),
        "permittivity is 0.2; it must lie between 1 and 100",
    ),
    (("image", "SURVEY", "--depth", "0", "0.3", "0.3001"), "gives 1 depths; use 2 to 5000"),
    (("image", "SURVEY", "-o", "picture.jpg"), "must end in"),
    (("image", "SURVEY", "--step", "migrate"), "the step 'migrate' does not exist"),
    (("process", "SURVEY", "-o", "x.nc"), "no step was given"),
    (("plot", "a-scan", "SURVEY", "--x", "900", "-o", "x.png"), "outside the data"),
    (("plot", "c-scan", "SURVEY", "-o", "x.png"), "--delay"),
    (("plot", "c-scan", "SURVEY", "--depth", "50", "-o", "x.png"), "--depth is for images"),
    (("plot", "b-scan", "SURVEY", "--until", "0", "-o", "x.png"), "--until"),
    (("plot", "height", "SURVEY", "-o", "x.jpg"), "must end in"),
    (("plot", "projection", "SURVEY", "-o", "x.png"), "do not contain 'image'"),
)


def test_wrong_arguments_are_refused_with_a_reason(survey_file, capsys):
    for arguments, reason in WRONG_ARGUMENTS:
        given = [str(survey_file) if one == "SURVEY" else one for one in arguments]
        assert reason in refused(capsys, *given)


def test_the_commands_start_without_libraries_that_take_long_to_import():
    slow = ["scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.stats", "scipy.spatial"]
    slow += ["dask.array", "distributed", "numba", "matplotlib"]
    code = (
        "import sys\nfrom gpr20_analysis.commands import image_command, import_command\n"
        f"print([name for name in {slow} if name in sys.modules])"
    )
    printed = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True)
    assert printed.stdout.decode().strip() == "[]"
