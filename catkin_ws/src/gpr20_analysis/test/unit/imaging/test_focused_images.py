"""The focused image that the robot's window shows, also of a survey that is still measured."""

import os

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault
from ground_kit import IMAGING_SCENE, survey_of
from run_seed import draws
from survey_kit import POINTS, make_survey, planned_trace

from gpr20_analysis import faults
from gpr20_analysis.candidates.focused import FEWEST_LINES, focus
from gpr20_analysis.dataset import Quality
from gpr20_analysis.read.growing_survey import GrowingSurvey
from gpr20_analysis.read.load import load_survey
from gpr20_survey.folder.survey_folder import trace_file_name
from gpr20_survey.trace import trace_json

GRID_MM = np.linspace(90.0, 270.0, 16)


@pytest.fixture(scope="module")
def survey():
    return survey_of(IMAGING_SCENE, GRID_MM, GRID_MM)


def without(survey, rows):
    """Return a survey of which some rows were not measured."""
    missing = survey.copy(deep=True)
    missing["s21"][:, rows] = np.nan
    missing["quality"][:, rows] = int(Quality.MISSING)
    return missing


def noise_of(survey, seed):
    """Return noise alone, as much in every sample."""
    generator = np.random.default_rng(seed)
    shape = (2, *survey["s21"].shape)
    noise = 1e-5 * (
        generator.standard_normal(shape[1:]) + 1j * generator.standard_normal(shape[1:])
    )
    return survey.assign(s21=(survey["s21"].dims, noise))


def test_the_target_is_the_brightest_place(survey):
    found = focus(survey, 5.0)
    deep = found.depth_mm > 60.0
    levels_db = found.levels_db[deep]
    layer, row, column = np.unravel_index(np.nanargmax(levels_db), levels_db.shape)
    place_mm = found.x_mm[column], found.y_mm[row], found.depth_mm[deep][layer]
    np.testing.assert_allclose(place_mm, (173.3, 181.7, 113.0), atol=12.0)
    assert found.levels_db.dtype == np.float32
    assert found.traces == 2 * len(GRID_MM) ** 2
    assert found.found.simulated


def test_lines_that_were_not_measured_stay_empty(survey):
    for rows in (slice(7, None), slice(0, 9), slice(8, 9)):
        empty = np.isnan(focus(without(survey, rows), 5.0).levels_db)
        assert empty[:, rows].all(), rows
        assert not np.delete(empty, np.arange(16)[rows], axis=1).any(), rows


@pytest.mark.parametrize(
    "measured", [9, *(pytest.param(n, marks=pytest.mark.release) for n in (16, 5))]
)
def test_noise_alone_has_the_level_of_noise_also_half_way(survey, measured):
    candidates = 0
    for seed in range(draws(2)):
        found = focus(without(noise_of(survey, seed), slice(measured, None)), 5.0)
        levels_db = found.levels_db[np.isfinite(found.levels_db)]
        # It is the brighter of two polarizations; the target of this scene is 70 dB above noise.
        assert abs(np.median(levels_db) - 0.5) < 2.0
        assert levels_db.max() < 13.0
        candidates += found.found.primary
    # At most 10 per m2 are asked for, and each of these sees 0.05 m2.
    assert candidates <= 4


def test_too_few_lines_are_refused(survey):
    with raises_fault(faults.TOO_FEW_LINES, FEWEST_LINES, 2):
        focus(without(survey, slice(2, None)), 5.0)


def add_trace(folder, index, **changes):
    trace = planned_trace(index, **changes)
    path = folder / "traces" / trace_file_name(trace)
    path.write_bytes(trace_json.encode(trace))
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
