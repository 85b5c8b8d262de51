"""The back-projection against a plain sum over all traces and frequencies, and its two ways."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from ground_kit import GRID_MM, IMAGING_SCENE, survey_of
from hypothesis import given, settings
from hypothesis import strategies as st

from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.imaging.projection.back_projection import back_projection_image
from gpr20_analysis.imaging.projection.lattice import combs_of, even_step_m, paths_of
from gpr20_analysis.imaging.projection.lattice_projection import lattice_image
from gpr20_analysis.imaging.projection.pair_projection import pair_image
from gpr20_analysis.imaging.projection.projection_scene import scene_of
from gpr20_analysis.imaging.records import Focus, Ground, Traces
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.progress import in_stages, no_progress
from gpr20_analysis.threads import on_threads
from gpr20_survey.radar.refraction import one_way_delay_s

SWEEP = FrequencyGrid(600e6, 54e6, 101)
DEPTH_M = np.array([0.0, 0.03, 0.08, 0.15])


def traces_of_noise(seed):
    """Return random spectra on a grid that is regular, some of them zero."""
    random = np.random.default_rng(seed)
    rows, columns = random.integers(1, 12, 2)
    steps_m = random.uniform(0.01, 0.06, 2)
    s21 = random.standard_normal((rows, columns, SWEEP.count, 2)) @ np.array([1.0, 1j])
    s21[random.random((rows, columns)) < 0.1] = 0.0
    s21[0, 0] = 1.0
    spread_m = random.choice([0.0, 0.03])
    height_m = 0.15 + spread_m * random.random((rows, columns))
    x_m, y_m = (0.1 + step_m * np.arange(count) for step_m, count in zip(steps_m, (columns, rows)))
    return Traces(s21, SWEEP, x_m, y_m, height_m, float(random.choice([0.0, 45.0, 90.0])))


def focus_of(seed):
    separation_m = [0.0, 0.1][seed % 2]
    return Focus(4.0, DEPTH_M, separation_m=separation_m, widest_angle_deg=50.0)


def plain_sum(traces, focus, x_m, y_m):
    """Return the image as the method is defined, with exact delays and no A-scans."""
    sine = np.sin(np.radians(focus.widest_angle_deg))
    turn = np.radians(traces.rotation_deg)
    side_m = focus.separation_m / 2.0 * np.array([np.cos(turn), np.sin(turn)])
    weights = focus.window.weights(SWEEP.count)
    image = np.zeros((len(focus.depth_m), len(y_m), len(x_m)), dtype=np.complex128)
    for place in np.ndindex(*traces.height_m.shape):
        dx = x_m[None, None, :] - traces.x_m[place[1]]
        dy = y_m[None, :, None] - traces.y_m[place[0]]
        height_m, depth_m = traces.height_m[place], focus.depth_m[:, None, None]
        reach_m = height_m * sine / np.sqrt(1.0 - sine**2)
        reach_m = reach_m + depth_m * sine / np.sqrt(focus.permittivity - sine**2)
        delay_s = sum(
            one_way_delay_s(
                height_m,
                depth_m,
                np.hypot(dx + one * side_m[0], dy + one * side_m[1]),
                focus.permittivity,
            )
            for one in (1.0, -1.0)
        )
        spectrum = traces.s21[place] * weights / weights.sum()
        held = np.exp(2j * np.pi * delay_s[..., None] * SWEEP.frequency_hz) @ spectrum
        image += np.where(np.hypot(dx, dy) <= reach_m, held, 0.0)
    return image / traces.height_m.size


def correlation(one, other):
    return abs(np.vdot(one, other)) / np.sqrt(np.vdot(one, one).real * np.vdot(other, other).real)


@pytest.mark.parametrize("seed", range(4))
def test_the_image_is_the_sum_of_all_traces_at_their_exact_delays(seed):
    traces, focus = traces_of_noise(seed), focus_of(seed)
    image = back_projection_image(traces, focus)
    assert correlation(image, plain_sum(traces, focus, traces.x_m, traces.y_m)) > 0.998
    # Equal distances together are the same as pair by pair:
    # at the same positions, at finer ones, and at some that begin beside the traces.
    for finer, begin in ((1, 0.0), (2, 0.0), (3, -0.37)):
        x_m, y_m = (
            place_m[0] + (begin + np.arange(finer * len(place_m)) / finer) * step_m
            for place_m in (traces.x_m, traces.y_m)
            for step_m in [even_step_m(place_m)]
        )
        scene = scene_of(traces, focus, x_m, y_m)
        together, pairs = lattice_image(scene, no_progress), pair_image(scene, no_progress)
        assert together is not None
        np.testing.assert_allclose(together, pairs, atol=2e-4 * np.abs(pairs).max())


def test_irregular_positions_are_computed_pair_by_pair():
    traces, focus = traces_of_noise(0), focus_of(1)
    assert len(traces.x_m) > 2
    moved = replace(traces, x_m=traces.x_m + 0.004 * (np.arange(len(traces.x_m)) % 2))
    scene = scene_of(moved, focus, moved.x_m, moved.y_m)
    assert lattice_image(scene, no_progress) is None
    expected = plain_sum(moved, focus, moved.x_m, moved.y_m)
    assert correlation(back_projection_image(moved, focus), expected) > 0.998


@settings(deadline=None, max_examples=40)
@given(
    st.integers(1, 9),
    st.integers(1, 9),
    st.integers(1, 3),
    st.integers(-200, 450),
    st.floats(0, 0.1),
)
def test_paths_hold_every_trace_in_reach_once_at_its_distance(rows, columns, finer, begin, side):
    steps_m, reach_m = (0.03, 0.02), 0.1037
    places_m = [step_m * np.arange(count) for step_m, count in zip(steps_m, (rows, columns))]
    images_m = [
        step_m * (begin / 50.0 + np.arange(2 * finer + 1) / finer)
        for step_m, place_m in zip(steps_m, places_m)
    ]
    side_m = side * np.array([0.6, 0.8])
    expected, found = [], []
    for down in combs_of(images_m[0], places_m[0], steps_m[0]):
        for right in combs_of(images_m[1], places_m[1], steps_m[1]):
            paths = paths_of((down, right), (rows, columns), steps_m, side_m, reach_m)
            begin_of = np.concatenate([[0], paths.ends[:-1]])
            assert np.all(np.diff(paths.distance_m[:, 0]) >= 0.0)
            for y, row in enumerate(np.arange(len(images_m[0]))[down.columns]):
                for x, column in enumerate(np.arange(len(images_m[1]))[right.columns]):
                    for path, (first, end) in enumerate(zip(begin_of, paths.ends)):
                        for offset in paths.offsets[first:end]:
                            trace = offset + (down.first + y, right.first + x)
                            if np.all(trace >= 0) and trace[0] < rows and trace[1] < columns:
                                found.append((row, column, *trace, *paths.distance_m[path]))
    for row, y_m in enumerate(images_m[0]):
        for column, x_m in enumerate(images_m[1]):
            for trace in np.ndindex(rows, columns):
                away_m = np.array([places_m[1][trace[1]] - x_m, places_m[0][trace[0]] - y_m])
                if np.hypot(*away_m) <= reach_m - 1e-6:
                    either = sorted(np.hypot(*(away_m + one * side_m)) for one in (1.0, -1.0))
                    expected.append((row, column, *trace, np.hypot(*away_m), *either))
    inside = [one for one in found if one[4] <= reach_m - 1e-6]
    assert len(inside) == len({one[:4] for one in inside}) == len(expected)
    np.testing.assert_allclose(sorted(inside), sorted(expected), atol=2e-5)


@pytest.mark.parametrize("ground", Ground)
def test_the_height_of_a_trace_that_is_left_out_is_in_the_table_of_delays(ground):
    traces, focus = traces_of_noise(0), replace(focus_of(0), ground=ground)
    traces.s21[-1, -1] = 0.0
    traces.height_m[-1, -1] = traces.height_m.max() + 0.05
    scene = scene_of(traces, focus, traces.x_m, traces.y_m)
    level, _ = scene.levels(traces.height_m)
    assert level.min() >= 0
    assert level.max() < len(scene.table.delay_s)
    assert np.isfinite(back_projection_image(traces, focus)).all()


@pytest.mark.parametrize("ground", Ground)
def test_progress_moves_within_a_polarization(ground):
    traces = traces_of_noise(1)
    seen = []

    def progress(items, total):
        for number, one in enumerate(items):
            yield one
            seen.append((number + 1, total))

    back_projection_image(traces, replace(focus_of(1), ground=ground), progress=progress)
    assert len(seen) >= 4
    assert [number for number, _ in seen] == list(range(1, seen[-1][1] + 1))


def test_stages_are_shown_as_one_progress():
    shown = []

    def progress(items, total):
        for one in items:
            yield one
            shown.append(total)

    seen = []
    for item, stage in in_stages("ab", progress):
        for _ in stage(range(4), 4):
            seen.append((item, len(shown)))
    steps = [number for _, number in seen]
    assert steps == sorted(steps)
    assert steps[0] == 0
    assert 99 <= steps[4] <= 100
    assert 150 < steps[-1] < 200
    assert shown == 200 * [200]


def test_the_progress_of_an_image_moves_within_each_polarization():
    survey = survey_of(IMAGING_SCENE, x_mm=GRID_MM[:4], y_mm=GRID_MM[:3])
    shown = []

    def progress(items, total):
        for one in items:
            shown.append((one, total))
            yield one

    depth_m = (0.01, 0.02, 0.03, 0.04)
    image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0, depth_m), progress)
    assert shown == [(step, 200) for step in range(200)]


def test_after_an_interruption_nothing_more_is_begun():
    begun = []
    entered = threading.Event()

    def work(item):
        begun.append(item)
        entered.set()
        time.sleep(0.01)

    def progress(items, _):
        entered.wait(10.0)
        raise KeyboardInterrupt
        yield from items

    with pytest.raises(KeyboardInterrupt):
        on_threads(work, range(500), progress)
    assert 0 < len(begun) < 250
