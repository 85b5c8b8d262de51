import math

import numpy as np
import pytest
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st

from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S, delay_of_depth
from gpr20_survey.radar.hyperbola import Hyperbola
from gpr20_survey.radar.refraction import one_way_delay_s

HEIGHTS_M = st.floats(0.02, 0.5)
DEPTHS_M = st.floats(0.02, 0.4)
PERMITTIVITIES = st.floats(1.5, 40.0)


@settings(max_examples=60)
@given(st.floats(0.0, 0.5), DEPTHS_M, HEIGHTS_M, PERMITTIVITIES)
def test_the_wave_takes_the_fastest_path(offset_m, depth_m, height_m, permittivity):
    crossings_m = np.linspace(0.0, offset_m, 4001)
    index = math.sqrt(permittivity)
    paths_m = np.hypot(height_m, crossings_m) + index * np.hypot(depth_m, offset_m - crossings_m)
    fastest_s = paths_m.min() / SPEED_OF_LIGHT_M_S
    found_s = one_way_delay_s(height_m, depth_m, offset_m, permittivity)
    assert found_s == pytest.approx(fastest_s, rel=1e-6)


@settings(max_examples=60)
@given(DEPTHS_M, HEIGHTS_M, PERMITTIVITIES, st.floats(40.0, 400.0), st.sampled_from([-1, 1]))
def test_a_point_of_the_flank_gives_the_permittivity(depth_m, height_m, truth, offset_mm, side):
    apex_s = float(delay_of_depth(depth_m, height_m, truth))
    target = Hyperbola(300.0, apex_s, height_m, truth)
    assert target.depth_m == pytest.approx(depth_m, rel=1e-6)
    place_mm = 300.0 + side * offset_mm
    delay_s = float(target.delays_s(np.array([place_mm]))[0])
    start = Hyperbola(300.0, apex_s, height_m, 4.0)
    assert start.through(place_mm, delay_s).permittivity == pytest.approx(truth, rel=1e-2)


def test_the_apex_is_the_earliest_point_and_both_sides_are_equal():
    hyperbola = Hyperbola(100.0, 2e-9, 0.1, 6.0)
    delays_s = hyperbola.delays_s(np.array([0.0, 50.0, 100.0, 150.0, 200.0]))
    assert delays_s == pytest.approx(delays_s[::-1])
    assert delays_s[2] == pytest.approx(2e-9)
    assert (np.diff(delays_s[2:]) > 0.0).all()


@each_case("delay_s", [0.0, 1.0])
def test_a_point_that_no_ground_explains_ends_at_the_limits(delay_s):
    fitted = Hyperbola(100.0, 2e-9, 0.1, 6.0).through(200.0, delay_s)
    assert fitted.permittivity == pytest.approx(1.0 if delay_s == 0.0 else 81.0, rel=1e-6)


def test_a_height_of_0_stays_drawable():
    assert np.isfinite(Hyperbola(0.0, 2e-9, 0.0, 9.0).delays_s(np.linspace(0.0, 500.0, 9))).all()


def test_an_apex_above_the_surface_stays_drawable():
    above = Hyperbola(100.0, 0.1e-9, 0.1, 6.0)
    assert above.depth_m > 0.0
    assert np.isfinite(above.delays_s(np.linspace(0.0, 200.0, 9))).all()
