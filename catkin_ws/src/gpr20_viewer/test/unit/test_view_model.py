"""The viewer's model: delays, images. Nothing here needs Qt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of

from gpr20_analysis import errors, work
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.chain import process_survey
from gpr20_survey.radar import Soils
from gpr20_viewer.positions import Place
from gpr20_viewer.scene import Picture, Scene, longest_delay_s, traces_picture
from gpr20_viewer.session import ImageRequest, ViewSession

PLACES_MM = np.linspace(140.0, 340.0, 11)
TARGET = point(240.0, 240.0, 0.083)
PLACE = Place(0.24, 0.24, 0.083)
FIXED = ImageOptions(permittivity=4.0)


def at_once(items, total=None):
    return items


def small(**changes):
    values = {"x_mm": PLACES_MM, "y_mm": PLACES_MM, "rotations_deg": (0.0,), **changes}
    return survey_of(scene([TARGET]), **values)


@pytest.fixture(scope="module")
def session():
    return ViewSession(small(), FIXED)


@pytest.fixture(scope="module")
def image(session):
    return session.compute(session.first_request, at_once)


@each_case("separation_m,along", [(0.0, "x"), (0.12, "y")])
def test_the_hyperbola_lies_on_the_echo_of_the_target(separation_m, along):
    # The simulator finds its paths by itself.
    ground = scene([TARGET], separation_m=separation_m)
    session = ViewSession(survey_of(ground, PLACES_MM, PLACES_MM, rotations_deg=(0.0,)), FIXED)
    line = session.line(0, along, 0.24)
    until_s = longest_delay_s(line, 0.15, 4.0, separation_m)
    picture = traces_picture(session, line, 0, True, until_s)
    ridge_ns = np.linspace(*picture.down, len(picture.levels_db))[picture.levels_db.argmax(axis=0)]
    expected_ns = line.delays_s(PLACE, 4.0, separation_m) * 1e9
    sample_ns = picture.down[1] / (len(picture.levels_db) - 1)
    assert np.abs(ridge_ns - expected_ns).max() < max(sample_ns, 0.06)


def test_the_hyperbola_follows_data_whose_time_zero_was_set():
    raw, shifted = (
        ViewSession(one, FIXED) for one in (small(), process_survey(small(), "time_zero"))
    )
    delays = [one.line(0, "x", 0.24).delays_s(PLACE, 4.0, 0.0) for one in (raw, shifted)]
    height_m = float(raw.survey.height.values[0, 0, 0])
    assert np.allclose(delays[0] - delays[1], 2.0 * height_m / 299792458.0, atol=1e-15)


def test_the_depth_of_a_delay_is_that_of_the_place(session):
    draw = np.random.default_rng(1)
    for _ in range(20):
        permittivity, separation_m = draw.uniform(1.0, 30.0), draw.choice([0.0, 0.1])
        line = session.line(0, draw.choice(["x", "y"]), 0.2)
        at_m, depth_m = draw.choice(line.position_m), draw.uniform(0.0, 0.3)
        place = Place(at_m, 0.2, depth_m) if line.along == "x" else Place(0.2, at_m, depth_m)
        delays_s = line.delays_s(place, permittivity, separation_m)
        delay_s = float(np.min(delays_s[line.position_m == at_m]))
        found_m = line.depth_m(at_m, delay_s, permittivity, separation_m, 0.3)
        assert abs(found_m - depth_m) < 1e-6, (place, permittivity, separation_m)


def test_the_caption_says_where_the_permittivity_is_from_and_its_range():
    for options, permittivity, words in (
        (ImageOptions(), 5.0, "(2 to 16), ASSUMED"),
        (ImageOptions(soil=Soils.CLAY), Soils.CLAY.value.permittivity, "(5 to 40), TYPICAL"),
    ):
        session = ViewSession(small(), options)
        first = session.compute(session.first_request, at_once)
        assert first.permittivity == permittivity and words in str(first.caption)
    chosen = session.compute(ImageRequest(8.0, False), at_once)
    assert "(7.2 to 8.8), set with the slider" in str(chosen.caption)


def test_the_background_is_subtracted_only_if_that_is_asked_for(session):
    with_it, without = (session.compute(ImageRequest(4.0, one), at_once) for one in (False, True))
    shallow = with_it.depth_m < 0.02
    brightest = [one.levels_db[:, shallow].max() for one in (with_it, without)]
    assert brightest[0] == 0.0 > brightest[1] + 10.0


def test_the_separation_that_a_survey_records_is_used_unless_another_is_given():
    recorded = small().assign_attrs({"antenna_separation_m": 0.06})
    for options, used_m in ((FIXED, 0.06), (replace(FIXED, separation_m=0.1), 0.1)):
        assert ViewSession(recorded, options).options.separation_m == used_m


def test_what_cannot_be_shown_is_refused(monkeypatch):
    nowhere = small().assign_attrs({"antenna_separation_m": np.nan})
    for survey, fault, shown in (
        (nowhere, errors.INPUT, "nan"),
        (process_survey(small(), "time"), errors.STEPS, "'s21'"),
    ):
        with raises_fault(fault, shown):
            ViewSession(survey, FIXED)
    monkeypatch.setattr(work, "available_bytes", lambda: 1 << 20)
    with raises_fault(errors.TOO_LARGE):
        ViewSession(small(), FIXED)


def test_a_picture_of_uneven_places_shows_the_nearest_one():
    across = np.array([0.0, 1.0, 4.0, 6.0])
    picture = Picture.of(np.arange(4.0)[None, :].repeat(2, 0), across, np.array([0.0, 1.0]))
    even = np.linspace(0.0, 6.0, picture.levels_db.shape[1])
    nearest = np.abs(across[None, :] - even[:, None]).min(axis=1)
    assert np.allclose(np.abs(across[picture.levels_db[0].astype(int)] - even), nearest)


def test_a_scene_moves_by_steps_and_stays_inside(session, image):
    scene = Scene(session, image, PLACE, 0, "x", 4.0)
    assert abs(scene.level_db(PLACE)) < 1.0
    moved = scene.moved(1, -1, 1)
    assert np.allclose((moved.x_m, moved.y_m), (0.26, 0.22)) and moved.depth_m > PLACE.depth_m
    assert scene.inside(Place(9.0, -1.0, 2.0)) == Place(0.34, 0.14, 0.3)
    said = str(scene.read_out(PLACE))
    assert said.startswith("x 240 mm, y 240 mm, depth 83 mm, delay ") and said.endswith(" dB")
    below = scene.in_traces(240.0, scene.delay_ns(PLACE))
    assert abs(below.depth_m - PLACE.depth_m) < 1e-6
