"""Plain arrays of other programs become surveys, with axes in the file or beside it."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
from arrays_kit import ENDINGS, FREQUENCY_HZ, TIME_S, a_line, describe, read, write_arrays
from fault_kit import raises_fault

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.conversion import export_survey
from gpr20_analysis.formats.format import IMPORTS
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample.real_line import REAL_LINE_FILE
from gpr20_analysis.sample.sample_survey import sample_survey

BAR_M = 0.015
PULSE = np.exp(-(((TIME_S - 2e-9) * 3e9) ** 2)) * np.cos(2 * np.pi * 1.5e9 * TIME_S)


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_file_with_documented_names_needs_nothing_beside_it(tmp_path, ending):
    path, line = tmp_path / f"line{ending}", a_line()
    write_arrays(path, {**line, "height_m": np.full(5, 0.1), "delay_s": 1e-9})
    found = read(path)
    np.testing.assert_array_equal(found.s21.values[0, 0], line["s21"])
    np.testing.assert_allclose(found.x, line["x_m"], atol=1e-12)
    assert found.height.values.tolist() == [[[0.1] * 5]]
    assert found.attrs["antenna_delay_s"] == 1e-9 and "simulated" not in found.attrs
    assert [key for key in ("rotation_deg", "y_m") if key in str(found.attrs["notes"])]
    assert read(path, height_m=0.3).height.values.tolist() == [[[0.3] * 5]]


def test_a_file_beside_it_names_arrays_and_gives_axes(tmp_path):
    path = tmp_path / "d.npy"
    values = np.stack([a_line(4)["s21"]] * 2)
    write_arrays(path, {"array": values})
    describe(
        path,
        s21="array",
        rotation_deg=[0, "9e1"],
        x_m={"start": 0.0, "step": "1e-2", "count": 4},
        frequency_hz={"start": 1e9, "step": 5e7, "count": 21},
        simulated=True,
    )
    found = read(path)
    np.testing.assert_array_equal(found.s21.values[:, 0], values)
    assert found.polarization.values.tolist() == [0.0, 90.0]
    assert found.attrs["simulated"] == 1 and (found.quality == 4).all()


def test_an_array_in_other_units_has_a_factor(tmp_path):
    path, line = tmp_path / "d.h5", a_line()
    write_arrays(path, {"g/s": line["s21"], "g/mm": line["x_m"] * 1e3, "GHz": FREQUENCY_HZ / 1e9})
    factor = {"x_m": {"array": "g/mm", "factor": 0.001}}
    describe(path, s21="g/s", frequency_hz={"array": "GHz", "factor": "1e9"}, **factor)
    found = read(path)
    np.testing.assert_allclose(found.x, line["x_m"])
    np.testing.assert_allclose(found.frequency, FREQUENCY_HZ)


def test_a_list_of_traces_is_put_on_its_grid_in_any_order(tmp_path):
    path = tmp_path / "d.mat"
    random = np.random.default_rng(1)
    y_m, x_m = (one.ravel() for one in np.meshgrid([0.0, 0.1], [0.0, 0.02, 0.04]))
    shuffled = random.permutation(6)
    s21 = np.exp(1j * np.arange(6))[:, None] * np.ones(21)
    arrays = {"s21": s21, "x_m": x_m, "y_m": y_m, "height_m": 0.1 + x_m}
    arrays = {key: one[shuffled] for key, one in arrays.items()}
    write_arrays(path, {**arrays, "frequency_hz": FREQUENCY_HZ})
    found = read(path)
    np.testing.assert_allclose(
        found.s21.values[0, :, :, 3], np.exp(1j * np.arange(6)).reshape(3, 2).T
    )
    np.testing.assert_allclose(found.height.values[0], [[0.1, 0.12, 0.14]] * 2)


@pytest.mark.parametrize("way", ["beside", "band", "found"])
def test_a_scans_become_spectra_at_the_frequencies_that_are_given(tmp_path, way):
    path, output = tmp_path / "d.npz", tmp_path / "o.nc"
    scans = np.tile(PULSE + 0.25, (3, 1))
    write_arrays(path, {"a_scans": scans, "x_m": [0.0, 0.1, 0.2], "time_s": TIME_S})
    if way == "beside":
        describe(path, frequency_hz={"start": 1e9, "step": 5e7, "count": 21})
    band = ["--band", "1e9", "2e9", "21"] if way == "band" else []
    command = ["import", str(path), str(output), "--format", "arrays"]
    assert main([*command, *band]) == 0
    found = load_survey(output)
    turns = np.exp(-2j * np.pi * np.outer(TIME_S, found.frequency.values))
    ratio = found.s21.values[0, 0] / (scans @ turns)
    # Nothing is removed from them silently, such as their mean.
    np.testing.assert_allclose(ratio, abs(ratio[0, 0]), rtol=1e-6)
    assert way == "found" or found.frequency.values.tolist() == FREQUENCY_HZ.tolist()
    assert main([*command, "--domain", "time", "--overwrite"]) == 0
    np.testing.assert_array_equal(load_survey(output).a_scan.values[0, 0], scans)


def test_samples_of_nan_are_missing_or_damaged(tmp_path):
    path, line = tmp_path / "d.npz", a_line()
    line["s21"][1], line["s21"][2, 4] = np.nan, np.inf
    write_arrays(path, line)
    found = read(path)
    assert (found.quality.values.ravel() & 3).tolist() == [0, 1, 2, 0, 0]
    assert len(found.attrs["missing"]) == 2 and len(found.attrs["faults"]) == 1


def test_the_bars_of_a_real_line_are_found_by_the_default_command(tmp_path, capsys):
    path, output = tmp_path / "line.npz", tmp_path / "line.nc"
    path.write_bytes(REAL_LINE_FILE.read_bytes())
    # Not recorded, and assumed: antennas at 10 mm, time zero at the first positive peak.
    describe(
        path,
        frequency_hz={"start": 0.5e9, "step": 125e6, "count": 21},
        height_m=0.01,
        delay_s=1.98e-9,
    )
    assert main(["import", str(path), str(output), "--format", "arrays"]) == 0
    capsys.readouterr()
    assert main(["image", str(output), "--permittivity", "6", "--json"]) == 0
    candidates = json.loads(capsys.readouterr().out)["candidates"]
    places_m = np.array([one["x_m"] for one in candidates if not one["doubtful"]])
    bars_m = np.load(path)["rebar_x_m"]
    away_m = np.abs(places_m[:, None] - bars_m)
    assert np.count_nonzero(away_m.min(axis=0) < BAR_M) >= 12
    assert np.count_nonzero(away_m[:14].min(axis=1) < BAR_M) >= 12


@pytest.mark.parametrize("ending", ENDINGS)
def test_files_with_documented_names_are_recognized(tmp_path, ending):
    path = tmp_path / f"line{ending}"
    write_arrays(path, a_line())
    with raises_fault(faults.IMPORT_FIRST, "--format arrays"):
        load_survey(path)


@pytest.mark.parametrize("name", ["d.npz", "d.npy", "d.mat", "d.h5"])
def test_other_names_are_recognized_by_the_file_beside_it(tmp_path, name):
    write_arrays(tmp_path / name, {"other": np.ones((2, 3))})
    assert IMPORTS.find("arrays").whole(tmp_path / name) is None
    describe(tmp_path / name, s21="other")
    assert IMPORTS.find("arrays").whole(tmp_path / name) == tmp_path / name


def test_files_of_other_formats_are_not_taken(tmp_path):
    survey = load_survey(sample_survey())
    export_survey(survey, tmp_path / "m.h5", "merged-hdf5")
    export_survey(survey, tmp_path / "n.nc", "netcdf")
    (tmp_path / "n.nc").rename(tmp_path / "n.h5")
    with h5py.File(tmp_path / "g.h5", "w") as file:
        file.create_group("rxs")
    (tmp_path / "text.npz").write_text("s21")
    for name in ("m.h5", "g.h5"):
        describe(tmp_path / name, s21="other")
    for name in ("m.h5", "n.h5", "g.h5", "text.npz", "absent.npy"):
        assert IMPORTS.find("arrays").whole(tmp_path / name) is None
