"""What a target sends back, against closed forms and fields that share no code with it."""

import numpy as np
import pytest
from echoes_kit import by_default
from recorded_worlds import UNIANDES, area, dataset, disc

from gpr20_analysis.hiding.injection import of_surface, with_targets
from gpr20_analysis.hiding.scattering import Soil, ball_amplitude_m, echo_of
from gpr20_survey.results.hiding_map import Target, Targets, target_of

FREQUENCY_HZ = np.linspace(0.6e9, 3.5e9, 30)
LIGHT_M_S = 299792458.0


def test_a_small_ball_scatters_as_rayleigh_says_and_a_large_one_from_its_nearest_point():
    wave, radius_m = np.array([0.5, 1.0, 2.0]), 0.01
    assert ball_amplitude_m(wave, radius_m) == pytest.approx(1.5 * wave**2 * radius_m**3, rel=1e-3)
    wave, radius_m = np.linspace(400.0, 900.0, 40), 0.1
    specular = -0.5 * radius_m * np.exp(2j * wave * radius_m)
    assert np.abs(ball_amplitude_m(wave, radius_m) / specular - 1.0).max() < 0.05


def test_in_air_an_echo_is_that_of_the_radar_equation():
    target = Target("ball", 0.04, 0.04)
    echo = echo_of(target, 0.08, Soil(1.0), 0.3, FREQUENCY_HZ, 0.2)
    wave = 2.0 * np.pi * FREQUENCY_HZ / LIGHT_M_S
    expected = ball_amplitude_m(wave, 0.02) / 0.4**2
    assert np.abs(echo.values[0]) == pytest.approx(np.abs(expected), rel=1e-6)


def test_loss_weakens_what_is_deep_by_its_way():
    target, wave = Targets.FRAGMENT.value, 2.0 * np.pi * FREQUENCY_HZ / LIGHT_M_S
    clear, lossy = (
        echo_of(target, 0.1, Soil(9.0, loss), 0.2, FREQUENCY_HZ, 0.1).values[0]
        for loss in (0.0, 0.05)
    )
    middle_m = 0.1 + target.diameter_m / 2.0
    assert np.abs(lossy / clear) == pytest.approx(np.exp(-wave * 3.0 * 0.05 * middle_m), rel=1e-6)


def level_db(survey, permittivity):
    image = by_default(survey, permittivity)
    return 20.0 * np.log10(float(abs(image["image"]).max()))


def test_a_disc_is_as_bright_as_by_an_exact_integral():
    """The antennas are dipoles over a half space; the disc differs little from the soil."""
    frequency_hz, place_m = np.linspace(0.6e9, 3.5e9, 49), 0.035 * np.arange(15)
    name, top_m, permittivity, height_m = "disc:112:15:3.2", 0.09, 2.56, 0.4
    middle_m = place_m[7]
    exact, level = disc(name, top_m)
    exact = exact[13:28, 13:28]
    empty = dataset(np.broadcast_to(level, exact.shape), height_m, place_m, place_m, frequency_hz)
    (transmission,) = of_surface(empty, 0.06, [permittivity])
    echo = echo_of(target_of(name), top_m, Soil(permittivity), height_m, frequency_hz, 0.5)
    injected = with_targets(empty, echo, [(middle_m, middle_m)], permittivity, transmission, 0.06)
    direct = dataset(level + exact, height_m, place_m, place_m, frequency_hz)
    assert level_db(injected, permittivity) == pytest.approx(
        level_db(direct, permittivity), abs=1.5
    )


def test_a_metal_ball_is_as_bright_as_by_finite_differences():
    survey, truth = area(UNIANDES, 1)
    ball, permittivity = truth["bodies"][3], truth["permittivity"]
    target = Target("ball", ball["height_m"], ball["height_m"])
    soil, place_m = Soil(permittivity), (ball["x_m"], ball["y_m"])
    frequency_hz = survey["frequency"].values
    echo = echo_of(target, ball["top_m"], soil, truth["height_m"], frequency_hz, 1.0)
    (transmission,) = of_surface(survey, 0.06, [permittivity])
    empty = survey.assign(s21=survey["s21"] * 0.0 + 1e-9)
    alone = with_targets(empty, echo, [place_m], permittivity, transmission, 0.06)
    levels_db = [peak_db(one, truth, ball) for one in (alone, survey)]
    assert levels_db[0] == pytest.approx(levels_db[1], abs=3.0)


def peak_db(survey, truth, ball):
    """Return the level of the image at a ball."""
    image = by_default(survey, truth["permittivity"])
    image = abs(image["image"]).isel(polarization=0)
    near = image.where(
        (abs(image["x"] - ball["x_m"]) < 0.04)
        & (abs(image["y"] - ball["y_m"]) < 0.04)
        & (abs(image["depth"] - ball["top_m"]) < 0.03)
    )
    return 20.0 * np.log10(float(near.max()))
