"""The model of the antennas from a metal plate, and what is found from the surface with it.

Ground and plate are computed exactly: the field that a horizontal dipole gets back from a layered
half space, as an integral over plane waves (Michalski and Mosig, "Multilayered media Green's
functions in integral equation formulations", IEEE Transactions on Antennas and Propagation 45
(1997), 508 to 519). The model knows nothing of dipoles: it is that of a far field.
"""

from functools import lru_cache

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault
from recorded_worlds import dataset
from run_seed import draws
from scipy.constants import speed_of_light
from scipy.special import jv

from gpr20_analysis import errors
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.antenna_step import (
    ENDS,
    SURFACE_PERMITTIVITY,
    antenna_of,
    without_antenna,
)
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.sentences import sentences_of

FREQUENCY_HZ = np.linspace(1e9, 5e9, 41)
PLATE_M = np.array([0.05, 0.06, 0.075, 0.095, 0.12, 0.15, 0.2])
PLACE_M = np.arange(5) * 0.02
METAL = np.inf


@lru_cache(maxsize=None)
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
        nodes_m = np.unique(np.linspace(heights_m.min(), heights_m.max(), 5))
        turned = [
            [returned(one, at, permittivity, self.apart_m) * np.exp(4j * np.pi * one * at
             / speed_of_light) for one in FREQUENCY_HZ] for at in nodes_m
        ]  # fmt: skip
        fit = np.polynomial.polynomial.polyfit(
            nodes_m - height_m, np.array(turned), min(3, len(turned) - 1)
        )
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
    count = draws(4)
    for seed in range(count):
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
    assert len(held) >= 0.6 * count
    assert np.mean(held) >= 0.9
    assert np.median(widths) < 1.6


def test_coupling_is_removed_and_an_image_uses_the_surface_and_says_so(antennas, model):
    cleaned = without_antenna(antennas.survey(0.1, 5.0, deviation_m=0.002), model)
    image = image_survey(cleaned, ImageOptions())
    assert image.attrs["permittivity_source"] == "measured at the surface"
    assert image.attrs["permittivity_lowest"] < 5.0 < image.attrs["permittivity_highest"]
    # Coupling and ringing are gone, up to a constant and the near field of the dipole.
    expected = np.array([returned(one, 0.1, 5.0, 0.0) for one in FREQUENCY_HZ])
    ratio = without_antenna(antennas.survey(0.1, 5.0), model)["s21"].values[0, 0, 0] / expected
    assert np.abs(ratio / np.mean(ratio) - 1.0)[5:].max() < 0.08
    for given, noted in ((5.0, False), (12.0, True)):
        image = image_survey(cleaned, ImageOptions(permittivity=given))
        assert image.attrs["permittivity_source"] == "given"
        notes = " ".join(map(str, sentences_of(image, "notes")))
        assert ("the surface reflects" in notes) == noted


def test_what_is_no_plate_at_enough_heights_and_a_model_of_others_is_refused(antennas, model):
    survey = antennas.survey(0.1, 5.0)
    for other in (survey.isel(frequency=slice(1, None)), survey.assign_coords(polarization=[90.0])):
        with raises_fault(errors.INPUT):
            without_antenna(other, model)
    few = ([0.1, 0.12, 0.15], [0.1, 0.105, 0.11, 0.115], [0.1, 0.1, 0.15, 0.2])
    sets = [[antennas.survey(one, METAL, PLACE_M[:2]) for one in heights_m] for heights_m in few]
    plate = antennas.survey(0.1, METAL, PLACE_M[:2])
    zero = plate["height"] * 0.0
    sets.append([plate.assign(height=zero + one) for one in PLATE_M])  # one survey many times
    changed = process_survey(survey, "background")
    for plates in sets:
        with raises_fault(errors.INPUT):
            antenna_of(plates)
    with pytest.raises(WrongDatasetError, match="background"):
        antenna_of([changed] * 5)
    lost = [two(one, one) for one in sets[-1]]
    lost[2]["s21"][1] = np.nan
    with raises_fault(errors.INPUT, "survey 3"):
        antenna_of(lost)


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
    assert main(["info", model]) == REFUSED


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
