"""Random surveys come back from every format as they were, and damage to the files is refused."""

import numpy as np
import pytest
from checksum_kit import check_with_sha256sum
from fault_kit import raises_fault
from random_surveys import random_survey
from run_seed import SEED, draws

from gpr20_analysis import ImageOptions, faults, image_survey
from gpr20_analysis.formats.conversion import export_survey, import_survey
from gpr20_analysis.formats.dataset_files import read_dataset, write_dataset
from gpr20_analysis.formats.sums_beside import sums_path
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.processing.to_frequency import to_frequency
from gpr20_survey.radar.frequency_to_delay import Window, delay_kernel

SEEDS = range(draws(2))
FORMATS = {"group-csv": "out", "original-json": "out", "merged-hdf5": "out.h5"}
SINGLE = 1e-6


def same(found, expected, tolerance):
    for name in ("polarization", "y", "x", "frequency"):
        np.testing.assert_allclose(found[name].values, expected[name].values, rtol=1e-12)
    scale = np.nanmax(np.abs(expected.s21.values))
    np.testing.assert_allclose(found.s21.values, expected.s21.values, atol=tolerance * scale)
    np.testing.assert_allclose(found.height.values, expected.height.values, atol=5.1e-6)
    np.testing.assert_array_equal(found.quality.values, expected.quality.values)
    assert found.attrs["missing"] == expected.attrs["missing"]
    for name in ("simulated", "survey_id", "antenna_delay_s"):
        assert found.attrs[name] == expected.attrs[name]


@pytest.mark.parametrize("seed", SEEDS)
def test_random_surveys_come_back_from_every_format(tmp_path, seed):
    survey = random_survey(seed)
    for form, name in FORMATS.items():
        path = tmp_path / form / name
        path.parent.mkdir()
        export_survey(survey, path, form)
        same(import_survey(path, form), survey, SINGLE if form == "merged-hdf5" else 0.0)
    for name in ("s.nc", "s.zarr"):
        write_dataset(survey, tmp_path / name)
        same(read_dataset(tmp_path / name), survey, 0.0)
    export_survey(survey, tmp_path / "touchstone", "touchstone")
    found = import_survey(tmp_path / "touchstone", "touchstone")
    same(found, survey, 1e-12)
    window = [Window.NONE, Window.HAMMING][seed % 2]
    in_time = to_time(survey, window, 1.0 + seed)
    for form, tolerance in (("group-csv", 1e-9), ("merged-hdf5", 3e-5)):
        path = tmp_path / f"in time {FORMATS[form]}"
        export_survey(in_time, path, form)
        found = import_survey(path, form)
        assert "a_scan" in found
        same(to_frequency(found), survey, tolerance)


@pytest.mark.parametrize("seed", SEEDS)
def test_random_surveys_come_back_from_segy(tmp_path, seed):
    survey = random_survey(seed)
    paths = list(export_survey(survey, tmp_path / "s.sgy", "segy"))
    assert len(paths) == survey.sizes["polarization"]
    for turn, path in enumerate(paths):
        part = survey.isel(polarization=[turn])
        whole = import_survey(path, "segy")
        sums_path(path).unlink()
        for found, within in ((whole, 1e-9), (import_survey(path, "segy"), 0.51e-4)):
            # The edges of the grid that no trace shows are known from the sums alone.
            part = part.sel(x=found.x, y=found.y, method="nearest")
            for name in ("x", "y", "height"):
                np.testing.assert_allclose(found[name].values, part[name].values, atol=0.51e-4)
            assert found.polarization.values.tolist() == part.polarization.values.tolist()
            np.testing.assert_allclose(found.x, part.x, atol=within)
            assert found.attrs["simulated"] == survey.attrs["simulated"]
            usable = (part.quality.values & 3) == 0
            assert ((found.quality.values & 3) == 0).tolist() == usable.tolist()
            kernel = delay_kernel(survey.frequency.values, found.delay.values)
            expected = (part.s21.values @ kernel).real[usable]
            scale = np.abs(expected).max()
            np.testing.assert_allclose(
                found.a_scan.values[usable].real, expected, atol=1e-6 * scale
            )
        for name in ("survey_id", "antenna_delay_s"):
            assert whole.attrs[name] == survey.attrs[name]


@pytest.mark.parametrize(("form", "name"), [("segy", "s.sgy"), ("touchstone", "t")])
def test_shifted_data_come_back_from_other_programs_formats_for_display_only(tmp_path, form, name):
    shifted = process_survey(random_survey(2, one_polarization=True), "time_zero")
    (path,) = export_survey(shifted, tmp_path / name, form)
    for found in (import_survey(path, form), import_survey(path, form, height_m=0.1)):
        with raises_fault(faults.STEPS):
            image_survey(to_frequency(found) if form == "segy" else found, ImageOptions())


def refused(path, form, name):
    with raises_fault(faults.FILE_DAMAGED, name):
        import_survey(path, form)


@pytest.mark.parametrize("form", ["group-csv", "original-json", "touchstone"])
def test_an_export_of_which_a_file_or_its_checksums_changed_is_refused(tmp_path, form):
    rng, path = np.random.default_rng(int(SEED)), tmp_path / "out"
    export_survey(random_survey(1), path, form)
    files = sorted(path.iterdir())
    victim = files[rng.integers(len(files))]
    whole = victim.read_bytes()
    content = bytearray(whole)
    place = rng.choice([at for at, byte in enumerate(content) if chr(byte).isdigit()])
    content[place] = ord("0") + (content[place] - ord("0") + 1) % 10
    victim.write_bytes(content)
    refused(path, form, victim.name)
    victim.unlink()
    refused(path, form, victim.name)
    victim.write_bytes(whole)
    other = path / victim.name.replace("X", "X9", 1)
    other.write_bytes(whole)
    refused(path, form, other.name)
    other.unlink()
    sums = tmp_path / "out.sha256"
    whole = sums.read_bytes()
    content = bytearray(whole)
    content[rng.integers(len(content))] ^= 1 << rng.integers(7)
    sums.write_bytes(content)
    refused(path, form, "")
    sums.write_bytes(whole)
    check_with_sha256sum(tmp_path)


def test_shifted_data_are_not_exported_to_formats_that_cannot_say_so(tmp_path):
    shifted = process_survey(random_survey(2), "time_zero")
    for form, name in FORMATS.items():
        with raises_fault(faults.INPUT):
            export_survey(shifted, tmp_path / name, form)
