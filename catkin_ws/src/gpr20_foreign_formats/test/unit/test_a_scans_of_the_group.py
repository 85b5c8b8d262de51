"""A-scans over time, as the group's programs write them, are read and imaged."""

import h5py
import numpy as np
import pandas as pd
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import read_dataset, write_dataset
from gpr20_analysis.processing.delay import to_time
from gpr20_foreign_formats import group_csv
from gpr20_survey.radar.frequency_to_delay import Window

STEP_MM = 16.0
X_MM = Y_MM = np.arange(160.0, 321.0, STEP_MM)
FREQUENCY_HZ = np.linspace(600e6, 6e9, 201)
TARGET = (233.0, 247.0, 0.1)
DEPTHS = ("--depth", "0.05", "0.15", "0.001")


@pytest.fixture(scope="module")
def survey():
    found = survey_of(scene([point(*TARGET)], 4.0, height_m=0.2), X_MM, Y_MM, FREQUENCY_HZ, (0.0,))
    return found.assign_attrs(simulated=1)


def group_transform(spectrum, frequency_hz):
    """Return A-scan and times as the group's script computes them, from its description.

    A Hamming window; zeros from 0 Hz up to one step below the first frequency; the conjugate
    mirrored onto the negative frequencies without leaving out 0 Hz; the half with times from 0.
    """
    step_hz = frequency_hz[1] - frequency_hz[0]
    below = int(np.ceil(frequency_hz[0] / step_hz - 1e-9)) - 1
    positive = np.append(np.zeros(below), spectrum * np.hamming(len(spectrum)))
    count = 2 * len(positive)
    a_scan = np.fft.ifft(np.append(positive, np.flip(np.conj(positive))))
    return a_scan[: count // 2], np.arange(count // 2) / (count * step_hz)


def write_as_the_group(survey, folder, times_file):
    folder.mkdir()
    for row, column in np.ndindex(*survey.s21.shape[1:3]):
        a_scan, delay_s = group_transform(survey.s21.values[0, row, column], FREQUENCY_HZ)
        table = pd.DataFrame({"A-Scan_real": a_scan.real, "A-Scan_imag": a_scan.imag})
        end_us = round(delay_s[-1] * 1e6, 4)
        name = f"TIME_X{X_MM[column]:g}_Y{Y_MM[row]:g}_OrX_Ts0u_Te{end_us}u_Qt{len(a_scan)}_H200"
        table.to_csv(folder / f"{name}.csv", index=False)
    if times_file:
        pd.DataFrame({"Time": delay_s}).to_csv(folder / "time", index=False)


def brightest(path, tmp_path):
    """Return x, y [mm] and depth [m] of the brightest voxel of the image."""
    arguments = [str(path), "--permittivity", "4", *DEPTHS, "-o", str(tmp_path / "i.nc")]
    assert main(["image", *arguments, "--overwrite"]) == 0
    image = read_dataset(tmp_path / "i.nc")
    magnitude = np.abs(image.image.values[0])
    depth, row, column = np.unravel_index(np.argmax(magnitude), magnitude.shape)
    return X_MM[column], Y_MM[row], float(image.depth[depth])


@pytest.mark.parametrize("times_file", [True, False])
def test_files_of_the_groups_transform_are_imaged(survey, tmp_path, capsys, times_file):
    write_as_the_group(survey, tmp_path / "time_files", times_file)
    output = tmp_path / "s.nc"
    arguments = [str(tmp_path / "time_files"), str(output), "--format", "group-csv"]
    assert main(["import", *arguments]) == 0
    notes = capsys.readouterr().err
    assert "the band" in notes and "was taken from the spectra" in notes
    assert ("there is no file 'time'" in notes) is not times_file
    found = read_dataset(output)
    assert 4e8 < found.frequency[0] < 8e8 and 5.8e9 < found.frequency[-1] < 6.3e9
    x_mm, y_mm, depth_m = brightest(output, tmp_path)
    assert abs(x_mm - TARGET[0]) <= STEP_MM and abs(y_mm - TARGET[1]) <= STEP_MM
    assert abs(depth_m - TARGET[2]) <= 0.005


def test_pandas_reads_a_scans_with_the_groups_names_and_times(survey, tmp_path):
    in_time = to_time(survey, Window.NONE, 2.0)
    group_csv.write_group_csv(in_time, tmp_path / "t")
    paths = sorted((tmp_path / "t").glob("TIME_SIMULATED_X160_Y160_OrX_Ts0u_Te*u_Qt*_H200.csv"))
    table = pd.read_csv(paths[0], usecols=["A-Scan_real", "A-Scan_imag"], float_precision="high")
    own = in_time.a_scan.values[0, 0, 0]
    np.testing.assert_allclose(table["A-Scan_real"], own.real, rtol=1e-12)
    np.testing.assert_allclose(table["A-Scan_imag"], own.imag, rtol=1e-12)
    times = pd.read_csv(tmp_path / "t" / "time", float_precision="high").Time
    np.testing.assert_allclose(times, in_time.delay.values, rtol=1e-12)
    # What the group's merging program takes from the name.
    end_s = float(paths[0].name.split("_Te")[1].split("u_Qt")[0]) * 1e-6
    assert end_s == pytest.approx(float(in_time.delay[-1]), rel=1e-8)


def test_times_that_do_not_fit_the_names_are_refused(survey, tmp_path):
    write_as_the_group(survey, tmp_path / "t", True)
    path = tmp_path / "t" / "time"
    lines = path.read_text().splitlines()
    for wrong, fault in (
        (lines[:-1], faults.INPUT),
        ([*lines[:5], "1e-9", *lines[6:]], faults.INPUT),
        (["x", "y"], faults.FILE_DAMAGED),
    ):
        path.write_text("\n".join(wrong) + "\n")
        with raises_fault(fault, "time"):
            group_csv.read_group_csv(tmp_path / "t")
    group_csv.write_group_csv(survey, tmp_path / "t")  # over frequency, beside those over time
    with raises_fault(faults.INPUT):
        group_csv.read_group_csv(tmp_path / "t")


def test_real_a_scans_of_a_merged_file_give_spectra_of_the_right_level(survey, tmp_path):
    """Simulations that the group merges have no imaginary parts."""
    write_dataset(survey, tmp_path / "f.nc")
    path = tmp_path / "t.h5"
    command = ["export", str(tmp_path / "f.nc"), str(path), "--format", "merged-hdf5"]
    assert main([*command, "--domain", "time"]) == 0
    with h5py.File(path, "r+") as file:
        del file["A-Scan/Im{A-Scan x-pol}"]
    assert main(["import", str(path), str(tmp_path / "r.nc"), "--format", "merged-hdf5"]) == 0
    found, true = read_dataset(tmp_path / "r.nc").s21.values, survey.s21.values
    # A real trace also has the negative frequencies, which leak a little.
    factor = np.vdot(true, found) / np.linalg.norm(true) ** 2
    assert factor == pytest.approx(1.0, abs=0.05)
    assert np.linalg.norm(found - true) < 0.15 * np.linalg.norm(true)
