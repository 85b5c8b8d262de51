"""Which local maxima of an image are more than noise."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from gpr20_analysis.dataset import DEPTH, IMAGE, POLARIZATION, X, Y
from gpr20_analysis.imaging.echoes import find_echoes, noise_peak
from gpr20_analysis.imaging.image_output import doubtful_echoes, echo_lines

SHAPE = (40, 30, 30)


def noise(seed: int, shape=SHAPE) -> np.ndarray:
    parts = np.random.default_rng(seed).standard_normal((2, *shape))
    return parts[0] + 1j * parts[1]


def image_of(volume: np.ndarray) -> xr.Dataset:
    axes = {name: 0.01 * np.arange(length) for name, length in zip((DEPTH, Y, X), volume.shape)}
    dimensions = (POLARIZATION, DEPTH, Y, X)
    return xr.Dataset({IMAGE: (dimensions, volume[None])}, {POLARIZATION: [0.0], **axes})


@pytest.mark.parametrize("shape", [SHAPE, (60, 60, 60), (10, 9, 9)])
def test_the_brightest_voxel_of_noise_is_where_it_is_said_to_be(shape):
    brightest = [np.abs(noise(seed, shape)).max() for seed in range(20)]
    said = np.mean([noise_peak(np.abs(noise(seed, shape))) for seed in range(20)])
    assert np.mean(brightest) == pytest.approx(said, rel=0.1)


def test_a_target_stands_above_noise_and_noise_is_told_to_be_doubtful():
    volume = noise(1)
    volume[20, 10, 12] = 40.0
    echoes = find_echoes(image_of(volume), faintest_db=-25.0)
    assert echoes[0].x_m == pytest.approx(0.12, abs=0.001)
    assert echoes[0].above_noise_db > 15.0
    assert len(echoes) > 5 and all(one.above_noise_db < 2.0 for one in echoes[1:])
    (printed,) = doubtful_echoes(echoes)
    count = sum(one.above_noise_db <= 0.0 for one in echoes)
    assert str(printed).startswith(f"{count} of the {len(echoes)} echoes are not brighter")
    assert echo_lines(echoes)[-1] == str(printed)


def test_nothing_is_doubted_where_all_echoes_stand_out():
    volume = np.zeros(SHAPE, dtype=complex)
    volume[20, 10, 12] = 1.0
    (echo,) = find_echoes(image_of(volume))
    assert echo.above_noise_db == np.inf
    assert doubtful_echoes([echo]) == [] and len(echo_lines([echo])) == 2
