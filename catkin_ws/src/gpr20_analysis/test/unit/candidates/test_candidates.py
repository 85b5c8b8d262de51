"""What is a candidate, what is said about it, and what comes first in the list."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from gpr20_analysis.candidates.rating import Rating
from gpr20_analysis.candidates.search import CandidateOptions, find_candidates
from gpr20_analysis.candidates.table import (
    DOUBTFUL_TITLE,
    candidate_lines,
    candidate_row,
)
from gpr20_analysis.dataset import DEPTH, IMAGE, NOISE, POLARIZATION, X, Y
from gpr20_analysis.errors import WrongDatasetError
from gpr20_common.catalogue import Language
from gpr20_common.low.catalogue_file import read_catalogue
from gpr20_survey.no_clearance import NO_CLEARANCE
from gpr20_survey.results.candidates import OMITTED, Flag

STEP_M = 0.01
SHAPE = (31, 30, 30)
# Half-way between voxels the field of a Gaussian peak is that of the neighbors.
WIDTH_M = 0.018
CORRELATION = float(np.exp(-((STEP_M / WIDTH_M) ** 2) / 2.0))


def image_of(peaks, seed=0, rotations=(0.0, 90.0), clutter=0.0, **attributes):
    """Return an image of noise and peaks (polarization, x, y, depth [m], level)."""
    axes = [STEP_M * np.arange(count) for count in SHAPE]
    random = np.random.default_rng(seed)
    parts = random.standard_normal((2, len(rotations), *SHAPE)) / np.sqrt(2.0)
    values = parts[0] + 1j * parts[1]
    values[:, :3] *= 1.0 + clutter
    grid = np.meshgrid(*axes, indexing="ij")
    for turn, x_m, y_m, depth_m, level in peaks:
        away_2 = sum((axis - at) ** 2 for axis, at in zip(grid, (depth_m, y_m, x_m)))
        values[turn] += level * np.exp(-away_2 / (2.0 * WIDTH_M**2))
    noise = xr.DataArray(np.ones((len(rotations), SHAPE[0])), dims=(POLARIZATION, DEPTH))
    noise.attrs.update({f"correlation_{name}": CORRELATION for name in (DEPTH, Y, X)})
    return xr.Dataset(
        {
            IMAGE: ((POLARIZATION, DEPTH, Y, X), values),
            NOISE: noise,
            "noise_over_y": (Y, np.ones(SHAPE[1])),
            "noise_over_x": (X, np.ones(SHAPE[2])),
        },
        {POLARIZATION: list(rotations), DEPTH: axes[0], Y: axes[1], X: axes[2]},
        {"method": "phase-shift", "permittivity": 4.0, "notes": [], **attributes},
    )


def test_peaks_of_both_polarizations_are_one_candidate_where_they_are():
    for seed in range(10):
        random = np.random.default_rng(seed)
        place = [float(one) for one in random.uniform(0.08, 0.2, 3)]
        shifted = [one + 0.004 for one in place]
        levels = random.uniform(15.0, 30.0, 2)
        image = image_of([(0, *place, levels[0]), (1, *shifted, levels[1])], seed)
        (one,) = find_candidates(image).candidates
        assert one.id == "C01" and one.flags == () and set(one.rotations_deg) == {0.0, 90.0}
        found = np.array([one.x_m, one.y_m, one.depth_m])
        assert np.abs(found - place).max() < 0.008
        assert one.above_noise_db == pytest.approx(20.0 * np.log10(levels.max()), abs=2.5)
        assert one.polarization_ratio_db == pytest.approx(
            20.0 * np.log10(levels[0] / levels[1]), abs=2.5
        )
        assert one.confidence > 1.0 - 1e-6


def test_what_to_know_about_a_candidate_is_flagged():
    for place_m, flags in (
        ((0.15, 0.15, 0.15), set()),
        ((0.01, 0.15, 0.15), {Flag.EDGE}),
        ((0.15, 0.15, 0.30), {Flag.EDGE}),
        ((0.15, 0.15, 0.02), {Flag.SURFACE_RESIDUE}),
    ):
        (one,) = find_candidates(image_of([(0, *place_m, 20.0)])).candidates
        assert set(one.flags) == {Flag.ONE_POLARIZATION, *flags}, place_m


def test_a_faint_candidate_beside_a_bright_one_is_kept_but_comes_last():
    peaks = [
        (0, 0.1, 0.1, 0.15, 1000.0),
        (0, 0.2, 0.2, 0.15, 60.0),
        (0, 0.25, 0.06, 0.2, 300.0),
    ]
    found = find_candidates(image_of(peaks, rotations=(0.0,)), CandidateOptions(1e-4))
    flagged = [Flag.SIDELOBE in one.flags for one in found.candidates]
    assert flagged[:3] == [False, False, True]


def test_residue_of_the_surface_over_the_whole_area_is_clutter_and_hides_no_candidate():
    peaks = [(0, 0.15, 0.15, 0.2, 15.0), (1, 0.15, 0.15, 0.2, 15.0)]
    found = find_candidates(image_of(peaks, clutter=30.0), CandidateOptions(most=5))
    first, *others = found.candidates
    assert first.flags == () and first.depth_m == pytest.approx(0.2, abs=0.01)
    assert all({Flag.CLUTTER, Flag.SURFACE_RESIDUE} <= set(one.flags) for one in others)
    assert found.omitted > 10
    everything = find_candidates(image_of(peaks, clutter=30.0), CandidateOptions(most=10_000))
    assert len(everything.candidates) == found.omitted + 5 and everything.omitted == 0
    shown = everything.shown()
    assert shown == everything.candidates[:11] and not shown[0].is_doubtful
    lines = candidate_lines(everything)
    assert lines[3] == str(DOUBTFUL_TITLE) and len(lines) == 3 + 11 + 3
    assert f"--most {len(everything.candidates)}" in lines[-1]
    assert not any("--most" in one for one in candidate_lines(everything, most_doubtful=None))


def test_only_doubtful_candidates_are_left_out_of_a_list_that_is_too_long():
    random = np.random.default_rng(5)
    places = random.permutation([(x, y) for x in (0.08, 0.15, 0.22) for y in (0.08, 0.15, 0.22)])
    peaks = [(turn, *at, 0.2, 15.0 + turn) for at in places for turn in (0, 1)]
    found = find_candidates(image_of(peaks, clutter=30.0), CandidateOptions(most=3))
    assert len(found.candidates) == len(places) and found.omitted > 10
    assert not any(OMITTED & set(one.flags) for one in found.candidates)
    unrated = image_of(peaks).drop_vars([NOISE, "noise_over_y", "noise_over_x"])
    found = find_candidates(unrated, CandidateOptions(most=12))
    assert len(found.candidates) == 12 and found.omitted == found.omitted_primary > 100
    assert any("NOT shown" in one and "--most" in one for one in candidate_lines(found))


@pytest.mark.parametrize(("lowest", "highest"), [(4.0, 4.0), (3.0, 6.0)])
def test_the_depth_has_the_uncertainty_of_permittivity_height_and_picking(lowest, highest):
    image = image_of(
        [(0, 0.15, 0.15, 0.2, 20.0)], permittivity_lowest=lowest, permittivity_highest=highest
    )
    (one,) = find_candidates(image, CandidateOptions(height_uncertainty_m=0.004)).candidates
    of_permittivity_m = 0.2 * max((4.0 / lowest) ** 0.5 - 1.0, 1.0 - (4.0 / highest) ** 0.5)
    assert one.depth_uncertainty_m > 0.002 + of_permittivity_m * 0.97
    assert one.depth_uncertainty_m < 0.004 + of_permittivity_m * 1.03
    assert 0.0 < one.x_uncertainty_m < 0.002


def test_the_scatter_of_places_is_what_the_uncertainty_says():
    errors, stated = [], []
    for seed in range(60):
        at = 0.15 + 0.004 * np.sin(seed)
        image = image_of([(0, at, 0.15, 0.15, 12.0)], seed, rotations=(0.0,))
        one = find_candidates(image).candidates[0]
        errors.append(one.x_m - at)
        stated.append(one.x_uncertainty_m)
    # The noise of this image is independent from voxel to voxel, so it scatters more.
    assert 0.5 < np.std(errors) / np.mean(stated) < 2.5


def test_lines_say_that_it_is_no_clearance_in_each_language():
    found = find_candidates(image_of([(0, 0.15, 0.15, 0.15, 20.0)], simulated=1))
    lines = candidate_lines(found)
    assert lines[0].startswith("SIMULATED") and lines[1] == str(NO_CLEARANCE)
    assert "one polarization" in lines[3]
    spanish = candidate_lines(found, read_catalogue(Language.SPANISH))
    assert spanish[0].startswith("SIMULADO") and "despeje" in spanish[1]
    assert candidate_row(found.candidates[0])[0] == "C01"
    empty = candidate_lines(find_candidates(image_of([], seed=3), CandidateOptions(1e-6)))
    assert str(NO_CLEARANCE) in empty and "No candidate was found." in empty


def test_a_probability_is_readable():
    (one,) = find_candidates(image_of([(0, 0.15, 0.15, 0.15, 20.0)])).candidates
    shown = {1.0: "100 %", 0.5: "50 %", 0.097: "10 %", 0.003: "0.3 %", 1e-9: "< 0.0001 %"}
    for probability, text in shown.items():
        assert replace(one, false_alarm_probability=probability).false_alarm_text == text


def test_wrong_options_are_refused():
    for wrong in ({"false_alarm_rate": float("nan")}, {"false_alarm_rate": 0.9}, {"most": 0}):
        with pytest.raises(WrongDatasetError):
            CandidateOptions(**wrong)


def test_the_levels_of_the_image_are_computed_once_however_many_peaks_it_has(monkeypatch):
    image = image_of([])
    image[IMAGE] *= 30.0
    computed, level = [], Rating.level
    monkeypatch.setattr(
        Rating, "level", lambda self, turn: computed.append(turn) or level(self, turn)
    )
    found = find_candidates(image)
    assert computed == [0, 1]
    assert len(found.candidates) == 50
    assert found.omitted > 500
