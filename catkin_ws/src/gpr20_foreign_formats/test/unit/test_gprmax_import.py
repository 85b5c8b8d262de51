"""Simulations of gprMax become transmissions: their delays do not hold the source's."""

import h5py
import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from instruments_kit import read

from gpr20_analysis import errors
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.imports import Band
from gpr20_analysis.read.load import load_survey
from gpr20_common.faults import NOT_ALLOWED
from gpr20_foreign_formats.gprmax_source import WAVEFORMS, source_of

STEP_S, COUNT = 20e-12, 1000
CENTRE_HZ = 2e9
BAND = ("--band", "1e9", "3e9", "101")
OPTIONS = {"band": Band(1e9, 3e9, 101), "height_m": 0.1}
TIME_S = np.arange(COUNT) * STEP_S


def make_gprmax(path, position=(0.1, 0.2), delay_s=4e-9, amplitude=1.0, version=3, along="y"):
    """Write what gprMax does; version 4 names the source, whose samples lie between the field's."""
    ricker = WAVEFORMS["ricker"]
    with h5py.File(path, "w") as file:
        file.attrs.update(Title="t", Iterations=COUNT, dt=STEP_S, nsrc=1, nrx=1)
        receiver, source = file.create_group("rxs/rx1"), file.create_group("srcs/src1")
        receiver.attrs["Position"] = (position[0] + 0.03, position[1], 0.5)
        source.attrs["Position"] = (position[0] - 0.03, position[1], 0.5)
        for name in ("Ex", "Ey", "Ez"):
            own = amplitude if name == f"E{along}" else 0.01
            receiver[name] = own * ricker((TIME_S - delay_s) * CENTRE_HZ)
        if version == 4:
            source.attrs["Polarisation"] = along
            excitation = source.create_group("excitation")
            excitation["samples"] = ricker((TIME_S + STEP_S / 2) * CENTRE_HZ)
            excitation.attrs.update(SampleInterval=STEP_S, TimeSampleOffset=STEP_S / 2)


def delay_of(survey, place):
    phase = np.unwrap(np.angle(survey.s21.values[place]))
    return -np.polyfit(survey.frequency.values, phase, 1)[0] / (2 * np.pi)


@pytest.mark.parametrize("version", [3, 4])
def test_spectra_are_divided_by_the_source(tmp_path, version):
    places = [(0.1 + 0.02 * column, 0.2 + 0.02 * row) for row in range(2) for column in range(3)]
    for number, place in enumerate(places):
        make_gprmax(tmp_path / f"scan{number + 1}.out", place, 4e-9, 1.0 + number, version)
    output = tmp_path / "g.nc"
    source = ["--source", f"ricker:{CENTRE_HZ}"] if version == 3 else []
    arguments = ["--format", "gprmax", "--height", "0.15", *BAND, *source]
    assert main(["import", str(tmp_path), str(output), *arguments]) == 0
    found = load_survey(output)
    np.testing.assert_allclose(found.x.values, [0.1, 0.12, 0.14])
    assert found.polarization.values.tolist() == [90.0]
    assert found.attrs["simulated"] == 1 and found.attrs["antenna_separation_m"] == 0.06
    assert delay_of(found, (0, 1, 2)) == pytest.approx(4e-9, abs=1e-13)
    amplitudes = np.abs(found.s21.values[0]).reshape(6, -1)
    np.testing.assert_allclose(amplitudes, np.arange(1.0, 7.0)[:, None] * np.ones(101), rtol=1e-5)


def test_without_its_source_a_simulation_is_refused(tmp_path, capsys):
    make_gprmax(tmp_path / "a.out")
    output = tmp_path / "g.nc"
    arguments = ["import", str(tmp_path / "a.out"), str(output), "--format", "gprmax", *BAND]
    assert main(arguments) == 3
    error = capsys.readouterr().err
    assert "does not contain the source signal" in error and "--source" in error


def test_two_simulations_of_one_place_by_their_polarization_are_two_samples(tmp_path):
    make_gprmax(tmp_path / "x.h5", version=4, along="x", delay_s=2e-9)
    make_gprmax(tmp_path / "y.h5", version=4, along="y", delay_s=3e-9)
    found = read(tmp_path, "gprmax", **OPTIONS)
    assert found.polarization.values.tolist() == [0.0, 90.0]
    assert delay_of(found, (0, 0, 0)) == pytest.approx(2e-9, abs=1e-13)
    assert delay_of(found, (1, 0, 0)) == pytest.approx(3e-9, abs=1e-13)


def test_a_band_that_the_source_or_the_time_step_does_not_reach_is_refused(tmp_path):
    make_gprmax(tmp_path / "a.h5", version=4)
    for stop_hz in (12e9, 30e9):
        with raises_fault(errors.INPUT, "--band"):
            read(tmp_path, "gprmax", band=Band(1e9, stop_hz, 101))


@pytest.mark.parametrize(
    ("change", "shown"),
    [
        (lambda file: file.attrs.update(nrx=2), "2"),
        (lambda file: file["srcs/src1"].attrs.update(Polarisation="z"), "a.h5"),
        (lambda file: file["srcs/src1"].attrs.update(Position=(0, 0, np.nan)), "Position"),
        (lambda file: file["rxs/rx1/Ey"].write_direct(np.full(COUNT, np.nan)), "Ey"),
        (lambda file: file["srcs/src1/excitation/samples"].write_direct(np.zeros(COUNT)), "a.h5"),
    ],
)
def test_files_that_are_no_single_whole_a_scan_are_refused(tmp_path, change, shown):
    make_gprmax(tmp_path / "a.h5", version=4)
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        change(file)
    with raises_fault(errors.INPUT, shown):
        read(tmp_path, "gprmax", **OPTIONS)


@pytest.mark.parametrize("text", ["ricker:x", "ricker:0", "sinc:1e9", "none:1", "ricker"])
def test_a_source_that_is_none_is_refused_with_what_there_is(text):
    with raises_fault(NOT_ALLOWED):
        source_of(text)


def test_antennas_that_move_apart_are_refused(tmp_path):
    make_gprmax(tmp_path / "a.h5", version=4)
    make_gprmax(tmp_path / "b.h5", position=(0.2, 0.2), version=4)
    with h5py.File(tmp_path / "b.h5", "r+") as file:
        file["srcs/src1"].attrs["Position"] = (0.07, 0.2, 0.5)
    with raises_fault(errors.INPUT, "0.06", "0.16", "move together"):
        read(tmp_path, "gprmax", **OPTIONS)
    given = read(tmp_path, "gprmax", **OPTIONS, separation_m=0.1)
    assert given.attrs["antenna_separation_m"] == 0.1


@each_case(
    "cells, along, allowed",
    [((60, 1, 40), "y", "x, z"), ((1, 60, 40), "z", ""), ((60, 40, 1), "y", ""),
     ((60, 40, 30), "z", "")],
)  # fmt: skip
def test_a_field_upwards_is_refused_in_a_model_of_any_shape(
    cells, along, allowed, tmp_path_factory
):
    path = tmp_path_factory.mktemp("flat") / "a.h5"
    make_gprmax(path, version=4, along=along)
    with h5py.File(path, "r+") as file:
        file.attrs["nx_ny_nz"] = cells
    if allowed:
        assert read(path, "gprmax", **OPTIONS).polarization.values.tolist() == [90.0]
        return
    with raises_fault(errors.INPUT, "a.h5", f"E{along}", "upwards"):
        read(path, "gprmax", **OPTIONS)
