"""Which lines and stops of a survey are shown, and how grey they are."""

import json

import numpy as np
import pytest

from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import Trace
from gpr20_visualization.mid.survey_picture import (
    DELAY_STEP_S,
    MAX_ROWS,
    LineImage,
    SurveyPicture,
    area_of,
    grey,
    side_by_side,
    transform_of,
)

FREQUENCIES_HZ = np.linspace(0.6e9, 6.0e9, 101)
START_US = 1_700_000_000_000_000
SURVEYS = [f"{number:08x}-0000-4000-8000-000000000000" for number in range(3)]
DESCRIPTION = {
    "parameters": {
        "x_start_mm": 10.0,
        "x_stop_mm": 30.0,
        "x_points": 3,
        "y_start_mm": 40.0,
        "y_stop_mm": 20.0,
        "y_points": 3,
        "polarizations_deg": [0.0, 90.0],
    }
}


def trace(index, x_mm, y_mm, z_deg=0.0, echoes=((4e-9, 1.0),), survey=SURVEYS[0]):
    s21 = sum(level * np.exp(-2j * np.pi * FREQUENCIES_HZ * delay) for delay, level in echoes)
    time_us = START_US + index * 1_000_000
    return Trace(
        survey_id=survey,
        sample_id=f"{survey}:{index}",
        index=index,
        timestamp_us=time_us,
        x_coord_mm=x_mm,
        y_coord_mm=y_mm,
        z_coord_deg=z_deg,
        antennae_height_m=0.2,
        frequency_hz=FREQUENCIES_HZ,
        s21_real=s21.real,
        s21_imag=s21.imag,
        sweep_started_us=time_us - 200_000,
        sweep_ended_us=time_us - 100_000,
        quality=(),
        analyzer=AnalyzerSettings(),
    )


def line(y_mm, first=0, survey=SURVEYS[0]):
    return [
        trace(first + 2 * number + place, x_mm, y_mm, z_deg, survey=survey)
        for number, x_mm in enumerate((10.0, 20.0, 30.0))
        for place, z_deg in enumerate((0.0, 90.0))
    ]


def test_an_echo_is_at_its_delay_and_delays_repeat_at_few_frequencies():
    line = LineImage()
    line.add(trace(0, 0.0, 0.0))
    rows = line.picture()[:, 0]
    assert len(rows) == MAX_ROWS
    assert np.argmax(rows) * DELAY_STEP_S == pytest.approx(4e-9)
    # 1 GHz apart: everything repeats after 1 ns.
    assert transform_of(np.linspace(1e9, 5e9, 5)).samples == 20


def test_grey_is_in_db_below_the_strongest_echo_before_the_common_part_is_removed():
    echoes = np.zeros((5, 4), complex)
    echoes[:, 0] = 1.0  # the same everywhere
    echoes[1, 2] = 0.125  # a fifth of it is part of the mean
    picture = grey(echoes)
    assert picture.shape == (4, 5)
    assert np.all(picture[0] == 0)
    level_db = 20.0 * np.log10(0.1)
    assert picture[2, 1] == round(255 * (1 + level_db / 60.0))


def test_what_was_not_measured_is_black():
    echoes = np.ones((3, 2), complex)
    echoes[0] *= 0.5
    echoes[1] = np.nan
    picture = grey(echoes)
    assert np.all(picture[:, 1] == 0)
    assert np.all(picture[:, 0] > 0)
    assert not grey(np.full((3, 2), np.nan, complex)).any()


def test_rotations_are_beside_each_other():
    whole = side_by_side([np.full((2, 3), 10, np.uint8), np.full((2, 3), 20, np.uint8)])
    assert whole.tolist() == [[10, 10, 10, 255, 20, 20, 20]] * 2


def test_a_line_is_shown_once_when_all_its_samples_are_there():
    survey = SurveyPicture()
    survey.set_area(area_of(json.dumps(DESCRIPTION)))
    first, *others = line(20.0)
    shown = [survey.add(one) for one in (first, first, *others)]  # one is measured again
    assert [one is not None for one in shown] == [False] * 6 + [True]
    assert survey.ended_us == START_US + 5_000_000
    # Not again with the first trace of the next line.
    assert survey.add(trace(6, 30.0, 30.0)) is None
    assert survey.stops_m == [(0.01, 0.02), (0.02, 0.02), (0.03, 0.02), (0.03, 0.03)]
    # Another survey begins without the stops of the former.
    assert survey.add(trace(0, 10.0, 70.0, survey=SURVEYS[1])) is None
    assert survey.stops_m == [(0.01, 0.07)]


def test_without_a_plan_a_line_is_shown_with_the_next_one():
    survey = SurveyPicture()
    assert [survey.add(one) for one in line(20.0)] == [None] * 6
    assert survey.add(trace(6, 30.0, 30.0)) is not None


def test_the_area_is_that_of_the_plan():
    area = area_of(json.dumps(DESCRIPTION))
    assert area.outline()[0] == area.outline()[-1] == (0.01, 0.04)
    assert area.outline()[2] == (0.03, 0.02)
    assert area.line_samples == 6


def test_a_damaged_description_has_no_area():
    endless = json.dumps(DESCRIPTION).replace('"x_points": 3', '"x_points": 1e999')
    for text in ("", "3", "[" * 100_000, '{"parameters": {"x_points": 3}}', endless):
        assert area_of(text) is None
