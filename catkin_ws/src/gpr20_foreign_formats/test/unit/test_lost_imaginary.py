"""Old samples whose imaginary part is a copy of the real part are recovered, and imaged."""

import json

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import IMAGING_SCENE, point, scene, survey_of
from run_seed import draws

from gpr20_analysis import faults
from gpr20_analysis.formats.conversion import export_survey, import_survey
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.chain import process_survey
from gpr20_foreign_formats import original_json
from gpr20_foreign_formats.lost_imaginary import recover

FREQUENCY_HZ = np.linspace(600e6, 6e9, 201)
PLACES_MM = np.linspace(120.0, 360.0, 13)
OPTIONS = ImageOptions(permittivity=5.0, depth_m=tuple(np.arange(0.03, 0.18, 0.003)))


def image_of(survey):
    return image_survey(process_survey(survey, "background:method=mean"), OPTIONS).image.values


def copied(spectra):
    return spectra.real * (1.0 + 1.0j)


def written(survey, folder):
    """Write a survey as the old storage did."""
    shape = survey.s21.shape[:3]
    sample = survey.assign(
        s21=(survey.s21.dims, copied(survey.s21.values)),
        timestamp=(survey.height.dims, np.full(shape, "NaT", "datetime64[ns]")),
        sample_id=(survey.height.dims, np.full(shape, "")),
    )
    original_json.write_original(sample, folder)
    return folder


def test_the_image_of_recovered_data_is_that_of_the_measured_data(tmp_path):
    ground = scene(IMAGING_SCENE.targets, 5.0, -60.0, height_m=0.2)
    survey = survey_of(ground, PLACES_MM, PLACES_MM, FREQUENCY_HZ, (90.0,))
    found = original_json.read_original(written(survey, tmp_path / "old"))
    true, recovered = image_of(survey), image_of(found)
    norms = np.linalg.norm(true) * np.linalg.norm(recovered)
    assert abs(np.vdot(true, recovered)) / norms > 0.99
    assert np.corrcoef(np.abs(true).ravel(), np.abs(recovered).ravel())[0, 1] > 0.99
    assert np.argmax(np.abs(true)) == np.argmax(np.abs(recovered))


def test_samples_that_have_an_imaginary_part_are_unchanged():
    rng = np.random.default_rng(1)
    whole = rng.standard_normal(201) + 1j * rng.standard_normal(201)
    echo = np.exp(-2j * np.pi * FREQUENCY_HZ * 3e-9)
    found = recover([whole, copied(echo)], FREQUENCY_HZ, [0.2, 0.2])
    np.testing.assert_array_equal(found.spectra[0], whole)
    np.testing.assert_array_equal(found.spectra[1].real, echo.real)
    inside = slice(20, -20)  # the ends of the band are less exact
    np.testing.assert_allclose(found.spectra[1].imag[inside], echo.imag[inside], atol=0.05)
    assert "in 1 of 2 samples" in str(found.notes[0])
    for no_copy in (whole, np.zeros(201, complex)):
        assert recover([no_copy], FREQUENCY_HZ, [0.2]).notes == []
    uneven_hz = np.array([1e9, 2e9, 4e9])
    assert recover([copied(np.ones(3))], uneven_hz, [0.2]).refusal is not None


@pytest.mark.parametrize("form, name", [("group-csv", "old"), ("merged-hdf5", "old.h5")])
def test_copies_in_files_of_the_group_are_recovered_too(tmp_path, form, name):
    ground = scene([point(240.0, 240.0, 0.1)], 5.0, -60.0, height_m=0.2)
    survey = survey_of(ground, PLACES_MM[:4], PLACES_MM[:3], FREQUENCY_HZ, (0.0,))
    old = survey.assign(s21=(survey.s21.dims, copied(survey.s21.values)))
    export_survey(old, tmp_path / name, form)
    found = import_survey(tmp_path / name, form)
    expected = recover(list(old.s21.values.reshape(-1, 201)), FREQUENCY_HZ, [0.2]).spectra
    error = found.s21.values.reshape(-1, 201) - expected
    assert np.abs(error).max() < 1e-6 * np.abs(expected).max()
    assert any("12 of 12 samples the imaginary part was a copy" in one for one in found.notes)


@pytest.mark.parametrize("seed", range(draws(1)))
def test_echoes_beyond_half_of_the_range_are_not_taken_for_near_ones(seed):
    rng = np.random.default_rng(seed)
    half_s = 0.5 * 200 / 5.4e9
    far_s = half_s * rng.uniform(1.05, 1.45)
    near, far = (np.exp(-2j * np.pi * FREQUENCY_HZ * one) for one in (2e-9, far_s))
    noise = rng.standard_normal(201) * 1e-3
    weak = recover([copied(near + 0.05 * far + noise)], FREQUENCY_HZ, [0.2])
    assert weak.refusal is None
    # Without an imaginary part it shows at its mirror image.
    assert weak.notes[1].values["mirrored_ns"] == pytest.approx(far_s * 1e9, abs=0.2)
    strong = recover([copied(near + 0.5 * far + noise)], FREQUENCY_HZ, [0.2])
    assert "cannot be recovered; a strong echo" in str(strong.refusal)
    assert recover([copied(near + noise)], FREQUENCY_HZ, [0.2]).notes[1:] == []


def test_what_cannot_be_recovered_is_imported_but_never_imaged(tmp_path):
    survey = survey_of(
        scene([]), np.array([0.0, 10.0]), np.array([0.0]), np.linspace(6e8, 6e9, 5), (0.0,)
    )
    folder = written(survey, tmp_path / "old")
    found = original_json.read_original(folder)
    assert any("cannot be recovered" in one for one in found.attrs["notes"])
    with raises_fault(faults.STEPS, "surface already has 1.33 ns"):
        image_survey(found, OPTIONS)
    sample = sorted(folder.iterdir())[0]
    assert json.loads(sample.read_text())["data"][0]["real_value"] == found.s21.values.flat[0].real
