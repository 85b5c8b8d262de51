"""Files that others made are read with their meaning, their times and their places, or refused."""

import os
import shutil
import subprocess
from pathlib import Path

import h5py
import instruments_kit as kit
import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_analysis import errors
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.common import to_frequency
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.formats.imports import import_survey
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.plotting.scans import until
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.replay import describe
from gpr20_common.faults import NOT_ALLOWED

DATA = Path(__file__).parent / "data"
# File, format, options, traces x samples, last place [m], step [ns], time zero [ns], separation [m]
READ = [
    ("comma.rd3", "rd3", {}, (8, 200), 0.35, 1e3 / 2426.187744, None, 0.18),
    ("tag0700.DZT", "dzt", {}, (12, 256), 0.22, 50.0 / 256, None, None),
    ("line.DT1", "dt1", {}, (20, 425), 4.75, 0.8, (61.63 - 1) * 0.8, 1.0),
    ("a.DT1", "dt1", {}, (8, 200), 1.75, 0.8, 24 * 0.8, 1.0),
    ("b.rd3", "rd3", {}, (8, 200), 0.35, 1e3 / 2426.187744, None, 0.18),
    ("z_standard.sgy", "segy", {"spacing_m": 0.02}, (4, 391), 0.06, 7.70333e-3, None, None),
    ("stale.sgy", "segy", {"spacing_m": 0.05}, (30, 200), 1.45, 0.1, None, None),
    ("sir4000.DZT", "dzt", {}, (6, 512), None, 2300.0 / 512, 230.0, None),
    ("ekko.DT1", "dt1", {}, (12, 425), 2.75, 0.8, 135 * 0.8, 1.0),
]


@each_case("name, form, options, shape, last_m, step_ns, zero_ns, separation_m", READ)
def test_a_file_of_others_has_the_right_places_times_and_distances(
    name, form, options, shape, last_m, step_ns, zero_ns, separation_m
):
    found = kit.read(DATA / name, form, **options)
    assert found.a_scan.shape[2:] == shape
    assert last_m is None or float(found.x[-1] - found.x[0]) == pytest.approx(last_m, abs=1e-6)
    assert float(found.delay[1]) * 1e9 == pytest.approx(step_ns, rel=1e-5)
    recorded = found.attrs.get("antenna_delay_s"), found.attrs.get("antenna_separation_m")
    assert recorded[0] == (None if zero_ns is None else pytest.approx(zero_ns * 1e-9, rel=1e-5))
    assert recorded[1] == separation_m
    notes = str(found.attrs["notes"])
    assert ("not record its time zero" in notes) == (zero_ns is None)
    assert ("not record the distance" in notes) == (separation_m is None)


def test_a_time_zero_late_in_the_record_is_removed_by_an_image():
    found = to_frequency(kit.read(DATA / "sir4000.DZT", "dzt", separation_m=0.2, height_m=0.1))
    options = ImageOptions(permittivity=6.0, depth_m=(0.5, 1.0))
    assert np.isfinite(image_survey(found, options).image.values).all()


@each_case("name, beside", [("a.DT1", "a.GPS"), ("b.rd3", "b.cor")])
def test_places_in_files_beside_it_are_named(name, beside):
    form = "dt1" if name.endswith("DT1") else "rd3"
    assert f"{beside} is not read" in str(kit.read(DATA / name, form).attrs["notes"])


def test_a_figure_of_a_line_shows_what_comes_after_its_time_zero():
    found = until(kit.read(DATA / "line.DT1", "dt1"))
    assert 55e-9 < float(found.delay[-1]) < 60e-9


def test_a_file_of_the_current_folder_is_refused_with_the_name_of_its_folder(tmp_path, monkeypatch):
    kit.write_touchstone(tmp_path / "probe", ["z.s2p"])
    monkeypatch.chdir(tmp_path / "probe")
    for named in ("z.s2p", "."):
        with raises_fault(NOT_ALLOWED, "probe: the name z.s2p has no place"):
            import_survey(named, "touchstone")


def test_a_line_whose_antennas_move_apart_is_refused(tmp_path):
    with raises_fault(errors.INPUT, "SURVEY MODE", "CMP/WARR"):
        kit.read(DATA / "cmp.DT1", "dt1")
    places = 20 * np.arange(kit.TRACES)
    kit.write_segy(tmp_path / "warr.sgy", b73=7, b81=places + 20)
    with raises_fault(errors.INPUT, "constant separation", "0.013", "0.113"):
        kit.read(tmp_path / "warr.sgy", "segy")
    kit.write_merged(tmp_path / "m.h5", srcsteps=(0, 0, 0))
    with raises_fault(errors.INPUT, "#src_steps"):
        kit.read(tmp_path / "m.h5", "gprmax", **kit.SPECTRA)


def test_a_second_channel_is_read_by_its_own_header(tmp_path):
    channels = [kit.counts(seed=seed) for seed in (1, 2)]
    own = {"position": -2.5, "range": 20.0, "antenna": b"400MHz", "gains": (0.0, 40.0)}
    kit.write_dzt(tmp_path / "a.dzt", channels, position=-1.0, second=own)
    first, second = (kit.read(tmp_path / "a.dzt", "dzt", channel=one) for one in (1, 2))
    for found, zero_ns, range_ns in ((first, 1.0, 8.0), (second, 2.5, 20.0)):
        assert found.attrs["antenna_delay_s"] == pytest.approx(zero_ns * 1e-9)
        assert float(found.delay[1]) == pytest.approx(range_ns * 1e-9 / kit.counts().shape[1])
    assert "400MHz" in str(second.attrs["notes"]) and "0 to 40 dB" in str(second.attrs["notes"])
    assert "1.5/1.6GH" in str(first.attrs["notes"]) and "dB" not in str(first.attrs["notes"])
    kit.write_dzt(tmp_path / "a.dzt", channels, data=2048)
    for number, values in enumerate(channels):
        found = kit.read(tmp_path / "a.dzt", "dzt", channel=number + 1).a_scan.values[0, 0]
        np.testing.assert_allclose(found.real, values / 2.0**15)
    for channel in (None, 0, 3):
        with raises_fault(NOT_ALLOWED, "2 channels", "--channel"):
            kit.read(tmp_path / "a.dzt", "dzt", channel=channel)
    for wrong in ({"spm": 10.0}, {"samples": 39}, {"bits": 8}, {"channels": 3}, {"tag": 0}):
        kit.write_dzt(tmp_path / "w.dzt", channels, second=wrong)
        with raises_fault(errors.INPUT, "w.dzt"):
            kit.read(tmp_path / "w.dzt", "dzt", channel=2)
    (tmp_path / "none.dzt").write_bytes(kit.channel_header(data=1, channels=2) + bytes(4 * 80 * 6))
    with raises_fault(errors.INPUT, "rh_data"):
        kit.read(tmp_path / "none.dzt", "dzt", channel=2)


@each_case("zero", ["0", "missing"])
def test_a_time_zero_that_nobody_set_is_not_recorded(tmp_path, zero):
    kit.write_dt1(tmp_path / "l.dt1", **{"TIMEZERO AT POINT": zero})
    if zero == "missing":
        header = tmp_path / "l.HD"
        lines = header.read_text().splitlines()
        header.write_text("\n".join(one for one in lines if "TIMEZERO" not in one))
    found = kit.read(tmp_path / "l.dt1", "dt1")
    assert "antenna_delay_s" not in found.attrs
    assert "does not record its time zero" in str(found.attrs["notes"])


def test_a_name_in_other_capitals_is_that_of_another_line_if_that_has_its_own_file(tmp_path):
    kit.write_dt1(tmp_path / "line1.dt1")
    (tmp_path / "line1.HD").rename(tmp_path / "LINE1.HD")
    assert kit.read(tmp_path / "line1.dt1", "dt1").sizes["x"] == kit.TRACES
    (tmp_path / "LINE1.DT1").write_bytes((tmp_path / "line1.dt1").read_bytes())
    with raises_fault(errors.INPUT, "line1.hd", "there are: -"):
        kit.read(tmp_path / "line1.dt1", "dt1")
    kit.write_dt1(tmp_path / "line1.dt1", **{"TIMEZERO AT POINT": "9"})  # exact name, other header
    assert kit.read(tmp_path / "line1.dt1", "dt1").attrs["antenna_delay_s"] == pytest.approx(1.6e-9)
    assert kit.read(tmp_path / "LINE1.DT1", "dt1").attrs["antenna_delay_s"] == pytest.approx(0.5e-9)
    shutil.copy(tmp_path / "line1.HD", tmp_path / "line1.hd")
    with raises_fault(errors.INPUT, "line1.HD", "line1.hd"):
        kit.read(tmp_path / "line1.dt1", "dt1")


@each_case("form, key", [("dt1", "NUMBER OF TRACES"), ("rd3", "LAST TRACE")])
def test_the_size_of_a_file_decides_how_many_traces_it_has(tmp_path, form, key):
    write = {"dt1": kit.write_dt1, "rd3": kit.write_rd3}[form]
    write(tmp_path / f"l.{form}", **{key: kit.TRACES + 3})
    found = kit.read(tmp_path / f"l.{form}", form)
    assert found.sizes["x"] == kit.TRACES
    assert f"says {kit.TRACES + 3} traces ({key}), but {kit.TRACES} are stored" in str(
        found.attrs["notes"]
    )


@each_case("order", "<>")
def test_the_size_of_a_segy_file_decides_which_header_counts_its_samples(tmp_path, order):
    kit.write_segy(tmp_path / "l.sgy", order=order, b3221=39)
    found = kit.read(tmp_path / "l.sgy", "segy")
    assert found.sizes["delay"] == 40 and "39 and 40 samples" in str(found.attrs["notes"])


def test_a_trace_whose_time_zero_was_moved_is_refused(tmp_path):
    kit.write_dt1(tmp_path / "l.dt1", moved=[2])
    with raises_fault(errors.INPUT, "TIMEZERO ADJUSTMENT"):
        kit.read(tmp_path / "l.dt1", "dt1")


@each_case("code, shown", [(2, ""), (3, ""), (4, "trace identification code"), (-1, "")])
def test_segy_traces_that_show_no_ground_are_missing_or_refused(tmp_path, code, shown):
    kit.write_segy(tmp_path / "l.sgy", b29=[1, 1, code, 1, 1, 1])
    if shown:
        with raises_fault(errors.INPUT, shown, str(code)):
            kit.read(tmp_path / "l.sgy", "segy")
    else:
        missing = kit.read(tmp_path / "l.sgy", "segy").attrs["missing"]
        assert len(missing) == (code in (2, 3))


@each_case("name, options", [("b1.h5", {}), ("b_merged.h5", {"source": "ricker:1.5e9"})])
def test_the_field_of_a_flat_model_is_that_across_its_line_at_its_own_places(name, options):
    found = kit.read(DATA / name, "gprmax", band=kit.SPECTRA["band"], **options)
    assert found.polarization.values.tolist() == [90.0] and found.y.values.tolist() == [0.0]
    count = 1 if name == "b1.h5" else 6
    np.testing.assert_allclose(found.x, 0.06 + np.arange(count) * kit.SPACING_M, atol=1e-9)
    assert found.attrs["antenna_separation_m"] == 0.04 and found.attrs["simulated"] == 1
    with h5py.File(DATA / name) as file:
        field = file["rxs/rx1/Ez"][()].reshape(637, -1)
    turns = np.exp(-2j * np.pi * np.outer(found.frequency, np.arange(637) * 4.717308673499368e-12))
    ratio = found.s21.values[0, 0] / (turns @ field).T  # the same source of all
    np.testing.assert_allclose(ratio, np.tile(ratio[0], (count, 1)), rtol=1e-9)


@pytest.mark.parametrize("form", ["dzt", "dt1", "rd3", "segy", "gprmax", "merged-hdf5", "arrays"])
def test_a_file_of_another_kind_is_never_called_damaged(tmp_path, form):
    ending = {"segy": ".sgy", "gprmax": ".h5", "merged-hdf5": ".h5", "arrays": ".npz"}
    path = tmp_path / f"photo{ending.get(form, f'.{form}')}"
    path.write_bytes(b"\xff\xd8\xff\xe0" + bytes(range(256)) * 40)
    for one in (".hd", ".rad"):
        path.with_suffix(one).write_bytes(path.read_bytes())
    with raises_fault(errors.INPUT, "is not a", error=AnalysisError):
        kit.read(path, form)


def test_names_that_are_no_utf_8_are_read_and_written(tmp_path):
    path = tmp_path / "l\udcff.dt1"
    kit.write_dt1(path)
    survey, image = tmp_path / "s\udcff.nc", tmp_path / "i\udcff.nc"
    assert main(["import", str(path), str(survey), "--format", "dt1", "--height", "0.1"]) == 0
    assert read_dataset(survey).attrs["source"] == "l\\xff.dt1"
    options = ["--permittivity", "6", "--depth", "0.02", "0.1", "0.01"]
    assert main(["image", str(survey), *options, "-o", str(image)]) == 0
    output = str(tmp_path / "p\udcff.nc")
    assert main(["process", str(survey), "-o", output, "--step", "background:method=mean"]) == 0
    assert main(["report", str(survey), "-o", str(tmp_path / "r\udcff.html")]) == 0
    assert main(["export", str(survey), str(tmp_path / "o\udcff.csv"), "--format", "csv"]) == 0
    folder = tmp_path / "d\udcff"
    assert main(["import", str(path), str(folder), "--format", "dt1"]) == 0
    (made,) = (one for one in folder.iterdir() if one.is_dir())
    assert main(["info", str(made)]) == 0


@each_case("name, topic", [("chatter.bag", "/chatter"), ("imu_ros1.mcap", "/imu/data")])
def test_a_recording_of_somebody_else_is_refused_with_its_topics(name, topic):
    for read_it in (load_survey, describe):
        with raises_fault(errors.INPUT, name, topic):
            read_it(DATA / name)
    assert main(["replay", str(DATA / name)]) == 3


def test_numbers_of_options_may_have_decimal_commas(tmp_path):
    kit.write_rd3(tmp_path / "l.rd3")
    output = tmp_path / "o.nc"
    given = ["--spacing", "5,5", "--time-zero", "0,5"]
    assert main(["import", str(tmp_path / "l.rd3"), str(output), "--format", "rd3", *given]) == 0
    found = read_dataset(output)
    np.testing.assert_allclose(found.x, np.arange(kit.TRACES) * 0.0055)
    assert found.attrs["antenna_delay_s"] == pytest.approx(0.5e-9)


@each_case("name", ["l.DZT", "a b;c.DZT", "it's.DZT", os.fsdecode(b"caf\xe9\\x41'.DZT")])
def test_the_command_that_is_advised_names_the_file_in_a_shell(tmp_path, name):
    kit.write_dzt(tmp_path / name)
    with pytest.raises(AnalysisError) as refused:
        load_survey(tmp_path / name)
    command = str(refused.value).partition("import it first: gpr20 import ")[2]
    shell = ["bash", "-c", f"printf '%s\\n' {command}"]
    first = subprocess.run(shell, capture_output=True, check=True).stdout.split(b"\n")[0]
    assert first == os.fsencode(tmp_path / name)


def test_a_file_that_is_no_folder_of_samples_is_refused_as_that(tmp_path):
    (tmp_path / "a.csv").write_text("x;y\n")
    with raises_fault(errors.INPUT, "a.csv contains no files VNA_"):
        import_survey(tmp_path / "a.csv", "group-csv")
