"""What is written for the group's programs is theirs, and comes back with the same numbers."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pandas as pd
import pytest
from fault_kit import raises_fault
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey
from gpr20_foreign_formats import group_csv, merged_hdf5

ALL = len(POINTS)

MISSING = 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.fixture(scope="module")
def cut_short(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("short"), ALL - MISSING, "stopped")


@pytest.fixture(scope="module")
def survey(folder):
    return load_survey(folder)


def export(source, output, kind, *more):
    return main(["export", str(source), str(output), "--format", kind, *more])


@pytest.mark.parametrize(
    ("kind", "output"),
    [("group-csv", "csv"), ("original-json", "json"), ("merged-hdf5", "merged.h5")],
)
@pytest.mark.parametrize("whole", [True, False])
def test_what_is_exported_is_imported_again(folder, cut_short, tmp_path, kind, output, whole):
    source = folder if whole else cut_short
    status = 0 if whole else 1
    assert export(source, tmp_path / output, kind) == status
    back = tmp_path / "back.nc"
    assert main(["import", str(tmp_path / output), str(back), "--format", kind]) == status
    expected, found = load_survey(source), load_survey(back)
    exact = {"rtol": 0.0, "atol": 0.0} if kind != "merged-hdf5" else {"rtol": 1e-6, "atol": 0.0}
    for name in ("s21", "polarization", "y", "x", "frequency"):
        np.testing.assert_allclose(found[name].values, expected[name].values, **exact)
    np.testing.assert_allclose(found.height.values, expected.height.values, atol=1e-5)
    assert len(found.attrs["missing"]) == (0 if whole else MISSING)


def test_files_of_the_group_have_its_names_and_header(survey, tmp_path):
    group_csv.write_group_csv(survey, tmp_path / "csv")
    path = tmp_path / "csv" / "VNA_X15_Y20_OrY_Fs600M_Fe6000M_Qf5_H300.csv"
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


def test_a_scans_over_time_come_back_from_the_merged_file(folder, tmp_path):
    assert export(folder, tmp_path / "t.h5", "merged-hdf5", "--domain", "time") == 0
    with h5py.File(tmp_path / "t.h5", "r") as file:
        assert file["A-Scan/Im{A-Scan y-pol}"].shape == (ALL // 2, file["Time"].attrs["q"])
    found = merged_hdf5.read_merged(tmp_path / "t.h5")
    assert found.a_scan.dims == ("polarization", "y", "x", "delay")
    assert float(found.delay[-1]) < 1 / 1.35e9


def test_the_real_parts_over_time_hold_two_samples_per_period_of_the_highest_frequency(
    survey, folder, tmp_path
):
    assert export(folder, tmp_path / "t.h5", "merged-hdf5", "--domain", "time") == 0
    highest_hz = float(survey.frequency[-1])
    with h5py.File(tmp_path / "t.h5", "r") as file:
        step_s = float(file["Time"].attrs["dt"])
        own = file["A-Scan/Re{A-Scan y-pol}"][0]
    assert step_s * 2.0 * highest_hz <= 1.0 + 1e-9
    spectrum = survey.s21.sel(polarization=90.0).values[0, 0]
    turns = np.exp(2j * np.pi * survey.frequency.values * 2.0 * step_s)
    assert own[2] == pytest.approx((spectrum * turns).sum().real / len(spectrum), rel=1e-5)


def test_samples_of_the_original_project_keep_its_keys(folder, tmp_path):
    assert export(folder, tmp_path / "o", "original-json") == 0
    sample = json.loads((tmp_path / "o" / "X010.00_Y010.00_Z000.00.json").read_text())
    assert set(sample) == {
        "x_coord", "y_coord", "z_coord", "antennae_height", "timestamp", "survey_id", "sample_id",
        "data",
    }  # fmt: skip
    assert set(sample["data"][0]) == {"freq_value", "real_value", "imaginary_value"}


def test_heights_that_are_not_known_cannot_be_said_in_the_groups_names(survey, tmp_path):
    with raises_fault(faults.FORMAT):
        group_csv.write_group_csv(survey.assign(height=survey.height * np.nan), tmp_path / "c")


def test_a_file_of_the_group_with_lines_missing_is_refused(survey, tmp_path):
    group_csv.write_group_csv(survey, tmp_path)
    victim = sorted(tmp_path.iterdir())[3]
    victim.write_text("".join(victim.read_text().splitlines(keepends=True)[:-1]))
    with raises_fault(faults.FILE_DAMAGED, victim.name):
        group_csv.read_group_csv(tmp_path)


def test_files_of_the_group_with_mixed_sweeps_are_refused(survey, tmp_path):
    group_csv.write_group_csv(survey, tmp_path)
    group_csv.write_group_csv(survey.isel(frequency=slice(0, 3)), tmp_path)
    with raises_fault(faults.FILE_CONTENT):
        group_csv.read_group_csv(tmp_path)


def test_scans_that_do_not_fill_the_grid_of_a_merged_file_are_refused(survey, tmp_path):
    path = tmp_path / "m.h5"
    merged_hdf5.write_merged(survey, path, "title")
    with h5py.File(path, "r+") as file:
        kept = file["A-Scan/Re{S21 x-pol}"][:-1]
        del file["A-Scan/Re{S21 x-pol}"]
        file["A-Scan/Re{S21 x-pol}"] = kept
    with raises_fault(faults.FILE_CONTENT):
        merged_hdf5.read_merged(path)


def test_a_merged_file_of_more_than_the_memory_is_refused(folder, tmp_path, monkeypatch):
    monkeypatch.setattr("gpr20_analysis.lazy.available_bytes", lambda: 1000)
    with raises_fault(faults.TOO_LARGE, "merged HDF5 file needs"):
        merged_hdf5.write_merged(load_survey(folder, lazy_bytes=0), tmp_path / "s.h5", "s")
