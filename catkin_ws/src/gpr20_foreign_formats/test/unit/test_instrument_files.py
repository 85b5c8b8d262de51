"""Lines of other instruments become surveys, with time zero, separation and spacing."""

import instruments_kit as kit
import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from obspy.io.segy.segy import _read_segy

from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample import REAL_LINE_FILE
from gpr20_common.faults import NOT_ALLOWED

X_M = np.arange(kit.TRACES) * kit.SPACING_M
STEP_S = kit.WINDOW_NS * 1e-9 / kit.SAMPLES


def check_line(found, values, step_s=STEP_S):
    np.testing.assert_allclose(found.a_scan.values[0, 0].real, values, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(found.x, X_M, atol=1e-9)
    np.testing.assert_allclose(found.delay, np.arange(values.shape[1]) * step_s, rtol=1e-6)
    assert found.polarization.values.tolist() == [0.0] and found.y.values.tolist() == [0.0]
    assert "simulated" not in found.attrs


@each_case("bits", [8, 16, 32])
def test_a_dzt_file_is_read_as_shares_of_its_full_scale(tmp_path, bits):
    kit.write_dzt(tmp_path / "later.dzt", position=0.8)
    found = kit.read(tmp_path / "later.dzt", "dzt")
    assert float(found.delay[0]) == pytest.approx(0.8e-9) and found.attrs["antenna_delay_s"] == 0.0
    kit.write_dzt(tmp_path / "line.DZT", bits=bits, position=-1.2)
    (tmp_path / "LINE.dzx").write_text("<DZX/>")
    found = kit.read(tmp_path / "line.DZT", "dzt", separation_m=0.06, height_m=0.01)
    check_line(found, kit.counts(bits) / 2.0 ** (bits - 1))
    assert found.attrs["antenna_delay_s"] == pytest.approx(1.2e-9)
    assert found.attrs["antenna_separation_m"] == 0.06
    assert (found.height == 0.01).all()
    assert "1.5/1.6GH" in str(found.attrs["notes"]) and "LINE.dzx" in str(found.attrs["notes"])


@each_case("kind, unit, unit_m", [("<i2", "m", 1.0), ("<f4", "ft", 0.3048)])
def test_a_dt1_file_is_read_with_its_header_beside_it(tmp_path, kind, unit, unit_m):
    kit.write_dt1(tmp_path / f"{unit}.DT1", kind, x=X_M / unit_m, unit=unit, dead=[2])
    for name in (f"{unit}.DT1", f"{unit}.HD"):
        found = kit.read(tmp_path / name, "dt1")
        own = kit.counts().astype(float)
        own[2] = np.nan
        check_line(found, own)
        assert len(found.attrs["missing"]) == 1
        assert found.attrs["antenna_delay_s"] == pytest.approx(2.5 * STEP_S)
        assert found.attrs["antenna_separation_m"] == pytest.approx(0.05 * unit_m)


def test_a_line_that_was_driven_backwards_is_read_from_its_other_end(tmp_path):
    kit.write_dt1(tmp_path / "l.dt1", x=X_M[::-1])
    check_line(kit.read(tmp_path / "l.dt1", "dt1"), kit.counts()[::-1])
    check_line(kit.read(tmp_path / "l.dt1", "dt1", spacing_m=kit.SPACING_M), kit.counts()[::-1])
    kit.write_dzt(tmp_path / "l.dzt", spm=-1.0 / kit.SPACING_M)
    found = kit.read(tmp_path / "l.dzt", "dzt")
    check_line(found.assign_coords(x=found.x - found.x[0]), kit.counts()[::-1] / 2.0**15)


@each_case("ending", [".rd3", ".RD7"])
def test_a_mala_file_is_read_with_its_header_beside_it(tmp_path, ending):
    kit.write_rd3(tmp_path / f"{ending[1:]}{ending}")
    bits = 16 if ending == ".rd3" else 32
    for name in (f"{ending[1:]}{ending}", f"{ending[1:]}.rad"):
        found = kit.read(tmp_path / name, "rd3", time_zero_s=1e-9)
        check_line(found, kit.counts(bits) / 2.0 ** (bits - 1))
        assert found.attrs["antenna_separation_m"] == 0.06
        assert found.attrs["antenna_delay_s"] == 1e-9


@each_case("code, order", [(code, order) for code in (1, 2, 3, 5, 8) for order in "<>"])
def test_segy_of_others_is_read_as_obspy_reads_it(tmp_path, code, order):
    values = kit.counts(8) * (0.37 if code in (1, 5) else 1.0)
    kit.write_segy(tmp_path / "l.sgy", code, order, values, ebcdic=order == ">")
    found = kit.read(tmp_path / "l.sgy", "segy")
    check_line(found, values, 200e-12)
    assert "ps is assumed" in str(found.attrs["notes"])
    if code != 8:
        others = [one.data for one in _read_segy(str(tmp_path / "l.sgy")).traces]
        same = found.a_scan.values[0, 0].real.astype("f4")
        np.testing.assert_array_equal(same, np.array(others, "f4"))
    given = kit.read(tmp_path / "l.sgy", "segy", interval_s=50e-12)
    assert float(given.delay[1]) == pytest.approx(50e-12)
    assert "assumed" not in str(given.attrs["notes"])


def test_ibm_floats_with_a_leading_zero_digit_are_right(tmp_path):
    # Of a file that ARAM24 recorded; segyio 1.9.14 reads the first as -9.32e-12.
    stored = np.array([[0xB80480CC, 0x3809BD34]], "u4")
    kit.write_segy(
        tmp_path / "l.sgy", 2, values=stored.astype("i8") - (stored >> 31).astype("i8") * 2**32
    )
    content = bytearray((tmp_path / "l.sgy").read_bytes())
    content[3225] = 1
    (tmp_path / "l.sgy").write_bytes(content)
    found = kit.read(tmp_path / "l.sgy", "segy").a_scan.values.ravel().real
    np.testing.assert_allclose(found, [-4.095557226690971e-12, 8.857636846215655e-12], rtol=1e-15)


def test_segy_says_where_source_and_receiver_are_and_what_is_dead(tmp_path):
    apart = {"b73": 20 * np.arange(kit.TRACES) - 30, "b81": 20 * np.arange(kit.TRACES) + 30}
    kit.write_segy(tmp_path / "l.sgy", b29=[1, 1, 2, 1, 1, 1], **apart)
    found = kit.read(tmp_path / "l.sgy", "segy")
    np.testing.assert_allclose(found.x, X_M, atol=1e-12)
    assert found.attrs["antenna_separation_m"] == pytest.approx(0.06)
    assert len(found.attrs["missing"]) == 1
    none = {"b73": 0, "b81": 0}
    kit.write_segy(tmp_path / "c.sgy", b181=20 * np.arange(kit.TRACES), **none)
    np.testing.assert_allclose(kit.read(tmp_path / "c.sgy", "segy").x, X_M, atol=1e-12)
    grid = {"b73": [0, 20, 0, 20, 0, 20], "b77": [0, 0, 40, 40, 80, 80]}
    kit.write_segy(tmp_path / "g.sgy", b81=grid["b73"], b85=grid["b77"], **grid)
    assert kit.read(tmp_path / "g.sgy", "segy").a_scan.shape[:3] == (1, 3, 2)


def test_extended_headers_of_segy_are_skipped_and_garbage_of_old_files_is_not_one(tmp_path):
    kit.write_segy(tmp_path / "l.sgy", b3501=0x0100, b3505=1)
    content = (tmp_path / "l.sgy").read_bytes()
    (tmp_path / "l.sgy").write_bytes(content[:3600] + bytes(3200) + content[3600:])
    check_line(kit.read(tmp_path / "l.sgy", "segy"), kit.counts(8), 200e-12)
    kit.write_segy(tmp_path / "old.sgy", b3501=0x4020, b3505=0x4020)
    check_line(kit.read(tmp_path / "old.sgy", "segy"), kit.counts(8), 200e-12)


@each_case("form, unit", [("RI", "GHz"), ("MA", "MHz"), ("DB", "Hz")])
def test_a_folder_of_touchstone_files_has_its_places_in_their_names(tmp_path, form, unit):
    names = ["p3_X0_Y10.5_Z90.s2p", "p1_X20.25_Y10.5_Z90.s2p"]
    kit.write_touchstone(tmp_path / "t", names, form, unit)
    found = kit.read(tmp_path / "t", "touchstone")
    assert found.polarization.values.tolist() == [90.0]
    np.testing.assert_allclose(found.x, [0.0, 0.02025])
    np.testing.assert_allclose(found.y, [0.0105])
    echo = np.exp(-2j * np.pi * np.linspace(1e9, 2e9, 11) * 1e-9)
    np.testing.assert_allclose(found.s21.values[0, 0], [0.1 * echo, 0.2 * echo], atol=1e-9)


def test_places_and_files_of_touchstone_are_ordered_as_numbers(tmp_path):
    kit.write_touchstone(tmp_path / "t", ["X-20.s2p", "x-40_y0.s2p", "x20,5_y0.s2p", "X0.s2p"])
    found = kit.read(tmp_path / "t", "touchstone")
    np.testing.assert_allclose(found.x, [-0.04, -0.02, 0.0, 0.0205])
    np.testing.assert_allclose(np.abs(found.s21.values[0, 0, :, 0]), [0.2, 0.1, 0.4, 0.3])
    kit.write_touchstone(tmp_path / "line", ["scan2.S1P", "scan10.S1P", "scan1.S1P"])
    with raises_fault(NOT_ALLOWED, "scan1.S1P", "--spacing"):
        kit.read(tmp_path / "line", "touchstone")
    found = kit.read(tmp_path / "line", "touchstone", spacing_m=0.05, separation_m=0.0)
    np.testing.assert_allclose(found.x, [0.0, 0.05, 0.1])
    np.testing.assert_allclose(np.abs(found.s21.values[0, 0, :, 0]), [0.3, 0.1, 0.2])


@each_case("steps, y_m", [((10, 0, 0), 0.0), ((0, 5, 0), 0.01)])
def test_a_merged_file_of_gprmax_has_the_steps_of_its_receiver(tmp_path, steps, y_m):
    kit.write_merged(tmp_path / "m.h5", steps=steps)
    command = ["import", str(tmp_path / "m.h5"), str(tmp_path / f"{y_m}.nc"), "--format", "gprmax"]
    assert main([*command, *kit.RICKER, "--band", "1e9", "2e9", "11", "--separation", "0.04"]) == 0
    found = load_survey(tmp_path / f"{y_m}.nc")
    assert found.polarization.values.tolist() == [90.0] and found.attrs["simulated"] == 1
    axis = found.x if steps[0] else found.y
    np.testing.assert_allclose(axis, np.arange(kit.TRACES) * (y_m or kit.SPACING_M))
    assert found.attrs["antenna_separation_m"] == 0.04
    given = kit.read(tmp_path / "m.h5", "gprmax", **kit.SPECTRA, spacing_m=0.1)
    np.testing.assert_allclose(given.x, np.arange(kit.TRACES) * 0.1)
    kit.write_merged(tmp_path / "3.out", steps=None)
    with raises_fault(NOT_ALLOWED, "3.out", "--spacing"):
        kit.read(tmp_path / "3.out", "gprmax", **kit.SPECTRA)


def test_a_real_line_is_the_same_in_its_dzt_file(tmp_path):
    path = tmp_path / "Lab_specimen_data.DZT"
    with np.load(REAL_LINE_FILE) as stored:  # see benchmarks/worlds/data/README.md
        values = np.rint(stored["a_scans"].astype(np.float64) * 2**15)
    kit.write_dzt(path, [values.astype(int)], spm=118.110, epsr=7.0)
    assert path.stat().st_size == 340992
    scans = kit.read(path, "dzt").a_scan
    np.testing.assert_array_equal(scans.values[0, 0, :, 2:].real * 2**15, values[:, 2:])
    assert float(scans.delay[1]) == pytest.approx(8e-9 / 512)
    assert float(scans.x[-1]) == pytest.approx(2.802, abs=1e-3)
