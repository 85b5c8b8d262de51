"""The delays of analysis and simulator agree, which find them by different methods.

The analysis solves Snell's law for the angle, the simulator looks for the quickest way.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.constants import speed_of_light

from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.refraction import refracted_path
from gpr20_simulator.mid.world.scene import Antennas, Scene, Shape, Soil, Target
from gpr20_survey.radar.refraction import one_way_delay_s

HEIGHTS_M = st.floats(0.02, 0.6)
DEPTHS_M = st.floats(0.005, 1.0)
PERMITTIVITIES = st.floats(1.0, 81.0)
PLACES_MM = st.floats(0.0, 800.0)


@given(HEIGHTS_M, DEPTHS_M, st.lists(st.floats(0.0, 2.0), min_size=1, max_size=20), PERMITTIVITIES)
def test_both_find_the_same_way_through_the_surface(height_m, depth_m, distances_m, permittivity):
    distance_m = np.array(distances_m)
    path = refracted_path(height_m, np.full_like(distance_m, depth_m), distance_m, permittivity)
    simulated_s = (path.air_m + math.sqrt(permittivity) * path.soil_m) / speed_of_light
    analysed_s = one_way_delay_s(height_m, depth_m, distance_m, permittivity)
    # 1e-9 of 2 m in soil of permittivity 81 is 2 mrad at 6 GHz.
    np.testing.assert_allclose(analysed_s, simulated_s, rtol=1e-9)


@given(
    places_mm=st.tuples(PLACES_MM, PLACES_MM, PLACES_MM, PLACES_MM),
    rotation_deg=st.floats(-90.0, 90.0),
    height_m=HEIGHTS_M,
    depth_m=DEPTHS_M,
    radius_m=st.floats(0.0005, 0.05),
    permittivity=PERMITTIVITIES,
    separation_m=st.sampled_from([0.0, 0.06, 0.2]),
)
def test_a_sphere_of_a_random_scene_is_where_the_analysis_expects_its_echo(
    places_mm, rotation_deg, height_m, depth_m, radius_m, permittivity, separation_m
):
    x_mm, y_mm, target_x_mm, target_y_mm = places_mm
    size_m = 2.0 * radius_m
    sphere = Target("one", Shape.SPHERE, target_x_mm, target_y_mm, depth_m, size_m, 0.0, 0.1, 0.1)
    scene = Scene(
        soil=Soil(permittivity, 0.0),
        antennas=Antennas(height_m=height_m, separation_m=separation_m),
        targets=(sphere,),
    )
    here = AntennaPosition(x_mm, y_mm, rotation_deg)
    simulated_s = Ground(scene).echoes(here).delay_s[2]
    turn, index = math.radians(rotation_deg), math.sqrt(permittivity)
    expected_s = -2.0 * radius_m * index / speed_of_light
    for side in (0.5, -0.5):
        away_m = math.hypot(
            x_mm / 1e3 + side * separation_m * math.cos(turn) - target_x_mm / 1e3,
            y_mm / 1e3 + side * separation_m * math.sin(turn) - target_y_mm / 1e3,
        )
        expected_s += one_way_delay_s(height_m, depth_m + radius_m, away_m, permittivity)
    assert simulated_s == pytest.approx(float(expected_s), rel=1e-6)
