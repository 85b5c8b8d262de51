"""Lines of other instruments become surveys, with time zero, separation and spacing."""

import json

import numpy as np
import pytest
from fault_kit import raises_fault
from instruments_kit import (
    KINDS,
    RICKER,
    SAMPLES,
    SPACING_M,
    SPECTRA,
    TRACES,
    WINDOW_NS,
    counts,
    read,
    write_dt1,
    write_dzt,
    write_merged,
    write_rd3,
    write_segy,
    write_touchstone,
)
from obspy.io.segy.segy import _read_segy

from gpr20_analysis import faults, import_survey
from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample.real_line import REAL_LINE_FILE
from gpr20_common.faults import NOT_ALLOWED

BAR_M = 0.015
X_M = np.arange(TRACES) * SPACING_M
STEP_S = WINDOW_NS * 1e-9 / SAMPLES


def check_line(found, values, step_s=STEP_S):
    np.testing.assert_allclose(found.a_scan.values[0, 0].real, values, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(found.x, X_M, atol=1e-9)
    np.testing.assert_allclose(found.delay, np.arange(values.shape[1]) * step_s, rtol=1e-6)
    assert found.polarization.values.tolist() == [0.0] and found.y.values.tolist() == [0.0]
    assert "simulated" not in found.attrs


@pytest.mark.parametrize("bits", [8, 16, 32])
def test_a_dzt_file_is_read_as_shares_of_its_full_scale(tmp_path, bits):
    write_dzt(tmp_path / "later.dzt", position=0.8)
    found = read(tmp_path / "later.dzt", "dzt")
    assert float(found.delay[0]) == pytest.approx(0.8e-9) and found.attrs["antenna_delay_s"] == 0.0
    write_dzt(tmp_path / "line.DZT", bits=bits, position=-1.2)
    (tmp_path / "LINE.dzx").write_text("<DZX/>")
    found = read(tmp_path / "line.DZT", "dzt", separation_m=0.06, height_m=0.01)
    check_line(found, counts(bits) / 2.0 ** (bits - 1))
    assert found.attrs["antenna_delay_s"] == pytest.approx(1.2e-9)
    assert found.attrs["antenna_separation_m"] == 0.06
    assert (found.height == 0.01).all()
    assert "1.5/1.6GH" in str(found.attrs["notes"]) and "LINE.dzx" in str(found.attrs["notes"])


@pytest.mark.parametrize("data", [2, 4, 2048])
def test_a_channel_of_several_is_chosen_wherever_the_data_begin(tmp_path, data):
    channels = [counts(seed=seed) for seed in (1, 2)]
    write_dzt(tmp_path / "a.dzt", channels, data=data)
    for number, values in enumerate(channels):
        check_line(read(tmp_path / "a.dzt", "dzt", channel=number + 1), values / 2.0**15)
    for channel in (None, 0, 3):
        with raises_fault(NOT_ALLOWED, "2 channels", "--channel"):
            read(tmp_path / "a.dzt", "dzt", channel=channel)


@pytest.mark.parametrize("kind", ["<i2", "<f4"])
@pytest.mark.parametrize(("unit", "unit_m"), [("m", 1.0), ("ft", 0.3048)])
def test_a_dt1_file_is_read_with_its_header_beside_it(tmp_path, kind, unit, unit_m):
    write_dt1(tmp_path / "XLINE00.DT1", kind, x=X_M / unit_m, unit=unit)
    for name in ("XLINE00.DT1", "XLINE00.HD"):
        found = read(tmp_path / name, "dt1")
        check_line(found, counts())
        assert found.attrs["antenna_delay_s"] == pytest.approx(3.5 * STEP_S)
        assert found.attrs["antenna_separation_m"] == pytest.approx(0.05 * unit_m)


def test_a_dt1_trace_whose_zero_flag_is_set_is_missing(tmp_path):
    write_dt1(tmp_path / "l.dt1", dead=[2])
    found = read(tmp_path / "l.dt1", "dt1")
    assert len(found.attrs["missing"]) == 1
    assert np.isnan(found.a_scan.values[0, 0]).all(axis=-1).nonzero()[0].tolist() == [2]


def test_a_line_that_was_driven_backwards_is_read_from_its_other_end(tmp_path):
    write_dt1(tmp_path / "l.dt1", x=X_M[::-1])
    check_line(read(tmp_path / "l.dt1", "dt1"), counts()[::-1])
    check_line(read(tmp_path / "l.dt1", "dt1", spacing_m=SPACING_M), counts()[::-1])
    write_dzt(tmp_path / "l.dzt", spm=-1.0 / SPACING_M)
    found = read(tmp_path / "l.dzt", "dzt")
    check_line(found.assign_coords(x=found.x - found.x[0]), counts()[::-1] / 2.0**15)


@pytest.mark.parametrize("ending", [".rd3", ".RD7"])
def test_a_mala_file_is_read_with_its_header_beside_it(tmp_path, ending):
    write_rd3(tmp_path / f"l{ending}")
    bits = 16 if ending == ".rd3" else 32
    for name in (f"l{ending}", "l.rad"):
        found = read(tmp_path / name, "rd3", time_zero_s=1e-9)
        check_line(found, counts(bits) / 2.0 ** (bits - 1))
        assert found.attrs["antenna_separation_m"] == 0.06
        assert found.attrs["antenna_delay_s"] == 1e-9


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("code", [1, 2, 3, 5, 8])
def test_segy_of_others_is_read_as_obspy_reads_it(tmp_path, code, order):
    values = counts(8) * (0.37 if code in (1, 5) else 1.0)
    write_segy(tmp_path / "l.sgy", code, order, values, ebcdic=order == ">")
    found = read(tmp_path / "l.sgy", "segy")
    check_line(found, values, 200e-12)
    assert "picoseconds are assumed" in str(found.attrs["notes"])
    if code != 8:
        others = [one.data for one in _read_segy(str(tmp_path / "l.sgy")).traces]
        same = found.a_scan.values[0, 0].real.astype("f4")
        np.testing.assert_array_equal(same, np.array(others, "f4"))
    given = read(tmp_path / "l.sgy", "segy", interval_s=50e-12)
    assert float(given.delay[1]) == pytest.approx(50e-12)
    assert "assumed" not in str(given.attrs["notes"])


def test_ibm_floats_with_a_leading_zero_digit_are_right(tmp_path):
    # Of a file that ARAM24 recorded; segyio 1.9.14 reads the first as -9.32e-12.
    stored = np.array([[0xB80480CC, 0x3809BD34]], "u4")
    write_segy(
        tmp_path / "l.sgy", 2, values=stored.astype("i8") - (stored >> 31).astype("i8") * 2**32
    )
    content = bytearray((tmp_path / "l.sgy").read_bytes())
    content[3225] = 1
    (tmp_path / "l.sgy").write_bytes(content)
    found = read(tmp_path / "l.sgy", "segy").a_scan.values.ravel().real
    np.testing.assert_allclose(found, [-4.095557226690971e-12, 8.857636846215655e-12], rtol=1e-15)


def test_segy_says_where_source_and_receiver_are_and_what_is_dead(tmp_path):
    apart = {"b73": 20 * np.arange(TRACES) - 30, "b81": 20 * np.arange(TRACES) + 30}
    write_segy(tmp_path / "l.sgy", b29=[1, 1, 2, 1, 1, 1], **apart)
    found = read(tmp_path / "l.sgy", "segy")
    np.testing.assert_allclose(found.x, X_M, atol=1e-12)
    assert found.attrs["antenna_separation_m"] == pytest.approx(0.06)
    assert len(found.attrs["missing"]) == 1
    none = {"b73": 0, "b81": 0}
    write_segy(tmp_path / "c.sgy", b181=20 * np.arange(TRACES), **none)
    np.testing.assert_allclose(read(tmp_path / "c.sgy", "segy").x, X_M, atol=1e-12)
    grid = {"b73": [0, 20, 0, 20, 0, 20], "b77": [0, 0, 40, 40, 80, 80]}
    write_segy(tmp_path / "g.sgy", b81=grid["b73"], b85=grid["b77"], **grid)
    assert read(tmp_path / "g.sgy", "segy").a_scan.shape[:3] == (1, 3, 2)


def test_extended_headers_of_segy_are_skipped_and_garbage_of_old_files_is_not_one(tmp_path):
    write_segy(tmp_path / "l.sgy", b3501=0x0100, b3505=1)
    content = (tmp_path / "l.sgy").read_bytes()
    (tmp_path / "l.sgy").write_bytes(content[:3600] + bytes(3200) + content[3600:])
    check_line(read(tmp_path / "l.sgy", "segy"), counts(8), 200e-12)
    write_segy(tmp_path / "old.sgy", b3501=0x4020, b3505=0x4020)
    check_line(read(tmp_path / "old.sgy", "segy"), counts(8), 200e-12)


@pytest.mark.parametrize("form", ["RI", "MA", "DB"])
@pytest.mark.parametrize("unit", ["Hz", "GHz"])
def test_a_folder_of_touchstone_files_has_its_places_in_their_names(tmp_path, form, unit):
    names = ["p3_X0_Y10.5_Z90.s2p", "p1_X20.25_Y10.5_Z90.s2p"]
    write_touchstone(tmp_path / "t", names, form, unit)
    found = read(tmp_path / "t", "touchstone")
    assert found.polarization.values.tolist() == [90.0]
    np.testing.assert_allclose(found.x, [0.0, 0.02025])
    np.testing.assert_allclose(found.y, [0.0105])
    echo = np.exp(-2j * np.pi * np.linspace(1e9, 2e9, 11) * 1e-9)
    np.testing.assert_allclose(found.s21.values[0, 0], [0.1 * echo, 0.2 * echo], atol=1e-9)


def test_places_in_names_of_touchstone_files_are_ordered_as_numbers(tmp_path):
    write_touchstone(tmp_path / "t", ["X-20.s2p", "x-40_y0.s2p", "x20,5_y0.s2p", "X0.s2p"])
    found = read(tmp_path / "t", "touchstone")
    np.testing.assert_allclose(found.x, [-0.04, -0.02, 0.0, 0.0205])
    np.testing.assert_allclose(np.abs(found.s21.values[0, 0, :, 0]), [0.2, 0.1, 0.4, 0.3])


def test_touchstone_files_without_places_are_a_line_in_the_order_of_their_numbers(tmp_path):
    write_touchstone(tmp_path / "t", ["scan2.S1P", "scan10.S1P", "scan1.S1P"])
    with raises_fault(NOT_ALLOWED, "scan1.S1P", "--spacing"):
        read(tmp_path / "t", "touchstone")
    found = read(tmp_path / "t", "touchstone", spacing_m=0.05, separation_m=0.0)
    np.testing.assert_allclose(found.x, [0.0, 0.05, 0.1])
    np.testing.assert_allclose(np.abs(found.s21.values[0, 0, :, 0]), [0.3, 0.1, 0.2])


@pytest.mark.parametrize(("steps", "y_m"), [((10, 0, 0), 0.0), ((0, 5, 0), 0.01)])
def test_a_merged_file_of_gprmax_has_the_steps_of_its_receiver(tmp_path, steps, y_m):
    write_merged(tmp_path / "m.h5", steps=steps)
    command = ["import", str(tmp_path / "m.h5"), str(tmp_path / "o.nc"), "--format", "gprmax"]
    assert main([*command, *RICKER, "--band", "1e9", "2e9", "11", "--separation", "0.04"]) == 0
    found = load_survey(tmp_path / "o.nc")
    assert found.polarization.values.tolist() == [90.0] and found.attrs["simulated"] == 1
    axis = found.x if steps[0] else found.y
    np.testing.assert_allclose(axis, np.arange(TRACES) * (y_m or SPACING_M))
    assert found.attrs["antenna_separation_m"] == 0.04
    given = read(tmp_path / "m.h5", "gprmax", **SPECTRA, spacing_m=0.1)
    np.testing.assert_allclose(given.x, np.arange(TRACES) * 0.1)
    write_merged(tmp_path / "3.out", steps=None)
    with raises_fault(NOT_ALLOWED, "3.out", "--spacing"):
        read(tmp_path / "3.out", "gprmax", **SPECTRA)


def test_the_bars_of_a_real_line_are_found_in_its_dzt_file(tmp_path, capsys):
    path, output = tmp_path / "Lab_specimen_data.DZT", tmp_path / "line.nc"
    with np.load(REAL_LINE_FILE) as stored:  # see benchmarks/worlds/data/README.md
        values, bars_m = np.rint(stored["a_scans"].astype(np.float64) * 2**15), stored["rebar_x_m"]
    write_dzt(path, [values.astype(int)], spm=118.110, epsr=7.0)
    assert path.stat().st_size == 340992
    scans = read(path, "dzt").a_scan
    np.testing.assert_array_equal(scans.values[0, 0, :, 2:].real * 2**15, values[:, 2:])
    assert float(scans.delay[1]) == pytest.approx(8e-9 / 512)
    assert float(scans.x[-1]) == pytest.approx(2.802, abs=1e-3)
    # Not recorded, and assumed: antennas at 10 mm, 60 mm apart, time zero at the first peak.
    known = ["--time-zero", "1.98", "--separation", "0.06", "--height", "0.01"]
    band = ["--band", "0.5e9", "3e9", "21"]
    assert main(["import", str(path), str(output), "--format", "dzt", *known, *band]) == 0
    capsys.readouterr()
    assert main(["candidates", str(output), "--permittivity", "6", "--json"]) == 0
    candidates = json.loads(capsys.readouterr().out)["candidates"]
    places_m = np.array([one["x_m"] for one in candidates if not one["doubtful"]])
    away_m = np.abs(places_m[:, None] - bars_m)
    # One, at the end of the line, is a weaker echo.
    assert np.count_nonzero(away_m.min(axis=0) < BAR_M) >= 13
    assert np.count_nonzero(away_m[:14].min(axis=1) < BAR_M) >= 12


@pytest.mark.parametrize("form", KINDS)
def test_the_files_are_recognized(tmp_path, form):
    name, write, *_ = KINDS[form]
    # Instruments write capital letters, gprMax small ones.
    path = tmp_path / (name if form == "gprmax" else name.upper())
    write(path)
    with raises_fault(faults.INPUT, f"--format {form}"):
        load_survey(path)


@pytest.mark.parametrize(
    ("form", "options", "shown"),
    [
        ("dzt", {"interval_s": 1e-12}, "--interval"),
        ("segy", {"source": "none"}, "--source"),
        ("group-csv", {"height_m": 0.1}, "--height"),
    ],
)
def test_an_option_that_a_format_cannot_use_is_refused(tmp_path, form, options, shown):
    with raises_fault(NOT_ALLOWED, form, shown):
        import_survey(tmp_path, form, **options)
