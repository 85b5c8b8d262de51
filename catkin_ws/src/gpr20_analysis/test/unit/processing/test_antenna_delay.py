"""The delay of cables and antennas: fitted, recorded, removed, and noted where it is unseen."""

import json
from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from run_seed import draws
from scipy.constants import speed_of_light
from survey_kit import describe_again, make_survey

from gpr20_analysis import errors
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.permittivity import BuriedReference
from gpr20_analysis.processing.chain import process_survey
from gpr20_analysis.processing.delay import set_time_zero, to_time
from gpr20_analysis.processing.surface_echo import fit_delay
from gpr20_analysis.read.load import load_survey
from gpr20_common.faults import NOT_ALLOWED
from gpr20_simulator.mid.world.scene import Noise

PLACES_MM = np.linspace(140.0, 340.0, 11)
TARGET = point(243.7, 236.2, 0.083)
DELAY_S = 0.3e-9


def survey(delay_s=DELAY_S, targets=(TARGET,), height_m=None, **antennas):
    ground = scene(targets, delay_s=delay_s, **antennas)
    return survey_of(ground, PLACES_MM, PLACES_MM, rotations_deg=(0.0,), height_m=height_m)


def depth_m(image):
    strongest = np.abs(image.image).argmax(...)
    return float(image.depth[strongest["depth"]])


def surface_notes(image):
    return [one for one in image.attrs["notes"] if "surface echo" in one]


def test_a_delay_is_fitted_noted_and_corrected():
    measured = survey()
    fit = fit_delay(measured)
    assert abs(fit.delay_s - DELAY_S) < min(10e-12, fit.uncertainty_s)
    cleaned = process_survey(measured, "background")
    fine = tuple(np.arange(0.05, 0.12, 0.0005))
    unseen = image_survey(cleaned, ImageOptions(permittivity=4.0, depth_m=fine))
    seen = image_survey(cleaned, ImageOptions(permittivity=4.0, depth_m=fine, delay_s=fit.delay_s))
    assert abs(depth_m(unseen) - TARGET.depth_m) > 0.02
    assert abs(depth_m(seen) - TARGET.depth_m) <= 1e-3
    (note,) = surface_notes(unseen)
    assert "+45 mm" in note
    assert not surface_notes(seen)
    assert json.loads(seen.attrs["imaging"])["delay_s"] == fit.delay_s
    # A height that is wrong by more than 5 mm is noted too, and a buried reference refused.
    right, buried = process_survey(survey(0.0), "background"), BuriedReference(0.1, 0.1, 0.1)
    for height_m, noted in ((None, 0), (0.203, 0), (0.207, 1)):
        image = image_survey(right, ImageOptions(permittivity=4.0, height_m=height_m))
        assert len(surface_notes(image)) == noted, height_m
    for data, options in ((cleaned, {}), (right, {"height_m": 0.25})):
        with raises_fault(NOT_ALLOWED):
            image_survey(data, ImageOptions(buried=buried, **options))
    apart = survey(separation_m=0.12)
    assert abs(fit_delay(apart, 0.12).delay_s - DELAY_S) < 10e-12
    assert fit_delay(apart).delay_s - DELAY_S > 50e-12


def test_the_recorded_delay_is_removed_by_default_and_only_once():
    cleaned = process_survey(survey().assign_attrs(antenna_delay_s=DELAY_S), "background")
    zero = process_survey(survey().assign_attrs(antenna_delay_s=DELAY_S), "time_zero", "background")
    options = ImageOptions(permittivity=4.0)
    expected = image_survey(process_survey(survey(0.0), "background"), options).image.values
    image = image_survey(cleaned, options)
    np.testing.assert_allclose(image.image.values, expected, atol=1e-3 * abs(expected).max())
    assert not surface_notes(image)
    assert not surface_notes(image_survey(zero, options))
    advance_s = 2.0 * zero.height.values / speed_of_light + DELAY_S
    np.testing.assert_allclose(zero.advance.values, advance_s, rtol=1e-9)
    with raises_fault(NOT_ALLOWED):
        removed = cleaned.assign_attrs(antenna_delay_removed_s=DELAY_S)
        image_survey(removed, replace(options, delay_s=DELAY_S))
    for wrong_s in (1e-4, np.nan):
        with raises_fault(NOT_ALLOWED, "-10000 and 10000 ns"):
            ImageOptions(delay_s=wrong_s)


def random_survey(random):
    """Return a survey of a random scene, its delay and its antenna separation."""
    delay_s = random.choice([0.0, DELAY_S, random.uniform(0.0, 2e-9)])
    separation_m = random.choice([0.0, 0.06, 0.12])
    middle_m, rise_m = random.uniform(0.13, 0.3), random.choice([0.0, 0.02])
    targets = [
        point(*random.uniform(140.0, 340.0, 2), *random.uniform((0.04, 0.02), (0.2, 0.08)))
        for _ in range(random.integers(0, 4))
    ]
    ground = scene(targets, random.uniform(3.0, 9.0), height_m=middle_m, delay_s=delay_s,
                   separation_m=separation_m,
                   coupling_level_db=random.uniform(-50.0, -28.0))  # fmt: skip
    ground = replace(ground, noise=Noise(random.uniform(-90.0, -55.0), int(random.integers(9999))))
    waves = random.uniform(30.0, 90.0, 2)

    def height_m(x_mm, y_mm):
        return middle_m + rise_m * np.sin(x_mm / waves[0]) * np.cos(y_mm / waves[1])

    made = survey_of(ground, PLACES_MM, PLACES_MM, rotations_deg=(0.0,), height_m=height_m)
    sensor_m = random.choice([0.0, 0.003]) * random.standard_normal(made.height.shape)
    return made.assign(height=made.height + sensor_m), delay_s, separation_m


def test_random_scenes_are_fitted_within_the_uncertainty_or_refused():
    within, refused, count = 0, 0, draws(5)
    for seed in range(count):
        made, delay_s, separation_m = random_survey(np.random.default_rng(seed))
        try:
            fit = fit_delay(made, separation_m)
        except WrongDatasetError:
            refused += 1
            continue
        within += abs(fit.delay_s - delay_s) <= fit.uncertainty_s
    assert within + refused >= count - 1
    assert refused <= max(1, count // 6)


def test_coupling_far_above_the_surface_is_told_apart_by_differing_heights():
    def height_m(x_mm, y_mm):
        return 0.2 + 0.01 * np.sin(x_mm / 50.0)

    fit = fit_delay(survey(height_m=height_m, coupling_level_db=-5.0))
    assert fit.by_movement
    assert abs(fit.delay_s - DELAY_S) < 10e-12
    # Without that it is refused: the coupling must not be taken for the surface.
    with raises_fault(NOT_ALLOWED):
        fit_delay(survey(coupling_level_db=-5.0))


def test_a_metal_plate_at_a_known_height_gives_the_delay():
    plate = survey(targets=(), surface_gain_db=-5.0, height_m=lambda x, y: 0.15)
    wrong = plate.assign(height=plate.height * np.nan)
    few = wrong.isel(y=[0], x=slice(0, 5))
    assert abs(fit_delay(few, height_m=0.15, plate=True).delay_s - DELAY_S) < 10e-12
    with raises_fault(NOT_ALLOWED):
        fit_delay(few, height_m=0.15)
    with raises_fault(NOT_ALLOWED):
        fit_delay(survey(coupling_level_db=-35.0), plate=True)


def test_other_surveys_that_cannot_give_it_are_refused():
    one = survey()
    noise = np.random.default_rng(0).standard_normal((*one.s21.shape, 2)) @ [1.0, 1j]
    for fault, wrong in (
        (errors.STEPS, set_time_zero(one)),
        (errors.STEPS, to_time(one)),
        (NOT_ALLOWED, process_survey(one, "background:method=mean")),
        (NOT_ALLOWED, one.assign(s21=one.s21 * 0.0 + noise)),
        (NOT_ALLOWED, one.isel(frequency=slice(0, 10))),
        (NOT_ALLOWED, one.assign(height=one.height * np.nan)),
        (NOT_ALLOWED, survey(surface_gain_db=-200.0, targets=())),
    ):
        with raises_fault(fault):
            fit_delay(wrong)


def test_the_robots_configuration_gives_the_delay_if_it_is_valid(tmp_path):
    folder = make_survey(tmp_path, 18, None)
    for analyzer, delay_s, noted in (
        ({"antenna_delay_ns": 0.25}, 0.25e-9, False),
        *((one, None, False) for one in ({}, None, "old")),
        *(({"antenna_delay_ns": one}, None, True) for one in ("0.3", None, 101.0)),
    ):
        describe_again(folder, analyzer=analyzer)
        found = load_survey(folder).attrs
        assert found.get("antenna_delay_s") == pytest.approx(delay_s), analyzer
        assert any("antenna_delay_ns" in one for one in found["notes"]) == noted, analyzer


def test_the_command_prints_the_line_of_the_configuration(tmp_path, capsys):
    path = tmp_path / "survey.nc"
    write_dataset(survey(), path)
    assert main(["delay", str(path)]) == DONE
    key, value = capsys.readouterr().out.splitlines()[-1].split(": ")
    assert key == "antenna_delay_ns"
    assert abs(float(value) - 0.3) < 0.01
    assert main(["delay", str(path), "--separation", "nan"]) == REFUSED
    capsys.readouterr()
    assert main(["image", str(path), "--permittivity", "4"]) == DONE
    assert "gpr20 delay" in capsys.readouterr().out
    assert main(["image", str(path), "--permittivity", "4", "--delay", value]) == DONE
    assert "gpr20 delay" not in capsys.readouterr().out
