"""The back-projection against a plain sum over all traces and frequencies, and its two ways."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from run_seed import draws

from gpr20_analysis.imaging.projection.back_projection import back_projection_image
from gpr20_analysis.imaging.projection.lattice import even_step_m
from gpr20_analysis.imaging.projection.lattice_projection import lattice_image
from gpr20_analysis.imaging.projection.pair_projection import pair_image
from gpr20_analysis.imaging.projection.projection_scene import scene_of
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.progress import no_progress
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


@pytest.mark.parametrize("seed", range(draws(2)))
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


def test_after_an_interruption_nothing_more_is_begun():
    begun = []
    entered = threading.Event()

    def work(item):
        begun.append(item)
        entered.set()
        time.sleep(0.01)

    def progress(items, _):
        entered.wait(30.0)
        raise KeyboardInterrupt
        yield from items

    with pytest.raises(KeyboardInterrupt):
        on_threads(work, range(20_000), progress)
    assert 0 < len(begun) < 20_000
