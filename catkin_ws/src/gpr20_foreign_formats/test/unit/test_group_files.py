"""Files of the group and of the original project arrive as they are, with what was decided."""

import json
import math
import subprocess

import h5py
import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from foreign_formats_kit import PACKAGE, added, additions_of_catkin
from ground_kit import point, scene, survey_of
from group_kit import (
    HZ,
    decisions_of,
    even,
    imported,
    originals,
    run,
    survey,
    write_csv,
    write_merged,
    write_originals,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.entry_points import additions
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.formats.imported_folder import SOURCES_FILE
from gpr20_analysis.formats.imports import IMPORTS
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.sentences import DECISIONS
from gpr20_survey.radar.frequency_to_delay import Window

FORMS = {"group-csv": write_csv, "original-json": lambda folder, found: write_originals(
    folder, originals(found)), "merged-hdf5": write_merged}  # fmt: skip


def same(found, samples, tolerance=0.0):
    assert int((found.quality.values & 3 == 0).sum()) == len(samples)
    for (x_mm, y_mm, turn), (height_m, values) in samples.items():
        own = found.sel(polarization=turn).sel(x=x_mm / 1e3, y=y_mm / 1e3, method="nearest")
        assert (float(own.x) * 1e3, float(own.y) * 1e3) == pytest.approx((x_mm, y_mm), abs=1e-9)
        np.testing.assert_allclose(own.s21.values, values, atol=tolerance)
        np.testing.assert_allclose(float(own.height), height_m, rtol=1e-12)
    np.testing.assert_allclose(found.frequency.values, HZ, rtol=1e-12)


@settings(max_examples=draws(6))
@given(form=st.sampled_from(sorted(FORMS)), seed=st.integers(0, 1 << 32), matlab=st.booleans())
def test_every_number_arrives_and_the_log_says_what_was_decided(
    form, seed, matlab, tmp_path_factory
):
    place, samples = tmp_path_factory.mktemp("group"), survey(seed)
    source = place / ("m.h5" if form == "merged-hdf5" else "scans")
    if form == "merged-hdf5":
        samples = even(samples)
        write_merged(source, samples, as_matlab=matlab)
    else:
        samples.pop(next(iter(samples))) if matlab else None
        FORMS[form](source, samples)
    folder = imported(source, form, place / "data")
    found, decided = load_survey(folder), decisions_of(folder)
    same(found, samples, 1e-7 if form == "merged-hdf5" else 0.0)
    assert found.attrs[DECISIONS] == decided and "simulated" not in found.attrs
    for word in ("mm" if form != "merged-hdf5" else "metres", "rotation", "phase"):
        assert word in " ".join(decided)
    status, printed = run("info", folder)
    assert status in (0, 1) and all(f"decided: {one}" in printed for one in decided)
    entry = json.loads((folder / "survey.json").read_text("ascii"))["imported"]
    assert (entry["source"], entry["format"]) == (source.name, form)
    assert entry.get("survey_id") == ("6d0c" if form == "original-json" else None)
    verified = verify_survey(folder)
    assert verified.faults == [] and verified.stored == len(samples)
    inside = str(source if source.is_dir() else place)
    sums = ["sha256sum", "--strict", "--quiet", "-c", str(folder / SOURCES_FILE)]
    assert subprocess.run(sums, cwd=inside).returncode == 0


def test_times_of_the_original_are_utc_and_its_constant_is_no_height(tmp_path):
    hz = np.linspace(600e6, 6e9, 101)
    found = originals(even(survey(3, hz=hz)), hz, antennae_height=10.0)
    source = write_originals(tmp_path / "scans", found)
    folder = imported(source, "original-json", tmp_path / "data", "--height", "0.2")
    decided, survey_there = " ".join(decisions_of(folder)), load_survey(folder)
    assert "constant of the original control" in decided and "have 0.2 m, as the user" in decided
    assert set(survey_there.height.values[np.isfinite(survey_there.height.values)]) == {0.2}
    assert str(survey_there.timestamp.values.min())[:19] == "2021-10-15T08:00:00"
    options = ImageOptions(permittivity=4.0, leave_out_missing=True)
    assert np.isfinite(image_survey(survey_there, options).image.values).any()
    next(iter(found.values()))["timestamp"] = "19700101000000"
    early = imported(write_originals(source, found), "original-json", tmp_path / "early")
    assert "not from 2020 on" in " ".join(decisions_of(early))


@each_case("form", FORMS)
def test_a_copied_imaginary_part_is_named_and_never_imaged(form, tmp_path):
    samples = even(survey(1))
    samples = {key: (height, one.real * (1 + 1j)) for key, (height, one) in samples.items()}
    source = tmp_path / f"{form}.h5"
    FORMS[form](source, samples)
    output = tmp_path / f"{form}.nc"
    status, printed = run("import", source, output, "--format", form)
    assert status == 0 and "copy of the real part" in printed
    same(read_dataset(output), samples, 1e-7)
    with raises_fault(faults.STEPS, "copy of the real part"):
        image_survey(read_dataset(output), ImageOptions(permittivity=4.0))


def test_the_command_may_say_that_the_ground_is_real(tmp_path):
    source = write_csv(tmp_path / "real", survey(2))
    found = load_survey(imported(source, "group-csv", tmp_path / "data", "--real-ground"))
    assert found.attrs["simulated"] == 0


STEP_MM, HEIGHT_M, TARGET = 16.0, 0.2, (233.0, 247.0, 0.1)
PLACES_MM = np.arange(160.0, 321.0, STEP_MM)
SWEEP_HZ = np.linspace(600e6, 6e9, 201)


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


@pytest.fixture(scope="module")
def ground():
    """A survey over a target, and its A-scans by the group's transform, with their times."""
    one = scene([point(*TARGET)], 4.0, height_m=HEIGHT_M)
    found = survey_of(one, PLACES_MM, PLACES_MM, SWEEP_HZ, (0.0,))
    scans, delay_s = {}, None
    for row, column in np.ndindex(*found.s21.shape[1:3]):
        a_scan, delay_s = group_transform(found.s21.values[0, row, column], SWEEP_HZ)
        place = (int(PLACES_MM[column]), int(PLACES_MM[row]), 0.0)
        scans[place] = (HEIGHT_M, a_scan)
    return found, scans, delay_s


def times(folder, delay_s):
    (folder / "time").write_text("".join(f"{one}\n" for one in ["Time", *delay_s.tolist()]))


@each_case("with_times", [True, False])
def test_a_scans_of_the_groups_transform_are_imaged(ground, tmp_path, with_times):
    _, scans, delay_s = ground
    source, output = tmp_path / f"{with_times}", tmp_path / f"{with_times}.nc"
    write_csv(source, scans, "TIME", f"Ts0u_Te{round(delay_s[-1] * 1e6, 4)}u")
    if with_times:
        times(source, delay_s)
    status, printed = run("import", source, output, "--format", "group-csv")
    assert status == 0 and "was taken from the spectra" in printed
    assert ("there is no file 'time'" in printed) is not with_times
    options = ImageOptions(permittivity=4.0, depth_m=tuple(np.arange(0.05, 0.15, 0.001)))
    image = image_survey(read_dataset(output), options)
    best = np.unravel_index(np.argmax(np.abs(image.image.values[0])), image.image.shape[1:])
    x_mm, y_mm = PLACES_MM[best[2]], PLACES_MM[best[1]]
    assert abs(x_mm - TARGET[0]) <= STEP_MM and abs(y_mm - TARGET[1]) <= STEP_MM
    assert abs(float(image.depth[best[0]]) - TARGET[2]) <= 0.005


def test_times_that_do_not_fit_the_names_are_refused(ground, tmp_path):
    _, scans, delay_s = ground
    source = write_csv(tmp_path / "t", scans, "TIME", f"Ts0u_Te{round(delay_s[-1] * 1e6, 4)}u")
    jump = delay_s.copy()
    jump[5] = 1e-9
    for wrong in (delay_s[:-1], jump, delay_s * 1.1):
        times(source, wrong)
        with raises_fault(faults.INPUT, "time"):
            IMPORTS.find("group-csv").read(source, None, lambda items, _: items)
    write_csv(source, survey())
    status, printed = run("import", source, tmp_path / "o.nc", "--format", "group-csv")
    assert status == 3 and "over frequency (VNA_) and over time (TIME_)" in printed


def test_real_a_scans_of_a_merged_file_give_spectra_of_the_right_level(ground, tmp_path):
    """Simulations that the group merges have no imaginary parts."""
    true = ground[0]
    in_time = to_time(true, Window.NONE, 3.0)
    scans = {
        (int(x), int(y), 0.0): (HEIGHT_M, in_time.a_scan.values[0, row, column])
        for row, y in enumerate(PLACES_MM)
        for column, x in enumerate(PLACES_MM)
    }
    path, output = tmp_path / "t.h5", tmp_path / "o.nc"
    write_merged(path, scans, "Time", in_time.delay.values, heights=False)
    with h5py.File(path, "r+") as file:
        del file["A-Scan/Im{A-Scan x-pol}"]
    band = ["--band", "600e6", "6e9", "201"]
    assert main(["import", str(path), str(output), "--format", "merged-hdf5", *band]) == 0
    found, expected = read_dataset(output).s21.values, true.s21.values
    # A real trace also has the negative frequencies, which leak a little.
    factor = np.vdot(expected, found) / np.linalg.norm(expected) ** 2
    assert factor == pytest.approx(1.0, abs=0.05)
    assert np.linalg.norm(found - expected) < 0.15 * np.linalg.norm(expected)


def test_a_migrated_image_of_the_group_is_read_with_its_doubts(tmp_path):
    magnitude = np.random.default_rng(1).random((4, 3, 5)).astype("f4")
    path, output = tmp_path / "migration_er2.58.h5", tmp_path / "o.nc"
    with h5py.File(path, "w") as file:
        file.attrs["Title"], file.attrs["Relative permittivity"] = "migration", 2.58
        place = file.create_group("/Position")
        for name, value in zip(
            ("x0", "y0", "z0", "xf", "yf", "zf", "qx", "qy", "qz", "h_ant_mig"),
            (0.0, 0.1, 0.0, 0.3, 0.3, 0.4, 4, 3, 5, 0.25),
        ):
            place.attrs[name] = value
        file.create_dataset("/MigratedImage/Image", data=magnitude, compression="gzip")
    with raises_fault(faults.INPUT, "--format migrated-hdf5"):
        load_survey(path)
    assert main(["import", str(path), str(output), "--format", "migrated-hdf5"]) == 0
    found = load_survey(output)
    assert found.image.dims == ("polarization", "depth", "y", "x")
    np.testing.assert_array_equal(found.image.values[0], magnitude.transpose(2, 1, 0))
    assert found.attrs["permittivity"] == 2.58 and math.isnan(float(found.polarization[0]))
    assert any("up to 100.0 mm smaller" in one for one in found.attrs["notes"])
    for change in ({"q": 4}, {"qx": 5}, {"zf": -0.4}, {"h_ant_mig": math.nan}):
        with h5py.File(path, "r+") as file:
            file["Position"].attrs.update(change)
        if "q" not in change:
            assert main(["import", str(path), str(output), "--format", "migrated-hdf5"]) == 3


def test_pip_and_catkin_install_the_same_entry_points():
    assert additions_of_catkin() == added()


@each_case("name", added()["gpr20_analysis.imports"])
def test_each_addition_can_be_loaded(name):
    assert added().keys() == {IMPORTS.group} and name in IMPORTS.names()
    assert IMPORTS.wings[name] == PACKAGE.name
    found = [one for one in additions(IMPORTS.group) if one.name == name]
    assert len(found) == 1 and IMPORTS.find(name) is found[0].load()
