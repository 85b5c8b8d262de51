"""A survey becomes the same Dataset from whatever holds it."""

import csv
import json
import shutil
from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest
from fault_kit import raises_fault
from storage_kit import with_bag
from survey_kit import POINTS, STARTED_US, make_survey, planned_trace

from gpr20_analysis import dataset, errors
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.dataset_files import write_dataset, write_plain_csv
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.traces import grid_of
from gpr20_analysis.report.summary import summarize
from gpr20_analysis.work import available_bytes
from gpr20_common.faults import NOT_ALLOWED
from gpr20_survey.axes import ZeroEpoch
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import AuxValue

ALL = len(POINTS)
SETTINGS = {"if_bandwidth_hz": 1000.0, "averages": 4, "output_power": "HIGH"}
# The last traces have no value of a sensor, and those before them one of another unit.
CELSIUS, KELVIN = 12, 14


def aux_of(index):
    if index >= KELVIN:
        return ()
    unit = "\N{DEGREE SIGN}C" if index < CELSIUS else "K"
    return (
        AuxValue("soil", 0.5 * index, unit, STARTED_US),
        AuxValue("period", 2.0, "seconds", STARTED_US),
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    aux = {index: {"aux": aux_of(index)} for index in range(ALL)}
    place = tmp_path_factory.mktemp("whole")
    return with_bag(make_survey(place, ALL, "finished", misplaced=aux))


def settings_in(attributes):
    return {name: attributes[name] for name in SETTINGS if name in attributes}


def test_every_source_gives_the_same_dataset(folder):
    for name in (".", "traces", "survey.bag", "survey.mcap"):
        found = load_survey(folder / name)
        assert found.equals(load_survey(folder)), name
        assert settings_in(found.attrs) == SETTINGS, name


def test_every_sample_lies_at_its_place_in_si_units(folder):
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
    assert survey.s21.dims == ("polarization", "y", "x", "frequency")
    assert survey.s21.dtype == np.complex128
    units = {name: survey[name].attrs["units"] for name in ("x", "y", "frequency", "height")}
    assert units == {"x": "m", "y": "m", "frequency": "Hz", "height": "m"}
    assert survey.attrs["planned"] == survey.attrs["stored"] == ALL
    assert (survey.attrs["missing"], survey.attrs["faults"]) == ([], [])


def test_missing_samples_are_nan_marked_and_listed(tmp_path):
    folder = with_bag(make_survey(tmp_path, ALL - 4, "stopped"))
    for name in (".", "survey.bag", "survey.mcap"):
        survey = load_survey(folder / name)
        missing = (survey.quality & int(Quality.MISSING)) != 0
        assert int(missing.sum()) == len(survey.attrs["missing"]) == 4, name
        assert np.isnan(survey.s21.values[missing.values]).all(), name
        assert np.isfinite(survey.s21.values[~missing.values]).all(), name
    cut_off = make_survey(tmp_path / "crash", 7, None)
    found = load_survey(cut_off / "survey.mcap").attrs
    assert found["stored"] == 7 and any("cut off" in note for note in found["notes"])
    survey[dataset.QUALITY][:] = 0
    survey[dataset.QUALITY][0, 1, 2] = int(Quality.DAMAGED)
    (missing,) = dataset.missing_samples(survey)
    assert str(missing) == "damaged: x 20 mm, y 15 mm, 0 deg"


def test_a_row_that_only_the_indices_miss_is_named(folder, tmp_path):
    traces = Path(shutil.copytree(str(folder / "traces"), str(tmp_path / "traces")))
    for path in sorted(traces.iterdir())[:6]:
        path.unlink()
    (missing,) = load_survey(traces).attrs["missing"]
    assert missing.startswith("missing: 6 samples at unknown positions")


def test_a_row_that_is_missing_between_others_is_put_in():
    rows_mm = [0.0, 10.0, 30.0, 40.0]
    positions = np.array([(0.0, y_mm, x_mm) for y_mm in rows_mm for x_mm in (5.0, 6.0)])
    notes = []
    grid = grid_of(positions, notes)
    assert (grid.y_mm, grid.x_mm) == ((0.0, 10.0, 20.0, 30.0, 40.0), (5.0, 6.0))
    assert len(notes) == 1


def test_missing_heights_and_remarks_of_the_robot_are_marked(tmp_path):
    special = {3: {"antennae_height_m": float("nan")}, 5: {"quality": ("VNA was slow", "again")}}
    survey = load_survey(make_survey(tmp_path, ALL, "finished", special))

    def marked(flag):
        return (survey.quality.values & int(flag)) != 0

    assert survey["index"].values[marked(Quality.NO_HEIGHT)].tolist() == [3]
    assert survey["index"].values[marked(Quality.REMARKED)].tolist() == [5]
    assert survey.remarks.values[marked(Quality.REMARKED)].tolist() == ["VNA was slow; again"]


def test_a_dataset_comes_back_from_its_file_unchanged(folder, tmp_path):
    with_holes = load_survey(make_survey(tmp_path, ALL - 5, "stopped"))
    for number, survey in enumerate((load_survey(folder), with_holes)):
        write_dataset(survey, tmp_path / f"{number}.nc")
        assert load_survey(tmp_path / f"{number}.nc").identical(survey), number


def test_an_image_that_cannot_be_is_refused_before_it_is_computed(folder, refusals, monkeypatch):
    assert main(["image", str(folder), "--permittivity", "4"]) == 3
    assert refusals == [NOT_ALLOWED.code]
    assert available_bytes() > 1 << 20
    monkeypatch.setattr("resource.getrlimit", lambda kind: (4096, 4096))
    assert available_bytes() == 4096
    monkeypatch.setattr("gpr20_analysis.work.available_bytes", lambda: 1000)
    with raises_fault(errors.TOO_LARGE):
        load_survey(folder)


def test_what_is_no_survey_is_refused_by_name(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "text.txt").write_text("no survey")
    for name in ("nothing", "empty", "text.txt"):
        with raises_fault(errors.INPUT, name):
            load_survey(tmp_path / name)


def test_a_folder_that_lost_its_traces_names_the_recording_that_has_them(folder, tmp_path):
    for name, lost in (("gone", shutil.rmtree), ("empty", lambda one: [*map(Path.unlink, one)])):
        copied = Path(shutil.copytree(str(folder), str(tmp_path / name)))
        lost(copied / "traces" if name == "gone" else (copied / "traces").iterdir())
        with raises_fault(errors.INPUT, copied / "survey.mcap"):
            load_survey(copied)
    assert load_survey(copied / "survey.mcap").equals(load_survey(folder))


def test_a_sensors_value_is_at_its_sample_in_table_and_report(folder, tmp_path):
    survey = load_survey(folder)
    assert dataset.aux_names(survey) == ["aux_period", "aux_soil", "aux_soil_2"]
    for name, first, last in (("aux_soil", 0, CELSIUS), ("aux_soil_2", CELSIUS, KELVIN)):
        index, values = survey["index"].values.ravel(), survey[name].values.ravel()
        held = (index >= first) & (index < last)
        assert np.array_equal(values[held], 0.5 * index[held])
        assert np.isnan(values[~held]).all()
    assert survey.aux_soil.attrs == {"long_name": "sensor soil", "units": "\N{DEGREE SIGN}C"}
    assert "soil" in str(survey.attrs["notes"])
    write_plain_csv(survey, tmp_path / "survey.csv")
    with (tmp_path / "survey.csv").open(encoding="utf-8", newline="") as stream:
        rows = {int(row["index"]): row for row in csv.DictReader(stream)}
    assert rows[CELSIUS]["aux_soil_2 [K]"] == "6.0"
    assert rows[KELVIN]["aux_period [seconds]"] == "nan"
    assert summarize(survey)["sensor soil"] == "0 to 5.5 °C, mean 2.75 °C (samples: 12)"


def test_the_settings_of_the_analyzer_are_in_the_summary(folder, capsys):
    assert main(["info", str(folder), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown["IF bandwidth"], shown["averages"]) == ("1000 Hz", "4")


def test_settings_and_zeros_that_differ_are_at_their_samples_also_in_a_file(tmp_path):
    unknown = {index: {"analyzer": AnalyzerSettings()} for index in range(7)}
    zeros = tuple(ZeroEpoch(3 + axis, STARTED_US + axis) for axis in range(3))
    low = {"analyzer": AnalyzerSettings(20.0, 1, "LOW"), "zeros": zeros}
    for number, (changes, shared, noted) in enumerate(
        ((unknown, SETTINGS, 0), ({5: low, 7: low}, {}, 1))
    ):
        survey = load_survey(make_survey(tmp_path / str(number), 9, "stopped", changes))
        assert settings_in(survey.attrs) == shared, number
        doubts = survey.attrs["doubts"]
        assert len(doubts) == noted, number
        for index in range(9):
            own = survey.where(survey["index"] == index, drop=True).squeeze()
            settings = changes.get(index, {"analyzer": AnalyzerSettings(**SETTINGS)})["analyzer"]
            bandwidth_hz = float(own.if_bandwidth_hz)
            assert (0.0 if np.isnan(bandwidth_hz) else bandwidth_hz) == settings.if_bandwidth_hz
            assert (int(own.averages), str(own.output_power.values)) == astuple(settings)[1:]
    assert "7 with IF bandwidth 1000 Hz, averages 4, output power HIGH, 2 with others" in doubts[0]
    held = np.isin(survey["index"].values, (5, 7))
    assert survey.zero_epochs.dims == (*dataset.SAMPLE_DIMS, "axis") and "axis" in survey.coords
    assert survey.zero_epochs.values[held].tolist() == [[3, 4, 5]] * 2
    times_us = survey.zero_times.values[held].astype("datetime64[us]").astype(np.int64)
    assert times_us.tolist() == [[one.time_us for one in zeros]] * 2
    assert (survey.zero_epochs.values[~held] == 0).all()
    assert np.isnat(survey.zero_times.values[~held]).all()
    write_dataset(survey, tmp_path / "survey.nc")
    assert load_survey(tmp_path / "survey.nc").equals(survey)
