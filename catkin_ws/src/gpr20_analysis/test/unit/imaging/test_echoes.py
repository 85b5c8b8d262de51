"""Echoes without each other's sidelobes, candidates of ground of others, the robot's image."""

import itertools
import os

import numpy as np
import pytest
import xarray as xr
from echoes_kit import by_default, places
from fault_kit import raises_fault
from ground_kit import IMAGING_SCENE, survey_of
from noise_kit import errors_in_uncertainties, imaged, survey
from recorded_worlds import LINES, line, real_line, truths
from run_seed import LONG, draws
from survey_kit import POINTS, make_survey, planned_trace

from gpr20_analysis.candidates.answer import FEWEST_LINES, focus
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import TOO_FEW_LINES
from gpr20_analysis.imaging.image_options import Method
from gpr20_analysis.processing.sweep import steps_to_top
from gpr20_analysis.read.load import GrowingSurvey, load_survey
from gpr20_survey.folder import trace_files
from gpr20_survey.folder.survey_folder import trace_file_name

METHODS = [Method.PHASE_SHIFT, Method.BACK_PROJECTION]
PLACE_M = 0.0125 * np.arange(41)
FREQUENCY_HZ = {stop: np.linspace(0.6e9, stop, 81) for stop in (2e9, 3e9, 6e9)}


def _release(*cases):
    return [pytest.param(*one, marks=pytest.mark.release) for one in cases]


def test_a_plateau_has_its_top_in_its_middle_in_every_precision():
    for kind in (np.float32, np.float64):
        assert steps_to_top(np.ones((1, 3), kind), np.array([1])) == 0.0


def rank_of(found, x_m, y_m, within_m=0.05):
    """Return the place in a list of the first candidate near a place; 1000 if there is none."""
    near = [
        number
        for number, one in enumerate(found)
        if np.hypot(one.x_m - x_m, one.y_m - y_m) < within_m
    ]
    return min(near, default=1000)


@pytest.mark.parametrize("method", METHODS)
def test_the_level_of_a_body_hardly_depends_on_the_depths_shown(method):
    data = survey(np.random.default_rng(0), 1.0, [(0.11, 0.09, 0.07)], rotations=(0.0,))
    levels = []
    for last_m in (0.12, 0.24):
        image = imaged(data, method, tuple(np.arange(0.0, last_m, 0.004)))
        levels.append(find_candidates(image).candidates[0].above_clutter_db)
    assert np.ptp(levels) < 3.0


@pytest.mark.parametrize(
    ("count", "stop_hz"),
    [(2, 6e9), *_release((2, 2e9), (2, 3e9), (3, 2e9), (3, 3e9), (3, 6e9), (4, 3e9), (4, 6e9))],
)
def test_bodies_at_one_depth_are_all_candidates(count, stop_hz):
    middle_m = (np.arange(count) + 0.5) / count * PLACE_M[-1]
    bodies = [(x_m, y_m, 0.08) for x_m in middle_m for y_m in middle_m]
    data = survey(
        np.random.default_rng(1), 0.02, bodies, rotations=(0.0,), place_m=PLACE_M,
        frequency_hz=FREQUENCY_HZ[stop_hz],
    )  # fmt: skip
    found = places(imaged(data))
    assert max(rank_of(found, *one[:2], within_m=0.03) for one in bodies) < len(bodies) + 2


@pytest.mark.parametrize(
    ("below_db", "apart_m", "seed"),
    [
        (30.0, 0.25, 0),
        *_release(*itertools.product((20.0, 24.0, 30.0), (0.15, 0.25, 0.45), (1, 2))),
    ],
)
def test_a_mine_beside_a_fragment_is_among_the_first_three(below_db, apart_m, seed):
    random = np.random.default_rng([int(apart_m * 100 + below_db), seed])
    turn = random.uniform(0.0, 2.0 * np.pi)
    if apart_m > 0.4:
        # Only along a diagonal both are within the area.
        turn = np.pi / 4.0 + np.pi / 2.0 * random.integers(4)
    away_m = apart_m / 2.0 * np.array([np.cos(turn), np.sin(turn)])
    fragment, mine = PLACE_M[-1] / 2.0 - away_m, PLACE_M[-1] / 2.0 + away_m
    grid = 0.015 * np.arange(-2, 3)
    disc = [(x, y) for x in grid for y in grid if np.hypot(x, y) < 0.035]
    level = 10.0 ** (-below_db / 20.0) / len(disc)
    bodies = [(*fragment, 0.04, 1.0), *((mine[0] + x, mine[1] + y, 0.09, level) for x, y in disc)]
    data = survey(
        random, 0.03, bodies, rotations=(0.0,), place_m=PLACE_M, frequency_hz=FREQUENCY_HZ[6e9]
    )
    found = find_candidates(imaged(data)).candidates
    assert rank_of(found, *fragment) == 0
    assert rank_of(found, *mine) < 3


def test_bodies_of_lines_by_maxwells_equations_lead_the_list():
    first, bodies = 0, 0
    for number in range(0, len(truths(LINES)), 5 if LONG else 20):
        data, truth = line(number)
        found = find_candidates(by_default(data, truth["permittivity"])).candidates
        for body in truth["bodies"]:
            near = [
                place
                for place, one in enumerate(found)
                if abs(one.x_m - body["x_m"]) < body["half_width_m"] + 0.03
                and -0.03 < one.depth_m - body["top_m"] < body["thickness_m"] + 0.06
            ]
            bodies += 1
            first += min(near, default=1000) < 3
    # These 40 lines are over clean ground.
    assert bodies > (40 if LONG else 10) and first / bodies > 0.85


def test_the_bars_of_a_real_line_are_the_first_of_its_list():
    data, bars_m = real_line()
    found = places(by_default(data, 6.0))
    nearest_m = [float(np.abs(bars_m - one.x_m).min()) for one in found[: len(bars_m)]]
    assert sum(one < 0.015 for one in nearest_m) >= 12
    for bar_m in bars_m:
        assert min(abs(one.x_m - bar_m) for one in found) < 0.015
    # No residue of the surface above them.
    assert all(0.05 < one.depth_m < 0.08 for one in found[:12])


@pytest.mark.parametrize("method", METHODS)
def test_candidates_lie_where_they_are_within_their_uncertainties(method):
    assert errors_in_uncertainties(method).max() < 1.6


GRID_MM = np.linspace(90.0, 270.0, 16)


@pytest.fixture(scope="module")
def area_survey():
    return survey_of(IMAGING_SCENE, GRID_MM, GRID_MM)


def without(area_survey, rows):
    """Return a survey of which some rows were not measured."""
    missing = area_survey.copy(deep=True)
    missing["s21"][:, rows] = np.nan
    missing["quality"][:, rows] = int(Quality.MISSING)
    return missing


def noise_of(area_survey, seed):
    """Return noise alone, as much in every sample."""
    generator = np.random.default_rng(seed)
    shape = (2, *area_survey["s21"].shape)
    noise = 1e-5 * (
        generator.standard_normal(shape[1:]) + 1j * generator.standard_normal(shape[1:])
    )
    return area_survey.assign(s21=(area_survey["s21"].dims, noise))


def test_the_target_is_the_brightest_place(area_survey):
    found = focus(area_survey, 5.0)
    deep = found.depth_mm > 60.0
    levels_db = found.levels_db[deep]
    layer, row, column = np.unravel_index(np.nanargmax(levels_db), levels_db.shape)
    place_mm = found.x_mm[column], found.y_mm[row], found.depth_mm[deep][layer]
    np.testing.assert_allclose(place_mm, (173.3, 181.7, 113.0), atol=12.0)
    assert found.levels_db.dtype == np.float32
    assert found.traces == 2 * len(GRID_MM) ** 2
    assert found.found.simulated


def test_lines_that_were_not_measured_stay_empty(area_survey):
    for rows in (slice(7, None), slice(0, 9), slice(8, 9)):
        empty = np.isnan(focus(without(area_survey, rows), 5.0).levels_db)
        assert empty[:, rows].all(), rows
        assert not np.delete(empty, np.arange(16)[rows], axis=1).any(), rows


@pytest.mark.parametrize(
    "measured", [9, *(pytest.param(n, marks=pytest.mark.release) for n in (16, 5))]
)
def test_noise_alone_has_the_level_of_noise_also_half_way(area_survey, measured):
    candidates = 0
    for seed in range(draws(2)):
        found = focus(without(noise_of(area_survey, seed), slice(measured, None)), 5.0)
        levels_db = found.levels_db[np.isfinite(found.levels_db)]
        # It is the brighter of two polarizations; the target of this scene is 70 dB above noise.
        assert abs(np.median(levels_db) - 0.5) < 2.0
        assert levels_db.max() < 13.0
        candidates += found.found.primary
    # At most 10 per m2 are asked for, and each of these sees 0.05 m2.
    assert candidates <= 4


def test_too_few_lines_are_refused(area_survey):
    with raises_fault(TOO_FEW_LINES, FEWEST_LINES, 2):
        focus(without(area_survey, slice(2, None)), 5.0)


def add_trace(folder, index, **changes):
    trace = planned_trace(index, **changes)
    path = folder / "traces" / trace_file_name(trace)
    path.write_bytes(trace_files.encode(trace))
    return path


def test_a_growing_survey_is_what_a_new_reading_gives(tmp_path, monkeypatch):
    folder = make_survey(tmp_path, 5, None)
    growing = GrowingSurvey(folder)
    read = []
    real = GrowingSurvey.load.__globals__["read_trace"]
    monkeypatch.setitem(
        GrowingSurvey.load.__globals__, "read_trace", lambda path: read.append(path) or real(path)
    )
    xr.testing.assert_identical(growing.load(), load_survey(folder))
    for index in range(5, len(POINTS)):
        add_trace(folder, index)
        read.clear()
        xr.testing.assert_identical(growing.load(), load_survey(folder))
        assert len(read) == 1


def test_a_damaged_trace_is_left_out_and_not_kept_and_a_replaced_one_read_again(tmp_path):
    folder = make_survey(tmp_path, 5, None)
    growing = GrowingSurvey(folder)
    (path,) = (folder / "traces").glob("000003_*")
    whole = path.read_bytes()
    path.write_bytes(whole[:100])
    assert "000003" in str(growing.load().attrs["faults"])
    path.write_bytes(whole)
    assert growing.load().attrs["faults"] == []
    os.utime(str(add_trace(folder, 2, antennae_height_m=0.5)), ns=(1, 1))
    assert float(growing.load()["height"].max()) == 0.5
