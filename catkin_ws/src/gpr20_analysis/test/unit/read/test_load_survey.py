"""A survey becomes the same Dataset from whatever holds it."""

from __future__ import annotations

import numpy as np
import pytest
from fault_kit import raises_fault
from survey_kit import POINTS, make_survey, planned_trace

from gpr20_analysis import dataset, faults
from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.survey_grid import grid_of

ALL = len(POINTS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.mark.parametrize("name", ["traces", "survey.bag", "survey.mcap"])
def test_every_recording_gives_the_same_dataset(folder, name):
    assert load_survey(folder / name).equals(load_survey(folder))


def test_every_sample_lies_at_its_place(folder):
    survey = load_survey(folder)
    for index, point in enumerate(POINTS):
        trace = planned_trace(index)
        own = survey.sel(polarization=point.z_deg).sel(
            x=point.x_mm / 1000, y=point.y_mm / 1000, method="nearest"
        )
        assert int(own["index"]) == index
        np.testing.assert_array_equal(own.s21.values, trace.s21_real + 1j * trace.s21_imag)
        assert float(own.height) == trace.antennae_height_m
        assert own.timestamp.values == np.datetime64(trace.timestamp_us, "us")


def test_the_dataset_says_units_and_origin(folder):
    survey = load_survey(folder)
    assert survey.s21.dims == ("polarization", "y", "x", "frequency")
    assert survey.s21.dtype == np.complex128
    units = {name: survey[name].attrs["units"] for name in ("x", "y", "frequency", "height")}
    assert units == {"x": "m", "y": "m", "frequency": "Hz", "height": "m"}
    assert survey.attrs["planned"] == survey.attrs["stored"] == ALL
    assert (survey.attrs["missing"], survey.attrs["faults"]) == ([], [])


def test_missing_samples_are_nan_marked_and_listed(tmp_path):
    folder = make_survey(tmp_path, ALL - 4, "stopped")
    for name in (".", "survey.bag", "survey.mcap"):
        survey = load_survey(folder / name)
        missing = (survey.quality & int(Quality.MISSING)) != 0
        assert int(missing.sum()) == len(survey.attrs["missing"]) == 4, name
        assert np.isnan(survey.s21.values[missing.values]).all(), name
        assert np.isfinite(survey.s21.values[~missing.values]).all(), name
        assert survey.attrs["missing"][0].startswith("missing: x "), name


def test_a_row_that_is_missing_between_others_is_put_in():
    rows_mm = [0.0, 10.0, 30.0, 40.0]
    positions = np.array([(0.0, y_mm, x_mm) for y_mm in rows_mm for x_mm in (5.0, 6.0)])
    notes = []
    grid = grid_of(positions, notes)
    assert grid.y_mm == (0.0, 10.0, 20.0, 30.0, 40.0)
    assert grid.x_mm == (5.0, 6.0)
    assert "were inserted" in str(notes[0])


def test_a_recording_cut_off_by_a_crash_is_read_up_to_the_cut(tmp_path):
    folder = make_survey(tmp_path, 7, None)
    for name in ("survey.bag", "survey.mcap"):
        survey = load_survey(folder / name)
        assert survey.attrs["stored"] == 7
        assert any("cut off" in note for note in survey.attrs["notes"])


def test_missing_heights_and_remarks_of_the_robot_are_marked(tmp_path):
    special = {3: {"antennae_height_m": float("nan")}, 5: {"quality": ("VNA was slow", "again")}}
    survey = load_survey(make_survey(tmp_path, ALL, "finished", special))

    def marked(flag):
        return (survey.quality.values & int(flag)) != 0

    assert survey["index"].values[marked(Quality.NO_HEIGHT)].tolist() == [3]
    assert survey["index"].values[marked(Quality.REMARKED)].tolist() == [5]
    assert survey.remarks.values[marked(Quality.REMARKED)].tolist() == ["VNA was slow; again"]


def test_a_dataset_comes_back_from_its_file_unchanged(folder, tmp_path):
    for survey in (load_survey(folder), load_survey(make_survey(tmp_path, ALL - 5, "stopped"))):
        for ending in ("nc", "zarr"):
            path = tmp_path / f"survey{survey.attrs['stored']}.{ending}"
            write_dataset(survey, path)
            assert load_survey(path).identical(survey), path


def test_what_is_no_survey_is_refused_by_name(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "text.txt").write_text("no survey")
    for name in ("nothing", "empty", "text.txt"):
        with raises_fault(faults.NO_INPUT, name):
            load_survey(tmp_path / name)


def test_the_list_of_missing_samples_follows_the_flags(folder):
    survey = load_survey(folder)
    survey[dataset.QUALITY][0, 1, 2] = int(Quality.DAMAGED)
    (missing,) = dataset.missing_samples(survey)
    assert str(missing) == "damaged: x 20 mm, y 15 mm, 0 deg"
