"""The model of the antennas from a metal plate, and what is found from the surface with it.

Ground and plate are computed exactly: the field that a horizontal dipole gets back from a layered
half space, as an integral over plane waves (Michalski and Mosig, "Multilayered media Green's
functions in integral equation formulations", IEEE Transactions on Antennas and Propagation 45
(1997), 508 to 519). The model knows nothing of dipoles: it is that of a far field.
"""

from __future__ import annotations

import json
import os

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault
from recorded_worlds import dataset
from scipy.constants import speed_of_light
from scipy.special import jv

from gpr20_analysis import faults
from gpr20_analysis.commands.batch_command import _made_of
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.antenna_delay import REMOVED
from gpr20_analysis.processing.antenna_step import (
    ENDS,
    SURFACE_PERMITTIVITY,
    antenna_of,
    without_antenna,
)
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.processing.surface_echo import SURFACE_DELAY, with_surface_delay
from gpr20_analysis.sentences import sentences_of

# A larger draw: GPR20_SCENES=100.
SCENES = int(os.environ.get("GPR20_SCENES", "12"))
FREQUENCY_HZ = np.linspace(1e9, 5e9, 41)
PLATE_M = np.array([0.05, 0.06, 0.075, 0.095, 0.12, 0.15, 0.2])
PLACE_M = np.arange(5) * 0.02
METAL = np.inf


def returned(frequency_hz, height_m, permittivity, apart_m):
    """Return the field along a dipole from below it, in units of -omega mu / (8 pi)."""
    wave = 2.0 * np.pi * frequency_hz / speed_of_light
    angle = np.linspace(0.0, np.pi / 2.0, 300)
    decay = np.linspace(0.0, np.arcsinh(25.0 / (2.0 * height_m * wave) + 1.0), 900)
    # Propagating and evanescent waves: across, down, and the weight of a step of the parameter.
    parts = (
        (wave * np.sin(angle), wave * np.cos(angle) + 0j, wave * np.sin(angle), angle),
        (wave * np.cosh(decay), -1j * wave * np.sinh(decay), 1j * wave * np.cosh(decay), decay),
    )
    total = 0.0
    for across, down, weight, parameter in parts:
        electric, magnetic = -1.0, 1.0
        if permittivity != METAL:
            below = np.sqrt(permittivity * wave**2 - across**2 + 0j)
            below = np.where(below.imag > 0.0, -below, below)
            electric = (down - below) / (down + below)
            magnetic = (permittivity * down - below) / (permittivity * down + below)
        zero, two = jv(0, across * apart_m), jv(2, across * apart_m)
        both = electric * (zero + two) - (down / wave) ** 2 * magnetic * (zero - two)
        values = weight * np.exp(-2j * down * height_m) * both
        total += np.sum((values[1:] + values[:-1]) / 2.0 * np.diff(parameter))
    return total


class Antennas:
    """Random antennas with cables: coupling, ringing, an uneven response and feedback."""

    def __init__(self, random, apart_m=0.0):
        self.random, self.apart_m = random, apart_m
        envelope = np.exp(-(((FREQUENCY_HZ - 3e9) / 2.5e9) ** 2))
        cable = np.exp(-2j * np.pi * FREQUENCY_HZ * random.uniform(0.0, 2e-9))
        self.transmission = (2e-3 + self.echoes(3e-4, 4, 0.0, 0.4e-9)) * cable * envelope
        self.internal = self.echoes(0.02, 3, 0.2e-9, 0.6e-9) + self.echoes(0.003, 6, 0.5e-9, 3e-9)
        self.feedback = self.echoes(4e-4, 3, 0.0, 0.6e-9)

    def echoes(self, level, count, earliest_s, latest_s):
        delays_s = self.random.uniform(earliest_s, latest_s, count)
        levels = level * self.random.normal(size=count)
        return np.exp(-2j * np.pi * np.outer(FREQUENCY_HZ, delays_s)) @ levels

    def survey(self, height_m, permittivity, places=PLACE_M, deviation_m=0.0, noise=2e-6):
        """Return a survey of a level surface; the heights differ, as if it was rough."""
        heights_m = height_m + deviation_m * self.random.normal(size=(len(places), len(places)))
        # Smooth over the height, so that few integrals are needed.
        nodes_m = np.linspace(heights_m.min() - 1e-4, heights_m.max() + 1e-4, 5)
        turned = [
            [returned(one, at, permittivity, self.apart_m) * np.exp(4j * np.pi * one * at
             / speed_of_light) for one in FREQUENCY_HZ] for at in nodes_m
        ]  # fmt: skip
        fit = np.polynomial.polynomial.polyfit(nodes_m - height_m, np.array(turned), 3)
        ground = np.moveaxis(
            np.polynomial.polynomial.polyval(heights_m - height_m, fit), 0, -1
        ) * np.exp(-4j * np.pi * heights_m[..., None] * FREQUENCY_HZ / speed_of_light)
        s21 = self.internal + self.transmission * ground / (1.0 - self.feedback * ground)
        s21 = s21 + noise * (self.random.normal(size=(*s21.shape, 2)) @ [1.0, 1j])
        return dataset(s21, heights_m, places, places, FREQUENCY_HZ)

    def model(self, sensor_m=0.0):
        """Return what is fitted to the plate, with errors of the recorded heights."""
        plates = [self.survey(one, METAL, PLACE_M[:2]) for one in PLATE_M]
        plates = [
            one.assign(height=one["height"] + sensor_m * self.random.normal()) for one in plates
        ]
        return antenna_of(plates, self.apart_m)


@pytest.fixture(scope="module")
def antennas():
    return Antennas(np.random.default_rng(1))


@pytest.fixture(scope="module")
def model(antennas):
    return antennas.model()


def test_the_reflection_of_the_surface_gives_the_permittivity():
    held = []
    widths = []
    for seed in range(SCENES):
        random = np.random.default_rng([28, seed])
        antennas = Antennas(random, float(random.choice([0.0, 0.0, 0.04])))
        permittivity = float(np.exp(random.uniform(np.log(2.5), np.log(16.0))))
        height_m = float(random.uniform(0.08, 0.18))
        survey = antennas.survey(height_m, permittivity, deviation_m=random.uniform(0.0, 0.004))
        cleaned = without_antenna(survey, antennas.model(0.002))
        if SURFACE_PERMITTIVITY not in cleaned.attrs:
            continue
        lowest, _, highest = (cleaned.attrs[SURFACE_PERMITTIVITY + one] for one in ENDS)
        held.append(lowest <= permittivity <= highest)
        widths.append(highest / lowest)
    assert len(held) >= 0.6 * SCENES
    assert np.mean(held) >= 0.9
    assert np.median(widths) < 1.6


def test_coupling_and_ringing_are_removed(antennas, model):
    survey = antennas.survey(0.1, 5.0)
    cleaned = without_antenna(survey, model)
    expected = np.array([returned(one, 0.1, 5.0, 0.0) for one in FREQUENCY_HZ])
    ratio = cleaned["s21"].values[0, 0, 0] / expected
    # Up to a constant, and the near field of the dipole.
    assert np.abs(ratio / np.mean(ratio) - 1.0)[5:].max() < 0.08


@pytest.mark.parametrize("height_m", [0.05, 0.06, 0.07])
def test_near_the_ground_the_surface_is_at_its_height(height_m):
    # Without the step the echo of the surface is not clear there: ringing covers it.
    for seed in range(3):
        antennas = Antennas(np.random.default_rng([29, seed]))
        survey = antennas.survey(height_m, 6.0, deviation_m=0.001)
        assert SURFACE_DELAY not in with_surface_delay(survey).attrs
        cleaned = without_antenna(survey, antennas.model(0.001))
        delay_s = cleaned.attrs[SURFACE_DELAY] - cleaned.attrs[REMOVED]
        assert abs(delay_s) * speed_of_light / 2.0 < 0.002


def test_an_image_uses_the_surface_and_says_so(antennas, model):
    cleaned = without_antenna(antennas.survey(0.1, 5.0, deviation_m=0.002), model)
    image = image_survey(cleaned, ImageOptions())
    assert image.attrs["permittivity_source"] == "measured at the surface"
    assert image.attrs["permittivity_lowest"] < 5.0 < image.attrs["permittivity_highest"]


def test_a_given_permittivity_that_contradicts_the_surface_is_noted(antennas, model):
    cleaned = without_antenna(antennas.survey(0.1, 5.0, deviation_m=0.002), model)
    for given, noted in ((5.0, False), (12.0, True)):
        image = image_survey(cleaned, ImageOptions(permittivity=given))
        assert image.attrs["permittivity_source"] == "given"
        notes = " ".join(map(str, sentences_of(image, "notes")))
        assert ("the surface reflects" in notes) == noted


@pytest.mark.parametrize(
    "heights_m", [[0.1, 0.12, 0.15], [0.1] * 5, [0.1, 0.105, 0.11, 0.115], [0.1, 0.1, 0.15, 0.2]]
)
def test_too_few_or_too_equal_heights_are_refused(antennas, heights_m):
    plates = [antennas.survey(one, METAL, PLACE_M[:2]) for one in heights_m]
    with raises_fault(faults.PLATE):
        antenna_of(plates)


def test_what_is_no_plate_is_refused(antennas):
    random = np.random.default_rng(3)
    plates = [antennas.survey(one, METAL, PLACE_M[:2]) for one in PLATE_M]
    for one in plates:
        one["s21"] = one["s21"] + 0.03 * random.normal(size=one["s21"].shape)
    with raises_fault(faults.PLATE):
        antenna_of(plates)


def test_one_survey_under_many_names_is_refused(antennas):
    plate = antennas.survey(0.1, METAL, PLACE_M[:2])
    heights_m = [0.06, 0.075, 0.095, 0.125, 0.17]
    for one in (plate, plate.assign(s21=plate["s21"] * 0.0)):
        with raises_fault(faults.PLATE):
            antenna_of([one.assign(height=one["height"] * 0.0 + height) for height in heights_m])


def test_a_model_of_another_sweep_or_rotation_is_refused(antennas, model):
    survey = antennas.survey(0.1, 5.0)
    for other in (survey.isel(frequency=slice(1, None)), survey.assign_coords(polarization=[90.0])):
        with raises_fault(faults.PLATE):
            without_antenna(other, model)


def test_frequencies_that_differ_by_rounding_lose_nothing(antennas, model):
    survey = antennas.survey(0.1, 5.0)
    rounded = survey.assign_coords(frequency=survey["frequency"] + 0.3)
    found = without_antenna(rounded, model)["s21"].values
    np.testing.assert_allclose(found, without_antenna(survey, model)["s21"].values)


def test_data_that_were_changed_are_refused(antennas, model):
    survey = process_survey(antennas.survey(0.1, 5.0), "background")
    with pytest.raises(WrongDatasetError, match="background"):
        without_antenna(survey, model)
    with pytest.raises(WrongDatasetError, match="background"):
        antenna_of([survey] * 5)


def test_the_commands_measure_and_use_the_antennas(antennas, tmp_path, capsys):
    for name, height_m in zip("abcdefg", PLATE_M):
        write_dataset(antennas.survey(height_m, METAL, PLACE_M[:2]), tmp_path / f"{name}.nc")
    plates = [str(tmp_path / f"{name}.nc") for name in "abcdefg"]
    survey, model = tmp_path / "survey.nc", str(tmp_path / "antenna.nc")
    write_dataset(antennas.survey(0.1, 5.0, np.arange(9) * 0.02, 0.002), survey)
    heights = ["--height", *map(str, PLATE_M)]
    assert main(["antenna", *plates, *heights, "-o", model]) == DONE
    assert "7 heights from 50 to 200 mm" in capsys.readouterr().out
    assert main(["image", str(survey), "--antenna", model]) == DONE
    assert "MEASURED at the surface" in capsys.readouterr().out
    assert main(["antenna", *plates, "--height", "0.1", "-o", model, "--overwrite"]) == REFUSED
    assert main(["antenna", *plates[:3], "-o", model, "--overwrite"]) == REFUSED
    assert main(["image", str(survey), "--antenna", str(survey)]) == REFUSED


def test_lazy_data_give_the_same(antennas, model):
    survey = antennas.survey(0.1, 5.0)
    lazy = without_antenna(survey.chunk({"y": 2}), model)
    xr.testing.assert_allclose(lazy.compute(), without_antenna(survey, model))


def two(survey, other):
    """Return a survey of two rotations."""
    return xr.concat([survey, other.assign_coords(polarization=[90.0])], "polarization")


def test_rotations_that_contradict_each_other_give_nothing(antennas):
    plates = [antennas.survey(one, METAL, PLACE_M[:2]) for one in PLATE_M]
    model = antenna_of([two(one, one) for one in plates])
    dry, wet = (antennas.survey(0.1, one) for one in (3.0, 12.0))
    assert SURFACE_PERMITTIVITY in without_antenna(two(dry, dry), model).attrs
    differing = without_antenna(two(dry, wet), model)
    assert SURFACE_PERMITTIVITY not in differing.attrs
    assert "contradict" in " ".join(map(str, sentences_of(differing, "notes")))


def test_a_plate_without_data_of_a_rotation_is_named(antennas):
    plates = [antennas.survey(one, METAL, PLACE_M[:2]) for one in PLATE_M]
    plates = [two(one, one) for one in plates]
    plates[2]["s21"][1] = np.nan
    with raises_fault(faults.PLATE, "survey 3"):
        antenna_of(plates)


def test_files_that_are_taken_for_one_another_are_refused(antennas, model, tmp_path, capsys):
    survey, plate = tmp_path / "survey.nc", tmp_path / "antenna.nc"
    write_dataset(antennas.survey(0.1, 5.0), survey)
    write_dataset(model, plate)
    write_dataset(model.drop_vars("misfit"), tmp_path / "part.nc")
    for name in (survey, tmp_path / "part.nc"):
        assert main(["image", str(survey), "--antenna", str(name)]) == REFUSED
        assert "gpr20 antenna" in capsys.readouterr().err
    for command in ("info", "image", "delay"):
        assert main([command, str(plate)]) == REFUSED
        assert "is a model of antennas" in capsys.readouterr().err


def test_every_way_to_the_image_removes_the_surface_too(antennas, model, tmp_path, capsys):
    survey, plate, cleaned = (tmp_path / f"{name}.nc" for name in ("survey", "antenna", "cleaned"))
    write_dataset(antennas.survey(0.1, 5.0, np.arange(9) * 0.02, 0.001), survey)
    write_dataset(model, plate)
    step = f"antenna:model={plate}"
    assert main(["process", str(survey), "--step", step, "-o", str(cleaned)]) == DONE
    capsys.readouterr()
    printed = []
    for given in ([str(survey), "--antenna", str(plate)], [str(cleaned)]):
        assert main(["candidates", *given, "--json"]) == DONE
        printed.append(json.loads(capsys.readouterr().out)["candidates"])
    assert printed[0] == printed[1]
    page = tmp_path / "report.html"
    depth = ["--depth", "0", "0.1", "0.01"]
    assert main(["report", str(survey), "--antenna", str(plate), "-o", str(page), *depth]) == DONE
    assert "MEASURED at the surface" in page.read_text(encoding="utf-8")


def test_a_height_that_is_given_counts_for_the_antennas_too(antennas, model, tmp_path, capsys):
    survey = antennas.survey(0.1, 5.0)
    write_dataset(survey.assign(height=survey["height"] * np.nan), tmp_path / "survey.nc")
    write_dataset(model, tmp_path / "antenna.nc")
    given = [str(tmp_path / "survey.nc"), "--antenna", str(tmp_path / "antenna.nc")]
    assert main(["image", *given]) == REFUSED
    assert main(["image", *given, "--height", "0.1"]) == DONE
    assert "MEASURED at the surface" in capsys.readouterr().out


def test_a_batch_is_computed_again_with_another_model(antennas, model, tmp_path):
    survey, plate = tmp_path / "survey.nc", tmp_path / "antenna.nc"
    write_dataset(antennas.survey(0.1, 5.0), survey)
    write_dataset(model, plate)
    first = _made_of(f"image --antenna {plate}", survey)
    assert _made_of(f"image --antenna {plate}", survey) == first
    os.utime(plate, ns=(0, 2**62))
    assert _made_of(f"image --antenna {plate}", survey) != first
