"""The images against point scatterers whose place is known, all of them off the grid."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from run_seed import draws

from gpr20_analysis import errors
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.imaging.back_projection import back_projection_image
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.records import Focus, Ground, Traces
from gpr20_analysis.processing.background import remove_background
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.work import on_threads
from gpr20_common.faults import NOT_ALLOWED
from gpr20_simulator.mid.world.ground import Ground as SimulatedGround
from gpr20_simulator.mid.world.scene import Surface
from gpr20_survey.radar import one_way_delay_s

TARGETS = (point(173.3, 181.7, 0.1134), point(318.9, 307.4, 0.0711))
QUIET = {"coupling_level_db": -200.0, "surface_gain_db": -200.0}
EXACT = (Method.PHASE_SHIFT, Method.BACK_PROJECTION)
NEAR_MM = np.linspace(115.0, 370.0, 18)


def brightest_near(image, target, turn=0):
    """Return the bright candidate of one polarization nearest to a target."""
    found = find_candidates(image.isel(polarization=[turn])).candidates
    return min(
        (one for one in found if one.above_clutter_db > found[0].above_clutter_db - 15.0),
        key=lambda one: np.hypot(one.x_m - target.x_mm / 1e3, one.y_m - target.y_mm / 1e3),
    )


def error_mm(echo, target):
    return np.array(
        [
            echo.x_m * 1e3 - target.x_mm,
            echo.y_m * 1e3 - target.y_mm,
            (echo.depth_m - target.depth_m) * 1e3,
        ]
    )


@pytest.fixture(scope="module")
def survey():
    return survey_of(scene(TARGETS, **QUIET), NEAR_MM, NEAR_MM, rotations_deg=(0.0,))


@pytest.mark.parametrize("method", EXACT)
@pytest.mark.parametrize("permittivity", [2.0, pytest.param(9.0, marks=pytest.mark.release)])
def test_point_targets_are_where_the_scene_has_them(method, permittivity):
    survey = survey_of(scene(TARGETS, permittivity), NEAR_MM, NEAR_MM, rotations_deg=(0.0,))
    cleaned = remove_background(survey)
    image = image_survey(cleaned, ImageOptions(method, permittivity))
    # Straight below, delay and so depth times the root of a wrong permittivity stay.
    wrong = image_survey(cleaned, ImageOptions(method, permittivity * 1.25))
    for target in TARGETS:
        assert np.all(np.abs(error_mm(brightest_near(image, target), target)) < 2.0)
    moved_m = brightest_near(wrong, TARGETS[0]).depth_m
    assert moved_m == pytest.approx(TARGETS[0].depth_m / np.sqrt(1.25), abs=0.006)


def test_phase_shift_and_back_projection_agree(survey):
    images = [image_survey(survey, ImageOptions(method, 4.0)).image.values for method in EXACT]
    with raises_fault(NOT_ALLOWED, "needs --method back-projection"):
        ImageOptions(Method.PHASE_SHIFT, 4.0, ground=Ground.UNEVEN)
    # Level ground is the same by either way.
    options = ImageOptions(Method.BACK_PROJECTION, 4.0, ground=Ground.UNEVEN)
    uneven = image_survey(survey, options).image.values
    assert np.allclose(uneven, images[1], atol=1e-5 * np.abs(images[1]).max())
    assert correlation(*images) > 0.85


@pytest.mark.parametrize("method", EXACT)
def test_recorded_heights_undo_a_tilted_scanner(method):
    def height_m(x_mm, y_mm):
        return 0.2 + 0.04 * (x_mm - 240.0) / 360.0

    tilted = {"rotations_deg": (0.0,), "height_m": height_m}
    survey = survey_of(scene(TARGETS, **QUIET), NEAR_MM, NEAR_MM, **tilted)
    recorded = image_survey(survey, ImageOptions(method, 4.0, ground=Ground.LEVEL))
    noted = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0)).attrs["notes"]
    assert any("differ by 28 mm" in one for one in noted)
    mean = image_survey(survey, ImageOptions(method, 4.0, height_m=0.2))
    for target in TARGETS:
        assert np.linalg.norm(error_mm(brightest_near(recorded, target), target)) < 1.5
        assert np.linalg.norm(error_mm(brightest_near(mean, target), target)) > 10.0


@pytest.mark.parametrize(
    ("surface", "separation_m"),
    [
        (Surface(slope_y=-0.03, wave_amplitude_m=0.003), 0.0),
        pytest.param(Surface(slope_x=0.03), 0.06, marks=pytest.mark.release),
    ],
)
def test_targets_below_uneven_ground_are_found_where_they_are(surface, separation_m):
    uneven = replace(scene(TARGETS, separation_m=separation_m, **QUIET), surface=surface)
    survey = survey_of(uneven, NEAR_MM, NEAR_MM, rotations_deg=(0.0,))
    options = ImageOptions(Method.BACK_PROJECTION, 4.0, separation_m=separation_m)
    known = image_survey(survey, replace(options, ground=Ground.UNEVEN))
    taken_as_level = image_survey(survey, options)
    for target in TARGETS:
        above_m = SimulatedGround(uneven).surface_height_m(target.x_mm, target.y_mm)
        below_surface = replace(target, depth_m=target.depth_m + above_m)
        assert np.linalg.norm(error_mm(brightest_near(known, target), below_surface)) < 2.0
        assert np.linalg.norm(error_mm(brightest_near(taken_as_level, target), below_surface)) > 4.0


def test_antennas_apart_are_focused_by_back_projection():
    target = point(243.7, 236.2, 0.06)
    ground = scene([target], separation_m=0.12, **QUIET)
    survey = survey_of(ground, NEAR_MM, NEAR_MM, rotations_deg=(0.0,))
    apart = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0, separation_m=0.12))
    together = image_survey(survey, ImageOptions(Method.BACK_PROJECTION, 4.0))
    assert np.linalg.norm(error_mm(brightest_near(apart, target), target)) < 1.5
    assert abs(error_mm(brightest_near(together, target), target)[2]) > 3.0


def test_an_image_that_does_not_fit_into_the_memory_is_refused(monkeypatch):
    target, places_mm = point(200, 200, 0.1), np.linspace(100.0, 300.0, 5)
    survey = survey_of(scene([target], **QUIET), places_mm, places_mm)
    monkeypatch.setattr("gpr20_analysis.work.available_bytes", lambda: survey.s21.nbytes)
    with raises_fault(errors.TOO_LARGE):
        image_survey(survey, ImageOptions(permittivity=4.0))


SWEEP = FrequencyGrid(600e6, 54e6, 101)
DEPTHS_M = np.array([0.0, 0.03, 0.08, 0.15])


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
    return Focus(4.0, DEPTHS_M, separation_m=separation_m, widest_angle_deg=50.0)


def plain_sum(traces, focus):
    """Return the image as the method is defined, with exact delays and no A-scans."""
    sine = np.sin(np.radians(focus.widest_angle_deg))
    turn = np.radians(traces.rotation_deg)
    side_m = focus.separation_m / 2.0 * np.array([np.cos(turn), np.sin(turn)])
    weights = focus.window.weights(SWEEP.count)
    x_m, y_m = traces.x_m, traces.y_m
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
    # Also at irregular positions.
    moved = replace(traces, x_m=traces.x_m + 0.004 * (np.arange(len(traces.x_m)) % 2))
    for data in (traces, moved):
        assert correlation(back_projection_image(data, focus), plain_sum(data, focus)) > 0.998


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
        on_threads(work, range(2_000), progress)
    assert 0 < len(begun) < 2_000
