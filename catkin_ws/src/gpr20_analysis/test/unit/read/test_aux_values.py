"""Values of other sensors: in the Dataset, in every file of it, and in the report."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from survey_kit import POINTS, STARTED_US, make_survey

import gpr20_analysis
from gpr20_analysis import dataset
from gpr20_analysis.formats.plain_csv import write_plain_csv
from gpr20_analysis.report.sections import _sensors
from gpr20_analysis.sentences import ENGLISH
from gpr20_survey.trace.aux_value import AuxValue

# The last traces have no value, and those before them one of another unit.
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
def survey(tmp_path_factory):
    aux = {index: {"aux": aux_of(index)} for index in range(len(POINTS))}
    folder = tmp_path_factory.mktemp("aux")
    return gpr20_analysis.load_survey(make_survey(folder, len(POINTS), "finished", misplaced=aux))


def test_each_value_is_at_its_sample_and_nan_where_there_is_none(survey):
    assert dataset.aux_names(survey) == ["aux_period", "aux_soil", "aux_soil_2"]
    for name, first, last in (("aux_soil", 0, CELSIUS), ("aux_soil_2", CELSIUS, KELVIN)):
        index, values = survey["index"].values.ravel(), survey[name].values.ravel()
        held = (index >= first) & (index < last)
        assert np.array_equal(values[held], 0.5 * index[held])
        assert np.isnan(values[~held]).all()
    assert survey.aux_soil.attrs == {"long_name": "sensor soil", "units": "\N{DEGREE SIGN}C"}
    assert "the sensor soil was recorded with different units" in str(survey.attrs["notes"])


@pytest.mark.parametrize("ending", ["nc", "zarr"])
def test_netcdf_and_zarr_hold_numbers_with_their_units(survey, tmp_path, ending):
    pytest.importorskip("zarr")
    path = tmp_path / f"survey.{ending}"
    gpr20_analysis.write_dataset(survey, path)
    again = gpr20_analysis.load_survey(path)
    for name in dataset.aux_names(survey):
        # Not a time, whatever the unit is.
        assert again[name].dtype == np.float64
        assert again[name].attrs == survey[name].attrs
        np.testing.assert_array_equal(again[name].values, survey[name].values)


def test_csv_has_a_column_for_each(survey, tmp_path):
    write_plain_csv(survey, tmp_path / "survey.csv")
    with (tmp_path / "survey.csv").open(encoding="utf-8", newline="") as stream:
        rows = {int(row["index"]): row for row in csv.DictReader(stream)}
    assert rows[3]["aux_soil [\N{DEGREE SIGN}C]"] == "1.5"
    assert rows[CELSIUS]["aux_soil_2 [K]"] == "6.0"
    assert rows[KELVIN]["aux_period [s]"] == "nan"


def test_the_report_has_a_line_for_each_and_nothing_without_sensors(survey):
    section = _sensors(survey, ENGLISH)
    assert section.rows[1] == ("soil", "\N{DEGREE SIGN}C", "12/18", "0", "2.75", "5.5")
    assert _sensors(survey.drop_vars(dataset.aux_names(survey)), ENGLISH).empty
