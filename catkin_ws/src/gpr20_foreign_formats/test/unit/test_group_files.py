"""Files of the group and of the original project arrive as they are, with what was decided."""

import json
import subprocess

import h5py
import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from foreign_formats_kit import PACKAGE, added, additions_of_catkin
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

from gpr20_analysis import errors
from gpr20_analysis.entry_points import additions
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.formats.imported_folder import SOURCES_FILE
from gpr20_analysis.formats.imports import IMPORTS
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.sentences import DECISIONS
from gpr20_analysis.work import no_progress

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
    assert "constant of the original control" in decided and "read as UTC" in decided
    assert set(survey_there.height.values[np.isfinite(survey_there.height.values)]) == {0.2}
    assert str(survey_there.timestamp.values.min())[:19] == "2021-10-15T08:00:00"
    options = ImageOptions(permittivity=4.0, leave_out_missing=True)
    assert np.isfinite(image_survey(survey_there, options).image.values).any()


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
    with raises_fault(errors.STEPS, "copy of the real part"):
        image_survey(read_dataset(output), ImageOptions(permittivity=4.0))


def test_the_command_may_say_that_the_ground_is_real(tmp_path):
    source = write_csv(tmp_path / "real", survey(2))
    found = load_survey(imported(source, "group-csv", tmp_path / "data", "--real-ground"))
    assert found.attrs["simulated"] == 0


def test_a_scans_over_time_have_the_times_of_their_names(tmp_path):
    samples = survey(5, turns=(0.0,))
    source = write_csv(tmp_path / "t", samples, "TIME", "Ts0u_Te0.0006u")
    (source / "time").write_text("Time\n0\n")
    found = IMPORTS.find("group-csv").read(source, None, no_progress)
    np.testing.assert_allclose(found.delay, np.arange(7) * 1e-10, rtol=1e-9)
    for (x_mm, y_mm, _), (_, values) in samples.items():
        own = found.a_scan.sel(x=x_mm / 1e3, y=y_mm / 1e3, method="nearest").values[0]
        np.testing.assert_array_equal(own, values)
    assert "rounded to 0.1 ns, delays are wrong by up to 8.3 %" in str(found.attrs["notes"])


def test_a_scans_of_a_merged_file_may_be_real(tmp_path):
    """Simulations that the group merges have no imaginary parts."""
    path, scans = tmp_path / "t.h5", even(survey(4, turns=(0.0,)))
    write_merged(path, scans, "Time", np.arange(7) * 1e-9, heights=False)
    with h5py.File(path, "r+") as file:
        del file["A-Scan/Im{A-Scan x-pol}"]
    found = IMPORTS.find("merged-hdf5").read(path, None, no_progress)
    own = found.a_scan.sel(x=0.02, y=0.015, method="nearest").values[0]
    np.testing.assert_allclose(own, scans[20, 15, 0.0][1].real, atol=1e-7)
    assert "so the A-scans are real" in str(found.attrs["notes"])
    np.testing.assert_allclose(found.delay, np.arange(7) * 1e-9)


def test_pip_and_catkin_install_the_same_entry_points():
    assert additions_of_catkin() == added()


@each_case("name", added()["gpr20_analysis.imports"])
def test_each_addition_can_be_loaded(name):
    assert added().keys() == {IMPORTS.group} and name in IMPORTS.names()
    assert IMPORTS.wings[name] == PACKAGE.name
    found = [one for one in additions(IMPORTS.group) if one.name == name]
    assert len(found) == 1 and IMPORTS.find(name) is found[0].entry.load()
