"""Echoes without each other's sidelobes, and candidates in ground that our imaging did not make."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from noise_kit import errors_in_uncertainties, imaged, survey
from recorded_worlds import LINES, line, real_line, truths
from run_seed import LONG

from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import DEFAULT_STEPS, Method
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import process_survey

METHODS = [Method.PHASE_SHIFT, Method.BACK_PROJECTION]
PLACE_M = 0.0125 * np.arange(41)
FREQUENCY_HZ = {stop: np.linspace(0.6e9, stop, 81) for stop in (2e9, 3e9, 6e9)}


def _release(*cases):
    return [pytest.param(*one, marks=pytest.mark.release) for one in cases]


def primary(image):
    return [one for one in find_candidates(image).candidates if not one.is_doubtful]


def by_default(data, permittivity):
    """Return the image that the command makes without options."""
    options = ImageOptions(permittivity=permittivity, ground=Ground.LEVEL)
    return image_survey(process_survey(data, *DEFAULT_STEPS), options)


def rank_of(found, x_m, y_m, within_m=0.05):
    """Return the place in a list of the first candidate near a place; 1000 if there is none."""
    near = [
        number
        for number, one in enumerate(found)
        if np.hypot(one.x_m - x_m, one.y_m - y_m) < within_m
    ]
    return min(near, default=1000)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("level", [1e-6, pytest.param(1.0, marks=pytest.mark.release)])
def test_noise_alone_is_hardly_a_candidate_at_any_level(method, level):
    found = [
        len(primary(imaged(survey(np.random.default_rng(seed), level, rotations=(0.0,)), method)))
        for seed in range(4)
    ]
    # 10 per m2 of 0.06 m2 are 0.6.
    assert np.mean(found) < 1.5


@pytest.mark.parametrize(("seed", "method"), [(0, Method.PHASE_SHIFT), (1, Method.BACK_PROJECTION)])
def test_the_level_of_a_body_hardly_depends_on_the_depths_shown(seed, method):
    random = np.random.default_rng(seed)
    depth_m = float(random.uniform(0.05, 0.09))
    place = tuple(random.uniform(0.07, 0.14, 2))
    data = survey(random, 1.0, [(*place, depth_m)])
    levels = []
    for last_m in (0.12, 0.2, 0.3):
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
    found = primary(imaged(data))
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
    found = primary(by_default(data, 6.0))
    nearest_m = [float(np.abs(bars_m - one.x_m).min()) for one in found[: len(bars_m)]]
    assert sum(one < 0.015 for one in nearest_m) >= 12
    for bar_m in bars_m:
        assert min(abs(one.x_m - bar_m) for one in found) < 0.015
    # No residue of the surface above them.
    assert all(0.05 < one.depth_m < 0.08 for one in found[:12])


@pytest.mark.parametrize("method", METHODS)
def test_candidates_lie_where_they_are_within_their_uncertainties(method):
    assert errors_in_uncertainties(method).max() < 1.6
