"""What is exported can be read by others."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import segyio
import skrf
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey

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


def test_segyio_reads_a_cube_whose_traces_are_the_a_scans(survey, tmp_path, folder):
    assert export(folder, tmp_path / "s.sgy", "segy") == 0
    with segyio.open(str(tmp_path / "s_090.sgy"), strict=True) as file:
        cube = segyio.tools.cube(file)
        assert cube.shape[:2] == (3, 3)
        header = file.header[1]
        assert header[segyio.TraceField.SourceX] == 150
        assert header[segyio.TraceField.SourceGroupScalar] == -10000
        assert file.bin[segyio.BinField.Interval] == 50
    own = survey.s21.sel(polarization=90.0, y=0.01, x=0.015).values
    weights = np.hanning(7)[1:-1]
    turns = np.exp(2j * np.pi * survey.frequency.values * 3 * 50e-12)
    assert cube[0, 1, 3] == pytest.approx((own * weights * turns).sum().real / 3.0, rel=1e-5)


def test_a_missing_sample_is_a_dead_trace_in_seg_y(cut_short, tmp_path):
    assert export(cut_short, tmp_path / "s.sgy", "segy") == 1
    dead = 0
    for name in ("s_000.sgy", "s_090.sgy"):
        with segyio.open(str(tmp_path / name)) as file:
            codes = file.attributes(segyio.TraceField.TraceIdentificationCode)[:]
            assert np.isfinite(file.trace.raw[:]).all()
            dead += int((codes == 2).sum())
    assert dead == MISSING


def test_scikit_rf_reads_s21_from_touchstone(survey, folder, tmp_path):
    assert export(folder, tmp_path / "ts", "touchstone") == 0
    files = sorted((tmp_path / "ts").glob("*.s2p"))
    assert len(files) == ALL
    network = skrf.Network(str(files[0]))
    own = survey.s21.values[survey["index"].values == 0][0]
    np.testing.assert_allclose(network.s[:, 1, 0], own, rtol=1e-12)
    np.testing.assert_allclose(network.f, survey.frequency.values, rtol=1e-12)
    assert "only S21 was measured" in files[0].read_text()


def test_pandas_reads_the_plain_table(survey, folder, tmp_path):
    assert export(folder, tmp_path / "t.csv", "csv") == 0
    table = pd.read_csv(tmp_path / "t.csv", float_precision="round_trip")
    row = table[table["index"] == 7].iloc[0]
    own = survey.s21.values[survey["index"].values == 7][0]
    assert row["real_600000000.0_hz"] == own[0].real
    assert row["imag_6000000000.0_hz"] == own[-1].imag
